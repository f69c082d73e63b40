//! Pulses whose times are known.

use super::*;

/// Periods of a tick.
const TICK: u32 = 20;

/// Pulses of these compare values, from a count on that overflows soon.
fn of(commands: &[u32], late: u32) -> Pulses {
    let mut pulses = Pulses::default();
    pulses.count(TICK);
    let mut begin = u32::MAX - 3 * PERIOD;
    for compare in commands {
        pulses.see(begin.wrapping_add(*compare), begin.wrapping_add(PERIOD - compare));
        begin = begin.wrapping_add(PERIOD + late);
    }
    pulses
}

#[test]
fn changes_that_come_with_ticks_are_in_step_and_others_are_not() {
    let commands: Vec<u32> = (0..200).map(|period| 3000 + period / TICK * 5).collect();
    let seen = of(&commands, 0).seen;
    assert_eq!((seen.periods, seen.changes, seen.in_step, seen.off, seen.residue), (199, 9, 8, 0, 0));
    let mut early = commands.clone();
    early[59] = early[60];
    assert_eq!(of(&early, 0).seen.off, 2);
    assert_eq!(of(&commands, 1).seen.residue, TICK);
}

#[test]
fn a_period_that_does_not_come_is_missing() {
    let mut pulses = of(&[3000; 10], 0);
    let fell = pulses.middle.wrapping_add(3 * PERIOD).wrapping_sub(3000);
    pulses.see(fell, fell.wrapping_add(6000));
    assert_eq!(pulses.seen.missing, 2);
}

#[test]
fn a_share_is_what_the_compare_value_says() {
    let pulses = of(&[3000, 4500], 0);
    assert_eq!(pulses.share(pulses.end.wrapping_add(100)), 0.5);
    assert_eq!(pulses.asked(pulses.end.wrapping_add(100)), 3000);
    assert_eq!(pulses.share(pulses.end.wrapping_add(3 * PERIOD)), 0.0);
    let [edge, change] = pulses.until(pulses.end.wrapping_add(7));
    assert_eq!((edge, change), (7, PERIOD - 4500 + 7));
}
