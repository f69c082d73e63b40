//! A device at a board's bridges: host-sim's plant, and its motors where it has windings.
//!
//! With windings ([`Motors::period`]) the node that runs the board calls it at every update of the bridges' timer, so that voltage, current,
//! force, motion and back-EMF go round within the PWM period, by the very functions that host-sim's own drive calls. Without, the bench
//! moves it once a control period under the duties that the bridges are told ([`Motors::step`]).

use haptic_core::device::encoder::Counts;
use haptic_core::device::{AXES, Reading};
use haptic_core::peer::Actuators;
use haptic_sim::plant::{Held, Plant};
use haptic_sim::scene::{DriveName, Scene};

use super::Bridges;

/// The device.
#[derive(Clone, Debug)]
pub struct Motors {
    /// What moves.
    pub plant: Plant,
    /// Where its encoders are, and the 16 bits that they last gave.
    pub counts: [i64; AXES],
    read: [u16; AXES],
    /// It has windings in a current loop.
    has_stage: bool,
    held: Option<Held>,
    /// From this instant on (ns) the device moves, as the scene has it at this time, s.
    next: Option<(u64, f64)>,
}

/// Volts at the end of the converter's range, through the divider.
const SUPPLY_SPAN_V: f64 = 36.3;

impl Motors {
    /// Of a peer of the scene, its encoders where they are when power comes on.
    pub fn new(scene: &Scene, index: usize) -> Self {
        let plant = Plant::new(scene, index);
        Self { plant, counts: [0; AXES], read: [0; AXES], has_stage: has_loop(scene), held: None, next: None }
    }

    /// It moves by itself, PWM period by PWM period.
    pub fn has_stage(&self) -> bool {
        self.has_stage
    }

    /// Where the encoders are now: the plant's 16-bit counts, unwrapped.
    pub fn turn(&mut self) -> [i64; AXES] {
        let Reading::Counts(counts) = self.plant.sensors::<f32>().reading else {
            panic!("a device on a board has encoders: see for_boards");
        };
        for ((whole, last), Counts(wrapped)) in self.counts.iter_mut().zip(&mut self.read).zip(counts) {
            *whole += i64::from(wrapped.wrapping_sub(*last).cast_signed());
            *last = wrapped;
        }
        self.counts
    }

    /// One control period under these duties, without windings.
    pub fn step(&mut self, time_s: f64, actuators: &Actuators<f32>) -> [i64; AXES] {
        self.plant.step(time_s, actuators);
        self.turn()
    }

    /// The control period that begins after `begins_ns` is the one at `time_s` of the scene; before the first of these nothing moves.
    pub fn moves(&mut self, begins_ns: u64, time_s: f64) {
        self.next = Some((begins_ns, time_s));
    }

    /// The PWM period that begins now: what the converter's three inputs read at its beginning, where the encoders are at its end, and
    /// what their counters say at the index if they pass it.
    pub fn period(&mut self, now_ns: u64, bridges: &Bridges) -> ([u16; 3], [i64; AXES], [Option<u16>; AXES]) {
        if let Some((_, time_s)) = self.next.take_if(|(begins_ns, _)| *begins_ns <= now_ns) {
            self.held = self.plant.begin(time_s);
        }
        let supply = self.plant.supply_v().unwrap_or(0.0) / SUPPLY_SPAN_V * 65536.0;
        let on = bridges.on() || bridges.outputs && self.plant.ignores_enable();
        let voltages = bridges.voltages().map(|voltage| on.then_some(voltage));
        let [one, two] = self.plant.period(self.held.as_ref(), voltages);
        let marks = self.plant.sensors::<f32>().marks.unwrap_or_default();
        let indexes = marks.map(|marks| marks.index.map(|Counts(index)| index));
        ([one, two, supply.round().clamp(0.0, 65535.0) as u16], self.turn(), indexes)
    }
}

/// The scene's device has windings in a current loop.
pub fn has_loop(scene: &Scene) -> bool {
    scene.world.plant.winding && scene.world.plant.drive == DriveName::Current
}
