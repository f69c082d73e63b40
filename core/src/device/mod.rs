//! An axis of the device: encoder counts to position and velocity, force to motor duty.
//!
//! | module | does |
//! |---|---|
//! | [`encoder`] | raw counts → joint position, with wrap-around and a plausibility check |
//! | [`velocity`] | joint positions → joint velocity, a list of estimators |
//! | [`kinematics`] | joints → axes of the task, and axis forces → joint forces, a list of mechanisms |
//! | [`constraint`] | the force that holds an unused axis on its line |
//! | [`motor`] | joint force → duty |
//! | [`watch`] | encoders that lie: stuck, or counting the wrong way |
//! | [`probe`] | a motor pushed open loop, within limits: calibration and the check before arming |
//!
//! A *joint* is what an encoder and a motor share: a slide (m, N) or something that turns (rad, N·m). An *axis* is a
//! direction of the task: always m, m/s, N. Positions are zero where the encoders were when they were first read.

pub mod constraint;
pub mod encoder;
pub mod kinematics;
pub mod motor;
pub mod probe;
mod reading;
pub mod velocity;
pub mod watch;

pub use reading::{AXES, Reading};
