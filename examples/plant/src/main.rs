//! A device of your own: a handle that a spring pulls home, stiffer the farther it is out, under the peer that flies.
//!
//! Whatever reads and moves is a [`Device`]; [`Pair::with_devices`] puts two of them under the peers of a scene. Prints where the shared
//! object comes to rest.

use std::error::Error;

use cohold_core::device::Reading;
use cohold_core::num::Motion;
use cohold_core::peer::{Actuators, Sensors};
use cohold_sim::{Device, Laws, Pair, Scene};

/// Control period, s.
const PERIOD_S: f64 = 1e-3;

/// A hand on a handle that a hardening spring pulls home.
struct Handle {
    motion: Motion<f64>,
    push_n: f64,
}

impl Handle {
    /// One control period under the motor force, by semi-implicit Euler.
    fn advance(&mut self, motor_n: f64) {
        const MASS_KG: f64 = 0.1;
        const DAMPING_N_S_PER_M: f64 = 1.0;
        let spring_n = -(20.0 + 4e3 * self.motion.position.abs()) * self.motion.position;
        let force_n = motor_n + self.push_n + spring_n - DAMPING_N_S_PER_M * self.motion.velocity;
        self.motion.velocity += PERIOD_S / MASS_KG * force_n;
        self.motion.position += PERIOD_S * self.motion.velocity;
    }
}

impl Device<f32> for Handle {
    fn sensors(&self) -> Sensors<f32> {
        let Motion { position, velocity } = self.motion;
        let free = Motion { position: position as f32, velocity: velocity as f32 };
        Sensors::of(Reading::Exact([free, Motion::REST]))
    }

    fn step(&mut self, _: f64, actuators: &Actuators<f32>) {
        self.advance(f64::from(actuators.forces[0]));
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::load(Laws::built_in(), None, &["coordination.stiffness_n_per_m=500".to_owned()])?;
    let handles = [2.0, -1.0].map(|push_n| Handle { motion: Motion::REST, push_n });
    let mut pair: Pair<f32, Handle> = Pair::with_devices(&scene, handles)?;
    (0..20_000).for_each(|_| pair.step());
    assert_eq!(pair.fault(), None, "a peer has stopped");
    for (number, side) in (1..).zip(pair.sides()) {
        let (object, handle) = (side.peer.observed()[0].object.position, side.plant.motion.position);
        println!("peer {number}: object at {:.3} mm, handle at {:.3} mm", 1e3 * object, 1e3 * handle);
    }
    Ok(())
}
