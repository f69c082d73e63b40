//! Devices that are sold, as a live peer drives them ([`ADAPTERS`]), and `devices emulate`, which stands in for one that is not there.
//!
//! | adapter | what it speaks to |
//! |---|---|
//! | `haply` | an Inverse3 behind Haply's local WebSocket service, 3.5 or newer |
//! | `moteus` | one to three moteus motors on a CAN bus, which drive the scene's mechanism |
//! | `mit` | one to three Damiao or T-Motor motors that take MIT's frame, likewise |
#![forbid(unsafe_code)]

mod can;
mod emulate;
mod find;
mod haply;
mod mechanism;
mod mit;
mod moteus;
mod motors;

use std::time::Duration;

use cohold_live::devices::Adapter;

pub use emulate::Emulation;

/// Most attempts to reach the program behind a device, which may be starting, and the pause between two.
const LOOKS: (usize, Duration) = (100, Duration::from_millis(50));

/// The last result of the attempts to reach it.
fn once_there<T, E>(look: impl Fn() -> Result<T, E>) -> Result<T, E> {
    for _ in 1..LOOKS.0 {
        match look() {
            Err(_) => std::thread::sleep(LOOKS.1),
            found => return found,
        }
    }
    look()
}

/// The adapters of these devices, and how each looks for what is attached.
pub const ADAPTERS: [Adapter; 3] = [
    Adapter {
        name: "haply",
        place: "[:ADDRESS:PORT]",
        check: |at, _| haply::place(at).map(drop),
        open: haply::open,
        look: find::services,
    },
    Adapter {
        name: "moteus",
        place: ":BUS",
        check: |at, _| motors::is_named(at),
        open: moteus::open,
        look: find::buses,
    },
    Adapter {
        name: "mit",
        place: ":BUS",
        check: |at, options| motors::is_named(at).and_then(|()| mit::model(options).map(drop)),
        open: mit::open,
        look: |_| Vec::new(),
    },
];
