//! The ways to a bus, from its motors' end: what comes is handed over frame by frame, and what is answered goes back.
//!
//! | place | the bus is |
//! |---|---|
//! | [`Place::Serial`] | behind an fdcanusb on a pseudo-terminal, whose lines are text: `can send 8001 01000A` and `rcv 100 2100… E B F` |
//! | [`Place::Socket`] | a Unix socket (SOCK_SEQPACKET) that takes and gives the kernel's frames, one a message; one client after another |
//! | [`Place::Interface`] | a CAN interface of this machine, real or virtual (`vcan`) |
//!
//! Only Linux has the last two.

use std::fs::File;
use std::io::{self, BufRead as _, BufReader, ErrorKind, Write as _};
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

#[cfg(target_os = "linux")]
use super::kernel;
use super::{locked, motors::Fault, motors::World};

/// How late a late answer is.
pub(crate) const LATE: Duration = Duration::from_millis(100);

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
    pub(crate) made: Option<PathBuf>,
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
        #[cfg(target_os = "linux")]
        Place::Socket(at) => kernel::socket(at, world, answers),
        #[cfg(target_os = "linux")]
        Place::Interface(name) => kernel::interface(name, world, answers),
        #[cfg(not(target_os = "linux"))]
        Place::Socket(_) | Place::Interface(_) => {
            Err(io::Error::new(ErrorKind::Unsupported, "a socket or a CAN interface needs Linux; use a serial port"))
        }
    }
}

/// Takes away what an emulator that was killed has left there; whatever else is there stays.
pub(crate) fn clear(at: &Path, is_left: impl FnOnce(&Path) -> bool) -> io::Result<()> {
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
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
    #[cfg(not(target_vendor = "apple"))]
    let flags = flags | OpenptFlags::CLOEXEC;
    let master = openpt(flags)?;
    // A child that inherits this end keeps clients waiting after the emulator has gone. Apple's systems set the flag in a second call:
    // a child that another thread starts in between inherits it. Writing to a pseudo-terminal raises no SIGPIPE.
    #[cfg(target_vendor = "apple")]
    rustix::io::ioctl_fioclex(&master)?;
    grantpt(&master).and_then(|()| unlockpt(&master))?;
    let name = ptsname(&master, Vec::new())?.into_string().map_err(io::Error::other)?;
    // Held open, so that the adapter outlives its clients.
    let held = File::options().read(true).write(true).open(&name)?;
    let mut raw = rustix::termios::tcgetattr(&held)?;
    raw.make_raw();
    rustix::termios::tcsetattr(&held, rustix::termios::OptionalActions::Now, &raw)?;
    if let Some(link) = link {
        let named = if cfg!(target_vendor = "apple") { "/dev/ttys" } else { "/dev/pts/" };
        clear(link, |at| std::fs::read_link(at).is_ok_and(|to| to.to_string_lossy().starts_with(named)))?;
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
        let Some(sent) = line.strip_prefix("can send ") else {
            if !line.trim().is_empty() {
                let _ = port.write_all(b"ERR unknown command\r\n");
            }
            continue;
        };
        let mut words = sent.split(' ');
        let (Some(id), Some(hex)) = (words.next(), words.next()) else { continue };
        let Ok(id) = u32::from_str_radix(id, 16) else { continue };
        let byte = |at: usize| hex.get(2 * at..2 * at + 2).and_then(|two| u8::from_str_radix(two, 16).ok());
        let bytes: Vec<u8> = (0..hex.len() / 2).filter_map(byte).collect();
        let fault = locked(world).fault;
        let reply = match fault {
            Fault::Unplugged => return,
            Fault::Silent => None,
            Fault::Flexible if words.any(|word| word == "f") => None,
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
