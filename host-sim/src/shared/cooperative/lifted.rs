//! The lifted matrix of a cooperative environment: what one packet period makes of it, while packets are only late.
//!
//! Devices, contacts and engine are those that run ([`super::world`]), put into unit states one after the other; what
//! the packets do is said anew: a state of the object and a push stand from the tick that they arrive in to the next packet.
//! Contact is at the clients. Gains are what the bounder has left, and constant. Limits, and the rounding of packets to f32,
//! are not part of it.
//!
//! **Order of the state**: position, velocity and motor force of every device; the object; its states on the way down, newest
//! first; every client's pushes on the way up, newest first. Units: m, m/s, N.

use haptic_core::contact::Contact;
use haptic_core::contact::bounder::Bound;
use haptic_core::device::AXES;
use haptic_core::num::Motion;
use haptic_core::peer::Actuators;

use super::engine::{DynamicsEngine, Pushed};
use super::world::World;
use haptic_analysis::Lifted;
use haptic_analysis::Matrix;
use haptic_analysis::delays_packets;
use haptic_analysis::{Analyser, AnalysisError, Verdict};
use haptic_sim::plant::Plant;
use haptic_sim::scene::Scene;

/// States of a device: position, velocity, motor force of the tick before.
const DEVICE_STATES: usize = 3;

/// A client and its way to the engine.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// Its contact, and the drag that the object has for its sake.
    pub gains: Bound<f64>,
    /// Packet periods that a push takes to the engine and a state takes back; `None` where the engine is at this client.
    pub delay_packets: Option<[usize; 2]>,
}

/// The clients of a world as it stands, in the scene that it was made from: its bounders' gains, its engine's place.
pub fn lines(world: &World, scene: &Scene) -> Vec<Line> {
    let [down, up] = delays_packets(&scene.linear());
    let holder = world.holders().first().copied().unwrap_or(0);
    let line = |(number, gains)| Line {
        gains,
        delay_packets: match holder {
            0 => Some([up, down]),
            _ if holder == number => None,
            // By way of the server, which passes on what has come with its next packet.
            _ => Some([up + 1 + down; 2]),
        },
    };
    (1..).zip(world.clients().map(|client| client.bound)).map(line).collect()
}

/// The verdict on one packet period of these clients in the linear scene behind this one.
pub fn verdict(scene: &Scene, lines: &[Line]) -> Result<Verdict, AnalysisError> {
    let mut period = Period::new(&scene.linear(), lines);
    let size = period.state.len();
    let mut matrix = Matrix::zeros(size, size);
    for at in 0..size {
        period.state.fill(0.0);
        period.state[at] = 1.0;
        period.pass();
        matrix.col_as_slice_mut(at).copy_from_slice(&period.state);
    }
    // Without a spring to any arm everything together can stand anywhere.
    let free = scene.users.iter().all(|user| user.settings.user.arm_stiffness_n_per_m == 0.0);
    let rest_modes = if free { vec![period.translation()] } else { Vec::new() };
    let devices: Vec<usize> = (0..lines.len()).map(|client| DEVICE_STATES * client).collect();
    Analyser::default().judge(Lifted { matrix, rest_modes }, &devices)
}

/// A client of the period.
struct Seat {
    plant: Plant,
    contact: Contact<f64>,
    line: Line,
}

/// One packet period, and the state that it starts from and leaves.
struct Period {
    seats: Vec<Seat>,
    engine: DynamicsEngine,
    ticks: u32,
    /// Longest way down, packets.
    down: usize,
    state: Vec<f64>,
}

impl Period {
    fn new(linear: &Scene, lines: &[Line]) -> Self {
        let settings = linear.peers();
        let seat = |(index, line): (usize, &Line)| Seat {
            plant: Plant::new(linear, index % 2),
            contact: Contact::build(&settings[index % 2]).with_gains(line.gains.stiffness, line.gains.damping),
            line: *line,
        };
        let down = lines.iter().filter_map(|line| line.delay_packets).map(|[_, down]| down).max().unwrap_or(0);
        let up: usize = lines.iter().filter_map(|line| line.delay_packets).map(|[up, _]| up).sum();
        let mut engine = DynamicsEngine::new(&settings[0]);
        for (user, line) in engine.users.iter_mut().zip(lines) {
            *user = Pushed { drag_n_s_per_m: line.gains.drag, ..Pushed::default() };
        }
        Self {
            seats: lines.iter().enumerate().map(seat).collect(),
            engine,
            ticks: linear.peer.timing.ticks_per_packet,
            down,
            state: vec![0.0; DEVICE_STATES * lines.len() + 2 * (1 + down) + up],
        }
    }

    /// Everything one metre away.
    fn translation(&self) -> Vec<f64> {
        let (devices, motions) = (DEVICE_STATES * self.seats.len(), 2 * (1 + self.down));
        let place = |at: usize| match at.checked_sub(devices) {
            None => at.is_multiple_of(DEVICE_STATES),
            Some(at) => at < motions && at.is_multiple_of(2),
        };
        (0..self.state.len()).map(|at| f64::from(u8::from(place(at)))).collect()
    }

    /// Takes everything through one packet period.
    fn pass(&mut self) {
        let (devices, rest) = self.state.split_at_mut(DEVICE_STATES * self.seats.len());
        let (motions, mut pushes) = rest.split_at_mut(2 * (1 + self.down));
        let mut told: Vec<Motion<f64>> =
            motions.chunks_exact(2).map(|at| Motion { position: at[0], velocity: at[1] }).collect();
        self.engine.take_over(told[0]);
        for (seat, state) in self.seats.iter_mut().zip(devices.chunks_exact(DEVICE_STATES)) {
            let (motion, motor) = seat.plant.free_axis();
            (motion.position, motion.velocity, *motor) = (state[0], state[1], state[2]);
        }
        for tick in 0..self.ticks {
            for (seat, user) in self.seats.iter_mut().zip(&mut self.engine.users) {
                let object = seat.line.delay_packets.map_or(self.engine.object, |[_, down]| told[down]);
                let force_n = seat.contact.force(*seat.plant.free_axis().0, object);
                match seat.line.delay_packets {
                    None => user.force_n = force_n,
                    Some([up, _]) if tick == 0 => {
                        let (own, others) = std::mem::take(&mut pushes).split_at_mut(up);
                        pushes = others;
                        user.force_n = own.last().copied().unwrap_or(force_n);
                        own.rotate_right(usize::from(up > 0));
                        if let Some(newest) = own.first_mut() {
                            *newest = force_n;
                        }
                    }
                    Some(_) => {}
                }
                let mut forces = [0.0; AXES];
                forces[0] = -force_n;
                seat.plant.step(0.0, &Actuators { forces, enable: true, ..Actuators::<f64>::default() });
            }
            self.engine.step();
        }
        for (seat, state) in self.seats.iter_mut().zip(devices.chunks_exact_mut(DEVICE_STATES)) {
            let (motion, motor) = seat.plant.free_axis();
            state.copy_from_slice(&[motion.position, motion.velocity, *motor]);
        }
        // What was newest is one packet older.
        told.rotate_right(1);
        let after = std::iter::once(self.engine.object).chain(told.into_iter().skip(1));
        for (at, motion) in motions.chunks_exact_mut(2).zip(after) {
            at.copy_from_slice(&[motion.position, motion.velocity]);
        }
    }
}

#[cfg(test)]
mod tests {
    use haptic_core::contact::bounder::Bounder;

    use super::super::limits::rendering;
    use super::super::{Engine, Setup};
    use super::*;
    use haptic_analysis::rendering::Renderer;

    fn setup(one_way_s: f64, keys: &[&str]) -> Setup {
        let keys = [keys, &["safety.max_force_n=200", "safety.max_slew_n_per_s=1000000"]].concat();
        Setup { bounder: false, ..Setup::base(one_way_s, &keys).expect("a good scene") }
    }

    fn radius(setup: &Setup, lines: &[Line]) -> f64 {
        verdict(&setup.scene, lines).expect("eigenvalues").spectral_radius
    }

    /// With a packet each tick, two equal users are the sampled map of one device at half of the object, which shares no
    /// code with this, and the same of one at an object that rests. Gains as the bounder would have them, and unbounded.
    #[test]
    fn with_a_packet_each_tick_it_is_the_map_of_one_device_and_one_object() {
        let mut renderer = Renderer::default();
        for ticks in [0_usize, 1, 4, 15] {
            let setup = setup(1e-3 * ticks as f64, &["contact.damping_n_s_per_m=3"]);
            let bounded = Bounder::new(1000.0, 3.0, 5.0, 1e-3).bound(2e-3 * ticks as f64);
            for gains in [Bound { stiffness: 1000.0, damping: 3.0, drag: 0.0 }, bounded] {
                let got = radius(&setup, &[Line { gains, delay_packets: Some([ticks, ticks]) }; 2]);
                let mut alike = rendering(&setup, 2e-3 * ticks as f64, gains.drag);
                alike.contact_damping_n_s_per_m = gains.damping;
                let rests = haptic_analysis::rendering::Rendering { object: None, ..alike };
                // The engine takes drag implicitly, the map exactly.
                let within = if gains.drag > 0.0 { 2e-3 } else { 1e-9 };
                let wanted = [alike, rests].map(|map| renderer.radius(&map, gains.stiffness).expect("eigenvalues"));
                let wanted = wanted[0].max(wanted[1]);
                assert!((got - wanted).abs() < within, "{ticks} ticks, {gains:?}: {got} is not {wanted}");
            }
        }
    }

    /// Slow packets, delay, an engine at either end: what a strike leaves grows in the simulated world as the eigenvalue says.
    #[test]
    fn the_world_grows_as_the_eigenvalue_says() {
        for (packet_ms, one_way_ms, stiffness, engine) in [
            (8_u64, 0.0, 690, Engine::Server),
            (8, 5.0, 150, Engine::Server),
            (4, 10.0, 150, Engine::Server),
            (8, 12.0, 50, Engine::Client),
            (8, 40.0, 50, Engine::Client),
        ] {
            let (packets, stiffness) =
                (format!("timing.ticks_per_packet={packet_ms}"), format!("contact.stiffness_n_per_m={stiffness}"));
            let strike = [
                "contact.damping_n_s_per_m=0",
                "user.1.pulse_n=0.01",
                "user.1.pulse_s=0.01",
                "user.1.pulse_every_s=1000",
            ];
            let keys = [&[packets.as_str(), &stiffness][..], &strike].concat();
            let setup = Setup { engine, ..setup(1e-3 * one_way_ms, &keys) };
            let mut world = World::new(&setup).expect("a good scene");
            let mut largest = [0.0_f64; 2];
            // Long against an oscillation.
            let window = 400 * packet_ms;
            for tick in 0..3 * window {
                if engine == Engine::Client {
                    world.ask();
                }
                world.step();
                if let Some(at) = (tick / window).checked_sub(1) {
                    largest[at as usize] =
                        world.forces().fold(largest[at as usize], |most, force| most.max(force.abs()));
                }
            }
            assert!(world.clients().all(|client| client.fault.is_none()) && largest[1] < 150.0, "{largest:?}");
            let grew = (largest[1] / largest[0]).ln() / 400.0;
            let wanted = radius(&setup, &lines(&world, &setup.scene)).ln();
            let what = format!("{packet_ms} ms, {one_way_ms} ms, {stiffness}: ln {grew:.5}, by eigenvalue {wanted:.5}");
            assert!(wanted > 0.002 && (grew / wanted - 1.0).abs() < 0.05, "{what}");
        }
    }
}
