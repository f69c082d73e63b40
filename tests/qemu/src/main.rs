//! A second opinion on the processor: cohold-core alone under QEMU's Cortex-M7, which shares nothing with the virtual board.
//!
//! `cargo xtask test --only qemu` runs it. What it is to do comes over semihosting, as its command line:
//!
//! | words | does |
//! |---|---|
//! | `replay FILE` | replays a recording of `cohold board record`; prints ticks and hash |
//! | `panic FILE` | the same, and in the middle of it an index out of range |
//! | `overflow FILE` | the same, and in the middle of it a recursion without end |
//!
//! A word of memory stands for the motors' outputs: every tick writes it, on while the peer enables its motors. Whatever ends the
//! program writes it off before anything else, as the board does; what it holds then is printed last.
#![no_std]
#![no_main]

use core::alloc::{GlobalAlloc, Layout};
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln, nr, syscall};
use cohold_cases::replay;

/// The motors' outputs; 0 is off.
#[unsafe(no_mangle)]
static OUTPUTS: AtomicU32 = AtomicU32::new(0);
/// Ticks done.
static TICKS: AtomicU32 = AtomicU32::new(0);
/// The tick in which it goes wrong.
const WRONG: u64 = 1000;

/// Nothing is replayed on a heap: there is none.
struct NoHeap;

// SAFETY: it never gives any memory.
unsafe impl GlobalAlloc for NoHeap {
    unsafe fn alloc(&self, _: Layout) -> *mut u8 {
        core::ptr::null_mut()
    }
    unsafe fn dealloc(&self, _: *mut u8, _: Layout) {}
}

#[global_allocator]
static HEAP: NoHeap = NoHeap;

/// A file of the host's.
struct File(usize);

impl File {
    fn open(name: &str) -> Option<Self> {
        let mut text = [0; 256];
        text.get_mut(..name.len())?.copy_from_slice(name.as_bytes());
        // SAFETY: address, mode "rb" and length of a name that ends in zero, as SYS_OPEN wants them.
        let handle = unsafe { syscall!(OPEN, text.as_ptr(), 1, name.len()) };
        (handle != usize::MAX).then_some(Self(handle))
    }

    /// Fills `into`; false if there is not enough left.
    fn read(&mut self, into: &mut [u8]) -> bool {
        // SAFETY: handle, address and length of memory that is ours. SYS_READ gives what it could not fill.
        into.is_empty() || unsafe { syscall!(READ, self.0, into.as_mut_ptr(), into.len()) } == 0
    }
}

/// What QEMU was asked to report.
fn command_line(text: &mut [u8; 256]) -> &str {
    let block = [text.as_mut_ptr() as usize, text.len()];
    // SAFETY: a block of address and length, which SYS_GET_CMDLINE fills in; the length becomes that of the text.
    let failed = unsafe { cortex_m_semihosting::syscall1(nr::GET_CMDLINE, block.as_ptr() as usize) } != 0;
    // SAFETY: the host wrote to the block behind the compiler's back.
    let length = unsafe { block.as_ptr().add(1).read_volatile() };
    let text = text.get(..length).filter(|_| !failed).unwrap_or_default();
    core::str::from_utf8(text).unwrap_or_default().trim_end_matches('\0')
}

/// Uses up the stack.
#[inline(never)]
#[allow(unconditional_recursion)]
fn recurse(depth: u32) -> u32 {
    let frame = core::hint::black_box([depth; 16]);
    recurse(depth + 1).wrapping_add(frame[depth as usize % 16])
}

/// Forbids the lowest 256 bytes of the stack, as the board does: this machine lets writes to nowhere pass.
fn guard_the_stack() {
    const SIZE_256: u32 = 7 << 1;
    const NEVER_EXECUTE: u32 = 1 << 28;
    if let Some(peripherals) = cortex_m::Peripherals::take() {
        // SAFETY: nothing uses those bytes but an overflow; everything else is as without the MPU.
        unsafe {
            peripherals.MPU.rnr.write(0);
            peripherals.MPU.rbar.write(0x2000_0000);
            peripherals.MPU.rasr.write(NEVER_EXECUTE | SIZE_256 | 1);
            peripherals.MPU.ctrl.write(1 << 2 | 1);
        }
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
    }
}

#[entry]
fn main() -> ! {
    guard_the_stack();
    let mut text = [0; 256];
    let line = command_line(&mut text);
    let (mode, name) = line.split_once(' ').unwrap_or((line, ""));
    let Some(mut file) = File::open(name) else {
        hprintln!("there is no file {:?} (told {:?})", name, line);
        debug::exit(debug::EXIT_FAILURE);
        loop {}
    };
    let each = |tick: u64, actuators: &cohold_core::peer::Actuators<f32>| {
        OUTPUTS.store(if actuators.enable { u32::MAX } else { 0 }, Ordering::SeqCst);
        TICKS.store(tick as u32 + 1, Ordering::Relaxed);
        if tick == WRONG && mode == "panic" {
            let table = [1, 2, 3];
            OUTPUTS.store(table[core::hint::black_box(tick as usize)], Ordering::SeqCst);
        }
        if tick == WRONG && mode == "overflow" {
            core::hint::black_box(recurse(0));
        }
    };
    match replay::run(|into| file.read(into), each) {
        Ok((ticks, hash)) => {
            hprintln!("{} ticks {:016x}", ticks, hash);
            debug::exit(debug::EXIT_SUCCESS);
        }
        Err(unreadable) => {
            hprintln!("{:?}: {}", unreadable, name);
            debug::exit(debug::EXIT_FAILURE);
        }
    }
    loop {}
}

/// The last words.
fn stopped(what: &str) -> ! {
    hprintln!("{} after {} ticks, outputs {:#x}", what, TICKS.load(Ordering::Relaxed), OUTPUTS.load(Ordering::SeqCst));
    debug::exit(debug::EXIT_SUCCESS);
    loop {}
}

#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    OUTPUTS.store(0, Ordering::SeqCst);
    stopped("panic")
}

/// As on the board (firmware/src/fault.rs): outputs off with constants in registers, then a stack that works.
#[unsafe(no_mangle)]
#[unsafe(naked)]
unsafe extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "movw r0, #:lower16:OUTPUTS",
        "movt r0, #:upper16:OUTPUTS",
        "movs r1, #0",
        "str r1, [r0]",
        "mov r0, sp",
        "movw r1, #:lower16:_stack_start",
        "movt r1, #:upper16:_stack_start",
        "mov sp, r1",
        "b {entry}",
        entry = sym hard_fault,
    )
}

extern "C" fn hard_fault(stack: u32) -> ! {
    stopped(if stack < 0x2000_0200 { "stack overflow" } else { "hard fault" })
}
