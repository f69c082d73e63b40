//! Energy at the two ports of a peer's coordination: the network's, and the object's.
//!
//! Between the ports stand the line's end and the spring K_T. What crosses the **network port** the peer books itself
//! (`haptic_core::law::ledger`): ½·u_in²·T_c and ½·u_out²·T_c a tick. At the **object port** F_T\[n\] acts on the copy over tick n and does
//! the work
//!
//! ```text
//! W[n] = F_T[n] · v̄[n] · T_c,   v̄[n] = ½·(ẋ_o[n] + ẋ_o[n+1]).
//! ```
//!
//! With this mean velocity m_O·(ẋ_o\[n+1\] − ẋ_o\[n\])·v̄\[n\] is the change of the copy's kinetic energy, exactly: whatever the integrator
//! makes by moving the copy further or less far than v̄·T_c is the peer's, and counts against it. What waits in the spring,
//! ½·K_T·(x_d − x_o)², has neither come out nor been lost. So a peer makes no energy if
//!
//! ```text
//! (sent + Σ max(W, 0) + stored) / (received + Σ max(−W, 0)) ≤ 1.
//! ```
//!
//! Left out: an impact changes ẋ_o between two ticks, so that v̄ is not known; nothing is said of impulsive contact. A force
//! that acts late (`object.force_delay_ticks`) is booked in the tick that computed it.

use core::iter::Sum;

use haptic_core::peer::Observed;

use super::Figure;

/// Energy that crossed the ports of one peer's coordination, J.
#[derive(Clone, Copy, Debug, Default)]
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
}

impl PortEnergy {
    /// What came out and what waits inside over what went in; above 1 the peer makes energy. 0 if nothing went in.
    pub fn out_over_in(&self) -> f64 {
        let out = self.sent_j + self.to_object_j + self.stored_j;
        ratio(out, self.received_j + self.from_object_j)
    }
}

impl Sum for PortEnergy {
    fn sum<I: Iterator<Item = Self>>(each: I) -> Self {
        each.fold(Self::default(), |sum, one| Self {
            received_j: sum.received_j + one.received_j,
            sent_j: sum.sent_j + one.sent_j,
            to_object_j: sum.to_object_j + one.to_object_j,
            from_object_j: sum.from_object_j + one.from_object_j,
            stored_j: sum.stored_j + one.stored_j,
        })
    }
}

/// Out over in; 0 if nothing went in.
pub(crate) fn ratio(out: f64, into: f64) -> f64 {
    if into > 0.0 { out / into } else { 0.0 }
}

/// Books the object port of one peer, tick by tick.
#[derive(Clone, Copy, Debug)]
pub struct ObjectPort<F = f64> {
    period_s: F,
    stiffness_n_per_m: F,
    /// Coordination force and velocity of the copy in the tick before.
    before: Option<(F, F)>,
    booked: PortEnergy<F>,
}

impl<F: Figure> ObjectPort<F> {
    /// An account without entries, at this control period (s) and K_T (N/m).
    pub fn new(period_s: F, stiffness_n_per_m: F) -> Self {
        Self { period_s, stiffness_n_per_m, before: None, booked: PortEnergy::default() }
    }

    /// Takes in motions and force of the next tick; with them the work of the tick before is known.
    #[inline]
    pub fn see(&mut self, seen: &Observed<F>) {
        if let Some((force, velocity)) = self.before.replace((seen.coordination_force, seen.object.velocity)) {
            let mean_velocity = F::HALF * (velocity + seen.object.velocity);
            let work_j = force * mean_velocity * self.period_s;
            self.booked.to_object_j = self.booked.to_object_j + work_j.larger(F::ZERO);
            self.booked.from_object_j = self.booked.from_object_j + (-work_j).larger(F::ZERO);
        }
        let stretch_m = seen.desired.position - seen.object.position;
        self.booked.stored_j = F::HALF * self.stiffness_n_per_m * stretch_m * stretch_m;
    }

    /// With what `of` makes of each number.
    pub(crate) fn map<G>(&self, of: impl Fn(F) -> G) -> ObjectPort<G> {
        let PortEnergy { received_j, sent_j, to_object_j, from_object_j, stored_j } = self.booked;
        ObjectPort {
            period_s: of(self.period_s),
            stiffness_n_per_m: of(self.stiffness_n_per_m),
            before: self.before.map(|(force, velocity)| (of(force), of(velocity))),
            booked: PortEnergy {
                received_j: of(received_j),
                sent_j: of(sent_j),
                to_object_j: of(to_object_j),
                from_object_j: of(from_object_j),
                stored_j: of(stored_j),
            },
        }
    }
}

impl ObjectPort {
    /// The account of both ports, given the energy that crossed the network port, J.
    pub fn with_network(&self, received_j: f64, sent_j: f64) -> PortEnergy {
        PortEnergy { received_j, sent_j, ..self.booked }
    }
}
