//! Studies: what they compute against other ways to compute it.

mod architectures;
mod campaign;
mod costs;
mod force;
mod halving;
mod precision;
mod record;
mod study;
