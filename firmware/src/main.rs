//! The image for a board of [`boards`]: boot order and priorities, nothing else.
//!
//! Boot: motors off → why did we start → settings → tick → watchdog and supervisor → network. The tick runs, disarmed,
//! from the third step on; a network that never comes up stops nothing but itself.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the image is for the board: cargo build --release -p firmware --target thumbv7em-none-eabihf");
}

#[cfg(target_os = "none")]
mod board;
#[cfg(target_os = "none")]
mod boards;
#[cfg(target_os = "none")]
mod console;
#[cfg(target_os = "none")]
mod fault;
#[cfg(target_os = "none")]
mod flow;
#[cfg(target_os = "none")]
mod lease;
#[cfg(target_os = "none")]
mod log;
#[cfg(target_os = "none")]
mod net;
#[cfg(target_os = "none")]
mod port;
#[cfg(target_os = "none")]
#[cfg_attr(not(feature = "usb"), path = "no_serial.rs")]
mod serial;
#[cfg(target_os = "none")]
mod sockets;
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
    use core::mem::MaybeUninit;

    use cohold_core::device::probe::{Outcome, Probe};
    use defmt_rtt as _;
    use embassy_executor::{InterruptExecutor, Spawner};
    use embassy_stm32::interrupt::{self, InterruptExt, Priority};
    use firmware_parts::exchange::{Latest, Queue};
    use firmware_parts::image::Real;
    use firmware_parts::recorder::{self, Reel};
    use firmware_parts::{kept::Kept, record::Record, signals::Signals, status};
    use static_cell::StaticCell;

    use crate::board::drive::{Drive, Fitted};
    use crate::board::{self, current, pace, random, switch};
    use crate::console::{self, Console};
    use crate::lease::Lease;
    use crate::log::log;
    use crate::telemetry::{self, Telemetry};
    use crate::tick::{self, Outgoing, Plan, Received};
    use crate::{fault, net, storage, supervisor};

    /// The words that interrupt and tasks share. Has a name in the image for debuggers and tests/board.
    #[unsafe(no_mangle)]
    static SIGNALS: Signals = Signals::at_power_on();

    /// A cell or queue that lives for ever, and its two sides.
    macro_rules! shared {
        ($type:ty, $value:expr) => {{
            static PLACE: StaticCell<$type> = StaticCell::new();
            PLACE.init_with(|| $value).split()
        }};
    }

    #[unsafe(link_section = ".axi.reels")]
    static mut REELS: [MaybeUninit<Reel>; 3] = [const { MaybeUninit::uninit() }; 3];

    /// The reels, put in order for this start.
    fn reels(stop: status::Stop) -> [&'static mut Reel; 3] {
        // SAFETY: any bits make a Reel, of whole numbers; called once, before anything else knows of them.
        let reels = unsafe { (&raw mut REELS).as_mut_unchecked().each_mut().map(|reel| reel.assume_init_mut()) };
        recorder::after(stop, reels)
    }

    /// An executor, and the interrupt that it runs on, whose peripheral nothing uses.
    macro_rules! executor {
        ($name:ident on $interrupt:ident) => {
            static $name: InterruptExecutor = InterruptExecutor::new();

            #[unsafe(no_mangle)]
            extern "C" fn $interrupt() {
                // SAFETY: the interrupt that the executor was started on.
                unsafe { $name.on_interrupt() }
            }
        };
    }

    // Priority 3, below the tick and its bell, above the time driver (4) and Ethernet or USB (5).
    executor!(SUPERVISOR on UART4);
    // Priority 6.
    executor!(NETWORK on UART5);

    #[embassy_executor::main]
    async fn main(spawner: Spawner) {
        let mut board = board::init();
        let cause = fault::cause();
        let mut history = board.flash.history();
        // Before anything is drawn: no two starts draw the same.
        let _ = history.start(cause.stop).map(|entry| board.flash.note(entry));
        random::start(board.random, history.used);
        if cause.stop.lost_memory() {
            current::forget_runs();
        }
        log!(info, "board {}: {}", board.number.peer().0, cause.stop.explain());
        if let Some(why) = board.unfit {
            log!(error, "not to be armed: {}", why);
        }

        let fits = |kept: &Kept| console::plan(&kept.settings, board.number).is_ok();
        let (store, kept, origin) = storage::load(&board.flash, &SIGNALS, fits);
        let Ok(plan) = console::plan(&kept.settings, board.number) else { defmt::panic!("the defaults are refused") };
        let (plans, plans_out) = shared!(Latest<Plan>, Latest::new(plan));
        let (incoming, incoming_out) = shared!(Latest<Received>, Latest::new(Received::default()));
        let (outgoing_in, outgoing) = shared!(Latest<Outgoing>, Latest::new(Outgoing::default()));
        let (reels_in, reels) = shared!(Latest<&'static mut Reel>, Latest::of(reels(cause.stop)));
        let (records_in, records_out) = shared!(Queue<Record, { tick::RECORDS }>, Queue::default());
        let (told_in, told) = shared!(Queue<Record, { telemetry::RECORDS }>, Queue::default());
        let (probes, probes_out) = shared!(Latest<(u32, Probe<Real>)>, Latest::new((0, Probe::default())));
        let (probed_in, probed) = shared!(Latest<Outcome>, Latest::new(Outcome::default()));
        tick::prepare(tick::Side {
            drive: Fitted::start(&SIGNALS),
            plans: plans_out,
            incoming: incoming_out,
            outgoing: outgoing_in,
            records: records_in,
            probes: probes_out,
            probed: probed_in,
            signals: &SIGNALS,
        });
        SIGNALS.by_switch.set(kept.hold_switch);
        switch::start(board.switch, &SIGNALS);
        telemetry::prepare(telemetry::Recorder {
            from: records_out,
            reels: reels_in,
            to: told_in,
            signals: &SIGNALS,
            asked: false,
            until: 0,
            on: false,
        });
        pace::start(board.pace, board.halts, plan.rate);

        interrupt::UART4.set_priority(Priority::P3);
        interrupt::UART5.set_priority(Priority::P6);
        static LEASE: StaticCell<Lease> = StaticCell::new();
        let lease = &*LEASE.init(Lease::new());
        let supervisor = SUPERVISOR.start(interrupt::UART4);
        supervisor.spawn(defmt::unwrap!(supervisor::run(
            board.watchdog,
            board.alive,
            board.armed,
            board.button,
            &SIGNALS,
            lease
        )));

        static CEILING: StaticCell<Kept> = StaticCell::new();
        let console = Console {
            number: board.number,
            cause,
            unacknowledged: cause.stop.latches(),
            unfit: board.unfit,
            contacts: Default::default(),
            history,
            faulted: false,
            origin,
            ceiling: CEILING.init(kept),
            applied: kept,
            draft: kept,
            device: 0,
            plans,
            signals: &SIGNALS,
            lease,
            word: Default::default(),
            probes,
            probed,
            leaves: None,
        };
        let telemetry = Telemetry::new(told, reels, &SIGNALS);
        let net = net::start(board.cable, board.number, outgoing, incoming, telemetry, console);
        NETWORK.start(interrupt::UART5).spawn(defmt::unwrap!(net));
        // Thread mode, below everything: programming flash may take its time.
        spawner.spawn(defmt::unwrap!(storage::run(board.flash, store, &SIGNALS)));
    }
}
