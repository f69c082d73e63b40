//! What a datagram on the one socket is, by its first byte, and what the meeting place's own datagrams say.
//!
//! | first byte | what | who reads it |
//! |---|---|---|
//! | 0, 1 | STUN (RFC 8489), with its cookie and its length | ICE |
//! | [`VERSION`] | sealed wire, or its greeting | the link above, never the carrier |
//! | 0xF1, 0xF2 | join and welcome | meeting place and seat |
//! | 0xF3 | signal between the two carriers, sealed | the carrier |
//! | 0xF4 | agreement under an invite | agreement |
//!
//! Neither can be taken for another: the first byte differs. RFC 7983 gives 0 to 3 to STUN, of whose messages none begins with more than 1, and
//! 20 to 79 to DTLS and TURN: versions of the wire shun 0, 1 and 20 to 79. All numbers are little-endian, but for STUN's.

use std::net::{Ipv6Addr, SocketAddr};

use cohold_protocol::key::Key;
use cohold_protocol::wire::VERSION;
use x25519_dalek::{X25519_BASEPOINT_BYTES, x25519};

const JOIN: u8 = 0xF1;
const WELCOME: u8 = 0xF2;
pub(crate) const SIGNAL: u8 = 0xF3;
pub(crate) const AGREEMENT: u8 = 0xF4;
const _: () = assert!(VERSION > 1 && (VERSION < 20 || VERSION > 79) && VERSION < JOIN);

/// Longest datagram that is relayed, bytes: the wire's longest has 200, a signal with six addresses 198.
pub const LONGEST: usize = 208;
/// Bytes of an address: port, then IPv6 or IPv4-mapped.
pub(crate) const ADDRESS: usize = 18;

/// A public key of X25519.
pub type Public = [u8; 32];

/// A secret key made of another one that nobody else has, and its public key.
pub(crate) fn pair(of: &Key) -> (Key, Public) {
    let secret = Key::new(of.derive("pair").first());
    let public = x25519(*secret.bytes(), X25519_BASEPOINT_BYTES);
    (secret, public)
}

/// What a datagram is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Frame {
    /// A message of STUN.
    Stun,
    /// What the link above says.
    Sealed,
    /// Asks for a seat.
    Join,
    /// Answers a join.
    Welcome,
    /// What one carrier says to the other.
    Signal,
    /// What two ends say to agree on a key.
    Agreement,
    /// Nothing that is known.
    Unknown,
}

impl Frame {
    /// What a datagram is.
    pub fn of(datagram: &[u8]) -> Self {
        match datagram.first() {
            Some(0 | 1) if super::stun::is_message(datagram) => Self::Stun,
            Some(&VERSION) => Self::Sealed,
            Some(&JOIN) if datagram.len() == Join::LEN => Self::Join,
            Some(&WELCOME) if datagram.len() == Welcome::LEN => Self::Welcome,
            Some(&SIGNAL) => Self::Signal,
            Some(&AGREEMENT) => Self::Agreement,
            _ => Self::Unknown,
        }
    }

    /// Whether a meeting place passes it on.
    pub fn is_relayed(self) -> bool {
        matches!(self, Self::Sealed | Self::Signal | Self::Agreement)
    }
}

/// An address as 18 bytes.
pub(crate) fn address_bytes(address: SocketAddr) -> [u8; ADDRESS] {
    let ip = match address.ip() {
        std::net::IpAddr::V4(ip) => ip.to_ipv6_mapped(),
        std::net::IpAddr::V6(ip) => ip,
    };
    datagram(&[&address.port().to_le_bytes(), &ip.octets()])
}

/// These parts in a row.
pub(crate) fn datagram<const N: usize>(parts: &[&[u8]]) -> [u8; N] {
    let mut bytes = [0; N];
    bytes.iter_mut().zip(parts.concat()).for_each(|(to, from)| *to = from);
    bytes
}

/// The address of 18 bytes.
pub(crate) fn address_of(bytes: &[u8; ADDRESS]) -> SocketAddr {
    let [low, high, ip @ ..] = *bytes;
    SocketAddr::new(Ipv6Addr::from(ip).to_canonical(), u16::from_le_bytes([low, high]))
}

/// Reads a datagram piece by piece.
pub(crate) struct Bytes<'a>(pub(crate) &'a [u8]);

impl Bytes<'_> {
    /// The next `N` bytes.
    pub(crate) fn next<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (next, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*next)
    }
}

/// The short name of a seat's public key, which says nothing of the secret key.
pub(crate) fn name(seat: &Public) -> [u8; 16] {
    Key::new(*seat).derive("seat").first()
}

/// What shows a meeting place that an end has the secret key of a seat: of X25519 between this and the place's key, and a cookie of the end's address.
pub(crate) fn proof(own: &Key, theirs: &Public, cookie: &[u8; 16]) -> [u8; 16] {
    Key::new(x25519(*own.bytes(), *theirs)).derive("proof").with(cookie).first()
}

/// Asks the meeting place for a seat, or keeps it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Join {
    /// Which of the two seats: 0 or 1.
    pub side: u8,
    /// Public key of this seat, of which only the two ends of the room have the secret key.
    pub seat: Public,
    /// Name of the other seat's public key.
    pub other: [u8; 16],
    /// What the meeting place has sent here; 0 at first.
    pub cookie: [u8; 16],
    /// That the end has the secret key, for this cookie and no other.
    pub proof: [u8; 16],
    /// Comes back in the welcome, so that nobody else can have written it.
    pub nonce: [u8; 8],
}

impl Join {
    /// Bytes of a join: longer than its answer.
    pub const LEN: usize = 90;

    /// The room of its two seats.
    pub fn room(&self) -> [u8; 16] {
        let (own, other) = (name(&self.seat), self.other);
        let [first, second] = if self.side == 0 { [own, other] } else { [other, own] };
        Key::new(datagram(&[&first, &second])).derive("room").first()
    }

    /// The datagram.
    pub fn emit(&self) -> [u8; Self::LEN] {
        let Self { side, seat, other, cookie, proof, nonce } = self;
        datagram(&[&[JOIN, *side], seat, other, cookie, proof, nonce])
    }

    /// The join in a datagram.
    pub fn parse(datagram: &[u8]) -> Option<Self> {
        let mut bytes = Bytes(datagram);
        let [kind, side] = bytes.next()?;
        let (seat, other, cookie) = (bytes.next()?, bytes.next()?, bytes.next()?);
        let join = Self { side, seat, other, cookie, proof: bytes.next()?, nonce: bytes.next()? };
        (kind == JOIN && side < 2 && datagram.len() == Self::LEN).then_some(join)
    }
}

/// The meeting place's answer to a join.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Welcome {
    /// The seat is taken.
    pub seated: bool,
    /// The other seat is taken, too.
    pub other: bool,
    /// There is no seat: the place is full, or too many have come from there, or the seat is another's.
    pub refused: bool,
    /// What to send back.
    pub cookie: [u8; 16],
    /// The meeting place's public key, another one at every start.
    pub place: Public,
    /// The join's.
    pub nonce: [u8; 8],
    /// Where the join came from.
    pub seen: SocketAddr,
}

impl Welcome {
    /// Bytes of a welcome.
    pub const LEN: usize = 76;

    /// The datagram.
    pub fn emit(&self) -> [u8; Self::LEN] {
        let flags = [self.seated, self.other, self.refused];
        let flags = flags.iter().enumerate().fold(0, |all, (at, flag)| all | u8::from(*flag) << at);
        datagram(&[&[WELCOME, flags], &self.cookie, &self.place, &self.nonce, &address_bytes(self.seen)])
    }

    /// The welcome in a datagram.
    pub fn parse(datagram: &[u8]) -> Option<Self> {
        let mut bytes = Bytes(datagram);
        let [kind, flags] = bytes.next()?;
        let flag = |at: u8| flags >> at & 1 == 1;
        let (cookie, place, nonce, seen) = (bytes.next()?, bytes.next()?, bytes.next()?, address_of(&bytes.next()?));
        let welcome = Self { seated: flag(0), other: flag(1), refused: flag(2), cookie, place, nonce, seen };
        (kind == WELCOME && datagram.len() == Self::LEN).then_some(welcome)
    }
}
