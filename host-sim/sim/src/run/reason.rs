//! Why a run is not stable, in a sentence, and the verdict that follows.

use std::fmt;

use cohold_core::safety::Fault;
use cohold_io::significant;

use crate::measure::growth::Swings;

/// What makes a run unstable: the first of these that applies, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reason {
    /// A peer stopped with a fault: the first that did.
    Stopped {
        /// Number of the peer that stopped, 1 or 2.
        peer: usize,
        /// The fault that stopped it.
        fault: Fault,
        /// Simulated time of the fault, s.
        time_s: f64,
    },
    /// The changes of a coordination force grew until the end.
    ForceGrew,
    /// The kinetic energy of the copies grew until the end.
    EnergyGrew,
    /// A coordination force went on swinging by more than all that users push with.
    Swings(Swings),
    /// The scene is linear, and an eigenvalue of it lies outside the unit circle, however little of it the run shows.
    Unstable {
        /// Largest |eigenvalue| of a packet period.
        spectral_radius: f64,
    },
    /// The scene is linear, and the analyser cannot judge it.
    NotJudged {
        /// Why not.
        because: &'static str,
    },
    /// The copies were further apart than [`super::APART_MM`] and than [`super::APART_FACTOR`] times what statics say
    /// ([`super::compliance_m_per_n`]) on average over the last half, or than [`super::END_FACTOR`] times that in the end.
    Apart {
        /// The larger of both, mm.
        true_discrepancy_mm: f64,
    },
    /// At the end a peer had disengaged, for the other was silent: that the copies are close is then chance.
    LetGo {
        /// Number of the peer that had let go, 1 or 2.
        peer: usize,
    },
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Stopped { peer, fault, time_s } => {
                write!(f, "peer {peer} stopped at {time_s:.3} s: {fault:?}: {}", fault.explain())
            }
            Self::ForceGrew => f.write_str("the coordination force oscillated and grew until the end"),
            Self::EnergyGrew => f.write_str("the energy of the copies grew until the end"),
            Self::Swings(Swings { hz, rms_n }) => {
                let [hz, rms_n] = [hz, rms_n].map(|number| significant(*number, 3));
                write!(f, "the coordination force goes on swinging at {hz} Hz by {rms_n} N rms")
            }
            Self::LetGo { peer } => write!(f, "peer {peer} had let go of the other one in the end"),
            Self::Unstable { spectral_radius } => {
                write!(f, "the scene is unstable: spectral radius {spectral_radius:.6}")
            }
            Self::NotJudged { because } => write!(f, "the scene is not judged, because {because}"),
            Self::Apart { true_discrepancy_mm } if *true_discrepancy_mm >= 1e3 => {
                write!(f, "the copies are {} m apart", significant(1e-3 * true_discrepancy_mm, 3))
            }
            Self::Apart { true_discrepancy_mm } => {
                write!(f, "the copies are {} mm apart", significant(*true_discrepancy_mm, 3))
            }
        }
    }
}

/// The verdict on a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The run passed every check.
    Stable,
    /// The copies came apart, and nothing else failed: [`Reason::Apart`].
    Apart,
    /// Another check failed: the run is unstable.
    Unstable,
}

impl Verdict {
    /// As tables say it: `stable`, `apart`, or `NO`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Stable => "stable",
            Self::Apart => "apart",
            Self::Unstable => "NO",
        }
    }
}
