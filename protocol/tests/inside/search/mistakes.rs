//! Links that make a mistake: the real one but for what a call of theirs does wrong. Seen by the search alone, which has to find
//! each of them.

use crate::engagement::Rung;
use crate::link::{Error, Link};
use crate::wire::{Datagram, Greeting, Header, Message};

/// What an end does wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mistake {
    /// Nothing.
    None,
    /// A session that nothing is answered in goes on.
    SessionWithoutLife,
    /// A challenge is good for ever.
    ChallengeWithoutLife,
    /// A board does what a line says whenever it was said.
    CommandWithoutLife,
    /// What is sealed counts whenever it was sealed, and confirms the session.
    MessageWithoutLife,
    /// The four above: the protocol before any of them had a life.
    NoLives,
    /// A message is handed out although nothing has been answered in the session.
    Unconfirmed,
    /// The source of randomness gives the same at every start.
    ConstantRandomness,
    /// The ephemeral that made a session makes the next one, too.
    EphemeralKept,
    /// Sequence numbers begin again.
    SequenceAgain,
    /// The replay window forgets what has been taken.
    WindowForgets,
    /// Flow of any age is taken.
    FlowOfAnyAge,
    /// Flow is taken in any order.
    FlowInAnyOrder,
    /// Events are taken in any order and any number of times.
    EventsAgain,
    /// A session outlasts silence, and so does an engagement.
    SilenceUnheard,
}

impl Mistake {
    /// Whether an end that does `self` wrong does `one` wrong.
    fn has(self, one: Self) -> bool {
        let lives =
            [Self::SessionWithoutLife, Self::ChallengeWithoutLife, Self::CommandWithoutLife, Self::MessageWithoutLife];
        self == one || self == Self::NoLives && lives.contains(&one)
    }

    /// Random bytes for the start of a peer: its number, and how often it has started.
    pub(super) fn entropy(self, peer: u8, life: u8) -> [u8; 32] {
        let mut entropy = [peer; 32];
        entropy[0] = if self.has(Self::ConstantRandomness) { 1 } else { life };
        entropy
    }

    /// The same link, with what is wrong from the start.
    pub(super) fn made(self, link: Link) -> Link {
        if self.has(Self::FlowOfAnyAge) { link.within(u32::MAX) } else { link }
    }

    /// Whether a board does a line that it heard.
    pub(super) fn does(self, is_fresh: bool) -> bool {
        is_fresh || self.has(Self::CommandWithoutLife)
    }

    /// [`Link::receive`].
    pub(super) fn receive(self, link: &mut Link, now: u64, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        if self.has(Self::ChallengeWithoutLife) {
            link.handshake.keep_challenges(now);
        }
        if self.has(Self::WindowForgets)
            && let Some(session) = &mut link.session
        {
            session.forget_what_was_taken();
        }
        if self.has(Self::FlowInAnyOrder) {
            link.newest_flow = None;
        }
        if self.has(Self::SequenceAgain) {
            link.counter = Default::default();
        }
        if self.has(Self::EventsAgain) {
            link.receiver = Default::default();
        }
        let (handshake, was_up) = (link.handshake.clone(), link.is_up());
        let is_greeting = datagram.get(1).is_some_and(|kind| Greeting::is_kind(*kind));
        let taken = if !is_greeting && (self.has(Self::Unconfirmed) || self.has(Self::MessageWithoutLife)) {
            self.open(link, now, datagram)
        } else if self.has(Self::SessionWithoutLife) {
            // Nothing lets time pass.
            if is_greeting { link.greeted(now, datagram).map(|()| None) } else { link.open(now, datagram) }
        } else {
            link.receive(now, datagram)
        };
        if self.has(Self::EphemeralKept) && link.is_up() && !was_up {
            link.handshake = handshake;
        }
        link.settle();
        taken
    }

    /// Opens what is sealed and does not ask how old it is.
    fn open(self, link: &mut Link, now: u64, datagram: &mut [u8]) -> Result<Option<Message>, Error> {
        let (header, head, sealed) = Header::parse(datagram)?;
        link.ends.check(header.from, header.to)?;
        let session = link.session.as_mut().ok_or(Error::NoSession)?;
        let opened = session.open(now, &header, head, sealed)?;
        let (message, age_us) = (Message::parse(opened.message)?, opened.age_us);
        if self.has(Self::MessageWithoutLife) && !session.is_confirmed() {
            session.confirm();
            let incarnation = session.remote.incarnation;
            link.confirm(now, incarnation);
        }
        link.heard_us = now;
        Ok(link.take(now, header.sequence, age_us.unwrap_or(0), message))
    }

    /// [`Link::poll`].
    pub(super) fn poll(self, link: &mut Link, now: u64, out: &mut Datagram) -> Option<usize> {
        self.unhurried(link, now, |link| link.poll(now, out))
    }

    /// [`Link::send`].
    pub(super) fn send(self, link: &mut Link, now: u64, message: Message, out: &mut Datagram) -> Option<usize> {
        self.unhurried(link, now, |link| link.send(now, message, out))
    }

    /// A call that says something.
    fn unhurried<T>(self, link: &mut Link, now: u64, call: impl FnOnce(&mut Link) -> T) -> T {
        if self.has(Self::SilenceUnheard) {
            link.heard_us = now;
            if link.engagement.rung() != Rung::Disengaged {
                link.engagement.hear(now);
            }
        }
        // For the call an unconfirmed session that has no life began just now.
        let unconfirmed = link.session.as_mut().filter(|session| !session.is_confirmed());
        let Some(session) = unconfirmed.filter(|_| self.has(Self::SessionWithoutLife)) else { return call(link) };
        let began_us = core::mem::replace(&mut session.began_us, now);
        let given = call(link);
        if let Some(session) = &mut link.session {
            session.began_us = began_us;
        }
        given
    }
}
