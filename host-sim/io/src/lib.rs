//! What comes from outside and goes there: files that users name, and what others said.
//!
//! Every package of a PC reads and writes files through [`read`], [`text`] and [`write()`], and prints through [`out`] and [`say`]:
//! `one_way.rs` of cohold's tests searches their sources for any other way.
#![forbid(unsafe_code)]

mod files;
mod number;
mod said;

pub use files::{Kind, Most, all, append, begin, is, open, read, read_with, text, write};
pub use number::significant;
pub use said::{draw, escaped, out, say};
