//! The midpoint peer (THEORY §7), and backward Euler beside it: what a tick does to the energy of copy and springs, term by term, and
//! what it refuses.

use cohold_core::law::Packet;
use cohold_core::law::wave::Decode;
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::peer::Observed;
use cohold_core::settings::Settings;

use super::Bench;

/// A packet each tick, so that u_in is known.
fn settings(stiffness: f64, damping: f64, impedance: f64, mass: f64, object_damping: f64) -> Settings {
    let mut settings = Settings::default();
    settings.timing.ticks_per_packet = 1;
    settings.object.integrator = IntegratorName::Midpoint;
    settings.object.force_delay_ticks = 0.0;
    settings.object.mass_kg = mass;
    settings.object.damping_n_s_per_m = object_damping;
    settings.coordination.comm = "passive-mean";
    settings.coordination.decode = Decode::Implicit;
    settings.coordination.stiffness_n_per_m = stiffness;
    settings.coordination.damping_n_s_per_m = damping;
    settings.coordination.wave_impedance_n_s_per_m = impedance;
    settings
}

/// Waves and a hand that are anything but smooth, and a tick's worth of each.
fn inputs(tick: u32) -> (f64, Motion<f64>) {
    let t = f64::from(tick);
    let wave = 0.8 * (0.9 * t).sin() + 0.5 * (2.3 * t).cos();
    (wave, Motion { position: 0.01 * (0.31 * t).sin(), velocity: 0.3 * (0.7 * t).cos() })
}

/// Largest difference between the change of ½·m_O·ẋ_o² + ½·K_T·s² in a tick and T_c·(½u_in² − ½u_out² + F_LC·v − B_T·(w − v)² −
/// b_O·v²), less (θ − ½)·(m_O·(Δẋ_o)² + K_T·(Δs)²) where forces are taken after θ of a tick, over the largest of its terms; each computed from what is observed, none from the peer's own account but the two
/// wave powers.
fn open_energy(settings: &Settings) -> f64 {
    let part = if settings.object.integrator == IntegratorName::BackwardEuler { 1.0 } else { 0.5 };
    let (object, coordination) = (&settings.object, &settings.coordination);
    let period = settings.timing.control_period_s;
    let mut bench = Bench::<f64>::armed(settings);
    let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
    // Of the tick before: what was seen, and what the line took and gave.
    let mut before: Option<(Observed<f64>, [f64; 2])> = None;
    let mut booked = [0.0; 2];
    for tick in 0..2000 {
        let (wave, hand) = inputs(tick);
        bench.peer.hear(&[Packet { wave, ..Packet::default() }]);
        bench.peer.exchange();
        bench.at(hand.position, hand.velocity);
        let seen = *bench.peer.observed()[0];
        let ledger = bench.peer.ledger()[0];
        let sums = [ledger.received_j(), ledger.sent_j()];
        if let Some((Observed { object: copy, desired, contact_force: contact, .. }, [received, sent])) = before {
            let kinetic = |motion: Motion<f64>| 0.5 * object.mass_kg * motion.velocity * motion.velocity;
            let stored = |copy: Motion<f64>, desired: f64| {
                0.5 * coordination.stiffness_n_per_m * (desired - copy.position).powi(2)
            };
            let mean = copy.velocity + part * (seen.object.velocity - copy.velocity);
            let stretched = seen.desired.position - seen.object.position - (desired.position - copy.position);
            let rub = coordination.damping_n_s_per_m * (desired.velocity - mean).powi(2);
            let terms = [
                kinetic(seen.object) - kinetic(copy),
                stored(seen.object, seen.desired.position) - stored(copy, desired.position),
                -received,
                sent,
                -period * contact * mean,
                period * rub,
                period * object.damping_n_s_per_m * mean * mean,
                (part - 0.5) * object.mass_kg * (seen.object.velocity - copy.velocity).powi(2),
                (part - 0.5) * coordination.stiffness_n_per_m * stretched.powi(2),
            ];
            largest = terms.iter().fold(largest, |largest, term| largest.max(term.abs()));
            worst = worst.max(terms.iter().sum::<f64>().abs());
        }
        before = Some((seen, [sums[0] - booked[0], sums[1] - booked[1]]));
        booked = sums;
    }
    worst / largest
}

#[test]
fn the_energy_of_a_tick_closes_to_rounding() {
    for stiffness in [10.0, 4000.0, 1e6] {
        for (damping, impedance, mass, object_damping) in
            [(0.0, 1.0, 0.3, 0.0), (2.0, 10.0, 0.02, 0.5), (20.0, 200.0, 10.0, 3.0), (0.0, 70.0, 0.001, 0.0)]
        {
            for integrator in [IntegratorName::Midpoint, IntegratorName::BackwardEuler] {
                let mut settings = settings(stiffness, damping, impedance, mass, object_damping);
                settings.object.integrator = integrator;
                let open = open_energy(&settings);
                assert!(
                    open < 1e-11,
                    "{integrator:?}, K_T {stiffness}, B_T {damping}, b {impedance}, m_O {mass}: {open:.1e} of a term"
                );
            }
        }
    }
}

/// One side: the port is solved with, and left out where it would pull. Never a pull, and the push is the spring's.
#[test]
fn what_can_only_push_never_pulls() {
    let mut settings = settings(4000.0, 2.0, 10.0, 0.3, 0.0);
    settings.contact.one_sided = true;
    let mut bench = Bench::<f64>::armed(&settings);
    let (mut pushed, mut ticks_free) = (0, 0);
    for tick in 0..5000 {
        let (wave, hand) = inputs(tick);
        // The line draws the copy to the hand.
        bench.peer.hear(&[Packet { wave: wave - 0.6, ..Packet::default() }]);
        bench.peer.exchange();
        bench.at(hand.position, hand.velocity);
        let seen = bench.peer.observed()[0];
        assert!(seen.contact_force >= 0.0, "tick {tick}: {} N", seen.contact_force);
        if seen.contact_force > 0.0 {
            pushed += 1;
            assert!(seen.device.position > seen.object.position, "tick {tick}: a push from a distance");
        } else {
            ticks_free += 1;
        }
    }
    assert!(pushed > 500 && ticks_free > 500, "{pushed} ticks of push, {ticks_free} of none");
}

/// A constant push on a free copy: x = ½·F/m·t² at every tick, in every number type, for the rule is exact there.
#[test]
fn a_constant_force_moves_a_copy_exactly() {
    fn fallen<S: Scalar>() -> f64 {
        let mut settings = settings(0.0, 0.0, 10.0, 0.5, 0.0);
        settings.coordination.comm = "none";
        // A spring that soft, pressed that far, is a force.
        settings.contact.stiffness_n_per_m = 0.0;
        settings.contact.damping_n_s_per_m = 0.25;
        let mut bench = Bench::<S>::armed(&settings);
        // B·(ẋ_h − v), ẋ_h so that the force is 1 N all along: what the copy will do, half a tick ahead.
        for tick in 0..1000 {
            let mean = 2.0 * (f64::from(tick) + 0.5) * 1e-3;
            bench.at(S::ZERO, S::from_f64(4.0 + mean));
        }
        bench.at(S::ZERO, S::ZERO);
        bench.peer.observed()[0].object.position.to_f64()
    }
    assert!((fallen::<f64>() - 1.0).abs() < 1e-12, "{}", fallen::<f64>());
    assert!((fallen::<f32>() - 1.0).abs() < 1e-5, "{}", fallen::<f32>());
    assert!((fallen::<cohold_core::num::Fixed>() - 1.0).abs() < 1e-6, "{}", fallen::<cohold_core::num::Fixed>());
}

#[test]
fn what_it_needs_is_said() {
    let mut settings = settings(4000.0, 2.0, 10.0, 0.3, 0.0);
    settings.coordination.decode = Decode::Delayed;
    let said = settings.check().expect_err("a decode that opens the loop").to_string();
    assert!(said.starts_with("coordination.decode = \"delayed\" is not allowed: it must be \"implicit\""), "{said}");
    settings.coordination.decode = Decode::Implicit;
    settings.object.force_delay_ticks = 0.5;
    let said = settings.check().expect_err("a force that acts late").to_string();
    assert!(said.starts_with("object.force_delay_ticks = 0.5 is not allowed: it must be 0"), "{said}");
}
