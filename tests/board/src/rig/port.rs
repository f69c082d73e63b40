//! The serial port of the rig: 115200 baud, 8N1, a line each way.

use std::fs::File;
use std::io::{ErrorKind, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

use rustix::fs::OFlags;
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};

/// Baud, as the rig's image has it.
const BAUD: u32 = 115_200;

/// An open port.
#[derive(Debug)]
pub struct Port {
    file: File,
    path: PathBuf,
    heard: Vec<u8>,
}

/// The first whole line among bytes, which it leaves, without its end.
pub fn line(bytes: &mut Vec<u8>) -> Option<String> {
    let end = bytes.iter().position(|byte| *byte == b'\n')?;
    let line: Vec<u8> = bytes.drain(..=end).collect();
    Some(String::from_utf8_lossy(&line).trim_end().to_owned())
}

impl Port {
    /// Opens a port, and forgets what has come there.
    ///
    /// # Errors
    /// It is not there, or no serial port.
    pub fn open(path: &Path) -> Result<Self, String> {
        let cannot = |cause: std::io::Error| format!("cannot open the rig's serial port {}: {cause}", path.display());
        let flags = (OFlags::NONBLOCK | OFlags::NOCTTY).bits() as i32;
        let file = File::options().read(true).write(true).custom_flags(flags).open(path).map_err(cannot)?;
        let mut settings = tcgetattr(&file).map_err(|cause| cannot(cause.into()))?;
        settings.make_raw();
        settings.set_speed(BAUD).map_err(|cause| cannot(cause.into()))?;
        tcsetattr(&file, OptionalActions::Flush, &settings).map_err(|cause| cannot(cause.into()))?;
        Ok(Self { file, path: path.to_owned(), heard: Vec::new() })
    }

    fn broken(&self, cause: &std::io::Error) -> String {
        format!("the rig's serial port {}: {cause}", self.path.display())
    }

    /// Says a line.
    ///
    /// # Errors
    /// The port is gone.
    pub fn say(&mut self, line: &str) -> Result<(), String> {
        // A line is shorter than what any port takes at once.
        self.file.write_all(format!("{line}\n").as_bytes()).map_err(|cause| self.broken(&cause))
    }

    /// The next line that has come, if one has.
    ///
    /// # Errors
    /// The port is gone.
    pub fn hear(&mut self) -> Result<Option<String>, String> {
        let mut bytes = [0; 256];
        loop {
            match self.file.read(&mut bytes) {
                Ok(0) => return Err(self.broken(&ErrorKind::UnexpectedEof.into())),
                Ok(length) => self.heard.extend(&bytes[..length]),
                Err(cause) if cause.kind() == ErrorKind::WouldBlock => return Ok(line(&mut self.heard)),
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Err(cause) => return Err(self.broken(&cause)),
            }
        }
    }
}
