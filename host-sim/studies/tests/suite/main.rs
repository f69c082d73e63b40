//! Studies: what they compute against other ways to compute it.

mod costs;
mod force;
mod precision;
mod rates;
mod record;
mod study;
