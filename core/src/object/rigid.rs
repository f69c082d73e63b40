//! A rigid body that turns: orientation and angular momentum through a tick, energy and momentum kept.
//!
//! The midpoint rule on the group of rotations. With the angular momentum L in space, the orientation R of the body, its inertia I and
//! the torque τ that acts through the tick, the mean angular velocity ω = R·Ω of the tick solves
//!
//! > I·Ω = ½·(RᵀL + R'ᵀL'),   R' = R·cay(T_c·Ω),   L' = L + T_c·τ
//!
//! which, multiplied by 1 + a×, a = ½·T_c·Ω, is a polynomial: I·Ω + a×I·Ω = RᵀL + ½·T_c·(τ − a×τ), τ in the body. Newton's method from
//! Ω = I⁻¹·RᵀL takes [`MOST`] steps at most, each a solve of three equations. cay(T_c·Ω) is the unit quaternion along (1, a).
//!
//! **Kept**: L of a free body, to the last bit; its energy ½·Ω·I·Ω to rounding, for L' and L are equally long seen from the body and the
//! midpoint keeps squares. Under a torque the energy changes by exactly T_c·τ·ω: a [`TorquePort`] gives what it takes, and a body among
//! ports makes none, at any stiffness. The norm of the quaternion is held at 1; what of it does not fit is carried to the next tick.
//!
//! **Order**: two. A free body turns by 2·atan(½·T_c·ω) a tick where it should by T_c·ω: slow by (T_c·ω)²/12.
//!
//! **Limits**: tried up to T_c·|ω| = 0.9; far beyond it Newton's method may end before it has converged, and energy is then not kept;
//! momentum always is. Inertias must be above 0. What is not finite stays so.
//!
//! Units: rad, kg·m², N·m, N·m·s. Axes of the body are its principal ones.
//!
//! References: Austin, Krishnaprasad & Wang, "Almost Poisson integration of rigid body systems", J. Comput. Phys. 107, 1993 (the
//! free body); Simo & Wong, "Unconditionally stable algorithms for rigid body dynamics that exactly preserve energy and momentum", Int.
//! J. Numer. Methods Eng. 31, 1991.

use crate::num::{Carry, Scalar};

/// Most Newton steps in a tick; each about doubles the correct digits, from a first relative error of about T_c·ω.
pub const MOST: u32 = 5;

/// A vector in space: x, y, z.
pub type Three<S> = [S; 3];

/// Torque on a body through a tick, as a function of its mean angular velocity: τ = f − Z·ω, both in space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TorquePort<S> {
    /// f: the torque on a body that does not turn, N·m.
    pub torque: Three<S>,
    /// Z: by how much the torque falls per rad/s of the body, N·m·s; x·Z·x is never negative.
    pub impedance: [Three<S>; 3],
}

/// Orientation and angular momentum of a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turning<S> {
    /// From the body to space, a unit quaternion: w, x, y, z.
    pub orientation: [S; 4],
    /// Angular momentum in space, N·m·s.
    pub momentum: Three<S>,
    carries: [Carry<S>; 4],
}

visited!([S: Scalar] Turning<S> { orientation, momentum });

/// Mean angular velocity and torque of a tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Turned<S> {
    /// Mean angular velocity ω in space, rad/s.
    pub mean_velocity: Three<S>,
    /// Torque τ in space, N·m.
    pub torque: Three<S>,
}

/// A body that turns about its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rotor<S> {
    /// kg·m², about its principal axes, and 1 over each.
    inertia: Three<S>,
    inverse: Three<S>,
    /// T_c and a half of it, s.
    period: S,
    half: S,
    /// ½.
    one_half: S,
}

fn cross<S: Scalar>([ax, ay, az]: Three<S>, [bx, by, bz]: Three<S>) -> Three<S> {
    [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]
}

fn dot<S: Scalar>([ax, ay, az]: Three<S>, [bx, by, bz]: Three<S>) -> S {
    ax * bx + ay * by + az * bz
}

fn each<S: Scalar>([ax, ay, az]: Three<S>, [bx, by, bz]: Three<S>, of: impl Fn(S, S) -> S) -> Three<S> {
    [of(ax, bx), of(ay, by), of(az, bz)]
}

/// The vector a + factor·b.
fn add<S: Scalar>(a: Three<S>, factor: S, b: Three<S>) -> Three<S> {
    each(a, b, |a, b| a + factor * b)
}

fn times<S: Scalar>(rows: [Three<S>; 3], vector: Three<S>) -> Three<S> {
    rows.map(|row| dot(row, vector))
}

fn transposed<S: Scalar>([[a, b, c], [d, e, f], [g, h, i]]: [Three<S>; 3]) -> [Three<S>; 3] {
    [[a, d, g], [b, e, h], [c, f, i]]
}

/// The solution of three equations, by Cramer's rule; 0 where there is none.
fn solved<S: Scalar>(rows: [Three<S>; 3], right: Three<S>) -> Three<S> {
    let [a, b, c] = transposed(rows);
    let (bc, determinant) = (cross(b, c), dot(a, cross(b, c)));
    [dot(right, bc), dot(right, cross(c, a)), dot(right, cross(a, b))].map(|part| part.ratio(determinant))
}

/// The matrix of v×.
fn turning<S: Scalar>([x, y, z]: Three<S>) -> [Three<S>; 3] {
    [[S::ZERO, -z, y], [z, S::ZERO, -x], [-y, x, S::ZERO]]
}

impl<S: Scalar> Turning<S> {
    /// The rotation matrix R, row by row, which takes body coordinates to space; needs a quaternion of norm 1.
    pub fn rotation(&self) -> [Three<S>; 3] {
        let [w, x, y, z] = self.orientation;
        let twice = |product: S| product + product;
        [
            [S::ONE - twice(y * y + z * z), twice(x * y - w * z), twice(x * z + w * y)],
            [twice(x * y + w * z), S::ONE - twice(x * x + z * z), twice(y * z - w * x)],
            [twice(x * z - w * y), twice(y * z + w * x), S::ONE - twice(x * x + y * y)],
        ]
    }
}

impl<S: Scalar> Rotor<S> {
    /// A rotor with these principal moments of inertia (kg·m², each above 0), in ticks of `period_s` (s).
    pub fn new(inertia_kg_m2: Three<f64>, period_s: f64) -> Self {
        Self {
            inertia: inertia_kg_m2.map(S::from_f64),
            inverse: inertia_kg_m2.map(|inertia| S::from_f64(1.0 / inertia)),
            period: S::from_f64(period_s),
            half: S::from_f64(0.5 * period_s),
            one_half: S::from_f64(0.5),
        }
    }

    /// The state of a body in this orientation (w, x, y, z, of any length but 0) with this angular velocity about its
    /// own axes, rad/s.
    pub fn turning(&self, orientation: [f64; 4], velocity: Three<f64>) -> Turning<S> {
        let norm = libm::sqrt(orientation.iter().map(|part| part * part).sum());
        let orientation = orientation.map(|part| S::from_f64(part / norm));
        let still = Turning { orientation, momentum: [S::ZERO; 3], carries: [Carry::default(); 4] };
        let momentum = each(self.inertia, velocity.map(S::from_f64), |inertia, velocity| inertia * velocity);
        Turning { momentum: times(still.rotation(), momentum), ..still }
    }

    /// Angular velocity about the body's own axes, rad/s.
    pub fn velocity(&self, state: &Turning<S>) -> Three<S> {
        let momentum = times(transposed(state.rotation()), state.momentum);
        each(self.inverse, momentum, |inverse, momentum| inverse * momentum)
    }

    /// Kinetic energy of the rotation, J.
    pub fn energy_j(&self, state: &Turning<S>) -> S {
        let momentum = times(transposed(state.rotation()), state.momentum);
        self.one_half * dot(momentum, each(self.inverse, momentum, |inverse, momentum| inverse * momentum))
    }

    /// Advances a body without torque by one tick.
    pub fn coast(&self, state: &mut Turning<S>) -> Turned<S> {
        self.step(state, &TorquePort::default())
    }

    /// Advances the body by one tick under `port`, the sum of all torques on it.
    pub fn step(&self, state: &mut Turning<S>, port: &TorquePort<S>) -> Turned<S> {
        let rotation = state.rotation();
        let back = transposed(rotation);
        let momentum = times(back, state.momentum);
        // The port as the body sees it.
        let torque = times(back, port.torque);
        let impedance = transposed(transposed(rotation).map(|column| times(back, times(port.impedance, column))));
        let mean = self.mean_velocity(momentum, torque, impedance);

        let mean_velocity = times(rotation, mean);
        let torque = add(port.torque, -S::ONE, times(port.impedance, mean_velocity));
        state.momentum = add(state.momentum, self.period, torque);
        self.turn(state, mean);
        Turned { mean_velocity, torque }
    }

    /// Ω of the tick, from what the body sees.
    fn mean_velocity(&self, momentum: Three<S>, torque: Three<S>, impedance: [Three<S>; 3]) -> Three<S> {
        let mut mean = each(self.inverse, momentum, |inverse, momentum| inverse * momentum);
        let mut before = None;
        for _ in 0..MOST {
            let acting = add(torque, -S::ONE, times(impedance, mean));
            let carried = each(self.inertia, mean, |inertia, mean| inertia * mean);
            // What is missing: ½·T_c·(τ − a×τ) + RᵀL − (I·Ω + a×I·Ω).
            let pushed = add(acting, -self.half, cross(mean, acting));
            let turned = add(carried, self.half, cross(mean, carried));
            let missing = add(add(momentum, self.half, pushed), -S::ONE, turned);
            let change = solved(self.slope(mean, carried, acting, impedance), missing);
            mean = add(mean, S::ONE, change);
            // Rounding is reached when a step is no smaller than the one before, or nothing.
            let size = dot(change, change);
            let smaller = before.is_none_or(|before| size < before);
            if !(smaller && size > S::ZERO) {
                break;
            }
            before = Some(size);
        }
        mean
    }

    /// By how much the left side less the right one grows with Ω.
    fn slope(&self, mean: Three<S>, carried: Three<S>, acting: Three<S>, impedance: [Three<S>; 3]) -> [Three<S>; 3] {
        let [ix, iy, iz] = self.inertia;
        let inertia = [[ix, S::ZERO, S::ZERO], [S::ZERO, iy, S::ZERO], [S::ZERO, S::ZERO, iz]];
        // I + ½T·(Ω×I − (I·Ω)×) + ½T·(Z + ½T·(−τ× − Ω×Z)): δ×v = −v×δ.
        let pulled = add_rows(impedance, -self.half, product(turning(mean), impedance));
        let pulled = add_rows(pulled, -self.half, turning(acting));
        let turned = add_rows(product(turning(mean), inertia), -S::ONE, turning(carried));
        add_rows(add_rows(inertia, self.half, turned), self.half, pulled)
    }

    /// Advances the orientation by one tick at this mean angular velocity (rad/s): R ← R·cay(T_c·Ω).
    fn turn(&self, state: &mut Turning<S>, mean: Three<S>) {
        let [w, x, y, z] = state.orientation;
        let [ax, ay, az] = mean.map(|mean| self.half * mean);
        let square = ax * ax + ay * ay + az * az;
        let root = (S::ONE + square).sqrt();
        // The change of (1, a)/√(1 + a²) from (1, 0), without cancellation.
        let scalar = -square.ratio(S::ONE + square + root);
        let [bx, by, bz] = [ax, ay, az].map(|part| part.ratio(root));
        // Back to length 1: along q, so that it turns nothing.
        let short = self.one_half * (S::ONE - (w * w + x * x + y * y + z * z));
        let scalar = scalar + short;
        let change = [
            w * scalar - x * bx - y * by - z * bz,
            x * scalar + w * bx + y * bz - z * by,
            y * scalar + w * by + z * bx - x * bz,
            z * scalar + w * bz + x * by - y * bx,
        ];
        for ((part, carry), change) in state.orientation.iter_mut().zip(&mut state.carries).zip(change) {
            *part = carry.add(*part, change);
        }
    }
}

fn product<S: Scalar>(a: [Three<S>; 3], b: [Three<S>; 3]) -> [Three<S>; 3] {
    let columns = transposed(b);
    a.map(|row| columns.map(|column| dot(row, column)))
}

fn add_rows<S: Scalar>([a, b, c]: [Three<S>; 3], factor: S, [d, e, f]: [Three<S>; 3]) -> [Three<S>; 3] {
    [add(a, factor, d), add(b, factor, e), add(c, factor, f)]
}
