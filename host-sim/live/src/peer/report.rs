//! What one peer in real time saw, as its report has it.

use crate::road::PathReport;
use cohold_protocol::wire::Telemetry;
use cohold_sim::measure::Statistics;
use cohold_sim::measure::port::PortEnergy;
use serde::Serialize;

use crate::devices::DeviceReport;
use crate::endpoint::Punctuality;
use crate::recording::recorder::mode_words;
use crate::tell::Noticed;
use crate::verdict::Verdict;
use crate::watch::LiveSummary;

/// What one peer saw.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Number of this peer: 1 is the left one, 2 the right one.
    pub peer: u8,
    /// Number of ticks while armed.
    pub ticks: u64,
    /// Mean |x_o − x_d| over the last half, mm; of several shared axes the distance in the plane or in space.
    pub decoded_discrepancy_mm: f64,
    /// Of several shared axes, along the first.
    #[serde(flatten)]
    pub seen: LiveSummary,
    /// Of one shared axis, or the first.
    #[serde(flatten)]
    pub forces: Forces,
    /// Each of several shared axes.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<AxisReport>,
    /// What the wall in the room of its device pushed with over the last half, N of the device; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wall_force_n: Option<Statistics>,
    /// Energy through the ports of its coordination while armed, J, summed over all shared axes.
    pub port_energy: Ports,
    /// Why it stopped, if it did.
    pub fault: Option<String>,
    /// What its scene is at the delays measured last; none where nobody judged it.
    pub verdict: Option<Verdict>,
    /// Every change of that which was said, with the time in s since the start.
    pub verdicts: Vec<(f64, String)>,
    /// It never armed, for its scene was unstable. Absent of one that was not refused.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub refused: bool,
    /// What the link reported, in order.
    pub notices: Vec<Noticed>,
    /// Smoothed round trip of the link, µs; none if none was measured.
    pub round_trip_us: Option<u32>,
    /// Mean deviation of the round trip, µs.
    pub jitter_us: u32,
    /// The other peer's clock less this one's, µs.
    pub clock_offset_us: Option<i64>,
    /// How much faster the other peer's clock runs, ppm.
    pub clock_drift_ppm: f32,
    /// What the other peer's newest telemetry says; none before any came.
    pub other: Option<RemoteReport>,
    /// Sealed datagrams of the other peer that were opened and accepted.
    pub datagrams_taken: u32,
    /// Sealed datagrams of the other peer that never came.
    pub datagrams_missing: u32,
    /// Datagrams refused: forged, replayed or broken.
    pub datagrams_refused: u32,
    /// Which way it went, and what both ways were like; absent where the other one was called at an address.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub path: Option<PathReport>,
    /// How well the control loop kept its ticks.
    pub punctuality: Punctuality,
    /// What was seen of its device; absent of a simulated one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device: Option<DeviceReport>,
}

/// Forces along one axis, over the last half.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Forces {
    /// Mean coordination force F_T, N.
    pub coordination_force_n: f64,
    /// Contact force F_LC, N of the world.
    pub contact_force_n: Statistics,
}

/// What one peer saw along one of several shared axes.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AxisReport {
    pub(super) axis: &'static str,
    pub(super) decoded_discrepancy_mm: f64,
    #[serde(flatten)]
    pub(super) forces: Forces,
}

/// Energy through the ports of its coordination while armed, J, of all shared axes; the most by which what came out exceeded what went
/// in, with both ports at the end of the same tick; and the verdict of it, the least balance E₀ + in − out with what its law began with (E₀): a
/// peer whose law is passive is never below 0 but for rounding.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Ports {
    #[serde(flatten)]
    pub(super) energy: PortEnergy,
    pub(super) least_balance_j: f64,
}

/// What the other peer's telemetry says.
#[derive(Clone, Debug, Serialize)]
pub struct RemoteReport {
    ticks: u32,
    /// Its mode, or its fault with the reason.
    state: String,
    /// Its coordination force F_T on the object, N; of several shared axes along the first.
    pub coordination_force_n: f32,
    /// From and to the network.
    energy_received_j: f64,
    energy_sent_j: f64,
}

impl RemoteReport {
    /// From telemetry of the other peer, as it came.
    pub fn new(said: &Telemetry) -> Self {
        Self {
            ticks: said.tick,
            state: mode_words([said.mode, said.fault]),
            coordination_force_n: said.coordination_force,
            energy_received_j: said.energy_received,
            energy_sent_j: said.energy_sent,
        }
    }
}
