//! Lanes against the scalar peer: the same bits, whatever the scene, and whoever leaves.

use cohold_sim::lanes::number::{LANES, lanes_left};
use cohold_sim::lanes::{self, How, Pairs};
use cohold_sim::rng::Rng;
use cohold_sim::run::{Options, Outcome, Reason, Until, run};
use cohold_sim::{Scene, scenes};

/// Scenes of the test: all of them in a build that is fast.
const SCENES: usize = if cfg!(debug_assertions) { 64 } else { 1000 };
/// Scenes in a row that differ in gains, masses and users alone.
const OF_A_KIND: usize = 20;
const SECONDS: f64 = 1.0;
const WHOLE: How = How::until(Until::TheEnd);

/// Random scenes: of every law, integrator and decoding, any gains; stable or not, on good networks and bad ones.
fn random_scenes(random: &mut Rng) -> Vec<Scene> {
    let mut found = Vec::new();
    // Some of what is drawn no peer allows.
    for _ in 0..3 * SCENES / OF_A_KIND {
        let names = ["power", "wave", "passive-wave", "passive-mean", "none", "self-timed"];
        let pick = |random: &mut Rng, count| random.below(count) as usize;
        let integrator = ["forward-euler", "semi-implicit", "exact", "midpoint", "backward-euler"][pick(random, 5)];
        let midpoint = matches!(integrator, "midpoint" | "backward-euler");
        let law = names[pick(random, 6)];
        let mut kind = vec![
            format!("coordination.comm={law}"),
            format!("object.integrator={integrator}"),
            format!(
                "coordination.decode={}",
                if midpoint { "implicit" } else { ["delayed", "implicit"][pick(random, 2)] }
            ),
            format!("axis.velocity={}", ["measured", "difference", "filtered", "adaptive"][pick(random, 4)]),
            format!("network.one_way_delay_packets={}", random.below(4)),
            format!("network.seed={}", random.below(1000)),
            format!("network.loss={}", if random.chance(0.5) { 0.0 } else { 0.1 * random.unit() }),
            format!("network.jitter={}", ["none", "uniform"][pick(random, 2)]),
            "network.jitter_s=0.01".to_owned(),
            format!("contact.one_sided={}", random.chance(0.3)),
            format!("coordination.ledger={}", random.chance(0.2) && !matches!(law, "power" | "none")),
        ];
        if midpoint {
            kind.push("object.force_delay_ticks=0.0".to_owned());
        }
        for _ in 0..OF_A_KIND {
            let mut own = kind.clone();
            let between = |random: &mut Rng, low: f64, high: f64| low * (high / low).powf(random.unit());
            for (key, low, high) in [
                ("coordination.stiffness_n_per_m", 50.0, 3e4),
                ("coordination.damping_n_s_per_m", 0.1, 20.0),
                ("coordination.wave_impedance_n_s_per_m", 2.0, 100.0),
                ("object.mass_kg", 0.02, 1.0),
                ("device.mass_kg", 0.05, 1.0),
                ("contact.stiffness_n_per_m", 100.0, 5000.0),
                ("user.1.push_n", 0.1, 5.0),
                ("user.2.sine_n", 0.1, 5.0),
                ("user.1.pulse_n", 0.1, 20.0),
            ] {
                own.push(format!("{key}={}", between(random, low, high)));
            }
            own.push(format!("device.force_delay_ticks={}", random.unit()));
            if let Ok(scene) = Scene::load(cohold_guest_laws::laws(), None, &own) {
                found.push(scene);
            }
        }
    }
    assert!(found.len() >= SCENES, "{} scenes", found.len());
    found.truncate(SCENES);
    found
}

/// Everything that a run gave, to the bit.
fn printed(outcome: &Outcome) -> String {
    format!("{outcome:?}")
}

/// From 3 of a kind on, whatever pays on this processor.
fn side_by_side(until: Until, scenes: &[Scene], duration_s: f64) -> Vec<Outcome> {
    let outcomes = lanes::run(How { fewest: 3, until }, scenes, duration_s).unwrap();
    assert_eq!(outcomes.len(), scenes.len());
    outcomes
}

fn same(scenes: &[Scene]) {
    same_for(scenes, SECONDS);
}

fn same_for(scenes: &[Scene], duration_s: f64) {
    for (scene, outcome) in scenes.iter().zip(side_by_side(Until::TheEnd, scenes, duration_s)) {
        let alone = run::<f64>(scene, Options { duration_s, record_every: 0 }, &|_| {}).unwrap();
        assert_eq!(printed(&outcome), printed(&alone), "{:?}", scene.settings());
    }
}

#[test]
fn random_scenes_have_the_bits_that_they_have_alone() {
    let scenes = random_scenes(&mut Rng::new(1));
    same(&scenes);
}

/// The same of two and of three shared axes, with users who push anywhere.
#[test]
fn random_scenes_of_several_axes_have_the_bits_that_they_have_alone() {
    let mut random = Rng::new(2);
    let mut scenes = random_scenes(&mut random);
    for (at, scene) in scenes.iter_mut().enumerate() {
        let axes = 2 + (at / OF_A_KIND % 2) as u32;
        (scene.peer.axis.count, scene.peer.axis.shared) = (axes, axes);
        // A side belongs to one axis.
        scene.peer.contact.one_sided = false;
        for user in &mut scene.users {
            let profile = &mut user.settings.user;
            (profile.direction_rad, profile.elevation_rad) = (6.0 * random.unit() - 3.0, 3.0 * random.unit() - 1.5);
        }
        scene.check("random").unwrap_or_else(|error| panic!("{error}"));
    }
    same(&scenes);
}

/// Scenes that differ in their gain alone.
fn gains(name: &str, least: f64, most: f64) -> Vec<Scene> {
    let gain = |lane: usize| least + (most - least) * lane as f64 / (LANES - 1) as f64;
    let of = |lane| {
        let mut scene = scenes::load(cohold_guest_laws::laws(), name).unwrap();
        scene.peer.coordination.stiffness_n_per_m = gain(lane);
        scene
    };
    (0..LANES).map(of).collect()
}

#[test]
fn scenes_that_differ_in_gains_stay_in_their_lanes_and_a_fault_takes_only_its_own_out() {
    let left = |scenes: &[Scene]| {
        let mut pairs = Pairs::<1>::new(&scenes.iter().collect::<Vec<_>>()).unwrap();
        (0..20_000).for_each(|_| pairs.step(&mut |_| ()));
        lanes_left()
    };
    assert_eq!(left(&gains("matched-line", 2e4, 8e4)), 0);
    // The paper's own: unstable in a pocket about 5000 N/m, where forces grow until the guard sees them.
    let pocket = left(&gains("paper-5.1-passive-wave-16ms", 2124.0, 8496.0));
    assert!(pocket != 0 && pocket.count_ones() < 8, "{pocket:b}");
    same(&gains("paper-5.1-passive-wave-16ms", 2124.0, 8496.0));
}

/// Limits, then faults take lanes out at ticks of their own, each of either peer: what was accounted until then is each one's own, and what
/// comes after as well.
#[test]
fn lanes_that_leave_one_after_another_have_the_figures_and_hashes_that_they_have_alone() {
    let scenes = gains("paper-5.2-wave-16ms", 3400.0, 5000.0);
    let seconds = 4.0;
    same_for(&scenes, seconds);
    let mut pairs = Pairs::<1>::new(&scenes.iter().collect::<Vec<_>>()).unwrap();
    let mut times = std::collections::BTreeSet::new();
    for tick in 0..4000 {
        let before = lanes_left();
        pairs.step(&mut |_| ());
        times.extend((lanes_left() != before).then_some(tick));
    }
    assert!(times.len() > 3 && times.first() > Some(&1000), "{times:?}");
}

/// Who asks for figures of merit alone gets what the whole run gives.
#[test]
fn a_run_that_ends_where_a_peer_stops_has_the_verdict_of_the_whole_one() {
    let scenes = gains("paper-5.2-wave-16ms", 1000.0, 10_000.0);
    let whole = lanes::run(WHOLE, &scenes, 4.0).unwrap();
    let mut stopped = 0;
    for (whole, ended) in whole.iter().zip(side_by_side(Until::Stopped, &scenes, 4.0)) {
        assert_eq!((whole.reason, whole.fault_time_s), (ended.reason, ended.fault_time_s));
        if let Some(Reason::Stopped { time_s, .. }) = ended.reason {
            stopped += 1;
            assert_eq!(ended.ticks, (time_s * 1000.0).round() as u64 + 1);
            assert_eq!(ended.metric(|_| ()), None);
        } else {
            assert_eq!(printed(whole), printed(&ended));
        }
    }
    assert!((1..LANES).contains(&stopped), "{stopped}");
}

/// Four gains with four seeds each, on a network as these settings say.
fn gains_and_seeds(settings: &[&str]) -> Vec<Scene> {
    let of = |lane: usize| {
        let mut scene = scenes::load(cohold_guest_laws::laws(), "paper-5.2-wave-16ms").expect("a built-in scene");
        let own = [
            format!("coordination.stiffness_n_per_m={}", 100.0 * (1 + lane / 4) as f64),
            format!("network.seed={}", 7 + lane % 4),
        ];
        for setting in settings.iter().copied().chain(own.iter().map(String::as_str)) {
            scene.apply_override(setting).expect("a good override");
        }
        scene
    };
    (0..LANES).map(of).collect()
}

/// Laws that only hold packets have lanes with seeds of their own: what is lost or late in one comes in another, and fades in each by itself.
#[test]
fn lanes_whose_packets_are_lost_and_late_at_other_times_have_the_bits_that_they_have_alone() {
    let networks: [&[&str]; 4] = [
        &["network.loss=0.1"],
        &["network.loss=0.45", "safety.fade_s=0.0", "safety.disengage_s=0.4"],
        &["network.jitter=pareto", "network.jitter_s=0.01", "network.reorder=0.2", "network.duplicate=0.2"],
        &["network.like=home-wifi", "timing.ticks_per_packet=3", "network.clock_drift_ppm=5000"],
    ];
    for law in ["power", "p-plus-d", "wave", "passive-wave", "passive-mean"] {
        let law = format!("coordination.comm={law}");
        for network in networks {
            let scenes = gains_and_seeds(&[&[law.as_str()], network].concat());
            let mut pairs = Pairs::<1>::new(&scenes.iter().collect::<Vec<_>>()).unwrap();
            (0..1000).for_each(|_| pairs.step(&mut |_| ()));
            // Jumps of what is late may reach a limit.
            assert!(lanes_left().count_ones() <= 2, "{law} {network:?}");
            let mut hashes: Vec<u64> =
                lanes::run(WHOLE, &scenes, SECONDS).unwrap().iter().map(|outcome| outcome.hash).collect();
            hashes.sort_unstable();
            hashes.dedup();
            assert_eq!(hashes.len(), LANES, "{law} {network:?}");
            same(&scenes);
        }
    }
}

/// A silence that lets go of the other peer takes its lane alone out.
#[test]
fn a_lane_that_is_let_go_of_leaves() {
    let scenes = gains_and_seeds(&["network.loss=0.35", "safety.fade_s=0.0", "safety.disengage_s=0.04"]);
    let mut pairs = Pairs::<1>::new(&scenes.iter().collect::<Vec<_>>()).unwrap();
    (0..300).for_each(|_| pairs.step(&mut |_| ()));
    let left = lanes_left().count_ones();
    assert!(left > 0 && left < LANES as u32, "{left}");
    same(&scenes);
}

#[test]
fn what_draws_nothing_is_the_same_with_every_seed() {
    let quiet = gains_and_seeds(&["network.extra_delay_s=0.003"]);
    assert!(quiet.iter().all(|scene| !scene.draws()));
    let outcomes = lanes::run(WHOLE, &quiet[..4], SECONDS).unwrap();
    assert!(outcomes.iter().all(|outcome| printed(outcome) == printed(&outcomes[0])));
    for random in ["network.loss=0.1", "network.jitter=uniform", "network.like=starlink", "network.corrupt=0.1"] {
        assert!(gains_and_seeds(&[random])[0].draws(), "{random}");
    }
}

/// What a law keeps in counters is each lane's own, too; gains, losses and what is in the tank differ.
#[test]
fn laws_with_energy_tanks_have_the_bits_that_they_have_alone() {
    for law in ["set-position", "passive-spring", "two-layer", "wave-integral", "wave-compensator"] {
        let mut scenes = gains("matched-line", 500.0, 8e3);
        for scene in &mut scenes {
            for setting in [&format!("coordination.comm={law}"), "object.integrator=midpoint", "network.loss=0.2"] {
                scene.apply_override(setting).expect("a good override");
            }
        }
        same(&scenes);
    }
}

#[test]
fn a_scene_that_is_built_otherwise_than_its_lanes_leaves_them_at_once() {
    let mut scenes = gains("matched-line", 2e4, 8e4);
    // Play is another surface, the guard counts another number of ticks, and lanes do not have a whole number each.
    scenes[3].peer.contact.gap_m = 1e-3;
    scenes[5].peer.safety.saturated_ticks = 7;
    Pairs::<1>::new(&scenes.iter().collect::<Vec<_>>()).unwrap();
    assert_eq!(lanes_left(), 1 << 3 | 1 << 5);
    same(&scenes);
}

/// A law from outside that keeps a whole number, and whose text says nothing; what it is it hands over, or not.
mod stepped {
    use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Spring};
    use cohold_core::num::{Configured, Motion, Scalar};
    use cohold_core::object::Solve;
    use cohold_core::settings::{Key, Refused, Settings};

    const TIMES: Key = Key::number("stepped.times", 1.0, [1.0, 8.0], "").means("How often the spring is there.");

    #[derive(Clone, Copy)]
    pub(super) struct Stepped<S, const SAYS: bool> {
        spring: Spring<S>,
        times: i32,
    }

    impl<S: Scalar, const SAYS: bool> Configured for Stepped<S, SAYS> {
        fn configuration(&self, each: &mut dyn FnMut(u64)) -> bool {
            SAYS && self.spring.configuration(each) & self.times.configuration(each)
        }
    }

    impl<S, const SAYS: bool> std::fmt::Debug for Stepped<S, SAYS> {
        fn fmt(&self, text: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            text.write_str("Stepped")
        }
    }

    impl<S: Scalar, const SAYS: bool> Law<S> for Stepped<S, SAYS> {
        const LAWS: &'static [LawInfo] = &[LawInfo { name: "stepped", keys: &[TIMES], ..LawInfo::MOTION }];
        type State = Motion<S>;

        fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
            Ok(Self { spring: Spring::build(settings), times: settings.own(&TIMES) as i32 })
        }
        fn start(&self, local: Motion<S>) -> Motion<S> {
            local
        }
        fn receive(&self, desired: &mut Motion<S>, packet: Packet<S>) {
            *desired = packet.motion;
        }
        fn couple(&self, desired: &mut Motion<S>, seen: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
            let force = S::from_i32(self.times) * self.spring.force(*desired, seen.local, solve);
            Coupled::toward(*desired, force)
        }
        fn send(&self, _: &Motion<S>, local: Motion<S>) -> Packet<S> {
            Packet { motion: local, ..Packet::default() }
        }
    }

    pub(super) struct Family<const SAYS: bool>;

    impl<const SAYS: bool> cohold_sim::Family for Family<SAYS> {
        type Of<S: Scalar> = Stepped<S, SAYS>;
    }
}

/// Scenes with it, of which every fourth counts to another number, keep their bits; which lanes leave.
fn stepped<const SAYS: bool>() -> u32 {
    let laws = cohold_guest_laws::laws().with::<stepped::Family<SAYS>>();
    let of = |lane: usize| {
        let mut scene = scenes::load(laws, "paper-5.2-power-16ms").expect("a built-in scene");
        let times = format!("stepped.times={}", if lane % 4 == 1 { 2 } else { 1 });
        for setting in ["coordination.comm=stepped", "coordination.stiffness_n_per_m=50", &times] {
            scene.apply_override(setting).expect("a good override");
        }
        scene
    };
    let scenes: Vec<Scene> = (0..LANES).map(of).collect();
    same(&scenes);
    let [one, two] = [0, 1].map(|lane| lanes::run(WHOLE, &scenes[lane..=lane], SECONDS).unwrap()[0].hash);
    assert_ne!(one, two);
    Pairs::<1>::new(&scenes.iter().collect::<Vec<_>>()).unwrap();
    lanes_left()
}

#[test]
fn a_law_is_compared_by_what_it_hands_over_and_has_no_lanes_if_that_is_nothing() {
    assert_eq!(stepped::<true>(), 0x2222);
    assert_eq!(stepped::<false>(), (1 << LANES) - 1);
}
