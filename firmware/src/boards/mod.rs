//! The printed boards that an image can be for: a folder each. What is the chip's stands in [`crate::board`], which all of them share; a board
//! says how fast its external clock is, and what is wired to which pin. A feature says which product it is, and chooses embassy-stm32's chip.
//!
//! A board more is a folder here, a feature in Cargo.toml, and a row below; tests/board runs it.

#[cfg(any(feature = "nucleo-h743zi2", feature = "nucleo-h753zi"))]
mod nucleo_mb1364;
#[cfg(any(feature = "nucleo-h743zi2", feature = "nucleo-h753zi"))]
pub(crate) use nucleo_mb1364::{EXTERNAL_HZ, wiring};

#[cfg(all(feature = "nucleo-h743zi2", feature = "nucleo-h753zi"))]
compile_error!("an image is for one board: --no-default-features --features nucleo-h753zi");
#[cfg(not(any(feature = "nucleo-h743zi2", feature = "nucleo-h753zi")))]
compile_error!("an image is for a board: --features nucleo-h743zi2");
