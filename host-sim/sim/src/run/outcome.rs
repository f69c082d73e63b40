//! Outcome of a run: its options, figures of merit and recorded tables.

use cohold_columns::Columns;
use cohold_core::contact::Impacts;
use cohold_core::safety::Fault;

use super::reason::{Reason, Verdict};
use crate::measure::Statistics;
use crate::measure::port::PortEnergy;
use crate::scene::Scene;

/// Duration of a run, and how much of it is recorded.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Simulated time of the run, s.
    pub duration_s: f64,
    /// Ticks from one recorded tick to the next; 0 records none.
    pub record_every: u64,
}

/// A run of 20 s, as the papers' are, that records no tick.
impl Default for Options {
    fn default() -> Self {
        Self::unrecorded(20.0)
    }
}

impl Options {
    /// A run of `duration_s` (s) with control period `period_s` (s) that records at most about 100,000 ticks.
    pub fn recorded(duration_s: f64, period_s: f64) -> Self {
        Self { duration_s, record_every: ((duration_s / period_s) as u64).div_ceil(100_000).max(1) }
    }

    /// A run of `duration_s` (s) that records no tick.
    pub const fn unrecorded(duration_s: f64) -> Self {
        Self { duration_s, record_every: 0 }
    }

    /// Control periods of a run of this scene.
    pub fn ticks(&self, scene: &Scene) -> u64 {
        (self.duration_s / scene.peer.timing.control_period_s).round() as u64
    }
}

/// How long runs go on of which only figures of merit are asked: one that stopped has none ([`Outcome::metric`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Until {
    /// To their end, so that the hash is of every tick.
    TheEnd,
    /// Until a peer stops: verdict and reason are those of the whole run, the hash is of the ticks until then.
    Stopped,
}

/// What the shared axes are called, the first one first.
pub const AXIS_NAMES: [&str; 3] = ["x", "y", "z"];

/// Figures of merit along one axis, or of all axes together: then lengths are those of vectors, and energies are sums.
#[derive(Clone, Copy, Debug)]
pub struct Figures {
    /// Mean of |x_o1 − x_o2| over the last half, mm.
    pub true_discrepancy_mm: f64,
    /// The largest |x_o1 − x_o2| of the whole run, mm.
    pub largest_true_discrepancy_mm: f64,
    /// Mean of |x_o − x_d| at peer 2 over the last half, mm.
    pub decoded_discrepancy_mm: f64,
    /// F_T at peer 2 over the last half, N: of all axes together the length of its mean, and what scatters about that.
    pub coordination_force_n: Statistics,
    /// Mean of |F_LC| over both peers and the last half, N.
    pub contact_force_n: f64,
    /// Largest |F_T| of either peer, N.
    pub peak_coordination_force_n: f64,
    /// Largest change of either F_T from one tick to the next, N.
    pub largest_jump_n: f64,
    /// Largest force that either peer's motors press its hand with, N; NaN where that was not seen, as of boards.
    pub peak_hand_force_n: f64,
    /// Largest change of that from one tick to the next, N; NaN likewise.
    pub largest_hand_change_n: f64,
    /// Energy through the ports of the coordination of each peer, J.
    pub energy: [PortEnergy; 2],
    /// The most, at the end of any tick, that a peer had taken from the network beyond what the other one had given to it, J; along several
    /// axes the sum of theirs.
    pub made_j: f64,
}

/// Outcome of a run along one shared axis.
#[derive(Clone, Debug)]
pub struct AxisOutcome {
    /// Discrepancies, forces and energies of this axis.
    pub figures: Figures,
    /// Recorded ticks, one in a row; empty if none was recorded.
    pub table: Columns,
}

/// Outcome of a run: whether it is stable, its figures of merit and what was recorded.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Why the run is not stable; none if it is.
    pub reason: Option<Reason>,
    /// Neither peer faulted, and neither force nor energy grew without bound; the copies may have come apart.
    pub bounded: bool,
    /// The first fault, with the number of the peer that it stopped (1 or 2).
    pub fault: Option<(usize, Fault)>,
    /// Simulated time of that fault, s.
    pub fault_time_s: Option<f64>,
    /// Figures of all shared axes together; of one axis, its own.
    pub whole: Figures,
    /// Outcome along each shared axis, in the order of [`AXIS_NAMES`].
    pub axes: Vec<AxisOutcome>,
    /// Impacts at both peers, where contact is impulsive.
    pub impacts: Option<[Impacts<f64>; 2]>,
    /// Number of ticks that were stepped.
    pub ticks: u64,
    /// Packets that a peer sent, lost ones included, mean of both, 1/s; NaN where they were not counted.
    pub packets_per_s: f64,
    /// Hash of both peers' states over every tick.
    pub hash: u64,
}

impl Outcome {
    /// Verdict on the run.
    pub fn verdict(&self) -> Verdict {
        match self.reason {
            None => Verdict::Stable,
            Some(Reason::Apart { .. }) => Verdict::Apart,
            Some(_) => Verdict::Unstable,
        }
    }

    /// Whether the run has no reason to be called unstable.
    pub fn is_stable(&self) -> bool {
        self.reason.is_none()
    }

    /// A figure of merit `of` this outcome; none if anything failed but that the copies came apart.
    pub fn metric<T>(&self, of: impl FnOnce(&Self) -> T) -> Option<T> {
        (self.verdict() != Verdict::Unstable).then(|| of(self))
    }

    /// This outcome with a reason, found outside the run, to call it unstable; what failed in the run takes precedence.
    #[must_use]
    pub fn doubted(mut self, reason: Option<Reason>) -> Self {
        // Apart is the least that can be said.
        if self.verdict() != Verdict::Unstable {
            self.reason = reason.or(self.reason);
        }
        self
    }

    /// **Channel**: the most, at the end of any tick, that a peer had taken from the network beyond what the other one had given to it, mJ;
    /// above what the law began with the network makes energy.
    pub fn energy_made_mj(&self) -> f64 {
        1e3 * self.whole.made_j
    }

    /// **Peer**: the most, at the end of any tick, that had left the ports of a peer's coordination beyond what had entered them, mJ, of the
    /// worse peer ([`crate::measure::port`]). None where contact is impulsive.
    pub fn peer_energy_made_mj(&self) -> Option<f64> {
        let [first, second] = self.whole.energy.map(|energy| 1e3 * energy.made_j);
        self.impacts.is_none().then(|| first.max(second))
    }
}
