//! A device of your own: one with a spring that pulls it home, stiffer the farther it is out, under the peer that flies.
//!
//! [`Seat`] is an actor of the engine: a peer as the scene describes it, in front of your device instead of the built-in one.
//! The engine gives it its turns and carries its packets. Prints where the shared object comes to rest.

use std::error::Error;

use haptic_core::device::Reading;
use haptic_core::law::Packet;
use haptic_core::num::Motion;
use haptic_core::peer::{Actuators, Sensors};
use haptic_core::safety::{Command, Mode};
use haptic_sim::engine::{self, Actor, Engine, Out};
use haptic_sim::network::link::{Numbered, Route};
use haptic_sim::{DynPeer, Laws, Scene};

/// Control period, s.
const PERIOD_S: f64 = 1e-3;

/// A hand on a handle that a hardening spring pulls home.
struct Handle {
    motion: Motion<f64>,
    home_m: f64,
    push_n: f64,
}

impl Handle {
    /// One control period under the motor force, by semi-implicit Euler.
    fn step(&mut self, motor_n: f64) {
        const MASS_KG: f64 = 0.1;
        const DAMPING_N_S_PER_M: f64 = 1.0;
        let out_m = self.motion.position - self.home_m;
        let spring_n = -(20.0 + 4e3 * out_m.abs()) * out_m;
        let force_n = motor_n + self.push_n + spring_n - DAMPING_N_S_PER_M * self.motion.velocity;
        self.motion.velocity += PERIOD_S / MASS_KG * force_n;
        self.motion.position += PERIOD_S * self.motion.velocity;
    }
}

/// A peer in front of the handle.
struct Seat {
    number: usize,
    peer: Box<dyn DynPeer<f32>>,
    handle: Handle,
    heard: Option<Packet<f32>>,
    sent: u64,
}

impl Seat {
    fn new(scene: &Scene, number: usize) -> Result<Self, Box<dyn Error>> {
        let mut peer = scene.peer(number)?;
        peer.command(Command::Arm);
        let [motion, _] = scene.start(number);
        let push_n = if number == 0 { 2.0 } else { -1.0 };
        Ok(Self { number, peer, handle: Handle { motion, home_m: motion.position, push_n }, heard: None, sent: 0 })
    }
}

impl Actor<usize> for Seat {
    type Packet = Numbered<Packet<f32>>;

    fn hear(&mut self, _: u64, _: usize, packet: &mut Self::Packet, _: &mut Out<'_, usize, Self::Packet>) {
        self.heard = Some(packet.what);
    }

    fn speak(&mut self, _: u64, out: &mut Out<'_, usize, Self::Packet>) {
        if self.peer.packet_due() {
            if let Some(what) = self.peer.speak() {
                out(1 - self.number, &Numbered { number: self.sent, what });
            }
            self.sent += 1;
        }
    }

    fn act(&mut self, _: u64, _: &mut Out<'_, usize, Self::Packet>) {
        if let Some(packet) = self.heard.take() {
            self.peer.hear(packet);
        }
        if self.peer.packet_due() {
            self.peer.listen();
        }
        let Motion { position, velocity } = self.handle.motion;
        let reading = Reading::Exact([Motion { position: position as f32, velocity: velocity as f32 }, Motion::REST]);
        let Actuators { forces: [motor_n, _], .. } = self.peer.tick(&Sensors::of(reading));
        self.handle.step(f64::from(motor_n));
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let scene = Scene::load(Laws::built_in(), None, &["coordination.stiffness_n_per_m=500".to_owned()])?;
    let seats = vec![engine::Seat::new(Seat::new(&scene, 0)?), engine::Seat::new(Seat::new(&scene, 1)?)];
    // One packet period, 8 ms, either way.
    let mut engine = Engine::new(1_000_000, seats, |_, _| Route::new(8_000_000));
    (0..20_000).for_each(|_| engine.step(&mut |_| ()));
    for seat in &engine.seats {
        let Seat { number, peer, handle, .. } = &seat.actor;
        assert_eq!(peer.mode(), Mode::Armed, "a peer has stopped");
        let (object_mm, handle_mm) = (1e3 * peer.observed().object.position, 1e3 * handle.motion.position);
        println!("peer {}: object at {object_mm:.3} mm, handle at {handle_mm:.3} mm", number + 1);
    }
    Ok(())
}
