//! The proxy: its modes as its differential equation has them, and what it is for: a force without steps.

use cohold_core::device::{AXES, Reading};
use cohold_core::law::Packet;
use cohold_core::num::Motion;
use cohold_core::peer::Sensors;

use super::period;
use crate::two_copies::{Copies, PERIOD, settings};

/// Alone (K_T = B_T = 0), its remote copy put Δ away, at rest: x_p of every tick, m.
fn alone(mass: f64, stiffness: f64, damping: f64) -> Vec<f64> {
    let settings = settings(
        "remote-dynamic-proxy",
        &[
            ("coordination.stiffness_n_per_m", 0.0),
            ("coordination.damping_n_s_per_m", 0.0),
            ("contact.stiffness_n_per_m", 0.0),
            ("contact.damping_n_s_per_m", 0.0),
            ("remote_proxy.mass_kg", mass),
            ("remote_proxy.stiffness_n_per_m", stiffness),
            ("remote_proxy.damping_n_s_per_m", damping),
        ],
    );
    let mut copies = Copies::<f64>::new(&settings, 0);
    (0..4000)
        .map(|_| {
            copies.peers[0].hear(&[Packet { motion: Motion::at(1.0), ..Packet::default() }]);
            copies.peers[0].exchange();
            copies.peers[0].tick(&Sensors::of(Reading::Exact([Motion::REST; AXES])));
            copies.peers[0].observed()[0].desired.position
        })
        .collect()
}

/// The step response of m·ẍ + B·ẋ + K·(x − 1) = 0 from rest, at time t.
fn closed(mass: f64, stiffness: f64, damping: f64, time: f64) -> f64 {
    let (decay, square) = (damping / (2.0 * mass), stiffness / mass - (damping / (2.0 * mass)).powi(2));
    let root = square.abs().sqrt();
    let (cos, sin) = if square > 0.0 {
        ((root * time).cos(), (root * time).sin())
    } else {
        ((root * time).cosh(), (root * time).sinh())
    };
    1.0 - (-decay * time).exp() * (cos + decay / root * sin)
}

#[test]
fn its_step_response_is_that_of_its_equation() {
    for (mass, stiffness, damping) in [(0.02, 310.0, 4.0), (0.1, 100.0, 1.0), (0.5, 50.0, 30.0)] {
        let got = alone(mass, stiffness, damping);
        let off = got
            .iter()
            .enumerate()
            .map(|(tick, x)| (x - closed(mass, stiffness, damping, tick as f64 * PERIOD)).abs())
            .fold(0.0, f64::max);
        // The midpoint rule is of second order: (ω·T_c)²/12 of a period, a few periods long.
        assert!(off < 5e-3, "{mass} kg, {stiffness} N/m, {damping} N·s/m: {off}");
    }
}

/// Without damping the mode s = ±iω becomes z = e^(±iθ), tan(θ/2) = ω·T_c/2: it neither grows nor decays, whatever K_p is, and its period is known to the digit.
#[test]
fn its_eigenvalues_are_the_closed_form() {
    for stiffness in [10.0, 1e3, 1e5] {
        let swing: Vec<f64> = alone(0.02, stiffness, 0.0).iter().map(|x| x - 1.0).collect();
        let omega = (stiffness / 0.02_f64).sqrt();
        let angle = 2.0 * (0.5 * omega * PERIOD).atan();
        let wanted = std::f64::consts::TAU / angle * PERIOD;
        // Crossings are found between ticks by a straight line: better the slower it swings.
        assert!((period(&swing) / wanted - 1.0).abs() < 2e-3, "{stiffness}: {} s, {wanted} s", period(&swing));
        // What an undamped midpoint swing keeps: 2·cos(θ) of two ticks apart, to rounding.
        for three in swing.windows(3) {
            let [a, b, c] = [three[0], three[1], three[2]];
            assert!((a + c - 2.0 * angle.cos() * b).abs() < 1e-9, "{stiffness}: {a} {b} {c}");
        }
    }
}

/// A packet that says that the remote copy is 1 mm farther: the power-domain law's force steps by K_T·Δ, the proxy's moves off from where it was.
#[test]
fn a_packet_makes_no_step_in_the_force() {
    let step = |law: &'static str| {
        let settings = settings(law, &[("coordination.stiffness_n_per_m", 1590.0), ("contact.stiffness_n_per_m", 0.0)]);
        let mut copies = Copies::<f64>::new(&settings, 0);
        copies.tick([Motion::REST; 2]);
        copies.peers[0].hear(&[Packet { motion: Motion::at(1e-3), ..Packet::default() }]);
        copies.peers[0].exchange();
        let reading = Reading::Exact([Motion::REST; AXES]);
        copies.peers[0].tick(&Sensors::of(reading));
        copies.peers[0].observed()[0].coordination_force
    };
    let (power, proxy) = (step("power"), step("remote-dynamic-proxy"));
    // Less what the copy gives way in the tick.
    assert!((power / 1.59 - 1.0).abs() < 0.01, "{power} N");
    // K_p·Δ·κ/(D + κ) of the port, D = 2m_p/T_c + κ_p, κ = K_T·T_c/2 + B_T.
    let (kappa, own) = (0.795 + 2.0, 40.0 + 0.155 + 4.0);
    let bound = 0.31 * kappa / (own + kappa);
    assert!(proxy > 0.0 && proxy <= bound && proxy > 0.9 * bound, "{proxy} N of {bound} N");
}

/// Pulled together from wherever they are: at rest both copies and both proxies are at one place.
#[test]
fn nothing_drifts_after_losses() {
    let settings = settings(
        "remote-dynamic-proxy",
        &[("timing.ticks_per_packet", 8.0), ("contact.stiffness_n_per_m", 0.1), ("contact.damping_n_s_per_m", 0.0)],
    );
    let mut copies = Copies::<f64>::new(&settings, 1);
    let mut number = 0_u32;
    for tick in 0..4000_u32 {
        let push = if tick < 2000 { 5.0 } else { 0.0 };
        // Three of four packets are lost while the hands push against each other.
        copies.tick_over([Motion::at(push), Motion::at(-push)], || {
            number += 1;
            number.is_multiple_of(4)
        });
    }
    let [one, two] = (0..10_000).map(|_| copies.tick([Motion::REST; 2])).last().expect("ticks");
    let distance_m = one.object.position - two.object.position;
    assert!(distance_m.abs() < 1e-6, "{distance_m} m apart");
}
