//! The ways to a bus, from its motors' end: what comes is handed over frame by frame, and what is answered goes back.
//!
//! | place | the bus is |
//! |---|---|
//! | [`Place::Serial`] | behind an fdcanusb on a pseudo-terminal, whose lines are text: `can send 8001 01000A` and `rcv 100 2100… E B F` |
//! | [`Place::Socket`] | a Unix socket (SOCK_SEQPACKET) that takes and gives the kernel's frames, one a message; one client after another |
//! | [`Place::Interface`] | a CAN interface of this machine, real or virtual (`vcan`) |

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, ErrorKind, Write as _};
use std::os::fd::AsFd;
use std::os::unix::fs::{FileTypeExt as _, symlink};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rustix::net::{
    AddressFamily, RecvFlags, SendFlags, SocketAddrUnix, SocketFlags, SocketType, accept_with, bind, connect, listen,
    recv, send, socket_with,
};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

use super::motors::{Fault, World, locked};

/// How late a late answer is.
const LATE: Duration = Duration::from_millis(100);
/// Flag of an identifier of 29 bits, and the identifiers' bits.
const EXTENDED: u32 = 1 << 31;
const ID: u32 = (1 << 29) - 1;
/// Largest identifier of 11 bits.
const STANDARD: u32 = 0x7ff;
/// Bytes of a frame with flexible data rate, and where the data of either kind begins.
const FD_LEN: usize = 72;
const DATA: usize = 8;

/// Where a bus is to be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Place {
    /// A pseudo-terminal, and a link to it if it is to be found by a name.
    Serial(Option<PathBuf>),
    /// A socket there.
    Socket(PathBuf),
    /// The interface of that name.
    Interface(String),
}

/// A bus that is served, and what is taken away when it is dropped.
pub(crate) struct Served {
    /// What a client opens.
    pub(crate) at: PathBuf,
    made: Option<PathBuf>,
}

impl Drop for Served {
    fn drop(&mut self) {
        if let Some(made) = &self.made {
            let _ = std::fs::remove_file(made);
        }
    }
}

/// Serves a bus there, in a thread of its own: what motors answer to a frame, if they do.
pub(crate) fn carry(
    place: &Place,
    world: Arc<Mutex<World>>,
    answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    match place {
        Place::Serial(link) => serial(link.as_deref(), world, answers),
        Place::Socket(at) => socket(at, world, answers),
        Place::Interface(name) => interface(name, world, answers),
    }
}

/// Takes away what an emulator that was killed has left there; whatever else is there stays.
fn clear(at: &Path, is_left: impl FnOnce(&Path) -> bool) -> io::Result<()> {
    match at.symlink_metadata() {
        Err(cause) if cause.kind() == ErrorKind::NotFound => Ok(()),
        Err(cause) => Err(cause),
        Ok(_) if is_left(at) => std::fs::remove_file(at),
        Ok(_) => Err(io::Error::new(ErrorKind::AlreadyExists, "something is there already")),
    }
}

fn serial(
    link: Option<&Path>,
    world: Arc<Mutex<World>>,
    answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    let master = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC)?;
    grantpt(&master).and_then(|()| unlockpt(&master))?;
    let name = ptsname(&master, Vec::new())?.into_string().map_err(io::Error::other)?;
    // Held open, so that the adapter outlives its clients.
    let held = File::options().read(true).write(true).open(&name)?;
    let mut raw = rustix::termios::tcgetattr(&held)?;
    raw.make_raw();
    rustix::termios::tcsetattr(&held, rustix::termios::OptionalActions::Now, &raw)?;
    if let Some(link) = link {
        clear(link, |at| std::fs::read_link(at).is_ok_and(|to| to.starts_with("/dev/pts")))?;
        symlink(&name, link)?;
    }
    let port = File::from(master);
    let lines = BufReader::new(port.try_clone()?);
    std::thread::spawn(move || {
        serve_lines(lines, &port, &world, answers);
        // Both ends go: who has it open reads its end.
        drop((port, held));
    });
    Ok(Served { at: link.map_or_else(|| name.into(), Path::to_owned), made: link.map(Path::to_owned) })
}

/// Until the bus is gone.
fn serve_lines(
    lines: BufReader<File>,
    mut port: &File,
    world: &Mutex<World>,
    mut answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)>,
) {
    for line in lines.split(b'\n').map_while(Result::ok) {
        let line = String::from_utf8_lossy(&line).into_owned();
        let mut words = line.strip_prefix("can send ").unwrap_or_default().split(' ');
        let (Some(id), Some(hex)) = (words.next(), words.next()) else { continue };
        let Ok(id) = u32::from_str_radix(id, 16) else { continue };
        let byte = |at: usize| hex.get(2 * at..2 * at + 2).and_then(|two| u8::from_str_radix(two, 16).ok());
        let bytes: Vec<u8> = (0..hex.len() / 2).filter_map(byte).collect();
        let fault = locked(world).fault;
        let reply = match fault {
            Fault::Unplugged => return,
            Fault::Silent => None,
            _ => answers(id, &bytes),
        };
        if fault == Fault::Late {
            std::thread::sleep(LATE);
        }
        let answered = reply.map_or_else(
            || "OK\r\n".to_owned(),
            |(to, data)| {
                let hex: String = data.iter().map(|byte| format!("{byte:02X}")).collect();
                format!("OK\r\nrcv {to:x} {hex} E B F\r\n")
            },
        );
        let _ = port.write_all(answered.as_bytes());
    }
}

fn seqpacket() -> io::Result<std::os::fd::OwnedFd> {
    Ok(socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None)?)
}

fn socket(
    at: &Path,
    world: Arc<Mutex<World>>,
    mut answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    let address = SocketAddrUnix::new(at)?;
    let (listener, probe) = (seqpacket()?, seqpacket()?);
    clear(at, |at| {
        at.metadata().is_ok_and(|file| file.file_type().is_socket())
            && connect(&probe, &address) == Err(rustix::io::Errno::CONNREFUSED)
    })?;
    bind(&listener, &address).and_then(|()| listen(&listener, 4))?;
    std::thread::spawn(move || {
        while let Ok(client) = accept_with(&listener, SocketFlags::CLOEXEC) {
            serve_messages(&client, &world, &mut answers);
        }
    });
    Ok(Served { at: at.to_owned(), made: Some(at.to_owned()) })
}

#[cfg(target_os = "linux")]
fn interface(
    name: &str,
    world: Arc<Mutex<World>>,
    mut answers: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    use socketcan::Socket as _;
    let bus = socketcan::CanFdSocket::open(name)?;
    std::thread::spawn(move || {
        // Who unplugs a bus that others are on only hears and says nothing more.
        loop {
            serve_messages(&bus, &world, &mut answers);
            std::thread::sleep(LATE);
        }
    });
    Ok(Served { at: name.into(), made: None })
}

#[cfg(not(target_os = "linux"))]
fn interface(
    _: &str,
    _: Arc<Mutex<World>>,
    _: impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
) -> io::Result<Served> {
    Err(io::Error::new(ErrorKind::Unsupported, "CAN interfaces are Linux's"))
}

/// Until the client has gone, or the bus.
fn serve_messages(
    client: impl AsFd,
    world: &Mutex<World>,
    answers: &mut impl FnMut(u32, &[u8]) -> Option<(u32, Vec<u8>)>,
) {
    let mut message = [0; FD_LEN];
    while let Ok((_, len)) = recv(&client, &mut message, RecvFlags::empty()) {
        let fault = locked(world).fault;
        if len == 0 || fault == Fault::Unplugged {
            return;
        }
        let id = u32::from_ne_bytes([message[0], message[1], message[2], message[3]]);
        let Some(data) = message.get(DATA..DATA + usize::from(message[4])) else { continue };
        let reply = answers(id & ID, data);
        if fault == Fault::Late {
            std::thread::sleep(LATE);
        }
        let Some((to, data)) = reply.filter(|_| fault != Fault::Silent) else { continue };
        let mut answer = [0; FD_LEN];
        answer[..4].copy_from_slice(&(to | if to > STANDARD { EXTENDED } else { 0 }).to_ne_bytes());
        answer[4] = data.len() as u8;
        answer[DATA..DATA + data.len()].copy_from_slice(&data);
        // As long as the question's: of both kinds there is one length.
        let _ = send(&client, &answer[..len], SendFlags::NOSIGNAL);
    }
}
