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
//! | [`watch`] | encoders that lie: stuck, or counting the wrong way |
//! | [`probe`] | a motor pushed open loop, within limits: calibration and the check before arming |
//! | [`couple`] | coordination laws: how the two copies of the shared object hold together |
//! | [`object`] | the shared virtual object's integrators |
//! | [`render`] | contact between device and object |
//! | [`axis`] | encoder counts to position and velocity, force to motor duty |
//! | [`scalar`] | the number types and the only maths functions |
//! | [`motion`] | position and velocity of one degree of freedom |
//! | [`vector`] | state as a vector: for the analyser, and for hashes |
//! | [`mod@sum`] | sums of many small terms, with compensation |
//! | [`mod@list`] | one list per kind of model: the only place where a law, integrator or estimator is named |
//!
//! SI units everywhere. Equations and symbols follow the cooperation paper (Rakhsha & Constantinescu 2012).
#![no_std]
#![forbid(unsafe_code)]

#[macro_use]
pub mod list;

pub mod axis;
pub mod couple;
pub mod motion;
pub mod object;
pub mod peer;
pub mod probe;
pub mod render;
pub mod safety;
pub mod scalar;
pub mod scene;
pub mod settings;
pub mod sum;
pub mod vector;
pub mod watch;
