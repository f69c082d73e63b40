//! The coupled pair under continuous control: what the 1 kHz peer is an approximation of.
//!
//! Devices, contacts, copies, the ends of the wave line and its filters obey one linear differential equation between two
//! packets (THEORY §2 with T_c → 0), whose solution is a matrix exponential: no step, no integrator, no decode scheme.
//! Only what is sampled in the world stays sampled: packets every T_n, and the user's force, which the harness holds for a
//! millisecond.
//!
//! With s = x_d − x_o the decode is (b + B_T)·ẋ_d = √(2b)·u_in − K_T·s + B_T·ẋ_o, and F_T = K_T·s + B_T·(ẋ_d − ẋ_o).
//!
//! States m, m/s, m, m/s, m, √W; inputs N, √W. Valid for linear scenes of the passive wave without force delays.
//! Relative error below 1e-13 over minutes: the exponential is one of order (6, 6), applied once each millisecond.

use std::collections::VecDeque;

use cohold_analysis::{Matrix, exponential};
use cohold_sim::scene::Scene;

/// Time from one sample to the next, s.
pub const SAMPLE_S: f64 = 1e-3;

/// The pair at one instant, just after packets crossed if they did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Position of each peer's copy of the object, m.
    pub objects_m: [f64; 2],
    /// Coordination force on each copy, N.
    pub forces_n: [f64; 2],
}

/// States x_h, ẋ_h, x_o, ẋ_o, x_d, y and inputs F_user, u_in of one peer.
const SIZE: usize = 8;

/// A linear function of states and inputs.
type Row = [f64; SIZE];

fn unit(at: usize) -> Row {
    let mut row = [0.0; SIZE];
    row[at] = 1.0;
    row
}

fn sum(terms: &[(f64, Row)]) -> Row {
    let mut row = [0.0; SIZE];
    for (factor, term) in terms {
        row.iter_mut().zip(term).for_each(|(total, value)| *total += factor * value);
    }
    row
}

/// One peer: what a millisecond makes of it, and what its coordination force is.
struct ContinuousPeer {
    transition: Matrix,
    force: Row,
}

impl ContinuousPeer {
    fn new(scene: &Scene) -> Self {
        let (device, contact, object) = (&scene.world.device, &scene.peer.contact, &scene.peer.object);
        let line = &scene.peer.coordination;
        let (stiffness, damping, b) = (line.stiffness_n_per_m, line.damping_n_s_per_m, line.wave_impedance_n_s_per_m);
        let [x_h, v_h, x_o, v_o, x_d, y, user, u_in] = [0, 1, 2, 3, 4, 5, 6, 7].map(unit);
        let root = (2.0 * b).sqrt();
        let stretch = sum(&[(1.0, x_d), (-1.0, x_o)]);
        let v_d = sum(&[(root, u_in), (-stiffness, stretch), (damping, v_o)]).map(|gain| gain / (b + damping));
        let force = sum(&[(stiffness, stretch), (damping, v_d), (-damping, v_o)]);
        let touch = sum(&[
            (contact.stiffness_n_per_m, x_h),
            (-contact.stiffness_n_per_m, x_o),
            (contact.damping_n_s_per_m, v_h),
            (-contact.damping_n_s_per_m, v_o),
        ]);
        let u_out = sum(&[(b / root, v_d), (-1.0 / root, force)]);
        let cutoff = std::f64::consts::TAU * line.cutoff_hz;
        let change = [
            v_h,
            sum(&[(1.0, user), (-device.damping_n_s_per_m, v_h), (-1.0, touch)]).map(|gain| gain / device.mass_kg),
            v_o,
            sum(&[(1.0, touch), (1.0, force), (-object.damping_n_s_per_m, v_o)]).map(|gain| gain / object.mass_kg),
            v_d,
            sum(&[(cutoff, u_out), (-cutoff, y)]),
            [0.0; SIZE],
            [0.0; SIZE],
        ];
        let over_a_sample = change.map(|row| row.map(|gain| gain * SAMPLE_S));
        Self { transition: exponential(&Matrix::from_fn(SIZE, SIZE, |i, j| over_a_sample[i][j])), force }
    }
}

/// The pair of a linear passive-wave scene, one sample each millisecond from 0 to before `duration_s`.
pub fn run(scene: &Scene, duration_s: f64) -> Vec<Sample> {
    let peer = ContinuousPeer::new(scene);
    let timing = &scene.peer.timing;
    let packet_s = timing.packet_period_s();
    let samples_per_packet = (packet_s / SAMPLE_S).round() as usize;
    let delay = scene.world.network.one_way_delay_packets as usize;
    let mut states = [vec![0.0; SIZE], vec![0.0; SIZE]];
    let mut on_the_way: VecDeque<[f64; 2]> = VecDeque::new();
    let mut samples = Vec::new();
    for at in 0..(duration_s / SAMPLE_S).round() as usize {
        let time_s = at as f64 * SAMPLE_S;
        if at % samples_per_packet == 0 {
            on_the_way.push_back([states[1][5], states[0][5]]);
            if on_the_way.len() > delay
                && let Some(arrived) = on_the_way.pop_front()
            {
                states.iter_mut().zip(arrived).for_each(|(state, wave)| state[7] = wave);
            }
        }
        let [first, second] = &mut states;
        // Each user pushes toward the other: user 2 toward negative x.
        (first[6], second[6]) = (scene.users[0].force_n(time_s), -scene.users[1].force_n(time_s));
        let force = |state: &[f64]| peer.force.iter().zip(state).map(|(gain, value)| gain * value).sum();
        samples.push(Sample { objects_m: [first[2], second[2]], forces_n: [force(first), force(second)] });
        for state in &mut states {
            *state = cohold_analysis::apply(&peer.transition, state);
        }
    }
    samples
}
