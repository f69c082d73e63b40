//! What two bare Nucleos and wires are to show on silicon: each test, its wires, what it drives and measures, its bound; who runs them;
//! and docs/results/hardware.md, which is made of that.
//!
//! One board is under test, with the release image; the other, the rig, plays device, faults and logic analyser with the image in
//! `src/image`. Nobody has run any of it on silicon yet: `cargo xtask rig --virtual` runs both images on virtual boards.
//!
//! | module | holds |
//! |---|---|
//! | [`order`] | what the PC tells the rig over its serial port, and how the rig answers |
//! | [`pulses`] | what the rig makes of the edges that it captures |
//! | [`device`] | the device that the rig plays |
//! | [`list`] | the tests |
//! | [`run`] | who runs them |
//! | [`shown`] | what came of them on two boards, as kept |
//! | [`page`] | the list as text |
#![cfg_attr(target_os = "none", no_std)]
#![forbid(unsafe_code)]

pub mod device;
#[cfg(not(target_os = "none"))]
pub mod list;
pub mod order;
#[cfg(not(target_os = "none"))]
pub mod page;
pub mod pulses;
#[cfg(not(target_os = "none"))]
pub mod run;
#[cfg(not(target_os = "none"))]
pub mod shown;
