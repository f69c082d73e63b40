//! Devices of all lanes, side by side: plants without joints, windings or friction, whose peers read and drive them exactly.

use std::array::from_fn;

use cohold_core::device::Reading;
use cohold_core::num::{Motion, Scalar as _};
use cohold_core::peer::{Actuators, Sensors};

use super::number::{F64s, LANES};
use crate::device::Device;
use crate::plant::{Linear, Plant};

/// Plants of which each lane has one.
#[derive(Debug)]
pub(super) struct Plants<const N: usize> {
    plants: Vec<Plant<N>>,
    /// Every user does the same.
    alike: bool,
    linear: Linear<F64s>,
    axes_in_use: usize,
    motions: [Motion<F64s>; N],
    motor_before: [F64s; N],
}

impl<const N: usize> Plants<N> {
    /// Of these plants, one a lane, which all are bare; `alike` where every user does the same.
    pub(super) fn new(plants: Vec<Plant<N>>, alike: bool) -> Self {
        let of = |number: &dyn Fn(&Plant<N>) -> f64| F64s::of(|lane| number(&plants[lane]));
        let gain = |row: usize| of(&|plant| plant.linear.gain_before[row]);
        let now = |row: usize| of(&|plant| plant.linear.gain_now[row]);
        let linear = Linear {
            transition: from_fn(|row| from_fn(|column| of(&|plant| plant.linear.transition[row][column]))),
            gain_before: from_fn(gain),
            gain_now: from_fn(now),
        };
        let motions = from_fn(|axis| Motion {
            position: of(&|plant| plant.motions()[axis].position),
            velocity: of(&|plant| plant.motions()[axis].velocity),
        });
        let axes_in_use = plants[0].axes_in_use;
        Self { plants, alike, linear, axes_in_use, motions, motor_before: [F64s::ZERO; N] }
    }

    /// Forces on the axes beside the motors', N.
    #[inline]
    fn pushes(&self, time_s: f64) -> [F64s; N] {
        if self.alike {
            return self.plants[0].pushes(time_s).map(F64s::splat);
        }
        let each: [[f64; N]; LANES] = from_fn(|lane| self.plants[lane].pushes(time_s));
        from_fn(|axis| F64s::of(|lane| each[lane][axis]))
    }
}

impl<const N: usize> Device<F64s, N> for Plants<N> {
    #[inline]
    fn sensors(&self) -> Sensors<F64s, N> {
        Sensors::of(Reading::Exact(self.motions))
    }

    #[inline]
    fn step(&mut self, time_s: f64, actuators: &Actuators<F64s, N>) {
        let pushes = self.pushes(time_s);
        let moved = self.motions.iter_mut().zip(&mut self.motor_before).take(self.axes_in_use);
        for ((motion, before), (push, force)) in moved.zip(pushes.iter().zip(&actuators.forces)) {
            *motion = self.linear.advance(*motion, *before + *push, *force + *push);
            *before = *force;
        }
    }
}
