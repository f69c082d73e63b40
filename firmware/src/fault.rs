//! When the program cannot go on: motors off before anything else, the cause kept across the reset, and the reset.
//!
//! The cause lies in memory that start-up leaves alone (DTCM `.uninit`), written in whole words because the error
//! correction of that memory commits whole words. After the reset the board is disarmed and says why it stopped; it takes
//! `clear` and `arm` to go on ([`crate::console`]).
//!
//! HardFault trusts nothing: its first instructions turn the bridges off with constants in registers, no stack needed, so
//! that a stack overflow ends there too. Then it takes the stack from the top, which nothing needs any more.

use core::{mem::MaybeUninit, panic::PanicInfo};

use cortex_m::peripheral::SCB;
use firmware_parts::status::Stop;

use crate::board::{bridges, reset};

#[derive(Clone, Copy, Debug)]
#[repr(C)]
struct Trace {
    /// Tells a trace from what memory holds at power-on.
    magic: u32,
    stop: u32,
    /// Panic: address and length of the file's name, line. HardFault: program counter, CFSR, HFSR, fault address.
    detail: [u32; 4],
    sum: u32,
}

const MAGIC: u32 = 0x4861_7053;

#[unsafe(link_section = ".uninit.fault")]
static mut TRACE: MaybeUninit<Trace> = MaybeUninit::uninit();

/// Why the board started, with what is known about it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cause {
    pub(crate) stop: Stop,
    pub(crate) place: Place,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Place {
    Unknown,
    /// A line of the source.
    Line(&'static str, u32),
    /// Program counter, configurable fault status and fault address.
    Address(u32, u32, u32),
}

impl core::fmt::Display for Place {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unknown => Ok(()),
            Self::Line(file, line) => write!(f, " at {file}:{line}"),
            Self::Address(pc, status, address) => write!(f, " at {pc:#x}, cfsr {status:#x}, address {address:#x}"),
        }
    }
}

/// The cause of this start; asks once, at boot.
pub(crate) fn cause() -> Cause {
    // SAFETY: any bits make a Trace, and nothing else runs yet.
    let trace = unsafe { (&raw const TRACE).cast::<Trace>().read_volatile() };
    // SAFETY: as above; the next start must not see it again.
    unsafe { (&raw mut TRACE).cast::<u32>().write_volatile(0) };
    let hardware = reset::cause();
    if trace.magic != MAGIC || trace.sum != sum(&trace) {
        return Cause { stop: hardware, place: Place::Unknown };
    }
    let [a, b, c, d] = trace.detail;
    match Stop::from_number(trace.stop as u8) {
        Some(Stop::Panic) => Cause { stop: Stop::Panic, place: line(a, b, c) },
        Some(Stop::HardFault) => Cause { stop: Stop::HardFault, place: Place::Address(a, b, d) },
        Some(Stop::ClockFailed) => Cause { stop: Stop::ClockFailed, place: Place::Unknown },
        _ => Cause { stop: hardware, place: Place::Unknown },
    }
}

/// The name of a source file, if it lies in flash, as the names of this very image do.
fn line(start: u32, length: u32, line: u32) -> Place {
    if !(0x0800_0000..0x0810_0000).contains(&start) || length > 200 {
        return Place::Unknown;
    }
    // SAFETY: within flash, which any address of that range is.
    let bytes = unsafe { core::slice::from_raw_parts(start as *const u8, length as usize) };
    core::str::from_utf8(bytes).map_or(Place::Unknown, |file| Place::Line(file, line))
}

fn sum(trace: &Trace) -> u32 {
    trace.detail.iter().fold(trace.magic.wrapping_add(trace.stop), |sum, word| sum.wrapping_add(*word)).wrapping_add(1)
}

/// Keeps the cause and starts anew.
fn stop(stop: Stop, detail: [u32; 4]) -> ! {
    let mut trace = Trace { magic: MAGIC, stop: stop as u32, detail, sum: 0 };
    trace.sum = sum(&trace);
    // SAFETY: nothing else runs any more; word-aligned plain data.
    unsafe { (&raw mut TRACE).cast::<Trace>().write_volatile(trace) };
    cortex_m::asm::dsb();
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    bridges::off();
    cortex_m::interrupt::disable();
    let detail = info.location().map_or([0; 4], |location| {
        let file = location.file();
        [file.as_ptr() as u32, file.len() as u32, location.line(), 0]
    });
    stop(Stop::Panic, detail)
}

/// The clock security system's, and on this chip nobody else's: the external clock stopped, the timer has turned its outputs off, and the
/// processor goes on with a clock for which nothing here is set up.
#[unsafe(no_mangle)]
extern "C" fn NonMaskableInt() -> ! {
    bridges::off();
    stop(Stop::ClockFailed, [0; 4])
}

/// Any interrupt without a handler: the program never enabled it.
#[unsafe(no_mangle)]
extern "C" fn DefaultHandler() -> ! {
    bridges::off();
    // SAFETY: a register of the processor; its low 9 bits are the exception that is active.
    let active = unsafe { (*SCB::PTR).icsr.read() } & 0x1FF;
    stop(Stop::HardFault, [0, 0, 0, active])
}

/// Bridges off, then a stack that works, then [`hard_fault`].
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "movw r0, #{a_low}", "movt r0, #{a_high}", "movw r1, #{x_low}", "movt r1, #{x_high}", "str r1, [r0]",
        "movw r0, #{b_low}", "movt r0, #{b_high}", "movw r1, #{y_low}", "movt r1, #{y_high}", "str r1, [r0]",
        "mov r0, sp",
        "movw r1, #:lower16:_stack_start", "movt r1, #:upper16:_stack_start",
        "mov sp, r1",
        "b {entry}",
        a_low = const bridges::OFF[0].0 & 0xFFFF, a_high = const bridges::OFF[0].0 >> 16,
        x_low = const bridges::OFF[0].1 & 0xFFFF, x_high = const bridges::OFF[0].1 >> 16,
        b_low = const bridges::OFF[1].0 & 0xFFFF, b_high = const bridges::OFF[1].0 >> 16,
        y_low = const bridges::OFF[1].1 & 0xFFFF, y_high = const bridges::OFF[1].1 >> 16,
        entry = sym hard_fault,
    )
}

/// Where the processor was, as far as that can be determined, and the reset. `stack` is where it had put its registers.
extern "C" fn hard_fault(stack: u32) -> ! {
    const CFSR: *const u32 = 0xE000_ED28 as *const u32;
    const HFSR: *const u32 = 0xE000_ED2C as *const u32;
    const MMFAR: *const u32 = 0xE000_ED34 as *const u32;
    const BFAR: *const u32 = 0xE000_ED38 as *const u32;
    /// The registers could not be put on the stack, by the MPU or by the bus.
    const NOT_STACKED: u32 = 1 << 4 | 1 << 12;
    // SAFETY: registers of the processor; the stack is read only where it lies in DTCM and was written.
    let (cfsr, hfsr, pc) = unsafe {
        let cfsr = CFSR.read_volatile();
        let sound = (0x2000_0000..0x2001_FFC0).contains(&stack) && stack.is_multiple_of(4) && cfsr & NOT_STACKED == 0;
        (cfsr, HFSR.read_volatile(), if sound { ((stack + 24) as *const u32).read_volatile() } else { 0 })
    };
    // SAFETY: as above; which of the two holds says CFSR bit 7.
    let address = unsafe { if cfsr & 0x80 != 0 { MMFAR.read_volatile() } else { BFAR.read_volatile() } };
    stop(Stop::HardFault, [pc, cfsr, hfsr, address])
}
