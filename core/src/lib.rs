//! One haptic peer: everything the 1 kHz tick computes, and nothing else.
//!
//! The same lines fly on the microcontroller, run in the simulator and are proved by the analyser. So this crate has no
//! I/O, no allocation, no time source and no randomness; a peer ([`peer::Peer`]) is plain data; and after
//! [`peer::Peer::new`] has accepted the settings, its `tick` and `exchange` are total: no panic, and no non-finite force,
//! whatever comes in.
//!
//! From the outside in; a module leans on those below it, never above:
//!
//! | module | holds |
//! |---|---|
//! | [`mod@sample`] | what there is to tell of a peer after a tick, every quantity once |
//! | [`peer`] | `tick` and `exchange`, the only entries at run time |
//! | [`schema`] | settings by name, laws' own keys too |
//! | [`device`] | encoder counts to position and velocity, force to motor duty; encoders that fail; a motor pushed open loop |
//! | [`contact`] | contact between device and object |
//! | [`law`] | coordination laws: how the two copies of the shared object hold together |
//! | [`object`] | the shared virtual object's integrators |
//! | [`mod@model`] | the trait of models that settings choose by name, and their lists |
//! | [`safety`] | modes, numbered faults, force and slew limits |
//! | [`mod@settings`] | every table of keys, with unit, default and range; what a law's own key is |
//! | [`names`] | settings that are one of a fixed list of names |
//! | [`num`] | the number types and the only maths functions, motion, state and configuration as numbers, compensated sums |
//!
//! SI units everywhere. Equations and symbols follow the cooperation paper (Rakhsha & Constantinescu 2012).
#![no_std]
// But for one instruction of the FPU, in `num::sqrt`.
#![deny(unsafe_code)]

#[macro_use]
pub mod num;
#[macro_use]
pub mod model;

pub mod contact;
pub mod device;
pub mod law;
pub mod names;
pub mod object;
pub mod peer;
pub mod safety;
pub mod sample;
pub mod schema;
pub mod settings;
