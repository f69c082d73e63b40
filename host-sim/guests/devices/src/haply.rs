//! An Inverse3 of Haply's, through the service that runs beside it: WebSocket and JSON on this machine, in a thread of its own.
//!
//! The service (3.5 and newer; older ones are refused) first lists its devices, then answers each message with one state, and says nothing by
//! itself. So the client is the clock: `open` gives a device that sends a force at each tick of the peer, takes the answer, and the next tick reads it. Forces
//! are N, positions m, speeds m/s; z up, x right, y forward.
//!
//! **Age.** A state has no number and no time. Before each question the adapter therefore looks whether something has come. A state that
//! nobody asked for is a fault: the answers after it would be to earlier questions than they seem to be.
//!
//! **Letting go.** The service applies a force once and forgets it after a time that its documentation does not name, so it has to be
//! measured, and told. Zero is sent where there is no force, when the peer has said nothing for as long as readings may be silent, and, without
//! waiting for an answer, when the peer lets go and at the end. A killed process closes its socket.

use std::collections::VecDeque;
use std::io::ErrorKind;
use std::net::{SocketAddr, TcpStream};
use std::time::{Duration, Instant};

use cohold_sim::device::Gone;
use serde_json::{Value, json};
use tungstenite::{Error as Broken, Message, WebSocket, client};

use cohold_cli::address::endpoint;
use cohold_core::settings::Settings;
use cohold_live::Error;
use cohold_live::devices::threaded::{Acts, Desk, Line, Threaded, stopped};
use cohold_live::devices::{AXES, Abilities, BUTTONS, DeviceOptions, Port, Sensed};

/// Where the service listens unless it is told otherwise.
pub(super) const LISTENS: &str = "127.0.0.1:10001";
/// Where the service puts zero: this one is in front of the arm, in its middle.
const PRESET: &str = "arm_front_centered";
/// How long the service may take to be there and to list its devices.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long a service may take that is only looked for.
const LOOKS: Duration = Duration::from_millis(200);
/// Longest wait for an answer before the orders are looked at again.
const LOOK: Duration = Duration::from_millis(2);
/// What is quoted of a text that is not understood, characters.
const QUOTED: usize = 160;

/// Why a state without a question is a fault.
const UNASKED: &str = "the service said a state that nobody asked for: how old its states are is not known any more";
/// What a read says while nothing has come.
const NONE_YET: [ErrorKind; 3] = [ErrorKind::WouldBlock, ErrorKind::TimedOut, ErrorKind::Interrupted];
/// So many pings and the like may come at once while nothing is asked for.
const OTHERS: usize = 16;

const NAMES: [&str; AXES] = ["x", "y", "z"];

/// The first Inverse3 of what the service told, or the one that is called so.
fn listed<'a>(told: &'a Value, id: Option<&str>) -> Option<&'a Value> {
    let called = |device: &&Value| id.is_none_or(|id| device["device_id"] == *id);
    told["inverse3"].as_array().and_then(|all| all.iter().find(called))
}

/// What it lacks, if it is not fit to be driven.
fn lacks(device: &Value) -> Option<&'static str> {
    let wanted =
        [("power_supply", "has no power supply"), ("calibrated", "is not calibrated"), ("ready", "is not ready")];
    wanted.into_iter().find(|(what, _)| device["status"][what] != true).map(|(_, words)| words)
}

/// What the device told, which was asked for and heard at these times.
fn sensed(text: &str, id: &str, between: [Instant; 2]) -> Result<Sensed, Gone> {
    let told: Value = serde_json::from_str(text).map_err(stopped)?;
    let device =
        listed(&told, Some(id)).ok_or_else(|| stopped(format!("the service lists no Inverse3 {id} any more")))?;
    if let Some(lacks) = lacks(device) {
        return Err(stopped(format!("Inverse3 {id} {lacks}")));
    }
    // What is no number is not a place; who takes the reading in says so.
    let along = |what: &str| NAMES.map(|axis| device["state"][what][axis].as_f64().unwrap_or(f64::NAN));
    let pressed = &told["wireless_verse_grip"][0]["state"]["buttons"];
    let buttons = BUTTONS.iter().rev().fold(0, |bits, button| bits << 1 | u8::from(pressed[button] == true));
    let (position_m, velocity_m_per_s) = (along("cursor_position"), along("cursor_velocity"));
    Ok(Sensed { position_m, velocity_m_per_s, between, buttons })
}

/// Where the service is, by what stands behind its name.
pub(super) fn place(at: &str) -> Result<SocketAddr, String> {
    endpoint(if at.is_empty() { LISTENS } else { at }).map_err(|cause| cause.to_string())
}

/// The Inverse3 that is asked for, or the first one, of the service at this place. A force that is not renewed for as long as readings may be
/// silent is no longer sent.
///
/// # Errors
/// There is no service, it is too old, it does not take the preset, or its device is not fit.
pub(super) fn open(at: &str, options: &DeviceOptions, _: &Settings) -> Result<Box<dyn Port>, Error> {
    let at = place(at)?;
    let port = super::once_there(|| service(at, PATIENCE)).and_then(|socket| attached(socket, options));
    Ok(Box::new(port.map_err(|cause| format!("Haply's service at {at}: {cause}"))?))
}

/// The Inverse3 of this service that these options name.
fn attached(mut socket: WebSocket<TcpStream>, options: &DeviceOptions) -> Result<Threaded, Error> {
    let (_, told) = hear(&mut socket)?;
    let wanted = options.id.as_deref();
    let device = listed(&told, wanted)
        .ok_or_else(|| ["it lists no Inverse3", wanted.unwrap_or_default()].join(" ").trim_end().to_owned())?;
    let id = device["device_id"].as_str().unwrap_or_default().to_owned();
    let hello = json!({
        "session": { "configure": { "profile": { "name": "cohold", "required_version": ">=3.5" } } },
        "inverse3": [{ "device_id": id, "configure": { "preset": { "preset": PRESET } },
            "commands": { "set_cursor_force": { "vector": { "x": 0.0, "y": 0.0, "z": 0.0 } } } }]
    });
    socket.send(Message::text(hello.to_string())).map_err(|cause| cause.to_string())?;
    let (quoted, told) = hear(&mut socket)?;
    // A session has a number from 3.5 on.
    if told["session_id"].is_null() {
        let why = format!("it is older than 3.5, or refused the session or the preset {PRESET}: {quoted}");
        return Err(why.into());
    }
    let device =
        listed(&told, Some(&id)).ok_or_else(|| format!("it refused the session or the preset {PRESET}: {quoted}"))?;
    if let Some(lacks) = lacks(device) {
        return Err(format!("Inverse3 {id} {lacks}: it is not armed").into());
    }
    socket.get_ref().set_read_timeout(Some(LOOK)).map_err(|cause| cause.to_string())?;
    let grip = told["wireless_verse_grip"].as_array().is_some_and(|grips| !grips.is_empty());
    let abilities = Abilities {
        name: format!("Inverse3 {id}"),
        axes: AXES,
        // The service names neither.
        is_homed: device["status"]["calibrated"] == true,
        buttons: if grip { BUTTONS.len() } else { 0 },
        lets_go_s: options.lets_go_s,
        ..Abilities::default()
    };
    let silent = Duration::from_secs_f64(options.silent_s);
    Threaded::start(abilities, silent, Service { socket, id, asked: VecDeque::new() })
}

/// The service at this place, if it is there within this time.
fn service(at: SocketAddr, wait: Duration) -> Result<WebSocket<TcpStream>, Error> {
    let ready = || {
        let stream = TcpStream::connect_timeout(&at, wait)?;
        stream.set_nodelay(true)?;
        stream.set_read_timeout(Some(PATIENCE))?;
        stream.set_write_timeout(Some(PATIENCE))?;
        Ok(stream)
    };
    let stream = ready().map_err(|cause: std::io::Error| cause.to_string())?;
    Ok(client(format!("ws://{at}/"), stream).map_err(|cause| format!("no WebSocket: {cause}"))?.0)
}

/// The next thing that the service says, and the beginning of its text.
fn hear(socket: &mut WebSocket<TcpStream>) -> Result<(String, Value), Error> {
    let text = socket.read().and_then(Message::into_text).map_err(|cause| format!("no answer: {cause}"))?;
    let told = serde_json::from_str(&text).map_err(|cause| format!("not JSON: {cause}"))?;
    Ok((text.chars().take(QUOTED).collect(), told))
}

/// What the service at this place lists, device by device.
///
/// # Errors
/// There is none.
pub(super) fn found(at: SocketAddr) -> Result<Vec<String>, Error> {
    let (_, told) = hear(&mut service(at, LOOKS)?)?;
    let each = |device: &Value| {
        let id = device["device_id"].as_str().unwrap_or_default();
        format!("Inverse3 {id}, which {}", lacks(device).unwrap_or("is ready"))
    };
    Ok(told["inverse3"].as_array().into_iter().flatten().map(each).collect())
}

/// The thread's end of the line to the service.
struct Service {
    socket: WebSocket<TcpStream>,
    id: String,
    /// When those messages were sent that are not answered yet.
    asked: VecDeque<Instant>,
}

impl Service {
    fn say(&mut self, [x, y, z]: [f64; AXES]) -> Result<(), Gone> {
        let id = &self.id;
        let vector = format!(r#"{{"x":{x:.5},"y":{y:.5},"z":{z:.5}}}"#);
        let text = format!(
            r#"{{"inverse3":[{{"device_id":"{id}","commands":{{"set_cursor_force":{{"vector":{vector}}}}}}}]}}"#
        );
        self.asked.push_back(Instant::now());
        self.socket.send(Message::text(text)).map_err(stopped)
    }

    /// Looks whether something has come, without waiting.
    fn look(&mut self) -> Result<(), Gone> {
        self.socket.get_ref().set_nonblocking(true).map_err(stopped)?;
        let heard = self.hear();
        self.socket.get_ref().set_nonblocking(false).map_err(stopped)?;
        heard.map(|_| ())
    }

    /// The next answer, and when it was asked for; none while there is none yet. Where nothing is asked for, a ping hides no state behind it.
    fn hear(&mut self) -> Result<Option<(String, Instant)>, Gone> {
        for _ in 0..OTHERS {
            match self.socket.read() {
                Ok(Message::Text(text)) => {
                    let asked = self.asked.pop_front().ok_or_else(|| stopped(UNASKED))?;
                    return Ok(Some((text.as_str().to_owned(), asked)));
                }
                Ok(Message::Close(_)) => return Err(stopped("the service has closed the line")),
                Ok(_) if self.asked.is_empty() => {}
                Ok(_) => return Ok(None),
                Err(Broken::Io(cause)) if NONE_YET.contains(&cause.kind()) => return Ok(None),
                Err(cause) => return Err(stopped(cause)),
            }
        }
        Err(stopped("the service says more than states: how old those are is not known any more"))
    }
}

impl Line for Service {
    /// While no answer comes, the service is told once if the peer lets go.
    fn exchange(&mut self, desk: &Desk) -> Result<(), Gone> {
        self.look()?;
        let force_n = desk.wanted();
        self.say(force_n.unwrap_or_default())?;
        let mut pushes = force_n.is_some();
        while !self.asked.is_empty() && !desk.ends() {
            match self.hear()? {
                Some((text, asked)) => desk.tell(Ok(Some(sensed(&text, &self.id, [asked, Instant::now()])?))),
                None if pushes && desk.wanted().is_none() => {
                    pushes = false;
                    self.say([0.0; AXES])?;
                }
                None => {}
            }
        }
        Ok(())
    }

    fn let_go(&mut self) {
        let _ = self.say([0.0; AXES]);
        let _ = self.socket.flush();
    }

    /// By the poll that the service documents, which commands nothing: it answers each message with a state.
    fn acts(&mut self) -> Acts {
        self.asked.push_back(Instant::now());
        let poll = json!({ "inverse3": [{ "device_id": self.id, "commands": { "probe_position": {} } }] });
        self.socket.send(Message::text(poll.to_string())).map_err(stopped)?;
        let by = Instant::now() + PATIENCE;
        while Instant::now() < by {
            let Some((text, _)) = self.hear()? else { continue };
            if !self.asked.is_empty() {
                continue;
            }
            let told: Value = serde_json::from_str(&text).map_err(stopped)?;
            let force = listed(&told, Some(&self.id)).map(|device| &device["state"]["current_cursor_force"]);
            let along = |axis: &str| force.and_then(|force| force[axis].as_f64());
            let along: Option<Vec<f64>> = NAMES.iter().map(|axis| along(axis)).collect();
            return Ok(along.map(|along| along.iter().fold(0.0, |most: f64, force| most.max(force.abs()))));
        }
        Err(stopped("the service does not answer"))
    }
}
