//! Who has the engine: what server and clients say to each other; the event's code is [`code::COOPERATIVE`]. A stamp is µs of the
//! client's clock.

use crate::bytes::{layout, messages};
use crate::roles::{carried_by_events, code};

layout! {
    /// Motion of the object along two axes as it is handed over: position (m) and velocity (m/s).
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    pub struct Body(32 bytes) {
        /// Along x and y.
        0 => axes: [[f64; 2]; 2],
    }
}

messages! {
    /// Who has the engine.
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Message("cooperative", code::COOPERATIVE, about 1) {
        /// Client: I want it.
        Ask = 1, 16 bytes {
            /// Now, on the client's clock.
            8 => stamp_us: u64,
        }
        /// Server: it is yours, go on from here.
        Lend = 2, 48 bytes {
            /// Of the engine from now on.
            4 => version: u32,
            /// As the request had it.
            8 => stamp_us: u64,
            /// Where the object is.
            16 => body: Body,
        }
        /// Client: I still have it.
        Renew = 3, 16 bytes {
            /// Of the engine.
            4 => version: u32,
            /// Now, on the client's clock.
            8 => stamp_us: u64,
        }
        /// Server: keep it.
        Renewed = 4, 16 bytes {
            /// Of the engine.
            4 => version: u32,
            /// As the request had it.
            8 => stamp_us: u64,
        }
        /// Server: give it back.
        Recall = 5, 8 bytes {
            /// Of the engine.
            4 => version: u32,
        }
        /// Client: it is yours again, go on from here.
        Return = 6, 40 bytes {
            /// Of the engine until now.
            4 => version: u32,
            /// Where the object is.
            8 => body: Body,
        }
        /// Server: it is back.
        Taken = 7, 8 bytes {
            /// Of the engine that was returned.
            4 => version: u32,
        }
    }
}

carried_by_events!(Message);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Error;
    use crate::wire::Event;

    const AT: Body = Body { axes: [[1.0, -0.5], [0.25, 0.0]] };

    #[test]
    fn literal_bytes() {
        let renew = Message::Renew { version: 7, stamp_us: 0x0a0b }.event(0x0102).unwrap();
        assert_eq!(renew.code, 0x0201);
        assert_eq!(renew.payload(), [3, 0, 2, 1, 7, 0, 0, 0, 0x0b, 0x0a, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn what_was_said_is_what_is_heard() {
        let all = [
            Message::Ask { stamp_us: u64::MAX },
            Message::Lend { version: 1, stamp_us: 2, body: AT },
            Message::Renew { version: u32::MAX, stamp_us: 0 },
            Message::Renewed { version: 3, stamp_us: 4 },
            Message::Recall { version: 5 },
            Message::Return { version: 6, body: AT },
            Message::Taken { version: 7 },
        ];
        for message in all {
            assert_eq!(Message::parse(&message.event(9).unwrap()), Ok((9, message)));
        }
    }

    #[test]
    fn cut_lengthened_and_broken_bytes_are_refused() {
        let said = Message::Return { version: 6, body: AT }.event(0).unwrap();
        let bytes = said.payload();
        let heard = |bytes: &[u8]| Message::parse(&Event::new(code::COOPERATIVE, bytes).unwrap());
        for len in 0..bytes.len() {
            assert!(heard(&bytes[..len]).is_err());
        }
        assert!(heard(&[bytes, &[0]].concat()).is_err());
        for (at, with) in [(0, 0), (0, 8), (1, 1)] {
            let mut broken = bytes.to_vec();
            broken[at] = with;
            assert!(heard(&broken).is_err());
        }
        let mut broken = bytes.to_vec();
        broken[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
        assert_eq!(heard(&broken), Err(Error::NotFinite { message: "cooperative" }));
        assert!(Message::parse(&Event::new(code::LOCK, bytes).unwrap()).is_err());
    }
}
