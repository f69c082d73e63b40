//! Haply's service as its clients see it, with a hand on an emulated Inverse3: lists its devices to whoever connects, then answers each
//! message with one state. Messages are those of the vendor's documentation and of its crate 1.3.1; how long a force stands is invented.

use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, accept};

/// For so long a force stands without a new one, s. The vendor says "applied once and forgotten", and no number.
pub(crate) const HOLDS_S: f64 = 0.02;
/// What moves with the hand, kg, and the hand: N/m, N·s/m.
const MASS_KG: f64 = 0.3;
pub(crate) const HAND_N_PER_M: f64 = 300.0;
const HAND_N_S_PER_M: f64 = 8.0;
/// Step of the mechanism, s.
const STEP_S: f64 = 50e-6;
/// How often a hand trembles, Hz.
const TREMOR_HZ: f64 = 1.0;
/// How long it takes to reach, s.
const REACH_S: f64 = 1.0;

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
    /// Its device is no longer calibrated.
    Uncalibrated,
    /// It is older than 3.5.
    Older,
    /// It does not know the preset.
    Preset,
}

/// The mechanism with the hand on it, in the device's frame.
pub(crate) struct World {
    start: Instant,
    now_s: f64,
    position_m: [f64; 3],
    velocity_m_per_s: [f64; 3],
    force_n: [f64; 3],
    until_s: f64,
    /// How far the hand trembles along each axis until it reaches, m.
    tremor_m: f64,
    /// Where the hand reaches, m, and since when, s.
    reach: Option<([f64; 3], f64)>,
    pub(crate) fault: Fault,
    /// Every force that was asked for, and when.
    pub(crate) asked: Vec<(f64, [f64; 3])>,
}

impl World {
    pub(crate) fn time_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Where the hand wants to be along an axis, m.
    fn wanted(&self, axis: usize) -> f64 {
        let tremor_m = self.tremor_m * (std::f64::consts::TAU * TREMOR_HZ * self.now_s).sin();
        let Some((reach_m, since_s)) = self.reach else { return tremor_m };
        let share = ((self.now_s - since_s) / REACH_S).clamp(0.0, 1.0);
        // Of least jerk; a hand that reaches trembles no more.
        let gone = share.powi(3) * (10.0 - 15.0 * share + 6.0 * share * share);
        gone * reach_m[axis] + (1.0 - gone) * tremor_m
    }

    /// Brings it to now; the force that acts then, N.
    pub(crate) fn advance(&mut self) -> [f64; 3] {
        let now_s = self.time_s();
        while self.now_s < now_s {
            self.now_s += STEP_S;
            if self.now_s >= self.until_s {
                self.force_n = [0.0; 3];
            }
            for axis in 0..3 {
                let spring_n = HAND_N_PER_M * (self.wanted(axis) - self.position_m[axis]);
                let force_n = self.force_n[axis] + spring_n - HAND_N_S_PER_M * self.velocity_m_per_s[axis];
                self.velocity_m_per_s[axis] += STEP_S * force_n / MASS_KG;
                self.position_m[axis] += STEP_S * self.velocity_m_per_s[axis];
            }
        }
        self.force_n
    }

    /// The hand begins to reach there.
    pub(crate) fn reach(&mut self, reach_m: [f64; 3]) {
        self.reach = Some((reach_m, self.time_s()));
    }

    /// Plants a fault; when, s.
    pub(crate) fn fail(&mut self, fault: Fault) -> f64 {
        self.fault = fault;
        self.time_s()
    }

    fn told(&self) -> Value {
        let off_m = if self.fault == Fault::Jump { 0.05 } else { 0.0 };
        let at = |axis: usize| {
            if self.fault == Fault::NotANumber { json!(null) } else { json!(self.position_m[axis] + off_m) }
        };
        let xyz = |of: [f64; 3]| json!({ "x": of[0], "y": of[1], "z": of[2] });
        let mut told = json!({
            "session_id": 7,
            "inverse3": [{
                "device_id": "049D",
                "state": {
                    "cursor_position": { "x": at(0), "y": at(1), "z": at(2) },
                    "cursor_velocity": xyz(self.velocity_m_per_s), "current_cursor_force": xyz(self.force_n),
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
            start: Instant::now(),
            now_s: 0.0,
            position_m: [0.0; 3],
            velocity_m_per_s: [0.0; 3],
            force_n: [0.0; 3],
            until_s: 0.0,
            tremor_m,
            reach: None,
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
