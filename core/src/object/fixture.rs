//! A virtual fixture (Rosenberg 1993): a guide that draws the shared object to a place, or a wall that it may not pass.
//!
//! One more port on the copy, solved with all others ([`super::midpoint`]), felt by whoever holds the object and by the other peer.
//!
//! **Guide**: a spring and a damper, f = K·(x_f − x_o), z = K·T_c/2 + B: what it stores is ½K·(x_o − x_f)², to rounding.
//!
//! **Forbidden**: with d how far the copy is past the wall and v how fast it goes on, the wall pushes back by
//!
//! > F = K·(d + T_c·v/2) + B·v   from d > 0,   F = ½K·(d + T_c·v)   from d ≤ 0,   each only where that is a push.
//!
//! With backward Euler the place is that of the tick's end: K·(d + T_c·v) + B·v, and K·(d + T_c·v).
//!
//! It stores ½K·max(0, d)². From inside, the first is the midpoint of the spring, and F ≥ 0 gives back no more than is stored. A
//! copy that crosses within a tick, from d₀ ≤ 0 to d₁ > 0, works ½K·d₁·(d₁ − d₀) ≥ ½K·d₁² against the second: at least what is stored
//! then. As the tick ends the wall pushes K·d₁, which works K·d₁·(d₁ − d₀) ≥ ½K·(d₁² − d₀²). So it makes no energy, at any stiffness and
//! any speed.

use crate::names::FixtureName;
use crate::num::{Motion, Scalar};
use crate::object::port::{Port, met_midway};
use crate::settings::{Allowed, Refused, Settings};

/// A guide or a wall at a place of the world, met midway through a tick (θ = ½), or as it ends ([`super::backward_euler`], θ = 1).
#[derive(Clone, Copy, Debug)]
pub struct Fixture<S> {
    /// Toward the place that is forbidden: 1, −1, or 0 for a guide.
    beyond: S,
    position: S,
    stiffness: S,
    /// θ·K·T_c + B, N·s/m.
    impedance: S,
    /// θ·K, N/m, and θ·K·T_c, N·s/m: of a copy that enters.
    entered: S,
    entering: S,
}

configured!([S: Scalar] Fixture<S> { beyond, position, stiffness, impedance, entered, entering });

/// A port that may be one-sided, as a wall's is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pushes<S> {
    /// What pushes the copy.
    pub port: Port<S>,
    /// The sign of the only force that this port may have; 0 where it may pull as well as push.
    pub toward: S,
}

impl<S: Scalar> Pushes<S> {
    /// Whether this is how it pushes on a copy of this mean velocity, m/s; and, of a push that was left out, whether it would not.
    #[inline]
    fn fits(self, included: bool, velocity: S) -> bool {
        let force = self.port.at(velocity) * self.toward;
        if included { force >= S::ZERO } else { self.toward != S::ZERO && force <= S::ZERO }
    }
}

impl<S: Scalar> Fixture<S> {
    /// The fixture of the table `fixture`; `None` where `fixture.kind` is "none".
    ///
    /// # Errors
    /// A fixture with an `object.integrator` that does not solve for ports.
    pub fn build(settings: &Settings) -> Result<Option<Self>, Refused<'static>> {
        let fixture = &settings.fixture;
        let beyond = match fixture.kind {
            FixtureName::None => return Ok(None),
            FixtureName::Guide => 0.0,
            FixtureName::ForbiddenAbove => 1.0,
            FixtureName::ForbiddenBelow => -1.0,
        };
        if !settings.object.integrator.solves() {
            let only = Allowed::Only(
                "\"none\" unless object.integrator is \"midpoint\" or \"backward-euler\": it is solved for with the object",
            );
            return Err(settings.refuses("fixture.kind", only));
        }
        let (stiffness, period) = (fixture.stiffness_n_per_m, settings.timing.control_period_s);
        let part = settings.object.integrator.part_of_tick();
        Ok(Some(Self {
            beyond: S::from_f64(beyond),
            position: S::from_f64(fixture.position_m),
            stiffness: S::from_f64(stiffness),
            impedance: S::from_f64(met_midway(stiffness, fixture.damping_n_s_per_m, settings)),
            entered: S::from_f64(part * stiffness),
            entering: S::from_f64(part * period * stiffness),
        }))
    }

    /// The port of this fixture on a copy that begins a tick like this.
    pub fn pushes(&self, object: Motion<S>) -> Pushes<S> {
        let away = self.position - object.position;
        let from_inside = Pushes { port: Port::new(self.stiffness * away, self.impedance), toward: -self.beyond };
        if self.beyond * away < S::ZERO || self.beyond == S::ZERO {
            from_inside
        } else {
            Pushes { port: Port::new(self.entered * away, self.entering), ..from_inside }
        }
    }
}

/// Finds which of two one-sided forces act on a copy in a tick, and returns the first one, N (0 if it does not act).
/// `solve` gives the mean velocity under the ports that act; its last call is for the ports that do. The choice is
/// unique, since each force falls with the velocity.
pub fn solve_both<S: Scalar>(first: Pushes<S>, second: Pushes<S>, mut solve: impl FnMut(Port<S>) -> S) -> S {
    for (one, two) in [(true, true), (true, false), (false, true)] {
        let [of_first, of_second] =
            [(first, one), (second, two)].map(|(pushes, acts)| if acts { pushes.port } else { Port::default() });
        let velocity = solve(of_first + of_second);
        if first.fits(one, velocity) && second.fits(two, velocity) {
            return of_first.at(velocity);
        }
    }
    solve(Port::default());
    S::ZERO
}
