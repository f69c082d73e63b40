//! A cell of the campaign: one way to hold the copies together over one network, run with every seed.

use rayon::prelude::*;

use cohold_analysis::judge;
use cohold_core::law::Promise;
use cohold_core::safety::Fault;
use cohold_core::settings::Refused;
use cohold_sim::measure::growth::Forces;
use cohold_sim::measure::swing::{Felt, felt};
use cohold_sim::pair::Pair;
use cohold_sim::peers::Builds;
use cohold_sim::plant::Plant;
use cohold_sim::run::{Options, Outcome, Verdict, run};
use cohold_sim::scene::Scene;
use cohold_sim::{of_axes, user::Trace, user::User};

use crate::entrant::Entrant;
use crate::study::{Place, Study};
use crate::sweep::{Plan, unstable_modes};
use crate::{Error, estimate::Estimate};

/// Simulated time of a run, s.
pub const DURATION_S: f64 = 20.0;

/// Runs of a cell whose network is random.
pub const SEEDS: u32 = 20;

/// What either user pushes in the run that measures the mobility, N.
pub const PUSH_N: f64 = 1.0;

/// And for how long, s.
pub const PUSH_S: f64 = 1.0;

/// After how long at rest, s: a line that follows the network has learned it.
pub const REST_S: f64 = 3.0;

/// What a common push shows.
#[derive(Clone, Copy, Debug)]
struct PushOutcome {
    /// How far the copies are in the end, their mean, m.
    displacement_m: f64,
    /// Largest |F_T|, N.
    peak_n: f64,
}

/// One way to hold the copies together over one network.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Name of the law, or of the scene.
    pub law: String,
    /// Name of the network.
    pub network: String,
    /// Whether it promises to be passive on any network.
    pub passive: bool,
    /// What the runs gave, seed by seed.
    pub outcomes: Vec<Outcome>,
    /// The modes in which the scene over this network is not stable, as in [`crate::sweep::Row`].
    pub unstable_modes: String,
    /// What a slow swing shows of a scene that is stable, its delay less the network's own; of [`super::costs`] only.
    pub swing: Option<Felt>,
    /// Common pushes, seed by seed; none of one in which a peer stopped.
    pushes: Vec<Option<PushOutcome>>,
    /// How far the push moves the copies on the scene's own network, m.
    free_displacement_m: Option<f64>,
}

impl Cell {
    /// Whether every run was stable.
    pub fn is_stable(&self) -> bool {
        self.outcomes.iter().all(Outcome::is_stable)
    }

    /// Runs of this verdict.
    pub fn count(&self, verdict: Verdict) -> usize {
        self.outcomes.iter().filter(|outcome| outcome.verdict() == verdict).count()
    }

    /// The worst verdict, and of how many of the runs.
    pub fn verdict(&self) -> String {
        let worst = [Verdict::Unstable, Verdict::Apart].into_iter().find(|verdict| self.count(*verdict) > 0);
        let worst = worst.unwrap_or(Verdict::Stable);
        format!("{} {}/{}", worst.name(), self.count(worst), self.outcomes.len())
    }

    /// What it is of every run, if all were whole.
    fn metric(&self, of: impl Fn(&Outcome) -> f64) -> Option<Vec<f64>> {
        self.outcomes.iter().map(|outcome| outcome.metric(&of)).collect()
    }

    /// The largest of all runs, if all were whole.
    pub fn worst(&self, of: impl Fn(&Outcome) -> f64) -> Option<f64> {
        // What is no number of one run is none of all: they are of one scene.
        self.metric(of)?.into_iter().reduce(f64::max).filter(|worst| !worst.is_nan())
    }

    /// The true discrepancy over the seeds, if all runs were whole.
    pub fn true_discrepancy_mm(&self) -> Option<Estimate> {
        self.metric(|outcome| outcome.whole.true_discrepancy_mm).map(|values| Estimate::of(&values))
    }

    /// The decoded discrepancy at peer 2 over the seeds, if all runs were whole.
    pub fn decoded_discrepancy_mm(&self) -> Option<Estimate> {
        self.metric(|outcome| outcome.whole.decoded_discrepancy_mm).map(|values| Estimate::of(&values))
    }

    /// The mobility: how far a common push moves the copies, over that on the scene's own network, if no peer stopped
    /// in either.
    pub fn mobility(&self) -> Option<Estimate> {
        let free_m = self.free_displacement_m?;
        let pushes: Option<Vec<f64>> = self.pushes.iter().map(|push| Some((*push)?.displacement_m / free_m)).collect();
        pushes.map(|pushes| Estimate::of(&pushes))
    }

    /// The largest |F_T| of any common push, N.
    pub fn push_peak_n(&self) -> Option<f64> {
        self.pushes.iter().try_fold(0.0_f64, |most, push| Some(most.max((*push)?.peak_n)))
    }

    /// The fault of the first run that had one.
    pub fn fault(&self) -> Option<(usize, Fault)> {
        self.outcomes.iter().find_map(|outcome| outcome.fault)
    }

    /// Why the first of the runs with the worst verdict is not stable.
    pub fn reason(&self) -> Option<String> {
        let failed = |outcome: &&Outcome| outcome.verdict() == Verdict::Unstable;
        let first = self.outcomes.iter().find(failed).or(self.outcomes.iter().find(|outcome| !outcome.is_stable()));
        first.and_then(|outcome| outcome.reason).map(|reason| reason.to_string())
    }
}

/// Both users push the same way, from rest, along the first shared axis.
fn push(scene: &Scene) -> Result<Option<PushOutcome>, Refused<'static>> {
    of_axes!(scene, pushed(scene))
}

fn pushed<const SHARED: usize, const N: usize>(scene: &Scene) -> Result<Option<PushOutcome>, Refused<'static>>
where
    f64: Builds<SHARED, N>,
{
    let mut pushed = scene.clone();
    for (user, sign) in pushed.users.iter_mut().zip([1.0, -1.0]) {
        // The arm stays, what the user does with it does not. A push of user 2 toward the other peer is toward negative x.
        let arm = user.settings.user;
        *user = User::default();
        let own = &mut user.settings.user;
        own.arm_damping_n_s_per_m = arm.arm_damping_n_s_per_m;
        own.arm_mass_kg = arm.arm_mass_kg;
        user.trace = Some(Trace::step(REST_S, sign * PUSH_N));
    }
    let mut pair = Pair::<f64, Plant<N>, SHARED, N>::build(&pushed)?;
    let ticks = |time_s: f64| (time_s / scene.peer.timing.control_period_s).round() as u64;
    (0..ticks(REST_S)).for_each(|_| pair.step());
    let ticks = ticks(PUSH_S);
    // Along every axis: what mechanisms couple shows along the others.
    let mut forces = Forces::new(ticks);
    let middle = |pair: &Pair<f64, Plant<N>, SHARED, N>| {
        pair.sides().map(|side| side.peer.observed()[0].object.position).iter().sum::<f64>() / 2.0
    };
    let mut start_m = 0.0;
    for tick in 0..ticks {
        pair.step();
        let along = pair.sides().map(|side| side.peer.observed().map(|seen| seen.coordination_force));
        forces.see(tick, along.into_iter().flatten());
        if tick == 0 {
            start_m = middle(&pair);
        }
    }
    let push = PushOutcome { displacement_m: middle(&pair) - start_m, peak_n: forces.peak() };
    Ok(pair.fault().is_none().then_some(push))
}

/// Whether this scene promises to be passive on any network: its law does, or the ledger that pays for what the law emits.
fn is_passive(scene: &Scene) -> bool {
    scene.peer.coordination.ledger || scene.law().promises.contains(&Promise::Passive)
}

/// Every cell of a study, scene by scene, network by network; with a swing of so many periods of what is stable, 0 for none.
pub(super) fn of(study: &Study, periods: u32) -> Result<Vec<Cell>, Error> {
    let free = |entrant: &Entrant| Ok(push(&entrant.scene)?.map(|push| push.displacement_m));
    let free_m = study.entrants.par_iter().map(free).collect::<Result<Vec<Option<f64>>, Error>>()?;
    let job = |_, scene: &Scene| {
        let outcome = run::<f64>(scene, Options::unrecorded(study.seconds()), &|_| {})?;
        Ok((outcome, push(scene)?))
    };
    let cell = |(point, runs): (usize, Vec<(Outcome, Option<PushOutcome>)>)| {
        let (scene, Place { entrant, network, .. }) = (study.scene_at(point)?, study.place(point));
        let (outcomes, pushes) = runs.into_iter().unzip();
        let mut cell = Cell {
            law: study.entrants[entrant].name.clone(),
            network: study.networks[network].name.clone(),
            passive: is_passive(&scene),
            outcomes,
            unstable_modes: unstable_modes(&judge(&scene)?),
            swing: None,
            pushes,
            free_displacement_m: free_m[entrant],
        };
        if periods > 0 && cell.is_stable() {
            let timing = &scene.peer.timing;
            let own_s = timing.packet_period_s() * f64::from(scene.world.network.one_way_delay_packets);
            let swing = felt(&scene, periods)?;
            cell.swing = Some(Felt { delay_s: swing.delay_s - own_s, ..swing });
        }
        Ok(cell)
    };
    study.each(&job)?.into_par_iter().enumerate().map(cell).collect()
}
