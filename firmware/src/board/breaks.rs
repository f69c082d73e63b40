//! Failures of the chip that turn the bridges' outputs off in hardware: system breaks of the timer (RM0433 §38.3.16).
//!
//! | failure | noticed by | and then |
//! |---|---|---|
//! | the external clock stops | clock security system | NMI: the board starts anew and says so |
//! | the chip's supply falls below 2.76 V | voltage detector, level 6 | fault 15 |
//! | the core locks up | itself | the dead man ([`super::deadman`]) |
//! | a debugger halts the core | the timer, whose clock stops with it (RM0433 §60.5.8) | outputs off until it goes on, and then the tick's stop ([`super::pace`]) |
//!
//! Left out are errors of two bits in a memory word, which can break as well: flash, because the store reads words that power left
//! half-written; DTCM and ITCM, because start-up reads and fetches ahead where nothing was ever written. On the way to the core such
//! a word is a bus fault, and so a hard fault, whose first instructions turn the bridges off.
//!
//! **Limit**: silicon before revision V does none of this (ES0392 §2.2.2), nor does it run at 480 MHz: [`unfit`].

use embassy_stm32::pac;

/// SYSCFG_CFGR, which the register crate does not have for this chip. Bits are set once and stay until the next reset.
const SYSCFG_CFGR: *mut u32 = 0x5800_0418 as *mut u32;
/// The voltage detector breaks, and cannot be turned off or set to another level any more.
const PVDL: u32 = 1 << 2;
/// A core that locked up breaks.
const CM7L: u32 = 1 << 6;
/// Level 6: 2.76 V falling, 2.86 V rising.
const LEVEL: u8 = 6;
/// Revision V in DBGMCU_IDC; earlier ones are smaller.
const REVISION_V: u16 = 0x2003;

/// Wires them to the break; `external`: the clock is the external one.
pub(crate) fn connect(external: bool) {
    // Before this bit there is nothing to secure; with it the chip falls back on its own oscillator.
    pac::RCC.cr().modify(|w| w.set_hsecsson(external));
    pac::PWR.cr1().modify(|w| {
        w.set_pls(LEVEL);
        w.set_pvde(true);
    });
    // The window watchdog stands still while a debugger halts the core, so the outputs must not go on; nor the tick's timer, which stays in step.
    pac::DBGMCU.apb2fzr1().modify(|w| w.set_tim1(true));
    pac::DBGMCU.apb1lfzr1().modify(|w| w.set_tim6(true));
    // SAFETY: a register of the chip (RM0433 §12.3.6) whose clock `embassy_stm32::init` enabled, and nobody else writes it.
    unsafe { SYSCFG_CFGR.write_volatile(PVDL | CM7L) };
}

/// What this board lacks that motors must not be on without.
pub(crate) fn unfit(external: bool) -> Option<&'static str> {
    if !external {
        Some("the external clock did not come: see to the 8 MHz of the ST-LINK and start anew")
    } else if pac::DBGMCU.idc().read().0 == 0 {
        Some("a debugger has hidden the chip's revision: power off and on")
    } else if pac::DBGMCU.idc().read().rev_id() < REVISION_V {
        Some("the chip is older than revision V: it is not made for 480 MHz, and its failures do not turn outputs off")
    } else {
        None
    }
}
