//! Motors stay on while an operator is there, and not a tick longer than he may be silent.

use firmware_parts::hold::{let_go, note, patience};
use firmware_parts::signals::Signals;
use haptic_core::safety::{Fault, Mode};

const PATIENCE: u32 = 500;

/// On since tick `start`, with an operator who is heard every 100 ticks up to `gone` ticks later; when the motors are let go of.
fn run(mode: Mode, patience: u32, start: u32, gone: u32) -> Option<u32> {
    let signals = Signals::at_power_on();
    signals.mode.set(mode);
    signals.patience.set(patience);
    (0..3000).find(|after| {
        signals.ticks.set(start.wrapping_add(*after));
        if after % 100 == 0 && *after <= gone {
            signals.consented.set(signals.ticks.get());
            signals.consent.set(true);
        }
        let over = let_go(&signals);
        assert_eq!((signals.disarm.acquire(), signals.let_go.get()), (over, over));
        over
    })
}

#[test]
fn motors_go_off_when_the_operator_has_been_silent() {
    // The count of ticks wraps every seven weeks.
    for start in [0, 7, u32::MAX - 200, u32::MAX - 1000] {
        for mode in [Mode::Armed, Mode::Probing] {
            assert_eq!(run(mode, PATIENCE, start, 0), Some(PATIENCE + 1));
            assert_eq!(run(mode, PATIENCE, start, 1200), Some(1200 + PATIENCE + 1));
            assert_eq!(run(mode, PATIENCE, start, 3000), None, "he is there");
        }
        assert_eq!(run(Mode::Armed, 0, start, 0), None, "armed alone");
        for mode in [Mode::Disarmed, Mode::Faulted(Fault::PeerLost)] {
            assert_eq!(run(mode, PATIENCE, start, 0), None, "nothing is on");
        }
    }
}

/// A yes counts from the newest time of the board's that the operator knew, and a no at once.
#[test]
fn what_the_operator_says_counts_from_when_it_was_said() {
    const LEASE: u32 = 200;
    let signals = Signals::at_power_on();
    signals.mode.set(Mode::Armed);
    signals.patience.set(patience(LEASE));
    signals.ticks.set(9000);
    // On a path of 190 ms there and back there is hardly anything left of the lease.
    note(&signals, 9_000_000, Some(8_810_000));
    assert!(!let_go(&signals));
    signals.ticks.set(9000 + 10);
    assert!(let_go(&signals), "off within the lease, the supervisor's look and the tick that does it included");
    note(&signals, 9_010_000, Some(9_010_000));
    assert!(!let_go(&signals));
    note(&signals, 9_010_000, None);
    assert!(let_go(&signals) && !signals.let_go.get(), "taken back, which is no silence");
    // Armed alone, nobody need let it.
    signals.patience.set(0);
    assert!(!let_go(&signals));
    // However old it is, it is not of the future.
    signals.patience.set(patience(LEASE));
    note(&signals, u64::MAX, Some(0));
    assert!(let_go(&signals));
}

/// The port may note a tick that the supervisor has not seen yet.
#[test]
fn who_was_heard_just_now_is_there() {
    let signals = Signals::at_power_on();
    signals.mode.set(Mode::Armed);
    signals.patience.set(PATIENCE);
    signals.ticks.set(9000);
    signals.consented.set(9002);
    signals.consent.set(true);
    assert!(!let_go(&signals));
}
