//! Histograms of the tick's times, against ticks counted by hand.

use firmware_parts::record::{RECEIVED, SENT};
use firmware_parts::times::{Histogram, Times, Took};

/// As on the board: 480 MHz, 1 kHz.
const PERIOD: u32 = 480_000;

#[test]
fn a_tick_is_counted_in_the_bin_of_its_highest_bit() {
    for (cycles, bin) in
        [(0, 0), (1, 0), (2, 1), (3, 1), (4, 2), (1023, 9), (1024, 10), (32_767, 14), (32_768, 15), (u32::MAX, 15)]
    {
        let times = Times::none();
        times.see(
            &Took { tick: 7, delay: cycles, began: 5, ended: 5_u32.wrapping_add(cycles), ..Took::default() },
            PERIOD,
        );
        let mut only = [0; Histogram::BINS];
        only[bin] = 1;
        assert_eq!((times.delay.counts(), times.duration.counts()), (only, only), "{cycles}");
        assert_eq!((times.delay.most(), times.duration.most()), (cycles, cycles));
    }
}

#[test]
fn spacing_is_of_two_ticks_in_a_row_and_the_counter_may_wrap() {
    let times = Times::none();
    let mut began = u32::MAX - PERIOD / 2;
    for (tick, late) in [(1, 0), (2, 0), (3, 100), (4, 0), (6, 0), (7, 0)] {
        times.see(
            &Took { tick, began: began.wrapping_add(late), ended: began.wrapping_add(late + 1), ..Took::default() },
            PERIOD,
        );
        began = began.wrapping_add(if tick == 4 { 2 * PERIOD } else { PERIOD });
    }
    let mut counts = [0; Histogram::BINS];
    // 2 after 1, 7 after 6; 3 after 2 and 4 after 3, 100 cycles off; 6 after 4 is none.
    (counts[0], counts[6]) = (2, 2);
    assert_eq!((times.spacing.counts(), times.spacing.most()), (counts, 100));
    assert_eq!(times.duration.counts().iter().sum::<u32>(), 6);
}

#[test]
fn the_longest_is_told_with_what_its_tick_did() {
    let times = Times::none();
    let ticks = [(1, 600, 0), (2, 2_000, SENT | RECEIVED), (3, 1_999, 0), (4, 2_000, 0)];
    for (tick, ended, flags) in ticks {
        times.see(&Took { tick, flags, ended, ..Took::default() }, PERIOD);
    }
    assert_eq!(times.duration.to_string(), "most 2000 in tick 2 sent received; from:ticks 512:1 1024:3");
    assert_eq!(times.delay.to_string(), "most 0 in tick 0; from:ticks 0:4");
}
