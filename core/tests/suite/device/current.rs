//! The current loop against closed forms and a twin in f64 that shares nothing with it: the winding advanced exactly.

use std::f64::consts::TAU;

use cohold_core::device::current::{
    Controller, CurrentLoop, Gains, MOST_VOLTAGE, PWM_PERIOD_S, Sensor, lag_s, periods_per_tick,
};
use cohold_core::device::motor::Duty;
use cohold_core::device::thermal::{HOT, Heat, Thermal, Thermistor};
use cohold_core::settings::{Settings, Value};
use proptest::prelude::*;

use super::{number, settings};

/// A timer of 3000 counts.
const COUNTS: u16 = 3000;
const SUPPLY_V: f64 = 24.0;

/// The motor of the measurements: 1.5 Ω, 0.5 mH.
fn motor(crossover_hz: f64) -> Settings {
    settings(&[("motor.resistance_ohm", number(1.5)), ("motor.current_loop_hz", number(crossover_hz))])
}

/// A winding at rest or moving, averaged over each PWM period, its rotor making `emf_v`.
struct Winding {
    resistance: f64,
    inductance: f64,
    current_a: f64,
}

impl Winding {
    /// One period at this voltage; the mean current, A.
    fn period(&mut self, volts: f64) -> f64 {
        let (before, end, time) = (self.current_a, volts / self.resistance, self.inductance / self.resistance);
        let left = (-PWM_PERIOD_S / time).exp();
        self.current_a = end + (before - end) * left;
        end + (before - end) * time / PWM_PERIOD_S * (1.0 - left)
    }
}

/// Mean current of each period (A) under the code that flies and under the same law in f64, the winding moving or not.
fn both(
    settings: &Settings,
    reference: impl Fn(usize) -> f64,
    emf_v: impl Fn(usize) -> f64,
    periods: usize,
) -> [Vec<f64>; 2] {
    let motor = &settings.motor;
    let design = CurrentLoop::build(settings, COUNTS).unwrap();
    let gains = design.gains(24_000);
    let code_a = motor.full_scale_a / 32767.0;
    let crossover = TAU * motor.current_loop_hz;
    let winding = || Winding { resistance: motor.resistance_ohm, inductance: motor.inductance_h, current_a: 0.0 };
    let (mut flies, mut twin, mut controller) = (winding(), winding(), Controller::default());
    let (mut counts, mut volts, mut integral) = (0, 0.0, 0.0);
    let mut currents = [Vec::new(), Vec::new()];
    for n in 0..periods {
        let wanted = reference(n);
        // What is sampled now acts in the next period; what the last one made acts in this.
        let measured = (flies.current_a / code_a).round() as i32;
        let next = controller.step(&gains, Duty((wanted / code_a).round() as i16), measured, 0);
        let error = wanted - twin.current_a;
        currents[0].push(flies.period(f64::from(counts) / f64::from(COUNTS) * SUPPLY_V - emf_v(n)));
        counts = next;
        let asked: f64 = crossover * motor.inductance_h * error + integral;
        let most = MOST_VOLTAGE * SUPPLY_V;
        let given = asked.clamp(-most, most);
        if asked == given || asked.signum() != error.signum() {
            integral += crossover * motor.resistance_ohm * PWM_PERIOD_S * error;
        }
        currents[1].push(twin.period(volts - emf_v(n)));
        volts = given;
    }
    currents
}

fn largest_difference([a, b]: &[Vec<f64>; 2]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// 63° of phase margin: 3 % of overshoot, 90 % within 0.3 ms; at 1.5 and 2 kHz 18 % and 38 %.
#[test]
fn a_step_overshoots_as_its_phase_margin_says() {
    for (hz, overshoot) in [(1000.0, 0.03), (1500.0, 0.18), (2000.0, 0.38)] {
        let currents = both(&motor(hz), |_| 0.5, |_| 0.0, 200);
        let peak = currents[0].iter().copied().fold(0.0, f64::max) / 0.5 - 1.0;
        assert!((peak - overshoot).abs() < 0.02, "{hz} Hz: {peak}");
        let rise = currents[0].iter().position(|current| *current > 0.45).unwrap() as f64 * PWM_PERIOD_S + PWM_PERIOD_S;
        assert!((190e-6..310e-6).contains(&rise), "{hz} Hz: {rise}");
        assert!((currents[0][199] - 0.5).abs() < 2e-3, "{hz} Hz: {}", currents[0][199]);
        // A count is 8 mV, which is 5 mA for ever and less for a while.
        assert!(largest_difference(&currents) < 3e-3, "{hz} Hz: {}", largest_difference(&currents));
    }
}

/// The area above the response to a step, which [`lag_s`] says in closed form, by adding it up.
#[test]
fn a_current_lags_its_reference_by_what_is_said() {
    for hz in [300.0, 700.0, 1000.0, 1500.0] {
        let settings = motor(hz);
        let [currents, twin] = both(&settings, |_| 1.0, |_| 0.0, 200);
        for currents in [currents, twin] {
            let area = currents.iter().map(|current| 1.0 - current).sum::<f64>() * PWM_PERIOD_S;
            assert!((area - lag_s(&settings)).abs() < 0.02 * lag_s(&settings), "{hz} Hz: {area} {}", lag_s(&settings));
        }
    }
}

/// A rotor that is moved makes a voltage that the loop makes good: i = emf·s/(L·s² + …) is ω/(ω_c·R) of it at low frequency.
#[test]
fn a_moving_rotor_disturbs_by_its_frequency_over_the_crossover() {
    let settings = motor(1000.0);
    let frequency = 3.0;
    let emf = |n: usize| 3.5 * (TAU * frequency * n as f64 * PWM_PERIOD_S).sin();
    let currents = both(&settings, |_| 0.0, emf, 40_000);
    let rms = |all: &[f64]| (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
    let expected = 3.5 / 2.0_f64.sqrt() * (frequency / 1000.0) / 1.5;
    assert!((rms(&currents[0]) - expected).abs() < 0.1 * expected, "{} {expected}", rms(&currents[0]));
    assert!((rms(&currents[1]) - expected).abs() < 0.03 * expected, "{} {expected}", rms(&currents[1]));
}

/// Why: an integral that grows through a second at the limit takes a second to come back.
#[test]
fn a_second_at_the_limit_leaves_no_windup() {
    // 30 V against 24 V: the reference cannot be reached; then the rotor stops.
    let stop = 20_000;
    let [currents, _] = both(&motor(1000.0), |_| 0.5, |n| if n < stop { 30.0 } else { 0.0 }, stop + 100);
    assert!(currents[stop] < -3.0, "not at its limit: {}", currents[stop]);
    // The integral is at most the limit: from there the loop settles as from any step.
    let back = currents[stop..].iter().rposition(|current| (current - 0.5).abs() > 0.5).unwrap();
    assert!(back < 20, "{back} periods to come back");
}

#[test]
fn forward_takes_the_back_emf_away() {
    let settings = settings(&[("motor.back_emf_forward", Value::Flag(true))]);
    let design = CurrentLoop::build(&settings, COUNTS).unwrap();
    // 8 N/A are 8 V·s/m: 0.5 m/s make 4 V of 24.
    assert_eq!(design.forward(0.5, 24_000), 500);
    assert_eq!(design.forward(-0.5, 24_000), -500);
    assert_eq!(design.forward(f32::NAN, 24_000), 0);
    let against = settings_with(&settings, "motor.reversed", Value::Flag(true));
    assert_eq!(CurrentLoop::build(&against, COUNTS).unwrap().forward(0.5, 24_000), -500);
    assert_eq!(CurrentLoop::build(&Settings::default(), COUNTS).unwrap().forward(9.0, 24_000), 0);
    // With nothing else to do, what goes forward comes out.
    let (gains, mut controller) = (design.gains(24_000), Controller::default());
    assert_eq!(controller.step(&gains, Duty::OFF, 0, 500), 500);
}

fn settings_with(settings: &Settings, key: &str, value: Value<'static>) -> Settings {
    let mut changed = *settings;
    changed.set(key, value).unwrap();
    changed
}

/// K_p = ω_c·L and K_i·T = ω_c·R·T in counts, by hand: 5 A/32767 · 3000/24 V · 2²⁰.
#[test]
fn gains_are_the_winding_times_the_crossover_and_follow_the_supply() {
    let design = CurrentLoop::build(&motor(1000.0), COUNTS).unwrap();
    let gains = design.gains(24_000);
    let unit = 5.0 / 32767.0 * 125.0 * 1_048_576.0;
    let near = |code: i32, exact: f64| (f64::from(code) - exact).abs() <= 1.0;
    assert!(near(gains.proportional, TAU * 1000.0 * 0.0005 * unit), "{gains:?}");
    assert!(near(gains.integral, TAU * 1000.0 * 1.5 * 50e-6 * unit), "{gains:?}");
    assert_eq!((gains.limit, gains.most), (2850, 31128));
    let half = design.gains(48_000);
    assert!((half.proportional * 2 - gains.proportional).abs() <= 2);
    assert_eq!(design.gains(0), design.gains(6_000));
    assert_eq!(design.gains(u32::MAX), design.gains(60_000));
}

#[test]
fn a_sensor_reads_its_range() {
    let sensor = Sensor::build(&Settings::default(), 12);
    assert_eq!(sensor.codes(2048), 0);
    // 6.875 A of 5 A full scale at the ends.
    assert!((sensor.codes(0) + 45055).abs() <= 1, "{}", sensor.codes(0));
    assert!((sensor.codes(2048 + 1024) - 22527).abs() <= 1);
    let mut measured = sensor;
    measured.zero = 2050;
    assert_eq!(measured.codes(2050), 0);
    let widest = settings(&[("motor.sense_a", number(1000.0)), ("motor.full_scale_a", number(0.001))]);
    assert_eq!(Sensor::build(&widest, 8).codes(u16::MAX), i32::MAX);
}

fn refused(changes: &[(&str, Value<'static>)]) -> String {
    CurrentLoop::build(&settings(changes), COUNTS).unwrap_err().to_string()
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    assert!(
        refused(&[("motor.inductance_h", number(10.0))])
            .starts_with("motor.inductance_h = 10 is not allowed: it must be a number from")
    );
    assert!(
        refused(&[("motor.resistance_ohm", number(0.001))]).starts_with("motor.resistance_ohm = 0.001 is not allowed")
    );
    let short = refused(&[("motor.sense_a", number(5.0))]);
    assert!(short.starts_with("motor.sense_a = 5 is not allowed: it must be a number from 6.07"), "{short}");
    let uneven = refused(&[("timing.control_period_s", number(0.00033))]);
    assert_eq!(
        uneven,
        "timing.control_period_s = 0.00033 is not allowed: it must be with a current loop a whole number of PWM periods of 0.00005 s"
    );
    assert_eq!(periods_per_tick(&Settings::default()), Ok(20));
}

proptest! {
    /// Neither limit is passed, and nothing overflows (tests run with overflow checks), whatever the loop is commanded.
    #[test]
    fn the_limits_hold_whatever_comes_in(
        (r, l, hz, full) in (0.0..=1.0_f64, 0.0..=1.0_f64, 50.0..=2000.0_f64, -3.0..=3.0_f64),
        counts in 1..=u16::MAX,
        supply in any::<u32>(),
        course in prop::collection::vec((any::<i16>(), any::<i32>(), any::<i32>()), 1..200),
    ) {
        let full = 10.0_f64.powf(full);
        let settings = settings(&[
            ("motor.resistance_ohm", number(10.0_f64.powf(-3.0 + 7.0 * r))),
            ("motor.inductance_h", number(10.0_f64.powf(-6.0 + 7.0 * l).min(10.0))),
            ("motor.current_loop_hz", number(hz)),
            ("motor.full_scale_a", number(full)),
            ("motor.sense_a", number((2.0 * full).min(1000.0))),
        ]);
        let Ok(design) = CurrentLoop::build(&settings, counts) else { return Ok(()) };
        let gains = design.gains(supply);
        prop_assert!(gains.proportional >= 49 && gains.integral >= 49, "{gains:?}");
        let mut controller = Controller::default();
        for (reference, measured, forward) in course {
            let given = controller.step(&gains, Duty(reference), measured, forward);
            prop_assert!(given.abs() <= gains.limit && f64::from(given.abs()) <= 0.95 * f64::from(counts));
            // A reference beyond the largest is the largest.
            let (mut one, mut other) = (controller, controller);
            let held = reference.clamp(-gains.most as i16, gains.most as i16);
            prop_assert_eq!(one.step(&gains, Duty(reference), 0, 0), other.step(&gains, Duty(held), 0, 0));
        }
    }

    /// The same for gains that no settings give.
    #[test]
    fn gains_from_elsewhere_do_no_harm(
        proportional in 0..=i32::MAX, integral in 0..=i32::MAX, limit in 0..=65535, most in 0..=32767,
        course in prop::collection::vec((any::<i16>(), any::<i32>(), any::<i32>()), 1..200),
    ) {
        let (gains, mut controller) = (Gains { proportional, integral, limit, most }, Controller::default());
        for (reference, measured, forward) in course {
            prop_assert!(controller.step(&gains, Duty(reference), measured, forward).abs() <= limit);
        }
    }
}

/// −τ·ln(1 − (continuous/i)²): 2 A and 30 s, cold.
#[test]
fn a_winding_is_too_warm_when_it_says() {
    let thermal = Thermal::<f32>::build(&Settings::default(), 1e-3);
    for (amperes, after_s) in
        [(4.0, Some(30.0 * -(0.75_f64).ln())), (2.1, Some(30.0 * -(1.0 - (2.0 / 2.1_f64).powi(2)).ln())), (1.99, None)]
    {
        let mut heat = Heat::default();
        let found = (1..400_000).find(|_| thermal.is_too_warm(&mut heat, amperes));
        match (found, after_s) {
            (Some(ticks), Some(exact)) => {
                let seconds = 1e-3 * f64::from(ticks);
                assert!((seconds - exact).abs() < 0.02 * exact, "{amperes} A: {seconds} s, {exact} s");
            }
            (found, expected) => assert_eq!(found.is_some(), expected.is_some(), "{amperes} A"),
        }
    }
}

/// Warmth is kept through a pause: half of what there was after τ·ln 2.
#[test]
fn a_pause_forgives_no_sooner_than_the_winding_cools() {
    let thermal = Thermal::<f64>::build(&Settings::default(), 1e-3);
    let mut heat = Heat::default();
    while !thermal.is_too_warm(&mut heat, 4.0) {}
    let hot = heat;
    for _ in 0..(30_000.0 * 2.0_f64.ln()) as u32 {
        thermal.is_too_warm(&mut heat, 0.0);
    }
    let again = (1..).find(|_| thermal.is_too_warm(&mut heat, 4.0)).unwrap();
    // From half of 4 A² to 4 A², toward 16 A².
    let exact = 30.0 * (14.0 / 12.0_f64).ln();
    assert!((1e-3 * f64::from(again) - exact).abs() < 0.02 * exact, "{again} {exact} {hot:?}");
}

/// What the divider of a thermistor of 10 kΩ and this B (K) reads at a temperature, °C, below 10 kΩ.
fn divided(b_k: f64, celsius: f64) -> u16 {
    let ohms = 10e3 * (b_k / (celsius + 273.15) - b_k / (25.0 + 273.15)).exp();
    (65536.0 * ohms / (ohms + 10e3)).round() as u16
}

#[test]
fn a_thermistor_shows_from_where_the_force_falls_to_the_limit() {
    let mut settings = Settings::default();
    assert_eq!(Thermistor::build(&settings), None);
    settings.motor.thermistor = true;
    // The example of docs/reference/board.md.
    assert_eq!(Thermistor::build(&settings).unwrap().code(divided(3950.0, 65.0)), 64 - 30);
    for (b_k, most_c) in [(3950.0, 80.0), (2500.0, 40.0), (2500.0, 125.0), (4500.0, 40.0), (4500.0, 125.0)] {
        (settings.motor.thermistor_b_k, settings.motor.max_temperature_c) = (b_k, most_c);
        let thermistor = Thermistor::build(&settings).unwrap();
        let at = |celsius: f64| thermistor.code(divided(b_k, celsius));
        let near_c = 0.5 * (25.0 + most_c);
        assert_eq!([-39.0, 25.0, near_c].map(at), [0; 3], "{b_k} K, {most_c} °C");
        assert_eq!([most_c + 0.02, most_c + 5.0].map(at), [HOT; 2], "{b_k} K, {most_c} °C");
        // A step is at most a 62nd of twice the way: the curve is steeper where it is cooler.
        let step_c = 2.0 * (most_c - near_c) / f64::from(HOT);
        let codes: Vec<u8> = (0..=1000).map(|part| at(near_c + 1e-3 * f64::from(part) * (most_c - near_c))).collect();
        assert!(codes.is_sorted() && at(near_c + step_c) >= 1 && at(most_c - 2.0 * step_c) < HOT, "{codes:?}");
        assert_eq!([0, 1023, 64_512, 65_535].map(|read| thermistor.code(read)), [HOT + 1; 4]);
        assert_eq!([1024, 64_511].map(|read| thermistor.code(read)), [HOT, 0]);
    }
}
