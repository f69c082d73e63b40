//! Numbers: the number types and the only maths functions, motion, state as a vector, and sums of many small terms.

mod motion;
mod scalar;
mod sum;
mod vector;

pub use motion::Motion;
pub use scalar::{Fixed, Scalar};
pub use sum::{Carry, Sum};
pub use vector::StateVector;
