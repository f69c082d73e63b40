//! An end of a line with a device of any kind: the emulator of each, by what they have in common.

use cohold_devices::emulators::{Emulated as _, inverse3, motors};

use super::board::Lab;
use super::emulated::{self, fdcanusb, haply};

/// The emulators, by the names of their adapters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Haply,
    Moteus,
    Mit,
    Board,
}

/// An emulated device and the hand on it.
pub(crate) enum End {
    Haply(inverse3::Emulator),
    Motors(motors::Emulator),
    /// A board, and the file of the key that it shares with its peer.
    Board(Lab, String),
}

impl End {
    /// The hand does not tremble, and a force stands for 0.2 s, which a busy machine may take to speak again.
    pub(crate) fn start(kind: Kind, key: &str, number: u8) -> Self {
        match kind {
            Kind::Haply => Self::Haply(haply(0.0)),
            Kind::Moteus => Self::Motors(fdcanusb()),
            Kind::Mit => Self::Motors(emulated::mit(&format!("end-{number}-mit"), 0.2)),
            Kind::Board => Self::Board(Lab::start(key, number, &[], 0.0), key.to_owned()),
        }
    }

    /// Flags of a peer that has it.
    pub(crate) fn flags(&self) -> Vec<String> {
        let (mut flags, lets_go) = match self {
            Self::Haply(emulator) => (vec!["--device".to_owned(), format!("haply:{}", emulator.at)], Some("0.2")),
            Self::Motors(bus) => {
                let words = bus.words();
                // MIT's motors have theirs in a register.
                let lets_go = words[1].starts_with("moteus:").then_some("0.2");
                (words, lets_go)
            }
            Self::Board(lab, key) => (lab.flags(key), None),
        };
        flags.extend(lets_go.into_iter().flat_map(|time_s| ["--device-lets-go-s", time_s]).map(str::to_owned));
        flags.extend(["--device-silent-s", "0.2"].map(str::to_owned));
        flags
    }

    /// The hand goes there along x, m.
    pub(crate) fn reach(&self, to_m: f64) {
        match self {
            Self::Haply(emulator) => emulator.world().reach([to_m, 0.0, 0.0]),
            Self::Motors(bus) => bus.world().hand.reach([to_m, 0.0]),
            Self::Board(lab, _) => lab.world().hand.reach([to_m]),
        }
    }

    /// What the device pushes the hand with along x, N.
    pub(crate) fn force_n(&self) -> f64 {
        match self {
            Self::Haply(emulator) => emulator.world().advance()[0],
            Self::Motors(bus) => bus.world().advance()[0],
            Self::Board(lab, _) => lab.mean_n(0.01),
        }
    }
}
