//! Flash bank 2: what the store and the keys are kept in, beside the program in bank 1.
//!
//! Either bank has a controller of its own, and one is read while the other programs or erases (RM0433 §4.3.4, table 15): the
//! program runs on from bank 1, the tick from ITCM anyway, and vectors are in bank 1 (banks are never swapped). An erase
//! takes 1–2 s; it is waited for between looks, so that tick, supervisor and network never notice. Programming a word takes
//! 0.1–0.3 ms and is waited for in place, in thread mode, which everything preempts.
//!
//! A word that power left half-programmed has two wrong bits as a rule, and reading it is a bus error. [`read`] looks with
//! faults ignored (CCR.BFHFNMIGN under FAULTMASK) and asks the controller whether the error correction gave up. For these
//! few instructions nothing else runs, the tick neither; it reads at boot and while disarmed.
//!
//! Own code and not embassy-stm32's: that clears errors in a register that is read-only here, so that one mistake would
//! lock the bank until the next reset.

use core::sync::atomic::{Ordering, compiler_fence};

use embassy_stm32::pac::flash::regs::{Ccr, Sr};
use embassy_stm32::{Peri, pac, peripherals::FLASH};
use embassy_time::{Duration, Timer};
use firmware_parts::history::History;
use firmware_parts::keys::{Keyless, Keys};
use firmware_parts::store::{Broken, Medium, SECTOR, Word};

/// First byte of the bank.
const BANK: u32 = 0x0810_0000;
const WORD: u32 = size_of::<Word>() as u32;
/// Between two looks at an erase.
const LOOK: Duration = Duration::from_millis(2);
/// Looks after which an erase has failed: the data sheet's longest is 4 s.
const LOOKS: u32 = 4000;
/// Looks at a word being programmed: far beyond the data sheet's longest, 0.6 ms.
const SPINS: u32 = 1_000_000;

unsafe extern "C" {
    static _store_start: u8;
    static _key_start: u8;
}

/// The two sectors of the settings.
pub(crate) struct Settings {
    _flash: Peri<'static, FLASH>,
}

fn bank() -> pac::flash::Bank {
    pac::FLASH.bank(1)
}

/// The word at an address of bank 2; `None` if its bits are lost.
fn read(address: u32) -> Option<Word> {
    let mut words = [0_u32; 8];
    bank().ccr().write(|w| w.set_clr_dbeccerr(true));
    // SAFETY: a register of the processor and a mask, both put back below; nothing can run in between.
    unsafe {
        let processor = cortex_m::Peripherals::steal();
        core::arch::asm!("cpsid f", options(nomem, nostack, preserves_flags));
        processor.SCB.ccr.modify(|ccr| ccr | 1 << 8);
        cortex_m::asm::dsb();
        for (nth, word) in (0..).zip(&mut words) {
            *word = ((address + 4 * nth) as *const u32).read_volatile();
        }
        cortex_m::asm::dsb();
        processor.SCB.ccr.modify(|ccr| ccr & !(1 << 8));
        core::arch::asm!("cpsie f", options(nomem, nostack, preserves_flags));
    }
    let lost = bank().sr().read().dbeccerr();
    let mut bytes = [0; WORD as usize];
    for (bytes, word) in bytes.chunks_exact_mut(4).zip(words) {
        bytes.copy_from_slice(&word.to_le_bytes());
    }
    (!lost).then_some(bytes)
}

/// The keys that the board was given, or why it has none.
pub(crate) fn keys() -> Result<Keys, Keyless> {
    let start = &raw const _key_start as u32;
    Keys::read(|at| read(start + WORD * at))
}

/// Unlocks the bank, every error of before forgotten; locks it again when dropped.
struct Open;

impl Open {
    fn new() -> Self {
        const ALL: u32 = 0x0FEF_0000;
        bank().ccr().write_value(Ccr(ALL));
        if bank().cr().read().lock() {
            bank().keyr().write_value(0x4567_0123);
            bank().keyr().write_value(0xCDEF_89AB);
        }
        Self
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        bank().cr().modify(|w| {
            w.set_pg(false);
            w.set_ser(false);
            w.set_lock(true);
        });
    }
}

/// Busy, done, or not.
fn outcome(sr: Sr) -> Option<Result<(), Broken>> {
    let wrong = sr.wrperr() || sr.pgserr() || sr.strberr() || sr.incerr() || sr.operr();
    match sr.bsy() || sr.qw() {
        true => None,
        false if wrong => Some(Err(Broken)),
        false => Some(Ok(())),
    }
}

impl Settings {
    pub(crate) fn new(flash: Peri<'static, FLASH>) -> Self {
        Self { _flash: flash }
    }

    fn start() -> u32 {
        &raw const _store_start as u32
    }

    /// What happened to this board, behind the keys.
    pub(crate) fn history(&self) -> History {
        History::open(|at| read(&raw const _key_start as u32 + WORD * at))
    }

    /// Programs a word of it.
    pub(crate) fn note(&mut self, (at, word): (u32, Word)) -> Result<(), Broken> {
        program(&raw const _key_start as u32 + WORD * at, &word)
    }
}

/// Programs the word at an address of bank 2, which is blank.
fn program(address: u32, word: &Word) -> Result<(), Broken> {
    let _open = Open::new();
    bank().cr().modify(|w| w.set_pg(true));
    cortex_m::asm::dsb();
    for (nth, bytes) in (0..).zip(word.as_chunks().0) {
        // SAFETY: within the sectors of the settings or behind the keys, which hold nothing that Rust knows of.
        unsafe { ((address + 4 * nth) as *mut u32).write_volatile(u32::from_le_bytes(*bytes)) };
    }
    cortex_m::asm::dsb();
    compiler_fence(Ordering::SeqCst);
    (0..SPINS).find_map(|_| outcome(bank().sr().read())).unwrap_or(Err(Broken))
}

impl Medium for Settings {
    fn read(&self, at: u32) -> Option<Word> {
        read(Self::start() + WORD * at)
    }

    fn program(&mut self, at: u32, word: &Word) -> Result<(), Broken> {
        program(Self::start() + WORD * at, word)
    }

    async fn erase(&mut self, sector: u32) -> Result<(), Broken> {
        let _open = Open::new();
        let first = (Self::start() - BANK) / (SECTOR * WORD);
        bank().cr().modify(|w| {
            w.set_ser(true);
            w.set_snb((first + sector) as u8);
        });
        bank().cr().modify(|w| w.set_start(true));
        cortex_m::asm::dsb();
        for _ in 0..LOOKS {
            Timer::after(LOOK).await;
            if let Some(outcome) = outcome(bank().sr().read()) {
                return outcome;
            }
        }
        Err(Broken)
    }
}
