//! Push: what a client does to the shared object, to whoever moves it; once each packet period, newest wins
//! ([`crate::roles::cooperative`]).

use crate::bytes::layout;

layout! {
    /// A client's push.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub message Push("push", 32 bytes, kind 19) {
        /// How long the client takes the way to the engine and back to be, µs: what its contact and the engine's damping follow;
        /// 2³² − 1 where it is not known.
        4 => round_trip_us: u32,
        /// When it was sent, µs of the client's clock; what was sent earlier than one that has come is out of date.
        8 => sent_us: u64,
        /// Force on the object along x and y, N.
        16 => force: [f32; 2],
        /// Where the hand is, for others to see, m.
        24 => hand: [f32; 2],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn literal_bytes() {
        let push = Push { round_trip_us: 0x0102_0304, sent_us: 5, force: [1.0, -0.5], hand: [2.5, 0.0] };
        let bytes = [
            19, 0, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0,
            0, 0,
        ];
        let mut out = [0; Push::LEN];
        assert_eq!(push.emit(&mut out), Ok(Push::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Push::parse(&bytes), Ok(push));
        out[2] = 1;
        assert_eq!(Push::parse(&out), Err(Error::Reserved { message: "push" }));
        out = bytes;
        out[16..20].copy_from_slice(&f32::NAN.to_le_bytes());
        assert_eq!(Push::parse(&out), Err(Error::NotFinite { message: "push" }));
    }
}
