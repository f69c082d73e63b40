//! Accounts of a run along all of its shared axes, and of the axes together: what its [`Outcome`] is formed of.
//!
//! One axis is its own whole, to the bit. Of several, discrepancies and forces of the whole are lengths of vectors, energies are sums.

use std::array::from_fn;

use super::account::{Account, Ticked};
use super::outcome::{AxisOutcome, Figures, Options, Outcome};
use super::reason::Reason;
use super::statics::{are_apart, compliance_m_per_n};
use crate::measure::growth::Forces;
use crate::measure::hands::Hands;
use crate::measure::{Figure, LastHalf, Statistics};
use crate::scene::Scene;
use crate::user::User;

/// Account of a run along `SHARED` axes.
#[derive(Clone, Debug)]
pub struct Accounts<const SHARED: usize = 1, F = f64> {
    axes: [Account<F>; SHARED],
    tick: u64,
    /// What a newton between the copies leaves at rest, m/N.
    compliance_m_per_n: F,
    /// The most that users push with, N.
    pushes_n: F,
    /// Of all axes together: |x_o1 − x_o2|, |x_o2 − x_d2|, mean |F_LC| of both peers. Nothing where there is one.
    halves: LastHalf<3, F>,
    true_m: F,
    largest_true_m: F,
    /// |F_T| of either peer, then how much it changed as a vector.
    forces: Forces<F>,
    hands: Hands<SHARED, F>,
    largest_jump: F,
    last: [[F; SHARED]; 2],
}

/// Length of a vector.
fn length<F: Figure>(parts: impl Iterator<Item = F>) -> F {
    parts.fold(F::ZERO, |sum, part| sum + part * part).root()
}

impl<const SHARED: usize, F: Figure> Accounts<SHARED, F> {
    /// Of a run of so many ticks of these scenes: `of` gives a number of theirs.
    pub(crate) fn of_each(like: &Scene, ticks: u64, options: Options, of: impl Fn(fn(&Scene) -> f64) -> F) -> Self {
        let period_s = like.peer.timing.control_period_s;
        let mass_kg = of(|scene| scene.peer.object.mass_kg);
        let stiffness_n_per_m = of(|scene| scene.peer.coordination.stiffness_n_per_m);
        Self {
            axes: from_fn(|_| Account::of(period_s, mass_kg, stiffness_n_per_m, ticks, options)),
            tick: 0,
            compliance_m_per_n: of(compliance_m_per_n),
            pushes_n: of(|scene| scene.users.iter().map(User::most_n).sum()),
            halves: LastHalf::new(ticks),
            true_m: F::ZERO,
            largest_true_m: F::ZERO,
            forces: Forces::new(ticks),
            hands: Hands::default(),
            largest_jump: F::ZERO,
            last: [[F::ZERO; SHARED]; 2],
        }
    }

    /// Takes in a tick of peer `at` (0 or 1) along each axis.
    #[inline(always)]
    pub fn ticked(&mut self, at: usize, ticked: [Ticked<F>; SHARED]) {
        for (axis, ticked) in self.axes.iter_mut().zip(ticked) {
            axis.ticked(at, ticked);
        }
    }

    /// Takes in what the motors of peer `at` press with along each axis in that tick, N; who never does has no figures of it.
    #[inline(always)]
    pub fn pressed(&mut self, at: usize, forces: [F; SHARED]) {
        self.axes.iter_mut().zip(forces).for_each(|(axis, force)| axis.pressed(at, force));
        if SHARED > 1 {
            self.hands.see(at, forces);
        }
    }

    /// A control period is over.
    #[inline(always)]
    pub(crate) fn measure(&mut self) {
        self.axes.iter_mut().for_each(Account::measure);
        if SHARED > 1 {
            self.measure_together();
        }
        self.tick += 1;
    }

    fn measure_together(&mut self) {
        self.true_m = length(self.axes.iter().map(|axis| axis.true_m));
        self.largest_true_m = self.largest_true_m.larger(self.true_m);
        let forces = [0, 1].map(|at| self.axes.each_ref().map(|axis| axis.observed(at).coordination_force));
        for (now, last) in forces.iter().zip(&mut self.last) {
            let jump = length(now.iter().zip(*last).map(|(now, last)| *now - last));
            self.largest_jump = self.largest_jump.larger(jump.or_infinite());
            *last = *now;
        }
        self.forces.see(self.tick, forces.map(|force| length(force.into_iter())));
        if !self.is_over() {
            let decoded = |axis: &Account<F>| {
                let second = axis.observed(1);
                second.object.position - second.desired.position
            };
            let decoded_m = length(self.axes.iter().map(decoded));
            let contact = |at: usize| length(self.axes.iter().map(|axis| axis.observed(at).contact_force));
            let contact_n = F::HALF * (contact(0) + contact(1));
            self.halves.see(self.tick, [self.true_m, decoded_m, contact_n]);
        }
    }

    /// A peer has stopped.
    #[inline]
    pub(crate) fn is_over(&self) -> bool {
        self.axes.iter().any(|axis| axis.stopped.is_some())
    }

    /// What `of` makes of each number.
    pub(crate) fn map<G: Copy>(&self, of: impl Fn(F) -> G + Copy) -> Accounts<SHARED, G> {
        Accounts {
            axes: self.axes.each_ref().map(|axis| axis.map(of)),
            tick: self.tick,
            compliance_m_per_n: of(self.compliance_m_per_n),
            pushes_n: of(self.pushes_n),
            halves: self.halves.map(of),
            true_m: of(self.true_m),
            largest_true_m: of(self.largest_true_m),
            forces: self.forces.map(of),
            hands: self.hands.map(of),
            largest_jump: of(self.largest_jump),
            last: self.last.map(|force| force.map(of)),
        }
    }
}

impl<const SHARED: usize> Accounts<SHARED> {
    /// An account of a run of so many ticks.
    pub fn new(scene: &Scene, ticks: u64, options: Options) -> Self {
        Self::of_each(scene, ticks, options, |number| number(scene))
    }

    /// Ends a control period: adds it to the figures, and records it if it is one of those to be kept.
    pub fn period(&mut self) {
        self.measure();
        self.axes.iter_mut().for_each(Account::record);
    }

    /// The account of each axis, in the order of [`super::AXIS_NAMES`].
    pub fn axes(&self) -> &[Account; SHARED] {
        &self.axes
    }

    /// The control period that is over, as a row of [`Account::columns`] for each axis.
    pub fn rows(&self) -> impl Iterator<Item = Vec<f64>> {
        self.axes.iter().map(Account::row)
    }

    /// Outcome of the run, without impacts and hash, which are not recorded here.
    pub fn outcome(self) -> Outcome {
        let ticks = self.tick;
        let stopped = self.axes.iter().find_map(|axis| axis.stopped);
        let let_go = self.axes.iter().find_map(Account::let_go);
        let force_grew = self.axes.iter().any(|axis| axis.forces.grew());
        let energy_grew = self.axes.iter().any(|axis| axis.energy.grew());
        let swings = self.axes.iter().find_map(|axis| axis.goes_on_swinging(self.pushes_n));
        let [true_m, decoded_m, contact_force_n] = self.halves.means();
        let last_true_m = if SHARED == 1 { self.axes[0].true_m } else { self.true_m };
        let axes: Vec<AxisOutcome> = self.axes.into_iter().map(Account::along).collect();
        let whole = if SHARED == 1 {
            axes[0].figures
        } else {
            // Means as a vector, and what scatters about it.
            let forces = axes.iter().map(|axis| axis.figures.coordination_force_n);
            Figures {
                true_discrepancy_mm: 1e3 * true_m,
                largest_true_discrepancy_mm: 1e3 * self.largest_true_m,
                decoded_discrepancy_mm: 1e3 * decoded_m,
                coordination_force_n: Statistics {
                    mean: length(forces.clone().map(|force| force.mean)),
                    sd: length(forces.map(|force| force.sd)),
                },
                contact_force_n,
                peak_coordination_force_n: self.forces.peak(),
                largest_jump_n: self.largest_jump,
                peak_hand_force_n: self.hands.peak,
                largest_hand_change_n: self.hands.change,
                energy: [0, 1].map(|at| axes.iter().map(|axis| axis.figures.energy[at]).sum()),
                made_j: axes.iter().map(|axis| axis.figures.made_j).sum(),
            }
        };
        let distances_mm = [whole.true_discrepancy_mm, 1e3 * last_true_m];
        let reason = if let Some((peer, fault, time_s)) = stopped {
            Some(Reason::Stopped { peer, fault, time_s })
        } else if force_grew {
            Some(Reason::ForceGrew)
        } else if energy_grew {
            Some(Reason::EnergyGrew)
        } else if let Some(swings) = swings {
            Some(Reason::Swings(swings))
        } else if are_apart(distances_mm, self.compliance_m_per_n, whole.coordination_force_n.mean) {
            Some(Reason::Apart { true_discrepancy_mm: distances_mm[0].max(distances_mm[1]) })
        } else {
            let_go.map(|peer| Reason::LetGo { peer })
        };
        Outcome {
            bounded: !matches!(reason, Some(Reason::Stopped { .. } | Reason::ForceGrew | Reason::EnergyGrew)),
            reason,
            fault: stopped.map(|(peer, fault, _)| (peer, fault)),
            fault_time_s: stopped.map(|(.., time_s)| time_s),
            whole,
            axes,
            impacts: None,
            ticks,
            packets_per_s: f64::NAN,
            hash: 0,
        }
    }
}
