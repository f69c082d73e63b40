//! Answers against a table made by hand, the rule of common networks, and runs that are a sweep's.

use std::path::Path;

use cohold_sim::run::{Options, Until, run};
use cohold_sim::scene::Scene;
use cohold_sim::scenes;
use cohold_studies::entrant::Entrant;
use cohold_studies::networks::Network;
use cohold_studies::study::answers::{Bound, Counts, Goal, metric};
use cohold_studies::study::{Place, Study};
use cohold_studies::sweep::{Axis, METRICS, Plan, Row, Sweep};

fn scene(name: &str, set: &[&str]) -> Scene {
    let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
    scenes::find(cohold_guest_laws::laws(), Some(Path::new(name)), &set).expect("a scene")
}

fn entrant(name: &str) -> Entrant {
    Entrant::of(cohold_guest_laws::laws(), name, None, &[]).expect("an entrant")
}

fn over(names: &[&str]) -> Vec<Network> {
    names.iter().flat_map(|name| Network::of(name).expect("a network")).collect()
}

/// Entrants A and B over two networks at three values of a key, of four seeds.
fn table() -> Study {
    let entrants = ["A", "B"].map(|name| Entrant { name: name.to_owned(), scene: scene("any-network", &[]) }).to_vec();
    let axis = "coordination.stiffness_n_per_m=100,200,300".parse().expect("an axis");
    Study::new(entrants, over(&["own", "loss 5 %"]), &[axis], None, 4, 1.0).expect("a study")
}

/// A run with this figure of merit (NaN: it failed), this force, and these modes.
fn row(point: usize, seed: u32, merit: f64, force: f64, modes: &str) -> Row {
    let mut metrics = [0.0; METRICS.len()];
    metrics[0] = merit;
    metrics[metric("peak_coordination_force_n").expect("a figure")] = force;
    Row {
        point,
        seed,
        verdict: if merit.is_nan() { "NO" } else { "stable" }.to_owned(),
        reason: if merit.is_nan() { "grows".to_owned() } else { String::new() },
        spectral_radius: 0.9,
        unstable_modes: modes.to_owned(),
        metrics,
        state_hash: format!("{merit} {point} {seed}"),
    }
}

/// The points in their order, each with the figures of four seeds, a force, and what is not stable.
fn rows(points: [([f64; 4], f64, &str); 12]) -> Vec<Row> {
    let of = |(point, (merits, force, modes)): (usize, ([f64; 4], f64, &str))| {
        (1..).zip(merits).map(move |(seed, merit)| row(point, seed, merit, force, modes)).collect::<Vec<_>>()
    };
    points.into_iter().enumerate().flat_map(of).collect()
}

const FAILED: [f64; 4] = [1.0, f64::NAN, 1.0, 1.0];
const GOAL: Goal = Goal { metric: 0, bounds: Vec::new() };

fn made_by_hand() -> Vec<Row> {
    rows([
        // A on its own: the first point is least by the seeds that choose (2 and 2; 3 and 3), and worse by those that judge.
        ([2.0, 2.0, 5.0, 7.0], 1.0, ""),
        ([3.0, 3.0, 4.0, 4.5], 1.0, ""),
        ([0.1, 0.1, 0.1, 0.1], 1.0, "one; none"),
        // A on the other network: one fails, one is beyond 5 N, one is left.
        (FAILED, 1.0, ""),
        ([1.0, 1.0, 1.0, 2.0], 9.0, ""),
        ([4.0, 4.0, 4.0, 6.0], 1.0, ""),
        // B on its own.
        ([9.0, 9.0, 8.0, 8.0], 1.0, ""),
        ([6.0, 6.0, 7.0, 9.0], 1.0, ""),
        ([8.0, 8.0, 9.0, 9.5], 1.0, ""),
        // B on the other network: nothing that may be taken.
        (FAILED, 1.0, ""),
        ([0.5, 0.5, 0.5, 0.5], 1.0, "none"),
        (FAILED, 1.0, "both"),
    ])
}

/// t with one degree of freedom is 12.7062: of 5 and 7 the mean is 6 ± 12.7062 · 1.
#[test]
fn the_seeds_that_choose_do_not_judge() {
    let (study, rows) = (table(), made_by_hand());
    let answers = study.answers(&rows, &GOAL);
    assert_eq!(answers.len(), 4);
    let best = answers[0].best.as_ref().expect("a best point");
    assert_eq!((best.point, best.seeds, best.judged.mean), (0, 2, 6.0));
    assert!((best.judged.within_95.expect("an interval") - 12.706_204_736).abs() < 1e-6, "{best:?}");
    // Of 4 − 5 and 4.5 − 7 the mean is −1.75 ± 12.7 · 0.75: not told apart. What lets go is not asked.
    assert_eq!(best.as_good, [0, 1]);
    let next = best.next.as_ref().expect("a runner-up");
    assert_eq!((next.grid, next.seeds, next.judged, next.difference.mean), (1, 2, true, -1.75));
    assert!((next.difference.within_95.expect("an interval") - 9.529_653_55).abs() < 1e-6, "{next:?}");
    assert_eq!(answers[0].counts, Counts { points: 3, failed: 0, let_go: 1, beyond: 0, given_up: 0 });
    assert_eq!(answers[3].counts, Counts { points: 3, failed: 2, let_go: 1, beyond: 0, given_up: 0 });
    assert!(answers[3].best.is_none());
    // Nothing else may be taken there.
    assert!(answers[1].best.as_ref().is_some_and(|best| best.next.is_none() == (answers[1].counts.allowed() == 1)));
    let told = study.answer_columns(&answers, &GOAL).row(0);
    assert_eq!((&told["next"], &told["next_seeds"], &told["next_judged"]), (&"200".into(), &2.into(), &true.into()));
}

#[test]
fn a_bound_holds_in_every_run() {
    let (study, rows) = (table(), made_by_hand());
    let bounds = vec!["peak_coordination_force_n=5".parse::<Bound>().expect("a bound")];
    let answers = study.answers(&rows, &Goal { metric: 0, bounds });
    let place = |at: usize| answers[at].best.as_ref().map(|best| study.place(best.point).grid);
    assert_eq!(place(1), Some(2));
    assert_eq!(answers[1].counts, Counts { points: 3, failed: 1, let_go: 0, beyond: 1, given_up: 0 });
    assert_eq!(study.answers(&rows, &GOAL)[1].best.as_ref().map(|best| study.place(best.point).grid), Some(1));
}

/// B has nothing on the second network: over all, A is compared with it on the first one alone, and not by a mean over what each has.
#[test]
fn pairs_are_compared_where_both_are() {
    let (study, rows) = (table(), made_by_hand());
    let answers = study.answers(&rows, &GOAL);
    let pairs = study.pairs(&rows, &answers, &GOAL);
    let told: Vec<_> = pairs.iter().map(|pair| (pair.network, pair.common.clone(), pair.paired.means)).collect();
    let (own, none) = ([Some(6.0), Some(8.0)], [None, None]);
    assert_eq!(told, [(Some(0), vec![0], own), (Some(1), vec![], none), (None, vec![0], own)]);
    // Of 7 − 5 and 9 − 7: 2, and nothing beside it.
    assert_eq!(pairs[2].paired.difference.map(|found| (found.mean, found.within_95)), Some((2.0, Some(0.0))));
    let table = study.pair_columns(&pairs);
    assert_eq!(table.row(2)["without"], "loss 5 %");
    assert_eq!((&table.row(2)["common_networks"], &table.row(2)["of_networks"]), (&1.into(), &2.into()));
}

/// Over two networks that both have, a seed's figure is the mean of both: 1, 3 against 2, 5 differ by 1 and 2.
#[test]
fn over_several_networks_the_seeds_are_paired() {
    let study = table();
    let same = |a: f64, b: f64| ([a, a, a, b], 1.0, "");
    let (one, two) = (same(0.0, 2.0), same(2.0, 4.0));
    let (three, four) = (same(1.0, 4.0), same(3.0, 6.0));
    let rows = rows([one, one, one, two, two, two, three, three, three, four, four, four]);
    let answers = study.answers(&rows, &GOAL);
    let pairs = study.pairs(&rows, &answers, &GOAL);
    assert_eq!(pairs[2].common, [0, 1]);
    assert_eq!(pairs[2].paired.means, [Some(2.0), Some(3.5)]);
    let found = pairs[2].paired.difference.expect("a difference");
    // 1 and 2: mean 1.5, half of the difference 0.5 times 12.7062.
    assert!(found.mean == 1.5 && (found.within_95.expect("an interval") - 6.353_102).abs() < 1e-5, "{found:?}");
}

/// One scene on its own network has a sweep's rows, to the last bit.
#[test]
fn a_sweep_is_a_study() {
    let one = entrant("paper-5.2-wave-16ms,network.loss=0.2");
    let axes: Vec<Axis> = vec!["coordination.stiffness_n_per_m=300..3000:3:log".parse().expect("an axis")];
    let sweep = Sweep { scene: one.scene.clone(), axes: axes.clone(), sample: None, seeds: 2, seconds: 1.0 };
    let study = Study::new(vec![one], over(&["own"]), &axes, None, 2, 1.0).expect("a study");
    let all = |plan: &Sweep| plan.run(Until::TheEnd, 0..plan.points(), Vec::new(), &|_| Ok(())).expect("rows");
    let rows = study.run(Until::TheEnd, 0..study.points(), Vec::new(), &|_| Ok(())).expect("rows");
    assert_eq!(Row::lines(&rows).expect("lines"), Row::lines(&all(&sweep)).expect("lines"));
}

/// A point has its network's settings over its entrant's, and the key that is varied.
#[test]
fn a_point_is_an_entrant_over_a_network() {
    let axes = ["object.mass_kg=0.1,0.2".parse().expect("an axis")];
    let networks = over(&["own", "bursts of 40 ms, 20 %"]);
    let study = Study::new(["wave", "power"].map(entrant).to_vec(), networks, &axes, None, 3, 1.0).expect("a study");
    assert_eq!((study.points(), study.runs()), (8, 24));
    let scene = study.scene_at(7).expect("a scene");
    assert_eq!(study.place(7), Place { entrant: 1, network: 1, grid: 1 });
    assert_eq!((scene.law().name, scene.world.network.loss, scene.peer.object.mass_kg), ("power", 0.2, 0.2));
    // 40 ms are five packets of 8 ms.
    assert_eq!(scene.world.network.loss_burst_packets, 5.0);
}

#[test]
fn what_cannot_be_asked_is_refused() {
    let said = |entrants: &[&str], networks: &[&str], axis: &str| {
        let axes = [axis.parse::<Axis>().expect("an axis")];
        let entrants = entrants.iter().map(|name| entrant(name)).collect();
        let study = Study::new(entrants, over(networks), &axes, None, 2, 1.0);
        study.and_then(|study| study.check()).expect_err("refused").to_string()
    };
    let mass = "object.mass_kg=0.1,0.2";
    assert_eq!(said(&["wave", "wave"], &["own"], mass), "wave takes part twice");
    assert_eq!(said(&["wave"], &["own", "own"], mass), "the network \"own\" stands there twice");
    let ruled = said(&["wave"], &["loss 5 %"], "network.loss=0,0.1");
    assert_eq!(ruled, "network.loss is varied, and the network \"loss 5 %\" rules it: take another network");
    let wrong = said(&["wave"], &["own"], "object.mass_kg=0.1,-1");
    assert!(wrong.contains("wave: ") && wrong.contains("object.mass_kg = -1 is not allowed"), "{wrong}");
    let unknown = Network::of("los 5 %").expect_err("no such network").to_string();
    assert!(unknown.contains("did you mean \"loss 5 %\"?") && unknown.contains("\"own\", "), "{unknown}");
    let bound = |text: &str| text.parse::<Bound>().expect_err("no bound").to_string();
    assert!(bound("force=3").starts_with("they are true_discrepancy_mm, "));
    assert!(bound("true_discrepancy_mm").starts_with("write it as NAME=MOST"));
    assert!(bound("true_discrepancy_mm=much").contains("must be a number"));
}

/// Runs of several points and seeds go side by side; rows are those of each run alone, and those of seeds from which nothing is drawn are the
/// same but for the seed.
#[test]
fn rows_are_those_of_each_run_alone() {
    for (loss, draws) in [("network.loss=0.2", true), ("network.extra_delay_s=0.001", false)] {
        let mut entrant = entrant("paper-5.2-wave-16ms");
        entrant.scene.apply_override(loss).expect("a good override");
        let axis = "coordination.stiffness_n_per_m=100,200,300,400,500".parse().expect("an axis");
        let study = Study::new(vec![entrant], over(&["own"]), &[axis], None, 7, 1.0).expect("a study");
        let rows = study.run(Until::TheEnd, 0..study.points(), Vec::new(), &|_| Ok(())).expect("rows");
        assert_eq!(rows.len(), 35);
        for row in &rows {
            let mut scene = study.scene_at(row.point).expect("a scene");
            scene.world.network.seed = row.seed;
            let options = Options { duration_s: 1.0, record_every: 0 };
            let alone = run::<f64>(&scene, options, &|_| ()).expect("a run");
            assert_eq!(row.state_hash, format!("{:016x}", alone.hash), "{loss} {} {}", row.point, row.seed);
        }
        let mut hashes: Vec<&str> = rows.iter().map(|row| row.state_hash.as_str()).collect();
        hashes.sort_unstable();
        hashes.dedup();
        assert_eq!(hashes.len(), if draws { 35 } else { 5 });
    }
}

/// Where nobody keeps rows a run ends where a peer stops: nothing of it is told that the whole run would tell otherwise, but its state hash.
#[test]
fn rows_that_nobody_keeps_say_the_same_but_for_the_hash_of_what_stopped() {
    let axes = vec!["coordination.stiffness_n_per_m=1000..10000:16".parse().expect("an axis")];
    let sweep = Sweep { scene: scene("paper-5.2-wave-16ms", &[]), axes, sample: None, seeds: 1, seconds: 4.0 };
    let whole = sweep.run(Until::TheEnd, 0..16, Vec::new(), &|_| Ok(())).expect("rows");
    let unkept = sweep.run(Until::Stopped, 0..16, Vec::new(), &|_| Ok(())).expect("rows");
    let stopped: Vec<bool> = whole.iter().map(|row| row.reason.contains("stopped at")).collect();
    assert!(stopped.contains(&true) && stopped.contains(&false));
    for ((whole, unkept), stopped) in whole.iter().zip(&unkept).zip(stopped) {
        assert_eq!(whole.state_hash != unkept.state_hash, stopped, "{}", whole.reason);
        let hashed = Row { state_hash: whole.state_hash.clone(), ..unkept.clone() };
        assert_eq!(Row::lines(&[hashed]).expect("lines"), Row::lines(std::slice::from_ref(whole)).expect("lines"));
    }
}
