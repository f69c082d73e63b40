//! Everything around the peers on a PC: software plant, network, harness, experiments, stability analysis, reports and
//! the command line. The peers themselves are `haptic_core`, the same lines that fly on the board.
//!
//! | module | holds |
//! |---|---|
//! | [`scene`] | a scene file with its overrides, checked key by key |
//! | [`scenes`] | the scenes of the folder `scenes/`, built in |
//! | [`plant`] | the device and the arm of its user: exact dynamics, optional imperfections |
//! | [`user`] | what the users do: the paper's force profiles, reaches, traces |
//! | [`network`] | packets on their way |
//! | [`dice`] | a stream of random numbers from a seed |
//! | [`harness`] | two peers, two plants and a network, stepped together |
//! | [`live`] | peers in real time, over real sockets |
//! | [`collaborate`] | one at a time edits: lock and token ring on trial |
//! | [`calibrate`] | what a person and a board find out about a device |
//! | [`cooperative`] | many users, one object, one dynamics engine: at a server or on its way to a client |
//! | [`architectures`] | the same task in every architecture, to choose by |
//! | [`experiment`] | runs with their figures of merit, the papers' experiments |
//! | [`analysis`] | stability, computed from the code that flies |
//! | [`accuracy`] | speed against error, for every numerical choice |
//! | [`report`] | tables, CSV and Parquet files, pictures |
//! | [`squash`] | one ball, many players: the paper's game, played by bots |
//! | [`visit`] | a static environment: its servers and clients |
//! | [`world`] | worlds that a server holds and a hand feels |
//! | [`cli`] | the command line |
#![forbid(unsafe_code)]

extern crate alloc;

pub mod accuracy;
pub mod analysis;
pub mod architectures;
pub mod calibrate;
pub mod cli;
pub mod collaborate;
pub mod cooperative;
pub mod dice;
pub mod experiment;
pub mod harness;
pub mod live;
pub mod network;
pub mod plant;
pub mod report;
pub mod scene;
pub mod scenes;
pub mod squash;
pub mod user;
pub mod visit;
pub mod world;
