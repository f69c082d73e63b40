//! The account is never below nothing, what comes out is what was put in, and the gate opens as far as the closed form says.

use cohold_core::law::{Law, Observation, Packet};
use cohold_core::num::Motion;
use cohold_core::object::Port;
use cohold_laws::passivity_observer::PassivityObserver;

use super::draws;
use crate::two_copies::{Copies, PERIOD, settings};

const MASS_KG: f64 = 0.3;

/// Packets that no copy makes, hands that throw and hold: W ≥ 0 in every tick, and the copy never gets more than E₀ and what it gave.
#[test]
fn each_end_is_passive_by_itself() {
    for (seed, start) in (0..40_u64).zip([0.0, 0.001, 0.02, 0.1].into_iter().cycle()) {
        let mut random = draws(seed);
        let settings = settings(
            "passivity-observer",
            &[("coordination.stiffness_n_per_m", 10.0_f64.powf(3.0 + 2.0 * random())), ("coordination.tank_j", start)],
        );
        let law = <PassivityObserver<f64> as Law<f64>>::build(&settings).expect("good settings");
        let mut end = law.start(Motion::REST);
        let (mut copy, mut given, mut least) = (Motion::<f64>::REST, 0.0, start);
        for _ in 0..5000 {
            if random() > 0.2 {
                let motion = Motion { position: 0.1 * random(), velocity: 3.0 * random() };
                law.receive(&mut end, Packet { motion, ..Packet::default() });
            }
            let hand = Port { force: 5.0 * random(), impedance: 1.0 };
            let mut mean = 0.0;
            let seen = Observation { local: copy, ..Observation::default() };
            let coupled = law.couple(&mut end, &seen, |port: Port<f64>| {
                let (inertia, all) = (2.0 * MASS_KG / PERIOD, port + hand);
                mean = (inertia * copy.velocity + all.force) / (inertia + all.impedance);
                mean
            });
            copy = Motion { position: copy.position + PERIOD * mean, velocity: 2.0 * mean - copy.velocity };
            given += PERIOD * coupled.force * mean;
            least = least.min(end.account_j());
            assert!(end.account_j() >= 0.0 && given <= start + 1e-12, "seed {seed}: {given} J of {start} J given");
        }
        assert!(least < start || start == 0.0, "seed {seed}: the gate was never asked");
    }
}

/// A copy that is held still and a packet 10 cm off: F_T = √(4κ·E₀/T_c), and all of K_T·Δ when E₀ covers it.
#[test]
fn the_gate_opens_as_far_as_the_account_covers() {
    for (start, wanted) in [(0.0, 0.0), (1e-4, (4.0 * 2.5 * 1e-4 / PERIOD).sqrt()), (1.0, 100.0), (1e9, 100.0)] {
        let settings = settings(
            "passivity-observer",
            &[
                ("coordination.stiffness_n_per_m", 1000.0),
                ("coordination.damping_n_s_per_m", 2.0),
                ("coordination.tank_j", start),
            ],
        );
        let law = <PassivityObserver<f64> as Law<f64>>::build(&settings).expect("good settings");
        let mut end = law.start(Motion::REST);
        law.receive(&mut end, Packet { motion: Motion::at(0.1), ..Packet::default() });
        let coupled = law.couple(&mut end, &Observation::default(), |_| 0.0);
        assert!((coupled.force - wanted).abs() < 1e-12 * wanted.max(1.0), "{start} J: {} N, {wanted} N", coupled.force);
    }
}

/// With more than enough in the account it is the power-domain law, to the bit.
#[test]
fn with_plenty_it_is_the_power_domain_law() {
    let run = |law: &'static str, own: &[(&str, f64)]| {
        let settings =
            settings(law, &[&[("timing.ticks_per_packet", 8.0), ("contact.stiffness_n_per_m", 500.0)], own].concat());
        let mut copies = Copies::<f32>::new(&settings, 1);
        (0..2000)
            .map(|tick| {
                let hand = crate::two_copies::swing(12.0, f64::from(tick) * PERIOD);
                copies.tick([hand, Motion::REST]).map(|seen| seen.coordination_force.to_bits())
            })
            .collect::<Vec<_>>()
    };
    assert!(run("passivity-observer", &[("coordination.tank_j", 1e9)]) == run("power", &[]));
}

#[test]
fn what_it_needs_is_said() {
    let mut settings = settings("passivity-observer", &[]);
    settings.object.integrator = cohold_core::object::IntegratorName::Exact;
    let said = settings.check_with::<crate::AnyLaw<f64>>().expect_err("another order").to_string();
    let wanted = "object.integrator = \"exact\" is not allowed: it must be \"midpoint\" or \"backward-euler\" where coordination.comm is a law that pays for its energy";
    assert_eq!(said, wanted);
}
