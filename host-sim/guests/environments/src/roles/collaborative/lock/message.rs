//! What clients and server of a lock say to each other.

use cohold_protocol::bytes::layout;

use crate::roles::collaborative::Value;
use crate::roles::messages::messages;

layout! {
    /// A copy of the object.
    pub struct Copy(28 bytes) {
        0 => version: u32, "Fence of the grant that it was made under; 0 is how the object was in the beginning.";
        4 => value: Value, "What it is.";
    }
}

messages! {
    /// A message about one object.
    pub enum Message("lock", code 0x0101, about 1) {
        /// Client: tell me when there is something newer than this version.
        Follow = 1, 8 bytes:
            4 => known: u32, "Version the client has.";
        /// Client: I want to edit, or go on editing.
        Ask = 2, 16 bytes:
            4 => incarnation: u32, "Which life of the client.";
            8 => number: u32, "1, 2, 3 … in the order of sending.";
            12 => known: u32, "Version the client has.";
        /// Client: I have finished; with fence 0, I no longer want to.
        Release = 3, 8 bytes:
            4 => fence: u32, "Of the grant.";
            flags value: Option<Value>, "What the object is now, if the client has changed it.";
        /// Server: it is yours, as of the ask that it answers.
        Grant = 4, 44 bytes:
            4 => incarnation: u32, "Which life of the client.";
            8 => number: u32, "Of the ask.";
            12 => fence: u32, "Number of this grant: higher than that of any before.";
            16 => copy: Copy, "What there is to edit.";
        /// Server: the object as it is.
        State = 5, 32 bytes:
            4 => copy: Copy, "The official copy.";
        /// Server: what became of a release.
        Answer = 6, 8 bytes:
            4 => fence: u32, "Of the release.";
            flags taken: bool, "The value was taken.";
    }
}
