//! Numbers: the types that a peer can compute in and the only maths functions ([`Scalar`]), [`Motion`], state as a
//! vector ([`StateVector`]), parameters that can be compared ([`Configured`]), and compensated sums ([`Sum`],
//! [`Carry`]).

#[macro_use]
mod configured;
mod scalar;
mod sin_cos;
mod sqrt;
#[macro_use]
mod state;

pub use configured::Configured;
pub(crate) use configured::word;
pub use scalar::{Fixed, Scalar};
pub use state::{Carry, Motion, StateVector, Sum, visit_counter, visit_sum};
