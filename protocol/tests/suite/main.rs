//! The protocol from outside. One program: three would each link it.
//!
//! | file | asks |
//! |---|---|
//! | [`protocol`] | what do two links make of a wire on which everything goes wrong? |
//! | [`roles`] | what do roles make of their messages? |
//! | [`fuzz`] | what do the fuzz targets make of what fuzzers found? |

mod fuzz;
mod protocol;
mod roles;
