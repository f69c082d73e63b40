//! The operator's port: a sealed link to whoever holds the operator's key, lines in, answers and records out.
//!
//! A [`Link`] of its own on UDP 7702: the operator has number 0, this board its own. The board never calls: it answers where
//! an operator's session began, once that address has proved itself ([`Path`]), so that an operator may come from anywhere, a stranger finds
//! nothing here, and who copies datagrams moves nothing; nor does the other peer find anything, whose key is another. The last operator to prove that he holds the key and is there
//! now takes the link over; what was half said to the one before is dropped, and records are no longer sent.
//!
//! **Run is a lease**: every datagram of the operator's end says whether the motors may run, and every datagram of the board whether
//! they do ([`firmware_parts::hold`]).
//!
//! Lines are taken one at a time, an answer each ([`Console`]). Lines of the log come in between ([`crate::log`]). A line that was said more
//! than half a second ago does nothing. A record that the network does not take now waits.

use core::fmt::Write;

use cohold_protocol::lease::{AtBoard, Told, Word};
use cohold_protocol::lines::{self, Line, Lines, OPERATOR, PORT};
use cohold_protocol::link::{ConfigError, Link, Notice};
use cohold_protocol::path::Path;
use cohold_protocol::wire::{Datagram, MAX_DATAGRAM};
use cohold_protocol::{ends::Ends, key::Key};
use embassy_net::{IpEndpoint, Stack};
use embassy_time::{Duration, Instant, with_timeout};

use crate::board::{Number, pace, random};
use crate::log::{LINES, log};
use crate::{console::Console, serial::Teller, sockets, telemetry::Telemetry};

/// Between two looks while nothing comes and there is no record to send; with records it is two ticks, so that a socket has room for what they
/// left.
const IDLE: Duration = Duration::from_millis(10);

/// The board's end of the link.
///
/// # Errors
/// [`Link::new`]'s: without randomness, that there is none.
pub(crate) fn link(key: &Key, seed: &Key, number: Number) -> Result<Link, ConfigError> {
    let entropy = random::draw(seed, number).ok_or(ConfigError::ZeroEntropy)?;
    Link::new(lines::config(key.clone(), Ends { local: number.peer(), remote: OPERATOR }, entropy))
}

struct Port {
    link: &'static mut Link,
    lines: Lines,
    /// Where the operator is answered.
    path: Path<IpEndpoint>,
    console: Console,
    telemetry: Telemetry,
}

impl Port {
    /// Takes a datagram; gives whom to answer with a welcome, which a stranger with an old greeting may be, once.
    fn receive(&mut self, datagram: &mut [u8], from: IpEndpoint) -> Option<IpEndpoint> {
        let now = Instant::now().as_micros();
        let taken = self.link.receive(now, datagram).is_ok();
        self.path.heard(now, from, datagram, taken, self.link);
        if !taken {
            self.console.signals.refused.count();
            return None;
        }
        while let Some(notice) = self.link.take_notice() {
            match notice {
                Notice::NewPeer(_) => {
                    log!(info, "operator: here");
                    self.console.lease.with(|hold, now_us| hold.step(now_us, AtBoard::Session));
                    self.lines.forget();
                    self.telemetry.stream(0);
                }
                Notice::Lost => {
                    log!(info, "operator: gone");
                    self.telemetry.stream(0);
                }
                _ => {}
            }
        }
        Some(from)
    }
}

#[embassy_executor::task]
pub(crate) async fn run(stack: Stack<'static>, console: Console, link: &'static mut Link, telemetry: Telemetry) -> ! {
    let (socket, mut answers) = sockets::pair(stack, PORT);
    let mut port = Port { link, lines: Lines::default(), path: Path::default(), console, telemetry };
    let (mut bytes, mut out): (Datagram, Datagram) = ([0; MAX_DATAGRAM], [0; MAX_DATAGRAM]);
    let mut teller = Teller::new();
    // A record that is sealed and waits.
    let mut waiting: Option<(usize, Datagram)> = None;
    loop {
        let busy = Duration::from_micros(2000 / u64::from(pace::per_ms()));
        let look = if port.telemetry.is_on() { busy } else { IDLE };
        let mut caller = None;
        match with_timeout(look, socket.recv_from(&mut bytes)).await {
            Ok(Ok((length, from))) => {
                caller = port.receive(bytes.get_mut(..length).unwrap_or_default(), from.endpoint);
            }
            Ok(Err(_)) => port.console.signals.refused.count(),
            Err(_) => answers.tend(),
        }
        port.console.leave();
        port.console.compare();
        port.console.note();
        teller.look(&port.console);
        let now = Instant::now().as_micros();
        let (lease, signals) = (port.console.lease, port.console.signals);
        // An operator who is gone has taken nothing back: the lease runs out.
        if let Some(said) = port.link.heard()
            && lease.with(|hold, now_us| hold.hear(now_us, said, signals))
        {
            log!(info, "the operator does not let the motors run: off");
        }
        if !port.lines.is_saying()
            && let Some(heard) = port.lines.hear(now, port.link)
        {
            let mut answer = Line::new();
            if heard.is_fresh() {
                port.console.word = heard.word;
                port.console.hear(&heard.line, &mut port.telemetry, &mut answer).await;
            } else {
                let _ = answer.push_str("error this line was said more than 0.5 s ago: nothing was done, say it again");
            }
            defmt::info!("operator: {=str}", answer.as_str());
            port.lines.say(&answer, Word::default());
        }
        // Behind the answers, which no flood of the log holds up.
        let is_free = !port.lines.is_saying() && port.link.is_up();
        if let Some(Ok((at, words))) = is_free.then(|| LINES.try_receive()) {
            let mut line = Line::new();
            let _ = write!(line, "log {} {words}", at.as_micros());
            port.lines.say(&line, Word::default());
        }
        // A session that is not confirmed has heard nothing of this operator.
        let told = lease.with(|hold, _| hold.told(signals));
        let heard = if port.link.is_up() { told.heard } else { Word::default().number };
        port.link.say_lease(Told { heard, ..told }.byte(), false);
        port.lines.push(port.link);
        while let Some(length) = port.link.poll(Instant::now().as_micros(), &mut out) {
            let datagram = out.get(..length).unwrap_or_default();
            if let Some(to) = port.path.of(datagram, caller) {
                answers.send(datagram, to).await;
            }
        }
        loop {
            if waiting.is_none()
                && let Some(sample) = port.telemetry.next()
            {
                let mut datagram = [0; MAX_DATAGRAM];
                let sealed = port.link.send(Instant::now().as_micros(), sample, &mut datagram);
                waiting = sealed.map(|length| (length, datagram));
            }
            let Some((length, datagram)) = &waiting else { break };
            let datagram = datagram.get(..*length).unwrap_or_default();
            // Where nothing may go yet, a record is lost like any other.
            if let Some(to) = port.path.of(datagram, None)
                && !answers.send(datagram, to).await
            {
                break;
            }
            waiting = None;
        }
    }
}
