//! Stability of one haptic device that renders one virtual object, with delay at any of four places (architectures paper
//! §2.3, Fig. 3 and 4).
//!
//! ```text
//!   m·ẍ + b·ẋ = F_user − F(t − delay2)   device, continuous      x(t − delay1) ──►┐
//!                                                                                 CDE: F = K·(x − x_o) + B·(ẋ − ẋ_o)
//!   m_o·ẍ_o + b_o·ẋ_o = F(t − delay3)    object, or a wall      x_o(t − delay4) ─►┘     every T, F computed in c·T
//! ```
//!
//! The collision detection engine (CDE) samples what has arrived at kT; the force it computes acts from kT + c·T + delay
//! on, and is held for T. Both bodies are advanced exactly (matrix exponential), so nothing is approximated: a delay may be
//! any number of seconds. The device is followed at the instants kT − delay1, the object at kT − delay4: the delay before
//! the CDE becomes part of the delay after it, and the sampled map needs a queue of past forces only.
//!
//! **State**: x, ẋ of the device, x_o, ẋ_o of the object, F\[k−1\], F\[k−2\], … (m, m/s, N). With a movable object the pair
//! can stand anywhere: that rest mode is divided out. Against a wall there is none, and no delay between CDE and dynamics
//! engine (DE) matters.
//!
//! | module | answers |
//! |---|---|
//! | [`closed`] | the same in closed form, for slow oscillations |
//! | [`maps`] | largest stiffness against delay and against sampling period |
//! | [`identify`] | the device behind the paper's statement: 1000 N/m needs 200 Hz and less than 5 ms |
//! | [`picture`] | both maps on the paper's axes |

pub mod closed;
pub mod identify;
pub mod maps;
pub mod picture;
#[cfg(test)]
#[path = "../../tests/inside/rendering.rs"]
mod tests;

use cohold_core::names::Choice;
use cohold_sim::plant::Linear;
use serde::Serialize;

use super::lifted::{Lifted, rest};
use super::matrix::reset;
use super::spectrum::{Polar, Spectrum, radius};
use crate::error::Error;

cohold_sim::choices! {
    /// Where a delay can sit, in the order of the paper's delay1 … delay4: between the device, the collision detection engine (CDE) and
    /// the dynamics engine (DE).
    #[derive(Serialize)]
    #[serde(rename_all = "kebab-case")]
    Place {
        "device to CDE" => DeviceToCollision, "Positions on their way from the device to the collision detection engine.";
        "CDE to device" => CollisionToDevice, "Forces on their way from there to the device.";
        "CDE to DE" => CollisionToDynamics, "Forces on their way from there to the dynamics engine.";
        "DE to CDE" => DynamicsToCollision, "Positions on their way from the dynamics engine to the collision detection engine.";
    }
}

/// A mass with damping.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Body {
    /// Mass of the body, kg.
    pub mass_kg: f64,
    /// Viscous damping of the body, N·s/m.
    pub damping_n_s_per_m: f64,
}

/// A device, an object and what is between them, but for the contact stiffness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Rendering {
    /// The haptic device in the hand.
    pub device: Body,
    /// The virtual object; `None` is a wall, which nothing moves.
    pub object: Option<Body>,
    /// Contact damping B, N·s/m.
    pub contact_damping_n_s_per_m: f64,
    /// Sampling period T, s.
    pub period_s: f64,
    /// Time from sampling to the new force, as a fraction c of T (may exceed 1).
    pub computing_ticks: f64,
    /// Delays, s, in the order of [`Place::ALL`].
    pub delays_s: [f64; 4],
}

/// Longest delay at one place, periods: the sampled map remembers a force for each.
pub const MOST_TICKS: f64 = 200.0;

impl Rendering {
    /// This arrangement with this delay (s) at one place.
    #[must_use]
    pub fn delayed(mut self, place: Place, delay_s: f64) -> Self {
        self.delays_s[place as usize] = delay_s;
        self
    }

    /// Seconds from sampling to force around the device's and around the object's loop, without the hold.
    pub fn loops_s(&self) -> [f64; 2] {
        let [to_engine, to_device, to_dynamics, from_dynamics] = self.delays_s;
        let computing_s = self.computing_ticks * self.period_s;
        [computing_s + to_engine + to_device, computing_s + to_dynamics + from_dynamics]
    }

    /// Every number finite and within what the map can hold.
    ///
    /// # Errors
    /// A number that is infinite, NaN, or beyond what the map can hold.
    pub fn check(&self) -> Result<(), Error> {
        let positive = |key, value, unit| Error::within(key, value, [1e-6, 1e6], unit);
        let any = |key, value, unit| Error::within(key, value, [0.0, 1e6], unit);
        positive("device_mass_kg", self.device.mass_kg, "kg")?;
        any("device_damping_n_s_per_m", self.device.damping_n_s_per_m, "N·s/m")?;
        if let Some(object) = self.object {
            positive("object_mass_kg", object.mass_kg, "kg")?;
            any("object_damping_n_s_per_m", object.damping_n_s_per_m, "N·s/m")?;
        }
        any("contact_damping_n_s_per_m", self.contact_damping_n_s_per_m, "N·s/m")?;
        Error::within("sampling_period_s", self.period_s, [1e-6, 10.0], "s")?;
        Error::within("computing_ticks", self.computing_ticks, [0.0, 10.0], "ticks")?;
        for (place, delay_s) in Place::ALL.iter().zip(self.delays_s) {
            let most_s = MOST_TICKS * self.period_s;
            Error::within(&format!("delay_s ({})", place.name()), delay_s, [0.0, most_s], "s")?;
        }
        Ok(())
    }
}

/// Computes spectral radii, one after the other, in the same memory.
#[derive(Debug, Default)]
pub struct Renderer {
    lifted: Lifted,
    spectrum: Spectrum,
}

/// One body as the sampled map sees it: whole periods of delay, and the exact step with the rest of it.
struct Sampled {
    whole: usize,
    step: Linear,
}

impl Sampled {
    fn new(body: Body, loop_s: f64, period_s: f64) -> Self {
        let ticks = loop_s / period_s;
        let late = ticks - ticks.floor();
        Self { whole: ticks as usize, step: Linear::new(body.mass_kg, body.damping_n_s_per_m, 0.0, late, period_s) }
    }
}

impl Renderer {
    /// Largest |eigenvalue| of the sampled map with this contact stiffness (N/m), the rest mode left out.
    ///
    /// # Errors
    /// Eigenvalues that do not converge.
    pub fn radius(&mut self, rendering: &Rendering, stiffness_n_per_m: f64) -> Result<f64, Error> {
        self.polar(rendering, stiffness_n_per_m).map(|polar| radius(&polar))
    }

    /// Eigenvalues of the sampled map, as size and angle.
    fn polar(&mut self, rendering: &Rendering, stiffness_n_per_m: f64) -> Result<Polar, Error> {
        self.build(rendering, stiffness_n_per_m);
        rest::divide_out(&mut self.lifted);
        self.spectrum.polar(&mut self.lifted.matrix).ok_or(Error::NoConvergence)
    }

    /// Writes the sampled map.
    fn build(&mut self, rendering: &Rendering, stiffness_n_per_m: f64) {
        let bodies: Vec<(Sampled, f64)> = [(Some(rendering.device), 1.0), (rendering.object, -1.0)]
            .into_iter()
            .zip(rendering.loops_s())
            .filter_map(|((body, sign), loop_s)| Some((Sampled::new(body?, loop_s, rendering.period_s), sign)))
            .collect();
        let queue = 2 * bodies.len();
        let remembered = bodies.iter().map(|(body, _)| body.whole + 1).max().unwrap_or(1);
        let matrix = &mut self.lifted.matrix;
        reset(matrix, queue + remembered, queue + remembered);
        // F[k] = K·(x − x_o) + B·(ẋ − ẋ_o): what it is made of.
        let made_of: Vec<(usize, f64)> = bodies
            .iter()
            .enumerate()
            .flat_map(|(at, (_, sign))| {
                let damping = rendering.contact_damping_n_s_per_m;
                [(2 * at, sign * stiffness_n_per_m), (2 * at + 1, sign * damping)]
            })
            .collect();
        for (at, (Sampled { whole, step }, sign)) in bodies.iter().enumerate() {
            for row in 0..2 {
                for column in 0..2 {
                    matrix[(2 * at + row, 2 * at + column)] += step.transition[row][column];
                }
                for (gains, ago) in [(step.gain_before, whole + 1), (step.gain_now, *whole)] {
                    // The device feels the reaction.
                    let gain = -sign * gains[row];
                    if ago > 0 {
                        matrix[(2 * at + row, queue + ago - 1)] += gain;
                    } else {
                        made_of.iter().for_each(|(state, share)| matrix[(2 * at + row, *state)] += gain * share);
                    }
                }
            }
        }
        made_of.iter().for_each(|(state, share)| matrix[(queue, *state)] = *share);
        for moved in queue + 1..queue + remembered {
            matrix[(moved, moved - 1)] = 1.0;
        }
        self.lifted.rest_modes.clear();
        if rendering.object.is_some() {
            let mut together = vec![0.0; queue + remembered];
            (together[0], together[2]) = (1.0, 1.0);
            self.lifted.rest_modes.push(together);
        }
    }
}
