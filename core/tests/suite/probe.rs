//! Probes against a device of two lines (mass, damping, dry friction, counts): limits hold, signs are found, hands are noticed.

use cohold_core::device::encoder::Counts;
use cohold_core::device::motor::Duty;
use cohold_core::device::probe::{End, Outcome, Probe, Request, Shape, Verdict};
use cohold_core::device::{AXES, Reading};
use cohold_core::law::AnyLaw;
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

/// A slide with its own idea of which way motor and encoder go.
struct Device {
    mass_kg: f64,
    damping_n_s_per_m: f64,
    dry_n: f64,
    hand_n: f64,
    /// Duties that have not become force yet.
    on_the_way: Vec<i16>,
    motor: f64,
    encoder: f64,
    position_m: f64,
    speed_m_per_s: f64,
}

impl Device {
    fn new(motor: f64, encoder: f64) -> Self {
        let (mass_kg, damping_n_s_per_m) = (0.1, 0.5);
        Self {
            mass_kg,
            damping_n_s_per_m,
            dry_n: 0.05,
            hand_n: 0.0,
            on_the_way: Vec::new(),
            motor,
            encoder,
            position_m: 0.0,
            speed_m_per_s: 0.0,
        }
    }

    fn counts(&self) -> Counts {
        Counts((self.encoder * self.position_m * 200_000.0).round() as i64 as u16)
    }

    /// A millisecond in ten steps; 40 N at full duty.
    fn step(&mut self, Duty(duty): Duty) {
        self.on_the_way.insert(0, duty);
        let duty = self.on_the_way.pop().unwrap_or(0);
        let push = self.motor * 40.0 * f64::from(duty) / 32767.0 + self.hand_n;
        for _ in 0..10 {
            let viscous = self.damping_n_s_per_m * self.speed_m_per_s;
            let mut speed = self.speed_m_per_s + 1e-4 * (push - viscous) / self.mass_kg;
            let brake = 1e-4 * self.dry_n / self.mass_kg;
            speed -= speed.clamp(-brake, brake);
            self.position_m += 1e-4 * speed;
            self.speed_m_per_s = speed;
        }
    }
}

struct Run {
    outcome: Outcome,
    mode: Mode,
    ticks: u32,
    largest_duty: i16,
    farthest_counts: i32,
}

fn run(settings: &Settings, probe: Probe<f32>, device: &mut Device, mut each: impl FnMut(u32, &mut Device)) -> Run {
    let mut peer = Peer::<f32, AnyLaw<f32>>::new(settings, [Motion::REST; AXES]).expect("a good scene");
    peer.probe(probe);
    assert_eq!((peer.mode(), peer.probed().end), (Mode::Probing, End::Running));
    let (mut ticks, mut largest_duty, mut farthest_counts) = (0, 0, 0);
    loop {
        each(ticks, device);
        let reading = Reading::Counts([device.counts(), Counts(0)]);
        let actuators = peer.tick(&Sensors::of(reading));
        assert_eq!(actuators.forces, [0.0; AXES]);
        farthest_counts = farthest_counts.max((device.position_m * 200_000.0).abs() as i32);
        if peer.mode() != Mode::Probing {
            assert_eq!(actuators, Actuators::default(), "motors are off in the tick that ends it");
            return Run { outcome: peer.probed(), mode: peer.mode(), ticks, largest_duty, farthest_counts };
        }
        let [Duty(duty), other] = actuators.duties;
        assert!(actuators.enable && other == Duty::OFF);
        largest_duty = largest_duty.max(duty.saturating_abs());
        device.step(Duty(duty));
        ticks += 1;
        assert!(ticks < 20_000);
    }
}

fn check(motor: f64, encoder: f64, change: impl Fn(&mut Settings), each: impl FnMut(u32, &mut Device)) -> Run {
    let mut settings = Settings::default();
    change(&mut settings);
    let probe = Probe::check(&settings, 1).expect("the defaults leave room for a check");
    run(&settings, probe, &mut Device::new(motor, encoder), each)
}

#[test]
fn signs_are_told_apart_whichever_is_wrong() {
    for (motor, encoder) in [(1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)] {
        for (motor_set, encoder_set) in [(false, false), (true, false), (false, true), (true, true)] {
            let set = |settings: &mut Settings| {
                (settings.motor.reversed, settings.encoder.reversed) = (motor_set, encoder_set);
            };
            let run = check(motor, encoder, set, |_, _| ());
            let sign = |reversed: bool| if reversed { -1.0 } else { 1.0 };
            let agree = motor * encoder * sign(motor_set) * sign(encoder_set) > 0.0;
            let expected = if agree { Verdict::Agree } else { Verdict::Disagree };
            assert_eq!((run.outcome.verdict(), run.outcome.end), (expected, End::Done), "{:?}", run.outcome);
            assert_eq!((run.ticks, run.mode), (40, Mode::Disarmed));
            // 2 % of 40 N on 0.1 kg for 10 ms and as long again to stop: at most 0.8 mm, and back.
            assert!(run.farthest_counts <= 160 && run.largest_duty == 655, "{} counts", run.farthest_counts);
        }
    }
}

/// The force follows the duty late: the work seems less, and a verdict is passed all the same, the right one.
#[test]
fn a_late_force_is_no_wrong_sign() {
    for late in 0..=2 {
        for (motor, expected) in [(1.0, Verdict::Agree), (-1.0, Verdict::Disagree)] {
            let delay = |tick: u32, device: &mut Device| {
                if tick == 0 {
                    device.on_the_way = vec![0; late];
                }
            };
            let run = check(motor, 1.0, |_| (), delay);
            assert_eq!(run.outcome.verdict(), expected, "{late} ticks late: {:?}", run.outcome);
        }
    }
}

#[test]
fn a_device_that_is_held_has_not_passed() {
    let run = check(1.0, 1.0, |_| (), |_, device| device.dry_n = 5.0);
    assert_eq!((run.outcome.verdict(), run.outcome.end), (Verdict::Still, End::Done));
    // Nor has one whose encoder is stuck.
    let run = check(1.0, 0.0, |_| (), |_, _| ());
    assert_eq!(run.outcome.verdict(), Verdict::Still);
}

/// A hand, however strong and whichever way, never makes signs that disagree pass, nor the other way round.
#[test]
fn a_hand_that_pushes_does_not_pass_for_the_motor() {
    for tenth in -200..=200 {
        let hand_n = 0.1 * f64::from(tenth);
        for (motor, wrong) in [(1.0, Verdict::Disagree), (-1.0, Verdict::Agree)] {
            let run = check(motor, 1.0, |_| (), |_, device| device.hand_n = hand_n);
            assert_ne!(run.outcome.verdict(), wrong, "{hand_n} N, motor {motor}: {:?}", run.outcome);
            if hand_n.abs() > 1.0 {
                assert_eq!(run.outcome.verdict(), Verdict::Unclear, "{hand_n} N, motor {motor}: {:?}", run.outcome);
            }
        }
    }
}

/// Nor does a hand, or a slope, alone: with a motor that is dead, or weak and the wrong way round.
#[test]
fn a_light_steady_push_alone_is_no_verdict() {
    use Verdict::{Agree, Disagree};
    for (motor, wrong) in [(0.0, [Agree, Disagree]), (-0.05, [Agree; 2]), (0.05, [Disagree; 2])] {
        for step in -100..=100 {
            let hand_n = 0.002 * f64::from(step);
            let run = check(motor, 1.0, |_| (), |_, device| device.hand_n = hand_n);
            assert!(!wrong.contains(&run.outcome.verdict()), "{hand_n} N, motor {motor}: {:?}", run.outcome);
        }
    }
}

#[test]
fn a_check_too_short_to_tell_a_hand_is_refused() {
    let mut settings = Settings::default();
    assert!(Probe::<f32>::check(&settings, 1).is_ok());
    settings.timing.control_period_s = 0.0025;
    let refused = Probe::<f32>::check(&settings, 1).expect_err("16 ticks").to_string();
    assert!(refused.starts_with("probe.check_s = 0.04 is not allowed: it must be a number from 0.05"), "{refused}");
}

fn probe(settings: &Settings, shape: Shape, duty: f64, duration_s: f64) -> Probe<f32> {
    Probe::build(settings, &Request { joint: 1, shape, duty, duration_s, frequency_hz: 5.0 })
        .expect("within its limits")
}

#[test]
fn every_limit_turns_the_motor_off() {
    let mut settings = Settings::default();
    let run = run(&settings, probe(&settings, Shape::Pulse, 0.05, 3.0), &mut Device::new(1.0, 1.0), |_, _| ());
    assert_eq!((run.outcome.end, run.mode), (End::Travel, Mode::Disarmed));
    // 4000 counts, and what is covered until the tick that sees it, at less than 0.9 m/s.
    assert!((4000..4180).contains(&run.farthest_counts), "{}", run.farthest_counts);

    settings.probe.max_travel_counts = 30_000;
    settings.probe.max_speed_counts_per_s = 50_000.0;
    let run = self::run(&settings, probe(&settings, Shape::Pulse, 0.1, 3.0), &mut Device::new(1.0, 1.0), |_, _| ());
    assert_eq!((run.outcome.end, run.mode), (End::Speed, Mode::Disarmed));
    // 0.25 m/s at 40 m/s².
    assert!((6..10).contains(&run.ticks), "{}", run.ticks);

    let held = |_: u32, device: &mut Device| device.dry_n = 100.0;
    let run = self::run(&settings, probe(&settings, Shape::Ramp, 0.1, 3.0), &mut Device::new(1.0, 1.0), held);
    assert_eq!((run.outcome.end, run.ticks), (End::Done, 3000));
    assert!((3270..=3276).contains(&run.largest_duty), "{}", run.largest_duty);

    let thrown = |tick: u32, device: &mut Device| {
        if tick == 10 {
            device.position_m += 0.1;
        }
    };
    let run = self::run(&settings, probe(&settings, Shape::Sine, 0.01, 3.0), &mut Device::new(1.0, 1.0), thrown);
    assert_eq!((run.outcome.end, run.mode), (End::Stopped, Mode::Faulted(Fault::EncoderJump)));
}

/// A duty is rounded to a code, but not beyond the limit.
#[test]
fn the_largest_duty_is_not_exceeded_by_rounding() {
    let mut settings = Settings::default();
    for number in 0..500 {
        let most = 0.01 + 1e-5 * f64::from(number);
        settings.probe.max_duty = most;
        let pulse = probe(&settings, Shape::Pulse, -most, 0.004);
        let largest = f64::from(run(&settings, pulse, &mut Device::new(1.0, 1.0), |_, _| ()).largest_duty);
        assert!(largest <= most * 32767.0 && largest > most * 32767.0 - 1.0, "{largest} of {most}");
    }
}

#[test]
fn what_is_outside_the_limits_is_refused_by_name() {
    let settings = Settings::default();
    let good = Request { joint: 1, shape: Shape::Sine, duty: 0.1, duration_s: 3.0, frequency_hz: 5.0 };
    assert!(Probe::<f32>::build(&settings, &good).is_ok());
    for (request, said) in [
        (Request { joint: 2, ..good }, "joint = 2 is not allowed: it must be a number from 1 to 1"),
        (Request { joint: 0, ..good }, "joint = 0 "),
        (Request { duty: 0.11, ..good }, "duty = 0.11 is not allowed: it must be a number from -0.1 to 0.1"),
        (Request { duty: f64::NAN, ..good }, "duty = NaN "),
        (Request { duration_s: 3.5, ..good }, "duration = 3.5 is not allowed: it must be a number from 0.004 to 3 s"),
        (Request { duration_s: 0.0, ..good }, "duration = 0 "),
        (Request { frequency_hz: 0.0, ..good }, "frequency = 0 "),
    ] {
        let refused = Probe::<f32>::build(&settings, &request).expect_err(said).to_string();
        assert!(refused.starts_with(said), "{refused}");
    }
}

#[test]
fn a_probe_begins_only_disarmed_and_stops_by_command() {
    let settings = Settings::default();
    let mut peer = Peer::<f32, AnyLaw<f32>>::new(&settings, [Motion::REST; AXES]).expect("defaults");
    let still = Sensors::of(Reading::Counts([Counts(0), Counts(0)]));
    let pulse = probe(&settings, Shape::Pulse, 0.05, 1.0);
    peer.command(Command::Arm);
    peer.probe(pulse);
    assert_eq!((peer.mode(), peer.probed().end), (Mode::Armed, End::None));
    peer.command(Command::Disarm);
    peer.probe(pulse);
    assert!(peer.tick(&still).enable);
    peer.command(Command::Arm);
    assert_eq!(peer.mode(), Mode::Probing, "arming has to wait");
    peer.command(Command::Disarm);
    assert_eq!((peer.mode(), peer.probed().end), (Mode::Disarmed, End::Stopped));
    assert_eq!(peer.tick(&still), Actuators::default());
}
