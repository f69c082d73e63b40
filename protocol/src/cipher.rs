//! ChaCha20-Poly1305 (RFC 8439) under one traffic key, in place: what a session seals and opens with.
//!
//! There are two implementations with one face and the same bits. `portable` is Rust alone and runs everywhere, the board
//! included; `ring`, with the feature of that name, is assembly for PCs and takes a third to two thirds of the time there
//! (docs/results/speed.md). Where both are compiled, tests hold them against each other.
//!
//! **Invariants**: a body is opened only if its tag is true, and the key is wiped from memory when the cipher is dropped. A body
//! whose tag is wrong is worth nothing afterwards: an implementation may have written over it.

pub mod portable;
#[cfg(feature = "ring")]
pub mod ring;

#[cfg(not(feature = "ring"))]
pub use portable::Cipher;
#[cfg(feature = "ring")]
pub use ring::Cipher;

#[cfg(test)]
#[path = "../tests/inside/cipher.rs"]
mod tests;
