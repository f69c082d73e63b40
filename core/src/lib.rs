//! One haptic peer: everything the 1 kHz tick computes, and nothing else.
//!
//! The same lines fly on the microcontroller, run in the simulator and are proved by the analyser. So this crate has no
//! I/O, no allocation, no time source and no randomness; parameters ([`scene::Scene`]) are immutable and apart from the
//! state ([`peer::State`]), both plain data; and after [`scene::Scene::build`] has accepted the settings,
//! [`peer::tick`] and [`peer::exchange`] are total: no panic, and no non-finite force, whatever comes in.
//!
//! From the outside in:
//!
//! | module | holds |
//! |---|---|
//! | [`peer`] | `tick` and `exchange`, the only entries at run time |
//! | [`scene`] | settings, checked once, become the models a scene needs |
//! | [`mod@settings`] | every key a peer understands, with unit, default and range |
//! | [`safety`] | modes, numbered faults, force and slew limits |
//! | [`law`] | coordination laws: how the two copies of the shared object hold together |
//! | [`object`] | the shared virtual object's integrators |
//! | [`contact`] | contact between device and object |
//! | [`device`] | encoder counts to position and velocity, force to motor duty; encoders that lie; a motor pushed open loop |
//! | [`num`] | the number types and the only maths functions, motion, state as a vector, compensated sums |
//! | [`mod@model`] | one list per kind of model: the only place where a law, integrator or estimator is named |
//!
//! SI units everywhere. Equations and symbols follow the cooperation paper (Rakhsha & Constantinescu 2012).
#![no_std]
#![forbid(unsafe_code)]

#[macro_use]
pub mod model;

pub mod contact;
pub mod device;
pub mod law;
pub mod num;
pub mod object;
pub mod peer;
pub mod safety;
pub mod scene;
pub mod settings;
