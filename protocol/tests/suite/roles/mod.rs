//! Roles as their messages: layouts, decoders against anything, and the cases that a lock and a ring exist for.

mod collaborative;
mod lock;
mod messages;
mod ring;
mod squash;
mod total;
