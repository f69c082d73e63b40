//! Recordings: every tick of what runs, in a file that other programs open unaided.
//!
//! | file | holds |
//! |---|---|
//! | [`mcap`] | the format, as far as it is needed |
//! | [`origin`] | what made a recording, and which clock its times are of |
//! | [`recorder`] | a queue and a thread between a beat and a file |
//! | [`mod@file`] | a recording read, whole or cut |
//! | [`ticks`] | what is recorded of a peer |
//! | `course` | where a recorded copy was at any time |
//! | [`merge`] | true discrepancy of two recordings |
//! | [`together`] | two recordings as one, on one clock |
//! | [`common_clock`] | how another clock goes, and how well that is known |

pub mod common_clock;
mod course;
pub mod file;
pub mod mcap;
pub mod merge;
pub mod origin;
pub mod recorder;
pub mod ticks;
pub mod together;
