//! What clients and server of a lock say to each other; the event's code is [`code::LOCK`].

use crate::bytes::{layout, messages};
use crate::roles::collaborative::Value;
use crate::roles::{carried_by_events, code};

layout! {
    /// A copy of the object.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Copy(28 bytes) {
        /// Fence of the grant that it was made under; 0 is how the object was in the beginning.
        0 => version: u32,
        /// What it is.
        4 => value: Value,
    }
}

messages! {
    /// A message about one object.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Message("lock", code::LOCK, about 1) {
        /// Client: tell me when there is something newer than this version.
        Follow = 1, 8 bytes {
            /// Version the client has.
            4 => known: u32,
        }
        /// Client: I want to edit, or go on editing.
        Ask = 2, 16 bytes {
            /// Which life of the client.
            4 => incarnation: u32,
            /// 1, 2, 3 … in the order of sending.
            8 => number: u32,
            /// Version the client has.
            12 => known: u32,
        }
        /// Client: I have finished; with fence 0, I no longer want to.
        Release = 3, 8 bytes {
            /// Of the grant.
            4 => fence: u32,
        }, flags {
            /// What the object is now, if the client has changed it.
            value: Option<Value>,
        }
        /// Server: it is yours, as of the ask that it answers.
        Grant = 4, 44 bytes {
            /// Which life of the client.
            4 => incarnation: u32,
            /// Of the ask.
            8 => number: u32,
            /// Number of this grant: higher than that of any before.
            12 => fence: u32,
            /// What there is to edit.
            16 => copy: Copy,
        }
        /// Server: the object as it is.
        State = 5, 32 bytes {
            /// The official copy.
            4 => copy: Copy,
        }
        /// Server: what became of a release.
        Answer = 6, 8 bytes {
            /// Of the release.
            4 => fence: u32,
        }, flags {
            /// The value was taken.
            taken: bool,
        }
    }
}

carried_by_events!(Message);
