//! Hard cases: where numbers get extreme, gains sit on an edge, or something must cancel exactly. Every test says why it is
//! here, and prints what it measured: `cargo test -p cohold-analysis --test suite hard_cases -- --nocapture`.
//!
//! | module | the hard thing |
//! |---|---|
//! | [`boundary`] | gains a millionth inside and outside the region |
//! | [`extremes`] | K_T over ten decades, object mass over seven, delay up to a second |
//! | [`chatter`] | one-sided contact at rest on the surface, and at the edge of chatter |
//! | [`let_go`] | one push across a gap, and then nobody holds what contact held |
//! | [`encoders`] | 16 to 24 bit per metre, a counter that wraps hundreds of times |
//! | [`drift`] | ten hours of single-precision positions |
//! | [`subnormals`] | states that decay below the smallest normal number |
//! | [`cancellation`] | equal and opposite pushes |

mod boundary;
mod cancellation;
mod chatter;
mod drift;
mod encoders;
mod extremes;
mod let_go;
pub(super) mod setup;
mod subnormals;
