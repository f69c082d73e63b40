//! What two ends answer to a hand: matrices against runs, and both against closed forms.

use std::f64::consts::TAU;

use cohold_analysis::answers;
use cohold_sim::measure::impedance::{Answer, Complex, RemoteEnd, SPEED_M_PER_S, answer};
use cohold_sim::scene::Scene;
use cohold_sim::scenes;

fn scene(packets: u32) -> Scene {
    let keys = ["network.jitter=none", "network.loss=0", &format!("network.one_way_delay_packets={packets}")];
    let keys = keys.map(str::to_owned);
    scenes::find(cohold_guest_laws::laws(), Some("leader-follower".as_ref()), &keys).unwrap()
}

fn one(packets: u32, near: usize, far: RemoteEnd, frequency_hz: f64) -> Answer {
    answers(&scene(packets), near, far, &[frequency_hz]).unwrap()[0]
}

#[test]
fn what_is_analysed_is_what_is_measured() {
    for packets in [40, 80] {
        for near in [0, 1] {
            for far in [RemoteEnd::Held, RemoteEnd::LetGo, RemoteEnd::Alone] {
                for frequency_hz in [0.5, 4.0, 25.0] {
                    // How a line carries on while it learns the delay is not linear, and what nobody holds rings of it for long.
                    let mut scene = scene(packets);
                    let damping = if far == RemoteEnd::LetGo { 0.0 } else { 5.0 };
                    scene.set_number("coordination.carry_damping_n_s_per_m", damping).unwrap();
                    let measured = answer(&scene, near, far, frequency_hz, SPEED_M_PER_S).unwrap();
                    let measured = measured.expect("it repeats");
                    let analysed = answers(&scene, near, far, &[frequency_hz]).unwrap()[0];
                    let close = |what: &str, one: Complex, other: Complex, least: f64| {
                        let off = (one - other).norm();
                        let label = format!("{what}, {packets} packets, led at {near}, {far:?}, {frequency_hz} Hz");
                        // What nobody holds and hardly anything damps still rings in the run, by what a run may repeat to.
                        let within = if far == RemoteEnd::LetGo { 3e-2 } else { 1e-3 };
                        assert!(off <= within * one.norm().max(least), "{label}: {one:?}, {other:?}");
                    };
                    close("impedance", analysed.impedance, measured.impedance, 1e-3);
                    close("motion", analysed.motion, measured.motion, 1e-3);
                    close("pushed", analysed.pushed, measured.pushed, 1e-3);
                }
            }
        }
    }
}

/// A line that follows the network is as long as the delay, the tick in which it is heard, and what it keeps to spare: below 2 ms here.
/// Far below every resonance: a held device is a spring behind 2/K_LC + 2/K_T + T/b, one that is alone a mass of all masses and b·T, which
/// the hand's motion takes along whole; and what is pressed at one end is felt at the other.
#[test]
fn slowly_moved_it_is_a_spring_or_a_mass() {
    let frequency_hz = 0.02;
    for packets in [40, 80] {
        let (line_s, omega) = (1e-3 * (f64::from(packets) + 1.0), TAU * frequency_hz);
        let spring = 1.0 / (2.0 / 1000.0 + 2.0 / 2000.0 + line_s / 10.0);
        let masses = 0.1 + 5.0 + 2.0 * 0.05 + 10.0 * line_s;
        for (near, far_damping) in [(0, 5.0), (1, 1.0)] {
            // Its damping behind that spring lets the hand go ahead: b − jω·b²/K of a damper behind a spring.
            let mass = masses - far_damping * far_damping / spring;
            let (held, alone) =
                (one(packets, near, RemoteEnd::Held, frequency_hz), one(packets, near, RemoteEnd::Alone, frequency_hz));
            let (felt, weighs) = (-omega * held.impedance.im, alone.impedance.im / omega);
            assert!((felt / spring - 1.0).abs() < 0.02, "{packets}: {felt} N/m, not {spring}");
            assert!((weighs / mass - 1.0).abs() < 0.01, "{packets}: {weighs} kg, not {mass}");
            assert!((alone.motion.norm() - 1.0).abs() < 0.02, "{packets}: {:?}", alone.motion);
            let ratio = held.pushed.norm() / held.impedance.norm();
            assert!((ratio - 1.0).abs() < 0.02, "{packets}: {ratio}");
        }
    }
}

#[test]
fn packets_of_several_ticks_are_refused_by_name() {
    let mut scene = scene(8);
    scene.apply_override("timing.ticks_per_packet=8").unwrap();
    let refused = answers(&scene, 0, RemoteEnd::Held, &[1.0]).unwrap_err().to_string();
    assert_eq!(refused, "timing.ticks_per_packet = 8 is not allowed here: it must be 1, a packet every tick");
}
