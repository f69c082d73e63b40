//! A device on a board: host-sim's plant behind the board's encoders and bridges.

use haptic_core::device::encoder::Counts;
use haptic_core::device::motor::Duty;
use haptic_core::device::velocity::VelocityName;
use haptic_core::device::{AXES, Reading};
use haptic_core::peer::Actuators;
use haptic_sim::plant::Plant;
use haptic_sim::scene::Scene;

use crate::part::Bridges;

/// PWM steps from zero to full duty on the board (firmware/src/board/bridges.rs).
pub const PWM_STEPS: u32 = 3000;

/// The scene as boards can run it: encoders for sensors, duties for motors, PWM in the board's steps.
pub fn for_boards(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.world.plant.encoder = true;
    scene.world.plant.motor = true;
    scene.world.plant.pwm_steps = PWM_STEPS;
    if scene.peer.axis.velocity == VelocityName::Measured {
        scene.peer.axis.velocity = VelocityName::Filtered;
    }
    scene
}

/// A device on a board.
pub(super) struct Device {
    pub(super) plant: Plant,
    /// Where its encoders are, and the 16 bits that they last gave.
    pub(super) counts: [i64; AXES],
    read: [u16; AXES],
}

impl Device {
    /// At `counts`, as the encoders are when power comes on.
    pub(super) fn new(plant: Plant) -> Self {
        Self { plant, counts: [0; AXES], read: [0; AXES] }
    }

    /// At `counts`, wherever it would be by itself.
    pub(super) fn at(plant: Plant, counts: [i64; AXES]) -> Self {
        let mut device = Self::new(plant);
        device.turn();
        Self { counts, ..device }
    }

    /// Where the encoders are now: the plant's 16-bit counts, unwrapped.
    pub(super) fn turn(&mut self) -> [i64; AXES] {
        let Reading::Counts(counts) = self.plant.sensors::<f32>().reading else {
            panic!("a device on a board has encoders: see for_boards");
        };
        for ((whole, last), Counts(wrapped)) in self.counts.iter_mut().zip(&mut self.read).zip(counts) {
            *whole += i64::from(wrapped.wrapping_sub(*last).cast_signed());
            *last = wrapped;
        }
        self.counts
    }

    /// One period under what the bridges are told.
    pub(super) fn step(&mut self, time_s: f64, bridges: &Bridges) -> [i64; AXES] {
        let actuators: Actuators<f32> =
            Actuators { duties: duties(bridges), enable: bridges.on(), ..Actuators::default() };
        self.plant.step(time_s, &actuators);
        self.turn()
    }
}

/// The duties that give what the bridges are told, to half a step.
pub fn duties(bridges: &Bridges) -> [Duty; AXES] {
    bridges.compare.map(|compare| {
        let steps = i32::from(compare) - i32::from(bridges.period / 2);
        let full = f64::from(Duty::FULL_SCALE);
        let duty = (f64::from(steps) * full / f64::from(PWM_STEPS)).round();
        if bridges.on() { Duty(duty as i16) } else { Duty::OFF }
    })
}
