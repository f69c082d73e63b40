//! What the device may do to a hand: force and power over time, and how far it goes, against closed forms.

use cohold_core::device::envelope::NEAR;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::Packet;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

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

/// What the second axis gave in each of these ticks where 30 N are asked of it at this speed, N.
fn given<S: Scalar>(bench: &mut Bench<S>, speed: f64, ticks: u32) -> Vec<f64> {
    let second = Motion { position: S::from_f64(-0.02), velocity: S::from_f64(speed) };
    (0..ticks).map(|_| bench.read(Reading::Exact([Motion::REST, second])).forces[1].to_f64()).collect()
}

/// Ticks in which x reaches this share of the limit's square: ln(1 − share·(limit/x)²) / ln(1 − T_c/τ).
fn closed_form(share: f64, limit: f64, x: f64, settings: &Settings) -> f64 {
    let weight = settings.timing.control_period_s / settings.safety.rms_s;
    (1.0 - share * (limit / x).powi(2)).ln() / (1.0 - weight).ln()
}

/// The root of the mean square after so many ticks of the law by which what is asked is cut, by a method of its own: the differential
/// equation of the mean, in a hundredth of a tick.
fn by_its_equation(limit: f64, lasting: f64, asked: f64, settings: &Settings, ticks: u32) -> (f64, f64) {
    let step = settings.timing.control_period_s / settings.safety.rms_s / 100.0;
    let (mut mean, mut given) = (0.0, asked);
    for _ in 0..100 * ticks {
        let left = ((1.0 - mean / (limit * limit)) / (1.0 - NEAR)).clamp(0.0, 1.0);
        given = asked.min(settings.safety.max_force_n * left + lasting);
        mean += step * (given * given - mean);
    }
    (given, mean.sqrt())
}

fn a_force_lasts_as_its_mean_square_allows<S: Scalar>() {
    for limit in [10.0, 20.0, 29.0] {
        let mut settings = held();
        settings.safety.max_rms_force_n = limit;
        let told = format!("{} at {limit} N", S::NAME);
        let mut bench = Bench::<S>::armed(&settings);
        let forces = given(&mut bench, 0.0, 3000);
        assert_eq!(bench.peer.mode(), Mode::Armed, "{told}");
        // In full until the mean square is near its limit. What falls first is force that is not asked for.
        let whole = forces.iter().take_while(|force| (*force - FORCE_N).abs() < 1e-5).count();
        assert!(whole as f64 >= closed_form(NEAR, limit, FORCE_N, &settings) - 1.0, "{told}: {whole}");
        // It falls as fast as its mean square rises, and at last to what may last on each of two axes.
        let rise = (FORCE_N / limit).powi(2) * settings.timing.control_period_s / settings.safety.rms_s;
        let most = settings.safety.max_force_n * rise / (1.0 - NEAR);
        assert!(forces.windows(2).all(|pair| pair[1] <= pair[0] + 1e-5 && pair[1] > pair[0] - most), "{told}");
        let mut square = 0.0;
        for (tick, force) in forces.iter().enumerate() {
            square += 1e-3 / settings.safety.rms_s * (force * force - square);
            assert!(square.sqrt() <= limit * (1.0 + 1e-6), "{told}: {} N at tick {tick}", square.sqrt());
        }
        let (last, _) = by_its_equation(limit, limit * 0.5_f64.sqrt(), FORCE_N, &settings, 3000);
        assert!((forces[2999] / last - 1.0).abs() < 5e-3, "{told}: {} N, {last} N", forces[2999]);

        // Arming anew forgives nothing.
        bench.command(Command::Disarm);
        bench.command(Command::Arm);
        let again = given(&mut bench, 0.0, 2)[1];
        assert!((again / last - 1.0).abs() < 2e-2, "{told}: {again} N, {last} N");
    }
    let mut settings = held();
    settings.safety.max_rms_force_n = 35.0;
    let forces = given(&mut Bench::<S>::armed(&settings), 0.0, 3000);
    assert!(forces.iter().all(|force| (force - FORCE_N).abs() < 1e-5), "{} with 35 N", S::NAME);
}

#[test]
fn force_over_time_in_every_number_type() {
    a_force_lasts_as_its_mean_square_allows::<f32>();
    a_force_lasts_as_its_mean_square_allows::<f64>();
    a_force_lasts_as_its_mean_square_allows::<Fixed>();
}

/// 30 N at 1.2 m/s are 36 W. What the hand gives the device is not its doing.
#[test]
fn power_over_time() {
    for limit in [5.0, 20.0, 35.0] {
        let mut settings = held();
        settings.safety.max_rms_force_n = 200.0;
        settings.safety.max_rms_power_w = limit;
        let mut bench = Bench::<f64>::armed(&settings);
        let forces = given(&mut bench, 1.2, 3000);
        assert_eq!(bench.peer.mode(), Mode::Armed);
        let whole = forces.iter().take_while(|force| (*force - FORCE_N).abs() < 1e-5).count();
        assert!(whole as f64 >= closed_form(NEAR, limit, 36.0, &settings) - 1.0, "{limit} W: {whole}");
        let mut square = 0.0;
        for force in &forces {
            square += 1e-3 / settings.safety.rms_s * ((1.2 * force).powi(2) - square);
            assert!(square.sqrt() <= limit * (1.0 + 1e-9), "{} W for {limit} W", square.sqrt());
        }
        // In the units of power: what is asked, and what the largest force would give.
        settings.safety.max_force_n *= 1.2;
        let (last, _) = by_its_equation(limit, limit, 36.0, &settings, 3000);
        assert!((1.2 * forces[2999] / last - 1.0).abs() < 5e-3, "{limit} W: {} N, {last} W", forces[2999]);
        let mut bench = Bench::<f64>::armed(&settings);
        assert!(given(&mut bench, -1.2, 3000).iter().all(|force| (force - FORCE_N).abs() < 1e-5));
    }
}

/// The smallest limits and the largest forces that settings allow overflow no number type. A mean over ten ticks is outrun: that is a fault.
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
    settings.safety.max_rms_force_n = 200.0;
    let mut bench = Bench::<Fixed>::armed(&settings);
    assert!(!bench.read(Reading::Exact([Motion::REST, fast])).enable);
    assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::PowerTooLong));
}

/// The partner moves his end by ±8.5 cm, five times a second, and asks for 50 N, at the limit of 40 N for less than half of the time. The hand gets
/// no more than its mean allows, and nothing ends.
#[test]
fn a_partner_who_shakes_the_hand() {
    let shaken = |max_rms_force_n: f64| {
        let mut settings = Settings::default();
        settings.coordination.comm = "power";
        settings.coordination.stiffness_n_per_m = 1000.0;
        settings.coordination.damping_n_s_per_m = 20.0;
        settings.safety.max_rms_force_n = max_rms_force_n;
        let mut bench = Bench::<f32>::armed(&settings);
        let (mut square, mut most) = (0.0, 0.0_f64);
        for tick in 0..6000_u16 {
            let turn = core::f64::consts::TAU * 5.0 * f64::from(tick) * 1e-3;
            if bench.peer.packet_due() {
                let motion = Motion::at(0.085 * turn.sin() as f32);
                bench.peer.hear(&[Packet { motion, ..Packet::default() }]);
                bench.peer.exchange();
            }
            // Held still.
            let [force, _] = bench.at(0.0, 0.0).forces;
            square += 1e-3 * (f64::from(force * force) - square);
            most = most.max(square.sqrt());
            assert_eq!(bench.peer.mode(), Mode::Armed);
        }
        most
    };
    let free = shaken(200.0);
    assert!(free > 22.0, "{free} N: no other guard sees it");
    let limited = shaken(15.0);
    assert!((12.0..=15.0).contains(&limited), "{limited} N");
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
