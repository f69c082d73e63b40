//! The board's wiring: `netlist.toml`, which is held against rules and drawn.
//!
//! | module | has |
//! |---|---|
//! | [`netlist`] | the file, and what a build of it joins |
//! | [`rules`] | what must be true of any wiring of a board: ends, drivers, levels, grounds, values |
//! | [`sheet`] | where everything goes on a drawing |
//! | [`svg`] | a drawing as a file |
//! | [`page`] | the tables of docs/guides/board/assembly.md |
//!
//! Nothing here knows the firmware: tests/suite.rs reads its sources and compares.
#![forbid(unsafe_code)]

pub mod netlist;
pub mod page;
pub mod rules;
pub mod sheet;
pub mod svg;
