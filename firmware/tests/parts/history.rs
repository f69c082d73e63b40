//! What a board keeps of its starts and faults, in flash that is only ever programmed.

use cohold_core::safety::Fault;
use firmware_parts::history::{FAULTS, FIRST, History, MOST, STARTS};
use firmware_parts::status::Stop;
use firmware_parts::store::{SECTOR, Word};

const BLANK: Word = [0xFF; 32];

/// The keys' sector, of a board that never started.
fn sector() -> Vec<Option<Word>> {
    (0..SECTOR).map(|at| Some(if at < FIRST { [0x11; 32] } else { BLANK })).collect()
}

/// Programs what is to be noted, into a word that is blank.
fn program(flash: &mut [Option<Word>], noted: Option<(u32, Word)>) {
    if let Some((at, word)) = noted {
        assert_eq!(flash[at as usize], Some(BLANK), "word {at} is not blank");
        flash[at as usize] = Some(word);
    }
}

fn start(flash: &mut [Option<Word>], stop: Stop) -> History {
    let mut history = History::open(|at| flash[at as usize]);
    program(flash, history.start(stop));
    history
}

#[test]
fn starts_and_faults_survive_power_newest_first() {
    let mut flash = sector();
    let mut history = start(&mut flash, Stop::PowerOn);
    program(&mut flash, history.fault(Fault::EncoderJump, 12_345));
    program(&mut flash, history.fault(Fault::PeerLost, 61_007));
    let told = "newest first; start: the tick or the supervisor made no progress; fault 5 at 61.007 s; fault 2 at 12.345 s; \
                start: power came on";
    assert_eq!(start(&mut flash, Stop::Watchdog).to_string(), told);
    // And of many no more than one line has room for.
    for _ in 0..20 {
        start(&mut flash, Stop::HardFault);
    }
    let told = start(&mut flash, Stop::HardFault).to_string();
    assert_eq!(told.matches("start: ").count(), 8);
    assert!(told.len() <= 700, "{}", told.len());
}

#[test]
fn a_start_that_an_image_of_before_counted_and_a_word_that_was_lost_are_starts() {
    let mut flash = sector();
    (flash[FIRST as usize], flash[FIRST as usize + 1]) = (Some([0; 32]), None);
    let history = start(&mut flash, Stop::PowerOn);
    assert_eq!((history.used, history.to_string().as_str()), (3, "newest first; start: power came on; start; start"));
}

#[test]
fn faults_leave_room_for_starts() {
    let mut flash = sector();
    // A board whose every start ends in more faults than are kept.
    let (mut starts, mut last) = (0, 0);
    loop {
        let mut history = start(&mut flash, Stop::PowerOn);
        if history.used == last {
            break;
        }
        last = history.used;
        starts += 1;
        (0..2 * FAULTS).for_each(|at| program(&mut flash, history.fault(Fault::Runaway, at)));
        assert!(history.used <= last + FAULTS);
    }
    assert_eq!(last, MOST, "the sector is full");
    assert!(starts >= STARTS, "{starts} starts");
    assert_eq!(flash[..FIRST as usize], sector()[..FIRST as usize], "the keys are as they were");
}
