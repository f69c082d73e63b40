//! Files and sayings, tried on what is not harmless.

mod files;
mod number;
mod said;
