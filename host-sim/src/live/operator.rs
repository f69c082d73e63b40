//! The operator's end of a board's command port: one line of text there, one answer back.
//!
//! What the lines are is the board's business (firmware/src/operator.rs).

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::time::{Duration, Instant};

use super::key_file;

/// How long an answer may take.
const PATIENCE: Duration = Duration::from_secs(3);

/// A board that listens.
#[derive(Debug)]
pub struct Operator {
    socket: UdpSocket,
    board: SocketAddr,
}

impl Operator {
    /// Gets in touch with the board at `board`, under the key of `key_file`.
    ///
    /// # Errors
    /// No socket, no key, or nobody there: in one line.
    pub fn connect(board: SocketAddr, key_file: &Path) -> Result<Self, String> {
        key_file::read(key_file)?;
        let any = if board.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
        let socket = UdpSocket::bind(any).map_err(|cause| format!("no socket: {cause}"))?;
        let mut operator = Self { socket, board };
        operator.ask("status")?;
        Ok(operator)
    }

    /// Says a line and gives the answer, which begins with `ok` or `error`.
    ///
    /// # Errors
    /// No answer, in one line.
    pub fn ask(&mut self, line: &str) -> Result<String, String> {
        let failed = |cause: std::io::Error| format!("cannot talk to {}: {cause}", self.board);
        self.socket.send_to(line.as_bytes(), self.board).map_err(failed)?;
        let start = Instant::now();
        let mut bytes = [0; 2048];
        loop {
            let left = PATIENCE.checked_sub(start.elapsed()).filter(|left| !left.is_zero());
            let Some(left) = left else { return Err(format!("no answer from {} to {line:?}", self.board)) };
            self.socket.set_read_timeout(Some(left)).map_err(failed)?;
            if let Ok((length, from)) = self.socket.recv_from(&mut bytes)
                && from == self.board
            {
                return Ok(String::from_utf8_lossy(&bytes[..length]).into_owned());
            }
        }
    }
}
