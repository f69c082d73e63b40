//! host-sim as a user runs it, and what it offers beside its command line. One program for all, so that they are linked once.

mod accuracy;
mod another_language;
mod bad_input;
mod columns;
mod command_line;
mod compare;
mod cooperative;
mod devices;
mod examples;
mod flood;
mod hub;
mod key_files;
mod live;
mod live_verdict;
mod one_way;
mod operator;
mod outside;
mod play;
mod precision;
mod program;
mod recordings;
mod reproduce;
mod signals;
mod squash;
mod static_scene;
mod sweep;
