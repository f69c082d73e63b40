//! Account of a run along one axis, tick by tick, of which its [`AxisOutcome`] is formed.

use std::array::from_fn;

use cohold_columns::{Columns, numbered};
use cohold_core::num::Scalar;
use cohold_core::peer::Observed;
use cohold_core::safety::{Fault, Mode};
use cohold_core::sample::{OfAxis, OfPeer, PeerQuantity, Quantities, Quantity, Reach, SAMPLE};

use super::outcome::{AxisOutcome, Figures, Options};
use crate::measure::growth::{Forces, Growth, Swing, Swings};
use crate::measure::hands::Hands;
use crate::measure::port::ObjectPort;
use crate::measure::{Figure, LastHalf, Statistics};
use crate::peers::DynPeer;
use crate::quantities::{Named, TRUE_DISCREPANCY};

/// What is recorded of each peer beside its quantities: at the object port, which the run has and the peer has not.
const OF_PORT: [Named; 2] = [
    ("energy_to_object_j", "work of F_T on the copy, at the mean velocity of the copy over a tick, since arming"),
    (
        "energy_from_object_j",
        "work of the copy against F_T, at the mean velocity of the copy over a tick, since arming",
    ),
];

/// What is recorded of both peers together.
const OF_BOTH: [Named; 2] =
    [TRUE_DISCREPANCY, ("decoded_discrepancy_2_m", "distance of peer 2's copy from its x_d, |x_o2 - x_d|")];

/// What is recorded of a peer as a whole: its mode and its fault. Its ticks, which come before them, are the rows.
fn of_peer(quantities: &Quantities) -> &'static [PeerQuantity] {
    &quantities.peer[1..]
}

/// State of one peer along one shared axis after a tick, as an [`Account`] takes it in.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ticked<F = f64> {
    observed: Observed<F>,
    received_j: F,
    sent_j: F,
    mode: Mode,
    engaged: bool,
}

impl<F: Figure> Ticked<F> {
    /// From motions and forces of a tick, the energy from and to the network so far (J), the mode, and whether the law
    /// acts (the peer is engaged).
    #[inline(always)]
    pub fn new<S: Scalar<Counter = F>>(
        observed: &Observed<S>,
        [received_j, sent_j]: [S; 2],
        mode: Mode,
        engaged: bool,
    ) -> Self {
        Self {
            observed: observed.map(S::to_counter),
            received_j: received_j.to_counter(),
            sent_j: sent_j.to_counter(),
            mode,
            engaged,
        }
    }

    /// The state of a simulated peer after a tick, along each shared axis.
    #[inline(always)]
    pub fn of<S: Scalar<Counter = F>, const SHARED: usize, const N: usize>(
        peer: &dyn DynPeer<S, SHARED, N>,
    ) -> [Self; SHARED] {
        let (seen, ledgers, mode, engaged) = (peer.observed(), peer.ledger(), peer.mode(), peer.is_engaged());
        from_fn(|axis| {
            let energy = [ledgers[axis].received_j(), ledgers[axis].sent_j()];
            Self::new(seen[axis], energy, mode, engaged)
        })
    }
}

/// Account of a run along one shared axis: discrepancies, forces, energies and the recorded ticks.
#[derive(Clone, Debug)]
pub struct Account<F = f64> {
    period_s: f64,
    mass_kg: F,
    record_every: u64,
    tick: u64,
    latest: [Ticked<F>; 2],
    ports: [ObjectPort<F>; 2],
    /// The most that either end has taken from the network beyond what the other had given to it, J.
    made_j: F,
    halves: LastHalf<5, F>,
    pub(crate) forces: Forces<F>,
    hands: Hands<1, F>,
    /// Of the square root of the copies' kinetic energy, an amplitude as a force is.
    pub(crate) energy: Growth<F>,
    swing: Swing<F>,
    /// Who stopped first, why, and when (s).
    pub(crate) stopped: Option<(usize, Fault, f64)>,
    /// |x_o1 − x_o2| after the control period that is over, m.
    pub(crate) true_m: F,
    largest_true_m: F,
    table: Columns,
}

impl<F: Figure> Account<F> {
    /// Of a run of so many ticks of this period (s), of copies of this mass (kg) and stiffness K_T (N/m).
    pub(crate) fn of(period_s: f64, mass_kg: F, stiffness_n_per_m: F, ticks: u64, options: Options) -> Self {
        Self {
            period_s,
            mass_kg,
            record_every: options.record_every,
            tick: 0,
            latest: Default::default(),
            ports: [ObjectPort::new(F::from_f64(period_s), stiffness_n_per_m); 2],
            made_j: F::ZERO,
            halves: LastHalf::new(ticks),
            forces: Forces::new(ticks),
            hands: Hands::default(),
            energy: Growth::new(ticks),
            swing: Swing::new(),
            stopped: None,
            true_m: F::ZERO,
            largest_true_m: F::ZERO,
            table: Columns::named(Account::columns()),
        }
    }

    /// Takes in a tick of peer `at` (0 or 1).
    #[inline(always)]
    pub fn ticked(&mut self, at: usize, ticked: Ticked<F>) {
        self.ports[at].see(&ticked.observed, [ticked.received_j, ticked.sent_j]);
        self.latest[at] = ticked;
    }

    /// Takes in what the motors of peer `at` press with along this axis in that tick, N.
    #[inline(always)]
    pub(crate) fn pressed(&mut self, at: usize, force: F) {
        self.hands.see(at, [force]);
    }

    /// A control period is over. After a fault nothing is averaged: what stands still would look good.
    #[inline(always)]
    pub(crate) fn measure(&mut self) {
        let [first, second] = self.latest.each_ref().map(|ticked| &ticked.observed);
        self.true_m = (first.object.position - second.object.position).abs();
        self.largest_true_m = self.largest_true_m.larger(self.true_m);
        let decoded_m = (second.object.position - second.desired.position).abs();
        let forces = [first.coordination_force, second.coordination_force];
        self.forces.see(self.tick, forces);
        let [one, other] = &self.latest;
        let made_j = (other.received_j - one.sent_j).larger(one.received_j - other.sent_j);
        self.made_j = self.made_j.larger(made_j);
        let speeds = [first.object.velocity, second.object.velocity];
        let energy_j = F::HALF * self.mass_kg * (speeds[0] * speeds[0] + speeds[1] * speeds[1]);
        self.energy.see(self.tick, energy_j.root());
        self.swing.see(&self.energy, forces[1]);
        let fault = (1..).zip(&self.latest).find_map(|(peer, ticked)| match ticked.mode {
            Mode::Faulted(fault) => Some((peer, fault)),
            _ => None,
        });
        self.stopped = self.stopped.or(fault.map(|(peer, fault)| (peer, fault, self.tick as f64 * self.period_s)));
        if self.stopped.is_none() {
            let contact = F::HALF * (first.contact_force.abs() + second.contact_force.abs());
            self.halves.see(self.tick, [self.true_m, decoded_m, forces[1], forces[1] * forces[1], contact]);
        }
        self.tick += 1;
    }

    /// What the last tick of peer `at` (0 or 1) saw and did.
    #[inline]
    pub(crate) fn observed(&self, at: usize) -> &Observed<F> {
        &self.latest[at].observed
    }

    /// What `of` makes of each number.
    pub(crate) fn map<G: Copy>(&self, of: impl Fn(F) -> G + Copy) -> Account<G> {
        Account {
            period_s: self.period_s,
            mass_kg: of(self.mass_kg),
            record_every: self.record_every,
            tick: self.tick,
            latest: self.latest.map(|ticked| Ticked {
                observed: ticked.observed.map(of),
                received_j: of(ticked.received_j),
                sent_j: of(ticked.sent_j),
                mode: ticked.mode,
                engaged: ticked.engaged,
            }),
            ports: self.ports.each_ref().map(|port| port.map(of)),
            made_j: of(self.made_j),
            halves: self.halves.map(of),
            forces: self.forces.map(of),
            hands: self.hands.map(of),
            energy: self.energy.map(of),
            swing: self.swing.map(of),
            stopped: self.stopped,
            true_m: of(self.true_m),
            largest_true_m: of(self.largest_true_m),
            table: self.table.clone(),
        }
    }
}

impl Account {
    /// The columns of a row, by name and meaning; each peer's with its number before the unit.
    pub fn columns() -> impl Iterator<Item = (String, String)> {
        Self::columns_of(&SAMPLE)
    }

    /// [`Account::columns`] of another list of quantities.
    pub fn columns_of(quantities: &Quantities) -> impl Iterator<Item = (String, String)> + use<> {
        let owned = |(name, meaning): Named| (name.to_owned(), meaning.to_owned());
        let of_axis = quantities.reaching(Reach::Runs);
        let of_peer = of_peer(quantities);
        let of = move |peer| {
            let named = of_peer.iter().map(Quantity::named).chain(of_axis.clone().map(Quantity::named)).chain(OF_PORT);
            named.map(move |(name, meaning)| (numbered(name, peer), format!("peer {peer}: {meaning}")))
        };
        let time = ("time_s", "since the start of the run");
        std::iter::once(owned(time)).chain((1..=2).flat_map(of)).chain(OF_BOTH.map(owned))
    }

    /// Ends a control period: adds it to the figures, and records it if it is one of those to be kept.
    pub fn period(&mut self) {
        self.measure();
        self.record();
    }

    /// How the coordination force of peer 2 goes on swinging beyond what users push with, N.
    pub(crate) fn goes_on_swinging(&self, pushes_n: f64) -> Option<Swings> {
        self.swing.goes_on(&self.energy, pushes_n, self.period_s)
    }

    /// The first peer that does not coordinate after the control period that is over, 1 or 2.
    pub(crate) fn let_go(&self) -> Option<usize> {
        (1..).zip(&self.latest).find_map(|(peer, ticked)| (!ticked.engaged).then_some(peer))
    }

    /// The control period that is over, as a row of [`Self::columns`].
    pub fn row(&self) -> Vec<f64> {
        self.row_of(&SAMPLE)
    }

    /// [`Account::row`] of another list of quantities.
    pub fn row_of(&self, quantities: &Quantities) -> Vec<f64> {
        let mut row = vec![self.tick.saturating_sub(1) as f64 * self.period_s];
        for (ticked, port) in self.latest.iter().zip(&self.ports) {
            let Ticked { observed, received_j, sent_j, mode, .. } = ticked;
            let peer = OfPeer::new(self.tick, *mode);
            for quantity in of_peer(quantities) {
                row.push((quantity.get)(&peer));
            }
            let of = OfAxis { observed, received_j: *received_j, sent_j: *sent_j };
            row.extend(quantities.reaching(Reach::Runs).map(|quantity| (quantity.get)(&of)));
            let energy = port.with_network(*received_j, *sent_j);
            row.extend([energy.to_object_j, energy.from_object_j]);
        }
        let second = self.latest[1].observed;
        row.extend([self.true_m, (second.object.position - second.desired.position).abs()]);
        row
    }

    /// What it gave along this axis.
    pub(crate) fn along(self) -> AxisOutcome {
        let [true_m, decoded_m, force, force_squared, contact] = self.halves.means();
        let energy = [0, 1].map(|at| {
            let ticked = self.latest[at];
            self.ports[at].with_network(ticked.received_j, ticked.sent_j)
        });
        let figures = Figures {
            true_discrepancy_mm: 1e3 * true_m,
            largest_true_discrepancy_mm: 1e3 * self.largest_true_m,
            decoded_discrepancy_mm: 1e3 * decoded_m,
            coordination_force_n: Statistics::of_moments(force, force_squared),
            contact_force_n: contact,
            peak_coordination_force_n: self.forces.peak(),
            largest_jump_n: self.forces.largest_change(),
            peak_hand_force_n: self.hands.peak,
            largest_hand_change_n: self.hands.change,
            energy,
            made_j: self.made_j,
        };
        AxisOutcome { figures, table: self.table }
    }

    /// Records the control period that is over, if it is one of those that are.
    pub(crate) fn record(&mut self) {
        if self.record_every > 0 && (self.tick - 1).is_multiple_of(self.record_every) {
            self.table.push_row(&self.row());
        }
    }
}
