//! The protocol from outside. One program: three would each link it.
//!
//! | file | asks |
//! |---|---|
//! | [`protocol`] | what do two links make of a wire on which everything goes wrong? |
//! | [`fuzz`] | what do the fuzz targets make of what fuzzers found? |

mod fuzz;
mod protocol;
