//! The protocol as a peer sees it: two links, the wire between them, and everything that can go wrong there.

mod authentic;
mod clock;
mod degradation;
mod events;
mod format;
mod fresh;
mod handshake;
mod key;
mod layouts;
mod lines;
mod memory;
mod parsers;
#[cfg(feature = "peer")]
mod peer;
mod random;
mod replay;
mod restarts;
mod tamper;
mod text;
mod world;
