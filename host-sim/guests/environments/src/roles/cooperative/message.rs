//! Who has the engine: what server and clients say to each other. A stamp is µs of the client's clock.

use cohold_protocol::bytes::layout;

use crate::roles::messages::messages;

layout! {
    /// Motion of the object along two axes as it is handed over: position (m) and velocity (m/s).
    pub struct Body(32 bytes) {
        0 => axes: [[f64; 2]; 2], "Along x and y.";
    }
}

messages! {
    /// Who has the engine.
    pub enum Message("cooperative", code 0x0201, about 1) {
        /// Client: I want it.
        Ask = 1, 16 bytes:
            8 => stamp_us: u64, "Now, on the client's clock.";
        /// Server: it is yours, go on from here.
        Lend = 2, 48 bytes:
            4 => version: u32, "Of the engine from now on.";
            8 => stamp_us: u64, "As the request had it.";
            16 => body: Body, "Where the object is.";
        /// Client: I still have it.
        Renew = 3, 16 bytes:
            4 => version: u32, "Of the engine.";
            8 => stamp_us: u64, "Now, on the client's clock.";
        /// Server: you may keep it for another lease.
        Renewed = 4, 16 bytes:
            4 => version: u32, "Of the engine.";
            8 => stamp_us: u64, "As the request had it.";
        /// Server: give it back.
        Recall = 5, 8 bytes:
            4 => version: u32, "Of the engine.";
        /// Client: it is yours again, go on from here.
        Return = 6, 40 bytes:
            4 => version: u32, "Of the engine until now.";
            8 => body: Body, "Where the object is.";
        /// Server: it is back.
        Taken = 7, 8 bytes:
            4 => version: u32, "Of the engine that was returned.";
    }
}
