//! The operator's end of a board's command port: one line of text there, one answer back, and what the board's ticks saw.
//!
//! A sealed link of its own beside the flow between the peers: the operator has number 0, the board its own (1 or 2), the key
//! is the one that all three hold. Lines and answers are reliable events, records are samples (haptic-protocol). What a
//! line may say is in firmware/src/operator.rs; the last operator to come is the one the board listens to.
//!
//! [`Session`] is sans-IO: tests drive it in virtual time. [`Operator`] puts it on a socket.

use std::collections::VecDeque;
use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::time::{Duration, Instant};

use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::lines::{LONGEST, Lines};
use haptic_protocol::link::{Config, Link, Notice, Stage};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::wire::{Datagram, MAX_DATAGRAM, Message, PeerId, Sample};

use crate::key_file;

/// The port on the board.
pub const PORT: u16 = 7702;
/// The operator's number.
const OPERATOR: PeerId = PeerId(0);
/// Both ends poll this often, µs; after twelve times as long in silence they call anew.
const PERIOD_US: u32 = 20_000;
/// How long a board may take to answer, at first and then.
const PATIENCE: Duration = Duration::from_secs(3);
/// Between two looks at the socket.
const LOOK: Duration = Duration::from_millis(2);

/// One operator and one board, whoever brings the time and the datagrams.
#[derive(Debug)]
pub struct Session {
    link: Link,
    lines: Lines,
    answers: VecDeque<String>,
    samples: Vec<Sample>,
}

impl Session {
    /// Calls board `number` (1 or 2). `entropy` must never be the same twice.
    ///
    /// # Errors
    /// A key or number that is refused, in one line.
    pub fn new(key: Key, number: u8, entropy: [u8; Key::LEN]) -> Result<Self, String> {
        let mut parameters = Parameters::new();
        // What the lines mean; a board that means something else is refused by name.
        parameters.add(Table::new("operator").number("version", 1.0)).map_err(|error| error.to_string())?;
        let ends = Ends { local: OPERATOR, remote: PeerId(number) };
        let link = Link::new(Config { key, ends, packet_period_us: PERIOD_US, parameters, entropy })
            .map_err(|error| error.to_string())?;
        Ok(Self { link, lines: Lines::default(), answers: VecDeque::new(), samples: Vec::new() })
    }

    /// Takes a datagram, which is opened in place; one that is not the board's is not taken.
    pub fn receive(&mut self, now_us: u64, datagram: &mut [u8]) {
        let taken = self.link.receive(now_us, datagram);
        while let Some(notice) = self.link.take_notice() {
            if matches!(notice, Notice::NewPeer { .. }) && !self.lines.is_saying() {
                self.lines.forget();
            }
        }
        if let Ok(Some(Message::Sample(sample))) = taken {
            self.samples.push(sample);
        }
        while let Some(line) = self.lines.hear(&mut self.link) {
            self.answers.push_back(line.as_str().to_owned());
        }
    }

    /// The next datagram to send, if any; call until there is none, at least every 20 ms.
    pub fn poll(&mut self, now_us: u64, out: &mut Datagram) -> Option<usize> {
        self.lines.push(&mut self.link);
        self.link.poll(now_us, out)
    }

    /// Begins to say a line; false while another one is on its way.
    pub fn say(&mut self, line: &str) -> bool {
        self.lines.say(line)
    }

    /// The next answer.
    pub fn answer(&mut self) -> Option<String> {
        self.answers.pop_front()
    }

    /// What the board's ticks saw since the last time; lost if it was lost.
    pub fn take_samples(&mut self) -> Vec<Sample> {
        std::mem::take(&mut self.samples)
    }

    /// Whether the board has answered under the key.
    pub fn is_there(&self) -> bool {
        !matches!(self.link.stage(), Stage::Calling | Stage::Joining | Stage::Refused)
    }

    /// Whether the board takes lines to mean something else.
    pub fn is_refused(&self) -> bool {
        self.link.stage() == Stage::Refused
    }
}

/// A board that listens.
#[derive(Debug)]
pub struct Operator {
    socket: UdpSocket,
    board: SocketAddr,
    start: Instant,
    number: u8,
    session: Session,
}

impl Operator {
    /// Gets in touch with the board at `board`, whichever it is, under the key of `key_file`.
    ///
    /// # Errors
    /// No socket, no key, or nobody there who holds it: in one line.
    pub fn connect(board: SocketAddr, key_file: &Path) -> Result<Self, String> {
        let key = key_file::read(key_file)?;
        let any = if board.is_ipv4() { "0.0.0.0:0" } else { "[::]:0" };
        let socket = UdpSocket::bind(any).map_err(|cause| format!("no socket: {cause}"))?;
        // Connected, so that only the board's datagrams come in.
        socket.connect(board).map_err(|cause| format!("cannot reach {board}: {cause}"))?;
        socket.set_read_timeout(Some(LOOK)).map_err(|cause| format!("cannot wait on the socket: {cause}"))?;
        let call = |number| -> Result<Self, String> {
            let session = Session::new(key.clone(), number, key_file::entropy()?)?;
            let socket = socket.try_clone().map_err(|cause| format!("no socket: {cause}"))?;
            Ok(Self { socket, board, start: Instant::now(), number, session })
        };
        // Either board may be there: both are called, and the one that is there answers.
        let mut called = [call(1)?, call(2)?];
        while called[0].start.elapsed() < PATIENCE {
            let mut came = [0; 2048];
            let length = socket.recv(&mut came).unwrap_or(0);
            for operator in &mut called {
                let mut datagram = came;
                operator.take(&mut datagram[..length]);
                if operator.session.is_refused() {
                    return Err(format!("the board at {board} takes other commands than this program: update one"));
                }
            }
            if let Some(there) = called.iter().position(|operator| operator.session.is_there()) {
                let [one, two] = called;
                return Ok(if there == 0 { one } else { two });
            }
        }
        Err(format!("nobody answers at {board}, or nobody who holds the key of {}", key_file.display()))
    }

    /// Which board it is, 1 or 2.
    pub fn number(&self) -> u8 {
        self.number
    }

    /// Says a line and gives the answer, which begins with `ok` or `error`.
    ///
    /// # Errors
    /// A line that is too long, or no answer: in one line.
    pub fn ask(&mut self, line: &str) -> Result<String, String> {
        if line.len() > LONGEST {
            return Err(format!("a line of {} bytes is not allowed: it must be at most {LONGEST}", line.len()));
        }
        if !self.session.say(line) {
            return Err(format!("{} has not taken the line before", self.board));
        }
        let asked = Instant::now();
        while asked.elapsed() < PATIENCE {
            self.turn();
            if let Some(answer) = self.session.answer() {
                return Ok(answer);
            }
        }
        Err(format!("no answer from {} to {line:?}", self.board))
    }

    /// Has every `every`-th tick sent for so long, and gives what came. A board that was away, or has started anew, has forgotten
    /// it: it is told again as soon as it is back. If it then refuses, that ends it: what came is given with the refusal.
    ///
    /// # Errors
    /// A board that refuses or does not answer at the beginning: in one line.
    pub fn record(&mut self, every: u32, time: Duration) -> Result<(Vec<Sample>, Option<String>), String> {
        let line = format!("stream {every}");
        let answer = self.ask(&line)?;
        if !answer.starts_with("ok") {
            return Err(format!("board {}: {line}: {answer}", self.number));
        }
        let (start, mut told, mut answered) = (Instant::now(), true, true);
        // An answer that is still on its way would be taken for the next line's.
        while start.elapsed() < time || told && !answered && start.elapsed() < time + PATIENCE {
            self.turn();
            if !self.session.is_there() {
                told = false;
            } else if !told {
                told = self.session.say(&line);
                answered = false;
            }
            if let Some(answer) = self.session.answer() {
                answered = true;
                if !answer.starts_with("ok") {
                    let refusal = format!("board {}: {line}: {answer}", self.number);
                    return Ok((self.session.take_samples(), Some(refusal)));
                }
            }
        }
        Ok((self.session.take_samples(), None))
    }

    /// Listens for so long, and gives the samples that came since the last time.
    pub fn samples(&mut self, time: Duration) -> Vec<Sample> {
        let until = Instant::now() + time;
        while Instant::now() < until {
            self.turn();
        }
        self.session.take_samples()
    }

    /// Takes what comes, for up to [`LOOK`], and says what is to be said.
    fn turn(&mut self) {
        let mut came = [0; 2048];
        let length = self.socket.recv(&mut came).unwrap_or(0);
        self.take(&mut came[..length]);
    }

    fn take(&mut self, came: &mut [u8]) {
        let now_us = self.start.elapsed().as_micros() as u64;
        if !came.is_empty() {
            self.session.receive(now_us, came);
        }
        let mut out = [0; MAX_DATAGRAM];
        while let Some(length) = self.session.poll(now_us, &mut out) {
            // A port that nobody listens on is no reason to stop calling: the board may be starting.
            let _ = self.socket.send(&out[..length]);
        }
    }
}
