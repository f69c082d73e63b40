//! Probe: what time is it at your end? Also what keeps an idle session alive.

use crate::bytes::layout;

layout! {
    /// A question about time.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub message Probe("probe", 12 bytes, kind 5) {
        /// The prober's clock when it sent this, µs (t1).
        4 => sent_us: u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literal_bytes() {
        let probe = Probe { sent_us: 0x0102_0304_0506_0708 };
        let bytes = [5, 0, 0, 0, 8, 7, 6, 5, 4, 3, 2, 1];
        let mut out = [0; Probe::LEN];
        assert_eq!(probe.emit(&mut out), Ok(Probe::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Probe::parse(&bytes), Ok(probe));
    }
}
