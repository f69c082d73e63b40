//! Motors stay on while an operator is there, and not a tick longer than he may be silent.

use firmware_parts::hold::let_go;
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
            signals.heard.set(signals.ticks.get());
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

/// The port may note a tick that the supervisor has not seen yet.
#[test]
fn who_was_heard_just_now_is_there() {
    let signals = Signals::at_power_on();
    signals.mode.set(Mode::Armed);
    signals.patience.set(PATIENCE);
    signals.ticks.set(9000);
    signals.heard.set(9002);
    assert!(!let_go(&signals));
}
