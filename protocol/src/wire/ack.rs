//! Acknowledgement: which events have arrived.

use crate::bytes::layout;

layout! {
    /// Which events have arrived.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Ack("acknowledgement", 12 bytes, kind 4) {
        /// Every event before this number has arrived.
        4 => next: u32,
        /// Bit i: event `next + 1 + i` has arrived too.
        8 => ahead: u32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let ack = Ack { next: 0x0a0b_0c0d, ahead: 5 };
        let bytes = [4, 0, 0, 0, 0x0d, 0x0c, 0x0b, 0x0a, 5, 0, 0, 0];
        let mut out = [0; Ack::LEN];
        assert_eq!(ack.emit(&mut out), Ok(Ack::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Ack::parse(&bytes), Ok(ack));
    }
}
