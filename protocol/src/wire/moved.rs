//! Moved: the shared object as whoever has the dynamics engine moves it, to each client; once each packet period, newest
//! wins ([`crate::roles::cooperative`]). With the time of its arrival the three times are a sample for [`crate::clock::Clock`].

use crate::bytes::layout;

layout! {
    /// The object, as it is moved.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub message Moved("moved", 48 bytes, kind 20) {
        /// Which engine.
        4 => version: u32,
        /// Position (m) and velocity (m/s) along x and y.
        8 => axes: [[f32; 2]; 2],
        /// When the newest push of this client was sent, µs of its clock; 0: none yet.
        24 => echo_us: u64,
        /// When it came, µs of the engine's clock.
        32 => came_us: u64,
        /// When this was sent, µs of the engine's clock.
        40 => sent_us: u64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;

    #[test]
    fn literal_bytes() {
        let moved = Moved { version: 9, axes: [[1.0, -0.5], [2.5, 0.0]], echo_us: 5, came_us: 6, sent_us: 0x0708 };
        let mut bytes = [0; Moved::LEN];
        bytes[0] = 20;
        bytes[4] = 9;
        bytes[8..24].copy_from_slice(&[0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0, 0, 0]);
        (bytes[24], bytes[32], bytes[40], bytes[41]) = (5, 6, 8, 7);
        let mut out = [0; Moved::LEN];
        assert_eq!(moved.emit(&mut out), Ok(Moved::LEN));
        assert_eq!(out, bytes);
        assert_eq!(Moved::parse(&bytes), Ok(moved));
        out[1] = 1;
        assert_eq!(Moved::parse(&out), Err(Error::Reserved { message: "moved" }));
    }
}
