//! Stage: how far two peers can have come with each other, and what there is to tell about it.

/// How far two peers have come with each other.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Stage {
    /// No session: saying hello.
    Calling = 0,
    /// The other peer has proved itself; keys are there, nothing has been heard under them yet.
    Joining = 1,
    /// Heard, but no flow comes: the other peer is there and does not coordinate.
    Idle = 2,
    /// Flow comes.
    Running = 3,
    /// Flow stays away; the coordination lets go.
    Fading = 4,
    /// The other peer was told other parameters; still saying hello, in case it is told better.
    Refused = 5,
}

/// Something that has happened to a link; [`crate::link::Link::take_notice`] tells each once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Notice {
    /// A session is confirmed: there are fresh keys at both ends.
    Joined,
    /// The other peer has started anew since the last session, or is here for the first time. Events that were under way
    /// are dropped.
    NewPeer {
        /// How many events were dropped.
        dropped: u8,
    },
    /// Flow comes: begin the coordination from rest, [`crate::link::Link::engagement`] rises from 0.
    Engaged,
    /// No flow for 3 packet periods: the engagement falls.
    Fading,
    /// Flow again before the engagement was lost: it rises from where it was.
    Resumed,
    /// The engagement is 0: no flow for 12 packet periods, or the session has ended.
    Disengaged,
    /// The session has ended: a goodbye, silence for 12 packet periods, or the other peer has started another one.
    Lost,
    /// The other peer was told something else.
    Refused {
        /// The first table of parameters that differs.
        table: &'static str,
    },
}
