//! The scene `any-network` where packets are lost in bursts (THEORY §11): what a hand feels, how far it gets and how near the copies are,
//! where an end carries on and where it stands like a wall.

use haptic_sim::pair::Pair;
use haptic_sim::{Laws, Scene, scenes};

/// Loss, and the mean length of a burst, ms: packets go each millisecond.
const SHORT: [(&str, &str); 3] = [("0.05", "40"), ("0.2", "40"), ("0.5", "40")];
const LONG: [(&str, &str); 3] = [("0.05", "100"), ("0.2", "100"), ("0.5", "100")];

/// Against each other, those of the cooperation paper's §5.2.
const AGAINST: &[&str] = &["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];
/// Both the same way, 1 N from rest.
const TOGETHER: &[&str] = &["user.1.push_n=1", "user.2.push_n=-1"];
/// One hand over 200 mm at 0.7 Hz, by an arm that does not give way; the other one only goes along.
const LED: &[&str] = &[
    "user.1.arm_stiffness_n_per_m=400",
    "user.1.arm_damping_n_s_per_m=5",
    "user.1.tremor_m=0.1",
    "user.1.tremor_hz=0.7",
];
const STANDS: &[&str] = &["coordination.carry_damping_n_s_per_m=0"];
/// What a wall would push a hand with: the device's own limits cut it at 40 N.
const UNBOUND: &[&str] = &[
    "safety.max_force_n=200",
    "safety.max_slew_n_per_s=1000000",
    "safety.max_rms_force_n=200",
    "safety.max_rms_power_w=1000",
    "safety.max_hand_power_w=1000",
    "motor.full_scale_a=50",
];

const SEEDS: u64 = 20;

fn scene(settings: &[&[&str]], network: Option<(&str, &str)>, seed: u64) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    let network = network.map(|(loss, burst)| [("loss", loss), ("loss_burst_packets", burst)]);
    let network = network.into_iter().flatten().map(|(key, value)| format!("network.{key}={value}"));
    let seed = format!("network.seed={seed}");
    let own = settings.iter().copied().flatten().map(|setting| (*setting).to_owned());
    for setting in own.chain(network).chain([seed]) {
        scene.apply_override(&setting).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

/// What runs of a scene came to; means but where it says most.
#[derive(Clone, Copy, Debug, Default)]
struct Got {
    /// Mean |x_o1 − x_o2| after the first half, mm, of runs that went on; its sum, and of how many ticks.
    true_mm: f64,
    sum_mm: f64,
    compared: u32,
    /// Where both copies are in the end, m.
    way_m: f64,
    /// The most that either hand felt, N, and F_T.
    most_hand_n: f64,
    most_force_n: f64,
    stopped: u32,
}

fn run(scene: &Scene, ticks: u32, got: &mut Got) {
    let mut pair = Pair::<f32>::new(scene).expect("a good scene");
    let (mut sum_m, mut compared, mut way_m) = (0.0, 0, 0.0);
    for tick in 0..ticks {
        pair.step();
        if pair.fault().is_some() {
            got.stopped += 1;
            break;
        }
        let seen = pair.sides().map(|side| side.peer.observed()[0].map(f64::from));
        if tick >= ticks / 2 {
            sum_m += (seen[0].object.position - seen[1].object.position).abs();
            compared += 1;
        }
        way_m = 0.5 * (seen[0].object.position + seen[1].object.position);
        for seen in seen {
            got.most_hand_n = got.most_hand_n.max(seen.contact_force.abs());
            got.most_force_n = got.most_force_n.max(seen.coordination_force.abs());
        }
    }
    got.sum_mm += 1e3 * sum_m;
    got.compared += compared;
    got.true_mm = got.sum_mm / f64::from(got.compared.max(1));
    got.way_m += way_m / SEEDS as f64;
}

fn over(settings: &[&[&str]], network: Option<(&str, &str)>, ticks: u32) -> Got {
    let mut got = Got::default();
    (1..=SEEDS).for_each(|seed| run(&scene(settings, network, seed), ticks, &mut got));
    got
}

/// A hand that is led feels at most half of what a line that stands lets it feel, is stopped nowhere, and in short bursts
/// the copies are hardly farther apart.
#[test]
fn a_hand_that_is_led_meets_no_wall() {
    const FAR: f64 = f64::MAX;
    // Of a wall's: the most at the hand, and the distance of the copies.
    let shares = [(0.5, 1.1), (0.5, 1.3), (0.5, 1.7), (0.5, FAR), (0.5, FAR), (0.5, FAR)];
    for (network, (most, farther)) in SHORT.into_iter().chain(LONG).zip(shares) {
        let both = [&[LED][..], &[LED, STANDS, UNBOUND]];
        let [carries, stands] = both.map(|settings| over(settings, Some(network), 8_000));
        println!("{network:?}: {carries:?}, a wall {stands:?}");
        assert_eq!(carries.stopped, 0, "{network:?}");
        assert!(carries.most_hand_n <= most * stands.most_hand_n, "{network:?}: {carries:?}, a wall {stands:?}");
        assert!(carries.true_mm <= farther * stands.true_mm, "{network:?}: {carries:?}, a wall {stands:?}");
    }
}

/// Pushed the same way, the object goes where it would, without a jolt.
#[test]
fn a_common_push_goes_on_through_bursts() {
    let free = over(&[TOGETHER], None, 1_000);
    for (network, least, most_n) in [(SHORT[0], 0.85, 2.5), (SHORT[1], 0.65, 3.0), (LONG[2], 0.35, 4.0)] {
        let [carries, stands] =
            [&[TOGETHER][..], &[TOGETHER, STANDS]].map(|settings| over(settings, Some(network), 1_000));
        let way = carries.way_m / free.way_m;
        println!("{network:?}: way {way}, {carries:?}, a wall {}, {stands:?}", stands.way_m / free.way_m);
        assert!(
            way >= least && carries.way_m > 1.15 * stands.way_m,
            "{network:?}: {way}, {carries:?}, a wall {stands:?}"
        );
        assert!(carries.most_force_n <= most_n && carries.stopped == 0, "{network:?}: {carries:?}");
    }
}

/// Pushed against each other the copies are as near as a wall holds them, or nearly.
#[test]
fn a_push_against_each_other_holds() {
    for (network, most_mm) in
        [(SHORT[0], 0.6), (SHORT[1], 0.7), (SHORT[2], 0.7), (LONG[0], 0.6), (LONG[1], 0.8), (LONG[2], 1.0)]
    {
        let got = over(&[AGAINST], Some(network), 10_000);
        println!("{network:?}: {got:?}");
        assert!(got.true_mm <= most_mm && got.stopped == 0, "{network:?}: {got:?}");
    }
}

/// What is lost is made good for as long as one looks: in the last five minutes of an hour as in the first.
#[test]
fn nothing_drifts_in_an_hour() {
    let scene = scene(&[AGAINST], Some(LONG[2]), 1);
    let mut pair = Pair::<f64>::new(&scene).expect("a good scene");
    let minutes = [(); 60].map(|()| {
        let mut sum_m = 0.0;
        for _ in 0..60_000 {
            pair.step();
            let [one, other] = pair.sides().map(|side| side.peer.observed()[0].object.position);
            sum_m += (one - other).abs();
        }
        1e3 * sum_m / 60_000.0
    });
    assert!(pair.fault().is_none(), "{:?}", pair.fault());
    let mean = |minutes: &[f64]| minutes.iter().sum::<f64>() / minutes.len() as f64;
    let [first, last] = [mean(&minutes[..5]), mean(&minutes[55..])];
    assert!(
        last < 1.0 && last < 1.2 * first,
        "{first} mm in the first five minutes, {last} mm in the last: {minutes:?}"
    );
}
