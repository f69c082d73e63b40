//! The hold-to-run switch: what holds it, and what one look does.

use cohold_core::safety::Mode;
use firmware_parts::record::mode_code;
use firmware_parts::signals::Signals;
use firmware_parts::switch::{STEADY, Switch};

/// Looks at a contact that is closed, or not, so many times; whether it is held then.
fn looks(switch: &Switch, signals: &Signals, closed: bool, times: u32) -> bool {
    (0..times).for_each(|_| switch.see(signals, closed));
    signals.held.get()
}

#[test]
fn a_steady_press_holds_it_and_nothing_shorter() {
    let (switch, signals) = (Switch::unseen(), Signals::at_power_on());
    assert!(!looks(&switch, &signals, false, 1));
    assert!(!looks(&switch, &signals, true, STEADY - 1));
    assert!(looks(&switch, &signals, true, 1));
    assert!(looks(&switch, &signals, true, 1_000_000), "as long as it is closed");
    // It bounces: each closing begins anew.
    for _ in 0..3 {
        assert!(!looks(&switch, &signals, false, 1));
        assert!(!looks(&switch, &signals, true, STEADY - 1));
    }
}

#[test]
fn one_that_was_closed_before_the_start_holds_nothing_until_it_was_open() {
    let (switch, signals) = (Switch::unseen(), Signals::at_power_on());
    assert!(!looks(&switch, &signals, true, 10 * STEADY));
    assert!(!looks(&switch, &signals, false, 1));
    assert!(looks(&switch, &signals, true, STEADY));
}

#[test]
fn one_look_that_finds_it_open_turns_off_what_is_on_where_it_is_asked_for() {
    for (mode, by_switch, off) in [
        (Mode::Armed, true, true),
        (Mode::Probing, true, true),
        (Mode::Armed, false, false),
        (Mode::Disarmed, true, false),
    ] {
        let (switch, signals) = (Switch::unseen(), Signals::at_power_on());
        signals.by_switch.set(by_switch);
        looks(&switch, &signals, false, 1);
        looks(&switch, &signals, true, STEADY);
        signals.mode.set_code(mode_code(mode));
        assert!(looks(&switch, &signals, true, 5));
        assert!(!signals.disarm.get() && !signals.released.get(), "{mode:?}: held");
        looks(&switch, &signals, false, 1);
        assert_eq!((signals.disarm.get(), signals.released.get()), (off, off), "{mode:?}");
    }
}
