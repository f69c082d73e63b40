//! What a power stage tells: every fault that comes of it, and when, against closed forms.

use cohold_core::device::encoder::Counts;
use cohold_core::device::motor::Duty;
use cohold_core::device::probe::{Probe, Request, Shape};
use cohold_core::device::stage::{Flow, Measured};
use cohold_core::device::thermal;
use cohold_core::device::velocity::VelocityName;
use cohold_core::device::{AXES, Reading};
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::Settings;

use super::Bench;

/// R (Ω) and k (N/A) of the default motor, and its codes per ampere.
const OHM: f64 = 4.8;
const EMF: f64 = 8.0;
const CODES: f64 = 32767.0 / 5.0;
/// The second motor is asked for 18 N, 2.25 A.
const ASKED: i16 = (18.0 / EMF * CODES + 0.5) as i16;
const SUPPLY: (f64, u16) = (24.0, 30_000);

/// A peer and a device whose first axis moves and feels nothing, and whose second is held 12 mm off its line.
struct Rig<S: Scalar> {
    bench: Bench<S>,
    tick: u32,
    speed: f64,
    duties: [Duty; AXES],
}

/// What a good stage and good encoders say.
struct True {
    counts: [f64; AXES],
    measured: Measured,
}

impl True {
    /// The second motor carries this part of what it is asked for.
    fn second(&mut self, part: f64) {
        let flow = &mut self.measured.motors[1];
        for code in [&mut flow.mean, &mut flow.last] {
            *code = (f64::from(*code) * part).round() as i16;
        }
    }
}

fn settings() -> Settings {
    let mut settings = Settings::default();
    settings.axis.count = 2;
    settings.axis.velocity = VelocityName::Difference;
    settings.axis.hold_damping_n_s_per_m = 0.0;
    settings.contact.stiffness_n_per_m = 0.0;
    settings.contact.damping_n_s_per_m = 0.0;
    settings.coordination.comm = "none";
    settings.safety.max_slew_n_per_s = 1e6;
    settings.safety.stuck_duty = 0.5;
    settings
}

impl<S: Scalar> Rig<S> {
    fn new(settings: &Settings, speed: f64) -> Self {
        let device = [Motion::REST, Motion::at(S::from_f64(-0.012))];
        let bench = Bench { peer: Peer::new(settings, device).expect("good settings") };
        Self { bench, tick: 0, speed, duties: [Duty::OFF; AXES] }
    }

    /// Armed, with a hundred good ticks behind it.
    fn armed(settings: &Settings, speed: f64) -> Self {
        let mut rig = Self::new(settings, speed);
        assert_eq!(rig.run(10, |_| {}), None);
        rig.bench.command(Command::Arm);
        assert_eq!(rig.run(100, |_| {}), None, "{}: {:?} at {speed} m/s", S::NAME, rig.bench.peer.mode());
        assert_eq!(rig.duties[1], Duty(ASKED));
        rig
    }

    /// Ticks until a fault latches, of so many, with what `spoil` makes of the truth.
    fn run(&mut self, most: u32, mut spoil: impl FnMut(&mut True)) -> Option<(u32, Fault)> {
        (1..=most).find_map(|ticks| {
            let speeds = [self.speed, 0.0];
            let flow = |axis: usize| {
                let code = self.duties[axis].0;
                let volts = OHM * f64::from(code) / CODES + EMF * speeds[axis];
                Flow { mean: code, last: code, voltage: (volts / SUPPLY.0 * f64::from(SUPPLY.1)).round() as i16 }
            };
            let measured =
                Measured { motors: [flow(0), flow(1)], supply_mv: 24_000, supply_counts: SUPPLY.1, thermistor: 0 };
            let mut truth = True { counts: [200.0 * self.speed * f64::from(self.tick), 0.0], measured };
            self.tick += 1;
            spoil(&mut truth);
            let reading = Reading::Counts(truth.counts.map(|counts| Counts(counts.round() as i64 as u16)));
            let stage = Some(truth.measured);
            self.duties = self.bench.peer.tick(&Sensors { stage, ..Sensors::of(reading) }).duties;
            match self.bench.peer.mode() {
                Mode::Faulted(fault) => Some((ticks, fault)),
                _ => None,
            }
        })
    }
}

/// Ticks until a leaky mean over 8 ms, taken every second tick, of `what` passes what is tolerated now; more was `before`.
fn noticed_after(what: f64, now: f64, before: f64) -> Option<u32> {
    (1..200)
        .find(|pairs| {
            let left = 0.75_f64.powi(*pairs);
            what * (1.0 - left) > now + (before - now).max(0.0) * left
        })
        .map(|pairs| 2 * pairs as u32)
}

macro_rules! every_number {
    ($($(#[$doc:meta])* fn $name:ident<S: Scalar>() $body:block)+) => {$(
        $(#[$doc])*
        #[test]
        fn $name() {
            fn generic<S: Scalar>() $body
            generic::<f32>();
            generic::<f64>();
            generic::<Fixed>();
        }
    )+};
}

every_number! {
    /// 2.25 A where 1.2 A are borne for ever, over 1 s: from half of that mean square on the current falls, and the square stays below.
    /// Warmth is not forgotten by arming.
    fn a_motor_gives_way_before_it_is_too_warm<S: Scalar>() {
        let mut settings = settings();
        (settings.motor.thermal_s, settings.motor.continuous_a) = (1.0, 1.2);
        let mut rig = Rig::<S>::armed(&settings, 0.0);
        let amperes = |rig: &Rig<S>| f64::from(rig.duties[1].0) / CODES;
        let asked = amperes(&rig);
        // The hundred ticks before, too.
        let mut mean = asked.powi(2) * (1.0 - (-0.1_f64).exp());
        let (mut full_until, mut most) = (None, mean);
        for tick in 100..12_000 {
            assert_eq!(rig.run(1, |_| {}), None, "{} in tick {tick}", S::NAME);
            mean += (amperes(&rig).powi(2) - mean) * 1e-3;
            most = most.max(mean);
            if amperes(&rig) < asked {
                full_until.get_or_insert(tick);
            }
        }
        // Twice what is left to the limit, of the whole force, and that of 0.9·1.2 A, are less than what is asked for.
        let force_n = |amperes: f64| amperes * settings.motor.newton_or_newton_metre_per_a;
        let share = 1.0 - 0.5 * force_n(asked - 1.08) / settings.safety.max_force_n;
        let exact = -1e3 * (1.0 - share * (1.2 / asked).powi(2)).ln();
        let full_until = f64::from(full_until.expect("it falls"));
        assert!((full_until - exact).abs() < 8.0, "{}: {full_until} {exact}", S::NAME);
        let last = amperes(&rig);
        assert!(most < 1.44 && (1.08..1.2).contains(&last), "{}: {most} A², at last {last} A", S::NAME);
        rig.bench.command(Command::Disarm);
        rig.bench.command(Command::Arm);
        assert_eq!(rig.run(20, |_| {}), None);
        assert!(amperes(&rig) < 1.3, "{} A", amperes(&rig));
        // Cool again after a while.
        rig.bench.command(Command::Disarm);
        assert_eq!(rig.run(3000, |_| {}), None);
        rig.bench.command(Command::Arm);
        assert_eq!(rig.run(100, |_| {}), None);
        assert_eq!(amperes(&rig), asked);
    }

    /// A motor that carries a seventh more than it is asked for, which no other watch sees.
    fn a_motor_that_carries_more_is_too_warm<S: Scalar>() {
        let mut settings = settings();
        (settings.motor.thermal_s, settings.motor.continuous_a) = (1.0, 1.2);
        let mut rig = Rig::<S>::armed(&settings, 0.0);
        let fault = rig.run(20_000, |truth| {
            for flow in &mut truth.measured.motors {
                let more = |code: i16| (8 * i32::from(code) / 7) as i16;
                *flow = Flow { mean: more(flow.mean), last: more(flow.last), ..*flow };
            }
        });
        assert!(fault.is_some_and(|(_, fault)| fault == Fault::MotorTooWarm), "{}: {fault:?}", S::NAME);
    }

    /// A thermistor takes force away, a 64th for each code; at 62, 10 ms long, the motor is too warm. One that is open or shorted stops the
    /// motors after 10 ms.
    fn a_thermistor_takes_force_away<S: Scalar>() {
        let shows = |code: u8| move |truth: &mut True| truth.measured.thermistor = code;
        let settings = settings();
        let full = settings.safety.max_force_n / settings.motor.newton_or_newton_metre_per_a * CODES;
        let mut rig = Rig::<S>::armed(&settings, 0.0);
        for code in 1..thermal::HOT {
            assert_eq!(rig.run(20, shows(code)), None, "{}: {code}", S::NAME);
            let left = full * (1.0 - f64::from(code) / 64.0);
            let given = f64::from(rig.duties[1].0);
            assert!((given - left.min(ASKED.into())).abs() < 8.0, "{}: {code}: {given}, {left}", S::NAME);
        }
        assert_eq!(rig.run(100, shows(thermal::HOT)), Some((10, Fault::MotorTooWarm)), "{}", S::NAME);
        let mut rig = Rig::<S>::armed(&settings, 0.0);
        assert_eq!(rig.run(9, shows(63)), None);
        assert!(f64::from(rig.duties[1].0) < full / 63.0);
        assert_eq!(rig.run(10, shows(63)), Some((1, Fault::Thermistor)), "{}", S::NAME);
        // Nor does it arm again.
        rig.bench.command(Command::Clear);
        assert_eq!(rig.run(10, shows(63)), Some((10, Fault::Thermistor)), "{}", S::NAME);
        rig.bench.command(Command::Clear);
        assert_eq!(rig.run(40, shows(0)), None);
        rig.bench.command(Command::Arm);
        assert_eq!(rig.run(100, shows(0)), None);
        assert_eq!(rig.duties[1], Duty(ASKED));
    }

    /// Tolerated are 2 % of 5.5 A, 0.11 A, and an eighth of 2.25 A: 0.391 A.
    fn a_current_that_does_not_follow<S: Scalar>() {
        let lost = |part: f64, volts: f64| {
            let mut rig = Rig::<S>::armed(&settings(), 0.0);
            rig.run(200, |truth| {
                truth.second(part);
                truth.measured.motors[1].voltage = (volts / SUPPLY.0 * f64::from(SUPPLY.1)).round() as i16;
            })
        };
        for part in [0.0, 0.5, 0.7, 2.0] {
            // With as much voltage as that takes there is nothing but the current to tell.
            let exact = noticed_after((1.0 - part).abs() * 2.25, 0.39125, 0.0).map(|ticks| (ticks, Fault::CurrentNotFollowed));
            assert_eq!(lost(part, part * 2.25 * OHM), exact, "{}: {part}", S::NAME);
        }
        assert_eq!(lost(0.84, 0.84 * 2.25 * OHM), None, "{}", S::NAME);
        // An open motor at the limit of the voltage: 22.8 V for nothing, of which 0.62 V and what was tolerated of 2.25 A before are.
        assert_eq!(lost(0.0, 22.8), Some((2, Fault::CurrentNotFollowed)), "{}", S::NAME);
    }

    /// Two ticks that end at the end of its range; while the motors are off, 10 ms off zero.
    fn a_sensor_that_cannot_be<S: Scalar>() {
        // 5 A are all that the numbers hold.
        let at_end = |truth: &mut True| (truth.measured.motors[0].last, truth.measured.motors[0].mean) = (-32767, -32767);
        let mut rig = Rig::<S>::armed(&settings(), 0.0);
        assert_eq!(rig.run(9, at_end), Some((2, Fault::CurrentSensor)), "{}", S::NAME);

        // 4 % of 6.875 A are 1802 codes.
        let off = |codes: i16| move |truth: &mut True| truth.measured.motors[1].mean = codes;
        for (codes, found) in [(1803, Some((10, Fault::CurrentSensor))), (-1803, Some((10, Fault::CurrentSensor))), (1801, None)] {
            let mut rig = Rig::<S>::new(&settings(), 0.0);
            assert_eq!(rig.run(40, off(codes)), found, "{}: {codes}", S::NAME);
            rig.bench.command(Command::Arm);
            let mode = if found.is_some() { Mode::Faulted(Fault::CurrentSensor) } else { Mode::Armed };
            assert_eq!(rig.bench.peer.mode(), mode);
            rig.bench.command(Command::Clear);
            assert!(found.is_none() || rig.run(40, off(codes)) == found, "again");
        }
    }

    /// 18 V to 30 V; 10 ms of less or more while armed; disarmed it only keeps the motors off.
    fn a_supply_out_of_range<S: Scalar>() {
        let supply = |mv: u16| move |truth: &mut True| truth.measured.supply_mv = mv;
        for (mv, found) in [(17_990, true), (18_010, false), (29_990, false), (30_010, true)] {
            // The voltage that flows stays what it is.
            let spoil = |truth: &mut True| {
                for flow in &mut truth.measured.motors {
                    flow.voltage = (f64::from(flow.voltage) * 24e3 / f64::from(mv)).round() as i16;
                }
                supply(mv)(truth);
            };
            let mut rig = Rig::<S>::armed(&settings(), 0.0);
            assert_eq!(rig.run(100, spoil), found.then_some((10, Fault::SupplyOutOfRange)), "{}: {mv} mV", S::NAME);

            let mut rig = Rig::<S>::new(&settings(), 0.0);
            assert_eq!(rig.run(100, spoil), None, "disarmed");
            rig.bench.command(Command::Arm);
            let refused = Mode::Faulted(Fault::SupplyOutOfRange);
            assert_eq!(rig.bench.peer.mode(), if found { refused } else { Mode::Armed }, "{}: {mv} mV", S::NAME);
            rig.bench.command(Command::Clear);
            rig.bench.peer.probe(probe(&settings()));
            assert_eq!(rig.bench.peer.mode() == refused, found);
            // Switched on, it takes two ticks to be seen.
            rig.bench.command(Command::Clear);
            assert_eq!(rig.run(2, |_| {}), None);
            rig.bench.command(Command::Arm);
            assert_eq!(rig.run(100, |_| {}), None, "{}: {mv} mV", S::NAME);
        }
    }

    /// k·v beside what is tolerated: 0.6 V, one count in 2 ms (0.02 V), an eighth of what the encoder shows.
    fn an_encoder_that_says_another_speed<S: Scalar>() {
        let reads = |speed: f64, scale: f64| {
            let mut rig = Rig::<S>::armed(&settings(), speed);
            let from = 200.0 * speed * f64::from(rig.tick - 1);
            rig.run(400, |truth| truth.counts[0] = from + scale * (truth.counts[0] - from))
        };
        for speed in [0.2, -0.5, 0.1] {
            let volts = EMF * f64::abs(speed);
            for (what, scale) in [("stuck", 0.0), ("reversed", -1.0), ("half", 0.5), ("double", 2.0), ("three", 3.0)] {
                let now = 0.62 + 0.125 * scale.abs() * volts;
                let exact = noticed_after((1.0 - scale).abs() * volts, now, 0.62 + 0.125 * volts);
                let exact = exact.map(|ticks| (ticks, Fault::EncoderImplausible));
                assert_eq!(reads(speed, scale), exact, "{}: {what} at {speed} m/s", S::NAME);
            }
            assert_eq!(reads(speed, 0.9), None, "{}: {speed} m/s, within tolerance", S::NAME);
        }
        // Below 0.62 V nothing is reported, and at rest nothing can be.
        assert_eq!(reads(0.07, 0.0), None, "{}", S::NAME);
    }

    /// Motor and encoder each either way round: the speeds agree, as long as the settings say so.
    fn either_way_round<S: Scalar>() {
        for (motor, encoder) in [(false, true), (true, false), (true, true)] {
            let mut settings = settings();
            (settings.motor.reversed, settings.encoder.reversed) = (motor, encoder);
            let turned = |truth: &mut True| {
                if encoder {
                    truth.counts[0] = -truth.counts[0];
                }
                if motor {
                    let Flow { voltage, .. } = &mut truth.measured.motors[0];
                    *voltage = -*voltage;
                }
            };
            let mut rig = Rig::<S>::new(&settings, 0.3);
            assert_eq!(rig.run(10, turned), None);
            rig.bench.command(Command::Arm);
            assert_eq!(rig.run(100, turned), None, "{}: {motor} {encoder}", S::NAME);
            if !encoder {
                assert_eq!(rig.run(20, |_| {}), Some((2, Fault::EncoderImplausible)), "{}: the other way round", S::NAME);
            }
        }
    }

    /// Copper that is 60 K warmer, iron that takes half of L, and a tenth of k: all of them are no fault.
    fn a_motor_that_is_not_quite_what_was_told<S: Scalar>() {
        for (ohms, emf) in [(1.25, 1.0), (0.76, 1.0), (1.0, 1.1), (1.24, 0.9)] {
            let mut rig = Rig::<S>::armed(&settings(), 0.6);
            let found = rig.run(400, |truth| {
                for (axis, flow) in truth.measured.motors.iter_mut().enumerate() {
                    let speed = if axis == 0 { 0.6 } else { 0.0 };
                    let volts = ohms * OHM * f64::from(flow.mean) / CODES + emf * EMF * speed;
                    flow.voltage = (volts / SUPPLY.0 * f64::from(SUPPLY.1)) as i16;
                }
            });
            assert_eq!(found, None, "{}: {ohms} {emf}", S::NAME);
        }
    }

    /// At the voltage's limit and 3.15 m/s 0.5 A are missing: no fault, for the encoder says where the voltage goes. Below the limit it is.
    fn a_supply_at_its_end_is_no_fault<S: Scalar>() {
        for (volts, found) in [(22.8, None), (18.0, Some(Fault::CurrentNotFollowed))] {
            let mut rig = Rig::<S>::armed(&settings(), (volts + 0.5 * OHM) / EMF);
            let noticed = rig.run(400, |truth| {
                let flow = &mut truth.measured.motors[0];
                flow.mean = (-0.5 * CODES) as i16;
                flow.last = flow.mean;
                flow.voltage = (volts / SUPPLY.0 * f64::from(SUPPLY.1)) as i16;
            });
            assert_eq!(noticed.map(|(_, fault)| fault), found, "{}: {volts} V", S::NAME);
        }
    }

    /// Bridges wake up for 2 ms: a current that does not come yet, or a voltage that does nothing, is none either.
    fn the_first_milliseconds_are_not_judged<S: Scalar>() {
        for late in [2, 4, 8] {
            let mut rig = Rig::<S>::new(&settings(), 0.5);
            assert_eq!(rig.run(10, |_| {}), None);
            rig.bench.command(Command::Arm);
            let mut ticks = 0;
            let found = rig.run(100, |truth| {
                ticks += 1;
                if ticks <= late {
                    truth.measured.motors = [Flow::default(); AXES];
                }
            });
            assert_eq!(found.is_some(), late > 4, "{}: {late} ms", S::NAME);
        }
    }
}

fn probe<S: Scalar>(settings: &Settings) -> Probe<S> {
    let request = Request { joint: 1, shape: Shape::Swing, duty: 0.05, duration_s: 0.04, frequency_hz: 0.0 };
    Probe::build(settings, &request).unwrap()
}

/// A probe finds out about signs and scales and watches its current by itself; the supply is the stage's all the same.
#[test]
fn a_probe_is_not_compared() {
    let mut settings = settings();
    settings.axis.count = 1;
    let started = || {
        let mut rig = Rig::<f64>::new(&settings, 0.1);
        assert_eq!(rig.run(10, |_| {}), None);
        rig.bench.peer.probe(probe(&settings));
        assert_eq!(rig.bench.peer.mode(), Mode::Probing);
        rig
    };
    assert_eq!(started().run(100, |truth| truth.counts[0] *= -0.2), None);
    assert_eq!(started().run(100, |truth| truth.measured.motors[0].voltage = 9999), None);
    assert_eq!(started().run(100, |truth| truth.measured.supply_mv = 5000), Some((10, Fault::SupplyOutOfRange)));
}

/// What joints that are not in use measure is nobody's.
#[test]
fn a_motor_that_is_not_there() {
    let mut settings = settings();
    settings.axis.count = 1;
    let mut rig = Rig::<f32>::new(&settings, 0.2);
    let nonsense = |truth: &mut True| truth.measured.motors[1] = Flow { mean: 9999, last: 32767, voltage: -3 };
    assert_eq!(rig.run(100, nonsense), None);
    rig.bench.command(Command::Arm);
    assert_eq!(rig.run(100, nonsense), None);
}
