//! Two emulated Damiao motors (DM4310): MIT's frame, enabling, and the registers that are asked for.

use super::carrier::Place;
use super::hand::Hand;
use super::motors::{Emulator, Fault, Motor, Protocol, World};

/// After so long without a frame they disable themselves unless it is told otherwise, s.
pub const TIMEOUT_AFTER_S: f64 = 0.05;
/// Their faults by name.
pub const FAULTS: [(&str, Fault); 13] = [
    ("none", Fault::None),
    ("silent", Fault::Silent),
    ("late", Fault::Late),
    ("jump", Fault::Jump),
    ("unplugged", Fault::Unplugged),
    ("wrong-sign", Fault::WrongSign),
    ("no-watchdog", Fault::NoWatchdog),
    ("too-warm", Fault::TooWarm),
    ("over-voltage", Fault::OverVoltage),
    ("never", Fault::Never),
    ("other-ranges", Fault::OtherRanges),
    ("other-mode", Fault::OtherMode),
    ("flexible", Fault::Flexible),
];
/// What the register TIMEOUT counts, s.
const TIMEOUT_S: f64 = 50e-6;
/// Ends of position, speed and torque: rad, rad/s, N·m.
const ENDS: [f64; 3] = [12.5, 30.0, 10.0];
/// States: disabled, enabled, over-voltage, winding too warm, heard nothing.
const DISABLED: u8 = 0;
const ENABLED: u8 = 1;
const OVER_VOLTAGE: u8 = 8;
const TOO_WARM: u8 = 0xc;
const LOST: u8 = 0xd;

/// A number of so many bits that reach from −`end` to `end`.
fn number(bits: u64, end: f64, count: u32) -> f64 {
    bits as f64 * 2.0 * end / ((1_u64 << count) - 1) as f64 - end
}

fn bits(number: f64, end: f64, count: u32) -> u64 {
    // What is not a number is nowhere: a chip that divides by zero sends the end of its range.
    if number.is_nan() {
        (1 << count) - 1
    } else {
        ((number + end) / (2.0 * end) * ((1_u64 << count) - 1) as f64) as u64
    }
}

/// What a motor answers to a frame.
fn answer(world: &mut World, joint: usize, data: [u8; 8], timeout_s: f64) -> Vec<u8> {
    let now = world.motors[joint].mode;
    let now_s = world.hand.time_s();
    match data {
        [0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, order] => match order {
            0xfc if matches!(now, DISABLED | ENABLED) => world.ask(joint, ENABLED, 0.0, now_s + timeout_s),
            0xfd if now == ENABLED => world.off(joint, DISABLED),
            0xfb => world.off(joint, DISABLED),
            _ => {}
        },
        _ => {
            let word = u64::from_be_bytes(data);
            let (position, speed) = (number(word >> 48, ENDS[0], 16), number(word >> 36 & 0xfff, ENDS[1], 12));
            let gains = [word >> 24 & 0xfff, word >> 12 & 0xfff];
            let torque_nm = number(word & 0xfff, ENDS[2], 12);
            if now == ENABLED {
                world.pulled |= gains != [0; 2] || position.abs() > 0.001 || speed.abs() > 0.01;
                world.ask(joint, ENABLED, torque_nm, now_s + timeout_s);
            }
        }
    }
    state(world, joint)
}

/// What a motor says of itself.
fn state(world: &mut World, joint: usize) -> Vec<u8> {
    if joint == 0 && matches!(world.fault, Fault::TooWarm | Fault::OverVoltage) {
        world.off(joint, if world.fault == Fault::TooWarm { TOO_WARM } else { OVER_VOLTAGE });
    }
    let [angle, turning] = world.told(joint);
    let Motor { mode, torque_nm, .. } = world.motors[joint];
    let told = bits(angle, ENDS[0], 16) << 24 | bits(turning, ENDS[1], 12) << 12 | bits(torque_nm, ENDS[2], 12);
    let warm = if world.fault == Fault::TooWarm { 110 } else { 33 };
    [&[mode << 4 | (joint as u8 + 1)], &told.to_be_bytes()[3..], &[warm, warm + 2]].concat()
}

/// What a motor's register holds.
fn register(world: &World, which: u8, timeout_s: f64) -> [u8; 4] {
    let off = if world.fault == Fault::OtherRanges { 2.0 } else { 1.0 };
    match which {
        9 => if world.fault == Fault::Never { 0 } else { (timeout_s / TIMEOUT_S).round() as u32 }.to_le_bytes(),
        10 => if world.fault == Fault::OtherMode { 2_u32 } else { 1 }.to_le_bytes(),
        21..=23 => ((off * ENDS[usize::from(which) - 21]) as f32).to_le_bytes(),
        _ => [0; 4],
    }
}

/// Two motors on a bus there, with this hand, which disable themselves after so long without a frame, s.
///
/// # Errors
/// There cannot be a bus there.
pub fn start(place: &Place, hand: Hand<2>, timeout_s: f64) -> std::io::Result<Emulator> {
    let protocol = Protocol { name: "mit", flags: &["--device-model", "dm4310", "--device-homed"], faults: &FAULTS };
    let world = World::shared([1.0, -1.0], LOST, hand);
    Emulator::start(place, protocol, world, move |world, id, data| match (id, data) {
        (0x7ff, [who @ 1..=2, 0, 0x33, which, ..]) => {
            let value = register(world, *which, timeout_s);
            Some((0x10 + u32::from(*who), [&[*who, 0, 0x33, *which], &value[..]].concat()))
        }
        (0x7ff, [who @ 1..=2, 0, 0xcc, ..]) => Some((0x10 + u32::from(*who), state(world, usize::from(*who) - 1))),
        (1 | 2, data) => Some((0x10 + id, answer(world, id as usize - 1, data.try_into().ok()?, timeout_s))),
        _ => None,
    })
}
