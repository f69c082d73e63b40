//! Memory: ITCM filled, caches, protection.
//!
//! The instruction cache is on; the data cache is off, so that the Ethernet DMA and the processor always see the same
//! bytes. The tick does not miss it: its code is in ITCM and its data in DTCM, which have no cache. The MPU marks the
//! Ethernet memory non-cacheable all the same, so that turning the data cache on stays harmless, makes ITCM read-only
//! once filled and the program in flash for good, and puts a guard under the stack: an overflow is a fault, not a corrupted neighbour.
//! Nothing is executed from data or from the second bank of flash, where the settings are, and nothing is read from where external
//! memories would be: the processor may read ahead in normal memory, and there none answers.

use core::ptr::addr_of;

use cortex_m::Peripherals;

unsafe extern "C" {
    static mut _itcm_start: u32;
    static _itcm_end: u32;
    static _itcm_load: u32;
    static _stack_guard: u32;
}

pub(crate) fn load_itcm() {
    // SAFETY: the symbols are the linker's; source and destination are different memories, both there at reset, and
    // nothing in ITCM is called before this.
    unsafe {
        let words = addr_of!(_itcm_end).offset_from(addr_of!(_itcm_start)) as usize;
        let (mut from, mut to) = (addr_of!(_itcm_load), &raw mut _itcm_start);
        // Not `copy_nonoverlapping` over all: that is a call of memcpy, which is in ITCM.
        for _ in 0..words {
            to.write_volatile(from.read_volatile());
            from = from.add(1);
            to = to.add(1);
        }
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// No access at all, never executed.
const NO_ACCESS: u32 = 1 << 28;
/// Read and execute only.
const READ_ONLY: u32 = 0b110 << 24 | 0b001 << 19;
/// Normal memory, not cacheable, readable and writable, never executed.
const NOT_CACHED: u32 = 1 << 28 | 0b011 << 24 | 0b001 << 19;
/// Device memory, shared, readable and writable, never executed: never read ahead of the program, in words that are whole.
const DEVICE: u32 = 1 << 28 | 0b011 << 24 | 1 << 16;
/// Read and execute only, through the instruction cache.
const PROGRAM: u32 = 0b110 << 24 | 1 << 17;

/// Sets up the MPU and the instruction cache.
pub(crate) fn protect() {
    // Base, size (a power of two), and attributes as in RASR bits 16–28. Where two overlap, the later decides: the guard lies in DTCM.
    let regions = [
        (0x2000_0000, 128 * 1024, NOT_CACHED),
        (addr_of!(_stack_guard) as u32, 256, NO_ACCESS),
        (0, 64 * 1024, READ_ONLY),
        (0x0800_0000, 1024 * 1024, PROGRAM),
        (0x2400_0000, 512 * 1024, NOT_CACHED),
        // A read ahead of a bank that is being erased would wait for seconds.
        (0x0810_0000, 1024 * 1024, DEVICE),
        (0x6000_0000, 512 * 1024 * 1024, NO_ACCESS),
        (0x8000_0000, 512 * 1024 * 1024, NO_ACCESS),
    ];
    // SAFETY: single-threaded start-up; nobody else holds these.
    let mut p = unsafe { Peripherals::steal() };
    // SAFETY: the regions forbid only what nothing does; memory outside them keeps its default attributes.
    unsafe {
        p.MPU.ctrl.write(0);
        for (number, (base, size, attributes)) in (0..).zip(regions) {
            p.MPU.rnr.write(number);
            p.MPU.rbar.write(base);
            p.MPU.rasr.write(attributes | (u32::trailing_zeros(size) - 1) << 1 | 1);
        }
        // Enabled, with the default map behind it, also for privileged code; not in HardFault and NMI.
        p.MPU.ctrl.write(0b101);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    p.SCB.enable_icache();
}
