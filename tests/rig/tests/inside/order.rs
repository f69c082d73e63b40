//! Lines that are orders, and lines that are none.

use super::*;

#[test]
fn a_line_is_an_order_or_none() {
    for (line, order) in [
        ("who", Some(Order::Who)),
        ("gate 8", Some(Order::Gate(8))),
        ("device sweep 10 2 800", Some(Order::Device(Moves::Sweep(10, 2, 800)))),
        ("pulses 4000 20", Some(Order::Pulses(4000, 20))),
        ("winding", Some(Order::Winding)),
        ("pull  stop ", Some(Order::Pull(Line::Stop))),
        ("turn 2 1000 down", Some(Order::Turn(1, 1000, false))),
        ("cut 1 B", Some(Order::Cut(0, true))),
        ("volts 4095", Some(Order::Volts(4095))),
        ("volts 4096", None),
        ("fall 2707 2200", Some(Order::Fall(2707, 2200))),
        ("fall 4096 2200", None),
        ("stop open", Some(Order::Stop(true))),
        ("turn 3 1 up", None),
        ("pulses 4000", None),
        ("pulses -1 20", None),
        ("pulses 4294967297 20", None),
        ("who else", None),
        ("", None),
    ] {
        assert_eq!(Order::read(line.as_bytes()), order, "{line:?}");
    }
}

#[test]
fn numbers_are_written_as_they_are_read_and_a_line_ends_at_its_end() {
    for value in [0, 7, 10, 240_000_000, u32::MAX] {
        assert_eq!(Text::of("ok").number(value).bytes(), format!("ok {value}").as_bytes());
    }
    let mut text = Text::default();
    (0..200).for_each(|_| text.push(b'x'));
    assert_eq!(text.bytes().len(), LONGEST);
}
