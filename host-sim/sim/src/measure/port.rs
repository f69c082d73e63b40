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

use haptic_core::peer::Observed;

/// Energy that crossed the ports of one peer's coordination, J.
#[derive(Clone, Copy, Debug, Default)]
pub struct PortEnergy {
    /// From the network.
    pub received_j: f64,
    /// To the network.
    pub sent_j: f64,
    /// To the object.
    pub to_object_j: f64,
    /// From the object.
    pub from_object_j: f64,
    /// In the spring.
    pub stored_j: f64,
}

impl PortEnergy {
    /// What came out and what waits inside over what went in; above 1 the peer makes energy. 0 if nothing went in.
    pub fn out_over_in(&self) -> f64 {
        let out = self.sent_j + self.to_object_j + self.stored_j;
        ratio(out, self.received_j + self.from_object_j)
    }
}

/// Out over in; 0 if nothing went in.
pub(crate) fn ratio(out: f64, into: f64) -> f64 {
    if into > 0.0 { out / into } else { 0.0 }
}

/// Books the object port of one peer, tick by tick.
#[derive(Clone, Copy, Debug)]
pub struct ObjectPort {
    period_s: f64,
    stiffness_n_per_m: f64,
    before: Option<Observed<f64>>,
    booked: PortEnergy,
}

impl ObjectPort {
    /// Nothing booked yet, at this control period and K_T.
    pub fn new(period_s: f64, stiffness_n_per_m: f64) -> Self {
        Self { period_s, stiffness_n_per_m, before: None, booked: PortEnergy::default() }
    }

    /// What the next tick saw; with it the work of the tick before is known.
    pub fn see(&mut self, seen: Observed<f64>) {
        if let Some(before) = self.before.replace(seen) {
            let mean_velocity = 0.5 * (before.object.velocity + seen.object.velocity);
            let work_j = before.coordination_force * mean_velocity * self.period_s;
            self.booked.to_object_j += work_j.max(0.0);
            self.booked.from_object_j += (-work_j).max(0.0);
        }
        let stretch_m = seen.desired.position - seen.object.position;
        self.booked.stored_j = 0.5 * self.stiffness_n_per_m * stretch_m * stretch_m;
    }

    /// With what crossed the network port.
    pub fn with_network(&self, received_j: f64, sent_j: f64) -> PortEnergy {
        PortEnergy { received_j, sent_j, ..self.booked }
    }
}
