//! The test bench: the unmodified release image on a virtual NUCLEO-H743ZI2, closed around cohold's plant.
//!
//! From the outside in:
//!
//! | module | holds |
//! |---|---|
//! | [`mod@bench`] | two boards, their devices and a PC on one wire, running a scene; what they did, tick by tick |
//! | [`trial`] | a scene on two boards from power-on to the figures of merit, beside cohold's |
//! | [`budget`] | the reviewed budgets and what was measured |
//! | [`cost`] | instructions of every tick |
//! | [`stack`] | static stack: the deepest path from an interrupt or a task |
//! | [`reviewed`] | what the emulator does not model, against a reviewed list |
//! | [`twin`] | the same scene in cohold, in f32: what the boards must equal, bit for bit |
//! | [`wire`] | the switch between boards and PC: delay, and whatever a bad network does |
//! | [`partner`] | cohold's live peer in place of the second board |
//! | [`far`] | that peer far away, by the PC beside the board, a meeting place and a direct path |
//! | [`pc`] | the operator's PC: ARP, and cohold's operator |
//! | [`node`] | one board in a process of its own, stepped from outside |
//! | `memo` | boards that are booted once and forked |
//! | `process` | processes that answer orders, and of which copies can be made: all that is unsafe |
//! | [`power`] | power that goes while settings are saved |
//! | [`docs`] | tables of docs/reference/board.md that tests write |
//! | [`log`] | what a board logged |
//! | [`image`] | the release image: built, found, its symbols |
//! | [`rig`] | a board and the rig beside it (tests/rig), both virtual, wired pin to pin |
//! | [`part`] | the chip: an emulated STM32H743 with our models of Ethernet, watchdogs and encoders in it |
//!
//! What is emulated and what is not: instructions, interrupts, priorities, timers and their filters, flash and memory
//! protection are; cycles, caches and bus contention are not. So bits, instruction counts and logic are evidence here, and
//! execution times are not.
#![deny(unsafe_code)]

pub mod bench;
pub mod budget;
pub mod cost;
pub mod docs;
pub mod far;
pub mod image;
pub mod log;
mod memo;
pub mod node;
pub mod part;
pub mod partner;
pub mod pc;
pub mod power;
mod process;
pub mod reviewed;
pub mod rig;
pub mod stack;
pub mod trial;
pub mod twin;
pub mod wire;
