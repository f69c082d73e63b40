//! The figures of merit of a run that a sweep keeps: those that `cooperate` and the campaign tell, as [`Outcome`] gives them.

use cohold_protocol::wire::packet_bytes;
use cohold_report::Rows;
use cohold_sim::run::Outcome;

/// A figure of merit.
#[derive(Clone, Copy, Debug)]
pub struct Metric {
    /// Its name without the unit.
    pub stem: &'static str,
    /// The unit, as names end; empty for a ratio.
    pub unit: &'static str,
    /// Meaning of the figure.
    pub meaning: &'static str,
    /// Whether a table for people shows it.
    pub shown: bool,
    /// The figure of a run; none of one that failed.
    pub of: fn(&Outcome) -> Option<f64>,
}

/// Mean rate of one peer's packets on the wire, bytes/s; a link's own datagrams beside the flow are not counted.
pub fn bytes_per_s(outcome: &Outcome) -> f64 {
    outcome.packets_per_s * packet_bytes(outcome.axes.len()) as f64
}

impl Metric {
    /// Its name, with the unit.
    pub fn name(&self) -> String {
        self.named("")
    }

    /// The last column in text only where people are shown it.
    pub(super) fn in_text<'a, R>(&self, columns: Rows<'a, R>) -> Rows<'a, R> {
        if self.shown { columns } else { columns.data_only() }
    }

    /// Its name with so much behind the stem; `_95` is half the 95 % interval.
    pub(super) fn named(&self, what: &str) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!("_{}", self.unit) };
        format!("{}{what}{unit}", self.stem)
    }
}

macro_rules! metrics {
    ($($stem:literal $unit:literal $shown:literal $meaning:literal $of:expr;)+) => {
        [$(Metric { stem: $stem, unit: $unit, meaning: $meaning, shown: $shown, of: $of }),+]
    };
}

/// All figures of merit. Those marked `whole` count in runs in which the copies came apart, too; the others only in stable runs.
pub const METRICS: [Metric; 14] = metrics! {
    "true_discrepancy" "mm" true "mean of |x_o1 - x_o2| over the last half" |o| o.metric(|o| o.whole.true_discrepancy_mm);
    "largest_true_discrepancy" "mm" false "largest |x_o1 - x_o2| over the whole run" |o| o.metric(|o| o.whole.largest_true_discrepancy_mm);
    "true_discrepancy" "mm_per_n" false "mean of |x_o1 - x_o2| over that of the contact force, over the last half" |o| {
        o.metric(|o| (o.whole.contact_force_n > 0.0).then(|| o.whole.true_discrepancy_mm / o.whole.contact_force_n)).flatten()
    };
    "decoded_discrepancy" "mm" false "mean of |x_o - x_d| at peer 2 over the last half" |o| o.metric(|o| o.whole.decoded_discrepancy_mm);
    "coordination_force_mean" "n" true "mean of F_T at peer 2 over the last half" |o| o.metric(|o| o.whole.coordination_force_n.mean);
    "coordination_force_sd" "n" false "standard deviation of F_T at peer 2 over the last half" |o| o.metric(|o| o.whole.coordination_force_n.sd);
    "peak_coordination_force" "n" true "largest |F_T| of either peer over the whole run" |o| o.metric(|o| o.whole.peak_coordination_force_n);
    "largest_jump" "n" false "largest change of either F_T from tick to tick" |o| o.metric(|o| o.whole.largest_jump_n);
    "peak_hand_force" "n" false "largest force that either peer's motors press its hand with, over the whole run" |o| {
        o.metric(|o| o.whole.peak_hand_force_n)
    };
    "largest_hand_change" "n" false "largest change of that force from one tick to the next" |o| o.metric(|o| o.whole.largest_hand_change_n);
    "energy_made" "mj" true "the most that the network had given beyond what it was given" |o| o.metric(Outcome::energy_made_mj);
    "peer_energy_made" "mj" false "the most that the worse peer's coordination had given beyond what it took" |o| {
        o.metric(Outcome::peer_energy_made_mj).flatten()
    };
    "packets" "per_s" true "packets that a peer sent, mean of both" |o| o.metric(|o| o.packets_per_s);
    "wire" "bytes_per_s" false "the same in bytes, sealed, with UDP and IP version 4" |o| o.metric(bytes_per_s);
};
