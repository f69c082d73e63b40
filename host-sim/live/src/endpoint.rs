//! The one loop over a UDP socket and the system's clock: under it runs every live command.
//!
//! At every tick the socket is emptied, then the actor acts. Emptying stops half a period after the tick began, so that no flood of
//! datagrams, forged or not, can hold up what is due; what is left waits for the next tick or is dropped by the system, as on any
//! full line. An endpoint that answers hears datagrams as they come instead. They come and go in batches ([`super::batch`]): what is
//! there is heard, and what was said about it is sent before the socket is looked at again. The loop ends when its time is over, when the actor
//! says so, when it misses somebody for longer than its patience, or when the process is asked to end; then the actor says goodbye.
//!
//! Ticks have absolute deadlines, so that errors do not add up: one that begins more than a period late is a miss, none is skipped.

use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};
use std::{io::ErrorKind, sync::Arc};

use cohold_sim::engine::{Actor, Out};
use serde::Serialize;
use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

use super::batch::{MOST, OutgoingBatch, ReceivedBatch};
use super::road::Road;
use crate::Error;

/// Longest that an endpoint waits for a datagram before it looks at the clock.
const LOOK: Duration = Duration::from_millis(2);
/// What a socket holds of datagrams that have come, as far as the system allows, bytes: of hundreds that come at once none is lost.
#[cfg(unix)]
const HOLDS: usize = 1 << 20;
/// What a socket may say that is about one datagram which was sent, or about a signal: what comes next may be good.
const PASSING: [ErrorKind; 6] = [
    ErrorKind::Interrupted,
    ErrorKind::ConnectionRefused,
    ErrorKind::ConnectionReset,
    ErrorKind::HostUnreachable,
    ErrorKind::NetworkUnreachable,
    ErrorKind::NetworkDown,
];

/// Whether a run is to end early.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<AtomicBool>);

impl Stop {
    /// Asked by Ctrl-C and SIGTERM: what runs ends with its report, and exit status 0 where all was well. The second of them ends the process at
    /// once, with status 2.
    ///
    /// # Errors
    /// The system does not let the program handle its signals.
    pub fn on_signals() -> Result<Self, Error> {
        let stop = Self::default();
        for signal in [SIGINT, SIGTERM] {
            flag::register_conditional_shutdown(signal, 2, stop.0.clone())
                .and_then(|_| flag::register(signal, stop.0.clone()))
                .map_err(cohold_sim::Error::cannot("listen for", &"signals"))?;
        }
        Ok(stop)
    }

    /// Asks whoever watches this to stop.
    pub fn ask(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Whether that was asked for.
    pub fn is_asked(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }
}

/// How well the ticks were kept.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Punctuality {
    /// Number of ticks that were kept.
    #[serde(rename = "beats")]
    pub ticks: u64,
    /// Ticks that began more than a period late.
    pub missed: u64,
    /// Latest a tick began, µs.
    pub worst_us: u64,
    /// The thread runs at a real-time priority.
    pub realtime_priority: bool,
}

/// Ticks of one thread.
#[derive(Debug)]
pub struct Ticker {
    start: Instant,
    period: Duration,
    /// How long there are ticks, s.
    seconds: f64,
    /// How well they were kept so far.
    pub kept: Punctuality,
}

impl Ticker {
    /// The first tick is now.
    pub fn new(period: Duration) -> Self {
        Self { start: Instant::now(), period, seconds: f64::INFINITY, kept: Punctuality::default() }
    }

    /// [`Ticker::new`] on a thread that asks for a real-time priority.
    pub fn realtime(period: Duration) -> Self {
        let kept = Punctuality { realtime_priority: realtime(), ..Punctuality::default() };
        Self { kept, ..Self::new(period) }
    }

    /// This ticker, which ends after `seconds` s.
    pub fn lasting(self, seconds: f64) -> Self {
        Self { seconds, ..self }
    }

    /// Whether there were as many ticks as its time holds; never, where it has no end.
    pub fn is_over(&self) -> bool {
        self.kept.ticks as f64 * self.period.as_secs_f64() >= self.seconds
    }

    /// When the next tick is due: for as many of them as 64 bits of nanoseconds hold, which is centuries.
    fn deadline(&self) -> Instant {
        let period_ns = u64::try_from(self.period.as_nanos()).unwrap_or(u64::MAX);
        self.start + Duration::from_nanos(period_ns.saturating_mul(self.kept.ticks))
    }

    /// Every tick from the next on comes so much later.
    pub fn postpone(&mut self, by: Duration) {
        self.start += by;
    }

    /// Sleeps until the next tick, if that is still to come; how late it begins.
    pub fn wait(&mut self) -> Duration {
        let deadline = self.deadline();
        std::thread::sleep(deadline.saturating_duration_since(Instant::now()));
        let late = Instant::now().saturating_duration_since(deadline);
        let late_us = late.as_micros() as u64;
        self.kept.ticks += 1;
        self.kept.missed += u64::from(late > self.period);
        self.kept.worst_us = self.kept.worst_us.max(late_us);
        late
    }
}

/// What a person reads whose system gives no real-time priority, and may do about it.
pub const NO_PRIORITY: &str = if cfg!(target_os = "linux") {
    "this user may have no real-time priority, so ticks come late when the machine is busy: run `sudo setcap cap_sys_nice=ep` on this program, or add `USER - rtprio 50` to /etc/security/limits.conf and log in anew (docs/guides/devices/index.md, Real-time priority)"
} else {
    "the system gives no real-time priority, so ticks come late when the machine is busy (docs/guides/devices/index.md, Real-time priority)"
};

/// Asks for a real-time priority for this thread, and says whether it got one.
pub fn realtime() -> bool {
    fifo(50)
}

/// [`realtime`], beneath the ticks: for whoever a tick depends on, and must not keep it waiting.
pub fn realtime_beneath() -> bool {
    fifo(40)
}

#[cfg(unix)]
fn fifo(priority: u8) -> bool {
    let priority = thread_priority::ThreadPriority::Crossplatform(priority.try_into().unwrap_or_default());
    thread_priority::set_thread_priority_and_policy(
        thread_priority::thread_native_id(),
        priority,
        thread_priority::ThreadSchedulePolicy::Realtime(thread_priority::RealtimeThreadSchedulePolicy::Fifo),
    )
    .is_ok()
}

/// Windows gives an ordinary process no real-time priority (16 to 31). Ticks get `TIME_CRITICAL` (15), and threads beneath them `HIGHEST` (10).
#[cfg(windows)]
fn fifo(priority: u8) -> bool {
    let priority = thread_priority::ThreadPriority::Crossplatform((priority + 49).try_into().unwrap_or_default());
    let _ = thread_priority::set_current_thread_priority(priority);
    false
}

/// Has this thread, and those that it starts, stand back behind the others by so much niceness, where each thread has one of its own.
pub fn stand_back(niceness: i32) {
    // Who is not nicer is no fault.
    #[cfg(target_os = "linux")]
    let _ = rustix::process::nice(niceness);
    #[cfg(not(target_os = "linux"))]
    let _ = niceness;
}

/// How long a run is once everybody is there, and how long to wait for that, s.
#[derive(Clone, Copy)]
pub struct Span {
    /// How long it lasts once everybody is there, s; infinite until it is stopped: what is a mean of the last half is of the whole then.
    pub duration_s: f64,
    /// Longest wait until everybody is there, s.
    pub patience_s: f64,
}

/// An actor of the engine's as an endpoint runs it. Times are ns since the endpoint was opened.
pub trait Live: Actor<SocketAddr, Packet = [u8]> {
    /// Whether it has ended, after a tick and before its time is over, and what is wrong if something is.
    fn end(&mut self) -> Option<Result<(), Error>> {
        None
    }

    /// Who or what is not there, if that is to end the run when patience does.
    fn missing(&self) -> Option<String> {
        None
    }

    /// Tells the others that this is the end.
    fn goodbye(&mut self, _now_ns: u64, _out: &mut Out<'_, SocketAddr, [u8]>) {}

    /// Takes how long the datagram that is heard next has waited in the socket, where the system says so.
    fn waited(&mut self, _waited: Duration) {}

    /// Takes note that the answers to what was heard are handed to the system.
    fn sent(&mut self, _now_ns: u64) {}
}

/// A socket and the clock that its times are read from.
#[derive(Debug)]
pub struct Endpoint {
    pub(crate) socket: UdpSocket,
    /// The address on which it listens.
    pub address: SocketAddr,
    answers: bool,
    start: Instant,
    /// What finds the path, where the other end is met somewhere.
    road: Option<Arc<dyn Road>>,
    /// Datagrams that the system did not take.
    pub unsent: AtomicU64,
}

impl Endpoint {
    /// An endpoint that takes what has come at every tick.
    ///
    /// # Errors
    /// The address cannot be opened.
    pub fn polled(listen: SocketAddr) -> Result<Self, Error> {
        Self::open(UdpSocket::bind(listen), listen, false)
    }

    /// [`Endpoint::polled`] on a road under this socket.
    ///
    /// # Errors
    /// The socket cannot be set up.
    pub fn on_road(socket: UdpSocket, road: Arc<dyn Road>) -> Result<Self, Error> {
        let endpoint = Self::open(Ok(socket), road.address(), false)?;
        Ok(Self { road: Some(road), ..endpoint })
    }

    /// The road to the other end, where it is not called at its address.
    pub fn road(&self) -> Option<Arc<dyn Road>> {
        self.road.clone()
    }

    /// An endpoint that takes each datagram as it comes.
    ///
    /// # Errors
    /// The address cannot be opened.
    pub fn answering(listen: SocketAddr) -> Result<Self, Error> {
        Self::open(UdpSocket::bind(listen), listen, true)
    }

    fn open(socket: std::io::Result<UdpSocket>, listen: SocketAddr, answers: bool) -> Result<Self, Error> {
        let failed = cohold_sim::Error::cannot::<std::io::Error>("listen on", &listen);
        let socket = socket.map_err(&failed)?;
        let waits = if answers { socket.set_read_timeout(Some(LOOK)) } else { socket.set_nonblocking(true) };
        waits.map_err(&failed)?;
        // A system that gives less is a fuller line.
        #[cfg(unix)]
        let _ = rustix::net::sockopt::set_socket_recv_buffer_size(&socket, HOLDS);
        // Without it datagrams have waited for no time.
        #[cfg(target_os = "linux")]
        let _ = nix::sys::socket::setsockopt(&socket, nix::sys::socket::sockopt::ReceiveTimestampns, &true);
        let address = socket.local_addr().map_err(&failed)?;
        let (road, unsent) = (None, AtomicU64::new(0));
        Ok(Self { socket, address, answers, start: Instant::now(), road, unsent })
    }

    /// This endpoint with a clock that began at `start`.
    pub fn since(self, start: Instant) -> Self {
        Self { start, ..self }
    }

    /// Whether datagrams can go from here to `to` at all: a socket is of one family, and nobody is his own partner.
    ///
    /// # Errors
    /// The other address is of another family, or this endpoint's own.
    pub fn reaches(&self, to: SocketAddr) -> Result<(), Error> {
        if self.road.is_some() {
            return Ok(());
        }
        let (own, family) = (self.address, |address: SocketAddr| if address.is_ipv4() { "IPv4" } else { "IPv6" });
        if own.is_ipv4() != to.is_ipv4() {
            let [ours, theirs] = [own, to].map(family);
            return Err(Error::Refused(format!(
                "{to} cannot be reached from {own}: one is {theirs} and the other {ours}; both must be the same"
            )));
        }
        let (from, at) = (own.ip(), to.ip());
        cohold_sim::refuse_if!(
            own.port() == to.port()
                && (from == at || from.is_unspecified() && (at.is_loopback() || at.is_unspecified())),
            "{to} is where this end listens itself: give it the address of the other"
        );
        Ok(())
    }

    /// When its clock began.
    pub fn start(&self) -> Instant {
        self.start
    }

    /// Time since it was opened, ns.
    pub fn now_ns(&self) -> u64 {
        self.start.elapsed().as_nanos() as u64
    }

    /// Sends a datagram; one that the system does not take now is late, and a network may lose it as well. Whether it was taken.
    pub fn send(&self, to: SocketAddr, datagram: &[u8]) -> bool {
        if let Some(road) = self.road.as_ref().filter(|road| road.address() == to) {
            return road.say(datagram, &mut |to, bytes| drop(self.socket.send_to(bytes, to)));
        }
        let sent = self.socket.send_to(datagram, to).is_ok();
        self.unsent.fetch_add(u64::from(!sent), Ordering::Relaxed);
        sent
    }

    /// Sends it with what else is said meanwhile: by [`Endpoint::flush`], or when there is enough for a batch.
    pub fn say(&self, going: &mut OutgoingBatch, to: SocketAddr, datagram: &[u8]) {
        match self.road.as_ref().filter(|road| road.address() == to) {
            Some(road) => _ = road.say(datagram, &mut |to, bytes| going.add(to, bytes)),
            None => going.add(to, datagram),
        }
        if going.is_full() {
            self.flush(going);
        }
    }

    /// Sends what was said.
    pub fn flush(&self, going: &mut OutgoingBatch) {
        self.unsent.fetch_add(going.send(&self.socket), Ordering::Relaxed);
    }

    /// Takes a batch of what has come, oldest first; an endpoint that answers waits for it, though not long. Whether there may
    /// be more to take.
    pub fn take(&self, came: &mut ReceivedBatch) -> Result<bool, Error> {
        if let Some(road) = &self.road {
            road.poll(&self.socket);
        }
        let took = came.take(&self.socket);
        if took.is_err() {
            came.clear();
        }
        if let Some(road) = &self.road {
            road.sift(came, &self.socket);
            road.release(came);
        }
        let Err(cause) = took else { return Ok(true) };
        match cause.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => Ok(self.answers || came.each().len() > 0),
            kind if PASSING.contains(&kind) => Ok(true),
            _ => Err(format!("the socket on {} failed: {cause}", self.address).into()),
        }
    }

    /// Takes what has come, oldest first, until there is nothing left or it is `until`; an endpoint that answers waits until then.
    ///
    /// # Errors
    /// The socket failed.
    pub fn drain(
        &self,
        came: &mut ReceivedBatch,
        until: Instant,
        mut each: impl FnMut(SocketAddr, &mut [u8]),
    ) -> Result<(), Error> {
        while Instant::now() < until && self.take(came)? {
            came.each().for_each(|(from, datagram)| each(from, datagram));
        }
        Ok(())
    }

    /// [`Endpoint::drain`] for an actor whose answers to each batch are sent at once.
    fn hear(
        &self,
        came: &mut ReceivedBatch,
        going: &mut OutgoingBatch,
        until: Instant,
        actor: &mut impl Live,
    ) -> Result<(), Error> {
        while Instant::now() < until && self.take(came)? {
            let waited: [Duration; MOST] = std::array::from_fn(|at| came.waited.get(at).copied().unwrap_or_default());
            for ((from, datagram), waited) in came.each().zip(waited) {
                actor.waited(waited);
                actor.hear(self.now_ns(), from, datagram, &mut |to, bytes| self.say(going, to, bytes));
            }
            self.flush(going);
            actor.sent(self.now_ns());
        }
        Ok(())
    }

    /// One turn of an actor whose loop has a clock of its own: it takes what has come, no longer than `until`, and acts.
    ///
    /// # Errors
    /// The socket failed.
    pub fn turn(
        &self,
        (came, going): (&mut ReceivedBatch, &mut OutgoingBatch),
        until: Instant,
        actor: &mut impl Live,
    ) -> Result<(), Error> {
        self.hear(came, going, until, actor)?;
        self.act(going, actor);
        Ok(())
    }

    fn act(&self, going: &mut OutgoingBatch, actor: &mut impl Live) {
        let mut send = |to, datagram: &[u8]| self.say(going, to, datagram);
        actor.speak(self.now_ns(), &mut send);
        actor.act(self.now_ns(), &mut send);
        self.flush(going);
    }

    /// Runs an actor to its end, its goodbye included; without anybody there for no longer than `patience_s`.
    ///
    /// # Errors
    /// The socket failed, nobody came in time, or the actor gave up.
    pub fn run(
        &self,
        mut ticker: Ticker,
        patience_s: f64,
        stop: &Stop,
        actor: &mut impl Live,
    ) -> Result<Punctuality, Error> {
        let (mut came, mut going) = (ReceivedBatch::default(), OutgoingBatch::default());
        let ended = loop {
            let heard = if self.answers {
                let heard = self.hear(&mut came, &mut going, ticker.deadline(), actor);
                ticker.wait();
                heard
            } else {
                ticker.wait();
                self.hear(&mut came, &mut going, Instant::now() + ticker.period / 2, actor)
            };
            if heard.is_err() || stop.is_asked() {
                break heard;
            }
            self.act(&mut going, actor);
            let end = actor.end().or_else(|| ticker.is_over().then_some(Ok(())));
            let late = ticker.start.elapsed().as_secs_f64() > patience_s;
            match (end, actor.missing()) {
                (Some(Err(wrong)), _) => break Err(wrong),
                (end, Some(missing)) if late || end.is_some() => break Err(missing.into()),
                (Some(Ok(())), _) => break Ok(()),
                _ => {}
            }
        };
        actor.goodbye(self.now_ns(), &mut |to, datagram| self.say(&mut going, to, datagram));
        self.flush(&mut going);
        ended.map(|()| ticker.kept)
    }
}

#[cfg(test)]
#[path = "../tests/inside/endpoint.rs"]
mod tests;
