//! Goodbye: the sender ends the session, and says so before it falls silent.

use crate::bytes::layout;

layout! {
    /// The sender ends the session.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Goodbye("goodbye", 4 bytes, kind 7) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let mut out = [9; Goodbye::LEN];
        assert_eq!(Goodbye {}.emit(&mut out), Ok(Goodbye::LEN));
        assert_eq!((out, Goodbye::parse(&out)), ([7, 0, 0, 0], Ok(Goodbye {})));
    }
}
