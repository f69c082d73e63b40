//! Energy at the two ports of a peer's coordination: the network's, and the object's.
//!
//! Between the ports stand the line's end and the spring K_T. What crosses the **network port** the peer books itself
//! (`cohold_core::law::ledger`): ½·u_in²·T_c and ½·u_out²·T_c a tick. At the **object port** F_T\[n\] acts on the copy over tick n and does
//! the work
//!
//! ```text
//! W[n] = F_T[n] · v̄[n] · T_c,   v̄[n] = ½·(ẋ_o[n] + ẋ_o[n+1]).
//! ```
//!
//! With this mean velocity m_O·(ẋ_o\[n+1\] − ẋ_o\[n\])·v̄\[n\] is the change of the copy's kinetic energy, exactly: whatever the integrator
//! makes by moving the copy further or less far than v̄·T_c is the peer's, and counts against it. What a peer has **made** is the most,
//! of the ends of all ticks, by which what came out exceeded what went in,
//!
//! ```text
//! max over n of  sent[n] + Σ W − received[n]
//! ```
//!
//! with both ports at the end of the same tick: nothing, of a passive peer, or what its law began with (E₀).
//!
//! Left out: an impact changes ẋ_o between two ticks, so that v̄ is not known; nothing is said of impulsive contact. A force
//! that acts late (`object.force_delay_ticks`) is booked in the tick that computed it.

use core::iter::Sum;

use cohold_core::peer::Observed;
use serde::Serialize;

use super::Figure;

/// Energy that crossed the ports of one peer's coordination, J.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct PortEnergy<F = f64> {
    /// Energy that came in from the network, J.
    pub received_j: F,
    /// Energy that went out to the network, J.
    pub sent_j: F,
    /// Work of the coordination on the object, J.
    pub to_object_j: F,
    /// Work of the object on the coordination, J.
    pub from_object_j: F,
    /// Energy stored in the coordination's spring, J.
    pub stored_j: F,
    /// The most, at the end of any tick, by which what came out exceeded what went in, J.
    pub made_j: F,
}

impl Sum for PortEnergy {
    fn sum<I: Iterator<Item = Self>>(each: I) -> Self {
        each.fold(Self::default(), |sum, one| Self {
            received_j: sum.received_j + one.received_j,
            sent_j: sum.sent_j + one.sent_j,
            to_object_j: sum.to_object_j + one.to_object_j,
            from_object_j: sum.from_object_j + one.from_object_j,
            stored_j: sum.stored_j + one.stored_j,
            made_j: sum.made_j + one.made_j,
        })
    }
}

/// Books the object port of one peer, tick by tick.
#[derive(Clone, Copy, Debug)]
pub struct ObjectPort<F = f64> {
    period_s: F,
    stiffness_n_per_m: F,
    /// Coordination force and velocity of the copy in the tick before, and what had come from the network and gone to it by its end.
    before: Option<[F; 4]>,
    /// Work on the object so far, J.
    net_j: F,
    /// What went in at both ports less what came out, by the end of the tick before, J.
    pub balance_j: F,
    booked: PortEnergy<F>,
}

impl<F: Figure> ObjectPort<F> {
    /// An account without entries, at this control period (s) and K_T (N/m).
    pub fn new(period_s: F, stiffness_n_per_m: F) -> Self {
        Self {
            period_s,
            stiffness_n_per_m,
            before: None,
            net_j: F::ZERO,
            balance_j: F::ZERO,
            booked: PortEnergy::default(),
        }
    }

    /// Takes in motions and force of the next tick, and what has come from the network and gone to it by its end, J; with them the work of the
    /// tick before is known. Where less has come or gone than before, the peer was armed anew, and so is what it has made.
    #[inline(always)]
    pub fn see(&mut self, seen: &Observed<F>, [received_j, sent_j]: [F; 2]) {
        let now = [seen.coordination_force, seen.object.velocity, received_j, sent_j];
        let before = self.before.replace(now);
        if before.is_some_and(|[.., received, sent]| received_j < received || sent_j < sent) {
            self.net_j = F::ZERO;
        } else if let Some([force, velocity, received_j, sent_j]) = before {
            let mean_velocity = F::HALF * (velocity + seen.object.velocity);
            let work_j = force * mean_velocity * self.period_s;
            self.net_j = self.net_j + work_j;
            self.balance_j = received_j - sent_j - self.net_j;
            self.booked.made_j = self.booked.made_j.larger(sent_j + self.net_j - received_j);
            self.booked.to_object_j = self.booked.to_object_j + work_j.larger(F::ZERO);
            self.booked.from_object_j = self.booked.from_object_j + (-work_j).larger(F::ZERO);
        }
        let stretch_m = seen.desired.position - seen.object.position;
        self.booked.stored_j = F::HALF * self.stiffness_n_per_m * stretch_m * stretch_m;
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G>(&self, of: impl Fn(F) -> G) -> ObjectPort<G> {
        let booked = self.booked;
        ObjectPort {
            period_s: of(self.period_s),
            stiffness_n_per_m: of(self.stiffness_n_per_m),
            before: self.before.map(|before| before.map(&of)),
            net_j: of(self.net_j),
            balance_j: of(self.balance_j),
            booked: PortEnergy {
                received_j: of(booked.received_j),
                sent_j: of(booked.sent_j),
                to_object_j: of(booked.to_object_j),
                from_object_j: of(booked.from_object_j),
                stored_j: of(booked.stored_j),
                made_j: of(booked.made_j),
            },
        }
    }
}

impl ObjectPort {
    /// Energy that the coordination took in and neither delivered nor stores, J. Below 0 it has generated energy.
    pub fn kept_j(&self) -> f64 {
        self.balance_j - self.booked.stored_j
    }

    /// The account of both ports, given the energy that crossed the network port, J.
    pub fn with_network(&self, received_j: f64, sent_j: f64) -> PortEnergy {
        PortEnergy { received_j, sent_j, ..self.booked }
    }
}
