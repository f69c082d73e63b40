//! The image for the NUCLEO-H743ZI2: boot order and priorities, nothing else.
//!
//! Boot: motors off → why did we start → settings → tick → watchdog and supervisor → network. The tick runs, disarmed,
//! from the third step on; a network that never comes up stops nothing but itself.
//!
//! | file | holds |
//! |---|---|
//! | `board/` | the only folder that knows the chip |
//! | `tick.rs` | the 1 kHz interrupt |
//! | `net.rs` | the 8 ms exchange with the other peer, sealed |
//! | `port.rs` | the operator's port, sealed |
//! | `console.rs` | what the operator's lines do: arm, stop, settings |
//! | `telemetry.rs` | what the ticks did, for the operator |
//! | `storage.rs` | saves settings to flash |
//! | `supervisor.rs` | feeds the watchdog while everything makes progress |
//! | `fault.rs` | when the program cannot go on |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the image is for the board: cargo build --release -p firmware --target thumbv7em-none-eabihf");
}

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod console;
#[cfg(target_os = "none")]
mod fault;
#[cfg(target_os = "none")]
mod net;
#[cfg(target_os = "none")]
mod port;
#[cfg(target_os = "none")]
mod storage;
#[cfg(target_os = "none")]
mod supervisor;
#[cfg(target_os = "none")]
mod telemetry;
#[cfg(target_os = "none")]
mod tick;

#[cfg(target_os = "none")]
mod image {
    use defmt_rtt as _;
    use embassy_executor::{InterruptExecutor, Spawner};
    use embassy_stm32::interrupt::{self, InterruptExt, Priority};
    use firmware_parts::kept::Kept;
    use static_cell::StaticCell;

    use crate::board::{self, pace};
    use crate::console::{self, Console};
    use crate::tick::Shared;
    use crate::{fault, net, storage, supervisor, tick};

    /// Supervisor: priority 2, below the tick and its bell, above the time driver (3) and Ethernet (4).
    static SUPERVISOR: InterruptExecutor = InterruptExecutor::new();
    /// Network: priority 5.
    static NETWORK: InterruptExecutor = InterruptExecutor::new();

    #[unsafe(no_mangle)]
    extern "C" fn UART4() {
        // SAFETY: the interrupt that [`SUPERVISOR`] was started on.
        unsafe { SUPERVISOR.on_interrupt() }
    }

    #[unsafe(no_mangle)]
    extern "C" fn UART5() {
        // SAFETY: the interrupt that [`NETWORK`] was started on.
        unsafe { NETWORK.on_interrupt() }
    }

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let board = board::init();
        let cause = fault::cause();
        defmt::info!("board {}: {=str}", board.number, cause.stop.explain());

        let fits = |kept: &Kept| console::plan(&kept.settings, board.number).is_ok();
        let (store, kept, origin) = storage::load(&board.flash, fits);
        let Ok(plan) = console::plan(&kept.settings, board.number) else { defmt::panic!("the defaults are refused") };
        static SHARED: StaticCell<Shared> = StaticCell::new();
        let tasks = tick::prepare(SHARED.init_with(|| Shared::new(plan)));
        pace::start(board.pace);

        interrupt::UART4.set_priority(Priority::P2);
        interrupt::UART5.set_priority(Priority::P5);
        SUPERVISOR.start(interrupt::UART4).spawn(defmt::unwrap!(supervisor::run(
            board.watchdog,
            board.alive,
            board.armed
        )));

        let console = Console {
            number: board.number,
            cause,
            unacknowledged: cause.stop.latches(),
            origin,
            applied: kept,
            draft: kept,
            device: 0,
            plans: tasks.plans,
            orders: 0,
            probes: tasks.probes,
            probed: tasks.probed,
        };
        NETWORK.start(interrupt::UART5).spawn(defmt::unwrap!(net::start(
            board.ethernet,
            board.number,
            tasks.outgoing,
            tasks.incoming,
            tasks.records,
            console,
        )));
        // Thread mode, below everything: programming flash may take its time.
        spawner.spawn(defmt::unwrap!(storage::run(board.flash, store)));
    }
}
