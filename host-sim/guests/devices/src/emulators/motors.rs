//! Motors on a bus that turn the joints of a five-bar, with a hand at its tip: what emulated moteus and MIT motors share.
//!
//! The joints' angles are from the hand's place by inverse kinematics (two triangles), and the force of torques on it is by virtual work,
//! F = Σ τ·∂q/∂x, with differences: neither is the forward kinematics that the peer computes.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard};

use super::asked::Asked;
use super::carrier::{Place, Served, carry};
use super::hand::{Hand, STEP_S};
use super::{Emulated, Seen, locked, named};

/// The second motor turns against its joint.
const MOTORS: &str = "1,-2";
/// The largest torque that a peer may ask of each, N·m.
const MOST_NM: &str = "1.5";

/// The linkage of the scene `plane`, m and rad.
const BASE_M: f64 = 0.06;
const PROXIMAL_M: f64 = 0.1;
const DISTAL_M: f64 = 0.14;
const HOME_RAD: [f64; 2] = [2.4, std::f64::consts::FRAC_PI_3];
/// Step of differences, m.
const DIFFERENCE_M: f64 = 1e-6;

/// What motors and their bus can do wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Fault {
    /// Nothing.
    #[default]
    None,
    /// They hear and say nothing.
    Silent,
    /// They answer 0.1 s late.
    Late,
    /// They tell places that are not numbers.
    NotANumber,
    /// The second tells an angle 0.5 rad off.
    Jump,
    /// Torques turn the other way.
    WrongSign,
    /// The first is too warm.
    TooWarm,
    /// The supply of the first is too high.
    OverVoltage,
    /// The bus is gone.
    Unplugged,
    /// No motor lets go by itself, though it says so.
    NoWatchdog,
    /// None does, and says so.
    Never,
    /// They hold their position after their watchdog.
    Holds,
    /// They do not know where their output is.
    Relative,
    /// They are set up for other ranges.
    OtherRanges,
    /// They are set up for another kind of command.
    OtherMode,
    /// They hear frames with flexible data rate only.
    Flexible,
}

/// A motor: its torque, and until when that stands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motor {
    pub(crate) torque_nm: f64,
    /// Never of one that is off.
    pub(crate) until_s: f64,
    /// Its own number of what it does.
    pub(crate) mode: u8,
}

/// Two motors, their linkage, and the hand.
pub struct World {
    /// The hand at the tip.
    pub hand: Hand<2>,
    pub(crate) motors: [Motor; 2],
    /// +1 of a motor that turns counter-clockwise, as the linkage counts.
    signs: [f64; 2],
    /// Place of the tip at home, m.
    home_m: [f64; 2],
    /// Its number where a motor let go by itself.
    lets_go: u8,
    pub(crate) fault: Fault,
    /// Pairs of torques that were asked for, and when.
    pub asked: Asked<2>,
    /// Consoles tell of themselves what a viewer asked for once.
    pub streams: bool,
    /// A motor was asked to pull by itself, by gains or an integrator.
    pub pulled: bool,
}

/// Angles of the proximal links with the tip there, from the middle of the base: elbows outward.
fn inverse(tip_m: [f64; 2]) -> [f64; 2] {
    [-1.0, 1.0].map(|side| {
        let [x, y] = [tip_m[0] - side * 0.5 * BASE_M, tip_m[1]];
        let far = x.hypot(y);
        let between = (PROXIMAL_M.powi(2) + far.powi(2) - DISTAL_M.powi(2)) / (2.0 * PROXIMAL_M * far);
        y.atan2(x) - side * between.acos()
    })
}

/// Where the tip is at home: the farther end of the two distal links' circles.
fn home() -> [f64; 2] {
    let elbow = |side: f64, angle: f64| [side * 0.5 * BASE_M + PROXIMAL_M * angle.cos(), PROXIMAL_M * angle.sin()];
    let [left, right] = [elbow(-1.0, HOME_RAD[0]), elbow(1.0, HOME_RAD[1])];
    let [along, up] = [right[0] - left[0], right[1] - left[1]];
    let half = 0.5 * along.hypot(up);
    let height = (DISTAL_M.powi(2) - half.powi(2)).sqrt();
    [
        0.5 * (left[0] + right[0]) - up * height / (2.0 * half),
        0.5 * (left[1] + right[1]) + along * height / (2.0 * half),
    ]
}

impl World {
    pub(crate) fn shared(signs: [f64; 2], lets_go: u8, hand: Hand<2>) -> Arc<Mutex<Self>> {
        Arc::new(Mutex::new(Self {
            hand,
            motors: [Motor { torque_nm: 0.0, until_s: f64::INFINITY, mode: 0 }; 2],
            signs,
            home_m: home(),
            lets_go,
            fault: Fault::None,
            asked: Asked::default(),
            streams: true,
            pulled: false,
        }))
    }

    /// Angles of the motors with the hand there, rad from home.
    fn angles(&self, hand_m: [f64; 2]) -> [f64; 2] {
        let angles = inverse([0, 1].map(|axis| self.home_m[axis] + hand_m[axis]));
        [0, 1].map(|joint| self.signs[joint] * (angles[joint] - HOME_RAD[joint]))
    }

    /// How a motor's angle changes along each axis, rad/m.
    fn slopes(&self) -> [[f64; 2]; 2] {
        let at = self.hand.position_m;
        [0, 1].map(|axis| {
            let moved = |by: f64| self.angles(std::array::from_fn(|of| if of == axis { at[of] + by } else { at[of] }));
            let [before, after] = [moved(-DIFFERENCE_M), moved(DIFFERENCE_M)];
            [0, 1].map(|joint| (after[joint] - before[joint]) / (2.0 * DIFFERENCE_M))
        })
    }

    /// Angle (rad) and speed (rad/s) of a motor as it tells them.
    pub(crate) fn told(&self, joint: usize) -> [f64; 2] {
        if self.fault == Fault::NotANumber {
            return [f64::NAN; 2];
        }
        let off = if self.fault == Fault::Jump && joint == 1 { 0.5 } else { 0.0 };
        let slopes = self.slopes();
        let speed = (0..2).map(|axis| slopes[axis][joint] * self.hand.velocity_m_per_s[axis]).sum();
        [self.angles(self.hand.position_m)[joint] + off, speed]
    }

    /// Somebody has said something to a motor: brings it to now.
    pub(crate) fn hear(&mut self) {
        self.advance();
        self.hand.wake();
    }

    /// Brings it to now; the force that acts on the hand then, N.
    pub fn advance(&mut self) -> [f64; 2] {
        let now_s = self.hand.time_s();
        let sign = if self.fault == Fault::WrongSign { -1.0 } else { 1.0 };
        let mut force_n = self.force();
        while self.hand.now_s < now_s {
            let next_s = self.hand.now_s + STEP_S;
            for motor in &mut self.motors {
                if next_s >= motor.until_s && self.fault != Fault::NoWatchdog {
                    *motor = Motor { torque_nm: 0.0, until_s: f64::INFINITY, mode: self.lets_go };
                }
            }
            force_n = self.force();
            self.hand.step(force_n.map(|force| sign * force));
        }
        force_n
    }

    fn force(&self) -> [f64; 2] {
        if self.motors.iter().all(|motor| motor.torque_nm == 0.0) {
            return [0.0; 2];
        }
        let slopes = self.slopes();
        [0, 1].map(|axis| (0..2).map(|joint| self.motors[joint].torque_nm * slopes[axis][joint]).sum())
    }

    /// A motor is off, for this reason.
    pub(crate) fn off(&mut self, joint: usize, mode: u8) {
        self.ask(joint, mode, 0.0, f64::INFINITY);
    }

    /// A torque was asked for of a motor, until then.
    pub(crate) fn ask(&mut self, joint: usize, mode: u8, torque_nm: f64, until_s: f64) {
        self.motors[joint] = Motor { torque_nm, until_s, mode };
        let torques = self.motors.map(|motor| motor.torque_nm);
        self.asked.push(self.hand.time_s(), torques);
    }

    /// How it is now.
    pub(crate) fn look(&mut self) -> Seen {
        let force_n = self.advance().to_vec();
        Seen {
            time_s: self.hand.time_s(),
            place_m: self.hand.position_m.to_vec(),
            force_n,
            orders: self.asked.count(),
            last_push_s: self.asked.last_push_s(),
        }
    }

    /// Plants a fault; when, s.
    pub fn fail(&mut self, fault: Fault) -> f64 {
        self.fault = fault;
        self.hand.time_s()
    }
}

/// What an emulator's own protocol adds to it.
pub(crate) struct Protocol {
    /// The name of its adapter.
    pub(crate) name: &'static str,
    /// Flags of a peer's that it needs beside the motors'.
    pub(crate) flags: &'static [&'static str],
    pub(crate) faults: &'static [(&'static str, Fault)],
}

/// A bus with two motors, as long as the process lives.
pub struct Emulator {
    /// What `--device` opens.
    pub at: PathBuf,
    protocol: Protocol,
    world: Arc<Mutex<World>>,
    _bus: Served,
}

impl Emulator {
    /// On a bus there, motors that answer so to a frame.
    pub(crate) fn start(
        place: &Place,
        protocol: Protocol,
        world: Arc<Mutex<World>>,
        mut answers: impl FnMut(&mut World, u32, &[u8]) -> Option<(u32, Vec<u8>)> + Send + 'static,
    ) -> std::io::Result<Self> {
        let served = world.clone();
        let bus = carry(place, world.clone(), move |id, data| {
            let mut world = locked(&served);
            world.hear();
            answers(&mut world, id, data)
        })?;
        Ok(Self { at: bus.at.clone(), protocol, world, _bus: bus })
    }

    /// Its world, which stands still while this is held.
    pub fn world(&self) -> MutexGuard<'_, World> {
        locked(&self.world)
    }
}

impl Emulated for Emulator {
    fn words(&self) -> Vec<String> {
        let device = format!("{}:{}", self.protocol.name, self.at.display());
        let own = ["--device", &device, "--device-motors", MOTORS, "--device-max-torque-nm", MOST_NM];
        own.iter().chain(self.protocol.flags).map(|word| (*word).to_owned()).collect()
    }

    fn plant(&self, fault: &str) -> Option<f64> {
        named(self.protocol.faults, fault).map(|fault| self.world().fail(fault))
    }

    fn look(&self) -> Seen {
        self.world().look()
    }
}
