use cohold_sim::scenes;

use super::super::kinds::EnvironmentKind;
use super::*;

/// Farthest that copies are apart which are still one object, m.
const TOGETHER_M: f64 = 0.02;

fn open(keys: &[&str]) -> ThreeLaws {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
    keys.iter().for_each(|text| scene.apply_override(text).expect("a key"));
    ThreeLaws::new(&EnvironmentKind::BadNetwork.fitting(scene).expect("a scene")).expect("three lanes")
}

fn column(sample: &Sample, name: &str) -> f64 {
    f64::from(sample[COLUMNS.iter().position(|(known, ..)| *known == name).expect("a column")])
}

fn apart(sample: &Sample, law: &str) -> f64 {
    (column(sample, &format!("object_1_{law}")) - column(sample, &format!("object_2_{law}"))).abs()
}

/// So many seconds with nobody's hand; the largest distance of the copies in each lane, m, and the last sample.
fn run(laws: &mut ThreeLaws, seconds: f64) -> ([f64; LANES], Sample) {
    let (mut most, mut last) = ([0.0_f64; LANES], [f32::NAN; MOST]);
    for _ in 0..(1000.0 * seconds) as u64 {
        (0..2).for_each(|hand| laws.play(hand));
        last = laws.step().expect("a tick");
        for (most, law) in most.iter_mut().zip(["power", "wave", "timed"]) {
            *most = most.max(apart(&last, law));
            // A page that looks only now is told of it as well.
            let [worst, at, lasted] =
                ["worst", "worst_at", "lasted"].map(|name| column(&last, &format!("{name}_{law}")));
            assert!(worst > *most - 1e-6 && at <= lasted, "{law}: {worst} {most} at {at} of {lasted}");
        }
    }
    (most, last)
}

/// On a network that loses nothing all three hold; on one that loses in bursts, by the same hands, power tears, passive waves drift apart,
/// and the self-timed line holds, whatever the seed.
#[test]
fn on_a_bad_network_one_law_holds() {
    let (most, last) = run(&mut open(&["network.loss=1e-9"]), 10.0);
    assert!(most.iter().all(|most| *most < TOGETHER_M), "{most:?}");
    assert_eq!(["power", "wave", "timed"].map(|law| column(&last, &format!("fault_{law}"))), [0.0; LANES]);
    for seed in 1..=5 {
        let (most, last) = run(&mut open(&[&format!("network.seed={seed}")]), 20.0);
        assert!(most[0] > 0.05 && most[1] > 0.05, "seed {seed}: {most:?}");
        let torn = |at: usize, law: &str| most[at] > TOGETHER_M || column(&last, &format!("fault_{law}")) > 0.0;
        assert!(torn(0, "power") && torn(1, "wave") && !torn(2, "timed"), "seed {seed}: {most:?} {last:?}");
        assert!(column(&last, "lasted_timed") > 19.99);
        assert!((column(&last, "worst_power") - most[0]).abs() < 1e-6, "seed {seed}: {most:?}");
    }
}

/// As many packets are sent and lost in one lane as in the others, and each takes as long. Both peers send in the same tick, so that a page can
/// say of each packet which way it went, and whether it was lost.
#[test]
fn the_same_packets_meet_the_same_fates() {
    let mut laws =
        open(&["network.loss=0.2", "network.loss_burst_packets=3", "network.jitter=uniform", "network.jitter_s=0.01"]);
    let (mut sent, mut compared, mut before, mut one_way) = (0.0, 0, [0.0; 3], 0.0);
    for tick in 0..6000 {
        // A change in flight is one for all of them, too.
        if tick == 3000 {
            let mut scene = laws.scene.clone();
            scene.world.network.loss = 0.4;
            laws.set(scene).expect("a good scene");
        }
        let sample = laws.step().expect("a tick");
        let of = |name: &str| ["power", "wave", "timed"].map(|law| column(&sample, &format!("{name}_{law}")));
        let [power, wave, timed] = of("fault");
        assert_eq!(timed, 0.0);
        for (faulted, lane) in [(power, 0), (wave, 1)] {
            if faulted == 0.0 {
                compared += 1;
                for name in ["sent", "lost", "delay_1", "delay_2"] {
                    assert_eq!(of(name)[lane], of(name)[2], "{name} at {tick}");
                }
            }
        }
        let now = ["sent", "lost", "lost_1"].map(|name| of(name)[2]);
        let [more, lost, lost_1] = std::array::from_fn(|at| now[at] - std::mem::replace(&mut before[at], now[at]));
        assert!(more == 0.0 || more == 2.0, "{more} at {tick}");
        assert!((0.0..=0.5 * more).contains(&lost_1) && (0.0..=0.5 * more).contains(&(lost - lost_1)), "at {tick}");
        (sent, one_way) = (now[0], one_way + f64::from(u8::from(lost == 1.0)));
    }
    assert!(sent > 1400.0 && compared > 6000 && one_way > 100.0, "{sent} {compared} {one_way}");
}

/// A lane that has faulted stands as it was; the others go on, and all begin again when they are asked to.
#[test]
fn a_lane_that_faults_stands() {
    // Below what the torn copies come to, and above what those that hold do.
    let mut laws = open(&["peer.1.safety.max_speed_m_per_s=0.2"]);
    let mut last = [f32::NAN; MOST];
    while last[0].is_nan() || column(&last, "fault_power") == 0.0 {
        last = run(&mut laws, 0.1).1;
        assert!(column(&last, "lasted_timed") < 30.0, "{last:?}");
    }
    let (_, later) = run(&mut laws, 1.0);
    let own = OF_ALL..OF_ALL + OF_LANE;
    assert_eq!(last[own.clone()], later[own]);
    assert!(column(&later, "lasted_timed") - column(&last, "lasted_timed") > 0.99, "{later:?}");
    assert!(matches!(column(&later, "faulted_power"), 1.0 | 2.0));
    laws.command(Command::Start).expect("it starts");
    let (_, anew) = run(&mut laws, 0.01);
    assert_eq!([column(&anew, "fault_power"), f64::from(anew[MOST - 1])], [0.0, 1.0]);
    assert!(column(&anew, "worst_power") < 1e-4 && column(&last, "worst_power") > 1e-3, "{anew:?} {last:?}");
}

/// A person's hand holds the devices of all lanes, beside the simulated pushes.
#[test]
fn a_hand_holds_all_lanes() {
    let mut laws = open(&["network.loss=1e-9"]);
    let mut last = [f32::NAN; MOST];
    for _ in 0..5000 {
        laws.point(0, Some([0.04, 0.0, 0.0]), 0);
        laws.play(1);
        last = laws.step().expect("a tick");
    }
    for law in ["power", "wave", "timed"] {
        let at = column(&last, &format!("device_1_{law}"));
        assert!((at - 0.04).abs() < 0.02, "{law}: {at}");
    }
    assert!((column(&last, "wanted_1") - 0.04).abs() < 1e-6 && column(&last, "push_1") > 0.2, "{last:?}");
}
