//! The operator's end of a board's command port on a socket: one line of text there, one answer back, and what the ticks saw.

use std::time::{Duration, Instant};
use std::{net::SocketAddr, path::Path};

use cohold_board_tools::calibrate::board::{Board, Tick};
use cohold_board_tools::operator::{Reins, Session, UNCONFIRMED, is_start};
use cohold_protocol::key::Role;
use cohold_protocol::lease::{AtOperator, Word};
use cohold_protocol::lines::LONGEST;
use cohold_protocol::wire::{MAX_DATAGRAM, Sample};
use cohold_sim::engine::{Actor, Out};

use super::addresses::any_towards;
use super::endpoint::{Endpoint, Live, Stop, Ticker};
use crate::{Error, key_file};

/// How long a board may take to answer, at first and then.
const PATIENCE: Duration = Duration::from_secs(3);
/// Between two looks at what has come.
const LOOK: Duration = Duration::from_millis(2);

/// Sessions that wait for something to be `done`, for so long at the most.
struct Waiting<'a, F> {
    sessions: &'a mut [Session],
    board: SocketAddr,
    done: F,
    over: bool,
}

impl<F: FnMut(&mut [Session]) -> bool> Actor<SocketAddr> for Waiting<'_, F> {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: SocketAddr, datagram: &mut [u8], out: &mut Out<'_, SocketAddr, [u8]>) {
        if from == self.board {
            for session in &mut *self.sessions {
                session.receive(now_ns / 1_000, &mut datagram.to_vec());
            }
            self.speak(now_ns, out);
        }
    }

    fn speak(&mut self, now_ns: u64, out: &mut Out<'_, SocketAddr, [u8]>) {
        let mut bytes = [0; MAX_DATAGRAM];
        for session in &mut *self.sessions {
            while let Some(length) = session.poll(now_ns / 1_000, &mut bytes) {
                // A port that nobody listens on is no reason to stop calling: the board may be starting.
                out(self.board, &bytes[..length]);
            }
        }
    }

    fn act(&mut self, _: u64, _: &mut Out<'_, SocketAddr, [u8]>) {
        self.over = (self.done)(self.sessions);
    }
}

impl<F: FnMut(&mut [Session]) -> bool> Live for Waiting<'_, F> {
    fn end(&mut self) -> Option<Result<(), Error>> {
        self.over.then_some(Ok(()))
    }

    fn waited(&mut self, waited: Duration) {
        self.sessions.iter_mut().for_each(|session| session.waited(waited.as_micros() as u64));
    }
}

/// Waits on an endpoint until something is `done`, for so long at the most.
fn wait(
    endpoint: &Endpoint,
    board: SocketAddr,
    sessions: &mut [Session],
    time: Duration,
    done: impl FnMut(&mut [Session]) -> bool,
) -> Result<(), Error> {
    let mut waiting = Waiting { sessions, board, done, over: false };
    endpoint.run(Ticker::new(LOOK).lasting(time.as_secs_f64()), f64::MAX, &Stop::default(), &mut waiting).map(|_| ())
}

/// A board that listens. It is sent goodbye when this is dropped.
#[derive(Debug)]
pub struct Operator {
    endpoint: Endpoint,
    board: SocketAddr,
    /// Number of the board, 1 or 2.
    pub number: u8,
    session: Session,
    stop: Stop,
}

impl Operator {
    /// Gets in touch with the board at `board`, whichever it is, under the operator's key of `key_file`.
    ///
    /// # Errors
    /// The key file cannot be read, or the board does not answer.
    pub fn connect(board: SocketAddr, key_file: &Path) -> Result<Self, Error> {
        let key = key_file::read(key_file, Role::Operator)?;
        let endpoint = Endpoint::answering(any_towards(board))?;
        // Either board may be there: both are called, and the one that is there answers.
        let [one, two] = [1, 2].map(|number| Session::new(key.clone(), number, key_file::entropy()?));
        let mut called = [one?, two?];
        let answered = |session: &Session| session.is_there() || session.is_refused();
        wait(&endpoint, board, &mut called, PATIENCE, |called| called.iter().any(answered))?;
        cohold_sim::refuse_if!(
            called.iter().any(Session::is_refused),
            "the board at {board} takes other commands than this program: update one"
        );
        let there = (1..).zip(called).find(|(_, session)| session.is_there());
        let (number, session) = there.ok_or_else(|| {
            format!("nobody answers at {board}, or nobody who holds the key of {}", key_file.display())
        })?;
        Ok(Self { endpoint, board, number, session, stop: Stop::default() })
    }

    /// This operator, whose recording and listening end when `stop` is asked for.
    pub fn until(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    fn wait(&mut self, time: Duration, mut done: impl FnMut(&mut Session) -> bool) -> Result<(), Error> {
        let session = std::slice::from_mut(&mut self.session);
        wait(&self.endpoint, self.board, session, time, |sessions| sessions.iter_mut().any(&mut done))
    }

    /// The operator's side of the lease, for whoever starts and stops: it holds from the next 2 ms on, whatever else this operator does.
    pub fn reins(&self) -> Reins {
        self.session.reins().clone()
    }

    /// Stops all motors of the board, and waits until the board says that they are off.
    ///
    /// # Errors
    /// The board did not say it in time, or the socket failed; and what to do then.
    pub fn stop(&mut self) -> Result<(), Error> {
        let reins = self.reins();
        reins.note(self.now_us(), AtOperator::Stop);
        let waited = self.wait(PATIENCE, |_| reins.giver().is_stopped());
        if reins.giver().is_stopped() {
            return Ok(());
        }
        Err(waited.map_or_else(|why| format!("{why}; {UNCONFIRMED}"), |()| UNCONFIRMED.to_owned()).into())
    }

    /// Says a line and gives the answer, which begins with `ok` or `error`. A line that turns motors on lets them run. `disarm` is
    /// [`Operator::stop`].
    ///
    /// # Errors
    /// The board fell silent, or the socket failed.
    pub fn ask(&mut self, line: &str) -> Result<String, Error> {
        self.ask_under(line, None)
    }

    /// [`Operator::ask`] of a line under the word of a run that has begun, if it has: the board refuses it if that was stopped meanwhile.
    ///
    /// # Errors
    /// As of [`Operator::ask`].
    pub fn ask_under(&mut self, line: &str, run: Option<Word>) -> Result<String, Error> {
        if line.split_whitespace().next() == Some("disarm") {
            self.stop()?;
            return Ok("ok disarmed".to_owned());
        }
        if line.len() > LONGEST {
            let allowed = format!("it must be at most {LONGEST}");
            return Err(cohold_sim::Error::not_allowed(format!("a line of {} bytes", line.len()), allowed).into());
        }
        let said = match run {
            None => self.session.say(line),
            Some(run) => self.session.say_under(line, run),
        };
        cohold_sim::refuse_if!(!said, "{} has not taken the line before", self.board);
        let mut answer = None;
        self.wait(PATIENCE, |session| {
            answer = session.answer();
            answer.is_some()
        })?;
        if answer.is_none() {
            self.session.unsay();
        }
        if is_start(line) && !answer.as_ref().is_some_and(|answer| answer.starts_with("ok")) {
            // It may have started all the same: it does not go on.
            self.reins().note(self.now_us(), AtOperator::Leave);
        }
        // Motors that were to run alone may be on.
        let then = if is_start(line) { format!("; {UNCONFIRMED}") } else { String::new() };
        answer.ok_or_else(|| format!("no answer from {} to {line:?}{then}", self.board).into())
    }

    fn now_us(&self) -> u64 {
        self.endpoint.now_ns() / 1_000
    }

    /// When its clock began.
    pub fn start(&self) -> Instant {
        self.endpoint.start()
    }

    /// Says a line that has samples sent, for so long, and gives what came, with why the board refused to go on if it did.
    ///
    /// # Errors
    /// The board fell silent, or the socket failed.
    pub fn record(&mut self, line: &str, time: Duration) -> Result<(Vec<Sample>, Option<String>), Error> {
        let mut samples = Vec::new();
        let refusal = self.record_each(line, time, |_, session| {
            let before = samples.len();
            samples.extend(session.take_samples());
            samples.len() > before
        })?;
        Ok((samples, refusal))
    }

    /// Says a line that has samples sent, for so long; `each` takes what came, ns after the clock began, and says whether anything did. A board that
    /// was away, or has started anew, has forgotten a `stream`: it is sent again as soon as it is back. If it then refuses, that ends it. Any
    /// other line ends when no more has come for a while.
    pub fn record_each(
        &mut self,
        line: &str,
        time: Duration,
        mut each: impl FnMut(u64, &mut Session) -> bool,
    ) -> Result<Option<String>, Error> {
        /// With nothing that comes.
        const SILENCE: Duration = Duration::from_millis(500);
        let is_endless = line.starts_with("stream");
        let answer = self.ask(line)?;
        let refusal_of = |number: u8, answer: &str| format!("board {number}: {line}: {answer}");
        if !answer.starts_with("ok") {
            return Err(refusal_of(self.number, &answer).into());
        }
        let (start, mut said, mut answered, mut refusal) = (Instant::now(), true, true, None);
        let mut newest = None;
        let (number, stop, begun) = (self.number, self.stop.clone(), self.endpoint.start());
        self.wait(time + PATIENCE, |session| {
            if each(begun.elapsed().as_nanos() as u64, session) {
                newest = Some(Instant::now());
            }
            if !session.is_there() {
                said = false;
            } else if !said && is_endless {
                said = session.say(line);
                answered = false;
            }
            if let Some(answer) = session.answer() {
                answered = true;
                refusal = (!answer.starts_with("ok")).then(|| refusal_of(number, &answer));
            }
            // An answer that is still on its way would be taken for the next line's.
            let all_came = !is_endless && newest.is_some_and(|newest| newest.elapsed() >= SILENCE);
            let over = stop.is_asked() || start.elapsed() >= time || all_came;
            refusal.is_some() || over && (answered || !said)
        })?;
        Ok(refusal)
    }

    /// Listens for so long, and gives the samples that came since the last time.
    ///
    /// # Errors
    /// The socket failed.
    pub fn samples(&mut self, time: Duration) -> Result<Vec<Sample>, Error> {
        let stop = self.stop.clone();
        self.wait(time, |_| stop.is_asked())?;
        Ok(self.session.take_samples())
    }
}

impl Drop for Operator {
    fn drop(&mut self) {
        let mut out = [0; MAX_DATAGRAM];
        if let Some(length) = self.session.goodbye(self.now_us(), &mut out) {
            self.endpoint.send(self.board, &out[..length]);
        }
    }
}

impl Board for Operator {
    fn ask(&mut self, line: &str) -> Result<String, cohold_board_tools::Error> {
        Ok(Self::ask(self, line).map_err(Box::from)?)
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, cohold_board_tools::Error> {
        let samples = self.samples(Duration::from_secs_f64(seconds)).map_err(Box::from)?;
        Ok(samples.iter().filter_map(|sample| Tick::from_record(sample.payload())).collect())
    }
}

#[cfg(all(test, unix))]
#[path = "../tests/inside/operator.rs"]
mod tests;
