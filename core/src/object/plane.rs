//! A wall with any normal in the plane or in space, and friction along it.
//!
//! **Wall**: with d how far the body is past it and v_n how fast it goes on, it pushes back along its normal as
//! [`super::fixture`] does: F_n = K·(d + T_c·v_n/2) + B·v_n from d > 0, ½K·(d + T_c·v_n) from d ≤ 0, each only where that is a push. Along
//! one axis of several its impedance is one entry; turned, a matrix n·z·nᵀ: the solve of [`super::vector`] sees it with all others.
//!
//! **Friction**: viscous, F = −B_f·v_t while in touch, one more share of that matrix; and Coulomb's, |F_t| ≤ μ·F_n, which brings the body
//! to rest along the wall within the tick if it can and holds it there, or else brakes with all that it has. Whether it can is known from the
//! motion along the wall, which leaves one equation along the normal; where it brakes the whole is solved with it.
//!
//! **Passive by construction**: the wall makes no energy (there), and a force along the wall that would do work on the body, F_t·v_t > 0 with
//! the v_t that came of it, is left out of the tick. T_c·F_t·v_t is all that friction does.
//!
//! **Exact** μ·F_n where nothing else couples the normal to the other directions; where something does, F_n is that of a body that stops.

use super::fixture::Fixture;
use super::port::Port;
use super::vector::{Body, Moving, VectorPort, combined, dot, solved, times};
use crate::names::FixtureName;
use crate::num::{Motion, Scalar};
use crate::settings::{Refused, Settings};

/// A wall in the plane (`N` = 2) or in space (3).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<S, const N: usize> {
    /// Unit normal toward the forbidden side.
    pub normal: [S; N],
    /// Distance of the wall from the origin along its normal, m.
    pub position: S,
    stiffness: S,
    /// θ·K·T_c + B, N·s/m, with θ = ½, or 1 where forces are those as the tick ends.
    impedance: S,
    /// θ·K, N/m, and θ·K·T_c, N·s/m: of a body that enters.
    entered: S,
    entering: S,
    /// B_f, N·s/m.
    drag: S,
    /// μ.
    friction: S,
    /// 1 − θ: the mean velocity of a body that comes to rest in a tick, over what it begins with.
    stopping: S,
    one_half: S,
}

configured!([S: Scalar, const N: usize] Plane<S, N> {
    normal, position, stiffness, impedance, entered, entering, drag, friction, stopping, one_half
});

/// Stiffness, damping and friction of a wall.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Gains {
    /// Stiffness normal to the wall K, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping along the normal B, N·s/m.
    pub damping_n_s_per_m: f64,
    /// Damping along the wall B_f, N·s/m.
    pub drag_n_s_per_m: f64,
    /// Coefficient of friction μ.
    pub friction: f64,
}

/// Motion and forces of a tick at a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallContact<S, const N: usize> {
    /// Mean velocity of the body through the tick v, m/s.
    pub mean_velocity: [S; N],
    /// Force with which the wall pushes along its normal, N; never negative.
    pub push: S,
    /// Force along the wall on the body, N: drag and friction.
    pub along: [S; N],
}

impl<S: Scalar, const N: usize> Plane<S, N> {
    /// A wall that forbids what lies beyond `position_m` (m) along `normal` (not 0), with gains ≥ 0 and the control period (s).
    pub fn new(normal: [f64; N], position_m: f64, gains: &Gains, period_s: f64) -> Self {
        Self::met_within(0.5, normal, position_m, gains, period_s)
    }

    /// The same, met through this part θ of a tick.
    fn met_within(part: f64, normal: [f64; N], position_m: f64, gains: &Gains, period_s: f64) -> Self {
        let length = libm::sqrt(normal.iter().map(|part| part * part).sum());
        let stiffness = gains.stiffness_n_per_m;
        Self {
            normal: normal.map(|part| S::from_f64(part / length)),
            position: S::from_f64(position_m),
            stiffness: S::from_f64(stiffness),
            impedance: S::from_f64(part * period_s * stiffness + gains.damping_n_s_per_m),
            entered: S::from_f64(part * stiffness),
            entering: S::from_f64(part * period_s * stiffness),
            drag: S::from_f64(gains.drag_n_s_per_m),
            friction: S::from_f64(gains.friction),
            stopping: S::from_f64(1.0 - part),
            one_half: S::from_f64(0.5),
        }
    }

    /// Depth of a body past the wall, m; negative in front of it.
    pub fn depth(&self, moving: &Moving<S, N>) -> S {
        dot(self.normal, moving.axes.map(|axis| axis.position)) - self.position
    }

    /// Energy stored in the wall's spring ½K·max(0, d)², J.
    pub fn energy_j(&self, moving: &Moving<S, N>) -> S {
        let depth = self.depth(moving).max(S::ZERO);
        self.one_half * self.stiffness * depth * depth
    }

    /// What is left of a vector along the wall.
    fn tangential(&self, vector: [S; N]) -> [S; N] {
        let toward = dot(self.normal, vector);
        combined(vector, self.normal, |part, normal| part - toward * normal)
    }

    /// The push as a port along the normal.
    fn port(&self, depth: S) -> Port<S> {
        if depth > S::ZERO {
            Port::new(-(self.stiffness * depth), self.impedance)
        } else {
            Port::new(-(self.entered * depth), self.entering)
        }
    }

    /// The drag along the wall.
    fn drag(&self) -> VectorPort<S, N> {
        let every_way = VectorPort::of_axes([Port::new(S::ZERO, self.drag); N]);
        every_way + VectorPort::along(self.normal, Port::new(S::ZERO, -self.drag))
    }

    /// Solves a tick of a body at this wall under `others`, the sum of all other ports; the body is not moved yet.
    pub fn meet(&self, body: &Body<S, N>, moving: &Moving<S, N>, others: &VectorPort<S, N>) -> WallContact<S, N> {
        let normal = self.port(self.depth(moving));
        let push = |velocity: [S; N]| -normal.at(dot(self.normal, velocity));
        let nothing = [S::ZERO; N];
        let clear = body.mean_velocity(moving, others);
        if push(clear) <= S::ZERO {
            // What can only push does not pull, and what does not push does not rub.
            return WallContact { mean_velocity: clear, push: S::ZERO, along: nothing };
        }
        let pushed = *others + VectorPort::along(self.normal, normal);
        let (rows, right) = body.equations(moving, &(pushed + self.drag()));
        let free = solved(rows, right);
        if push(free) < S::ZERO {
            // What drags would draw it off: then there is nothing to drag on.
            let velocity = body.mean_velocity(moving, &pushed);
            return WallContact { mean_velocity: velocity, push: push(velocity).max(S::ZERO), along: nothing };
        }
        let along = |velocity: [S; N], friction: [S; N]| {
            combined(self.tangential(velocity).map(|part| -(self.drag * part)), friction, |one, two| one + two)
        };
        let without = WallContact { mean_velocity: free, push: push(free), along: along(free, nothing) };
        if self.friction == S::ZERO {
            return without;
        }
        // The friction that gives the body this mean velocity along the wall, what moves it along the normal then, and the most there is.
        let holding = |along: [S; N]| {
            let left = combined(right, times(&rows, along), |right, taken| right - taken);
            let onward = dot(self.normal, left).ratio(dot(self.normal, times(&rows, self.normal)));
            let velocity = combined(along, self.normal, |along, normal| along + onward * normal);
            let needed = self.tangential(combined(times(&rows, velocity), right, |held, pushed| held - pushed));
            // Of what would pull there is none.
            (needed, velocity, self.friction * push(velocity).max(S::ZERO))
        };
        // At rest along the wall at the end of the tick: the mean of that is half of what is there now. Or nowhere in all of it.
        let stopping = self.tangential(moving.velocity()).map(|part| self.stopping * part);
        for along_wall in [stopping, nothing] {
            let (needed, velocity, most) = holding(along_wall);
            let holds = push(velocity) >= S::ZERO && dot(needed, needed) <= most * most;
            if holds && dot(needed, along_wall) <= S::ZERO {
                return WallContact { mean_velocity: velocity, push: push(velocity), along: along(along_wall, needed) };
            }
        }
        let (needed, _, most) = holding(stopping);
        let share = most.ratio(dot(needed, needed).sqrt());
        let friction = needed.map(|part| share * part);
        let velocity = solved(rows, combined(right, friction, |right, friction| right + friction));
        if dot(friction, velocity) > S::ZERO || push(velocity) < S::ZERO {
            return without;
        }
        WallContact { mean_velocity: velocity, push: push(velocity), along: along(velocity, friction) }
    }
}

/// A fixture of an object that is shared along several axes: a wall, or a guide to one, at the copy.
#[derive(Clone, Copy, Debug)]
pub struct Oblique<S, const N: usize> {
    plane: Plane<S, N>,
    body: Body<S, N>,
    /// It draws as well as pushes.
    draws: bool,
}

configured!([S: Scalar, const N: usize] Oblique<S, N> { plane, body, draws });

impl<S: Scalar, const N: usize> Oblique<S, N> {
    /// The fixture of the table `fixture`; `None` where `fixture.kind` is "none".
    ///
    /// # Errors
    /// A fixture with an `object.integrator` that does not solve for ports.
    pub fn build(settings: &Settings) -> Result<Option<Self>, Refused<'static>> {
        if Fixture::<S>::build(settings)?.is_none() {
            return Ok(None);
        }
        let (fixture, object, period_s) = (&settings.fixture, &settings.object, settings.timing.control_period_s);
        let part = object.integrator.part_of_tick();
        let (sine, cosine) = libm::sincos(fixture.direction_rad);
        let (up, level) = libm::sincos(fixture.elevation_rad);
        let sign = if fixture.kind == FixtureName::ForbiddenBelow { -1.0 } else { 1.0 };
        let mut normal = [0.0; N];
        for (part, of_three) in normal.iter_mut().zip([cosine * level, sine * level, up]) {
            *part = sign * of_three;
        }
        let gains = Gains {
            stiffness_n_per_m: fixture.stiffness_n_per_m,
            damping_n_s_per_m: fixture.damping_n_s_per_m,
            drag_n_s_per_m: fixture.drag_n_s_per_m,
            friction: fixture.friction,
        };
        Ok(Some(Self {
            plane: Plane::met_within(part, normal, sign * fixture.position_m, &gains, period_s),
            body: Body::moved_within(part, object.mass_kg, object.damping_n_s_per_m, period_s),
            draws: fixture.kind == FixtureName::Guide,
        }))
    }

    /// Mean velocity (m/s) through a tick of a copy that begins it as `object`, under this fixture and all other ports.
    pub fn mean_velocity(&self, object: [Motion<S>; N], others: &VectorPort<S, N>) -> [S; N] {
        let (plane, moving) = (&self.plane, Moving::at(object));
        if !self.draws {
            return plane.meet(&self.body, &moving, others).mean_velocity;
        }
        let spring = Port::new(-(plane.stiffness * plane.depth(&moving)), plane.impedance);
        let drawn = *others + VectorPort::along(plane.normal, spring) + plane.drag();
        self.body.mean_velocity(&moving, &drawn)
    }
}
