//! The lifted matrix of a cooperative environment: what one packet period makes of it, while packets are only late.
//!
//! Devices, contacts and engine are those that run ([`super::world`]), put into unit states one after the other; what
//! the packets do is said anew: a state of the object and a push stand from the tick that they arrive in to the next packet.
//! Contact is at the clients. Gains are what the bounder has left, and constant. Limits, and the rounding of packets to f32,
//! are not part of it.
//!
//! **Order of the state**: position, velocity and motor force of every device; the object; its states on the way down, newest
//! first; every client's pushes on the way up, newest first. Units: m, m/s, N.

use cohold_analysis::{Analyser, Verdict};
use cohold_analysis::{Lifted, Matrix, delays_ticks};
use cohold_core::{contact::Contact, device::AXES, num::Motion, peer::Actuators};
use cohold_sim::{plant::Plant, scene::Scene};

use super::bounder::Bound;
use super::engine::{DynamicsEngine, Pushed};
use super::world::World;

/// States of a client's device: position, velocity, motor force of the tick before, and those that it holds back, of the device that holds back most.
fn device_states(scene: &Scene) -> usize {
    3 + scene.devices().iter().map(|device| device.delay().0).max().unwrap_or(0)
}

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
    // Clients and engine look once a packet period: a part of one is one more.
    let packet = scene.peer.timing.ticks_per_packet as usize;
    let [down, up] = delays_ticks(&scene.linear()).map(|ticks| ticks.div_ceil(packet));
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
///
/// # Errors
/// A scene that cannot be built, or whose eigenvalues do not converge.
pub fn verdict(scene: &Scene, lines: &[Line]) -> Result<Verdict, crate::Error> {
    let mut period = Period::new(&scene.linear(), lines);
    let size = period.state.len();
    let mut matrix = Matrix::zeros(size, size);
    for at in 0..size {
        period.state.fill(0.0);
        period.state[at] = 1.0;
        period.pass();
        matrix.column_mut(at).copy_from_slice(&period.state);
    }
    // Without a spring to any arm everything together can stand anywhere.
    let free = scene.users.iter().all(|user| user.settings.user.arm_stiffness_n_per_m == 0.0);
    let rest_modes = if free { vec![period.translation()] } else { Vec::new() };
    let devices: Vec<usize> = (0..lines.len()).map(|client| period.device * client).collect();
    Ok(Analyser::default().judge(Lifted { matrix, rest_modes }, &devices)?)
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
    /// Numbers of each device.
    device: usize,
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
        let device = device_states(linear);
        Self {
            seats: lines.iter().enumerate().map(seat).collect(),
            engine,
            ticks: linear.peer.timing.ticks_per_packet,
            down,
            device,
            state: vec![0.0; device * lines.len() + 2 * (1 + down) + up],
        }
    }

    /// Everything one metre away.
    fn translation(&self) -> Vec<f64> {
        let (devices, motions) = (self.device * self.seats.len(), 2 * (1 + self.down));
        let place = |at: usize| match at.checked_sub(devices) {
            None => at.is_multiple_of(self.device),
            Some(at) => at < motions && at.is_multiple_of(2),
        };
        (0..self.state.len()).map(|at| f64::from(u8::from(place(at)))).collect()
    }

    /// Takes everything through one packet period.
    fn pass(&mut self) {
        let (devices, rest) = self.state.split_at_mut(self.device * self.seats.len());
        let (motions, mut pushes) = rest.split_at_mut(2 * (1 + self.down));
        let mut broadcast: Vec<Motion<f64>> =
            motions.chunks_exact(2).map(|at| Motion { position: at[0], velocity: at[1] }).collect();
        self.engine.take_over(broadcast[0]);
        for (seat, state) in self.seats.iter_mut().zip(devices.chunks_exact(self.device)) {
            let mut numbers = state.iter().copied();
            seat.plant.visit_axes(1, |number| *number = numbers.next().unwrap_or(0.0));
        }
        for tick in 0..self.ticks {
            for (seat, user) in self.seats.iter_mut().zip(&mut self.engine.users) {
                let object = seat.line.delay_packets.map_or(self.engine.object, |[_, down]| broadcast[down]);
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
        for (seat, state) in self.seats.iter_mut().zip(devices.chunks_exact_mut(self.device)) {
            let mut numbers = state.iter_mut();
            seat.plant.visit_axes(1, |number| numbers.next().into_iter().for_each(|to| *to = *number));
        }
        // What was newest is one packet older.
        broadcast.rotate_right(1);
        let after = std::iter::once(self.engine.object).chain(broadcast.into_iter().skip(1));
        for (at, motion) in motions.chunks_exact_mut(2).zip(after) {
            at.copy_from_slice(&[motion.position, motion.velocity]);
        }
    }
}
