//! What is said: the flow of motions and forces, and who has the engine.
//!
//! All little-endian, lengths exact, numbers finite, byte 0 the kind. Up and down, once each packet period, newest wins:
//!
//! | push (kind 1), 32 bytes | | | state (kind 2), 48 bytes | | |
//! |---|---|---|---|---|---|
//! | 0 | u8 | 1 | 0 | u8 | 2 |
//! | 1 | u8 × 3 | 0 | 1 | u8 × 3 | 0 |
//! | 4 | u32 | round trip, µs | 4 | u32 | version |
//! | 8 | u64 | sent, sender's µs | 8 | f32 × 4 | x, ẋ, y, ẏ of the object, m and m/s |
//! | 16 | f32 × 2 | force on the object, N | 24 | u64 | echo: when the push was sent, µs |
//! | 24 | f32 × 2 | position of the hand, m | 32 | u64 | when the push came, engine's µs |
//! | | | | 40 | u64 | sent, engine's µs |
//!
//! Who has the engine (kinds 3 to 9): kind, 3 zero bytes, version u32; `ask`, `lend`, `renew` and `renewed` then a stamp
//! u64 (µs of the client's clock); `lend` and `return` then the body, f64 × 4 (x, ẋ, y, ẏ), exact.

use core::fmt;

/// Motion of the object along two axes as it is handed over: position (m) and velocity (m/s).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Body {
    /// Along x and y.
    pub axes: [[f64; 2]; 2],
}

impl Body {
    fn is_finite(&self) -> bool {
        self.axes.iter().flatten().all(|number| number.is_finite())
    }
}

/// A client's push, to whoever has the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Push {
    /// How long the client takes the way to the engine and back to be, µs: what its contact and the engine's damping follow.
    pub round_trip_us: u32,
    /// When it was sent, µs of the client's clock.
    pub sent_us: u64,
    /// Force on the object, N.
    pub force: [f32; 2],
    /// Where the hand is, for others to see, m.
    pub hand: [f32; 2],
}

/// The object, from whoever has the engine.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// Which engine.
    pub version: u32,
    /// Position and velocity along x and y.
    pub axes: [[f32; 2]; 2],
    /// When the newest push of this client was sent, µs of its clock; 0: none yet.
    pub echo_us: u64,
    /// When it came, µs of the engine's clock.
    pub came_us: u64,
    /// When this was sent, µs of the engine's clock.
    pub sent_us: u64,
}

/// Who has the engine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Message {
    /// Client: I want it.
    Ask {
        /// Now, on the client's clock.
        stamp_us: u64,
    },
    /// Server: it is yours, go on from here.
    Lend {
        /// Of the engine from now on.
        version: u32,
        /// As the request had it.
        stamp_us: u64,
        /// Where the object is.
        body: Body,
    },
    /// Client: I still have it.
    Renew {
        /// Of the engine.
        version: u32,
        /// Now, on the client's clock.
        stamp_us: u64,
    },
    /// Server: keep it.
    Renewed {
        /// Of the engine.
        version: u32,
        /// As the request had it.
        stamp_us: u64,
    },
    /// Server: give it back.
    Recall {
        /// Of the engine.
        version: u32,
    },
    /// Client: it is yours again, go on from here.
    Return {
        /// Of the engine until now.
        version: u32,
        /// Where the object is.
        body: Body,
    },
    /// Server: it is back.
    Taken {
        /// Of the engine that was returned.
        version: u32,
    },
}

/// Bytes that are no message of this role.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Malformed;

impl fmt::Display for Malformed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("these bytes are no message of the cooperative role")
    }
}

impl core::error::Error for Malformed {}

/// Longest message, bytes.
pub(super) const MAX: usize = 48;

/// A message as bytes.
#[derive(Clone, Copy, Debug)]
pub struct Bytes {
    bytes: [u8; MAX],
    len: usize,
}

impl Bytes {
    fn new(kind: u8, word: u32) -> Self {
        Self { bytes: [0; MAX], len: 0 }.put(&[kind, 0, 0, 0]).put(&word.to_le_bytes())
    }

    fn put(mut self, field: &[u8]) -> Self {
        let end = self.len.saturating_add(field.len());
        // The longest layout fills the room exactly: nothing is ever cut.
        if let Some(room) = self.bytes.get_mut(self.len..end) {
            room.copy_from_slice(field);
            self.len = end;
        }
        self
    }

    fn body(self, body: &Body) -> Self {
        body.axes.iter().flatten().fold(self, |bytes, number| bytes.put(&number.to_le_bytes()))
    }

    fn numbers(self, numbers: &[f32]) -> Self {
        numbers.iter().fold(self, |bytes, number| bytes.put(&number.to_le_bytes()))
    }

    /// The bytes.
    pub fn as_slice(&self) -> &[u8] {
        self.bytes.get(..self.len).unwrap_or(&[])
    }
}

/// Takes fields off the front.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Malformed> {
        let (field, rest) = self.0.split_first_chunk().ok_or(Malformed)?;
        self.0 = rest;
        Ok(*field)
    }

    fn head(&mut self) -> Result<(u8, u32), Malformed> {
        let [kind, zeros @ ..] = self.take::<4>()?;
        if zeros == [0; 3] { Ok((kind, u32::from_le_bytes(self.take()?))) } else { Err(Malformed) }
    }

    fn u64(&mut self) -> Result<u64, Malformed> {
        self.take().map(u64::from_le_bytes)
    }

    fn pair(&mut self) -> Result<[f32; 2], Malformed> {
        let pair = [f32::from_le_bytes(self.take()?), f32::from_le_bytes(self.take()?)];
        if pair.iter().all(|number| number.is_finite()) { Ok(pair) } else { Err(Malformed) }
    }

    fn body(&mut self) -> Result<Body, Malformed> {
        let mut body = Body::default();
        for number in body.axes.iter_mut().flatten() {
            *number = f64::from_le_bytes(self.take()?);
        }
        if body.is_finite() { Ok(body) } else { Err(Malformed) }
    }

    fn end<T>(self, message: T) -> Result<T, Malformed> {
        if self.0.is_empty() { Ok(message) } else { Err(Malformed) }
    }
}

impl Push {
    /// Bytes.
    pub const LEN: usize = 32;

    /// As bytes.
    pub fn emit(&self) -> Bytes {
        Bytes::new(1, self.round_trip_us).put(&self.sent_us.to_le_bytes()).numbers(&self.force).numbers(&self.hand)
    }

    /// From bytes.
    ///
    /// # Errors
    /// They are none of these.
    pub fn parse(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut fields = Fields(bytes);
        let (1, round_trip_us) = fields.head()? else { return Err(Malformed) };
        let push = Self { round_trip_us, sent_us: fields.u64()?, force: fields.pair()?, hand: fields.pair()? };
        fields.end(push)
    }
}

impl State {
    /// Bytes.
    pub const LEN: usize = 48;

    /// As bytes.
    pub fn emit(&self) -> Bytes {
        let times = [self.echo_us, self.came_us, self.sent_us];
        let bytes = self.axes.iter().fold(Bytes::new(2, self.version), |bytes, axis| bytes.numbers(axis));
        times.iter().fold(bytes, |bytes, time| bytes.put(&time.to_le_bytes()))
    }

    /// From bytes.
    ///
    /// # Errors
    /// They are none of these.
    pub fn parse(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut fields = Fields(bytes);
        let (2, version) = fields.head()? else { return Err(Malformed) };
        let axes = [fields.pair()?, fields.pair()?];
        let state = Self { version, axes, echo_us: fields.u64()?, came_us: fields.u64()?, sent_us: fields.u64()? };
        fields.end(state)
    }
}

impl Message {
    /// As bytes.
    pub fn emit(&self) -> Bytes {
        match self {
            Self::Ask { stamp_us } => Bytes::new(3, 0).put(&stamp_us.to_le_bytes()),
            Self::Lend { version, stamp_us, body } => Bytes::new(4, *version).put(&stamp_us.to_le_bytes()).body(body),
            Self::Renew { version, stamp_us } => Bytes::new(5, *version).put(&stamp_us.to_le_bytes()),
            Self::Renewed { version, stamp_us } => Bytes::new(6, *version).put(&stamp_us.to_le_bytes()),
            Self::Recall { version } => Bytes::new(7, *version),
            Self::Return { version, body } => Bytes::new(8, *version).body(body),
            Self::Taken { version } => Bytes::new(9, *version),
        }
    }

    /// From bytes.
    ///
    /// # Errors
    /// They are none of these.
    pub fn parse(bytes: &[u8]) -> Result<Self, Malformed> {
        let mut fields = Fields(bytes);
        let message = match fields.head()? {
            (3, 0) => Self::Ask { stamp_us: fields.u64()? },
            (4, version) => Self::Lend { version, stamp_us: fields.u64()?, body: fields.body()? },
            (5, version) => Self::Renew { version, stamp_us: fields.u64()? },
            (6, version) => Self::Renewed { version, stamp_us: fields.u64()? },
            (7, version) => Self::Recall { version },
            (8, version) => Self::Return { version, body: fields.body()? },
            (9, version) => Self::Taken { version },
            _ => return Err(Malformed),
        };
        fields.end(message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BODY: Body = Body { axes: [[1.0, -0.5], [0.25, 0.0]] };

    #[test]
    fn literal_bytes() {
        let push = Push { round_trip_us: 0x0102_0304, sent_us: 5, force: [1.0, -0.5], hand: [2.5, 0.0] };
        let bytes = [
            1, 0, 0, 0, 4, 3, 2, 1, 5, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x80, 0x3f, 0, 0, 0, 0xbf, 0, 0, 0x20, 0x40, 0, 0, 0,
            0,
        ];
        assert_eq!(push.emit().as_slice(), bytes);
        assert_eq!(Push::parse(&bytes), Ok(push));
        let renew = Message::Renew { version: 7, stamp_us: 0x0a0b };
        assert_eq!(renew.emit().as_slice(), [5, 0, 0, 0, 7, 0, 0, 0, 0x0b, 0x0a, 0, 0, 0, 0, 0, 0]);
    }

    #[test]
    fn what_was_said_is_what_is_heard() {
        let all = [
            Message::Ask { stamp_us: u64::MAX },
            Message::Lend { version: 1, stamp_us: 2, body: BODY },
            Message::Renew { version: u32::MAX, stamp_us: 0 },
            Message::Renewed { version: 3, stamp_us: 4 },
            Message::Recall { version: 5 },
            Message::Return { version: 6, body: BODY },
            Message::Taken { version: 7 },
        ];
        for message in all {
            let bytes = message.emit();
            assert_eq!(Message::parse(bytes.as_slice()), Ok(message));
            assert!(Push::parse(bytes.as_slice()).is_err() && State::parse(bytes.as_slice()).is_err());
        }
        let state = State { version: 9, axes: [[1.0, 2.0], [3.0, 4.0]], echo_us: 5, came_us: 6, sent_us: 7 };
        assert_eq!(state.emit().as_slice().len(), State::LEN);
        assert_eq!(State::parse(state.emit().as_slice()), Ok(state));
        assert_eq!(Push::default().emit().as_slice().len(), Push::LEN);
    }

    #[test]
    fn cut_lengthened_and_broken_bytes_are_refused() {
        let bytes = Message::Return { version: 6, body: BODY }.emit();
        let bytes = bytes.as_slice();
        for len in 0..bytes.len() {
            assert_eq!(Message::parse(&bytes[..len]), Err(Malformed));
        }
        assert_eq!(Message::parse(&[bytes, &[0]].concat()), Err(Malformed));
        let mut broken = [0; 40];
        broken.copy_from_slice(bytes);
        broken[8..16].copy_from_slice(&f64::NAN.to_le_bytes());
        assert_eq!(Message::parse(&broken), Err(Malformed));
        broken.copy_from_slice(bytes);
        broken[2] = 1;
        assert_eq!(Message::parse(&broken), Err(Malformed));
    }
}
