//! Gains, masses and delays over all that a scene accepts.

use cohold_analysis::{Verdict, verdict};
use cohold_core::num::{Fixed, StateVector};
use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;
use cohold_sim::scene::Scene;

use super::setup::{COMMS, scene};

/// Users who push, pull back and strike, so that every mode is there.
const USERS: &str = "user.1.push_n=0.5 user.2.push_n=0.5 user.1.pulse_n=0.5 user.1.pulse_every_s=1";

/// Packets that the pushes last.
const PACKETS: u64 = 750;

/// What became of a pair that computes in one number type.
struct Ran {
    faulted: bool,
    /// A motor had as much as one of the limits gives.
    cut: bool,
    largest_force_n: f64,
}

/// Runs the scene; whatever the peers compute, what reaches the motors is within the limit, and nothing after a fault.
fn ran<S: Number>(scene: &Scene) -> Ran {
    let mut pair = Pair::<S>::new(scene).expect("a good scene");
    let (mut largest_force_n, mut largest_motor_n) = (0.0_f64, 0.0_f64);
    let step_n = scene.peer.safety.max_slew_n_per_s * scene.peer.timing.control_period_s;
    let least_cut_n = 0.999 * step_n.min(scene.peer.safety.max_force_n);
    for _ in 0..PACKETS * u64::from(scene.peer.timing.ticks_per_packet) {
        pair.step();
        for side in pair.sides_mut() {
            let motor_n = *side.plant.free_axis().1;
            assert!(motor_n.abs() <= scene.peer.safety.max_force_n, "{motor_n} N from {}", S::NAME);
            assert!(motor_n == 0.0 || side.peer.mode() == cohold_core::safety::Mode::Armed);
            largest_motor_n = largest_motor_n.max(motor_n.abs());
            largest_force_n = largest_force_n.max(side.peer.observed()[0].coordination_force.to_f64().abs());
        }
    }
    Ran { faulted: pair.fault().is_some(), cut: largest_motor_n >= least_cut_n, largest_force_n }
}

/// Whether the linear pair settles, from random states too small to meet a limit; asked of what changes by e⁶ within
/// 150,000 packets.
fn settles(scene: &Scene, verdict: &Verdict) -> bool {
    let linear = scene.linear();
    let mut pair = Pair::<f64>::new(&linear).expect("a good scene");
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0) * 2.0_f64.powi(-300)
    };
    for side in pair.sides_mut() {
        side.peer.visit(&mut |number: &mut f64| *number = random());
        side.plant.free_axis().0.velocity = random();
    }
    let least = 8.0 * f64::from(linear.world.network.one_way_delay_packets + 1);
    let packets = (16.0 / verdict.spectral_radius.ln().abs()).clamp(least, 150_000.0) as u64;
    let window = packets / 8 * u64::from(linear.peer.timing.ticks_per_packet);
    let mut envelopes = [0.0_f64; 8];
    for envelope in &mut envelopes {
        for _ in 0..window {
            pair.step();
            for side in pair.sides() {
                let seen = side.peer.observed()[0];
                for size in [seen.device.velocity, seen.object.velocity, seen.contact_force, seen.coordination_force] {
                    *envelope = envelope.max(size.abs());
                }
            }
        }
    }
    pair.fault().is_none() && envelopes[7] < envelopes[3]
}

/// Everything that must hold of a scene, however extreme.
fn check(name: &str, overrides: &str) {
    let scene = scene(&format!("{overrides} {USERS}"));
    let verdict = verdict(&scene).expect("a verdict");
    let radius = verdict.spectral_radius;
    let all = [ran::<f64>(&scene), ran::<f32>(&scene), ran::<Fixed>(&scene)];
    let forces =
        all.each_ref().map(|ran| format!("{}{:.3e}", if ran.faulted { "fault " } else { "" }, ran.largest_force_n));
    println!("{name:45} rho {radius:.8}, {} states; largest F_T: {}", verdict.states, forces.join(", "));
    for ran in &all {
        if verdict.stable {
            assert!(!ran.faulted, "{name}: a stable pair stopped");
            let same = (ran.largest_force_n / all[0].largest_force_n - 1.0).abs();
            assert!(same < 1e-3, "{name}: number types differ by {same}");
        } else if radius.ln() * PACKETS as f64 > 20.0 {
            // What limits take of a contact is passive: some go on there, without end and without growing.
            assert!(ran.faulted || ran.cut, "{name}: grew by e^20 and met nothing");
        }
    }
    if (radius - 1.0).abs() > 1e-4 {
        assert_eq!(settles(&scene, &verdict), verdict.stable, "{name}");
    }
}

/// Why: from a coupling that is hardly there to one that no f32 can resolve (one step of a position of 0.3 m is 0.3 N of
/// spring at 1e7 N/m). Stable ones run alike in every number type; unstable ones end in a fault, with the motors off.
#[test]
fn coordination_stiffness_over_ten_decades() {
    let implicit = "coordination.decode=implicit object.force_delay_ticks=0 object.integrator=semi-implicit";
    for (law, _) in COMMS {
        for (decode, more) in [("delayed", ""), ("implicit", implicit)] {
            for exponent in -3..=7 {
                let comm_and_gain =
                    format!("coordination.comm={law} coordination.stiffness_n_per_m=1e{exponent} {more}");
                check(&format!("{law}, {decode}, K_T = 1e{exponent} N/m"), &comm_and_gain);
            }
        }
    }
}

/// Why: 0.1 g under 1000 N/m swings faster than it is sampled; a ton hardly moves, and its modes lie within 1e-6 of 1.
#[test]
fn object_mass_over_seven_decades() {
    for (law, stiffness) in COMMS {
        for integrator in ["forward-euler", "semi-implicit", "exact"] {
            for exponent in -4..=3 {
                let overrides = format!(
                    "coordination.comm={law} coordination.stiffness_n_per_m={stiffness} object.integrator={integrator} \
                     object.mass_kg=1e{exponent}"
                );
                check(&format!("{law}, {integrator}, m_O = 1e{exponent} kg"), &overrides);
            }
        }
    }
}

/// Why: 125 packets are a second each way, and hundreds of states on their way, whose eigenvalues crowd near the circle.
#[test]
fn delay_up_to_a_second() {
    // Power-domain coordination bears little stiffness over such delays.
    for (law, stiffness) in [("power", 5.0), ("wave", 1000.0), ("passive-wave", 2000.0)] {
        for delay in [0, 1, 2, 5, 10, 20, 50, 100, 125] {
            let overrides = format!(
                "coordination.comm={law} coordination.stiffness_n_per_m={stiffness} \
                 network.one_way_delay_packets={delay} safety.max_delay_s=1"
            );
            check(&format!("{law}, n_t = {delay}"), &overrides);
        }
    }
}
