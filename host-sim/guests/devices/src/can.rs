//! Frames on a CAN bus, and the ways to one.
//!
//! | `at` is | the bus is |
//! |---|---|
//! | a character device, as `/dev/ttyACM0` | behind an fdcanusb, whose lines are text: `can send 8001 01000A BF` and `rcv 100 2100… E B F` |
//! | a Unix socket (SOCK_SEQPACKET) | behind whoever listens there, a message for each frame, as the kernel's `can_frame` or `canfd_frame` |
//! | a name, as `can0` | SocketCAN's interface of that name |
//!
//! No way blocks on writing: what a full adapter does not take is left out, for the next tick's frames are newer. A frame may be lost.

use std::io;
use std::time::{Duration, Instant};

use moteus_protocol::CanFdFrame;

use cohold_live::Error;

/// A bus.
pub(super) trait Bus: Send {
    /// Sends these frames, together where the bus can.
    fn send(&mut self, frames: &[CanFdFrame]) -> io::Result<()>;

    /// Adds the frames that have come; waits for the first one as long as this.
    fn receive(&mut self, wait: Duration, came: &mut Vec<CanFdFrame>) -> io::Result<()>;
}

/// A frame to this identifier, classical or with flexible data rate.
pub(super) fn frame(id: u32, payload: &[u8], fd: bool) -> CanFdFrame {
    let mut frame = CanFdFrame::new();
    frame.arbitration_id = id;
    let len = payload.len().min(frame.data.len());
    frame.data[..len].copy_from_slice(&payload[..len]);
    frame.size = len as u8;
    frame.set_fdcan(fd);
    frame.set_brs(fd);
    frame
}

/// The first of the frames that come until then of which this makes something.
pub(super) fn next<T>(
    bus: &mut dyn Bus,
    by: Instant,
    of: impl Fn(&CanFdFrame) -> Option<T>,
) -> Result<Option<T>, Error> {
    let mut came = Vec::new();
    while Instant::now() < by {
        bus.receive(by.saturating_duration_since(Instant::now()), &mut came).map_err(|cause| cause.to_string())?;
        if let Some(found) = came.drain(..).find_map(|frame| of(&frame)) {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// The bus at this place, and what it is, for people.
pub(super) fn open(at: &str) -> Result<Box<dyn Bus>, Error> {
    let failed = |cause: io::Error| Error::from(format!("{at}: {cause}"));
    #[cfg(unix)]
    if let Ok(file) = std::path::Path::new(at).metadata() {
        use std::os::unix::fs::FileTypeExt as _;
        if file.file_type().is_char_device() {
            return Ok(Box::new(unix::Fdcanusb::open(at).map_err(failed)?));
        }
        #[cfg(target_os = "linux")]
        if file.file_type().is_socket() {
            return Ok(Box::new(unix::Messages::open(at).map_err(failed)?));
        }
    }
    #[cfg(target_os = "linux")]
    if std::path::Path::new("/sys/class/net").join(at).exists() {
        return Ok(Box::new(unix::Messages::of_interface(at).map_err(failed)?));
    }
    let why = "it is no serial port, no socket and no CAN interface of this machine";
    Err(failed(io::Error::new(io::ErrorKind::NotFound, why)))
}

/// A frame as the kernel has it, with flexible data rate 72 bytes, else 16.
#[cfg(target_os = "linux")]
pub(super) mod kernel {
    use moteus_protocol::CanFdFrame;

    /// Flag of an identifier of 29 bits.
    const EXTENDED: u32 = 1 << 31;
    /// The identifiers' bits.
    const ID: u32 = (1 << 29) - 1;
    /// Largest identifier of 11 bits.
    const STANDARD: u32 = 0x7ff;
    /// Flags of a frame: its bit rate switches; it is one with flexible data rate.
    const BRS: u8 = 1;
    const FDF: u8 = 4;
    /// Bytes of both kinds, and where their data begins.
    const FD_LEN: usize = 72;
    const LEN: usize = 16;
    const DATA: usize = 8;

    /// The message of a frame.
    pub(crate) fn message(frame: &CanFdFrame) -> Vec<u8> {
        let mut frame = frame.clone();
        frame.pad_to_dlc();
        let id = frame.arbitration_id & ID;
        let flagged = if id > STANDARD { id | EXTENDED } else { id };
        let fd = frame.fdcan_enabled();
        let mut message = vec![0; if fd { FD_LEN } else { LEN }];
        message[..4].copy_from_slice(&flagged.to_ne_bytes());
        message[4] = frame.size;
        message[5] = if fd { FDF | if frame.brs_enabled() { BRS } else { 0 } } else { 0 };
        let data = frame.payload();
        message[DATA..DATA + data.len()].copy_from_slice(data);
        message
    }

    /// The frame of a message.
    pub(crate) fn frame(message: &[u8]) -> Option<CanFdFrame> {
        let id = u32::from_ne_bytes(message.get(..4)?.try_into().ok()?);
        let data = message.get(DATA..DATA + usize::from(*message.get(4)?))?;
        Some(super::frame(id & ID, data, message.len() == FD_LEN))
    }
}

#[cfg(unix)]
mod unix {
    use std::fs::File;
    use std::io::{self, ErrorKind, Read as _, Write as _};
    use std::os::fd::AsFd;
    use std::os::unix::fs::OpenOptionsExt as _;
    use std::time::Duration;

    use moteus_protocol::CanFdFrame;
    use moteus_protocol::fdcanusb::{EncodeOptions, Line, MAX_LINE_LENGTH, encode_can_send, parse_line};
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    use rustix::fs::OFlags;
    use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

    use super::Bus;

    /// Longest remainder of a line that is kept; more without its end is no fdcanusb.
    const LONGEST: usize = 4 * MAX_LINE_LENGTH;

    /// How long an adapter may take to refuse a line.
    const SETTLES: Duration = Duration::from_millis(100);

    /// Waits until there is something to read; at the end of the wait there may be nothing.
    fn wait_for(port: impl AsFd, wait: Duration) -> io::Result<()> {
        let wait = Timespec { tv_sec: wait.as_secs() as _, tv_nsec: wait.subsec_nanos().into() };
        match poll(&mut [PollFd::new(&port, PollFlags::IN)], Some(&wait)) {
            Ok(_) | Err(rustix::io::Errno::INTR) => Ok(()),
            Err(cause) => Err(cause.into()),
        }
    }

    /// An fdcanusb on a serial port.
    pub(super) struct Fdcanusb {
        port: File,
        /// What has come of a line, and what is still to go of one.
        partial: Vec<u8>,
        going: Vec<u8>,
    }

    impl Fdcanusb {
        pub(super) fn open(at: &str) -> io::Result<Self> {
            let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32;
            let port = File::options().read(true).write(true).custom_flags(flags).open(at)?;
            let mut settings = tcgetattr(&port)?;
            settings.make_raw();
            tcsetattr(&port, OptionalActions::Flush, &settings)?;
            let mut adapter = Self { port, partial: Vec::new(), going: vec![b'\n'] };
            // Another program may have left a part of a line. It ends here, and the adapter's answer to it is dropped.
            adapter.flush()?;
            let _ = adapter.receive(SETTLES, &mut Vec::new());
            adapter.partial.clear();
            Ok(adapter)
        }

        /// Writes what is still to go; whether it is all gone.
        fn flush(&mut self) -> io::Result<bool> {
            while !self.going.is_empty() {
                match self.port.write(&self.going) {
                    Ok(gone) => drop(self.going.drain(..gone)),
                    Err(cause) if cause.kind() == ErrorKind::WouldBlock => return Ok(false),
                    Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                    Err(cause) => return Err(cause),
                }
            }
            Ok(true)
        }
    }

    impl Bus for Fdcanusb {
        /// All lines in one write: one transfer over USB.
        fn send(&mut self, frames: &[CanFdFrame]) -> io::Result<()> {
            if !self.flush()? {
                return Ok(());
            }
            for frame in frames {
                let mut line = [0; MAX_LINE_LENGTH];
                let len = encode_can_send(frame, &EncodeOptions::default(), &mut line)
                    .map_err(|_| io::Error::other("a frame that has no line"))?;
                self.going.extend_from_slice(&line[..len]);
            }
            self.flush().map(drop)
        }

        fn receive(&mut self, wait: Duration, came: &mut Vec<CanFdFrame>) -> io::Result<()> {
            wait_for(&self.port, wait)?;
            let mut chunk = [0; 1024];
            loop {
                match self.port.read(&mut chunk) {
                    Ok(0) => return Err(io::Error::other("the adapter is gone")),
                    Ok(len) => self.partial.extend_from_slice(&chunk[..len]),
                    Err(cause) if cause.kind() == ErrorKind::WouldBlock => break,
                    Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                    Err(cause) => return Err(cause),
                }
            }
            while let Some(end) = self.partial.iter().position(|byte| *byte == b'\n') {
                let line: Vec<u8> = self.partial.drain(..=end).collect();
                match parse_line(&line) {
                    Line::Rcv(frame) => came.push(frame),
                    Line::Err(why) => {
                        return Err(io::Error::other(format!("the adapter says {}", String::from_utf8_lossy(why))));
                    }
                    _ => {}
                }
            }
            if self.partial.len() > LONGEST {
                return Err(io::Error::other("what comes has no lines: it is no fdcanusb"));
            }
            Ok(())
        }
    }

    /// A bus behind a socket that takes a message for each frame: SocketCAN's, or one that does as it does.
    #[cfg(target_os = "linux")]
    pub(super) struct Messages<S>(S);

    #[cfg(target_os = "linux")]
    impl Messages<std::os::fd::OwnedFd> {
        pub(super) fn open(at: &str) -> io::Result<Self> {
            use rustix::net::{AddressFamily, SocketAddrUnix, SocketFlags, SocketType, connect, socket_with};
            let socket = socket_with(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None)?;
            connect(&socket, &SocketAddrUnix::new(at)?)?;
            Ok(Self(socket))
        }
    }

    #[cfg(target_os = "linux")]
    impl Messages<socketcan::CanFdSocket> {
        pub(super) fn of_interface(at: &str) -> io::Result<Self> {
            use socketcan::Socket as _;
            socketcan::CanFdSocket::open(at).map(Self)
        }
    }

    #[cfg(target_os = "linux")]
    impl<S: AsFd + Send> Bus for Messages<S> {
        fn send(&mut self, frames: &[CanFdFrame]) -> io::Result<()> {
            use rustix::net::{SendFlags, send};
            for frame in frames {
                match send(&self.0, &super::kernel::message(frame), SendFlags::DONTWAIT | SendFlags::NOSIGNAL) {
                    Ok(_) | Err(rustix::io::Errno::AGAIN | rustix::io::Errno::NOBUFS) => {}
                    Err(cause) => return Err(cause.into()),
                }
            }
            Ok(())
        }

        fn receive(&mut self, wait: Duration, came: &mut Vec<CanFdFrame>) -> io::Result<()> {
            use rustix::net::{RecvFlags, recv};
            wait_for(&self.0, wait)?;
            let mut message = [0; 72];
            loop {
                match recv(&self.0, &mut message, RecvFlags::DONTWAIT) {
                    Ok((_, 0)) => return Err(io::Error::other("the bus is gone")),
                    Ok((_, len)) => came.extend(super::kernel::frame(&message[..len.min(message.len())])),
                    Err(rustix::io::Errno::AGAIN) => return Ok(()),
                    Err(cause) => return Err(cause.into()),
                }
            }
        }
    }
}
