//! The bench: a small budget tells what a large one does, it goes on where it was stopped, and the findings that it answers.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use cohold_core::names::Choice;
use cohold_sim::measure::{at_hand, led::felt};

use super::motions::Motion;
use super::runs::Run;
use super::search::tune;
use super::*;
use crate::campaign::laws::{LADDER, asked_for};
use crate::networks::{self, Named};
use crate::study::around::best;

const FEW: &[Named] = &[("8 ms", ""), ("bursts of 40 ms, 20 %", "loss=0.2 loss_burst_packets=40ms")];

fn bench(names: &str, budget: usize) -> Bench {
    let laws = cohold_guest_laws::laws();
    let chosen = asked_for(laws, names).expect("laws");
    let networks = Network::named(FEW);
    Bench { laws, chosen, budget, seeds: 1, searches: 1, networks, traces: Vec::new() }
}

/// Finding 3 and 10: within the same bound of what a hand feels, and the same number of tunings, the self-timed line is nearer than P+d by far, as the
/// whole bench and 1,118 tunings of an auditor found.
#[test]
fn a_small_budget_finds_the_order_of_the_whole() {
    let bench = bench("self-timed,p-plus-d", 48);
    let book = Book::open(None, "bench").expect("no folder");
    let tuned: Vec<Vec<Tuning>> =
        bench.chosen.iter().map(|law| tune(&bench, law, &book, &|| ()).expect("tunings")).collect();
    for bound in [25.0, 50.0] {
        let found =
            |of: &[Tuning]| best(of, bound).filter(|best| best.is_within(bound)).map(|best| best.worst_mm_per_n);
        let (line, spring) = (found(&tuned[0]).expect("a line"), found(&tuned[1]).unwrap_or(f64::MAX));
        assert!(line < spring, "at {bound}: {line} and {spring} mm/N");
        assert!(line < 2.0, "at {bound}: {line} mm/N");
    }
    for tunings in &tuned {
        assert_eq!(tunings.len(), 48);
        assert_eq!(tunings[0].gains, "", "the law's own gains are the first");
    }
}

/// Lines of rows: what is no number is written, and equal to itself.
fn lines<R: crate::sweep::Kept>(rows: &[R]) -> String {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    rows.iter().for_each(|row| writer.serialize(row).expect("a line"));
    String::from_utf8(writer.into_inner().expect("lines")).expect("text")
}

fn all(found: &Found) -> String {
    let runs: Vec<Run> = found.points.iter().flat_map(|point| point.runs.clone()).collect();
    lines(&found.tunings) + &lines(&runs)
}

/// The same rows on one thread and on two, and after a bench that was killed in the middle of a line; what was found is not done again.
#[test]
fn it_goes_on_where_it_was_stopped_with_the_same_rows() {
    let folder = std::env::temp_dir().join(format!("cohold-bench-{}", std::process::id()));
    let folder = folder.as_path();
    let bench = Bench { searches: 2, ..bench("power", 6) };
    let question = bench.question(Provenance::now("1", "c")).expect("a question");
    let on = |threads, folder: Option<&Path>| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| bench.run(folder.map(|folder| (folder, &question)), &|| ())).expect("a bench")
    };
    let whole = all(&on(1, None));
    assert_eq!(all(&on(2, Some(folder))), whole);
    // A kill leaves half a line, and less than half of the rows.
    for name in ["tunings-1-of-1.csv", "runs-1-of-1.csv"] {
        let file = folder.join(name);
        let text = std::fs::read(&file).expect("rows");
        std::fs::write(&file, &text[..text.len() * 2 / 5]).expect("cut");
    }
    let (there, steps) = (Mutex::new(0), AtomicUsize::new(0));
    let rows = |name: &str| std::fs::read_to_string(folder.join(name)).expect("rows").lines().count();
    *there.lock().expect("a count") = rows("runs-1-of-1.csv");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().expect("a pool");
    let resumed = pool.install(|| bench.run(Some((folder, &question)), &|| _ = steps.fetch_add(1, Ordering::Relaxed)));
    assert_eq!(all(&resumed.expect("a bench")), whole);
    assert!(steps.load(Ordering::Relaxed) <= bench.steps());
    let again = bench.run(Some((folder, &question)), &|| ()).expect("a bench");
    assert_eq!(all(&again), whole);
    assert_eq!(rows("tunings-1-of-1.csv"), 1 + again.tunings.len(), "each tuning once");
    assert!(rows("runs-1-of-1.csv") > *there.lock().expect("a count"));
    let another = Bench { budget: 7, ..bench.clone() };
    let refused =
        another.run(Some((folder, &another.question(Provenance::now("1", "c")).expect("a question"))), &|| ());
    assert!(refused.expect_err("another bench").to_string().contains("is of another bench"));
}

/// Finding 1: no law is let go of earlier than another, whatever it declares.
#[test]
fn one_ladder_of_silence_for_all_laws_at_all_gains() {
    let laws = cohold_guest_laws::laws();
    for law in laws.all() {
        let gains = protocol::gains(laws, law).expect("gains");
        assert!(
            !gains.iter().any(|gain| gain.key.starts_with("safety.") || gain.key.starts_with("timing.")),
            "{}",
            law.name
        );
        let scene = protocol::scene(laws, law, "").expect("a scene");
        for setting in LADDER.iter().chain(&protocol::SCENE) {
            let (key, value) = setting.split_once('=').expect("a setting");
            assert_eq!(
                scene.get(key).expect("a key").to_string().parse::<f64>(),
                value.parse::<f64>(),
                "{}: {key}",
                law.name
            );
        }
    }
}

/// Finding 2: what single gains decided is tuned for every law alike. The stiffness that holds a model to the other copy, of which 1 N makes 10 mm at 100 N/m and
/// not at 200; the damping with which four channels are stable over 40 ms and bursts of loss and without which they are not; and P+d is among the laws.
#[test]
fn what_single_gains_decide_is_tuned() {
    let laws = cohold_guest_laws::laws();
    let law = |name: &str| asked_for(laws, name).expect("a law")[0];
    let tuned = |name: &str, key: &str| {
        let gains = protocol::gains(laws, law(name)).expect("gains");
        gains.iter().any(|gain| gain.key == key && gain.share(200.0) > 0.0)
    };
    assert!(tuned("model-mediated", "model_mediated.correction_n_per_m"));
    // Of these the last is 0 where the law declares it: all that the key accepts, and no feedback somewhere between.
    for key in ["coordination.damping_n_s_per_m", "four_channel.local_damping_n_s_per_m", "four_channel.local_force"] {
        assert!(tuned("four-channel", key), "{key}");
    }
    assert!(tuned("p-plus-d", "coordination.stiffness_n_per_m"));
    const LATE: &[Named] =
        &[("40 ms, bursts of 40 ms, 20 %", "one_way_delay_packets=40ms loss=0.2 loss_burst_packets=40ms")];
    let late = &Network::named(LATE)[0];
    let run = |gains: &str| {
        let scene = late.over(&protocol::scene(laws, law("four-channel"), gains).expect("a scene")).expect("a network");
        at_hand::run(&Motion::Against.of(&scene).expect("a motion"), 10.0, None).expect("a run").outcome
    };
    let [bare, damped] = [(2, 0), (6, 8)].map(|(damping, local)| {
        run(&format!("coordination.damping_n_s_per_m={damping} four_channel.local_damping_n_s_per_m={local}"))
    });
    assert!(damped.is_stable() && !bare.is_stable(), "{:?}, {:?}", damped.reason, bare.reason);
}

/// Whatever is tuned has ends that the law takes, and a share of its range that comes back.
#[test]
fn every_gain_goes_from_end_to_end() {
    let laws = cohold_guest_laws::laws();
    for law in laws.all() {
        for gain in protocol::gains(laws, law).expect("gains") {
            for share in [0.0, 0.3, 1.0] {
                let value: f64 = gain.value(share).parse().expect("a number");
                let back = gain.share(value);
                let near = if gain.whole { 0.1 } else { 1e-3 };
                assert!((back - share).abs() < near, "{} {}: {share} is {value}, {back}", law.name, gain.key);
                let mut scene = protocol::scene(laws, law, "").expect("a scene");
                scene
                    .apply_override(&format!("{}={}", gain.key, gain.value(share)))
                    .expect("a value within the key's own range");
            }
        }
    }
}

/// Finding 3: drag is felt, in newtons a metre a second, and takes way in millimetres: P+d of 30 N·s/m lets a common push go a fraction of the way that a line
/// of the same apparent mass does.
#[test]
fn drag_is_felt_and_way_is_not_normalised() {
    let laws = cohold_guest_laws::laws();
    let chosen = asked_for(laws, "p-plus-d,self-timed").expect("laws");
    let of = |law: &LawInfo| {
        let scene = protocol::scene(laws, law, "").expect("a scene");
        let felt = felt(&scene, 0.2).expect("a scene").expect("an answer");
        let pushed = Motion::Together.of(&scene).expect("a motion");
        let found = at_hand::run(&pushed, Motion::Together.duration_s(), None).expect("a run");
        (felt, 1e3 * found.way_m)
    };
    let [(drag, slow), (light, far)] = [of(chosen[0]), of(chosen[1])];
    // Lee & Spong: both copies are pushed through 2·(B_T + K_T·T), T = 8 ms and half a tick; at 0.2 Hz the springs give a little.
    assert!((drag.re / (2.0 * (30.0 + 310.0 * 0.0085) + 1.0) - 1.0).abs() < 0.06, "{drag:?}");
    assert!(light.re < 3.0, "{light:?}");
    assert!(far > 4.0 * slow && slow > 1.0, "{slow} and {far} mm");
}

/// Finding 4: the balance of the whole link at one instant tells who makes energy, whatever a law books: a spring whose far end is late does, a self-timed line
/// gives at most what it began with.
#[test]
fn the_balance_of_the_link_tells_who_makes_energy() {
    let laws = cohold_guest_laws::laws();
    let network = &Network::named(networks::TEST)[3];
    let least = |name: &str, gains: &str| {
        let law = asked_for(laws, name).expect("a law")[0];
        let scene = network.over(&protocol::scene(laws, law, gains).expect("a scene")).expect("a network");
        let scene = Motion::Against.of(&scene).expect("a motion");
        at_hand::run(&scene, 5.0, None).expect("a run").least_balance_j
    };
    let [made, kept] = [least("power", "coordination.stiffness_n_per_m=1500"), least("self-timed", "")];
    assert!(made < -0.1, "{made} J");
    // 30 mJ at each end.
    assert!(kept >= -0.060_001, "{kept} J");
}

/// Each motion is what its line of the page says, and nobody stops under a law that holds.
#[test]
fn every_motion_runs() {
    let laws = cohold_guest_laws::laws();
    let law = asked_for(laws, "self-timed").expect("a law")[0];
    let scene = protocol::scene(laws, law, "").expect("a scene");
    for &motion in Motion::ALL {
        let found = at_hand::run(&motion.of(&scene).expect("a motion"), motion.duration_s(), None).expect("a run");
        assert!(found.outcome.fault.is_none(), "{}: {:?}", motion.name(), found.outcome.reason);
        let peak_n = found.outcome.whole.peak_hand_force_n;
        assert!(peak_n > 0.1, "{}: {peak_n} N", motion.name());
        let lets_go = motion == Motion::Contact;
        // A common push begins after 3 s.
        let opens = found.forces.iter().skip(3_100).filter(|force| force[0] == 0.0).count();
        assert_eq!(opens > 500, lets_go, "{}: no force in {opens} ticks", motion.name());
    }
}

/// Of three searches that ended at 2, 1 and 3 mm/N the second is shown, as its own networks told, with how far apart they ended; no end where one of them found
/// nothing, or gains that stop. The nearest law is one that stops nowhere, and among those that promise passivity another one.
#[test]
fn every_search_is_shown_and_the_nearest_is_named() {
    let bench = bench("p-plus-d,self-timed", 1);
    let own = bench.run(None, &|| ()).expect("a bench").points;
    assert!(own.iter().all(|point| point.stopped() == 0), "these laws stop nowhere at their own gains");
    let tuned = |law: usize, search_seed: u32, tuned: f64, tested: f64| {
        let Point { law, tuning, mut runs, .. } = own[law].clone();
        runs.iter_mut()
            .for_each(|run| (run.search_seed, run.mm_per_n, run.true_mm) = (search_seed, tested, 2.0 * tested));
        Point { law, name: "≤ 25".to_owned(), tuning: Tuning { search_seed, worst_mm_per_n: tuned, ..tuning }, runs }
    };
    let found = |points: &[Point]| Found { points: points.to_vec(), searches: 3, ..Found::default() };
    let tunings = [(1, 1.9), (2, 0.9), (3, 2.9)].map(|(search_seed, worst_mm_per_n)| {
        let (felt_n_s_per_m, reason) = ([10.0; 3], String::new());
        Tuning { search_seed, worst_mm_per_n, felt_n_s_per_m, mass_kg: 0.1, reason, ..own[0].tuning.clone() }
    });
    let chosen: Vec<_> =
        search::chosen(&tunings).into_iter().map(|(name, tuning)| (name, tuning.search_seed)).collect();
    let within = |bound: &str| [2, 1, 3].map(|search_seed| (bound.to_owned(), search_seed));
    assert_eq!(chosen, [&[("declared".to_owned(), 1)][..], &within("≤ 25"), &within("≤ 50")].concat());
    let (near, far) = ([tuned(0, 2, 0.9, 1.0), tuned(0, 1, 1.9, 2.0), tuned(0, 3, 2.9, 3.0)], [tuned(1, 1, 4.0, 5.0)]);
    let all = found(&[&near[..], &far].concat());
    let shown: Vec<_> = all.best().map(|point| (point.law.name, point.tuning.search_seed)).collect();
    assert_eq!(shown, [("p-plus-d", 2), ("self-timed", 1)]);
    let figure: fn(&Point) -> Option<f64> = Point::worst_mm_per_n;
    let spread = |found: &Found, at: usize| found.spread(found.best().nth(at).expect("a point"), figure);
    assert_eq!([spread(&all, 0), spread(&all, 1)], [[Some(1.0), Some(3.0)], [Some(5.0), None]]);
    // The rows: up to 5, 25 and 50 N·s/m, of all laws and of those that promise passivity.
    let named = |found: &Found, row| chooser::nearest(found).row(row);
    assert_eq!(
        (named(&all, 2)["pushed_law"].as_str(), named(&all, 3)["pushed_law"].as_str()),
        (Some("p-plus-d"), Some("self-timed"))
    );
    assert_eq!((named(&all, 2)["led_mm"].as_f64(), named(&all, 2)["led_most_mm"].as_f64()), (Some(2.0), Some(6.0)));
    assert!(named(&all, 0)["pushed_law"].is_null(), "{}", named(&all, 0));
    let mut stops = near;
    stops[0].runs[0].stopped = true;
    let stops = found(&[&stops[..], &far].concat());
    assert_eq!(spread(&stops, 0), [Some(2.0), None]);
    assert_eq!(named(&stops, 2)["pushed_law"].as_str(), Some("self-timed"));
}

/// The scene with the gains of four channels is the bench's, with the gains that the page has.
#[test]
fn the_scene_of_the_nearest_law_is_that_of_the_page() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/results/laws.md");
    let page = std::fs::read_to_string(page).expect("the page of laws");
    let gains = |line: &str| Some(line.strip_prefix("- `four-channel` ≤ 25: `")?.strip_suffix('`')?.to_owned());
    let gains = page.lines().find_map(gains).expect("the bench has gains of four channels for 25 N·s/m");
    let laws = cohold_guest_laws::laws();
    let benched = protocol::scene(laws, asked_for(laws, "four-channel").expect("a law")[0], &gains).expect("a scene");
    let near = cohold_sim::scenes::load(laws, "four-channel-near").expect("a built-in scene");
    let settings = |scene: &cohold_sim::Scene| {
        scene.settings().into_iter().filter(|(key, _)| !key.starts_with("user.")).collect::<Vec<_>>()
    };
    assert_eq!(settings(&near), settings(&benched));
}
