//! Emulators as these tests start them: with a hand that trembles or not, each at a place of its own.

use std::net::Ipv4Addr;
use std::path::Path;

use cohold_devices::emulators::carrier::Place;
use cohold_devices::emulators::hand::Hand;
use cohold_devices::emulators::{inverse3, mit, moteus, motors};
use cohold_live::endpoint::realtime_beneath;

/// Starts it in a thread with a real-time priority, which its own threads inherit: a device has a processor of its own.
fn promptly<E: Send>(start: impl FnOnce() -> std::io::Result<E> + Send) -> E {
    let starting = || {
        realtime_beneath();
        start().expect("its place is free")
    };
    std::thread::scope(|scope| scope.spawn(starting).join().expect("it starts"))
}

/// Haply's service at any port of loopback.
pub(crate) fn haply(tremor_m: f64) -> inverse3::Emulator {
    let at = (Ipv4Addr::LOCALHOST, 0).into();
    promptly(|| inverse3::Emulator::start(at, Hand::new(tremor_m), inverse3::HOLDS_S))
}

/// moteus motors behind an fdcanusb.
pub(crate) fn fdcanusb() -> motors::Emulator {
    promptly(|| moteus::start(&Place::Serial(None), Hand::new(0.0)))
}

/// moteus motors on a bus whose frames a socket of this name carries.
pub(crate) fn moteus(name: &str) -> motors::Emulator {
    promptly(|| moteus::start(&socket(name), Hand::new(0.0)))
}

/// MIT motors on such a bus, which disable themselves after so long without a frame, s.
pub(crate) fn mit(name: &str, timeout_s: f64) -> motors::Emulator {
    promptly(|| mit::start(&socket(name), Hand::new(0.0), timeout_s))
}

/// In a folder of this test program's own.
fn socket(name: &str) -> Place {
    Place::Socket(Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}.can", std::process::id())))
}
