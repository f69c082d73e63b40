//! Both ends of reliable events, without a link.

use crate::reliable::{Receiver, Sender};
use crate::wire::{Ack, Event};

fn event(code: u32) -> Event {
    Event::new(code as u16, &code.to_le_bytes()).unwrap()
}

#[test]
fn an_event_is_repeated_after_the_round_trip_and_ever_more_rarely() {
    let mut sender = Sender::default();
    sender.push(event(7)).unwrap();
    let mut times = vec![];
    for now in (0..10_000_000).step_by(1_000) {
        if sender.due(now, 20_000).is_some() {
            times.push(now / 1_000);
        }
    }
    assert_eq!(times[..8], [0, 20, 60, 140, 300, 620, 1260, 2260]);
    sender.acknowledge(&Ack { next: 1, ahead: 0 });
    assert_eq!(sender.due(20_000_000, 0), None);
}

#[test]
fn numbers_wrap_and_nonsense_is_ignored() {
    let (mut sender, mut receiver) = (Sender::default(), Receiver::default());
    // An acknowledgement of what was never sent, and events from far away.
    sender.push(event(0)).unwrap();
    for next in [9, 1_000, 1 << 31] {
        sender.acknowledge(&Ack { next, ahead: u32::MAX });
        assert_eq!(sender.under_way(), 1);
        receiver.receive(event(1).numbered(next.max(8)));
        assert_eq!(receiver.take(), None);
    }
    assert_eq!(receiver.ack(), Ack { next: 0, ahead: 0 });
    // Out of order, twice each: in order, once.
    for number in [3, 1, 1, 5, 0, 3, 7, 2, 0] {
        receiver.receive(event(number).numbered(number));
    }
    assert_eq!(receiver.ack(), Ack { next: 4, ahead: 0b101 });
    assert_eq!(std::iter::from_fn(|| receiver.take()).map(|event| event.number).collect::<Vec<_>>(), [0, 1, 2, 3]);
    assert_eq!(receiver.ack(), Ack { next: 4, ahead: 0b101 });
    // A full window.
    for number in 4..12 {
        receiver.receive(event(number).numbered(number));
    }
    assert_eq!(receiver.ack(), Ack { next: 12, ahead: 0 });
    receiver.receive(event(12).numbered(12));
    assert_eq!(receiver.ack(), Ack { next: 12, ahead: 0 });
}
