//! What one tick read, computed and commanded along one shared axis, with a digest of the state behind it: 108 bytes, little-endian.
//!
//! The interrupt fills one [`Record`] a tick; tasks put its bytes into telemetry. Inputs and digest are enough to run the
//! same tick again on a PC and compare bits (tests/board does, and so may anyone with a full-rate capture).
//!
//! | offset | bytes | field |
//! |---|---|---|
//! | 0 | 4 | tick since boot |
//! | 4 | 4 | encoder counts, 2 × u16: joints 1 and 2; in the record of the second shared axis joints 2 and 3, of the third 3 and 1 |
//! | 8 | 4 | motor duties of the same joints, 2 × i16, 1/32767 of full scale |
//! | 12 | 1 | mode: 0 disarmed, 1 armed, 2 faulted, 3 probing |
//! | 13 | 1 | fault number, 0 none |
//! | 14 | 1 | flags: 1 bridges enabled, 2 a packet went out, 4 a packet came in, 8 the tick before overran, 16 let go of the other peer, 32 coordination acts |
//! | 15 | 1 | shared axis, from 0 |
//! | 16 | 12 | the packet that came in: position (m), velocity (m/s), wave (√W), 3 × f32; 0 without one |
//! | 28 | 8 | device position (m), velocity (m/s) |
//! | 36 | 8 | object position, velocity |
//! | 44 | 8 | decoded remote position, velocity |
//! | 52 | 8 | contact force, coordination force (N) |
//! | 60 | 4 | digest of the state after the tick |
//! | 64 | 8 | energy from and to the network (J) |
//! | 72 | 16 | the counters of the packet that came in: energy (J), wave integral (√W·s), 2 × f64; 0 without one |
//! | 88 | 4 | its live ticks; 0 without one |
//! | 92 | 12 | what the power stage measured since the tick before, of each motor: mean and last current (1/32767 of full scale), mean voltage (counts of the timer), 3 × i16 |
//! | 104 | 4 | supply of the bridges (mV), counts of the timer that are all of it, 2 × u16; 0 without a current loop |

use haptic_core::device::stage::{Flow, Measured};
use haptic_core::law::{Packet, ledger::Ledger};
use haptic_core::num::{Motion, StateVector};
use haptic_core::peer::Observed;
use haptic_core::{device::encoder::Counts, device::motor::Duty, safety::Mode};

use crate::signals::Coded;

/// What a sample with a record in it is called on the operator's link; where the object is shared along several axes every tick has a
/// record of each, those of the second axis called one more, those of the third two.
pub const CODE: u16 = 1;
/// Bytes of a record.
pub const BYTES: usize = 108;
const WORDS: usize = BYTES / 4;

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

/// What the records of all axes of a tick have in common.
#[derive(Clone, Copy, Debug)]
pub struct Tick {
    /// Ticks since the board started.
    pub tick: u32,
    /// The shared axis, from 0.
    pub axis: u8,
    /// Encoder counts of two joints ([`joints`]).
    pub counts: [Counts; 2],
    /// Motor duties of the same two joints.
    pub duties: [Duty; 2],
    /// What the power stage measured; none without a current loop.
    pub stage: Option<Measured>,
    /// Mode of the peer after the tick.
    pub mode: Mode,
    /// [`ENABLED`] and the others.
    pub flags: u8,
    /// Digest of the state after the tick ([`digest`]).
    pub digest: u32,
}

/// What each of the `N` joints has, of the two that the record of a shared axis (from 0) tells: the axis' own and the next one's, after the
/// last the first.
#[inline(always)]
pub fn joints<T: Copy, const N: usize>(each: [T; N], axis: usize) -> [T; 2] {
    [each[axis % N], each[(axis + 1) % N]]
}

/// One tick, of one shared axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Record(pub [u32; WORDS]);

impl Record {
    /// What a tick read and did, of one shared axis.
    #[inline(always)]
    pub fn fill(&mut self, of: &Tick, incoming: Option<&Packet<f32>>, seen: &Observed<f32>, ledger: &Ledger<f32>) {
        let Tick { tick, axis, counts, duties, stage, mode, flags, digest } = *of;
        let halves = |[low, high]: [u16; 2]| u32::from(low) | u32::from(high) << 16;
        // One after the other, and what may be absent in a branch of its own: an array of all of them, or a default, would go by way of
        // the stack.
        let Self(words) = self;
        words[0] = tick;
        words[1] = halves(counts.map(|Counts(count)| count));
        words[2] = halves(duties.map(|duty| duty.0.cast_unsigned()));
        words[3] = mode.code() | u32::from(flags) << 16 | u32::from(axis) << 24;
        if let Some(incoming) = incoming {
            let [energy, integral] = [incoming.energy_j, incoming.wave_integral].map(f64::to_bits);
            words[4] = incoming.motion.position.to_bits();
            words[5] = incoming.motion.velocity.to_bits();
            words[6] = incoming.wave.to_bits();
            words[18] = energy as u32;
            words[19] = (energy >> 32) as u32;
            words[20] = integral as u32;
            words[21] = (integral >> 32) as u32;
            words[22] = incoming.live_ticks;
        } else {
            words[4..7].fill(0);
            words[18..23].fill(0);
        }
        words[7] = seen.device.position.to_bits();
        words[8] = seen.device.velocity.to_bits();
        words[9] = seen.object.position.to_bits();
        words[10] = seen.object.velocity.to_bits();
        words[11] = seen.desired.position.to_bits();
        words[12] = seen.desired.velocity.to_bits();
        words[13] = seen.contact_force.to_bits();
        words[14] = seen.coordination_force.to_bits();
        words[15] = digest;
        words[16] = ledger.received_j().to_bits();
        words[17] = ledger.sent_j().to_bits();
        if let Some(Measured { motors: [one, two], supply_mv, supply_counts }) = stage {
            let signed = |numbers: [i16; 2]| halves(numbers.map(i16::cast_unsigned));
            words[23] = signed([one.mean, one.last]);
            words[24] = signed([one.voltage, two.mean]);
            words[25] = signed([two.last, two.voltage]);
            words[26] = halves([supply_mv, supply_counts]);
        } else {
            words[23..].fill(0);
        }
    }

    /// The bytes on the wire.
    pub fn bytes(&self) -> [u8; BYTES] {
        let mut bytes = [0; BYTES];
        for (bytes, word) in bytes.chunks_exact_mut(4).zip(self.0) {
            bytes.copy_from_slice(&word.to_le_bytes());
        }
        bytes
    }

    /// A record from its bytes.
    pub fn from_bytes(bytes: &[u8; BYTES]) -> Self {
        let words = bytes.as_chunks().0;
        Self(core::array::from_fn(|at| u32::from_le_bytes(words[at])))
    }

    /// Ticks since the board started.
    pub fn tick(&self) -> u32 {
        self.0[0]
    }
    /// The shared axis, from 0.
    pub fn axis(&self) -> u8 {
        (self.0[3] >> 24) as u8
    }
    /// Encoder counts of two joints.
    pub fn counts(&self) -> [Counts; 2] {
        [self.0[1], self.0[1] >> 16].map(|half| Counts(half as u16))
    }
    /// Motor duties of two joints.
    pub fn duties(&self) -> [Duty; 2] {
        [self.0[2], self.0[2] >> 16].map(|half| Duty((half as u16).cast_signed()))
    }
    /// What the power stage measured since the tick before; none without a current loop.
    pub fn stage(&self) -> Option<Measured> {
        let half = |at: usize| (self.0[23 + at / 2] >> (16 * (at % 2))) as u16;
        let motors = [0, 3].map(|at| {
            let [mean, last, voltage] = [at, at + 1, at + 2].map(|at| half(at).cast_signed());
            Flow { mean, last, voltage }
        });
        let stage = Measured { motors, supply_mv: half(6), supply_counts: half(7) };
        (stage.supply_counts > 0).then_some(stage)
    }
    /// Mode, and the fault in it.
    pub fn mode(&self) -> Mode {
        Mode::decode(self.0[3] & 0xFFFF)
    }
    /// [`ENABLED`], [`SENT`], [`RECEIVED`], [`OVERRUN`], [`PARTED`], [`ENGAGED`].
    pub fn flags(&self) -> u8 {
        (self.0[3] >> 16) as u8
    }
    /// The packet that came in before this tick.
    pub fn incoming(&self) -> Option<Packet<f32>> {
        let double = |low: usize| f64::from_bits(u64::from(self.0[low]) | u64::from(self.0[low + 1]) << 32);
        let [position, velocity, wave] = [self.0[4], self.0[5], self.0[6]].map(f32::from_bits);
        (self.flags() & RECEIVED != 0).then(|| Packet {
            motion: Motion { position, velocity },
            wave,
            energy_j: double(18),
            wave_integral: double(20),
            live_ticks: self.0[22],
        })
    }
    /// What the tick saw and did.
    pub fn observed(&self) -> Observed<f32> {
        let number = |word: usize| f32::from_bits(self.0[word]);
        let motion = |word: usize| Motion { position: number(word), velocity: number(word + 1) };
        Observed {
            device: motion(7),
            object: motion(9),
            desired: motion(11),
            contact_force: number(13),
            coordination_force: number(14),
        }
    }
    /// Energy from and to the network, J.
    pub fn energy_j(&self) -> [f32; 2] {
        [f32::from_bits(self.0[16]), f32::from_bits(self.0[17])]
    }
    /// Digest of the state after the tick.
    pub fn digest(&self) -> u32 {
        self.0[15]
    }
}

/// A digest of the bits of a peer's dynamic state, cheap enough for every tick: one instruction a number.
///
/// A difference in one number always shows. Differences in several show unless they are the same bits, turned by [`TURN`] a number.
#[inline]
pub fn digest(state: &mut (impl StateVector<f32> + ?Sized)) -> u32 {
    let mut digest = 0;
    state.visit(&mut |number: &mut f32| digest = number.to_bits() ^ u32::rotate_right(digest, TURN));
    digest
}

/// Odd, so that 32 numbers are turned to 32 places.
const TURN: u32 = 13;
