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
