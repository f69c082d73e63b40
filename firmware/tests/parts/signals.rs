//! Words: what is put in comes out.

use cohold_core::safety::{Command, Fault, Mode};
use cohold_protocol::link::Stage;
use firmware_parts::signals::{Coded, Order, Saving, Signals};

/// Code and value lead to each other, and no two values share a code.
fn all_distinct<T: Coded + PartialEq + core::fmt::Debug>(all: &[T]) {
    let signals = all.iter().map(|value| (value, value.code()));
    for (value, code) in signals.clone() {
        assert_eq!(T::decode(code), *value);
        assert_eq!(signals.clone().filter(|(_, other)| *other == code).count(), 1, "{value:?}");
    }
}

#[test]
fn words_carry_what_was_put_in() {
    let modes = [Mode::Disarmed, Mode::Armed, Mode::Probing].into_iter();
    let modes = modes.chain(Fault::ALL.into_iter().map(Mode::Faulted));
    all_distinct(&modes.collect::<Vec<_>>());
    all_distinct(&[Saving::Done, Saving::Busy, Saving::Failed]);
    all_distinct(&[Stage::Calling, Stage::Joining, Stage::Idle, Stage::Running, Stage::Fading, Stage::Refused]);
    all_distinct(&[false, true]);
    assert_eq!(Mode::Faulted(Fault::PeerLost).code(), 0x0502, "as records have it");

    let signals = Signals::at_power_on();
    assert_eq!(
        (signals.mode.get(), signals.saving.get(), signals.stage.get()),
        (Mode::Disarmed, Saving::Done, Stage::Calling)
    );
    assert_eq!((signals.order.get().command, signals.order.get()), (Command::Disarm, signals.done.get()));
}

#[test]
fn the_same_command_given_again_is_another_order() {
    let signals = Signals::at_power_on();
    for command in [
        Command::Arm,
        Command::Arm,
        Command::Disarm,
        Command::Clear,
        Command::Clear,
        Command::Home,
        Command::Clutch,
        Command::Release,
    ] {
        let order = signals.order.get().next(command);
        signals.order.release(order);
        assert!(signals.order.acquire() == order && signals.done.acquire() != order);
        assert_eq!(signals.order.acquire().command, command);
        signals.done.release(signals.order.acquire());
        assert!(signals.done.acquire() == order);
    }
    // Numbers come round.
    let last = Order::decode(0xFFFF_FF00 | Order::decode(0).next(Command::Arm).code() & 0xFF);
    all_distinct(&[last, last.next(Command::Arm), last.next(Command::Arm).next(Command::Arm)]);
}
