//! The ticks before a fault: which are kept, and of which reset they tell.

use cohold_core::device::{encoder::Counts, motor::Duty};
use firmware_parts::exchange::Latest;
use firmware_parts::record::{Record, Tick};
use firmware_parts::recorder::{Reel, TICKS, after};
use firmware_parts::status::Stop;

/// A reel in memory that power has just come to.
fn garbage() -> Reel {
    let mut reel = Reel::empty();
    (0..700).for_each(|tick| write(&mut reel, tick));
    reel.stand();
    reel
}

fn write(reel: &mut Reel, tick: u32) {
    let of =
        Tick { tick, axis: 0, counts: [Counts(0); 2], duties: [Duty(0); 2], stage: None, mode: 1, flags: 0, digest: 0 };
    let mut record = Record::default();
    record.fill_with::<f32>(&of, None, |_| {});
    reel.write(&record);
}

fn ticks(reel: &Reel) -> Vec<u32> {
    (0..reel.count()).filter_map(|number| reel.get(number)).map(Record::tick).collect()
}

/// The three of a board, for ever.
fn reels() -> [&'static mut Reel; 3] {
    [(); 3].map(|()| &mut *Box::leak(Box::new(garbage())))
}

#[test]
fn a_reel_holds_the_last_ticks_oldest_first() {
    let mut reel = Reel::empty();
    assert_eq!((reel.count(), reel.get(0)), (0, None));
    for number in [1, 5, TICKS as u32 - 1, TICKS as u32, TICKS as u32 + 1, 1000, 3 * TICKS as u32] {
        reel.begin(0);
        (0..number).for_each(|tick| write(&mut reel, tick));
        let first = number.saturating_sub(TICKS as u32);
        assert_eq!(ticks(&reel), (first..number).collect::<Vec<_>>());
        assert_eq!(reel.get(reel.count()), None);
    }
}

#[test]
fn power_ends_them() {
    for stop in [Stop::PowerOn, Stop::BrownOut] {
        let [next, shown, spare] = after(stop, reels());
        assert!(next.count() == 0 && shown.count() == 0 && spare.count() == 0, "{stop:?}");
    }
}

#[test]
fn a_reset_shows_what_led_to_it_and_another_start_the_last_fault() {
    let [next, shown, spare] = after(Stop::PowerOn, reels());
    (0..300).for_each(|tick| write(next, tick));
    // A fault; then the next reel, to which 10 ticks went when the program failed.
    let number = next.stand();
    spare.begin(number);
    (300..310).for_each(|tick| write(spare, tick));
    let [next, after_panic, other] = after(Stop::Panic, [next, shown, spare]);
    assert_eq!(ticks(after_panic), (300..310).collect::<Vec<_>>());
    assert!(next.count() == 0 && other.count() == 0);
    // Nothing was written since.
    let [.., again] = [after(Stop::Panic, [next, after_panic, other])];
    assert!(again[1].count() == 0);

    let [next, shown, spare] = after(Stop::PowerOn, reels());
    (0..300).for_each(|tick| write(next, tick));
    let number = next.stand();
    spare.begin(number);
    (300..310).for_each(|tick| write(spare, tick));
    let [next, after_request, spare] = after(Stop::Request, [next, shown, spare]);
    assert_eq!(ticks(after_request), (44..300).collect::<Vec<_>>(), "of the fault, for nothing failed since");
    assert!(next.count() == 0);
    // A program that fails then tells of itself.
    (400..420).for_each(|tick| write(next, tick));
    let [_, after_panic, _] = after(Stop::HardFault, [spare, after_request, next]);
    assert_eq!(ticks(after_panic), (400..420).collect::<Vec<_>>());
}

#[test]
fn each_fault_replaces_the_one_before_whoever_reads() {
    let mut cell = Latest::of(after(Stop::PowerOn, reels()));
    let (mut tick_side, mut reader) = cell.split();
    for fault in 0..10 {
        let first = 1000 * fault;
        for tick in first..first + 400 {
            let (over, mut next) = (tick == first + 399, 0);
            tick_side.fill(|reel| {
                write(reel, tick);
                next = if over { reel.stand() } else { 0 };
                over
            });
            if over {
                tick_side.fill(|reel| {
                    reel.begin(next);
                    false
                });
            }
        }
        // Who reads has what stood when he looked, whatever the tick does.
        if fault % 3 == 0 {
            assert!(reader.fetch());
        }
        let seen = first - 1000 * (fault % 3);
        assert_eq!(ticks(reader.get()), (seen + 400 - TICKS as u32..seen + 400).collect::<Vec<_>>());
    }
}
