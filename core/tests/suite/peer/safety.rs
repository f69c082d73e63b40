//! Every fault turns the motors off in the tick that sees it, latches, and takes commands to leave.

use cohold_core::device::encoder::Counts;
use cohold_core::device::velocity::VelocityName;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::Packet;
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::{Choice, Settings};

type Bench = super::Bench<f32>;

impl Bench {
    #[track_caller]
    fn assert_stopped(&mut self, last: Actuators<f32>, fault: Fault) {
        assert_eq!(last, Actuators::default(), "motors are off in the same tick");
        assert_eq!(self.peer.mode(), Mode::Faulted(fault));
        // Neither time nor arming leaves a fault; clearing does, and leaves the motors off.
        self.command(Command::Arm);
        self.command(Command::Disarm);
        assert_eq!(self.peer.mode(), Mode::Faulted(fault));
        self.command(Command::Clear);
        assert_eq!(self.peer.mode(), Mode::Disarmed);
        assert_eq!(self.at(0.0, 0.0), Actuators::default());
        // Re-armed, the peer starts from no force at all.
        self.command(Command::Arm);
        let after = self.at(0.0, 0.0);
        assert!(after.enable && after.forces == [0.0; AXES], "{after:?}");
    }
}

/// A push that gives a force: the bench is not vacuously quiet.
#[test]
fn an_armed_peer_pushes_back() {
    let mut bench = Bench::armed(&Settings::default());
    let pushed = bench.at(0.001, 0.0);
    assert!(pushed.enable);
    assert_eq!(pushed.forces, [-1.0, 0.0], "K_LC times 1 mm");
    assert!(pushed.duties[0].0 < 0);
}

#[test]
fn a_disarmed_peer_is_silent() {
    let mut bench = Bench::at_rest(&Settings::default(), Motion::REST);
    assert_eq!(bench.at(0.01, 0.0), Actuators::default());
}

#[test]
fn a_reading_that_is_no_number() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut bench = Bench::armed(&Settings::default());
        bench.at(0.001, 0.0);
        let last = bench.at(bad, 0.0);
        bench.assert_stopped(last, Fault::NonFiniteInput);
    }
}

/// A jump so far that its speed is no number: the estimators remember it, and clearing must make them forget.
#[test]
fn a_reading_whose_velocity_is_no_number() {
    for velocity in VelocityName::ALL {
        let mut settings = Settings::default();
        settings.axis.velocity = *velocity;
        let mut bench = Bench::armed(&settings);
        let last = bench.at(3e38, f32::MAX);
        let fault = if *velocity == VelocityName::Measured { Fault::Overspeed } else { Fault::NonFiniteInput };
        bench.assert_stopped(last, fault);
    }
}

#[test]
fn a_packet_that_is_no_number() {
    let mut bench = Bench::armed(&Settings::default());
    let packet = Packet { wave: f32::NAN, ..Packet::default() };
    bench.peer.hear(&[packet]);
    bench.peer.exchange();
    let last = bench.at(0.001, 0.0);
    bench.assert_stopped(last, Fault::NonFiniteInput);
}

#[test]
fn an_encoder_that_jumps() {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    let mut bench = Bench::armed(&settings);
    bench.read(Reading::Counts([Counts(0), Counts(0)]));
    bench.read(Reading::Counts([Counts(65_000), Counts(0)]));
    let last = bench.read(Reading::Counts([Counts(30_000), Counts(0)]));
    assert_eq!(last, Actuators::default());
    assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::EncoderJump));
    // A lasting offset must not lock the peer for ever: clearing takes it as where the joint was.
    bench.command(Command::Clear);
    bench.command(Command::Arm);
    assert!(bench.read(Reading::Counts([Counts(30_000), Counts(0)])).enable);
    assert_eq!(bench.peer.mode(), Mode::Armed);
}

#[test]
fn a_motion_too_fast() {
    let mut bench = Bench::armed(&Settings::default());
    let last = bench.at(0.0, 10.5);
    bench.assert_stopped(last, Fault::Overspeed);
}

/// A hand presses 100 mm into an object that hardly moves: the device gives what it may, for as long as the hand presses.
#[test]
fn a_force_is_held_at_its_limit() {
    let mut settings = Settings::default();
    settings.object.mass_kg = 1000.0;
    (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (3.0, 2000.0);
    let mut bench = Bench::armed(&settings);
    for tick in 0..5_000 {
        let given = bench.at(0.1, 0.0).forces[0];
        // 2 N more in each tick.
        assert_eq!(given, if tick == 0 { -2.0 } else { -3.0 }, "tick {tick}");
    }
    assert_eq!(bench.peer.mode(), Mode::Armed);
}

/// A motor gives 10 N where 40 N are asked, and the object gets 40 N: that may not last.
#[test]
fn a_motor_too_long_at_its_largest_duty() {
    let mut settings = Settings::default();
    settings.object.mass_kg = 1000.0;
    settings.motor.max_duty *= 0.25;
    let mut bench = Bench::armed(&settings);
    let mut last = Actuators::default();
    let mut ticks = 0;
    while bench.peer.mode() == Mode::Armed && ticks < 1000 {
        last = bench.at(0.1, 0.0);
        ticks += 1;
    }
    assert_eq!(ticks, settings.safety.saturated_ticks);
    bench.assert_stopped(last, Fault::ForceSaturated);
}

#[test]
fn a_peer_that_falls_silent() {
    let settings = Settings::default();
    let mut bench = Bench::armed(&settings);
    // Silence before the first packet is no loss: the other peer may start later.
    for _ in 0..1000 {
        bench.peer.exchange();
    }
    assert_eq!(bench.peer.mode(), Mode::Armed);
    bench.peer.hear(&[Packet::default()]);
    bench.peer.exchange();
    // safety.peer_lost_s is 10 s of packets of 8 ms.
    for _ in 1..1250 {
        bench.peer.exchange();
    }
    assert_eq!(bench.peer.mode(), Mode::Armed);
    bench.peer.exchange();
    let last = bench.at(0.001, 0.0);
    bench.assert_stopped(last, Fault::PeerLost);
}

#[test]
fn a_peer_whose_packets_come_too_late() {
    let mut settings = Settings::default();
    settings.safety.peer_lost_s = 0.16;
    for (taken_again, fault) in [(false, Fault::PeerDelayed), (true, Fault::PeerLost)] {
        let mut bench = Bench::armed(&settings);
        bench.peer.hear(&[Packet::default()]);
        bench.peer.exchange();
        bench.peer.delayed();
        if taken_again {
            bench.peer.hear(&[Packet::default()]);
            bench.peer.exchange();
        }
        for _ in 0..19 {
            bench.peer.exchange();
        }
        assert_eq!(bench.peer.mode(), Mode::Armed);
        bench.peer.exchange();
        let last = bench.at(0.001, 0.0);
        bench.assert_stopped(last, fault);
    }
}

#[test]
fn a_tick_that_overruns() {
    let mut bench = Bench::armed(&Settings::default());
    let reading = Reading::Exact([Motion::REST; AXES]);
    let last = bench.peer.tick(&Sensors { overrun: true, ..Sensors::of(reading) });
    bench.assert_stopped(last, Fault::TickOverrun);
}

#[test]
fn an_object_that_leaves_the_numbers() {
    let mut settings = Settings::default();
    settings.coordination.comm = "power";
    settings.object.force_delay_ticks = 0.0;
    let mut bench = Bench::armed(&settings);
    let far = Packet { motion: Motion { position: 3e38, velocity: 0.0 }, ..Packet::default() };
    bench.peer.hear(&[far]);
    bench.peer.exchange();
    let last = bench.at(0.0, 0.0);
    bench.assert_stopped(last, Fault::Diverged);
}

/// Force and velocity still fit f32, their product does not: the ledger would never recover.
#[test]
fn a_power_that_leaves_the_numbers() {
    let mut settings = Settings::default();
    settings.coordination.comm = "power";
    let mut bench = Bench::armed(&settings);
    let fast = Packet { motion: Motion { position: 0.0, velocity: 1e20 }, ..Packet::default() };
    bench.peer.hear(&[fast]);
    bench.peer.exchange();
    let last = bench.at(0.0, 0.0);
    bench.assert_stopped(last, Fault::Diverged);
    assert_eq!(bench.peer.ledger()[0].received_j(), 0.0);
}

/// Faults have numbers that logs and telemetry rely on.
#[test]
fn fault_numbers_never_change() {
    let faults = [
        Fault::NonFiniteInput,
        Fault::EncoderJump,
        Fault::Overspeed,
        Fault::ForceSaturated,
        Fault::PeerLost,
        Fault::TickOverrun,
        Fault::Diverged,
        Fault::EncoderStuck,
        Fault::Runaway,
        Fault::PeerDelayed,
        Fault::ForceTooLong,
        Fault::PowerTooLong,
        Fault::OutOfWorkspace,
        Fault::BridgeFailed,
        Fault::ChipFailed,
        Fault::MotorTooWarm,
        Fault::CurrentNotFollowed,
        Fault::CurrentSensor,
        Fault::SupplyOutOfRange,
        Fault::LostCounts,
        Fault::EncoderImplausible,
        Fault::EncoderWire,
        Fault::EnableGate,
        Fault::LoopMissed,
        Fault::DriveSilent,
        Fault::DriveFailed,
        Fault::DriveTooWarm,
        Fault::DriveBusOff,
        Fault::DriveLetGo,
        Fault::EncoderSilent,
        Fault::EncoderMagnet,
        Fault::Halted,
        Fault::Thermistor,
    ];
    assert!(faults.map(Fault::number).into_iter().eq((1..=22).chain([31]).chain(64..=73)));
    assert_eq!(Fault::ALL, faults);
    assert!((0..=255).all(|number| Fault::from_number(number).is_none_or(|fault| fault.number() == number)));
}

/// The other peer moves the object; the encoder says nothing. The force may change by a quarter of full scale, no more.
#[test]
fn an_encoder_that_is_stuck() {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    settings.coordination.comm = "power";
    settings.coordination.stiffness_n_per_m = 300.0;
    let stuck_at = |counts: &dyn Fn(u16) -> u16| {
        let mut bench = Bench::armed(&settings);
        let mut largest = 0.0_f32;
        for tick in 0..400_u16 {
            if bench.peer.packet_due() {
                let pulled = Packet { motion: Motion::at(0.0004 * f32::from(tick)), ..Packet::default() };
                bench.peer.hear(&[pulled]);
                bench.peer.exchange();
            }
            let actuators = bench.read(Reading::Counts([Counts(counts(tick)), Counts(0)]));
            largest = largest.max(actuators.forces[0].abs());
        }
        (bench, largest)
    };
    let (mut bench, largest) = stuck_at(&|_| 7);
    assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::EncoderStuck));
    // 10 N, and what the object adds in eight ticks.
    assert!((9.0..12.0).contains(&largest), "{largest} N");
    let last = bench.read(Reading::Counts([Counts(7), Counts(0)]));
    bench.assert_stopped(last, Fault::EncoderStuck);
    // With one wire cut, every edge of the other goes one to and fro, however fast or slowly.
    for every in [1, 3, 32, 100] {
        let (bench, largest) = stuck_at(&|tick| 7 + tick / every % 2);
        assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::EncoderStuck), "every {every} ticks");
        assert!((9.0..12.0).contains(&largest), "every {every} ticks: {largest} N");
    }
    // A few counts on now and then is a device that is there.
    let (bench, largest) = stuck_at(&|tick| 7 + 3 * (tick / 32));
    assert_eq!(bench.peer.mode(), Mode::Armed);
    assert!(largest > 15.0, "{largest} N");
}

/// At a hand's limits, 3 N and 60 N/s, it is half of the force: four to eight ticks after it has changed by 1.5 N, however often packets go.
#[test]
fn an_encoder_that_is_stuck_under_a_gentle_force() {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    settings.coordination.comm = "power";
    (settings.safety.max_force_n, settings.safety.max_slew_n_per_s) = (3.0, 60.0);
    // What it hears is a jump that throws the copy.
    settings.safety.max_speed_m_per_s = 100.0;
    for ticks_per_packet in [1, 2, 3, 4, 5, 8, 16] {
        settings.timing.ticks_per_packet = ticks_per_packet;
        let mut bench = Bench::armed(&settings);
        let (mut ticks, mut low, mut high) = (0, 0.0_f32, 0.0_f32);
        let mut changed = None;
        while bench.peer.mode() == Mode::Armed && ticks < 200 {
            if bench.peer.packet_due() {
                bench.peer.hear(&[Packet { motion: Motion::at(0.1), ..Packet::default() }]);
                bench.peer.exchange();
            }
            ticks += 1;
            let force = bench.read(Reading::Counts([Counts(7); 2])).forces[0];
            (low, high) = (low.min(force), high.max(force));
            if high - low > 1.5 && changed.is_none() {
                changed = Some(ticks);
            }
        }
        assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::EncoderStuck), "M = {ticks_per_packet}");
        let later = ticks - changed.unwrap();
        assert!((4..=8).contains(&later), "M = {ticks_per_packet}: {later}");
    }
}

/// A device whose encoder begins to count the wrong way, pressed against the object by 4 N: an exact model of both.
#[test]
fn an_encoder_that_counts_the_wrong_way() {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    settings.coordination.comm = "none";
    settings.object.mass_kg = 1000.0;
    let run = |flipped: bool| {
        let mut bench = Bench::armed(&settings);
        let (mut position, mut speed) = (0.0_f64, 0.0_f64);
        let (mut seen, mut last) = (0.0, 0.0);
        for tick in 0..1000 {
            seen += if flipped && tick > 300 { last - position } else { position - last };
            last = position;
            let counts = Counts((seen * 200_000.0).round() as i64 as u16);
            let actuators = bench.read(Reading::Counts([counts, Counts(0)]));
            if bench.peer.mode() != Mode::Armed {
                return (bench.peer.mode(), tick, speed);
            }
            speed += 1e-3 * (f64::from(actuators.forces[0]) + 4.0 - 3.0 * speed) / 0.1;
            position += 1e-3 * speed;
        }
        (bench.peer.mode(), 1000, speed)
    };
    assert_eq!(run(false).0, Mode::Armed);
    let (mode, tick, speed) = run(true);
    assert_eq!(mode, Mode::Faulted(Fault::Runaway), "tick {tick}, {speed} m/s");
    // It is stopped long before max_speed_m_per_s, 10 m/s.
    assert!(speed.abs() < 4.0, "tick {tick}, {speed} m/s");
}

/// A blow, as far as a hand can deal one, is no runaway.
#[test]
fn a_blow_is_taken() {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    settings.object.mass_kg = 1000.0;
    let mut bench = Bench::armed(&settings);
    let forces = (0..12_u16).map(|tick| {
        // 2 m/s.
        bench.read(Reading::Counts([Counts(400 * tick), Counts(0)])).forces[0]
    });
    let hardest = forces.fold(0.0, f32::min);
    assert!(hardest < -20.0, "{hardest} N");
    assert_eq!(bench.peer.mode(), Mode::Armed);
}

/// The slew limit holds from tick to tick for a force that grows, on either side of zero. One that falls does so at once.
#[test]
fn forces_slew() {
    let mut settings = Settings::default();
    settings.safety.max_slew_n_per_s = 1000.0;
    settings.contact.stiffness_n_per_m = 5000.0;
    let mut bench = Bench::armed(&settings);
    let (mut last, mut fell) = (0.0_f32, 0.0_f32);
    for (tick, position) in
        [0.001, 0.004, 0.004, 0.004, 0.004, -0.002, -0.0021].into_iter().cycle().take(40).enumerate()
    {
        let [force, _] = bench.at(position, 0.0).forces;
        let from = if force > 0.0 { last.max(0.0) } else { last.min(0.0) };
        assert!(force.abs() <= from.abs() + 1.0 + 1e-6, "tick {tick}: {last} to {force}");
        fell = fell.max((last - force).abs());
        last = force;
    }
    assert!(fell > 2.0, "{fell} N at once");
}

/// Arming puts the object where the device is, so that nothing jerks.
#[test]
fn arming_starts_from_zero_force_wherever_the_device_is() {
    let mut bench = Bench::at_rest(&Settings::default(), Motion::REST);
    bench.at(0.123, 0.0);
    bench.command(Command::Arm);
    let armed = bench.at(0.123, 0.0);
    assert!(armed.enable);
    assert_eq!(armed.forces, [0.0; AXES]);
}

/// A device that stands away from where its encoders read zero must not seem to jump there in its first tick.
#[test]
fn the_first_reading_of_an_encoder_is_no_motion() {
    let mut settings = Settings::default();
    settings.axis.velocity = VelocityName::Difference;
    let mut bench = Bench::at_rest(&settings, Motion::at(-0.005));
    bench.command(Command::Arm);
    bench.read(Reading::Counts([Counts(1234), Counts(0)]));
    assert_eq!(bench.peer.observed()[0].device, Motion::at(-0.005));
}
