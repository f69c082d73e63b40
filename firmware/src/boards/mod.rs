//! The boards that an image can be for: a folder each, and a feature of its name. What is the chip's stands in [`crate::board`], which all of
//! them share; a board says how fast its external clock is, and what is wired to which pin.
//!
//! A board more is a folder here, a feature in Cargo.toml that chooses embassy-stm32's chip, and a row below; tests/board runs it.

#[cfg(feature = "nucleo-h743zi2")]
mod nucleo_h743zi2;
#[cfg(feature = "nucleo-h753zi")]
mod nucleo_h753zi;

#[cfg(feature = "nucleo-h743zi2")]
pub(crate) use nucleo_h743zi2::{EXTERNAL_HZ, wiring};
#[cfg(feature = "nucleo-h753zi")]
pub(crate) use nucleo_h753zi::{EXTERNAL_HZ, wiring};

#[cfg(all(feature = "nucleo-h743zi2", feature = "nucleo-h753zi"))]
compile_error!("an image is for one board: --no-default-features --features nucleo-h753zi");
#[cfg(not(any(feature = "nucleo-h743zi2", feature = "nucleo-h753zi")))]
compile_error!("an image is for a board: --features nucleo-h743zi2");
