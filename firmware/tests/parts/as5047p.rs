//! Frames of an AS5047P against its data sheet's layout, every wrong bit in every frame, wires that are off, and what a joint does with each.

use cohold_core::device::encoder::Counts;
use cohold_core::safety::Fault;
use cohold_core::settings::Settings;
use firmware_parts::as5047p::{ANGLE, BAD, DIAGNOSIS, Design, ERRORS, Reason, Sensor, Trouble, judge};
use firmware_parts::signals::Coded;

/// Bit 15 makes the number of ones even, by the data sheet's figures of both kinds of frame.
fn with_parity(lower: u16) -> u16 {
    assert!(lower < 1 << 15);
    if (0..15).filter(|bit| lower >> bit & 1 == 1).count() % 2 == 1 { lower | 1 << 15 } else { lower }
}

/// A command to read: bit 14, and the address.
fn read(address: u16) -> u16 {
    with_parity(1 << 14 | address)
}

const ANGLECOM: u16 = 0x3FFF;
const DIAAGC: u16 = 0x3FFC;
const ERRFL: u16 = 0x0001;
const ERROR_FLAG: u16 = 1 << 14;
/// LF, and a gain in the middle: nothing is wrong.
const WELL: u16 = 1 << 8 | 0x80;

#[test]
fn commands_are_the_data_sheets() {
    assert_eq!([ANGLE, DIAGNOSIS, ERRORS], [ANGLECOM, DIAAGC, ERRFL].map(read));
}

/// A chip as its data sheet has it: executes a command as its frame ends, answers it in the next.
struct Chip {
    angle: u16,
    diagnosis: u16,
    errors: u16,
    out: u16,
}

impl Chip {
    fn new(angle: u16) -> Self {
        Self { angle, diagnosis: WELL, errors: 0, out: 0 }
    }

    /// A frame each way, in which these bits go wrong on their way.
    fn frame(&mut self, command: u16, wrong: [u16; 2]) -> u16 {
        let (heard, told) = (command ^ wrong[0], self.out ^ wrong[1]);
        if heard.count_ones() % 2 == 1 {
            self.errors |= 1 << 2;
        } else if heard >> 14 & 1 == 0 || ![ANGLECOM, DIAAGC, ERRFL].contains(&(heard & 0x3FFF)) {
            self.errors |= 1 << 1;
        }
        let mut data = match heard & 0x3FFF {
            ANGLECOM => self.angle,
            DIAAGC => self.diagnosis,
            ERRFL => core::mem::take(&mut self.errors),
            _ => 0,
        };
        if self.errors != 0 {
            data |= ERROR_FLAG;
        }
        self.out = with_parity(data);
        told
    }

    /// A tick's two frames; `wrong` of each: bits of what is heard, bits of what is told.
    fn tick(&mut self, sensor: &mut Sensor, wrong: [[u16; 2]; 2]) {
        let first = self.frame(ANGLE, wrong[0]);
        let command = sensor.first(Some(first));
        let second = self.frame(command, wrong[1]);
        sensor.second(Some(second));
    }
}

const NOTHING: [[u16; 2]; 2] = [[0; 2]; 2];

fn design() -> Design {
    Design::build(&Settings::default()).unwrap()
}

/// What is against a first joint that is driven, or not.
fn against(sensor: &Sensor, driving: bool) -> (Reason, Option<Fault>) {
    let (trouble, fault) = judge(&design(), &[*sensor, Sensor::default()], driving);
    (trouble.reason, fault)
}

/// A chip at this angle that was heard.
fn heard(angle: u16) -> (Chip, Sensor) {
    let (mut chip, mut sensor) = (Chip::new(angle), Sensor::default());
    for _ in 0..3 {
        chip.tick(&mut sensor, NOTHING);
    }
    assert_eq!((against(&sensor, true), sensor.counts()), ((Reason::None, None), Counts(0)));
    (chip, sensor)
}

#[test]
fn it_is_heard_in_the_third_tick_and_silence_before_that_is_no_fault_of_motors_that_are_off() {
    let (mut chip, mut sensor) = (Chip::new(1234), Sensor::default());
    for _ in 0..2 {
        chip.tick(&mut sensor, NOTHING);
        assert_eq!(against(&sensor, false), (Reason::Silent, None));
        assert_eq!(against(&sensor, true), (Reason::Silent, Some(Fault::EncoderSilent)));
    }
    chip.tick(&mut sensor, NOTHING);
    assert_eq!(against(&sensor, true), (Reason::None, None));
}

/// Counts are the angle that was moved, across its own end and the counter's, either way.
#[test]
fn turns_add_up() {
    for (start, step) in [(16380_i64, 700_i64), (3, -700), (0, 2730), (8191, -2730), (5, 1), (16000, 0)] {
        let (mut chip, mut sensor) = heard(start as u16);
        for tick in 1..200_i64 {
            chip.angle = (start + step * tick).rem_euclid(1 << 14) as u16;
            chip.tick(&mut sensor, NOTHING);
            assert_eq!(sensor.counts(), Counts((step * tick).rem_euclid(1 << 16) as u16), "{start} {step} {tick}");
        }
    }
}

/// Any bit of any frame, either way, at any angle of a few: no count that is not there, and whole again after two readings at the most.
#[test]
fn every_single_wrong_bit_is_seen_and_got_over() {
    let mut most = 0;
    for angle in [0, 1, 0x1FFF, 0x2000, 0x3FFF, 0x2AAA] {
        for frame in 0..2 {
            for way in 0..2 {
                for bit in 0..16 {
                    let (mut chip, mut sensor) = heard(angle);
                    let mut wrong = NOTHING;
                    wrong[frame][way] = 1 << bit;
                    chip.tick(&mut sensor, wrong);
                    let what = format!("angle {angle}, frame {frame}, way {way}, bit {bit}");
                    assert_eq!(sensor.counts(), Counts(0), "{what}");
                    // What the second frame says badly is told with the first of the next tick.
                    let mut missed = 0;
                    for _ in 0..4 {
                        chip.angle = (chip.angle + 1) & 0x3FFF;
                        let before = sensor.counts();
                        chip.tick(&mut sensor, NOTHING);
                        missed += u32::from(sensor.counts() == before);
                        assert_eq!(against(&sensor, true), (Reason::None, None), "{what}");
                    }
                    assert_eq!(sensor.counts(), Counts(4), "{what}");
                    assert_eq!(chip.errors, 0, "{what}");
                    most = most.max(missed);
                }
            }
        }
    }
    // In the ticks after it; of what is told wrong in the tick itself there is one more.
    assert_eq!(most, 1);
}

#[test]
fn a_line_at_either_level_or_no_frame_at_all_is_a_fault_in_the_third_tick() {
    // At an angle of 0, where what a line at 0 says is an angle.
    for (told, reason) in [(Some(0), Reason::Silent), (Some(0xFFFF), Reason::Silent), (None, Reason::Silent)] {
        let (_, mut sensor) = heard(0);
        for tick in 1..=2 * BAD {
            sensor.first(told);
            sensor.second(told);
            let wanted = if tick < BAD { (Reason::None, None) } else { (reason, Some(Fault::EncoderSilent)) };
            assert_eq!(against(&sensor, true), wanted, "{told:?} {tick}");
            // It was read before: a fault of motors that are off, too.
            assert_eq!(against(&sensor, false), wanted, "{told:?} {tick}");
        }
        assert_eq!(sensor.counts(), Counts(0));
    }
}

#[test]
fn an_encoder_that_hears_nothing_is_told_from_one_that_answers() {
    // Its input stands at 0: a command that writes nothing, answered by zeros.
    let (mut chip, mut sensor) = heard(100);
    for _ in 0..BAD {
        let first = chip.frame(0, [0; 2]);
        sensor.first(Some(first));
        let second = chip.frame(0, [0; 2]);
        sensor.second(Some(second));
    }
    assert_eq!(against(&sensor, true).1, Some(Fault::EncoderSilent));
}

#[test]
fn a_magnet_that_is_too_far_or_too_near_is_named() {
    for (diagnosis, reason, fault) in [
        (WELL | 1 << 11, Reason::Weak, Fault::EncoderMagnet),
        (WELL | 1 << 10, Reason::Strong, Fault::EncoderMagnet),
        (WELL | 1 << 9, Reason::Strong, Fault::EncoderMagnet),
        (0x80, Reason::Silent, Fault::EncoderSilent),
    ] {
        let (mut chip, mut sensor) = heard(7);
        chip.diagnosis = diagnosis;
        let ticks = (1..20).find(|_| {
            chip.tick(&mut sensor, NOTHING);
            against(&sensor, true).1.is_some()
        });
        // The diagnosis that comes in a tick is of the one before.
        assert_eq!((ticks, against(&sensor, true)), (Some(BAD + 1), (reason, Some(fault))), "{diagnosis:#x}");
    }
}

/// Where it is found again is where it was left, as the peer's own memory of it has it.
#[test]
fn after_a_silence_it_goes_on_from_where_it_was() {
    let (mut chip, mut sensor) = heard(16000);
    chip.angle = 100;
    chip.tick(&mut sensor, NOTHING);
    assert_eq!(sensor.counts(), Counts(484));
    for _ in 0..BAD {
        sensor.first(None);
        sensor.second(None);
    }
    chip.angle = 9000;
    for _ in 0..2 {
        chip.tick(&mut sensor, NOTHING);
    }
    assert_eq!((sensor.counts(), against(&sensor, true).0), (Counts(484), Reason::None));
    chip.angle = 9010;
    chip.tick(&mut sensor, NOTHING);
    assert_eq!(sensor.counts(), Counts(494));
}

#[test]
fn only_encoders_in_use_count_and_the_first_is_named() {
    let (_, well) = heard(1);
    let gone = Sensor::default();
    let one = design();
    assert_eq!(judge(&one, &[well, gone], true), (Trouble::default(), None));
    let mut settings = Settings::default();
    settings.axis.count = 2;
    let two = Design::build(&settings).unwrap();
    let of = |joint| Trouble { joint, reason: Reason::Silent };
    assert_eq!(judge(&two, &[well, gone], true), (of(1), Some(Fault::EncoderSilent)));
    assert_eq!(judge(&two, &[gone, gone], true), (of(0), Some(Fault::EncoderSilent)));
}

#[test]
fn what_is_told_of_it_comes_back_and_has_a_sentence() {
    for reason in [Reason::Silent, Reason::Garbled, Reason::Weak, Reason::Strong] {
        for joint in 0..2 {
            let trouble = Trouble { joint, reason };
            assert_eq!(Trouble::decode(trouble.code()), trouble);
            assert!(trouble.explain().unwrap().contains(&format!("encoder {}", joint + 1)), "{trouble:?}");
        }
    }
    assert_eq!((Trouble::default().code(), Trouble::default().explain()), (0, None));
}

/// Half a revolution must not pass between whole readings, of which two may be missing: 2,730 counts a tick, less two for rounding, by a
/// quarter above the speed.
#[test]
fn a_speed_that_an_angle_cannot_be_followed_at_is_refused() {
    let mut settings = Settings::default();
    let fastest = 2728.0 / (1.25 * 0.001 * settings.encoder.counts_per_m);
    settings.encoder.max_speed_m_per_s = fastest;
    assert!(Design::build(&settings).is_ok());
    settings.encoder.max_speed_m_per_s = 1.001 * fastest;
    let refused = Design::build(&settings).unwrap_err();
    assert_eq!(refused.key, "encoder.max_speed_m_per_s");
}
