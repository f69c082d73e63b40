//! Emulators as these tests start them: with a hand that trembles or not, each at a place of its own.

use std::net::Ipv4Addr;
use std::path::Path;

use haptic_emulators::carrier::Place;
use haptic_emulators::hand::Hand;
use haptic_emulators::{inverse3, mit, moteus};

/// Haply's service at any port of loopback.
pub(crate) fn haply(tremor_m: f64) -> inverse3::Emulator {
    let at = (Ipv4Addr::LOCALHOST, 0).into();
    inverse3::Emulator::start(at, Hand::new(tremor_m), inverse3::HOLDS_S).expect("a socket on loopback")
}

/// moteus motors behind an fdcanusb.
pub(crate) fn fdcanusb() -> moteus::Emulator {
    moteus::Emulator::start(&Place::Serial(None), Hand::new(0.0)).expect("a pseudo-terminal")
}

/// moteus motors on a bus whose frames a socket of this name carries.
pub(crate) fn moteus(name: &str) -> moteus::Emulator {
    moteus::Emulator::start(&socket(name), Hand::new(0.0)).expect("a socket")
}

/// MIT motors on such a bus, which disable themselves after so long without a frame, s.
pub(crate) fn mit(name: &str, timeout_s: f64) -> mit::Emulator {
    mit::Emulator::start(&socket(name), Hand::new(0.0), timeout_s).expect("a socket")
}

/// In a folder of this test program's own.
fn socket(name: &str) -> Place {
    Place::Socket(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}.can", std::process::id())))
}
