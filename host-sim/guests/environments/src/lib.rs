//! The architectures paper's shared environments (Buttolo, Oboe & Hannaford 1997): what each end is, the worlds that they share, and
//! their ends in real time.
//!
//! [`roles`] and [`records`] are for any processor: no heap, no clock, no I/O. The rest is for PCs, and needs the feature `std`.
#![cfg_attr(not(feature = "std"), no_std)]
#![forbid(unsafe_code)]

#[cfg(feature = "std")]
mod carried;
#[cfg(feature = "std")]
pub mod collaborative;
#[cfg(feature = "std")]
mod commands;
#[cfg(feature = "std")]
pub mod cooperative;
#[cfg(feature = "std")]
mod error;
#[cfg(feature = "std")]
pub mod live;
#[cfg(feature = "std")]
mod play;
pub mod records;
pub mod roles;
#[cfg(feature = "std")]
pub mod squash;
#[cfg(feature = "std")]
pub mod studies;
#[cfg(feature = "std")]
pub mod trials;
#[cfg(feature = "std")]
pub mod world;

#[cfg(feature = "std")]
pub use self::{carried::Crossing, carried::said, commands::join, error::Error};
