//! What one peer read, tick by tick, for the same peer on another processor: and the hash of all that it computed from it.
//!
//! The file is read as it is needed, so that a machine without memory to spare can replay hours of it. Nothing here
//! allocates: tests/qemu runs it on a Cortex-M7 that has no heap.
//!
//! Layout, little-endian: length of the settings (u32) and their lines `key=value`; position of the device's two axes at the
//! start (2 × f32); then for every tick a byte of flags, and what they announce: 1 exact reading (4 × f32: position and
//! velocity of both axes) instead of counts (2 × u16); 2 an exchange before the tick; 4 a packet in it (3 × f32: position,
//! velocity, wave; 2 × f64: energy, wave integral; u32: live ticks). The file ends after a tick.
//!
//! The hash: FNV-1a over 64-bit words with a fold, over the bits of the dynamic state, of forces and duties, after every tick.

use cohold_core::device::encoder::Counts;
use cohold_core::device::{AXES, Reading};
use cohold_core::law::{AnyLaw, Packet};
use cohold_core::num::{Motion, Scalar, StateVector};
use cohold_core::peer::{Actuators, Peer, Sensors};
use cohold_core::safety::Command;
use cohold_core::settings::{Settings, Value};

/// The reading is exact.
pub const EXACT: u8 = 1;
/// An exchange comes before the tick.
pub const EXCHANGE: u8 = 2;
/// A packet came in.
pub const PACKET: u8 = 4;
/// Longest text of settings, bytes.
pub const LONGEST: usize = 8192;

/// Where a hash starts.
pub const SEED: u64 = 0xcbf2_9ce4_8422_2325;

/// Why a file cannot be replayed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unreadable {
    /// It ends too early.
    Short,
    /// Its settings are none.
    Settings,
}

/// The hash goes on with what a tick left.
pub fn fold(hash: &mut u64, state: &mut (impl StateVector<f32> + ?Sized), actuators: &Actuators<f32>) {
    let mut word = |word: u64| {
        *hash = (*hash ^ word).wrapping_mul(0x0000_0100_0000_01b3);
        *hash ^= *hash >> 32;
    };
    state.visit(&mut |number: &mut f32| word(number.bits()));
    actuators.forces.iter().for_each(|force| word(force.bits()));
    actuators.duties.iter().for_each(|duty| word(u64::from(duty.0.cast_unsigned())));
    word(u64::from(actuators.enable));
}

/// Runs a file through a peer; gives ticks and hash. `read` fills its argument, or says that there is no more; `each` is told
/// what every tick commanded.
///
/// # Errors
/// It is no such file.
pub fn run(
    mut read: impl FnMut(&mut [u8]) -> bool,
    mut each: impl FnMut(u64, &Actuators<f32>),
) -> Result<(u64, u64), Unreadable> {
    let mut length = [0; 4];
    let mut text = [0; LONGEST];
    let found = read(&mut length);
    let text = text.get_mut(..u32::from_le_bytes(length) as usize).filter(|_| found).ok_or(Unreadable::Short)?;
    if !read(text) {
        return Err(Unreadable::Short);
    }
    let mut settings = Settings::default();
    for line in core::str::from_utf8(text).map_err(|_| Unreadable::Settings)?.lines() {
        let (key, text) = line.split_once('=').ok_or(Unreadable::Settings)?;
        settings.set(key, Value::of_text(text)).map_err(|_| Unreadable::Settings)?;
    }
    let mut take = |size: usize| {
        let mut bytes = [0; 16];
        let whole = bytes.get_mut(..size).is_some_and(&mut read);
        if whole { Ok(bytes) } else { Err(Unreadable::Short) }
    };
    let [x, y, ..] = floats(&take(4 * AXES)?);
    let device = [Motion::at(x), Motion::at(y)];
    let mut peer = Peer::<f32, AnyLaw<f32>>::new(&settings, device).map_err(|_| Unreadable::Settings)?;
    peer.command(Command::Arm);
    let (mut ticks, mut hash) = (0, SEED);
    while let Ok([flags, ..]) = take(1) {
        let reading = if flags & EXACT != 0 {
            let [a, b, c, d] = floats(&take(16)?);
            Reading::Exact([Motion::new(a, b), Motion::new(c, d)])
        } else {
            let [a, b, c, d, ..] = take(4)?;
            Reading::Counts([Counts(u16::from_le_bytes([a, b])), Counts(u16::from_le_bytes([c, d]))])
        };
        if flags & PACKET != 0 {
            let [position, velocity, wave, _] = floats(&take(12)?);
            let wide = take(16)?;
            let mut doubles = wide.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes));
            let mut double = || doubles.next().unwrap_or_default();
            let (energy_j, wave_integral) = (double(), double());
            let [a, b, c, d, ..] = take(4)?;
            let live_ticks = u32::from_le_bytes([a, b, c, d]);
            let motion = Motion::new(position, velocity);
            peer.hear(&[Packet { motion, wave, energy_j, wave_integral, live_ticks }]);
        }
        if flags & EXCHANGE != 0 {
            peer.exchange();
        }
        let actuators = peer.tick(&Sensors::of(reading));
        fold(&mut hash, &mut peer, &actuators);
        each(ticks, &actuators);
        ticks += 1;
    }
    Ok((ticks, hash))
}

fn floats(bytes: &[u8; 16]) -> [f32; 4] {
    let mut each = bytes.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes));
    core::array::from_fn(|_| each.next().unwrap_or_default())
}
