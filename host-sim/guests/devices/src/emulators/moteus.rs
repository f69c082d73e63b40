//! Two emulated moteus motors: the public register map as far as a torque loop needs it, read here by itself, byte for byte.

use super::carrier::Place;
use super::hand::Hand;
use super::motors::{Emulator, Fault, Protocol, World};

/// Their faults by name.
pub const FAULTS: [(&str, Fault); 12] = [
    ("none", Fault::None),
    ("silent", Fault::Silent),
    ("late", Fault::Late),
    ("not-a-number", Fault::NotANumber),
    ("jump", Fault::Jump),
    ("unplugged", Fault::Unplugged),
    ("wrong-sign", Fault::WrongSign),
    ("no-watchdog", Fault::NoWatchdog),
    ("too-warm", Fault::TooWarm),
    ("over-voltage", Fault::OverVoltage),
    ("holds", Fault::Holds),
    ("relative", Fault::Relative),
];
/// Modes: stopped, fault, position, timeout.
const STOPPED: u8 = 0;
const FAULT: u8 = 1;
const POSITION: u8 = 10;
const TIMEOUT: u8 = 11;
/// Registers of a command.
const FEEDFORWARD: u32 = 0x22;
const GAINS: [u32; 3] = [0x23, 0x24, 0x2b];
const WATCHDOG: u32 = 0x27;

/// A number of a register's type: 0 to 2 are integers of 8, 16 and 32 bits that count `steps`, 3 is a float.
fn number(kind: u8, bytes: &mut &[u8], steps: [f64; 3]) -> Option<f64> {
    let len = [1, 2, 4, 4][usize::from(kind)];
    let (own, rest) = bytes.split_at_checked(len)?;
    *bytes = rest;
    Some(match kind {
        0 => match own[0].cast_signed() {
            i8::MIN => f64::NAN,
            count => f64::from(count) * steps[0],
        },
        1 => f64::from(i16::from_le_bytes(own.try_into().ok()?)) * steps[1],
        2 => f64::from(i32::from_le_bytes(own.try_into().ok()?)) * steps[2],
        _ => f32::from_le_bytes(own.try_into().ok()?).into(),
    })
}

/// What one step of an integer is, of a register that is written here.
fn steps(register: u32) -> [f64; 3] {
    match register {
        FEEDFORWARD => [0.5, 0.01, 0.001],
        WATCHDOG => [0.01, 0.001, 1e-6],
        0x23 | 0x24 | 0x2b => [1.0 / 127.0, 1.0 / 32767.0, 1.0 / 2147483647.0],
        _ => [1.0; 3],
    }
}

fn varuint(bytes: &mut &[u8]) -> Option<u32> {
    let (first, rest) = bytes.split_first()?;
    *bytes = rest;
    // None here is above 127.
    (*first < 0x80).then_some(u32::from(*first))
}

/// What motor `joint` answers to a frame: it writes first, then reads. None to a frame that asks for nothing.
fn answer(world: &mut World, console: &mut String, joint: usize, mut bytes: &[u8]) -> Option<Vec<u8>> {
    let (mut mode, mut torque_nm, mut watchdog_s, mut gains) = (None, 0.0, 0.1, [1.0; 3]);
    let (mut reads, mut polled) = (Vec::new(), false);
    while let Some((kind, rest)) = bytes.split_first() {
        bytes = rest;
        let number_of = |bytes: &mut &[u8]| match kind & 3 {
            0 => varuint(bytes),
            count => Some(count.into()),
        };
        match kind {
            0x00..=0x0f => {
                let (count, first) = (number_of(&mut bytes)?, varuint(&mut bytes)?);
                for register in first..first + count {
                    let value = number(kind >> 2 & 3, &mut bytes, steps(register))?;
                    match register {
                        0 => mode = Some(value as u8),
                        FEEDFORWARD => torque_nm = value,
                        WATCHDOG => watchdog_s = value,
                        _ => {
                            if let Some(which) = GAINS.iter().position(|gain| *gain == register) {
                                gains[which] = value;
                            }
                        }
                    }
                }
            }
            0x10..=0x1f => {
                let (count, first) = (number_of(&mut bytes)?, varuint(&mut bytes)?);
                reads.extend((first..first + count).map(|register| (kind >> 2 & 3, register)));
            }
            // The console: a line to it, and what it has said.
            0x40 => {
                let (_, len) = (varuint(&mut bytes)?, varuint(&mut bytes)? as usize);
                let line = std::str::from_utf8(bytes.get(..len)?).ok()?;
                let holds = world.fault == Fault::Holds;
                match line.trim() {
                    "conf get servo.timeout_mode" => console.push_str(if holds { "10\r\n" } else { "12\r\n" }),
                    "tel stop" => {
                        world.streams = false;
                        console.push_str("OK\r\n");
                    }
                    _ => console.push_str("ERR unknown command\r\n"),
                }
                bytes = &bytes[len..];
            }
            0x42 => {
                varuint(&mut bytes)?;
                varuint(&mut bytes)?;
                polled = true;
            }
            0x50 => {}
            _ => return None,
        }
    }
    let now = world.motors[joint].mode;
    match mode {
        Some(STOPPED) => world.off(joint, STOPPED),
        // A fault and a timeout stay until it is told to stop.
        Some(POSITION) if now != TIMEOUT && now != FAULT => {
            world.pulled |= gains != [0.0; 3] || watchdog_s.is_nan() || watchdog_s <= 0.0;
            let until_s = world.hand.time_s() + watchdog_s;
            world.ask(joint, POSITION, torque_nm, until_s);
        }
        _ => {}
    }
    if joint == 0 && matches!(world.fault, Fault::TooWarm | Fault::OverVoltage) && mode != Some(STOPPED) {
        world.off(joint, FAULT);
    }
    if polled {
        if world.streams {
            console.push_str("emit servo_stats\r\n");
        }
        let some = console.len().min(48);
        let text: String = console.drain(..some).collect();
        return Some([&[0x41, 1, text.len() as u8], text.as_bytes()].concat());
    }
    let told = world.told(joint);
    let either = |is_so: bool, then: f64, otherwise: f64| if is_so { then } else { otherwise };
    let mut reply = Vec::new();
    for (kind, register) in &reads {
        let value = match register {
            0 => f64::from(world.motors[joint].mode),
            1 => told[0] / std::f64::consts::TAU,
            2 => told[1] / std::f64::consts::TAU,
            3 => world.motors[joint].torque_nm,
            0x0c => either(world.fault == Fault::Relative, 0.0, 2.0),
            // In steps of half a volt.
            0x0d => 2.0 * either(world.fault == Fault::OverVoltage && joint == 0, 57.0, 24.0),
            0x0e => either(world.fault == Fault::TooWarm && joint == 0, 79.0, 31.0),
            0x0f if world.motors[joint].mode == FAULT => either(world.fault == Fault::TooWarm, 38.0, 34.0),
            _ => 0.0,
        };
        reply.extend([0x20 | kind << 2 | 1, *register as u8]);
        match kind {
            0 => reply.push((value as i8).cast_unsigned()),
            3 => reply.extend((value as f32).to_le_bytes()),
            _ => return None,
        }
    }
    (!reads.is_empty()).then_some(reply)
}

/// Two motors on a bus there, with this hand.
///
/// # Errors
/// There cannot be a bus there.
pub fn start(place: &Place, hand: Hand<2>) -> std::io::Result<Emulator> {
    let protocol = Protocol { name: "moteus", flags: &[], faults: &FAULTS };
    let mut consoles = [const { String::new() }; 2];
    Emulator::start(place, protocol, World::shared([1.0, -1.0], TIMEOUT, hand), move |world, id, data| {
        let joint = ((id & 0x7f) as usize).checked_sub(1)?;
        let reply = answer(world, consoles.get_mut(joint)?, joint, data)?;
        Some(((id & 0x7f) << 8, reply))
    })
}
