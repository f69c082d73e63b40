//! Networks that are like measured ones: what their sources print of those, measured of these.

use cohold_sim::network::rule::{Direction, Fate, of_scene, seconds};
use cohold_sim::{Laws, Scene};

const MS: u64 = 1_000_000;

fn like(name: &str, seed: u32, extra_s: f64) -> Scene {
    let mut scene = Scene::new(Laws::built_in());
    for set in [
        format!("network.like={name}"),
        format!("network.seed={seed}"),
        format!("network.extra_delay_s={extra_s}"),
        "network.one_way_delay_packets=0".to_owned(),
    ] {
        scene.apply_override(&set).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

/// Delays of packets sent every so many ns, ms; none of one that is lost.
fn delays_ms(scene: &Scene, direction: Direction, every_ns: u64, count: u64) -> Vec<Option<f64>> {
    let mut rule = of_scene(scene, direction, 0).expect("a rule");
    let delay = |number: u64| match rule.decide(number, number * every_ns) {
        Fate::Drop => None,
        fate => fate.copies().first().map(|copy| 1e3 * seconds(copy.delay_ns)),
    };
    (0..count).map(delay).collect()
}

/// There and back, sent every so many ns, ms; the answer leaves when the question has come.
fn round_trips_ms(scene: &Scene, every_ns: u64, count: u64) -> Vec<Option<f64>> {
    let there = delays_ms(scene, Direction::OneToTwo, every_ns, count);
    let mut rule = of_scene(scene, Direction::TwoToOne, 0).expect("a rule");
    let trip = |(number, there_ms): (u64, &Option<f64>)| {
        let there_ms = (*there_ms)?;
        let back = rule.decide(number, number * every_ns + (1e6 * there_ms) as u64).copies();
        Some(there_ms + 1e3 * seconds(back.first()?.delay_ns))
    };
    (0..count).zip(&there).map(trip).collect()
}

fn sorted(delays: &[Option<f64>]) -> Vec<f64> {
    let mut sorted: Vec<f64> = delays.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[(share * sorted.len() as f64) as usize]
}

fn lost(delays: &[Option<f64>]) -> f64 {
    delays.iter().filter(|delay| delay.is_none()).count() as f64 / delays.len() as f64
}

/// Rischke et al. 2021: 95 % of the packets after 4 to 10 ms.
#[test]
fn a_campus_network_is_as_rischke_et_al_measured() {
    for (seed, direction) in [(1, Direction::OneToTwo), (2, Direction::TwoToOne)] {
        let delays = delays_ms(&like("5g-campus", seed, 0.004), direction, MS, 200_000);
        let all = sorted(&delays);
        let within = all.iter().filter(|ms| (4.0..=10.0).contains(*ms)).count() as f64 / all.len() as f64;
        assert!((within - 0.95).abs() < 0.005, "{within}");
        assert_eq!(lost(&delays), 0.0);
    }
}

/// Huston 2024: 6.7 ms from one round trip to the next a second later, spikes of 30 to 50 ms more at each change, 1 to 2 % lost each way.
#[test]
fn a_line_over_satellites_is_as_huston_measured() {
    let scene = like("starlink", 1, 0.015);
    let trips = round_trips_ms(&scene, 1000 * MS, 7200);
    // Whole seconds never meet a spike, which he tells of by itself.
    let steps: Vec<f64> = trips.windows(2).filter_map(|two| Some((two[1]? - two[0]?).abs())).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    assert!((mean - 6.7).abs() < 0.7, "{mean} ms");
    let each_way = delays_ms(&scene, Direction::OneToTwo, MS, 600_000);
    assert!((lost(&each_way) - 0.015).abs() < 0.002, "{}", lost(&each_way));
    // The first change is after 7.5 s: nothing comes for 0.1 s, and then late.
    assert!(each_way[7_500..7_600].iter().all(Option::is_none));
    let mean_of = |ticks: std::ops::Range<usize>| {
        let all = sorted(&each_way[ticks]);
        all.iter().sum::<f64>() / all.len() as f64
    };
    // Over changes one way is 15 to 25 ms later, and as much back.
    let more: Vec<f64> = (0..39)
        .map(|at| 7_500 + 15_000 * at)
        .map(|at| mean_of(at + 100..at + 300) - mean_of(at + 400..at + 2_400))
        .collect();
    let mean = 2.0 * more.iter().sum::<f64>() / more.len() as f64;
    assert!((30.0..50.0).contains(&mean), "{mean} ms");
}

/// Huitema 2023: a packet every 20 ms, 10 minutes: median 4.04 ms, 95 % below 8 ms, 38 of 30,000 lost, 18 stands, 12 of them longer than 200 ms.
#[test]
fn a_wi_fi_is_as_huitema_measured() {
    let mut counts = [0.0; 2];
    let mut shares = [0.0; 3];
    const SEEDS: u32 = 20;
    for seed in 1..=SEEDS {
        // About every 20 ms, at any phase of what varies.
        let trips = round_trips_ms(&like("home-wifi", seed, 0.0008), 20 * MS + 70_000, 30_000);
        let all = sorted(&trips);
        for (sum, found) in shares.iter_mut().zip([quantile(&all, 0.5), quantile(&all, 0.95), 1e5 * lost(&trips)]) {
            *sum += found / f64::from(SEEDS);
        }
        // A stand is where a round trip takes longer than the one before by so much.
        for (count, most_ms) in counts.iter_mut().zip([100.0, 200.0]) {
            let known: Vec<f64> = trips.iter().flatten().copied().collect();
            let begins = known.windows(2).filter(|two| two[1] > most_ms && two[0] < 50.0).count();
            *count += begins as f64 / f64::from(SEEDS);
        }
    }
    let [median, most, lost] = shares;
    assert!((median - 4.04).abs() < 0.15 && (most - 8.0).abs() < 0.6, "{median} ms, {most} ms");
    assert!((lost - 127.0).abs() < 60.0, "{lost} of 100,000");
    assert!((counts[0] - 18.0).abs() < 4.0 && (counts[1] - 12.0).abs() < 4.0, "{counts:?}");
}

/// The same network, however often packets are sent, and none overtakes another.
#[test]
fn who_sends_more_often_finds_the_same_network() {
    for name in ["5g-campus", "starlink", "home-wifi"] {
        let scene = like(name, 3, 0.0);
        let fine = delays_ms(&scene, Direction::OneToTwo, MS, 100_000);
        let coarse = delays_ms(&scene, Direction::OneToTwo, 8 * MS, 12_500);
        let both = coarse.iter().zip(fine.iter().step_by(8)).filter_map(|(one, other)| Some(((*one)?, (*other)?)));
        let (mut same, mut all) = (0, 0);
        for (one, other) in both {
            all += 1;
            same += u32::from((one - other).abs() < 1e-5);
        }
        assert!(all > 12_000 && same == all, "{name}: {same} of {all}");
        let mut newest = 0.0_f64;
        for (sent_ms, delay_ms) in fine.iter().enumerate().filter_map(|(tick, delay)| Some((tick as f64, (*delay)?))) {
            let due_ms = sent_ms + delay_ms;
            assert!(due_ms >= newest - 1e-5, "{name}: sent at {sent_ms} ms");
            newest = newest.max(due_ms);
        }
        assert_eq!(fine, delays_ms(&scene, Direction::OneToTwo, MS, 100_000), "{name}");
        assert_ne!(fine, delays_ms(&like(name, 4, 0.0), Direction::OneToTwo, MS, 100_000), "{name}");
    }
}
