//! Numbers: the number types and the only maths functions, motion, state as a vector, configuration as words, and sums of many small
//! terms.

#[macro_use]
mod configured;
mod scalar;
mod sqrt;
mod state;

pub use configured::Configured;
pub(crate) use configured::word;
pub use scalar::{Fixed, Scalar};
pub use state::{Carry, Motion, StateVector, Sum};
pub(crate) use state::{visit_counter, visit_sum};
