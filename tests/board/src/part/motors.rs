//! A device at a board's bridges: cohold's plant, and its motors where it has windings.
//!
//! With windings ([`Motors::period`]) the node that runs the board calls it at every update of the bridges' timer, so that voltage, current,
//! force, motion and back-EMF go round within the PWM period, by the very functions that cohold's own drive calls. It is made in the process of
//! that node ([`Made`]), where everything is done to it that the bench does here ([`Act`]), and the bench knows of it what it says at a stop
//! ([`Felt`]). Without, the bench moves it once a control period under the duties that the bridges are commanded ([`Motors::step`]).

use cohold_core::device::encoder::Counts;
use cohold_core::device::kinematics::KinematicsName;
use cohold_core::device::{AXES, Reading, motor::Duty};
use cohold_core::names::Choice;
use cohold_core::num::Motion;
use cohold_core::peer::Actuators;
use cohold_sim::Laws;
use cohold_sim::plant::{Held, Plant};
use cohold_sim::scene::{DriveName, PlantFault, Scene};
use serde::{Deserialize, Serialize};

use super::{Bridges, MOTORS};

/// What moves: a device of one or two motors, or of three.
#[derive(Clone, Debug)]
enum Body {
    Plane(Box<Plant>),
    Space(Box<Plant<3>>),
}

/// What its `N` encoders read.
fn read<const N: usize>(plant: &Plant<N>) -> [u16; MOTORS] {
    let Reading::Counts(counts) = plant.sensors::<f32>().reading else {
        panic!("a device on a board has encoders: see for_boards");
    };
    core::array::from_fn(|joint| counts.get(joint).map_or(0, |Counts(count)| *count))
}

/// A control period of it.
fn step<const N: usize>(plant: &mut Plant<N>, time_s: f64, duties: [Duty; MOTORS], enable: bool) {
    let duties = core::array::from_fn(|joint| duties[joint]);
    plant.step(time_s, &Actuators::<f32, N> { duties, enable, ..Actuators::default() });
}

/// A scene, key by key, and which of its peers.
pub type Made = (Vec<String>, usize);

/// Where the encoders are, how fast it moves along its first axis, m/s, and the supply of the bridges, V.
pub type Felt = ([i64; MOTORS], f64, f64);

/// What is done to a device.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub enum Act {
    /// Its encoders are there, wherever it would be by itself.
    At([i64; MOTORS]),
    /// It is moved so far along its first axis, m, and stands there.
    Carry(f64),
    /// The control period that begins after an instant (ns) is the one at this time of the scene (s); before the first of these nothing moves.
    Moves(u64, f64),
    /// The emergency stop's second contact opens, or closes.
    Cut(bool),
    /// Something goes wrong with its first joint: which of [`PlantFault::ALL`].
    Fails(usize),
}

/// The device behind a board's bridges.
#[derive(Clone, Debug)]
pub struct Motors {
    /// What it is made of, and what was done to it that its board's node does not know of.
    pub made: Made,
    /// See [`Motors::made`].
    pub acts: Vec<Act>,
    body: Body,
    /// Where its encoders are, and the 16 bits that they last gave.
    pub counts: [i64; MOTORS],
    read: [u16; MOTORS],
    /// It has windings in a current loop.
    has_stage: bool,
    held: Option<Held>,
    /// From this instant on (ns) the device moves, as the scene has it at this time, s.
    next: Option<(u64, f64)>,
    /// Supply of the bridges, V, and what it is while the emergency stop's second contact is closed.
    supply_v: [f64; 2],
    /// That contact is open.
    cut: bool,
    /// A control period, s.
    period_s: f64,
    /// Torque at full current of a motor that turns as its controller counts, N·m.
    full_nm: f64,
}

/// Volts at the end of the converter's range, through the divider.
const SUPPLY_SPAN_V: f64 = 36.3;
/// By what a supply falls that is cut, s: 1000 µF and 2.2 kΩ.
const FALLS_S: f64 = 2.2;
/// A PWM period, s.
const PWM_S: f64 = 50e-6;

impl Motors {
    /// Of a peer of the scene, its encoders where they are when power comes on.
    pub fn new(scene: &Scene, index: usize) -> Self {
        let body = match scene.peer.axis.count {
            3.. => Body::Space(Box::new(Plant::build(scene, index))),
            _ => Body::Plane(Box::new(Plant::new(scene, index))),
        };
        let (has_stage, supply_v) = (has_loop(scene), [scene.world.plant.supply_v; 2]);
        let (motor, encoder) = (&scene.peer.motor, &scene.peer.encoder);
        // A slide is moved by a drum: as many metres a revolution as that has counts.
        let drum_m = if scene.peer.kinematics.model == KinematicsName::Direct {
            encoder.counts_per_rev / encoder.counts_per_m / std::f64::consts::TAU
        } else {
            1.0
        };
        let full_nm = motor.newton_or_newton_metre_per_a * motor.full_scale_a * drum_m;
        let (held, next, cut, counts, read) = (None, None, false, [0; MOTORS], [0; MOTORS]);
        let keys = scene.settings().into_iter().map(|(key, value)| format!("{key}={value}"));
        let (made, acts) = ((keys.collect(), index), Vec::new());
        let period_s = scene.peer.timing.control_period_s;
        let mut motors =
            Self { made, acts, body, counts, read, has_stage, held, next, supply_v, cut, period_s, full_nm };
        motors.turn();
        motors
    }

    /// Another, of what one was made of.
    ///
    /// # Panics
    /// No scene was.
    pub fn again((keys, index): &Made) -> Self {
        let mut scene = Scene::new(Laws::built_in());
        keys.iter().for_each(|key| scene.apply_override(key).expect("a key of a scene"));
        Self::new(&scene, *index)
    }

    /// Does this to it.
    pub fn act(&mut self, act: Act) {
        match act {
            Act::At(counts) => self.counts = counts,
            Act::Carry(metres) => {
                let motion = self.free_axis();
                *motion = Motion::at(motion.position + metres);
            }
            Act::Moves(begins_ns, time_s) => self.next = Some((begins_ns, time_s)),
            Act::Cut(cut) => self.cut = cut,
            Act::Fails(fault) => match &mut self.body {
                Body::Plane(plant) => plant.fail(PlantFault::ALL[fault]),
                Body::Space(plant) => plant.fail(PlantFault::ALL[fault]),
            },
        }
        self.acts.push(act);
    }

    /// What there is to say of it.
    pub fn felt(&mut self) -> Felt {
        (self.counts, self.speed(), self.supply_v())
    }

    /// It is as that in its board's node is.
    pub fn feel(&mut self, (counts, speed, supply_v): Felt) {
        (self.counts, self.free_axis().velocity, self.supply_v[0]) = (counts, speed, supply_v);
    }

    /// Supply of the bridges, V.
    pub fn supply_v(&self) -> f64 {
        self.supply_v[0]
    }

    /// The supply after so many seconds more.
    fn feed(&mut self, seconds: f64) {
        let [now_v, full_v] = &mut self.supply_v;
        if !self.cut && now_v == full_v {
            return;
        }
        *now_v = if self.cut { *now_v * (-seconds / FALLS_S).exp() } else { *full_v };
        if let Body::Plane(plant) = &mut self.body {
            plant.set_supply(*now_v);
        }
    }

    /// It moves by itself, PWM period by PWM period.
    pub fn has_stage(&self) -> bool {
        self.has_stage
    }

    /// Where the encoders are now: the plant's 16-bit counts, unwrapped.
    fn turn(&mut self) -> [i64; MOTORS] {
        let counts = match &self.body {
            Body::Plane(plant) => read(plant),
            Body::Space(plant) => read(plant),
        };
        for ((whole, last), wrapped) in self.counts.iter_mut().zip(&mut self.read).zip(counts) {
            *whole += i64::from(wrapped.wrapping_sub(*last).cast_signed());
            *last = wrapped;
        }
        self.counts
    }

    /// One control period under these duties, without windings.
    pub fn step(&mut self, time_s: f64, duties: [Duty; MOTORS], enable: bool) -> [i64; MOTORS] {
        self.feed(self.period_s);
        match &mut self.body {
            Body::Plane(plant) => step(plant, time_s, duties, enable),
            Body::Space(plant) => step(plant, time_s, duties, enable),
        }
        self.turn()
    }

    /// The duties of which this torque of its first motor (N·m) is the share.
    pub fn duties(&self, torque_nm: f64) -> [Duty; MOTORS] {
        let code = torque_nm / self.full_nm * f64::from(Duty::FULL_SCALE);
        [Duty(code.round() as i16), Duty::OFF, Duty::OFF]
    }

    /// How fast it moves along its first axis, m/s.
    pub fn speed(&mut self) -> f64 {
        self.free_axis().velocity
    }

    /// Its motion along the first axis.
    fn free_axis(&mut self) -> &mut Motion<f64> {
        match &mut self.body {
            Body::Plane(plant) => plant.free_axis().0,
            Body::Space(plant) => plant.free_axis().0,
        }
    }

    /// The PWM period that begins now: what the converters' three inputs read at its beginning and in its middle, where the encoders are at its end, and
    /// what their counters say at the index if they pass it.
    ///
    /// # Panics
    /// It has three motors: a board with three has no current loop.
    pub fn period(&mut self, now_ns: u64, bridges: &Bridges) -> ([[u16; 3]; 2], [i64; MOTORS], [Option<u16>; MOTORS]) {
        self.feed(PWM_S);
        let Body::Plane(plant) = &mut self.body else { panic!("three motors, and windings") };
        if let Some((_, time_s)) = self.next.take_if(|(begins_ns, _)| *begins_ns <= now_ns) {
            self.held = plant.begin(time_s);
        }
        // To the nearest; a cast saturates.
        let supply = (plant.supply_v().unwrap_or(0.0) / SUPPLY_SPAN_V * 65536.0 + 0.5) as u16;
        let on = bridges.on() || bridges.outputs && plant.ignores_enable();
        let [first, second] = bridges.voltages().map(|voltage| on.then_some(voltage));
        let [one, two] = plant.period(self.held.as_ref(), [first, second]);
        let marks: [_; AXES] = plant.sensors::<f32>().marks.unwrap_or_default();
        let [first, second] = marks.map(|marks| marks.index.map(|Counts(index)| index));
        let indexes = [first, second, None];
        ([0, 1].map(|at| [one[at], two[at], supply]), self.turn(), indexes)
    }
}

/// The scene's device has windings in a current loop.
pub fn has_loop(scene: &Scene) -> bool {
    scene.world.plant.winding && scene.world.plant.drive == DriveName::Current
}
