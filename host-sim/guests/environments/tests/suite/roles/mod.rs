//! Roles as their messages: layouts, decoders against anything, and the cases that a lock and a ring exist for.

mod collaborative;
mod cooperative;
mod lock;
mod memory;
mod messages;
mod ring;
mod squash;
mod static_scene;
mod total;
