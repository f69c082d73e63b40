//! Pins of the chip by name, edges on them, and which timer's input each leads to.
//!
//! The emulator has no wire from a pin to a timer: this is it, and it leads nowhere unless the image has set the pin to that alternate function.

use rigless::device::Level;
use rigless::soc::stm32h743::peripherals::gpio::Pin;
use serde::{Deserialize, Serialize};

/// A pin: its port, 0 for A, and its number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Place {
    /// The port.
    pub port: u8,
    /// The pin in it.
    pub number: u8,
}

impl Place {
    /// The pin of a name such as `PE14`.
    ///
    /// # Panics
    /// It is none.
    pub const fn of(name: &str) -> Self {
        let name = name.as_bytes();
        assert!(name.len() >= 3 && name.len() <= 4 && name[0] == b'P', "a pin is a P, a port and a number");
        let tens = if name.len() == 4 { name[2] - b'0' } else { 0 };
        Self { port: name[1] - b'A', number: 10 * tens + name[name.len() - 1] - b'0' }
    }

    /// The pin as its port knows it.
    pub(super) fn pin(self) -> Pin {
        Pin::new(self.number).expect("ports have 16 pins")
    }
}

/// A level that a pin takes at an instant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// When, ns.
    pub at: u64,
    /// Where.
    pub place: Place,
    /// High, or low.
    pub high: bool,
}

/// The emulator's name of a level.
pub(super) fn level(high: bool) -> Level {
    if high { Level::High } else { Level::Low }
}

/// The pins that lead to a timer's input: which of the encoders' timers, its channel, and the alternate function that leads there.
const INPUTS: [(Place, usize, u8, u8); 10] = [
    (Place::of("PC6"), 0, 1, 2),
    (Place::of("PC7"), 0, 2, 2),
    (Place::of("PC8"), 0, 3, 2),
    (Place::of("PD12"), 1, 1, 2),
    (Place::of("PD13"), 1, 2, 2),
    (Place::of("PD14"), 1, 3, 2),
    (Place::of("PA5"), 2, 1, 1),
    (Place::of("PB3"), 2, 2, 1),
    (Place::of("PB10"), 2, 3, 1),
    (Place::of("PB11"), 2, 4, 1),
];

/// Which timer's input a pin leads to, if any: timer, channel, alternate function.
pub(super) fn input(place: Place) -> Option<(usize, u8, u8)> {
    INPUTS.iter().find(|(pin, ..)| *pin == place).map(|(_, timer, channel, function)| (*timer, *channel, *function))
}

/// What a write to a port's set/reset register does to its pins.
pub(crate) fn written(at: u64, address: u64, value: u64) -> Vec<Edge> {
    let Some(offset) = address.checked_sub(0x5802_0000).filter(|offset| offset % 0x400 == 0x18) else {
        return Vec::new();
    };
    let port = (offset / 0x400) as u8;
    let edges = (0..16).filter(|number| (value >> number | value >> (number + 16)) & 1 != 0);
    edges.map(|number| Edge { at, place: Place { port, number }, high: value >> number & 1 != 0 }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_write_sets_and_resets_the_pins_that_it_says() {
        let edge = |name, high| Edge { at: 5, place: Place::of(name), high };
        assert_eq!(written(5, 0x5802_1018, 1 << 15 | 1 << 22), [edge("PE6", false), edge("PE15", true)]);
        assert_eq!(written(5, 0x5802_1014, 1), []);
        assert_eq!(written(5, 0x4001_0018, 1), []);
    }
}
