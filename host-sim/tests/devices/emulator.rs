//! Haply's service as its clients see it, with a hand on an emulated Inverse3: lists its devices to whoever connects, then answers each
//! message with one state. Messages are those of the vendor's documentation and of its crate 1.3.1; how long a force stands is invented.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, accept};

use super::hand::{Hand, STEP_S};

/// For so long a force stands without a new one, s. The vendor says "applied once and forgotten", and no number.
pub(crate) const HOLDS_S: f64 = 0.02;
/// What the service can do wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Fault {
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
}

/// The mechanism with the hand on it, in the device's frame.
pub(crate) struct World {
    hand: Hand<3>,
    force_n: [f64; 3],
    until_s: f64,
    pub(crate) fault: Fault,
    /// Every force that was asked for, and when.
    pub(crate) asked: Vec<(f64, [f64; 3])>,
}

impl World {
    pub(crate) fn time_s(&self) -> f64 {
        self.hand.time_s()
    }

    /// Brings it to now; the force that acts then, N.
    pub(crate) fn advance(&mut self) -> [f64; 3] {
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
    pub(crate) fn reach(&mut self, reach_m: [f64; 3]) {
        self.hand.reach(reach_m);
    }

    /// Plants a fault; when, s.
    pub(crate) fn fail(&mut self, fault: Fault) -> f64 {
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
                "state": { "hall": 0, "buttons": { "a": false, "b": false, "c": false }, "battery_level": 0.9 } }],
        });
        if self.fault == Fault::Older {
            told.as_object_mut().expect("an object").remove("session_id");
        }
        told
    }
}

/// A service that listens, until the test ends.
pub(crate) struct Emulator {
    pub(crate) at: SocketAddr,
    world: Arc<Mutex<World>>,
}

impl Emulator {
    pub(crate) fn start(tremor_m: f64) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a socket on loopback");
        let at = listener.local_addr().expect("its address");
        let world = Arc::new(Mutex::new(World {
            hand: Hand::new(tremor_m),
            force_n: [0.0; 3],
            until_s: 0.0,
            fault: Fault::None,
            asked: Vec::new(),
        }));
        let served = world.clone();
        std::thread::spawn(move || {
            for stream in listener.incoming().flatten() {
                let _ = stream.set_nodelay(true);
                if let Ok(socket) = accept(stream) {
                    serve(socket, &served);
                }
            }
        });
        Self { at, world }
    }

    pub(crate) fn world(&self) -> MutexGuard<'_, World> {
        self.world.lock().expect("the emulator goes on")
    }
}

/// Serves one client until its line is closed, or until the service closes it.
fn serve(mut socket: WebSocket<TcpStream>, world: &Mutex<World>) {
    let first = world.lock().expect("the test goes on").told();
    let _ = socket.send(Message::text(first.to_string()));
    while let Ok(message) = socket.read() {
        let heard: Value = serde_json::from_str(message.to_text().unwrap_or_default()).unwrap_or_default();
        let device = &heard["inverse3"][0];
        let vector = &device["commands"]["set_cursor_force"]["vector"];
        let (fault, told) = {
            let mut world = world.lock().expect("the test goes on");
            world.advance();
            if let [Some(x), Some(y), Some(z)] = ["x", "y", "z"].map(|axis| vector[axis].as_f64()) {
                let now_s = world.time_s();
                (world.force_n, world.until_s) = ([x, y, z], now_s + HOLDS_S);
                world.asked.push((now_s, [x, y, z]));
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
        let _ = socket.send(Message::text(text.to_string()));
    }
}
