//! Reply: the answer to a probe.

use crate::bytes::layout;

layout! {
    /// The answer to a [`super::Probe`].
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Reply("reply", 28 bytes, kind 6) {
        /// The prober's clock when it sent the probe, µs (t1).
        4 => probe_sent_us: u64,
        /// The answerer's clock when the probe came, µs (t2).
        12 => probe_received_us: u64,
        /// The answerer's clock when it sent this, µs (t3).
        20 => sent_us: u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let reply = Reply { probe_sent_us: 1, probe_received_us: 0x0203, sent_us: 0x04 << 56 };
        #[rustfmt::skip]
        let bytes = [
            6, 0, 0, 0,
            1, 0, 0, 0, 0, 0, 0, 0,
            3, 2, 0, 0, 0, 0, 0, 0,
            0, 0, 0, 0, 0, 0, 0, 4,
        ];
        let mut out = [0; Reply::LEN];
        assert_eq!(reply.emit(&mut out), Ok(Reply::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Reply::parse(&bytes), Ok(reply));
    }
}
