//! The check before arming of a device with a current loop: a motor of three lines (R, k, an ideal loop) behind a bridge and a sensor
//! that may be broken, and what is reported of each.

use cohold_core::device::encoder::Counts;
use cohold_core::device::motor::Duty;
use cohold_core::device::probe::{End, Outcome, Probe, Request, Shape, Verdict};
use cohold_core::device::stage::{Flow, Measured};
use cohold_core::device::winding::{REST_STEPS, WAYS};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::AnyLaw;
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::safety::Mode;
use cohold_core::settings::Settings;

const SUPPLY_V: f64 = 24.0;
const SUPPLY_COUNTS: u16 = 3000;
const COUNTS_PER_M: f64 = 200_000.0;

/// A slide of 0.1 kg that nothing brakes, its motor, bridge and sensor.
#[derive(Clone, Copy)]
struct Device {
    resistance_ohm: f64,
    /// Of the winding while no loop is closed; a closed loop is ideal.
    inductance_h: f64,
    newton_per_a: f64,
    /// What the encoder counts of a metre, over what the settings say.
    scale: f64,
    /// What the sensor reads of a current: −1 is its two wires swapped, 0 a dead one.
    sensor: f64,
    obeys_enable: bool,
    /// The motor pushes against its encoder.
    against: f64,
    position_m: f64,
    speed_m_per_s: f64,
    /// What flows, and the most that flowed before a loop was closed, A.
    current_a: f64,
    most_open_a: f64,
    stage: Measured,
}

impl Default for Device {
    fn default() -> Self {
        Self {
            resistance_ohm: 4.8,
            inductance_h: 0.0,
            newton_per_a: 8.0,
            scale: 1.0,
            sensor: 1.0,
            obeys_enable: true,
            against: 1.0,
            position_m: 0.0,
            speed_m_per_s: 0.0,
            current_a: 0.0,
            most_open_a: 0.0,
            stage: Measured { supply_mv: 24_000, supply_counts: SUPPLY_COUNTS, ..Measured::default() },
        }
    }
}

impl Device {
    fn counts(&self) -> Counts {
        Counts((self.against * self.scale * self.position_m * COUNTS_PER_M).round() as i64 as u16)
    }

    /// A millisecond: the loop holds what its sensor reads to what is asked for, as far as the supply goes.
    fn step(&mut self, actuators: &Actuators<f32>) {
        let [Duty(duty), _] = actuators.duties;
        let share = f64::from(duty) / 32767.0;
        let (mut mean_a, mut mean_v) = (0.0, 0.0);
        for _ in 0..10 {
            let emf_v = self.newton_per_a * self.speed_m_per_s;
            let conducts = actuators.enable || !self.obeys_enable;
            let voltage = if actuators.open {
                share * SUPPLY_V
            } else if self.sensor > 0.0 {
                share * 5.0 / self.sensor * self.resistance_ohm + emf_v
            } else {
                // What is read goes the wrong way, or nowhere: all the voltage that there is.
                SUPPLY_V.copysign(share)
            };
            let rest_a = if conducts { (voltage - emf_v) / self.resistance_ohm } else { 0.0 };
            // Exact over a tenth of a millisecond in which the voltage stands: what is left of the difference.
            let left = if actuators.open { (-1e-4 * self.resistance_ohm / self.inductance_h).exp() } else { 0.0 };
            let before_a = self.current_a;
            self.current_a = rest_a + left * (before_a - rest_a);
            if actuators.open {
                self.most_open_a = self.most_open_a.max(self.current_a.abs());
            }
            let current_a = if left > 0.0 { 0.5 * (before_a + self.current_a) } else { rest_a };
            let acceleration = self.newton_per_a * current_a / 0.1;
            self.position_m += 1e-4 * (self.speed_m_per_s + 5e-5 * acceleration);
            self.speed_m_per_s += 1e-4 * acceleration;
            mean_a += 0.1 * current_a;
            mean_v += if actuators.enable { 0.1 * voltage } else { 0.0 };
        }
        let code = |current_a: f64| (self.sensor * current_a / 5.0 * 32767.0).clamp(-32767.0, 32767.0).round() as i16;
        let voltage = (mean_v / SUPPLY_V * f64::from(SUPPLY_COUNTS)).round() as i16;
        self.stage.motors[0] = Flow { mean: code(mean_a), last: code(self.current_a), voltage };
    }
}

/// Runs a probe; gives what came of it, how many ticks were with the enable low, open, and closed, and the most current that flowed, A.
fn run(settings: &Settings, probe: Probe<f32>, mut device: Device) -> (Outcome, [u32; 3], Device) {
    let mut peer = Peer::<f32, AnyLaw<f32>>::new(settings, [Motion::REST; AXES]).expect("a good scene");
    peer.probe(probe);
    let mut ticks = [0; 3];
    loop {
        let reading = Reading::Counts([device.counts(), Counts(0)]);
        let actuators = peer.tick(&Sensors { stage: Some(device.stage), ..Sensors::of(reading) });
        if peer.mode() != Mode::Probing {
            assert_eq!(actuators, Actuators::default(), "off in the tick that ends it");
            return (peer.probed(), ticks, device);
        }
        ticks[if !actuators.enable { 0 } else { 2 - usize::from(actuators.open) }] += 1;
        device.step(&actuators);
    }
}

fn check(device: Device) -> (Outcome, [u32; 3]) {
    let settings = Settings::default();
    let (outcome, ticks, _) = run(&settings, Probe::check(&settings, 1).expect("the defaults"), device);
    (outcome, ticks)
}

#[test]
fn a_device_as_the_settings_say_passes() {
    let (outcome, ticks) = check(Device::default());
    assert_eq!((outcome.verdict(), outcome.end), (Verdict::Agree, End::Done), "{outcome:?}");
    assert!(outcome.passed());
    // 12 with the enable low, 4 to wake and 16 open, then the swing.
    assert_eq!(ticks, [12, 20, 40]);
    let electric = outcome.electric.expect("it was measured");
    assert!((98..=102).contains(&electric.resistance_percent), "{electric:?}");
    assert!((97..=103).contains(&electric.constant_percent), "{electric:?}");
    // Warm copper, and a constant that was measured ten percent too high.
    let (outcome, _) = check(Device { resistance_ohm: 6.0, newton_per_a: 7.2, ..Device::default() });
    assert!(outcome.passed(), "{outcome:?}");
}

/// Windings of 0.3 to 20 Ω and 0.05 to 5 mH, time constants from 3 µs to 17 ms, that the settings know: each is seen to take current, and none
/// takes more than the check asks for and a tenth, 0.1 A, where the free device needs a millisecond to come to speed (R·m/k²); with the sensor the wrong way round each is refused.
#[test]
fn a_trial_gives_every_winding_the_checks_current_and_no_more() {
    let asked_a = Settings::default().probe.check_duty * Settings::default().motor.full_scale_a;
    for resistance_ohm in [0.3, 0.45, 1.0, 2.3, 5.0, 20.0] {
        for inductance_h in [0.05e-3, 0.2e-3, 0.45e-3, 1e-3, 2.3e-3, 5e-3] {
            let mut settings = Settings::default();
            (settings.motor.resistance_ohm, settings.motor.inductance_h) = (resistance_ohm, inductance_h);
            // m is 0.1 kg.
            let newton_per_a = (resistance_ohm * 0.1 / 1e-3).sqrt().min(8.0);
            let device = Device { resistance_ohm, inductance_h, newton_per_a, ..Device::default() };
            let what = format!("{resistance_ohm} ohm, {inductance_h} H");
            let probe = Probe::check(&settings, 1).expect("the defaults");
            let (outcome, [_, open, closed], after) = run(&settings, probe, device);
            assert!(open == 20 && closed > 0, "{what}: {outcome:?}");
            assert!(after.most_open_a <= 1.1 * asked_a, "{what}: {} A", after.most_open_a);
            let (outcome, [_, _, closed], _) = run(&settings, probe, Device { sensor: -1.0, ..device });
            assert_eq!((outcome.end, closed), (End::Sensor, 0), "{what}");
        }
    }
}

/// Each ends before the loop is closed, with the reason.
#[test]
fn what_a_loop_would_run_away_with_is_refused_before_it_is_closed() {
    for (name, device, end, expected) in [
        ("bridge", Device { obeys_enable: false, ..Device::default() }, End::Enable, [5..=12, 0..=0]),
        ("sensor", Device { sensor: -1.0, ..Device::default() }, End::Sensor, [12..=12, 20..=20]),
        ("dead sensor", Device { sensor: 0.0, ..Device::default() }, End::Open, [12..=12, 20..=20]),
        ("open", Device { resistance_ohm: 1e6, ..Device::default() }, End::Open, [12..=12, 20..=20]),
        (
            "short",
            Device { resistance_ohm: 0.05, newton_per_a: 0.0, ..Device::default() },
            End::Current,
            [12..=12, 5..=5],
        ),
    ] {
        let (outcome, [low, open, closed]) = check(device);
        assert_eq!((outcome.end, outcome.verdict()), (end, Verdict::Stage), "{name}: {outcome:?}");
        assert!(!outcome.passed(), "{name}");
        let [lows, opens] = expected;
        assert!(lows.contains(&low) && opens.contains(&open) && closed == 0, "{name}: {low} {open} {closed}");
    }
}

#[test]
fn a_hand_that_moves_it_before_the_bridge_is_enabled_has_not_passed() {
    let (outcome, _) = check(Device { speed_m_per_s: 0.01, ..Device::default() });
    assert_eq!((outcome.end, outcome.verdict()), (End::Enable, Verdict::Stage));
}

/// An encoder of another scale, or another motor: the signs agree, and it is not armed.
#[test]
fn what_does_not_fit_the_settings_is_refused() {
    for scale in [0.25, 0.5, 0.7, 1.5, 2.0] {
        let (outcome, _) = check(Device { scale, ..Device::default() });
        assert_eq!(outcome.verdict(), Verdict::Scale, "{scale}: {outcome:?}");
        let percent = f64::from(outcome.electric.expect("measured").constant_percent);
        // Volts a count: as many more as there are fewer counts.
        assert!((percent * scale - 100.0).abs() < 8.0, "{scale}: {percent}");
    }
    // So many counts that it seems to go too far.
    assert_eq!(check(Device { scale: 4.0, ..Device::default() }).0.verdict(), Verdict::Unclear);
    for resistance_ohm in [1.5, 20.0] {
        let (outcome, _) = check(Device { resistance_ohm, ..Device::default() });
        assert_eq!(outcome.verdict(), Verdict::Winding, "{resistance_ohm} Ω: {outcome:?}");
    }
    // The signs come first: nothing else is worth looking at before they agree.
    let (outcome, _) = check(Device { against: -1.0, resistance_ohm: 1.5, ..Device::default() });
    assert_eq!(outcome.verdict(), Verdict::Disagree);
}

/// Whichever signs are set: the constant is positive where motor and encoder agree.
#[test]
fn signs_of_the_settings_are_those_of_the_constant() {
    for (motor, encoder) in [(false, true), (true, false), (true, true)] {
        let mut settings = Settings::default();
        (settings.motor.reversed, settings.encoder.reversed) = (motor, encoder);
        let against = if motor == encoder { 1.0 } else { -1.0 };
        let device = Device { against, ..Device::default() };
        let (outcome, ..) = run(&settings, Probe::check(&settings, 1).expect("the defaults"), device);
        assert!(outcome.passed(), "{motor} {encoder}: {outcome:?}");
    }
}

#[test]
fn a_windings_probe_rests_and_then_alternates_without_drift() {
    assert_eq!(WAYS.iter().sum::<i32>(), 0);
    assert_eq!((1..).zip(WAYS).map(|(at, way): (i32, i32)| at * way).sum::<i32>(), 0);
    let settings = Settings::default();
    let request = Request { joint: 1, shape: Shape::Winding, duty: 0.1, duration_s: 0.68, frequency_hz: 0.0 };
    let probe = Probe::build(&settings, &request).expect("within the limits");
    let (outcome, ticks, device) = run(&settings, probe, Device { resistance_ohm: 48.0, ..Device::default() });
    assert_eq!((outcome.end, outcome.electric), (End::Done, None));
    assert_eq!(ticks, [0, REST_STEPS + 640, 0], "no loop is closed");
    assert!(device.position_m.abs() < 2e-5, "{} m", device.position_m);
    // Nothing measures, nothing is reported: it does not push at all.
    let mut peer = Peer::<f32, AnyLaw<f32>>::new(&settings, [Motion::REST; AXES]).expect("a good scene");
    peer.probe(probe);
    let still = Sensors::of(Reading::Counts([Counts(0); AXES]));
    assert_eq!(peer.tick(&still), Actuators::default());
    assert_eq!(peer.probed().end, End::Unmeasured);
}

/// Any other probe closes the loop at once; a sensor of the wrong sign ends it in the tick that sees it.
#[test]
fn a_current_that_runs_away_ends_any_probe() {
    let settings = Settings::default();
    let request = Request { joint: 1, shape: Shape::Pulse, duty: 0.05, duration_s: 1.0, frequency_hz: 0.0 };
    let probe = Probe::build(&settings, &request).expect("within the limits");
    let (outcome, ticks, _) = run(&settings, probe, Device { sensor: -1.0, ..Device::default() });
    assert_eq!((outcome.end, ticks), (End::Current, [0, 0, 1]));
}
