//! What the device may do to a hand: force and power over time, and how far it goes, against closed forms.

use haptic_core::device::{AXES, Reading};
use haptic_core::law::Packet;
use haptic_core::num::{Fixed, Motion, Scalar};
use haptic_core::safety::{Command, Fault, Mode};
use haptic_core::settings::Settings;

use super::Bench;

/// The second axis is held by a spring alone: 20 mm from its line are exactly 30 N, object or not.
const FORCE_N: f64 = 30.0;

fn held() -> Settings {
    let mut settings = Settings::default();
    settings.axis.count = 2;
    settings.axis.hold_stiffness_n_per_m = 1500.0;
    settings.axis.hold_damping_n_s_per_m = 0.0;
    settings.safety.max_slew_n_per_s = 1e6;
    settings.safety.rms_s = 0.5;
    settings
}

/// Ticks that 30 N on an axis at this speed are allowed, and why they end.
fn allowed<S: Scalar>(bench: &mut Bench<S>, speed: f64) -> (u32, Mode) {
    let second = Motion { position: S::from_f64(-0.02), velocity: S::from_f64(speed) };
    (0..20_000)
        .find_map(|ticks| {
            let actuators = bench.read(Reading::Exact([Motion::REST, second]));
            let mode = bench.peer.mode();
            assert!(mode != Mode::Armed || (actuators.forces[1].to_f64() - FORCE_N).abs() < 1e-5);
            (mode != Mode::Armed).then_some((ticks, mode))
        })
        .unwrap_or((20_000, bench.peer.mode()))
}

/// m reaches 1 after n = ln(1 − (limit/x)²) / ln(1 − T_c/τ) ticks.
fn closed_form(limit: f64, x: f64, settings: &Settings) -> u32 {
    let share = settings.timing.control_period_s / settings.safety.rms_s;
    ((1.0 - (limit / x).powi(2)).ln() / (1.0 - share).ln()) as u32
}

fn a_force_is_taken_for_as_long_as_its_mean_square_allows<S: Scalar>() {
    for limit in [10.0, 20.0, 29.0] {
        let mut settings = held();
        settings.safety.max_rms_force_n = limit;
        let mut bench = Bench::<S>::armed(&settings);
        let (ticks, mode) = allowed(&mut bench, 0.0);
        assert_eq!(mode, Mode::Faulted(Fault::ForceTooLong), "{} at {limit} N", S::NAME);
        assert!(ticks.abs_diff(closed_form(limit, FORCE_N, &settings)) <= 1, "{} at {limit} N: {ticks}", S::NAME);

        // A fault and arming anew forgive nothing.
        bench.command(Command::Clear);
        bench.command(Command::Arm);
        assert!(allowed(&mut bench, 0.0).0 <= 1, "{} at {limit} N", S::NAME);

        // With the motors off for a time of 3 τ, all but e⁻³ of it is.
        bench.command(Command::Clear);
        for _ in 0..1500 {
            bench.at(S::ZERO, S::ZERO);
        }
        bench.command(Command::Arm);
        let again = f64::from(allowed(&mut bench, 0.0).0);
        let left = (-3.0_f64).exp();
        let expected = ((1.0 - (limit / FORCE_N).powi(2)) / (1.0 - left * (limit / FORCE_N).powi(2))).ln()
            / (1.0 - settings.timing.control_period_s / settings.safety.rms_s).ln();
        assert!((again - expected).abs() <= 3.0, "{} at {limit} N: {again} for {expected}", S::NAME);
    }
    let mut settings = held();
    settings.safety.max_rms_force_n = 30.5;
    assert_eq!(allowed(&mut Bench::<S>::armed(&settings), 0.0).1, Mode::Armed);
}

#[test]
fn force_over_time_in_every_number_type() {
    a_force_is_taken_for_as_long_as_its_mean_square_allows::<f32>();
    a_force_is_taken_for_as_long_as_its_mean_square_allows::<f64>();
    a_force_is_taken_for_as_long_as_its_mean_square_allows::<Fixed>();
}

/// P = 30 N · 1.2 m/s. What the hand gives the device is not its doing.
#[test]
fn power_over_time() {
    for limit in [5.0, 20.0, 35.0] {
        let mut settings = held();
        settings.safety.max_rms_force_n = 200.0;
        settings.safety.max_rms_power_w = limit;
        let (ticks, mode) = allowed(&mut Bench::<f64>::armed(&settings), 1.2);
        assert_eq!(mode, Mode::Faulted(Fault::PowerTooLong));
        assert!(ticks.abs_diff(closed_form(limit, 36.0, &settings)) <= 1, "{limit} W: {ticks}");
        assert_eq!(allowed(&mut Bench::<f64>::armed(&settings), -1.2).1, Mode::Armed);
    }
}

/// The smallest limits and the largest forces that settings allow overflow no number type.
#[test]
fn the_ends_of_the_ranges() {
    let mut settings = held();
    settings.axis.hold_stiffness_n_per_m = 1e5;
    settings.safety.max_force_n = 200.0;
    settings.safety.max_speed_m_per_s = 100.0;
    settings.safety.max_rms_force_n = 0.01;
    settings.safety.max_rms_power_w = 0.01;
    let fast = Motion { position: Fixed::from_f64(-0.02), velocity: Fixed::from_f64(99.0) };
    let mut bench = Bench::<Fixed>::armed(&settings);
    assert!(!bench.read(Reading::Exact([Motion::REST, fast])).enable);
    assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::ForceTooLong));
}

/// The partner moves his end by ±8.5 cm, five times a second, and asks for 50 N: at the limit of 40 N for less than half of the time,
/// so that fault 4 forgets it again and again.
#[test]
fn a_partner_who_shakes_the_hand() {
    let shaken = |max_rms_force_n: f64| {
        let mut settings = Settings::default();
        settings.coordination.comm = "power";
        settings.coordination.stiffness_n_per_m = 1000.0;
        settings.coordination.damping_n_s_per_m = 20.0;
        settings.safety.max_rms_force_n = max_rms_force_n;
        let mut bench = Bench::<f32>::armed(&settings);
        let mut square = 0.0;
        for tick in 0..6000_u16 {
            let turn = core::f64::consts::TAU * 5.0 * f64::from(tick) * 1e-3;
            if bench.peer.packet_due() {
                let motion = Motion::at(0.085 * turn.sin() as f32);
                bench.peer.hear(&[Packet { motion, ..Packet::default() }]);
                bench.peer.exchange();
            }
            // Held still.
            let [force, _] = bench.at(0.0, 0.0).forces;
            square += f64::from(force * force);
            if bench.peer.mode() != Mode::Armed {
                return (tick, bench.peer.mode(), square);
            }
        }
        (6000, bench.peer.mode(), square)
    };
    let (_, mode, square) = shaken(200.0);
    assert_eq!(mode, Mode::Armed, "no other guard sees it");
    assert!((square / 6000.0).sqrt() > 22.0, "{} N", (square / 6000.0).sqrt());
    let (tick, mode, _) = shaken(20.0);
    assert_eq!(mode, Mode::Faulted(Fault::ForceTooLong));
    assert!(tick < 2000, "{tick}");
}

/// A free device that is dragged away, and one that stands too far out.
#[test]
fn the_workspace_ends() {
    let settings = Settings::default();
    let end = settings.safety.workspace_m as f32;
    for outward in [1.0, -1.0] {
        let mut bench = Bench::<f32>::at_rest(&settings, Motion::at(0.3));
        // With the motors off anybody may take it anywhere.
        bench.at(0.3 + outward * (end + 0.5), 0.0);
        assert_eq!(bench.peer.mode(), Mode::Disarmed);
        bench.at(0.3 + outward * (end - 0.001), 0.0);
        bench.command(Command::Arm);
        assert!(bench.at(0.3 + outward * (end - 0.001), 0.0).enable);
        assert!(!bench.at(0.3 + outward * (end + 0.001), 0.0).enable);
        assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::OutOfWorkspace));
        bench.command(Command::Clear);
        bench.command(Command::Arm);
        assert_eq!(bench.at(0.3 + outward * (end + 0.001), 0.0).forces, [0.0; AXES]);
        assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::OutOfWorkspace));
    }
}
