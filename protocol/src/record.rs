//! A board's record of one tick along one shared axis (feature `peer`): what it read, computed and commanded, with a digest of the state
//! behind it. 27 words of 4 bytes, little-endian; where each begins is in [`word`], and of a quantity of the axis in
//! [`cohold_core::sample`], f32 there.
//!
//! The interrupt fills one [`Record`] a tick; tasks put its bytes into samples of the operator's link. Inputs and digest are enough to run
//! the same tick again on a PC and compare bits (tests/board does, and so may anyone with a full-rate capture).

use cohold_core::device::stage::{Flow, Measured};
use cohold_core::law::Packet;
use cohold_core::num::{Motion, Scalar, StateVector};
use cohold_core::peer::Observed;
use cohold_core::sample::{self, OfAxis, OfPeer, SAMPLE};
use cohold_core::{device::encoder::Counts, device::motor::Duty, safety::Fault, safety::Mode};

use crate::peer::wire;

/// What a sample with a record in it is called on the operator's link; where the object is shared along several axes every tick has a
/// record of each, those of the second axis called one more, those of the third two.
pub const CODE: u16 = 1;
/// Bytes of a record.
pub const BYTES: usize = 4 * (WORDS + ADDED);
/// Words that every record has.
const WORDS: usize = 27;
/// Words of quantities behind them.
const ADDED: usize = {
    let (mut rest, mut end) = (SAMPLE.axis, WORDS);
    while let [first, others @ ..] = rest {
        assert!(matches!(first.word, 7..=14 | 16..=17 | WORDS..), "the word is not free");
        (rest, end) = (others, if first.word < end { end } else { first.word + 1 });
    }
    end - WORDS
};

/// Where what is no quantity of an axis begins, in words from 0.
pub mod word {
    /// Ticks since boot, u32.
    pub const TICK: usize = 0;
    /// Encoder counts, 2 × u16: of joints 1 and 2; in the record of the second shared axis of 2 and 3, of the third of 3 and 1.
    pub const COUNTS: usize = 1;
    /// Motor duties of the same joints, 2 × i16, 1/32767 of full scale.
    pub const DUTIES: usize = 2;
    /// Four bytes: [`Mode::number`](cohold_core::safety::Mode::number), the fault's number (0 none), flags ([`super::ENABLED`] and what
    /// follows it), and the shared axis, from 0, in two bits, above which is the thermistor that the power stage measured.
    pub const MODE: usize = 3;
    /// The packet that came in: position (m), velocity (m/s), wave (√W), 3 × f32; 0 without one.
    pub const HEARD: usize = 4;
    /// Digest of the state after the tick, u32.
    pub const DIGEST: usize = 15;
    /// The counters of the packet that came in: energy (J), wave integral (√W·s), 2 × f64, and live ticks, u32; 0 without one.
    pub const COUNTERS: usize = 18;
    /// What the power stage measured since the tick before, of each motor: mean and last current (1/32767 of full scale), mean voltage
    /// (counts of the timer), 6 × i16; supply of the bridges (mV), counts of the timer that are all of it, 2 × u16. 0 without a current
    /// loop.
    pub const STAGE: usize = 23;
}

/// What a sample is called that holds PWM periods in a row: the number of the first, u32, then of each a [`Period`].
pub const PERIODS: u16 = 16;
/// Periods in such a sample.
pub const PERIODS_IN_ONE: usize = 10;

/// What the current loop saw and did in one period of its PWM, of two motors, 1/32767 of full scale and of the supply.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Period {
    /// Currents at its beginning.
    pub currents: [i16; 2],
    /// Voltages over it.
    pub voltages: [i16; 2],
}

impl Period {
    /// Bytes of one.
    pub const BYTES: usize = 8;

    /// The bytes on the wire.
    pub fn bytes(self) -> [u8; Self::BYTES] {
        let ([a, b], [c, d]) = (self.currents.map(i16::to_le_bytes), self.voltages.map(i16::to_le_bytes));
        [a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]]
    }

    /// The periods in the payload of a sample, each with its number.
    pub fn of_payload(payload: &[u8]) -> impl Iterator<Item = (u32, Self)> {
        let (first, rest) = payload.split_first_chunk().unwrap_or((&[0; 4], &[]));
        let first = u32::from_le_bytes(*first);
        rest.as_chunks().0.iter().enumerate().map(move |(nth, &[a, b, c, d, e, f, g, h])| {
            let [a, b, c, d] = [[a, b], [c, d], [e, f], [g, h]].map(i16::from_le_bytes);
            (first.wrapping_add(nth as u32), Self { currents: [a, b], voltages: [c, d] })
        })
    }
}

/// The bridges are enabled.
pub const ENABLED: u8 = 1;
/// A packet went out before this tick.
pub const SENT: u8 = 2;
/// A packet came in before this tick.
pub const RECEIVED: u8 = 4;
/// The tick before had not ended when this one was due.
pub const OVERRUN: u8 = 8;
/// The peer let go of the other one before this tick: the link's session had ended.
pub const PARTED: u8 = 16;
/// The coordination acted in this tick.
pub const ENGAGED: u8 = 32;

/// What is the same of every record of a tick.
#[derive(Clone, Copy, Debug)]
pub struct Tick<'a> {
    /// Since boot.
    pub tick: u32,
    /// The shared axis, from 0.
    pub axis: u8,
    /// Of two joints ([`joints`]): encoder counts and motor duties.
    pub counts: [Counts; 2],
    /// As above.
    pub duties: [Duty; 2],
    /// What the power stage measured; none without a current loop.
    pub stage: Option<&'a Measured>,
    /// The mode after the tick ([`mode_code`]).
    pub mode: u32,
    /// [`ENABLED`] and the others.
    pub flags: u8,
    /// Of the state after the tick ([`digest`]).
    pub digest: u32,
}

/// What each of the `N` joints has, of the two that the record of a shared axis (from 0) tells: the axis' own and the next one's, after the
/// last the first.
#[inline(always)]
#[allow(clippy::indexing_slicing, reason = "a remainder by the length is within it")]
pub fn joints<T: Copy, const N: usize>(each: [T; N], axis: usize) -> [T; 2] {
    [each[axis % N], each[(axis + 1) % N]]
}

/// Mode in bits 0–7, fault number in bits 8–15.
#[inline]
pub fn mode_code(mode: Mode) -> u32 {
    if mode == Mode::Armed { u32::from(Mode::Armed.number()) } else { unarmed_code(mode) }
}

/// Apart, so that a tick with motors on looks nothing up.
#[cold]
#[inline(never)]
fn unarmed_code(mode: Mode) -> u32 {
    u32::from(mode.number()) | u32::from(mode.fault_number()) << 8
}

/// The mode that such a number means; any other means a fault.
pub fn mode_of_code(code: u32) -> Mode {
    match code & 0xFF {
        0 => Mode::Disarmed,
        1 => Mode::Armed,
        3 => Mode::Probing,
        _ => Mode::Faulted(Fault::from_number((code >> 8) as u8).unwrap_or(Fault::NonFiniteInput)),
    }
}

/// One tick, of one shared axis: the words that every record has, and those of more quantities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Record<const MORE: usize = ADDED>(pub [u32; WORDS], pub [u32; MORE]);

impl<const MORE: usize> Record<MORE> {
    /// All words 0.
    pub const EMPTY: Self = Self([0; WORDS], [0; MORE]);
}

impl<const MORE: usize> Default for Record<MORE> {
    fn default() -> Self {
        Self::EMPTY
    }
}

impl Record {
    /// What a tick read and did, of one shared axis, each number to the nearest f32.
    #[inline(always)]
    pub fn fill<S: Scalar>(&mut self, of: &Tick<'_>, incoming: Option<&Packet<S>>, axis: &OfAxis<'_, S>) {
        self.fill_with(of, incoming, |record| sample::each(axis, |word, number| record.put(word, wire(number))));
    }

    /// The bytes on the wire.
    pub fn bytes(&self) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        for (bytes, word) in bytes.as_chunks_mut().0.iter_mut().zip(self.0.iter().chain(&self.1)) {
            *bytes = word.to_le_bytes();
        }
        bytes
    }

    /// A record from its bytes; none where they are fewer or more.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (words, odd) = bytes.as_chunks();
        let mut record = Self::default();
        for (to, from) in record.0.iter_mut().chain(&mut record.1).zip(words) {
            *to = u32::from_le_bytes(*from);
        }
        (words.len() == WORDS + ADDED && odd.is_empty()).then_some(record)
    }
}

impl<const MORE: usize> Record<MORE> {
    /// The same; `quantities` puts those of the axis.
    #[inline(always)]
    pub fn fill_with<S: Scalar>(
        &mut self,
        of: &Tick<'_>,
        incoming: Option<&Packet<S>>,
        quantities: impl FnOnce(&mut Self),
    ) {
        let Tick { tick, axis, counts, duties, stage, mode, flags, digest } = *of;
        let halves = |[low, high]: [u16; 2]| u32::from(low) | u32::from(high) << 16;
        // One after the other, and what may be absent in a branch of its own: an array of all of them, or a default, would go by way of
        // the stack.
        let Self(words, _) = self;
        words[word::TICK] = tick;
        words[word::COUNTS] = halves(counts.map(|Counts(count)| count));
        words[word::DUTIES] = halves(duties.map(|duty| duty.0.cast_unsigned()));
        words[word::MODE] = mode | u32::from(flags) << 16 | u32::from(axis) << 24;
        if let Some(incoming) = incoming {
            let [energy, integral] = [incoming.energy_j, incoming.wave_integral].map(|sum| sum.to_f64().to_bits());
            words[word::HEARD] = wire(incoming.motion.position).to_bits();
            words[word::HEARD + 1] = wire(incoming.motion.velocity).to_bits();
            words[word::HEARD + 2] = wire(incoming.wave).to_bits();
            words[word::COUNTERS] = energy as u32;
            words[word::COUNTERS + 1] = (energy >> 32) as u32;
            words[word::COUNTERS + 2] = integral as u32;
            words[word::COUNTERS + 3] = (integral >> 32) as u32;
            words[word::COUNTERS + 4] = incoming.live_ticks;
        } else {
            words[word::HEARD..word::HEARD + 3].fill(0);
            words[word::COUNTERS..word::COUNTERS + 5].fill(0);
        }
        quantities(self);
        let Self(words, _) = self;
        words[word::DIGEST] = digest;
        if let Some(stage) = stage {
            let [one, two] = &stage.motors;
            words[word::MODE] |= u32::from(stage.thermistor) << 26;
            let signed = |numbers: [i16; 2]| halves(numbers.map(i16::cast_unsigned));
            words[word::STAGE] = signed([one.mean, one.last]);
            words[word::STAGE + 1] = signed([one.voltage, two.mean]);
            words[word::STAGE + 2] = signed([two.last, two.voltage]);
            words[word::STAGE + 3] = halves([stage.supply_mv, stage.supply_counts]);
        } else {
            words[word::STAGE..].fill(0);
        }
    }

    /// A quantity of the axis, at its word.
    #[inline(always)]
    pub fn put(&mut self, word: usize, number: f32) {
        let Self(words, more) = self;
        let place = if word < WORDS { words.get_mut(word) } else { more.get_mut(word - WORDS) };
        if let Some(place) = place {
            *place = number.to_bits();
        }
    }

    /// The quantity at a word; 0 where the record has none.
    pub fn number(&self, word: usize) -> f32 {
        f32::from_bits(self.0.iter().chain(&self.1).nth(word).copied().unwrap_or(0))
    }

    /// Ticks since boot.
    pub fn tick(&self) -> u32 {
        self.0[word::TICK]
    }
    /// The shared axis, from 0.
    pub fn axis(&self) -> u8 {
        (self.0[word::MODE] >> 24) as u8 & 3
    }
    /// Encoder counts.
    pub fn counts(&self) -> [Counts; 2] {
        let counts = self.0[word::COUNTS];
        [counts, counts >> 16].map(|half| Counts(half as u16))
    }
    /// Motor duties.
    pub fn duties(&self) -> [Duty; 2] {
        let duties = self.0[word::DUTIES];
        [duties, duties >> 16].map(|half| Duty((half as u16).cast_signed()))
    }
    /// What the power stage measured since the tick before; none without a current loop.
    pub fn stage(&self) -> Option<Measured> {
        let [.., one, two, three, supply] = self.0.map(|word| [word as u16, (word >> 16) as u16]);
        let flow = |numbers: [u16; 3]| {
            let [mean, last, voltage] = numbers.map(u16::cast_signed);
            Flow { mean, last, voltage }
        };
        let motors = [flow([one[0], one[1], two[0]]), flow([two[1], three[0], three[1]])];
        let [supply_mv, supply_counts] = supply;
        let thermistor = (self.0[word::MODE] >> 26) as u8;
        (supply_counts > 0).then_some(Measured { motors, supply_mv, supply_counts, thermistor })
    }
    /// Mode, and the fault in it.
    pub fn mode(&self) -> Mode {
        mode_of_code(self.0[word::MODE] & 0xFFFF)
    }
    /// The peer as a whole, as it reported it.
    pub fn of_peer(&self) -> OfPeer {
        let [mode, fault, ..] = self.0[word::MODE].to_le_bytes();
        OfPeer { tick: self.tick().into(), mode, fault }
    }
    /// [`ENABLED`], [`SENT`], [`RECEIVED`], [`OVERRUN`], [`PARTED`], [`ENGAGED`].
    pub fn flags(&self) -> u8 {
        (self.0[word::MODE] >> 16) as u8
    }
    /// The packet that came in before this tick.
    pub fn incoming(&self) -> Option<Packet<f32>> {
        let Self(words, _) = self;
        let double = |low: u32, high: u32| f64::from_bits(u64::from(low) | u64::from(high) << 32);
        (self.flags() & RECEIVED != 0).then(|| Packet {
            motion: Motion { position: self.number(word::HEARD), velocity: self.number(word::HEARD + 1) },
            wave: self.number(word::HEARD + 2),
            energy_j: double(words[word::COUNTERS], words[word::COUNTERS + 1]),
            wave_integral: double(words[word::COUNTERS + 2], words[word::COUNTERS + 3]),
            live_ticks: words[word::COUNTERS + 4],
        })
    }
    /// What the tick saw and did.
    pub fn observed(&self) -> Observed<f32> {
        let motion = |position, velocity| Motion { position: self.number(position), velocity: self.number(velocity) };
        Observed {
            device: motion(const { SAMPLE.word("device_m") }, const { SAMPLE.word("device_m_per_s") }),
            object: motion(const { SAMPLE.word("object_m") }, const { SAMPLE.word("object_m_per_s") }),
            desired: motion(const { SAMPLE.word("decoded_m") }, const { SAMPLE.word("decoded_m_per_s") }),
            contact_force: self.number(const { SAMPLE.word("contact_n") }),
            coordination_force: self.number(const { SAMPLE.word("coordination_n") }),
        }
    }
    /// Energy from and to the network, J.
    pub fn energy_j(&self) -> [f32; 2] {
        [const { SAMPLE.word("energy_received_j") }, const { SAMPLE.word("energy_sent_j") }]
            .map(|word| self.number(word))
    }
    /// Digest of the state after the tick.
    pub fn digest(&self) -> u32 {
        self.0[word::DIGEST]
    }
}

/// A digest of the bits of a peer's dynamic state, cheap enough for every tick: one instruction a number.
///
/// A difference in one number always shows. Differences in several show unless they are the same bits, turned by `TURN` a number.
#[inline]
pub fn digest<S: Scalar>(state: &mut (impl StateVector<S> + ?Sized)) -> u32 {
    let mut digest = 0;
    // The higher half of an f32's bits is 0.
    state.visit(&mut |number: &mut S| {
        digest = (number.bits() ^ number.bits() >> 32) as u32 ^ u32::rotate_right(digest, TURN);
    });
    digest
}

/// Odd, so that 32 numbers are turned to 32 places.
const TURN: u32 = 13;
