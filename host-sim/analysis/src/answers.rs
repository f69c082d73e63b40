//! What two ends answer to a hand, frequency by frequency: from the code that flies, as a matrix.
//!
//! The peers of a linear scene that say a packet every tick are driven on unit states ([`Response`]); between exchanges nothing is left
//! out. With z = e^(jωT_c), the states p of the near peer, whose device is led, and l of the far one answer
//!
//! ```text
//! (z − A₁)·p − z⁻ᵈ¹·B₁·C₂·l = A₁ₕ·(x, v),      (z − A₂)·l − z⁻ᵈ²·B₂·C₁·p = z⁻ᵈ²·B₂·C₁ₕ·(x, v),      x = v/(jω),
//! ```
//!
//! where A is a peer's own answer, B what it makes of a packet, C what it says, d how many ticks that takes, and h the columns of the led
//! device. What is measured in time ([`cohold_sim::measure::impedance`]) has nothing in common with that but the peers.
//!
//! **Limits**: a packet every tick, a law that is linear, a constant delay. Units as there.

use cohold_sim::measure::impedance::{Answer, Complex, RemoteEnd, held, of_device};
use cohold_sim::scene::Scene;
use nalgebra::{DMatrix, DVector};

use crate::error::Error;
use crate::lifted::delay::delays_ticks;
use crate::lifted::driven::Response;
use crate::matrix::Matrix;

/// States of a device that come first: position, velocity, motor force of the tick before.
const DEVICE: usize = 3;
const FORCE: usize = 2;

/// What the end `near` (0 or 1) of a scene, whose device is led, and the other one answer at these frequencies, Hz.
///
/// # Errors
/// Settings that no peer accepts; packets that do not go every tick.
pub fn answers(scene: &Scene, near: usize, far: RemoteEnd, frequencies_hz: &[f64]) -> Result<Vec<Answer>, Error> {
    let mut linear = scene.linear();
    linear.users = Default::default();
    let timing = &linear.peer.timing;
    if timing.ticks_per_packet != 1 {
        let every = timing.ticks_per_packet;
        return Err(cohold_sim::Error::from(format!(
            "timing.ticks_per_packet = {every} is not allowed here: it must be 1, a packet every tick"
        ))
        .into());
    }
    let period_s = timing.control_period_s;
    let other = 1 - near;
    let (mut led, mut answering) = (Response::default(), Response::default());
    led.measure(&linear, near, 0)?;
    answering.measure(&if far == RemoteEnd::LetGo { linear.hands_off() } else { linear.clone() }, other, 0)?;
    if led.states() == 0 || answering.states() == 0 {
        return Err(Error::NotReached);
    }
    // The device of a hand that holds it, or has let go of it, does not move what its peer sees.
    let first = if far == RemoteEnd::Alone { 0 } else { DEVICE };
    let (delays, devices) = (delays_ticks(&linear), linear.devices());
    let (states, all) = (led.states() - DEVICE, led.states() + answering.states() - DEVICE - first);
    let part = |of: &Matrix, rows: usize, columns: usize| of.view_range(rows.., columns..).map(Complex::from);
    let [own, own_far] = [part(&led.own, DEVICE, DEVICE), part(&answering.own, first, first)];
    let [heard, heard_far] = [part(&led.heard, DEVICE, 0), part(&answering.heard, first, 0)];
    let [said, said_far] = [part(&led.sent, 0, DEVICE), part(&answering.sent, 0, first)];
    let at = |frequency_hz: f64| {
        let omega = core::f64::consts::TAU * frequency_hz;
        let z = Complex::from_polar(1.0, omega * period_s);
        let late = |end: usize| Complex::from_polar(1.0, -omega * period_s * delays[end] as f64);
        // At a speed of 1 m/s.
        let hand = DVector::from_vec(vec![Complex::new(0.0, -1.0 / omega), Complex::from(1.0)]);
        let by_hand =
            |of: &Matrix, rows: usize, count: usize| of.view((rows, 0), (count, 2)).map(Complex::from) * &hand;
        let heard_of_hand = by_hand(&led.sent, 0, led.packet()) * late(other);
        let mut matrix = DMatrix::from_diagonal_element(all, all, z);
        let mut add = |(row, column): (usize, usize), block: DMatrix<Complex>| {
            let mut place = matrix.view_mut((row, column), block.shape());
            place -= block;
        };
        add((0, 0), own.clone());
        add((states, states), own_far.clone());
        add((0, states), &heard * &said_far * late(near));
        add((states, 0), &heard_far * &said * late(other));
        let mut right = DVector::zeros(all);
        right.rows_mut(0, states).copy_from(&by_hand(&led.own, DEVICE, states));
        right.rows_mut(states, all - states).copy_from(&(&heard_far * &heard_of_hand));
        let nothing = Complex::from(f64::NAN);
        let solved = matrix.lu().solve(&right).unwrap_or_else(|| DVector::from_element(all, nothing));
        let (near_states, far_states) = (solved.rows(0, states), solved.rows(states, all - states));
        let force = |of: &Response, from: usize, states: DVector<Complex>, packet: DVector<Complex>| {
            let own = of.own.view((FORCE, from), (1, of.states() - from)).map(Complex::from) * states;
            let heard = of.heard.view((FORCE, 0), (1, of.packet())).map(Complex::from) * packet;
            own[0] + heard[0]
        };
        let packet = &said_far * far_states * late(near);
        let near_force = force(&led, DEVICE, near_states.into_owned(), packet) + by_hand(&led.own, FORCE, 1)[0];
        let packet = &said * near_states * late(other) + heard_of_hand;
        let far_force = force(&answering, first, far_states.into_owned(), packet);
        let motion =
            if far == RemoteEnd::Alone { far_states[0] * Complex::new(0.0, omega) } else { Complex::from(0.0) };
        Answer {
            impedance: of_device(&devices[near], omega, period_s, -near_force),
            motion,
            pushed: held(&devices[other], omega, period_s, far_force),
        }
    };
    Ok(frequencies_hz.iter().map(|frequency_hz| at(*frequency_hz)).collect())
}
