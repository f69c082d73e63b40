//! host-sim as a user runs it, and what it offers beside its command line. One program for all, so that they are linked once.

mod accuracy;
mod another_language;
mod architectures;
mod bad_input;
mod campaign;
mod collaborate;
mod command_line;
mod cooperative;
mod costs;
mod endpoint;
mod examples;
mod flood;
mod force;
mod hub;
mod key_files;
mod lifted;
mod live;
mod operator;
mod play;
mod precision;
mod program;
mod record;
mod restarts;
mod signals;
mod squash;
mod static_scene;
