//! Bytes to and from a moteus against the crate `moteus-protocol`, and what a motor does tick by tick with the answers that come.

use cohold_core::device::{encoder::Counts, motor::Duty};
use cohold_core::names::MotorDrive;
use cohold_core::safety::Fault;
use cohold_core::settings::Settings;
use firmware_parts::moteus::{ANSWER_WORDS, Design, LOST, MOST_C, Motor, STOP, Told, Trouble, WAKE_TICKS, command};
use firmware_parts::signals::Coded;
use moteus_protocol::command::{PositionCommand, PositionFormat, StopCommand};
use moteus_protocol::query::{QueryFormat, QueryResult};
use moteus_protocol::{CanFdFrame, Register, Resolution, Subframe, Value, parse_frame};

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// What a frame writes and reads, register by register, without what stands only for how it was packed.
fn parts(data: &[u8]) -> Vec<String> {
    let mut parts: Vec<String> = parse_frame(data).map(|part| format!("{part:?}")).collect();
    parts.sort();
    parts
}

/// The crate's own frame of the same command: what the host side sends (host-sim/guests/devices/src/moteus.rs).
fn theirs(torque_nm: f32, most_nm: f32) -> Vec<u8> {
    let mut frame = CanFdFrame::new();
    let mut format = PositionFormat::default();
    (format.position, format.velocity) = (Resolution::Int8, Resolution::Int8);
    (format.kp_scale, format.kd_scale) = (Resolution::Int8, Resolution::Int8);
    format.ilimit_scale = Resolution::Int8;
    format.watchdog_timeout = Resolution::Int16;
    PositionCommand::new()
        .position(f32::NAN)
        .velocity(0.0)
        .kp_scale(0.0)
        .kd_scale(0.0)
        .ilimit_scale(0.0)
        .feedforward_torque(torque_nm)
        .maximum_torque(most_nm)
        // The crate truncates: 5 ms, and a little more.
        .watchdog_timeout(0.0051)
        .serialize(&mut frame, &format);
    QueryFormat::default().serialize(&mut frame);
    frame.data[..usize::from(frame.size)].to_vec()
}

#[test]
fn a_command_says_what_the_crates_says() {
    for (torque_nm, most_nm) in [(0.0, 1.0), (0.25, 0.5), (-0.125, 2.0), (f32::MIN_POSITIVE, 0.03)] {
        assert_eq!(parts(&bytes(&command(torque_nm, most_nm))), parts(&theirs(torque_nm, most_nm)));
    }
    // A watchdog, no gains: nothing of the comparison is empty.
    assert!(parts(&bytes(&command(0.0, 1.0))).len() >= 14);
}

#[test]
fn a_stop_says_what_the_crates_says() {
    let mut frame = CanFdFrame::new();
    StopCommand::serialize(&mut frame);
    QueryFormat::default().serialize(&mut frame);
    assert_eq!(parts(&bytes(&STOP)), parts(&frame.data[..usize::from(frame.size)]));
}

/// An answer as a controller packs it.
fn answer(told: &Told) -> [u32; ANSWER_WORDS] {
    let mut data = vec![0x21, 0, told.mode, 0x2F, 1];
    for number in [told.position_rev, told.velocity_rev_per_s, told.torque_nm] {
        data.extend(number.to_le_bytes());
    }
    data.extend([0x23, 0x0D, told.supply.cast_unsigned(), told.temperature_c.cast_unsigned(), told.fault]);
    data.resize(4 * ANSWER_WORDS, 0x50);
    let mut words = [0; ANSWER_WORDS];
    for (word, bytes) in words.iter_mut().zip(data.as_chunks().0) {
        *word = u32::from_le_bytes(*bytes);
    }
    words
}

fn told() -> Told {
    Told {
        mode: 10,
        position_rev: 0.375,
        velocity_rev_per_s: -1.5,
        torque_nm: 0.0625,
        supply: 48,
        temperature_c: 31,
        fault: 0,
    }
}

#[test]
fn an_answer_is_read_as_the_crate_reads_it_and_anything_else_is_none() {
    let words = answer(&Told { fault: 99, ..told() });
    let (ours, theirs) = (Told::read(&words).expect("it is one"), QueryResult::parse_data(&bytes(&words)));
    assert_eq!(ours, Told { fault: 99, ..told() });
    assert_eq!(ours.mode, theirs.mode as u8);
    assert_eq!(
        [ours.position_rev, ours.velocity_rev_per_s, ours.torque_nm],
        [theirs.position, theirs.velocity, theirs.torque]
    );
    assert_eq!(
        [f32::from(ours.supply) / 2.0, f32::from(ours.temperature_c), f32::from(ours.fault)],
        [theirs.voltage, theirs.temperature, f32::from(theirs.fault)]
    );
    // One bit of any head.
    for (word, bit) in [(0, 0), (0, 9), (0, 25), (1, 3), (4, 8), (4, 17)] {
        let mut wrong = words;
        wrong[word] ^= 1 << bit;
        assert_eq!(Told::read(&wrong), None, "bit {bit} of word {word}");
    }
}

/// The registers of an answer are those of the crate's query, in our order.
#[test]
fn what_is_asked_for_is_told() {
    let stop = bytes(&STOP);
    let asked = parse_frame(&stop).filter_map(|part| match part {
        Subframe::Register { register, value: None, .. } => Some(register),
        _ => None,
    });
    let answered = bytes(&answer(&told()));
    let told = parse_frame(&answered).filter_map(|part| match part {
        Subframe::Register { register, value: Some(Value::Int8(_) | Value::Float(_)), .. } => Some(register),
        _ => None,
    });
    let told: Vec<u16> = told.collect();
    assert_eq!(asked.collect::<Vec<u16>>(), told);
    assert!(told.contains(&Register::Fault.address()) && told.len() == 7);
}

fn design() -> (Settings, Design) {
    let mut settings = Settings::default();
    settings.axis.count = 1;
    settings.motor.drive = MotorDrive::Amplifier;
    settings.encoder.counts_per_rev = 8192.0;
    (settings, Design::build(&settings).expect("one motor"))
}

/// A motor that has been driven for some time and answers.
fn driven() -> (Design, Motor) {
    let (_, design) = design();
    let mut motor = Motor::default();
    for _ in 0..20 {
        assert_eq!(motor.hear(&design, Some(Told { torque_nm: 0.0, ..told() }), false), None);
        motor.drive(&design, Duty(0));
    }
    (design, motor)
}

fn torque(words: &[u32]) -> f32 {
    f32::from_bits(words[2])
}

#[test]
fn the_joint_counts_from_where_it_was_heard_first() {
    let (_, design) = design();
    let mut motor = Motor::default();
    let mut at = |revolutions: f32| {
        let heard = Told { mode: 0, position_rev: revolutions, ..told() };
        assert_eq!(motor.hear(&design, Some(heard), false), None);
        motor.counts()
    };
    assert_eq!(at(3.25), Counts(0));
    assert_eq!(at(3.25 + 5.0 / 8192.0), Counts(5));
    assert_eq!(at(3.25 - 5.4 / 8192.0), Counts((-5_i16).cast_unsigned()));
    // 16 bits, as a timer has them.
    assert_eq!(at(3.25 + 9.0), Counts((9 * 8192_u32) as u16));
}

#[test]
fn a_torque_is_the_share_of_the_motors_own_and_no_more_than_it_may_be() {
    let (settings, _) = design();
    let (design, mut motor) = driven();
    let radius_m = settings.encoder.counts_per_rev / settings.encoder.counts_per_m / core::f64::consts::TAU;
    let full_nm = settings.motor.newton_or_newton_metre_per_a * settings.motor.full_scale_a * radius_m;
    let words = motor.drive(&design, Duty(-16384));
    assert!((f64::from(torque(&words)) + full_nm * 16384.0 / 32767.0).abs() < 1e-7 * full_nm);
    assert!((f64::from(f32::from_bits(words[5])) - settings.motor.max_duty * full_nm).abs() < 1e-6 * full_nm);
    // Of a joint that turns there is no radius.
    let mut turning = settings;
    turning.kinematics.model = cohold_core::device::kinematics::KinematicsName::Capstan;
    let design = Design::build(&turning).expect("one motor");
    let nm = f64::from(torque(&motor.drive(&design, Duty(i16::MAX))));
    assert!((nm - settings.motor.newton_or_newton_metre_per_a * settings.motor.full_scale_a).abs() < 1e-6);
}

#[test]
fn torque_fades_without_answers_and_is_gone_after_four_ticks() {
    let (design, mut motor) = driven();
    let full = torque(&motor.drive(&design, Duty(8000)));
    for (missing, share) in [(1, 0.75), (2, 0.5), (3, 0.25)] {
        assert_eq!(motor.hear(&design, None, false), None, "{missing} missing");
        assert_eq!(torque(&motor.drive(&design, Duty(8000))), share * full, "{missing} missing");
    }
    assert_eq!(motor.hear(&design, None, false), Some(Fault::DriveSilent));
    assert_eq!(LOST, 4);
    assert_eq!(torque(&motor.drive(&design, Duty(8000))), 0.0);
    // One answer in time, and it is all there again.
    let (design, mut motor) = driven();
    assert_eq!(motor.hear(&design, None, false), None);
    motor.drive(&design, Duty(8000));
    assert_eq!(motor.hear(&design, Some(Told { torque_nm: 0.0, ..told() }), false), None);
    assert_eq!(torque(&motor.drive(&design, Duty(8000))), full);
}

#[test]
fn torque_comes_in_once_the_controller_is_awake() {
    let (_, design) = design();
    let mut motor = Motor::default();
    let hear = |motor: &mut Motor, mode: u8| {
        assert_eq!(motor.hear(&design, Some(Told { mode, torque_nm: 0.0, ..told() }), false), None);
        torque(&motor.drive(&design, Duty(400)))
    };
    for mode in [0, 2, 3, 3, 4] {
        assert_eq!(hear(&mut motor, mode), 0.0);
    }
    let rising: Vec<f32> = (0..10).map(|_| hear(&mut motor, 10)).collect();
    let full = rising[9];
    let expected: Vec<f32> = (1..=10).map(|tick: u8| full * f32::from(tick.min(8)) / 8.0).collect();
    assert_eq!(rising, expected);
    // One that does not wake is none.
    let mut motor = Motor::default();
    let mut asleep = || {
        let fault = motor.hear(&design, Some(Told { mode: 3, ..told() }), false);
        motor.drive(&design, Duty(400));
        fault
    };
    assert!((0..=WAKE_TICKS).all(|_| asleep().is_none()));
    assert_eq!(asleep(), Some(Fault::DriveLetGo));
}

#[test]
fn each_trouble_is_a_fault_of_a_motor_that_is_on_and_a_reason_not_to_turn_it_on() {
    let good = Told { torque_nm: 0.0, ..told() };
    let cases = [
        (Told { mode: 1, fault: 38, ..good }, Trouble::Own(38), Fault::DriveFailed),
        (Told { mode: 11, ..good }, Trouble::LetGo, Fault::DriveLetGo),
        (Told { mode: 0, ..good }, Trouble::LetGo, Fault::DriveLetGo),
        (Told { temperature_c: MOST_C + 1, ..good }, Trouble::TooWarm, Fault::DriveTooWarm),
        (Told { supply: 35, ..good }, Trouble::Supply, Fault::SupplyOutOfRange),
        (Told { supply: 61, ..good }, Trouble::Supply, Fault::SupplyOutOfRange),
        (Told { position_rev: f32::NAN, ..good }, Trouble::NotANumber, Fault::NonFiniteInput),
        (Told { velocity_rev_per_s: f32::INFINITY, ..good }, Trouble::NotANumber, Fault::NonFiniteInput),
    ];
    for (heard, trouble, fault) in cases {
        let (design, mut motor) = driven();
        let before = motor.counts();
        assert_eq!(motor.hear(&design, Some(heard), false), Some(fault), "{heard:?}");
        assert_eq!((motor.trouble(), motor.counts()), (trouble, before), "{heard:?}");
        motor.stop();
        // Of one that is off it is no fault, and a mode that nobody asked for is none either.
        assert_eq!(motor.hear(&design, Some(heard), false), None, "{heard:?}");
        assert_eq!(motor.trouble(), if trouble == Trouble::LetGo { Trouble::None } else { trouble }, "{heard:?}");
    }
    let (design, mut motor) = driven();
    assert_eq!(motor.hear(&design, Some(good), true), Some(Fault::DriveBusOff));
    // Limits themselves are within.
    for supply in [36, 60] {
        let (design, mut motor) = driven();
        assert_eq!(motor.hear(&design, Some(Told { supply, temperature_c: MOST_C, ..good }), false), None);
    }
}

#[test]
fn another_torque_than_was_asked_for_is_a_fault_after_ten_ticks() {
    let (design, mut motor) = driven();
    let asked = torque(&motor.drive(&design, Duty(16000)));
    let mut hear = |torque_nm: f32| {
        let fault = motor.hear(&design, Some(Told { torque_nm, ..told() }), false);
        motor.drive(&design, Duty(16000));
        fault
    };
    assert!((0..100).all(|_| hear(asked).is_none()));
    assert!((0..9).all(|_| hear(0.5 * asked).is_none()));
    assert_eq!(hear(0.5 * asked), Some(Fault::CurrentNotFollowed));
}

#[test]
fn whoever_was_silent_may_have_lost_count() {
    let (design, mut motor) = driven();
    motor.stop();
    let silent: Vec<_> = (0..5).map(|_| motor.hear(&design, None, false)).collect();
    assert_eq!(silent, [None, None, None, Some(Fault::DriveSilent), Some(Fault::DriveSilent)]);
    assert!(Fault::DriveSilent.doubts_encoders());
    // It comes back somewhere else: the joint is where it was, and the signs are to be checked again.
    let before = motor.counts();
    assert_eq!(motor.hear(&design, Some(Told { mode: 0, position_rev: -0.1, ..told() }), false), None);
    assert_eq!(motor.counts(), before);
    // Before the first answer silence is no fault.
    let mut motor = Motor::default();
    assert!((0..10).all(|_| motor.hear(&design, None, false).is_none()));
    assert_eq!(motor.trouble(), Trouble::Silent);
}

#[test]
fn troubles_keep_their_codes_and_have_their_sentences() {
    let own = (0..=255).map(Trouble::Own);
    let others = [
        Trouble::None,
        Trouble::Silent,
        Trouble::BusOff,
        Trouble::LetGo,
        Trouble::NotANumber,
        Trouble::TooWarm,
        Trouble::Supply,
        Trouble::Astray,
    ];
    for trouble in own.chain(others) {
        assert_eq!(Trouble::decode(trouble.code()), trouble);
        assert_eq!(trouble.explain().is_some(), trouble.fault().is_some(), "{trouble:?}");
    }
    assert_eq!([8, 255, 512, u32::MAX].map(Trouble::decode), [Trouble::None; 4]);
}
