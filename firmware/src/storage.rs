//! Storage: saves settings when the console asks, and notes faults, in thread mode, where nothing waits for it.
//!
//! While it is at work the motors stay off ([`Saving::Busy`] refuses arming), and saving is asked for only while they are.

use embassy_futures::select::{Either, select};
use embassy_sync::channel::Channel;
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use firmware_parts::signals::{Saving, Signals};
use firmware_parts::store::{Store, Word};
use firmware_parts::{history::FAULTS, kept::Kept};

use crate::{board::flash, log::log};

static ASKED: Signal<CriticalSectionRawMutex, Kept> = Signal::new();
/// Words of the board's history, and where they go: room for all of one start.
static NOTES: Channel<CriticalSectionRawMutex, (u32, Word), { FAULTS as usize }> = Channel::new();

/// Has a word of the board's history programmed.
pub(crate) fn note(entry: (u32, Word)) {
    let _ = NOTES.try_send(entry);
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// They were stored in flash.
    Stored,
    /// The image: nothing is stored.
    Defaults,
    /// The image: what is stored is not for it.
    Refused,
}

impl Origin {
    pub(crate) fn explain(self) -> &'static str {
        match self {
            Self::Stored => "stored",
            Self::Defaults => "defaults",
            Self::Refused => "defaults, the stored ones are refused",
        }
    }
}

/// What is stored, if `fits` finds nothing against it; the defaults otherwise, of which a hold-to-run switch that was there is left.
pub(crate) fn load(flash: &flash::Settings, signals: &Signals, fits: impl Fn(&Kept) -> bool) -> (Store, Kept, Origin) {
    let store = Store::open(flash);
    signals.saves.set(store.generation());
    let (kept, origin) = match store.load(flash) {
        None => (Kept::default(), Origin::Defaults),
        Some(Ok(kept)) if fits(&kept) => (kept, Origin::Stored),
        Some(Ok(Kept { hold_switch, .. })) => {
            log!(error, "the stored settings do not fit this image: defaults");
            (Kept { hold_switch, ..Kept::default() }, Origin::Refused)
        }
        Some(Err(unreadable)) => {
            let line = unreadable.line.as_str();
            log!(error, "the stored settings have a line that means nothing: {}: defaults", line);
            (Kept { hold_switch: unreadable.hold_switch, ..Kept::default() }, Origin::Refused)
        }
    };
    log!(info, "settings {}: {}", store.generation(), origin.explain());
    (store, kept, origin)
}

/// Asks for a save; false while one is under way.
pub(crate) fn save(signals: &Signals, kept: &Kept) -> bool {
    if signals.saving.acquire() == Saving::Busy {
        return false;
    }
    signals.saving.release(Saving::Busy);
    ASKED.signal(*kept);
    true
}

#[embassy_executor::task]
pub(crate) async fn run(mut flash: flash::Settings, mut store: Store, signals: &'static Signals) -> ! {
    loop {
        let kept = match select(ASKED.wait(), NOTES.receive()).await {
            Either::First(kept) => kept,
            Either::Second(entry) => {
                if flash.note(entry).is_err() {
                    log!(error, "a fault could not be noted: the flash does not take it");
                }
                continue;
            }
        };
        let saving = match store.save(&mut flash, &kept).await {
            Ok(generation) => {
                signals.saves.set(generation);
                log!(info, "settings {} saved", generation);
                Saving::Done
            }
            Err(_) => {
                log!(error, "the settings could not be saved: the flash does not take them");
                Saving::Failed
            }
        };
        signals.saving.release(saving);
    }
}
