//! Some files and a WebSocket for each window, at the [doors](super::doors) that are open; a thread for each connection, of which there are
//! [so many](super::connections).
//!
//! **Who may talk to it.** Only this machine can connect, unless a door to a local network was asked for, where no key of the operator
//! opens. A web page that the person visits elsewhere runs on this machine
//! too, so: the host must be ours by name (a rebound DNS name is not), the origin of a WebSocket must be this page, and its
//! path holds [keys](super::roles) of this run that only the address has, behind its `#`: browsers send that to nobody. What a window
//! says is checked, each time, against what its keys open. Nothing is fetched from elsewhere, no script or style stands in the page, and
//! its Content-Security-Policy says so.
//!
//! **Who asks, gets.** A window asks once a frame: the tick it has come to, and where its hand is wanted. It gets what came
//! since, each sample once, whatever it asks for. One that sleeps asks nothing, is sent nothing, and after [`SILENCE`] its hand has let go. One that does not read is
//! closed after [`PATIENCE`]; one that asks or orders without end is heard every [`SOONEST`].
//!
//! | from a window | |
//! |---|---|
//! | 20 bytes | tick wanted next, u32; hand along, across and up, 3 × f32, m, NaN for none; start that it has seen last, u32; little-endian |
//! | `stop`, `start`, `cut`, `join`, `partner NAME`, `board NUMBER LINE` | acts at the next tick |
//! | any other text | an order of [`super::orders`], judged first |
//!
//! | to a window | |
//! |---|---|
//! | bytes | [`HEADER`] bytes as [`header`] makes them, then samples: the columns of what is shown, and the count of starts; f32, little-endian |
//! | `{"hello"}` | first of all: names, units, ranges |
//! | `{"holds"}` | settings and the verdict on them, whenever they change |
//! | `{"refused"}`, `{"ask"}` | what became of its order |
//! | `{"join"}` | to the operator, where there is a door to a local network: the address of a hand there, and its QR code |
//! | close 4000, 4001 | the run has ended; another window has taken its hand |

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::mpsc::SyncSender;
use std::time::{Duration, Instant};

use cohold_core::names::Choice as _;
use cohold_core::safety::Fault;
use cohold_core::settings::Allowed;
use cohold_live::endpoint::stand_back;
use cohold_sim::device::DeviceFault;
use cohold_sim::scene::Scene;
use serde_json::{Value, json};
use tungstenite::handshake::derive_accept_key;
use tungstenite::protocol::frame::{CloseFrame, coding::CloseCode};
use tungstenite::protocol::{Role as Side, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::connections::{Connections, Pass};
use super::doors::{Doors, Way};
use super::environment::{ALONE, FAULT, WAITS};
use super::judge::Ask;
use super::kinds::{EnvironmentKind, Kinds};
use super::mailbox::{Contents, Mailbox, Pointed};
use super::messages::{LET_GO, command, question};
use super::opened::Opened;
use super::opened_page;
use super::orders::CLICKS;
use super::partner::Model;
use super::qr::Code;
use super::roles::{Keys, Rights, Role};
use super::session::PERIOD_S;
use cohold_live::hand;

pub(super) const FILES: &[(&str, &str, &str)] = &[
    ("/", "text/html; charset=utf-8", include_str!("site/index.html")),
    ("/page.css", "text/css; charset=utf-8", include_str!("site/page.css")),
    ("/phone.css", "text/css; charset=utf-8", include_str!("site/phone.css")),
    ("/page.js", "text/javascript; charset=utf-8", include_str!("site/page.js")),
    ("/environments.js", "text/javascript; charset=utf-8", include_str!("site/environments.js")),
    ("/join.js", "text/javascript; charset=utf-8", include_str!("site/join.js")),
    ("/phone.js", "text/javascript; charset=utf-8", include_str!("site/phone.js")),
    ("/laws.js", "text/javascript; charset=utf-8", include_str!("site/laws.js")),
    ("/timeline.css", "text/css; charset=utf-8", include_str!("site/timeline.css")),
    ("/timeline.js", "text/javascript; charset=utf-8", include_str!("site/timeline.js")),
    ("/samples.js", "text/javascript; charset=utf-8", include_str!("site/samples.js")),
    ("/plots.js", "text/javascript; charset=utf-8", include_str!("site/plots.js")),
    ("/figure.js", "text/javascript; charset=utf-8", include_str!("site/figure.js")),
    ("/pair.js", "text/javascript; charset=utf-8", include_str!("site/pair.js")),
    ("/parts.js", "text/javascript; charset=utf-8", include_str!("site/parts.js")),
    ("/delay.js", "text/javascript; charset=utf-8", include_str!("site/delay.js")),
    ("/lens.js", "text/javascript; charset=utf-8", include_str!("site/lens.js")),
    ("/numbers.js", "text/javascript; charset=utf-8", include_str!("site/numbers.js")),
    ("/scene.js", "text/javascript; charset=utf-8", include_str!("site/scene.js")),
    ("/settings.js", "text/javascript; charset=utf-8", include_str!("site/settings.js")),
    ("/status.js", "text/javascript; charset=utf-8", include_str!("site/status.js")),
    ("/stiff.js", "text/javascript; charset=utf-8", include_str!("site/stiff.js")),
    ("/stories.js", "text/javascript; charset=utf-8", include_str!("site/stories.js")),
    ("/stories.css", "text/css; charset=utf-8", include_str!("site/stories.css")),
];
/// After so long without a word from its window a hand lets go.
const SILENCE: Duration = Duration::from_millis(250);
/// How long a request's head, and what is sent, may take.
const PATIENCE: Duration = Duration::from_secs(2);
/// From one message of a window to the next at the least.
const SOONEST: Duration = Duration::from_millis(4);
/// Longest head of a request, and longest message of a window, bytes: a scene file of every key has 5,000.
const LONGEST_HEAD: usize = 4096;
pub(super) const LONGEST_MESSAGE: usize = 16384;
/// How far windows stand back behind the control loop where that gets no real-time priority.
const NICENESS: i32 = 5;
/// Bytes before the samples.
const HEADER: usize = 20;
/// Where in them it says what is shown.
const KIND: usize = 18;
/// Why a window is closed: the run has ended, or another window has taken its hand.
pub(super) const OVER: u16 = 4000;
const TAKEN: u16 = 4001;

/// Where the page is.
#[derive(Clone, Debug)]
pub(super) struct Site {
    doors: Doors,
    keys: Keys,
    hello: Arc<Value>,
    /// What the operator's windows are told of the door to the local network.
    join: Option<Arc<Value>>,
    /// The recording that the page shows, and the scene that made it, told as what holds.
    recording: Option<Arc<(Opened, Option<String>)>>,
}

/// What a request gets.
#[derive(Debug, PartialEq)]
pub(super) enum Answer {
    File(&'static str, &'static str),
    /// What its keys open, and the text that accepts the connection.
    Window(Rights, String),
    Refused(&'static str),
}

impl Site {
    /// The site at these doors, with fresh keys.
    pub(super) fn new(doors: Doors, hello: Value) -> Result<Self, cohold_cli::Failure> {
        Ok(Self { doors, keys: Keys::new()?, hello: Arc::new(hello), join: None, recording: None })
    }

    /// The same for a recording.
    pub(super) fn of_recording(self, opened: Opened, holds: Option<String>) -> Self {
        Self { recording: Some(Arc::new((opened, holds))), ..self }
    }

    /// The address for who has these roles, on this machine.
    pub(super) fn address(&self, roles: &[Role]) -> String {
        self.address_by(Way::Here, roles).unwrap_or_default()
    }

    /// The same by either way, if there is that way.
    pub(super) fn address_by(&self, way: Way, roles: &[Role]) -> Option<String> {
        Some(format!("http://{}/#{}", self.doors.host(way)?, self.keys.ring(roles)))
    }

    /// Tells the operator's windows how a hand is taken on the local network; the code of that address.
    pub(super) fn offer(&mut self, hand: Role) -> Result<Option<Code>, cohold_cli::Failure> {
        let Some(address) = self.address_by(Way::Lan, &[hand]) else { return Ok(None) };
        let code = Code::of(&address)?;
        let join = json!({ "address": address, "hand": hand as usize + 1, "side": code.side, "path": code.path() });
        self.join = Some(Arc::new(json!({ "join": join })));
        Ok(Some(code))
    }

    /// Serves on threads of its own, as long as the program runs.
    pub(super) fn serve(
        &self,
        listeners: Vec<(Way, TcpListener)>,
        mailbox: &Arc<Mailbox>,
        asks: SyncSender<Ask>,
    ) -> Result<(), cohold_cli::Failure> {
        let connections = Arc::new(Connections::default());
        for (way, listener) in listeners {
            let (site, mailbox) = (self.clone(), Arc::clone(mailbox));
            let (connections, asks) = (Arc::clone(&connections), asks.clone());
            let accept = move || {
                stand_back(NICENESS);
                for stream in listener.incoming().flatten() {
                    let Ok(pass) = connections.admit(way, &stream) else { continue };
                    let (site, mailbox, asks) = (site.clone(), Arc::clone(&mailbox), asks.clone());
                    let serve = move || {
                        // A browser that went away is nothing to report.
                        let _ = site.connection(way, stream, &pass, &mailbox, &asks);
                    };
                    let _ = std::thread::Builder::new().name("window".into()).spawn(serve);
                }
            };
            std::thread::Builder::new().name("page".into()).spawn(accept)?;
        }
        Ok(())
    }

    fn connection(
        &self,
        way: Way,
        mut stream: TcpStream,
        pass: &Pass,
        mailbox: &Mailbox,
        asks: &SyncSender<Ask>,
    ) -> std::io::Result<()> {
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let Some((head, rest)) = head(&mut stream)? else { return Ok(()) };
        match self.answer(way, &head) {
            Answer::File(kind, text) => respond(&mut stream, "200 OK", kind, text),
            Answer::Refused(status) => respond(&mut stream, status, "text/plain", status),
            Answer::Window(rights, accept) => {
                pass.has(rights);
                write!(
                    stream,
                    "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
                     Sec-WebSocket-Accept: {accept}\r\n\r\n"
                )?;
                stream.set_read_timeout(Some(SILENCE))?;
                let limits = WebSocketConfig::default()
                    .max_message_size(Some(LONGEST_MESSAGE))
                    .max_frame_size(Some(LONGEST_MESSAGE));
                let socket = WebSocket::from_partially_read(stream, rest, Side::Server, Some(limits));
                let join = self.join.as_ref().filter(|_| rights.operates);
                let greeting = [Some(json!({ "hello": *self.hello })), join.map(|join| (**join).clone())];
                match &self.recording {
                    Some(recording) => opened_page::window(socket, &self.hello, recording, mailbox),
                    None => Window { socket, rights, pass, mailbox, asks }.serve(greeting.into_iter().flatten()),
                }
                Ok(())
            }
        }
    }

    /// What a request's head gets that came in this way.
    pub(super) fn answer(&self, way: Way, head: &[u8]) -> Answer {
        let mut headers = [httparse::EMPTY_HEADER; 48];
        let mut request = httparse::Request::new(&mut headers);
        let (Ok(_), Some(method), Some(path)) = (request.parse(head), request.method, request.path) else {
            return Answer::Refused("400 Bad Request");
        };
        let header = |name: &str| {
            let mut all = request.headers.iter().filter(|header| header.name.eq_ignore_ascii_case(name));
            // One that comes twice is none.
            all.next().filter(|_| all.next().is_none()).and_then(|header| std::str::from_utf8(header.value).ok())
        };
        let Some(host) = header("host").filter(|host| self.doors.is_host(way, host)) else {
            return Answer::Refused("421 Misdirected Request");
        };
        if method != "GET" {
            return Answer::Refused("405 Method Not Allowed");
        }
        if let Some((_, kind, text)) = FILES.iter().find(|(name, ..)| *name == path) {
            return Answer::File(kind, text);
        }
        let Some(ring) = path.strip_prefix("/ws/") else { return Answer::Refused("404 Not Found") };
        let ours = header("origin") == Some(&format!("http://{host}"));
        let Some(rights) = self.keys.opened_by(ring).filter(|rights| ours && way.admits(*rights)) else {
            return Answer::Refused("403 Forbidden");
        };
        let upgrade = header("upgrade").is_some_and(|to| to.eq_ignore_ascii_case("websocket"));
        match (upgrade, header("sec-websocket-version"), header("sec-websocket-key")) {
            (true, Some("13"), Some(key)) => Answer::Window(rights, derive_accept_key(key.as_bytes())),
            _ => Answer::Refused("426 Upgrade Required"),
        }
    }
}

/// A request's head and what came behind it, unless it is too long or takes too long.
pub(super) fn head(stream: &mut impl Read) -> std::io::Result<Option<(Vec<u8>, Vec<u8>)>> {
    let start = Instant::now();
    let (mut head, mut chunk) = (Vec::new(), [0; 1024]);
    loop {
        let got = stream.read(&mut chunk)?;
        head.extend_from_slice(&chunk[..got]);
        if let Some(at) = head.windows(4).position(|four| four == b"\r\n\r\n") {
            let rest = head.split_off(at + 4);
            return Ok(Some((head, rest)));
        }
        if got == 0 || head.len() > LONGEST_HEAD || start.elapsed() > PATIENCE {
            return Ok(None);
        }
    }
}

fn respond(stream: &mut TcpStream, status: &str, kind: &str, text: &str) -> std::io::Result<()> {
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\nCache-Control: no-store\r\n\
         X-Content-Type-Options: nosniff\r\nReferrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\n\
         Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
         img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'\r\n\r\n{text}",
        text.len(),
    )
}

/// One window, until it goes, the program ends, or another takes its hand.
struct Window<'a> {
    socket: WebSocket<TcpStream>,
    rights: Rights,
    pass: &'a Pass,
    mailbox: &'a Mailbox,
    asks: &'a SyncSender<Ask>,
}

/// Closes the line of a window, and says why.
pub(super) fn hang_up(socket: &mut WebSocket<TcpStream>, why: Option<u16>) {
    let _ = socket.close(why.map(|why| CloseFrame { code: CloseCode::from(why), reason: "".into() }));
    let _ = socket.flush();
}

impl Window<'_> {
    fn serve(mut self, mut greeting: impl Iterator<Item = Value>) {
        let me = {
            let mut contents = self.mailbox.lock();
            contents.windows += 1;
            let me = contents.windows;
            if let Some(hand) = self.rights.hand {
                (contents.holder[hand], contents.pointed[hand]) = (Some(me), Some(LET_GO));
            }
            me
        };
        let greeted = greeting.all(|text| self.socket.send(Message::text(text.to_string())).is_ok());
        let why = if greeted { self.answer(me) } else { None };
        let mut contents = self.mailbox.lock();
        if let Some(hand) = self.rights.hand.filter(|hand| contents.holder[*hand] == Some(me)) {
            (contents.holder[hand], contents.pointed[hand]) = (None, None);
        }
        drop(contents);
        hang_up(&mut self.socket, why);
    }

    /// Answers what it asks, until it goes, or is closed for a reason.
    fn answer(&mut self, me: u64) -> Option<u16> {
        let mut edition = 0;
        let mut last = Instant::now();
        // The tick after the last that it was sent: it is sent none twice, so that a question brings about no more than its time did.
        let mut sent = None;
        loop {
            let message = match self.socket.read() {
                Ok(message) => Some(message),
                // Nothing came for a while: the hand lets go. Systems call that by different names.
                Err(Error::Io(error)) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => None,
                Err(_) => return None,
            };
            if message.is_some() {
                self.pass.speaks();
            }
            let mut contents = self.mailbox.lock();
            if contents.over {
                return Some(OVER);
            }
            if self.rights.hand.is_some_and(|hand| contents.holder[hand] != Some(me)) {
                return Some(TAKEN);
            }
            let answers = match message {
                None => {
                    self.point(&mut contents, LET_GO);
                    continue;
                }
                Some(Message::Binary(bytes)) => match <[u8; 20]>::try_from(&bytes[..]) {
                    Ok(bytes) => {
                        let (from, pointed) = question(bytes);
                        self.point(&mut contents, pointed);
                        contents.operator_asked |= self.rights.operates;
                        let answers = picture(&mut contents, me, &mut edition, sent.unwrap_or(from));
                        if let Some(Message::Binary(bytes)) = answers.first() {
                            sent = next(bytes, contents.status.kind);
                        }
                        answers
                    }
                    Err(_) => return None,
                },
                Some(Message::Text(line)) => {
                    self.order(&mut contents, me, line.as_str());
                    Vec::new()
                }
                Some(Message::Close(_)) => return None,
                Some(_) => Vec::new(),
            };
            drop(contents);
            // Whatever it says: no onlooker keeps the control loop from the mailbox.
            std::thread::sleep((last + SOONEST).saturating_duration_since(Instant::now()));
            last = Instant::now();
            if answers.into_iter().any(|answer| self.socket.send(answer).is_err()) {
                return None;
            }
        }
    }

    fn point(&self, contents: &mut Contents, pointed: Pointed) {
        if let Some(hand) = self.rights.hand {
            contents.pointed[hand] = Some(pointed);
        }
    }

    fn order(&self, contents: &mut Contents, me: u64, line: &str) {
        let command = command(line);
        let refused = match command {
            _ if !self.rights.may(command.as_ref()) => "only the operator's address may order that",
            Some(command) => return contents.ask(command),
            None if self.asks.try_send(Ask { window: me, line: line.to_owned() }).is_ok() => return,
            None => "the last orders are still being judged: try again",
        };
        contents.answer(me, json!({ "refused": refused }).to_string());
    }
}

/// What a window that has come to tick `from` gets.
pub(super) fn picture(contents: &mut Contents, window: u64, edition: &mut u64, from: u32) -> Vec<Message> {
    let columns = contents.status.kind.columns().len();
    let mut bytes = Vec::with_capacity(HEADER + 4 * (columns + 1) * 20);
    let (first, samples) = contents.since(from);
    bytes.extend(header(first, contents));
    let numbers = samples.flat_map(|sample| sample[..columns].iter().chain(sample.last()));
    bytes.extend(numbers.flat_map(|number| number.to_le_bytes()));
    let mut answers = vec![Message::Binary(bytes.into())];
    answers.extend(contents.announced_since(edition).into_iter().map(Message::text));
    answers.extend(std::iter::from_fn(|| contents.answer_for(window)).map(Message::text));
    answers
}

/// Tick of the first sample, late ticks, latest, µs, each u32; modes of the two peers, who holds a hand, cut, partner, which environment, one spare.
fn header(first: u32, contents: &Contents) -> [u8; HEADER] {
    let status = contents.status;
    let mut bytes = [0; HEADER];
    for (at, number) in [first, status.late, status.worst_us].into_iter().enumerate() {
        bytes[4 * at..4 * at + 4].copy_from_slice(&number.to_le_bytes());
    }
    let people = contents.holder.map(|holder| u8::from(holder.is_some()));
    let standing = status.standing;
    let [one, two] = standing.modes;
    let rest = [one, two, people[0], people[1], u8::from(standing.cut), standing.partner, status.kind.number(), 0];
    bytes[12..].copy_from_slice(&rest);
    bytes
}

/// The header of what is no live picture: the tick of its first sample, and which environment.
pub(super) fn header_of(first: u32, kind: EnvironmentKind) -> [u8; HEADER] {
    let mut bytes = [0; HEADER];
    bytes[..4].copy_from_slice(&first.to_le_bytes());
    bytes[KIND] = kind.number();
    bytes
}

/// The tick for which a window asks next after this answer.
pub(super) fn next(sent: &[u8], kind: EnvironmentKind) -> Option<u32> {
    let first = u32::from_le_bytes(sent.get(..4)?.try_into().ok()?);
    let samples = (sent.len().checked_sub(HEADER)? / (4 * (kind.columns().len() + 1))) as u32;
    Some(first.wrapping_add(samples))
}

/// What a page is sent once: so that no name, unit or range stands in it a second time.
/// `other` is who has the other hand where that is a process elsewhere.
pub(super) fn hello(kinds: Kinds, scene: &Scene, other: Option<String>, boards: bool) -> Value {
    let of_peers = Fault::ALL.iter().map(|fault| (fault.number(), fault.explain()));
    let of_devices = DeviceFault::ALL.iter().map(|fault| (*fault as u8, fault.explain()));
    let faults: serde_json::Map<_, _> =
        of_peers.chain(of_devices).map(|(number, why)| (number.to_string(), json!(why))).collect();
    let keys: serde_json::Map<_, _> = scene
        .keys()
        .into_iter()
        .map(|(name, key)| {
            let range = match key.allowed {
                Allowed::Number { min, max } => json!([min, max]),
                Allowed::Whole { min, max } => json!([min, max]),
                _ => Value::Null,
            };
            (name, json!({ "unit": key.unit, "means": key.doc, "range": range }))
        })
        .collect();
    let clicks: Vec<_> = CLICKS
        .iter()
        .map(|(name, scene, keys)| json!({ "name": name, "order": format!("scene {scene} {keys}").trim_end() }))
        .collect();
    json!({
        "environments": kinds.hello(),
        "header_bytes": HEADER,
        "faults": faults,
        "fault_base": FAULT,
        "waits": WAITS,
        "alone": ALONE,
        "other": other,
        "boards": boards,
        "keys": keys,
        "clicks": clicks,
        "laws": scene.laws.all().iter().map(|law| law.name).collect::<Vec<_>>(),
        "partners": Model::NAMES,
        "hand_n_per_m": hand::STIFFNESS,
        "hand_n": hand::STRENGTH,
        "reach_m": hand::REACH_M,
        "period_s": PERIOD_S,
    })
}

#[cfg(test)]
#[path = "../tests/inside/web.rs"]
mod tests;
