//! The hub: 2 to 16 peers, each behind a sealed link, hold one object.

mod junction;
mod processes;
#[path = "../program/mod.rs"]
mod program;
mod virtual_time;
