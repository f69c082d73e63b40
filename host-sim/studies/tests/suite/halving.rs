//! The search beside the full grid, which is its oracle: the same best points from fewer runs, whatever was there before.

use std::collections::BTreeSet;
use std::sync::Mutex;

use haptic_sim::peers::Laws;
use haptic_studies::entrant::Entrant;
use haptic_studies::study::answers::{Answer, Goal, metric};
use haptic_studies::study::halving::Searched;
use haptic_studies::study::{Over, Study};
use haptic_studies::sweep::{Plan, Row};

/// Two laws over three networks, of which two lose at random, at seven stiffnesses: 42 points of ten seeds.
fn study() -> Study {
    let entrant = |name: &str| Entrant::of(Laws::built_in(), name, None, &[], None).expect("an entrant");
    let networks = ["own", "loss 20 %", "bursts of 40 ms, 20 %"];
    let networks = networks.iter().flat_map(|name| Over::of(name).expect("a network")).collect();
    let axis = "coordination.stiffness_n_per_m=100..100000:7:log".parse().expect("an axis");
    Study::new(["passive-mean", "p-plus-d"].map(entrant).to_vec(), networks, &[axis], None, 10, 4.0).expect("a study")
}

fn goal(merit: &str, bounds: &[&str]) -> Goal {
    let bounds = bounds.iter().map(|bound| bound.parse().expect("a bound")).collect();
    Goal { metric: metric(merit).expect("a figure of merit"), bounds }
}

fn search(study: &Study, goal: &Goal, there: &[Row]) -> Searched {
    study.search(goal, there.to_vec(), &|_| Ok(())).expect("a search")
}

fn lines(rows: &[Row]) -> Vec<u8> {
    Row::lines(rows).expect("lines")
}

/// What each answer says of its best point.
fn told(answers: &[Answer]) -> Vec<Option<(usize, f64, usize)>> {
    answers.iter().map(|one| one.best.as_ref().map(|best| (best.point, best.judged.mean, best.seeds))).collect()
}

/// The goals of the first study and of its page: another figure of merit, and bounds that take the grid's best points away.
#[test]
fn it_finds_what_the_grid_finds_with_less_than_half_of_the_runs() {
    let study = study();
    let grid = study.run(0..study.points(), Vec::new(), &|_| Ok(())).expect("rows");
    assert_eq!(grid.len(), 420);
    let goals = [
        goal("true_discrepancy_mm", &[]),
        goal("true_discrepancy_mm", &["peak_hand_force_n=1.5"]),
        goal("largest_hand_change_n", &["true_discrepancy_mm=10", "peak_coordination_force_n=3"]),
    ];
    let mut most = 0;
    for goal in &goals {
        let found = search(&study, goal, &[]);
        let (all, some) = (study.answers(&grid, goal), study.searched_answers(&found.rows, goal));
        assert_eq!(told(&some), told(&all), "{}", goal.what());
        for (some, all) in some.iter().zip(&all) {
            assert_eq!(some.counts.points, 7);
            assert!(some.counts.allowed() <= all.counts.allowed() && all.counts.given_up == 0, "{some:?} {all:?}");
        }
        // Every row is the grid's, to the last bit.
        let known: BTreeSet<Vec<u8>> = grid.iter().map(|row| lines(std::slice::from_ref(row))).collect();
        assert!(found.rows.iter().all(|row| known.contains(&lines(std::slice::from_ref(row)))));
        assert_eq!(found.new, found.rows.len());
        most = most.max(found.new);
    }
    assert!(most * 2 < grid.len(), "{most} runs of {}", grid.len());
}

/// What is there is taken and changes nothing: runs of a search that was stopped, or of a grid.
#[test]
fn whatever_is_there_the_runs_are_the_same() {
    let (study, goal) = (study(), goal("true_discrepancy_mm", &["peak_hand_force_n=1.5"]));
    let whole = search(&study, &goal, &[]);
    let rows = Mutex::new(Vec::new());
    let stopped = study.search(&goal, Vec::new(), &|new| {
        let mut rows = rows.lock().expect("rows");
        rows.extend_from_slice(new);
        if rows.len() > 40 { Err("stopped".into()) } else { Ok(()) }
    });
    assert_eq!(stopped.expect_err("it is stopped").to_string(), "stopped");
    let there = rows.into_inner().expect("rows");
    let after = search(&study, &goal, &there);
    assert_eq!(lines(&after.rows), lines(&whole.rows));
    assert_eq!(after.new, whole.new - there.len());
    let grid = study.run(0..study.points(), there, &|_| Ok(())).expect("rows");
    let all = search(&study, &goal, &grid);
    assert_eq!((lines(&all.rows), all.new), (lines(&whole.rows), 0));
}

/// Best points that fail with a seed that judges: who was given up comes back, and the grid's next best is found.
#[test]
fn where_the_grid_has_a_point_so_has_the_search() {
    let study = study();
    let grid = study.run(0..study.points(), Vec::new(), &|_| Ok(())).expect("rows");
    let usual = goal("true_discrepancy_mm", &[]);
    let bests: BTreeSet<usize> =
        study.answers(&grid, &usual).iter().filter_map(|one| Some(one.best.as_ref()?.point)).collect();
    let last = study.first_seed() + study.seeds() - 1;
    let fails = |mut row: Row| {
        if row.seed == last && bests.contains(&row.point) {
            (row.verdict, row.reason) = ("NO".to_owned(), "made to fail".to_owned());
        }
        row
    };
    let grid: Vec<Row> = grid.into_iter().map(fails).collect();
    let (found, all) = (search(&study, &usual, &grid), study.answers(&grid, &usual));
    let some = study.searched_answers(&found.rows, &usual);
    assert_eq!(told(&some), told(&all));
    assert_eq!(found.new, 0);
}

/// One seed chooses and judges: nothing can be spared.
#[test]
fn a_single_seed_is_the_grid() {
    let entrant = Entrant::of(Laws::built_in(), "wave", None, &[], None).expect("an entrant");
    let axis = "coordination.damping_n_s_per_m=2,4,8".parse().expect("an axis");
    let own = Over::of("own").expect("a network");
    let study = Study::new(vec![entrant], own, &[axis], None, 1, 1.0).expect("a study");
    let goal = goal("true_discrepancy_mm", &[]);
    let (found, grid) = (search(&study, &goal, &[]), study.run(0..3, Vec::new(), &|_| Ok(())).expect("rows"));
    assert_eq!(lines(&found.rows), lines(&grid));
    assert_eq!(told(&study.searched_answers(&found.rows, &goal)), told(&study.answers(&grid, &goal)));
}
