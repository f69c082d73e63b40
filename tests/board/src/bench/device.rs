//! A device on a board: cohold's plant behind the board's encoders and bridges.

use std::sync::{Arc, Mutex, MutexGuard};

use cohold_core::device::motor::Duty;
use cohold_core::device::velocity::VelocityName;
use cohold_core::names::MotorDrive;
use cohold_sim::scene::Scene;

use crate::part::motors::{Act, Motors, has_loop};
use crate::part::{Bridges, MOTORS};

/// PWM steps from no voltage to all of it on the board (firmware/src/board/bridges.rs).
pub const PWM_STEPS: u32 = 6000;
/// The same from no current of an amplifier to all of it: one leg alone.
pub const AMPLIFIER_STEPS: u32 = PWM_STEPS / 2;

/// What a scene is configured with for devices with windings, their motors in current loops.
pub const CURRENT_LOOP: [&str; 4] =
    ["plant.encoder=true", "plant.motor=true", "plant.winding=true", "plant.drive=current"];

/// The scene as boards can run it: encoders for sensors, duties for motors, PWM in the board's steps.
pub fn for_boards(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.world.plant.encoder = true;
    scene.world.plant.motor = true;
    scene.world.plant.pwm_steps = if has_loop(&scene) { PWM_STEPS } else { AMPLIFIER_STEPS };
    scene.world.plant.current_bits = 16;
    scene.peer.motor.drive = if has_loop(&scene) { MotorDrive::CurrentLoop } else { MotorDrive::Amplifier };
    if scene.peer.axis.velocity == VelocityName::Measured {
        scene.peer.axis.velocity = VelocityName::Filtered;
    }
    scene
}

/// A device on a board: the bench's, or the node's that runs the board.
#[derive(Clone)]
pub(super) struct Device(Arc<Mutex<Motors>>);

impl Device {
    /// Of a peer of the scene, its encoders where they are when power comes on.
    pub(super) fn new(scene: &Scene, index: usize) -> Self {
        Self(Arc::new(Mutex::new(Motors::new(scene, index))))
    }

    /// At `counts`, wherever it would be by itself.
    pub(super) fn at(scene: &Scene, index: usize, counts: [i64; MOTORS]) -> Self {
        let device = Self::new(scene, index);
        device.motors().act(Act::At(counts));
        device
    }

    pub(super) fn motors(&self) -> MutexGuard<'_, Motors> {
        self.0.lock().expect("nobody panics with it")
    }

    /// What a board's node is given of it: what moves by itself.
    pub(super) fn stage(&self) -> Option<Arc<Mutex<Motors>>> {
        self.motors().has_stage().then(|| self.0.clone())
    }

    /// One period under what the bridges are commanded, and where its encoders are then; one that moves by itself does so from the next tick on, which
    /// is after `begins_ns`.
    pub(super) fn step(&self, time_s: f64, bridges: &Bridges, begins_ns: u64) -> Option<[i64; MOTORS]> {
        let mut motors = self.motors();
        if motors.has_stage() {
            motors.act(Act::Moves(begins_ns, time_s));
            return None;
        }
        let (duties, enable) = if bridges.by_controller {
            (motors.duties(bridges.torque_nm.unwrap_or(0.0)), bridges.torque_nm.is_some())
        } else {
            (duties(bridges), bridges.currents().is_some())
        };
        Some(motors.step(time_s, duties, enable))
    }
}

/// The duties that give what amplifiers are commanded, to half a step.
pub fn duties(bridges: &Bridges) -> [Duty; MOTORS] {
    let duty = |share: f64| Duty((share * f64::from(Duty::FULL_SCALE)).round() as i16);
    bridges.currents().map_or([Duty::OFF; MOTORS], |currents| currents.map(duty))
}
