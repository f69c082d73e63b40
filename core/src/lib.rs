//! One haptic peer: everything that its control loop (1 kHz) computes, and nothing else. A peer renders contact between
//! one force-feedback device and its local copy of a virtual object that two people share; a coordination law couples
//! that copy, over the network, to the copy of the other peer.
//!
//! The same code runs on the microcontroller, in the simulator and in the stability analysis. So this crate has no I/O,
//! no allocation, no time source and no randomness; a peer ([`peer::Peer`]) is plain data; and after
//! [`peer::Peer::new`] has accepted the settings, its `tick` and `exchange` are total: no panic, and no non-finite
//! force, whatever comes in.
//!
//! From the outside in; a module leans on those below it, never above:
//!
//! | module | holds |
//! |---|---|
//! | [`mod@sample`] | the quantities that can be recorded of a peer after a tick, each declared once |
//! | [`peer`] | `tick`, `exchange` and `hear`, the only entries at run time |
//! | [`schema`] | every setting by name, with the keys that laws declare themselves |
//! | [`device`] | encoder counts to position and velocity, force to motor duty; encoders that fail; a motor pushed open loop |
//! | [`contact`] | contact between device and object |
//! | [`law`] | coordination laws: how the two copies of the shared object are coupled |
//! | [`object`] | the shared virtual object's integrators |
//! | [`mod@model`] | the trait of models that settings choose by name, and their lists |
//! | [`safety`] | modes, numbered faults, force and slew limits |
//! | [`mod@settings`] | every table of keys, with unit, default and range; what a law's own key is |
//! | [`names`] | settings that are one of a fixed list of names |
//! | [`num`] | the number types and the only maths functions, motion, state and configuration as numbers, compensated sums |
//!
//! **Words**: a *tick* is one control period T_c, of which M make a packet period T_n; the *copy* is the local copy x_o
//! of the shared object; a *port* is a force that is affine in the copy's velocity ([`object::port`]); a copy is *moved
//! by ports* with `object.integrator = "midpoint"`, in one solve a tick, and *staged* with the papers' other
//! integrators; a peer is *engaged* while its law acts ([`law::degradation`]); a packet *stands* while it is held.
//!
//! SI units everywhere. The *cooperation paper* is Rakhsha & Constantinescu 2012, whose equations and symbols the code
//! follows; the *architectures paper* is Buttolo, Oboe & Hannaford 1997; THEORY is docs/reference/theory.md of the repository.
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
pub mod playout;
pub mod safety;
pub mod sample;
pub mod schema;
pub mod settings;

/// The examples of the page that registries show.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
