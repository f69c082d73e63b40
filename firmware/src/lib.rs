//! What the board's image needs and no chip: testable on a PC.
//!
//! The rest of the package is the image itself (`main.rs`), for the STM32H743 only.
#![no_std]

pub mod as5047p;
pub mod button;
pub mod ceiling;
pub mod contacts;
pub mod exchange;
pub mod hedge;
pub mod history;
pub mod hold;
pub mod image;
pub mod kept;
pub mod keys;
pub mod mac;
pub mod moteus;
pub mod operator;
mod order;
pub mod rate;
pub mod recorder;
pub mod signals;
pub mod status;
pub mod store;
pub mod switch;
pub mod times;

pub use cohold_protocol::record;
