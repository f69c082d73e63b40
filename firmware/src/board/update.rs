//! The bootloader in the chip's ROM, entered by an order: another image without a probe, over the board's own USB (AN2606).
//!
//! It wants the chip as a reset leaves it. So an order leaves two words in memory that start-up leaves alone, and resets; the first thing that
//! the next start does, before its stack, its clocks and its watchdogs, is to look at these words, to clear them, and to go to the ROM: the main
//! stack and the entry are the first two words there. Whatever resets the chip then starts the image.
//!
//! **Off meanwhile**: the reset leaves every pin floating, and PF3 with the resistor that turns bridges and amplifiers off. Both watchdogs are
//! stopped by it, but for one that option bytes start, with which nobody would be in time: [`obstacle`].

use core::mem::MaybeUninit;

use cortex_m::peripheral::SCB;
use embassy_stm32::pac;

use super::bridges;

/// Where the ROM's bootloader begins, on this chip (AN2606, STM32H74x and H75x).
const ROM: u32 = 0x1FF0_9800;
/// What is left for the start that is to go there; two words, so that memory at power-on does not say it by chance.
const WANTED: [u32; 2] = [0x5570_6461, 0x7465_2E2E];
/// RCC_APB4ENR and its bit for SYSCFG: others who go to this ROM from a program found that it wants that clock.
const APB4ENR: u32 = 0x5802_44F4;
const SYSCFGEN: u32 = 1 << 1;
/// The processor's pointer to its vectors.
const VTOR: u32 = 0xE000_ED08;

/// Has a name in the image for debuggers and tests/board.
#[unsafe(no_mangle)]
#[unsafe(link_section = ".uninit.update")]
static mut LEFT_FOR_START: MaybeUninit<[u32; 2]> = MaybeUninit::uninit();

/// Why it must not be entered, if so.
pub(crate) fn obstacle() -> Option<&'static str> {
    // The bit is set where software starts the watchdog.
    let by_software = pac::FLASH.optsr_cur().read().iwdg1_hw();
    (!by_software)
        .then_some("the chip's option bytes start the independent watchdog, which would end the bootloader (IWDG1_SW)")
}

/// Motors off, and the bootloader.
pub(crate) fn enter() -> ! {
    bridges::off();
    // SAFETY: nothing else uses these words.
    unsafe { (&raw mut LEFT_FOR_START).cast::<[u32; 2]>().write_volatile(WANTED) };
    cortex_m::asm::dsb();
    SCB::sys_reset()
}

/// Called by start-up before anything else. No stack, no memory but the two words.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn __pre_init() {
    core::arch::naked_asm!(
        "movw r0, #:lower16:{left}", "movt r0, #:upper16:{left}",
        "ldrd r1, r2, [r0]",
        "movw r3, #{first_low}", "movt r3, #{first_high}", "cmp r1, r3", "bne 1f",
        "movw r3, #{second_low}", "movt r3, #{second_high}", "cmp r2, r3", "bne 1f",
        "movs r1, #0", "str r1, [r0]", "str r1, [r0, #4]",
        "movw r0, #{enable_low}", "movt r0, #{enable_high}", "ldr r1, [r0]", "orr r1, r1, #{syscfg}", "str r1, [r0]",
        "movw r2, #{rom_low}", "movt r2, #{rom_high}",
        "movw r0, #{vtor_low}", "movt r0, #{vtor_high}", "str r2, [r0]",
        "ldr r0, [r2]", "ldr r1, [r2, #4]",
        "msr msp, r0",
        "dsb", "isb",
        "bx r1",
        "1: bx lr",
        left = sym LEFT_FOR_START,
        first_low = const WANTED[0] & 0xFFFF, first_high = const WANTED[0] >> 16,
        second_low = const WANTED[1] & 0xFFFF, second_high = const WANTED[1] >> 16,
        enable_low = const APB4ENR & 0xFFFF, enable_high = const APB4ENR >> 16, syscfg = const SYSCFGEN,
        rom_low = const ROM & 0xFFFF, rom_high = const ROM >> 16,
        vtor_low = const VTOR & 0xFFFF, vtor_high = const VTOR >> 16,
    )
}
