//! Haply's service as its clients see it, with a hand on an emulated Inverse3: lists its devices to whoever connects, then answers each
//! message with one state. Messages are those of the vendor's documentation and of its crate 1.3.1; how long a force stands is invented.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, accept};

use super::asked::Asked;
use super::hand::{Hand, STEP_S};
use super::{Emulated, Seen, locked, named};

/// For so long a force stands without a new one unless it is told otherwise, s. The vendor says "applied once and forgotten", and no number.
pub const HOLDS_S: f64 = 0.02;
/// Its faults by name.
pub const FAULTS: [(&str, Fault); 12] = [
    ("none", Fault::None),
    ("silent", Fault::Silent),
    ("late", Fault::Late),
    ("not-a-number", Fault::NotANumber),
    ("jump", Fault::Jump),
    ("closes", Fault::Closes),
    ("wrong-sign", Fault::WrongSign),
    ("no-watchdog", Fault::NoWatchdog),
    ("uncalibrated", Fault::Uncalibrated),
    ("older", Fault::Older),
    ("preset", Fault::Preset),
    ("unasked", Fault::Unasked),
];

/// What the service can do wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    #[default]
    None,
    /// It hears and says nothing.
    Silent,
    /// It answers 0.1 s late.
    Late,
    /// It tells places that are not numbers.
    NotANumber,
    /// It tells places 50 mm off.
    Jump,
    /// It closes the line.
    Closes,
    /// A force pushes the other way.
    WrongSign,
    /// A force stands until there is another one.
    NoWatchdog,
    /// Its device is no longer calibrated.
    Uncalibrated,
    /// It is older than 3.5.
    Older,
    /// It does not know the preset.
    Preset,
    /// It says each state twice.
    Unasked,
}

/// The mechanism with the hand on it, in the device's frame.
pub struct World {
    hand: Hand<3>,
    force_n: [f64; 3],
    until_s: f64,
    /// How long a force stands, s.
    holds_s: f64,
    fault: Fault,
    /// Forces that were asked for, and when.
    pub asked: Asked<3>,
}

impl World {
    /// Since it began, s.
    pub fn time_s(&self) -> f64 {
        self.hand.time_s()
    }

    /// Brings it to now; the force that acts then, N.
    pub fn advance(&mut self) -> [f64; 3] {
        let now_s = self.time_s();
        let sign = if self.fault == Fault::WrongSign { -1.0 } else { 1.0 };
        while self.hand.now_s < now_s {
            if self.hand.now_s + STEP_S >= self.until_s && self.fault != Fault::NoWatchdog {
                self.force_n = [0.0; 3];
            }
            self.hand.step(self.force_n.map(|force| sign * force));
        }
        self.force_n
    }

    /// The hand begins to reach there.
    pub fn reach(&mut self, reach_m: [f64; 3]) {
        self.hand.reach(reach_m);
    }

    /// Plants a fault; when, s.
    pub fn fail(&mut self, fault: Fault) -> f64 {
        self.fault = fault;
        self.time_s()
    }

    fn told(&self) -> Value {
        let off_m = if self.fault == Fault::Jump { 0.05 } else { 0.0 };
        let at = |axis: usize| {
            if self.fault == Fault::NotANumber { json!(null) } else { json!(self.hand.position_m[axis] + off_m) }
        };
        let xyz = |of: [f64; 3]| json!({ "x": of[0], "y": of[1], "z": of[2] });
        let mut told = json!({
            "session_id": 7,
            "inverse3": [{
                "device_id": "049D",
                "state": {
                    "cursor_position": { "x": at(0), "y": at(1), "z": at(2) },
                    "cursor_velocity": xyz(self.hand.velocity_m_per_s), "current_cursor_force": xyz(self.force_n),
                    "control_domain": "cartesian", "control_mode": "force", "mode": "force_control" },
                "status": { "calibrated": self.fault != Fault::Uncalibrated, "in_use": true, "power_supply": true, "ready": true } }],
            "verse_grip": [],
            "wireless_verse_grip": [{ "device_id": "61548",
                "state": { "hall": 0, "buttons": { "a": self.hand.presses(), "b": false, "c": false }, "battery_level": 0.9 } }],
        });
        if self.fault == Fault::Older {
            told.as_object_mut().expect("an object").remove("session_id");
        }
        told
    }
}

/// A service that listens, as long as the process lives.
pub struct Emulator {
    /// Where it listens.
    pub at: SocketAddr,
    world: Arc<Mutex<World>>,
}

impl Emulator {
    /// Listens there, port 0 is any, with this hand on a device that holds a force for so long, s.
    ///
    /// # Errors
    /// Nobody may listen there.
    pub fn start(at: SocketAddr, hand: Hand<3>, holds_s: f64) -> std::io::Result<Self> {
        let listener = TcpListener::bind(at)?;
        let at = listener.local_addr()?;
        let asked = Asked::default();
        let world = World { hand, force_n: [0.0; 3], until_s: 0.0, holds_s, fault: Fault::None, asked };
        let world = Arc::new(Mutex::new(world));
        let served = world.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let _ = stream.set_nodelay(true);
                let served = served.clone();
                // One that says nothing keeps nobody else from it.
                std::thread::spawn(move || {
                    if let Ok(socket) = accept(stream) {
                        serve(socket, &served);
                    }
                });
            }
        });
        Ok(Self { at, world })
    }

    /// Its world, which stands still while this is held.
    pub fn world(&self) -> MutexGuard<'_, World> {
        locked(&self.world)
    }
}

impl Emulated for Emulator {
    fn words(&self) -> Vec<String> {
        let holds_s = self.world().holds_s.to_string();
        vec!["--device".to_owned(), format!("haply:{}", self.at), "--device-lets-go-s".to_owned(), holds_s]
    }

    fn plant(&self, fault: &str) -> Option<f64> {
        named(&FAULTS, fault).map(|fault| self.world().fail(fault))
    }

    fn look(&self) -> Seen {
        let mut world = self.world();
        let force_n = world.advance().to_vec();
        Seen {
            time_s: world.time_s(),
            place_m: world.hand.position_m.to_vec(),
            force_n,
            orders: world.asked.count(),
            last_push_s: world.asked.last_push_s(),
        }
    }
}

/// Serves one client until its line is closed, or until the service closes it.
fn serve(mut socket: WebSocket<TcpStream>, world: &Mutex<World>) {
    let first = locked(world).told();
    let _ = socket.send(Message::text(first.to_string()));
    while let Ok(message) = socket.read() {
        let heard: Value = serde_json::from_str(message.to_text().unwrap_or_default()).unwrap_or_default();
        let device = &heard["inverse3"][0];
        if device.is_null() {
            continue;
        }
        let vector = &device["commands"]["set_cursor_force"]["vector"];
        let (fault, told) = {
            let mut world = locked(world);
            world.advance();
            world.hand.wake();
            if let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(|axis| vector[axis].as_f64()) {
                let now_s = world.time_s();
                (world.force_n, world.until_s) = ([x, y, z], now_s + world.holds_s);
                world.asked.push(now_s, [x, y, z]);
            }
            (world.fault, world.told())
        };
        let text = match fault {
            Fault::Silent => continue,
            Fault::Closes => break,
            Fault::Preset if !device["configure"].is_null() => json!({ "session_id": 7, "error": "unknown preset" }),
            _ => told,
        };
        if fault == Fault::Late {
            std::thread::sleep(Duration::from_millis(100));
        }
        for _ in 0..if fault == Fault::Unasked { 2 } else { 1 } {
            let _ = socket.send(Message::text(text.to_string()));
        }
    }
}
