//! The image of the rig: the NUCLEO-H743ZI2 beside the board under test, which plays device, gate, stop and faults, and captures what the
//! board does. docs/results/hardware.md says what it is for, [`cohold_rig::order`] what can be asked of it.
//!
//! One loop, in which the processor sleeps until a timer, a capture or a byte is there; no interrupt is taken, so nothing comes between two
//! lines of it. All state is on the stack. It cannot panic: the panic handler calls what does not exist, so that an image that might
//! reach it does not link.
//!
//! | wire | pin here |
//! |---|---|
//! | encoder 1: A, B, index; encoder 2: A, B | PC6, PC7, PC8; PD12, PD13 |
//! | gate's output, stop's contact, bridges' fault line | PD15, PE15, PE6 (open drain) |
//! | the last two, to be captured | PB11, PB3 |
//! | board's PE9, PE14, to be captured; PF3 | PA5, PB10; PF3 |
//! | analogue output | PA4 |
//! | board's blue button, PC13 | PD14 |
//! | serial port of the PC, through the ST-LINK | PD8, PD9 |
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {
    eprintln!("the rig's image is for its board: `cargo xtask rig --virtual` builds it and runs it on a virtual one");
}

#[cfg(target_os = "none")]
mod captures;
#[cfg(target_os = "none")]
mod clocks;
#[cfg(target_os = "none")]
mod pins;
#[cfg(target_os = "none")]
mod rig;
#[cfg(target_os = "none")]
mod serial;
#[cfg(target_os = "none")]
mod start;
