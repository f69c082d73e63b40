//! cohold as a user runs it, and what it offers beside its command line. One program for all, so that they are linked once.

mod accuracy;
mod another_language;
mod bad_input;
mod bench;
mod columns;
mod command_line;
mod cooperative;
mod declared;
mod examples;
mod guests;
mod hub;
mod key_files;
mod letters;
mod live;
mod live_verdict;
mod one_way;
mod operator;
mod outside;
#[path = "../homes/peers.rs"]
#[expect(dead_code, reason = "two homes need more of a peer")]
mod peers;
mod play;
mod precision;
mod program;
mod rates;
mod recordings;
mod reproduce;
mod signals;
mod squash;
mod static_scene;
mod study;
mod sweep;
mod vectors;
