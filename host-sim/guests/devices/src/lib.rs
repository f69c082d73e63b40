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
pub mod emulators;
mod find;
mod haply;
mod mechanism;
mod mit;
mod moteus;
mod motors;

use std::time::{Duration, Instant};

use cohold_cli::Cli;
use cohold_live::devices::Adapter;

use emulate::Emulation;

/// How long a program behind a device may take to start, and the pause between two attempts to reach it.
const STARTS: [Duration; 2] = [Duration::from_secs(5), Duration::from_millis(50)];

/// The first success, or the failure of the last attempt.
fn once_there<T, E>(reach: impl Fn() -> Result<T, E>) -> Result<T, E> {
    let by = Instant::now() + STARTS[0];
    loop {
        match reach() {
            Err(_) if Instant::now() < by => std::thread::sleep(STARTS[1]),
            reached => return reached,
        }
    }
}

/// Adds these devices to a command line.
pub fn join(cli: Cli) -> Cli {
    cli.with_adapters(&ADAPTERS).with_commands::<Emulation>("devices")
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
