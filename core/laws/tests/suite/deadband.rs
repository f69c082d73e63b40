//! Deadband coding: Weber's law on a ramp, and what the receiver goes on at between packets, in closed form.

use crate::setup;
use cohold_core::law::{Coupled, Law, Observation, Packet};
use cohold_core::num::Motion;
use cohold_core::settings::Settings;
use cohold_laws::deadband::{Deadband, PassiveDeadband};

/// Silence for 50 ms.
fn settings(law: &'static str, own: &[(&str, f64)]) -> Settings {
    let mut settings = setup::settings(law, &[&[("event.longest_s", 0.05)], own].concat());
    (settings.safety.fade_s, settings.safety.disengage_s) = (0.1, 0.4);
    settings
}

fn moving(position: f64, velocity: f64) -> Packet<f64> {
    Packet { motion: Motion { position, velocity }, ..Packet::default() }
}

/// What is sent of a velocity that grows from 0 to 1 m/s by 0.1 mm/s a tick.
fn sent_of_a_ramp(weber: f64, least: f64) -> Vec<f64> {
    let own = [("deadband.weber", weber), ("deadband.least_m_per_s", least)];
    let law = Deadband::<f64>::build(&settings("deadband", &own)).expect("good settings");
    let mut state = law.start(Motion::REST);
    let mut sent = Vec::new();
    for tick in 0..=10_000 {
        let packet = moving(0.0, 1e-4 * f64::from(tick));
        if Law::<f64>::speaks(&law, &state, &packet) {
            law.spoke(&mut state, &packet);
            sent.push(packet.motion.velocity);
        }
    }
    sent
}

/// Each is the first sample beyond (1 + k) times the one before, or beyond Δ₀ more; so their number is ln(v/v₀)/ln(1 + k) but for the
/// grain of the ramp.
#[test]
fn a_ramp_is_sent_at_webers_fractions() {
    for (weber, least) in [(0.1, 1e-3), (0.05, 1e-3), (0.3, 1e-3), (0.0, 0.02), (0.1, 0.02)] {
        let sent = sent_of_a_ramp(weber, least);
        for pair in sent.windows(2) {
            let beyond = pair[0] + f64::max(weber * pair[0], least);
            assert!(pair[1] > beyond - 1e-12 && pair[1] <= beyond + 1e-4 + 1e-12, "{pair:?} at {weber}");
        }
        if weber > 0.0 && least < 0.01 {
            let geometric: Vec<f64> = sent.iter().copied().filter(|velocity| *velocity > 0.1).collect();
            let expected = (geometric[geometric.len() - 1] / geometric[0]).ln() / (1.0 + weber).ln();
            let steps = (geometric.len() - 1) as f64;
            assert!(steps <= expected && steps > 0.98 * expected, "{steps} packets for {expected}");
        }
    }
}

#[test]
fn standing_still_is_worth_no_packet_and_turning_is() {
    let law = Deadband::<f64>::build(&settings("deadband", &[])).expect("good settings");
    let mut state = law.start(Motion::REST);
    assert!(!Law::<f64>::speaks(&law, &state, &moving(0.1, 0.0)));
    assert!(!Law::<f64>::speaks(&law, &state, &moving(0.1, 0.002)));
    assert!(Law::<f64>::speaks(&law, &state, &moving(0.1, 0.0021)));
    law.spoke(&mut state, &moving(0.0, 0.5));
    assert!(!Law::<f64>::speaks(&law, &state, &moving(0.0, 0.549)));
    assert!(!Law::<f64>::speaks(&law, &state, &moving(0.0, 0.451)));
    assert!(Law::<f64>::speaks(&law, &state, &moving(0.0, -0.5)));
}

/// A copy that is held at the origin, `ticks` after a packet.
fn after<L: Law<f64>>(law: &L, packet: Packet<f64>, ticks: u32) -> Vec<Coupled<f64>> {
    let mut state = law.start(Motion::REST);
    law.receive(&mut state, packet);
    let tick = |age_ticks| {
        let seen = Observation { local: Motion::REST, age_ticks, ..Observation::default() };
        law.couple(&mut state, &seen, |_| 0.0)
    };
    (0..ticks).map(tick).collect()
}

/// x_d = x* + n·T_c·ẋ* for 50 ticks; then it stands.
#[test]
fn the_last_sample_is_held_for_the_longest_silence() {
    let law = Deadband::<f64>::build(&settings("deadband", &[])).expect("good settings");
    for (tick, coupled) in after(&law, moving(0.01, 0.2), 80).into_iter().enumerate() {
        let wanted = 0.01 + 2e-4 * tick.min(50) as f64;
        assert!((coupled.desired.position - wanted).abs() < 1e-12, "tick {tick}: {} m", coupled.desired.position);
        assert_eq!(coupled.desired.velocity, if tick < 50 { 0.2 } else { 0.0 }, "tick {tick}");
        // F_T = K_T·(x_d − x_o) + B_T·ẋ_d on a copy that is held still.
        let force = 1000.0 * wanted + 2.0 * coupled.desired.velocity;
        assert!((coupled.force - force).abs() < 1e-9, "tick {tick}: {} N", coupled.force);
    }
}

/// ẋ_d = ẋ* − Δ·sign(F_T) once there is a force, Δ = k·|ẋ*|: of all velocities that the deadband leaves open none gives less power.
#[test]
fn the_modified_hold_takes_the_velocity_that_gives_least() {
    let law = PassiveDeadband::<f64>::build(&settings("passive-deadband", &[("coordination.tank_j", 1.0)]));
    let law = law.expect("good settings");
    for (position, velocity, wanted) in
        [(0.01, 0.2, 0.18), (-0.01, 0.2, 0.22), (0.01, -0.2, -0.22), (-0.01, -0.2, -0.18)]
    {
        let coupled = after(&law, moving(position, velocity), 10);
        assert!((coupled[0].desired.velocity - velocity).abs() < 1e-12, "no force yet");
        for Coupled { desired, force, .. } in &coupled[1..] {
            assert!((desired.velocity - wanted).abs() < 1e-12, "{} m/s for {wanted}", desired.velocity);
            let open = [0.9, 0.95, 1.0, 1.05, 1.1].map(|share| force * share * velocity);
            assert!(open.iter().all(|power| force * desired.velocity <= power + 1e-12));
        }
    }
}
