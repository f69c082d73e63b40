//! Roles: what peers of one architecture say to each other, as state machines without I/O.

pub mod cooperative;
