//! What the board says at its serial port, once a second, to whoever has opened it: what stands against arming, and its status.
//!
//! Text for a person, no key needed and no probe; nothing is heard there. Orders come by the sealed port ([`crate::port`]) alone. A reader
//! who does not read holds nobody: what he has not taken in [`PATIENCE`] is dropped, and who speaks here never waits.

use cohold_protocol::lines::Line;
use embassy_executor::Spawner;
use embassy_futures::select::{Either, select};
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use embassy_time::{Duration, Instant, Timer, with_timeout};

use crate::{board::cable::Serial, console::Console};

const PERIOD: Duration = Duration::from_secs(1);
const PATIENCE: Duration = Duration::from_millis(500);
/// A packet that is full would say that more comes.
const PART: usize = 63;

/// The newest of what is to be said.
static SAYS: Signal<CriticalSectionRawMutex, Line> = Signal::new();

/// What is said from now on, until something else is.
pub(crate) fn say(text: &str) {
    let mut line = Line::new();
    // The longest of them has room.
    let _ = line.push_str(text);
    SAYS.signal(line);
}

/// Tells once a second how the board is.
pub(crate) struct Teller {
    next: Instant,
}

impl Teller {
    pub(crate) fn new() -> Self {
        Self { next: Instant::now() }
    }

    /// To be called now and then.
    pub(crate) fn look(&mut self, console: &Console) {
        if Instant::now() >= self.next {
            self.next += PERIOD;
            let mut line = Line::new();
            // What does not fit is cut: the first words say what matters.
            let _ = console.tell(&mut line);
            SAYS.signal(line);
        }
    }
}

/// Begins to say it.
pub(crate) fn start(serial: Serial, spawner: &Spawner) {
    spawner.spawn(defmt::unwrap!(run(serial)));
}

#[embassy_executor::task]
async fn run(serial: Serial) -> ! {
    let (mut to, _) = serial.split();
    let mut line = Line::new();
    loop {
        // What nobody says anew is said again, for who opens the port late.
        if let Either::First(new) = select(SAYS.wait(), Timer::after(2 * PERIOD)).await {
            line = new;
        }
        if !to.dtr() {
            continue;
        }
        let saying = async {
            for part in line.as_bytes().chunks(PART).chain([&b"\r\n"[..]]) {
                // The cable is out.
                if to.write_packet(part).await.is_err() {
                    break;
                }
            }
        };
        let _ = with_timeout(PATIENCE, saying).await;
    }
}
