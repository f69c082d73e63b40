//! The self-timed line in runs (THEORY §8): what it keeps apart over bad networks, what it costs, and that it makes nothing.

use cohold_sim::pair::Pair;
use cohold_sim::rng::Rng;
use cohold_sim::run::{Options, Outcome};
use cohold_sim::{Laws, Scene, scenes};

const MATCHED: [&str; 3] =
    ["coordination.stiffness_n_per_m=1e5", "coordination.wave_impedance_n_s_per_m=60", "object.mass_kg=0.02"];

/// What §8 is about: an end that stands is a wall.
const STANDS: &str = "coordination.carry_damping_n_s_per_m=0";

/// §5.2 with a self-timed line over 8 ms, a packet a tick.
fn scene(settings: &[&str], network: &[&str], seed: u64) -> Scene {
    let mut scene = scenes::load(Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("built in");
    let common = [
        "object.integrator=midpoint",
        "object.force_delay_ticks=0",
        "coordination.decode=implicit",
        "coordination.comm=self-timed",
        "timing.ticks_per_packet=1",
        "network.one_way_delay_packets=8",
        // A silence is not let go of: the line stands.
        "safety.fade_s=5",
        "safety.disengage_s=9",
        &format!("network.seed={seed}"),
    ];
    for setting in common.iter().chain(settings).chain(network) {
        scene.apply_override(setting).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

/// Means over the last half of 10 s.
#[derive(Clone, Copy, Debug)]
struct Got {
    true_mm: f64,
    /// Energy that came out over what went in, in the worse direction, at every tick.
    out_over_in: f64,
    /// Ticks in which the first end was live.
    live: f64,
    /// Energy of both copies and both springs less what the hands did, at the most, J.
    made_j: f64,
}

fn run(scene: &Scene, ticks: u32) -> Got {
    let mut pair = Pair::<f64>::new(scene).expect("a good scene");
    let period = scene.peer.timing.control_period_s;
    let (mut sum_m, mut live, mut out_over_in, mut sent) = (0.0, 0, 0.0_f64, 0.0);
    let (mut work_j, mut made_j, mut before) = ([0.0; 2], 0.0_f64, [None; 2]);
    for tick in 0..ticks {
        pair.step();
        assert!(pair.fault().is_none(), "{:?}", pair.fault());
        let seen = pair.sides().map(|side| *side.peer.observed()[0]);
        if tick >= ticks / 2 {
            sum_m += (seen[0].object.position - seen[1].object.position).abs();
        }
        let energies = pair.sides().map(|side| (side.peer.ledger()[0].received_j(), side.peer.ledger()[0].sent_j()));
        for (into, out) in [(energies[0].1, energies[1].0), (energies[1].1, energies[0].0)] {
            out_over_in = out_over_in.max(if into > 1e-9 { out / into } else { 0.0 });
        }
        live += u32::from(energies[0].1 != sent);
        sent = energies[0].1;
        // What the hands' contacts did on the copies, at the copies' mean velocity: known a tick later.
        let mut stored_j = 0.0;
        for (at, seen) in seen.iter().enumerate() {
            if let Some((velocity, force)) = before[at] {
                work_j[at] += period * force * 0.5 * (velocity + seen.object.velocity);
            }
            before[at] = Some((seen.object.velocity, seen.contact_force));
            let stretch = seen.desired.position - seen.object.position;
            stored_j += 0.5 * scene.peer.object.mass_kg * seen.object.velocity.powi(2)
                + 0.5 * scene.peer.coordination.stiffness_n_per_m * stretch * stretch;
        }
        made_j = made_j.max(stored_j - work_j[0] - work_j[1]);
    }
    Got {
        true_mm: 1e3 * sum_m / f64::from(ticks - ticks / 2),
        out_over_in,
        live: f64::from(live) / f64::from(ticks),
        made_j,
    }
}

/// Mean over seeds; what must hold in each of them is asserted.
fn mean(settings: &[&str], network: &[&str], seeds: u64) -> Got {
    let got: Vec<Got> = (1..=seeds).map(|seed| run(&scene(settings, network, seed), 10_000)).collect();
    for got in &got {
        assert!(got.out_over_in <= 1.0 + 1e-9, "{network:?}: {got:?}");
        // Of each end what it begins with.
        let capital_j = if settings.contains(&STANDS) { 0.0 } else { 0.01 };
        assert!(got.made_j < capital_j + 1e-9, "{network:?}: {got:?}");
    }
    let mean = |of: fn(&Got) -> f64| got.iter().map(of).sum::<f64>() / seeds as f64;
    Got { true_mm: mean(|got| got.true_mm), live: mean(|got| got.live), ..got[0] }
}

fn near(got: f64, wanted: f64, tolerance: f64) {
    assert!((got / wanted - 1.0).abs() < tolerance, "{got}, {wanted} in THEORY");
}

/// K_T = 4,000, b = 10, m_O = 0.3, a credit of 12: 1.69 mm whatever is lost; how much of the time it is live.
#[test]
fn what_is_lost_moves_no_position() {
    let soft = ["coordination.stiffness_n_per_m=4000", "coordination.credit_ticks=12", STANDS];
    near(mean(&soft, &[], 1).true_mm, 1.69, 0.01);
    for (network, live) in [
        (&["network.loss=0.2"][..], 1.00),
        (&["network.loss=0.5"], 0.93),
        (&["network.loss=0.2", "network.loss_burst_packets=40"], 0.65),
        (&["network.loss=0.5", "network.loss_burst_packets=100"], 0.30),
    ] {
        let got = mean(&soft, network, 5);
        near(got.true_mm, 1.69, 0.015);
        assert!((got.live - live).abs() < 0.05, "{network:?}: live {}, {live} in THEORY", got.live);
    }
}

/// K_T = 10⁵, m_O = 0.02, b = 60, a credit of 10.
#[test]
fn a_matched_line_is_close() {
    let matched = [&MATCHED[..], &["coordination.credit_ticks=10", STANDS]].concat();
    near(mean(&matched, &[], 1).true_mm, 0.185, 0.01);
    near(mean(&matched, &["network.loss=0.2", "network.loss_burst_packets=40"], 8).true_mm, 0.217, 0.1);
    near(mean(&matched, &["network.loss=0.5", "network.loss_burst_packets=100"], 8).true_mm, 0.205, 0.1);
}

/// A credit that follows learns any delay, and stays as close as its own line time allows, F·T/b + F/K_T, where the line may weigh what it does.
#[test]
fn a_line_that_follows_learns_the_delay() {
    for delay_ms in [1_u32, 8, 40, 200] {
        let delay = format!("network.one_way_delay_packets={delay_ms}");
        let heavy = [&MATCHED[..], &["coordination.most_line_mass_kg=0"]].concat();
        let got = mean(&heavy, &[&delay], 1);
        // The network's delay and the eight samples that are always kept.
        let line = f64::from(delay_ms + 8) / 60.0 + 0.01;
        assert!(got.true_mm <= 1.3 * line, "{delay_ms} ms: {} mm, {line} mm of its line", got.true_mm);
        // It stands only while it learns.
        assert!(got.live > 0.85, "{delay_ms} ms: live {}", got.live);
    }
}

/// THEORY §15: under a push F at rest the copies stand C·F apart, C = d₀·T_c/(ρ·b) + 2/K_T, less the share of it that a taut line takes back.
#[test]
fn a_taut_line_gives_way_by_what_is_left() {
    for ([credit, delay, packets], stiffness, b, mass_kg) in [
        ([12, 8, 1], 1e4, 60.0, 0.0),
        ([60, 40, 1], 4e3, 20.0, 0.0),
        ([120, 100, 1], 1e5, 60.0, 4.0),
        ([40, 3, 8], 2e3, 40.0, 0.0),
    ] {
        let line_s = 1e-3 * f64::from(credit);
        let light: f64 = if mass_kg > 0.0 { mass_kg / (b * line_s) } else { 1.0 };
        let compliance = line_s / (light.min(1.0) * b) + 2.0 / stiffness;
        for share in [0.0, 0.5, 0.9, 1.0] {
            let settings = [
                format!("coordination.credit_ticks={credit}"),
                format!("network.one_way_delay_packets={}", delay / packets),
                format!("timing.ticks_per_packet={packets}"),
                format!("coordination.stiffness_n_per_m={stiffness}"),
                format!("coordination.wave_impedance_n_s_per_m={b}"),
                format!("coordination.most_line_mass_kg={mass_kg}"),
                format!("coordination.tautness={share}"),
                "user.2.sine_n=0".into(),
            ];
            let settings: Vec<&str> = settings.iter().map(String::as_str).collect();
            let got = run(&scene(&settings, &[], 1), 10_000);
            // Of a push of 1 N.
            let wanted_mm = 1e3 * (1.0 - share) * compliance;
            let within_mm = 0.02 * 1e3 * compliance;
            assert!((got.true_mm - wanted_mm).abs() < within_mm, "{settings:?}: {} mm, {wanted_mm} mm", got.true_mm);
            assert!(got.made_j < 0.06 && got.out_over_in <= 1.0 + 1e-9, "{settings:?}: {got:?}");
        }
    }
}

/// Hostile networks, stated and following credits: nothing is made anywhere (asserted in `mean`), and no end is left behind.
#[test]
fn no_network_makes_energy() {
    let networks: [&[&str]; 6] = [
        &["network.jitter=gamma", "network.jitter_s=0.01"],
        &["network.jitter=uniform", "network.jitter_s=0.03", "network.duplicate=0.2"],
        &["network.reorder=0.3", "network.reorder_depth_packets=16"],
        &["network.loss=0.6"],
        &["network.loss=0.5", "network.loss_burst_packets=40", "network.asymmetry_s=0.04"],
        &["network.clock_drift_ppm=500", "network.loss=0.1", "network.corrupt=0.1"],
    ];
    for network in networks {
        for credit in ["coordination.credit_ticks=0", "coordination.credit_ticks=20"] {
            for stands in [&[STANDS][..], &[]] {
                let got = mean(&[&MATCHED[..], &[credit], stands].concat(), network, 4);
                assert!(got.live > 0.1, "{network:?}, {credit}: live {}", got.live);
            }
        }
    }
}

/// Equal chances by ratio.
fn spread(random: &mut Rng, low: f64, high: f64) -> f64 {
    low * (high / low).powf(random.unit())
}

/// One of these.
fn one<'a>(random: &mut Rng, of: &[&'a str]) -> &'a str {
    of[random.below(of.len() as u64) as usize]
}

/// A thousand scenes over hostile networks, with hands that let go of the object again and again: copies and springs never hold
/// more than the hands put in, and E₀.
#[test]
fn a_thousand_hostile_runs_make_nothing() {
    let mut random = Rng::new(1);
    let mut stood = 0;
    for number in 0..1000 {
        let capital_j = [0.0, 0.002, 0.02][number as usize % 3];
        let settings = [
            format!("coordination.stiffness_n_per_m={}", spread(&mut random, 10.0, 1e6)),
            format!("coordination.damping_n_s_per_m={}", 20.0 * random.unit()),
            format!("coordination.wave_impedance_n_s_per_m={}", spread(&mut random, 1.0, 200.0)),
            format!("object.mass_kg={}", spread(&mut random, 1e-3, 10.0)),
            format!("timing.ticks_per_packet={}", 1 + (8.0 * random.unit()) as u32),
            one(
                &mut random,
                &["coordination.credit_ticks=0", "coordination.credit_ticks=10", "coordination.credit_ticks=60"],
            )
            .into(),
            format!(
                "coordination.carry_damping_n_s_per_m={}",
                if number % 4 == 0 { 0.0 } else { spread(&mut random, 0.5, 200.0) }
            ),
            format!("coordination.carry_s={}", spread(&mut random, 0.01, 2.0)),
            format!("coordination.carry_return_s={}", spread(&mut random, 0.005, 0.5)),
            format!("coordination.carry_energy_j={capital_j}"),
            format!("coordination.tautness={}", if number % 2 == 0 { 0.0 } else { 1.5 * random.unit() }),
            format!("coordination.even_s={}", ["0", "0.02", "0.1"][number as usize / 3 % 3]),
            // Pushed only: what is on its own side of the surface is let go of.
            one(&mut random, &["contact.one_sided=true", "contact.one_sided=false", "contact.gap_m=0.002"]).into(),
            format!("user.1.pulse_n={}", 3.0 * random.unit()),
            "user.1.pulse_every_s=0.3".into(),
            format!("user.2.sine_n={}", 2.0 * random.unit()),
            "user.2.sine_rad_per_s=11".into(),
        ];
        let network = [
            format!("network.one_way_delay_packets={}", (12.0 * random.unit()) as u32),
            format!("network.loss={}", 0.6 * random.unit()),
            format!("network.loss_burst_packets={}", spread(&mut random, 1.0, 100.0)),
            one(&mut random, &["network.jitter=gamma", "network.jitter=uniform", "network.jitter=pareto"]).into(),
            format!("network.jitter_s={}", spread(&mut random, 1e-4, 0.02)),
            format!("network.duplicate={}", 0.3 * random.unit()),
            format!("network.reorder={}", 0.3 * random.unit()),
            "network.reorder_depth_packets=8".into(),
            format!("network.clock_drift_ppm={}", 500.0 * random.unit()),
        ];
        let [settings, network] =
            [settings.as_slice(), &network].map(|all| all.iter().map(String::as_str).collect::<Vec<_>>());
        let got = run(&scene(&settings, &network, number), 2_000);
        let borrowed_j = if number % 4 == 0 { 0.0 } else { 2.0 * capital_j };
        assert!(got.made_j < borrowed_j + 1e-9, "run {number}: {got:?} of {settings:?} over {network:?}");
        assert!(got.out_over_in <= 1.0 + 1e-9, "run {number}: {got:?} of {settings:?} over {network:?}");
        stood += u32::from(got.live < 0.95);
    }
    assert!(stood > 300, "networks that stop a line are among them: {stood}");
}

/// Two hands in ordinary motion over 8 ms: pushes of the cooperation paper's §5.2, and a hand that is led ±50 mm at 1 Hz with the object
/// in front of it, which the other hand presses with 2 N.
const PUSHES: &[&str] = &["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];
const LED: &[&str] = &[
    "user.1.arm_stiffness_n_per_m=300",
    "user.1.arm_damping_n_s_per_m=5",
    "user.1.arm_mass_kg=0.5",
    "user.1.tremor_m=0.05",
    "user.1.tremor_hz=1",
    "user.1.push_n=2",
    "user.2.push_n=2",
];

fn outcome(settings: &[&[&str]]) -> Outcome {
    let mut scene = scenes::load(Laws::built_in(), "any-network").expect("built in");
    scene.users = Default::default();
    settings.iter().copied().flatten().for_each(|setting| scene.apply_override(setting).expect("a good override"));
    scene.check("test").expect("a good scene");
    cohold_sim::run::run::<f64>(&scene, Options { duration_s: 20.0, record_every: 0 }, &|_| ()).expect("a good scene")
}

/// N samples in a packet cost the delay of those beyond the 8 spare ones: (N − 8)·T_c of line each way, which is (N − 8)·T_c·F/b
/// under a push F, and nothing else, where no tautness takes it back.
#[test]
fn fewer_packets_cost_the_delay_of_the_samples_beyond_the_spare_ones() {
    const SLACK: &[&str] = &["coordination.tautness=0"];
    let each_tick = outcome(&[PUSHES, SLACK]);
    assert!((each_tick.packets_per_s - 1000.0).abs() < 1e-9);
    for together in [8, 9, 10, 12, 16] {
        let of_events =
            outcome(&[PUSHES, SLACK, &["event.longest_s=0.05", &format!("event.together_ticks={together}")]]);
        let (b, force_n) = (60.0, 1.0);
        let expected_mm = each_tick.whole.true_discrepancy_mm + f64::from(together - 8) * force_n / b;
        let ratio = of_events.whole.true_discrepancy_mm / expected_mm;
        assert!((ratio - 1.0).abs() < 0.01, "{together}: {} mm for {expected_mm}", of_events.whole.true_discrepancy_mm);
        let rate = 1000.0 / f64::from(together);
        assert!((of_events.packets_per_s / rate - 1.0).abs() < 0.02, "{together}: {}", of_events.packets_per_s);
    }
}

#[test]
fn a_hundred_packets_a_second_hold_the_object_nearly_as_a_thousand_do() {
    // Without delay the line becomes as short as with a packet a tick; over 48 ms it is N − 1 ticks longer, of some 60; over 200 ms that is little of it.
    let networks: [(&[&str], f64); 4] = [
        (&[], 1.1),
        (&["network.one_way_delay_packets=0"], 1.1),
        (&["network.one_way_delay_packets=48"], 1.14),
        (&["network.one_way_delay_packets=200"], 1.1),
    ];
    let pushes = networks.map(|(network, most)| (PUSHES, network, most));
    for (motion, network, most) in pushes.into_iter().chain([(LED, &[][..], 1.1)]) {
        let each_tick = outcome(&[motion, network]);
        let of_events = outcome(&[motion, network, &["event.longest_s=0.05"]]);
        assert!(of_events.is_stable() && of_events.packets_per_s < 120.0, "{} packets/s", of_events.packets_per_s);
        let ratio = of_events.whole.true_discrepancy_mm / each_tick.whole.true_discrepancy_mm;
        assert!((0.9..most).contains(&ratio), "{network:?}: {ratio}");
        assert!(of_events.energy_made_mj() <= 1e-6);
    }
    let at_rest = outcome(&[&["event.longest_s=0.05"]]);
    assert!((19.0..21.0).contains(&at_rest.packets_per_s), "{} packets/s at rest", at_rest.packets_per_s);
}
