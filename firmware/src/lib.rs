//! What the board's image needs and no chip: testable on a PC.
//!
//! | module | holds |
//! |---|---|
//! | [`exchange`] | the only memory that the 1 kHz interrupt and the tasks share |
//! | [`signals`] | the words among it |
//! | [`kept`] | what a board keeps from one start to the next |
//! | [`store`] | how that survives in flash, whatever happens to the power |
//! | [`packet`] | between the coordination and the wire |
//! | [`record`] | what one tick saw and did, and its bytes |
//! | [`operator`] | the lines of text by which a person arms, stops and sets up a board |
//! | [`status`] | mode, fault and the cause of a start, as a person is told them |
//!
//! The rest of the package is the image itself (`main.rs`), for the STM32H743 only.
#![no_std]

pub mod exchange;
pub mod kept;
pub mod operator;
pub mod record;
pub mod signals;
pub mod status;
pub mod store;
