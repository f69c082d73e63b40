//! Two emulated moteus motors behind an fdcanusb on a pseudo-terminal, or on a socket that carries a bus's frames: the public register map as far
//! as a torque loop needs it, read here by itself, byte for byte.

use std::fs::File;
use std::io::{BufRead, BufReader, Write};
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use rustix::net::{
    AddressFamily, RecvFlags, SendFlags, SocketAddrUnix, SocketFlags, SocketType, accept_with, bind, listen, recv,
    send, socket_with,
};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use super::motors::{Fault, World, locked};

/// The second motor turns against its joint.
pub(crate) const MOTORS: &str = "1,-2";
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
                if line.trim() == "conf get servo.timeout_mode" {
                    *console = format!("{}\r\n", if holds { 10 } else { 12 });
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
        let text = std::mem::take(console);
        return Some([&[0x41, 1, text.len() as u8], text.as_bytes()].concat());
    }
    let told = world.told(joint);
    let mut reply = Vec::new();
    for (kind, register) in &reads {
        let value = match register {
            0 => f64::from(world.motors[joint].mode),
            1 => told[0] / std::f64::consts::TAU,
            2 => told[1] / std::f64::consts::TAU,
            3 => world.motors[joint].torque_nm,
            0x0c => {
                if world.fault == Fault::Relative {
                    0.0
                } else {
                    2.0
                }
            }
            // In steps of half a volt.
            0x0d => 2.0 * if world.fault == Fault::OverVoltage && joint == 0 { 57.0 } else { 24.0 },
            0x0e => {
                if world.fault == Fault::TooWarm && joint == 0 {
                    79.0
                } else {
                    31.0
                }
            }
            0x0f if world.motors[joint].mode == FAULT => {
                if world.fault == Fault::TooWarm {
                    38.0
                } else {
                    34.0
                }
            }
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

/// An adapter with two motors, until the test ends.
pub(crate) struct Emulator {
    /// What `--device` opens.
    pub(crate) at: PathBuf,
    world: Arc<Mutex<World>>,
}

impl Emulator {
    /// Behind an fdcanusb.
    pub(crate) fn serial(tremor_m: f64) -> Self {
        let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).expect("a pseudo-terminal");
        grantpt(&master).and_then(|()| unlockpt(&master)).expect("its other end");
        let name = ptsname(&master, Vec::new()).expect("its name").into_string().expect("a path");
        // Held open, so that the adapter outlives its clients.
        let held = File::options().read(true).write(true).open(&name).expect("its other end");
        let mut raw = rustix::termios::tcgetattr(&held).expect("its settings");
        raw.make_raw();
        rustix::termios::tcsetattr(&held, rustix::termios::OptionalActions::Now, &raw).expect("its settings");
        let world = World::shared([1.0, -1.0], TIMEOUT, tremor_m);
        let served = world.clone();
        std::thread::spawn(move || serve_lines(File::from(master), held, &served));
        Self { at: name.into(), world }
    }

    /// On a bus whose frames a socket carries as SocketCAN's does.
    pub(crate) fn messages(name: &str, tremor_m: f64) -> Self {
        let world = World::shared([1.0, -1.0], TIMEOUT, tremor_m);
        let served = world.clone();
        let mut consoles = [const { String::new() }; 2];
        let at = carry(name, world.clone(), move |id, data| {
            let joint = (id & 0x7f) as usize;
            let mut world = locked(&served);
            world.advance();
            let reply = answer(&mut world, consoles.get_mut(joint.checked_sub(1)?)?, joint - 1, data)?;
            Some(((id & 0x7f) << 8, reply))
        });
        Self { at, world }
    }

    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        locked(&self.world)
    }
}

fn serve_lines(mut port: File, held: File, world: &Mutex<World>) {
    let mut consoles = [const { String::new() }; 2];
    for line in BufReader::new(port.try_clone().expect("the port")).split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line).into_owned();
        let mut words = line.strip_prefix("can send ").unwrap_or_default().split(' ');
        let (Some(id), Some(hex)) = (words.next(), words.next()) else { continue };
        let Ok(id) = u32::from_str_radix(id, 16) else { continue };
        let bytes: Vec<u8> =
            (0..hex.len() / 2).filter_map(|at| u8::from_str_radix(&hex[2 * at..2 * at + 2], 16).ok()).collect();
        let joint = (id & 0x7f) as usize;
        let reply = {
            let mut world = locked(world);
            world.advance();
            match (world.fault, joint.checked_sub(1)) {
                (Fault::Silent, _) | (_, None) => None,
                (Fault::Unplugged, _) => break,
                (_, Some(at)) => consoles.get_mut(at).and_then(|console| answer(&mut world, console, at, &bytes)),
            }
        };
        if locked(world).fault == Fault::Late {
            std::thread::sleep(Duration::from_millis(100));
        }
        let hex: String = reply.iter().flatten().map(|byte| format!("{byte:02X}")).collect();
        let answered =
            if reply.is_some() { format!("OK\r\nrcv {:x} {hex} E B F\r\n", joint << 8) } else { "OK\r\n".to_owned() };
        let _ = port.write_all(answered.as_bytes());
    }
    // Both ends go: who has it open reads its end.
    drop((port, held));
}

/// Listens at a socket of this name in a folder of this test program's own, and answers the frames of one client after another.
pub(crate) fn carry(
    name: &str,
    world: Arc<Mutex<World>>,
    mut answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> PathBuf {
    let at = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("{name}-{}.can", std::process::id()));
    let _ = std::fs::remove_file(&at);
    let listener =
        socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None).expect("a socket");
    bind(&listener, &SocketAddrUnix::new(&at).expect("a short name"))
        .and_then(|()| listen(&listener, 4))
        .expect("it listens");
    std::thread::spawn(move || {
        while let Ok(client) = accept_with(&listener, SocketFlags::CLOEXEC) {
            serve_messages(&client, &world, &mut answers);
        }
    });
    at
}

fn serve_messages(
    client: &OwnedFd,
    world: &Mutex<World>,
    answers: &mut impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)>,
) {
    let mut message = [0; 72];
    while let Ok((_, len)) = recv(client, &mut message, RecvFlags::empty()) {
        let fault = locked(world).fault;
        if len == 0 || fault == Fault::Unplugged {
            return;
        }
        let id = u32::from_ne_bytes([message[0], message[1], message[2], message[3]]);
        let reply = answers(id & 0x1fff_ffff, &message[8..8 + usize::from(message[4])]);
        if fault == Fault::Late {
            std::thread::sleep(Duration::from_millis(100));
        }
        let Some((to, data)) = reply.filter(|_| fault != Fault::Silent) else { continue };
        let mut answer = [0; 72];
        answer[..4].copy_from_slice(&(to | if to > 0x7ff { 1 << 31 } else { 0 }).to_ne_bytes());
        answer[4] = data.len() as u8;
        answer[8..8 + data.len()].copy_from_slice(&data);
        // As long as the question's: of both kinds there is one length.
        let _ = send(client, &answer[..len], SendFlags::NOSIGNAL);
    }
}
