//! Numbers: the number types and the only maths functions, motion, state as a vector, and sums of many small terms.

mod scalar;
mod sqrt;
mod state;

pub use scalar::{Fixed, Scalar};
pub use state::{Carry, Motion, StateVector, Sum};
pub(crate) use state::{visit_counter, visit_sum};
