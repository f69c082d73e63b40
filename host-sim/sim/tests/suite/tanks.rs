//! Laws that pay for their energy, over networks that lose, delay, repeat and reorder: what they promise, law by law.

use cohold_core::num::Fixed;
use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;
use cohold_sim::rng::Rng;
use cohold_sim::user::Trace;
use cohold_sim::{Scene, scenes};

/// A law, the share of K_T·(x_d − x_o)² that waits in its spring, and what is in each tank at first, J.
#[derive(Clone, Copy, Debug)]
struct Subject {
    law: &'static str,
    spring: f64,
    start_j: f64,
}

const SET_POSITION: Subject = Subject { law: "set-position", spring: 0.5, start_j: 0.02 };
const PASSIVE_SPRING: Subject = Subject { law: "passive-spring", spring: 0.25, start_j: 0.02 };
const TWO_LAYER: Subject = Subject { law: "two-layer", spring: 0.0, start_j: 0.02 };
const WAVE_INTEGRAL: Subject = Subject { law: "wave-integral", spring: 0.5, start_j: 0.0 };
const WAVE_COMPENSATOR: Subject = Subject { law: "wave-compensator", spring: 0.5, start_j: 0.0 };
const PASSIVE_DEADBAND: Subject = Subject { law: "passive-deadband", ..PASSIVE_SPRING };
const ALL: [Subject; 6] = [SET_POSITION, PASSIVE_SPRING, TWO_LAYER, WAVE_INTEGRAL, WAVE_COMPENSATOR, PASSIVE_DEADBAND];

/// §5.2 with this law, moved by ports.
fn scene(law: &str, settings: &[String]) -> Scene {
    let mut scene = scenes::load(cohold_guest_laws::laws(), "paper-5.2-passive-wave-16ms").expect("built in");
    let common = [
        "object.integrator=midpoint",
        "object.force_delay_ticks=0",
        "coordination.decode=implicit",
        &format!("coordination.comm={law}"),
        "safety.fade_s=50",
        "safety.disengage_s=90",
        "safety.peer_lost_s=100",
        "safety.max_delay_s=1",
    ];
    let silent = (law == PASSIVE_DEADBAND.law).then_some("event.longest_s=0.1");
    for setting in common.into_iter().chain(silent).chain(settings.iter().map(String::as_str)) {
        scene.apply_override(setting).expect("a good override");
    }
    scene.check("test").expect("a good scene");
    scene
}

/// Books what hands and contacts do on the copies, and what the copies hold.
struct Books {
    subject: Subject,
    before: [Option<(f64, f64)>; 2],
    work_j: f64,
    /// Energy of both copies and both springs less what was done on them, at the most, J.
    made_j: f64,
    /// Energy that came out of the line less what went in, in the worse direction, at the most, J.
    leaked_j: f64,
    sent_j: f64,
}

impl Books {
    fn new(subject: Subject) -> Self {
        Self { subject, before: [None; 2], work_j: 0.0, made_j: f64::MIN, leaked_j: f64::MIN, sent_j: 0.0 }
    }

    /// `rounding`: of the sums that a peer of this number type keeps, as a share.
    fn book<S: Number>(&mut self, pair: &Pair<S>, scene: &Scene, rounding: f64) {
        let peer = &scene.peer;
        let mut stored_j = 0.0;
        for (before, side) in self.before.iter_mut().zip(pair.sides()) {
            let seen = side.peer.observed()[0];
            let now = seen.object.velocity.to_f64();
            if let Some((velocity, force)) = *before {
                self.work_j += peer.timing.control_period_s * force * 0.5 * (velocity + now);
            }
            *before = Some((now, seen.contact_force.to_f64()));
            let stretch = seen.desired.position.to_f64() - seen.object.position.to_f64();
            stored_j += 0.5 * peer.object.mass_kg * now.powi(2)
                + self.subject.spring * peer.coordination.stiffness_n_per_m * stretch * stretch;
        }
        self.made_j = self.made_j.max(stored_j - self.work_j);
        let ledgers = pair.sides().map(|side| side.peer.ledger()[0]);
        let energies = ledgers.map(|ledger| (ledger.received_j().to_f64(), ledger.sent_j().to_f64()));
        for (sent, out) in [(energies[0].1, energies[1].0), (energies[1].1, energies[0].0)] {
            self.leaked_j = self.leaked_j.max(out - sent * (1.0 + rounding));
            self.sent_j = self.sent_j.max(sent);
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

/// Peers of any size and hands that push, let go and push again.
fn any_peers(random: &mut Rng) -> Vec<String> {
    vec![
        format!("coordination.stiffness_n_per_m={}", spread(random, 10.0, 1e5)),
        format!("coordination.damping_n_s_per_m={}", 20.0 * random.unit()),
        format!("coordination.wave_impedance_n_s_per_m={}", spread(random, 1.0, 200.0)),
        format!("object.mass_kg={}", spread(random, 1e-2, 10.0)),
        format!("timing.ticks_per_packet={}", 1 + (8.0 * random.unit()) as u32),
        one(random, &["contact.one_sided=true", "contact.one_sided=false", "contact.gap_m=0.002"]).into(),
        format!("user.1.pulse_n={}", 3.0 * random.unit()),
        "user.1.pulse_every_s=0.3".into(),
        format!("user.2.sine_n={}", 2.0 * random.unit()),
        "user.2.sine_rad_per_s=11".into(),
    ]
}

fn any_network(random: &mut Rng, seed: u64) -> Vec<String> {
    vec![
        format!("network.one_way_delay_packets={}", (12.0 * random.unit()) as u32),
        format!("network.loss={}", 0.6 * random.unit()),
        format!("network.loss_burst_packets={}", spread(random, 1.0, 100.0)),
        one(random, &["network.jitter=gamma", "network.jitter=uniform", "network.jitter=pareto"]).into(),
        format!("network.jitter_s={}", spread(random, 1e-4, 0.02)),
        format!("network.duplicate={}", 0.3 * random.unit()),
        format!("network.reorder={}", 0.3 * random.unit()),
        "network.reorder_depth_packets=8".into(),
        format!("network.delay_step_s={}", 0.05 * random.unit()),
        format!("network.clock_drift_ppm={}", 500.0 * random.unit()),
        format!("network.seed={seed}"),
    ]
}

/// Passive: at no tick have copies and springs more than the tanks had at first and what was done on them, and at no tick has more
/// come out of the line than went in.
fn makes_nothing<S: Number>(subject: Subject, runs: u64, rounding: f64) {
    let mut random = Rng::new(1);
    let mut moved_j = 0.0_f64;
    for seed in 1..=runs {
        let settings = [any_peers(&mut random), any_network(&mut random, seed)].concat();
        let scene = scene(subject.law, &settings);
        let mut pair = Pair::<S>::new(&scene).expect("a good scene");
        let mut books = Books::new(subject);
        for _ in 0..2000 {
            pair.step();
            if pair.fault().is_some() {
                // Hands that throw a light copy are too fast for the device, whoever holds it.
                break;
            }
            books.book(&pair, &scene, rounding);
        }
        let Books { made_j, leaked_j, work_j, sent_j, .. } = books;
        // A spring of K N/m that is rounded to a step of its position is wrong by K times that; so it is of every tick.
        let rounding_j = 1e-9 + 1e3 * rounding * (1.0 + work_j.abs());
        assert!(made_j <= 2.0 * subject.start_j + rounding_j, "{subject:?}, run {seed}: {made_j} J of {settings:?}");
        assert!(leaked_j <= rounding_j, "{subject:?}, run {seed}: {leaked_j} J of {sent_j} of {settings:?}");
        moved_j += sent_j;
    }
    assert!(moved_j > 1e-3 * runs as f64, "{subject:?}: {moved_j} J crossed the line");
}

#[test]
fn no_network_makes_energy() {
    for subject in ALL {
        makes_nothing::<f64>(subject, 150, 1e-12);
        makes_nothing::<f32>(subject, 40, 1e-6);
        makes_nothing::<Fixed>(subject, 40, 1e-6);
    }
}

/// The same with nobody there: released copies that begin apart in speed.
#[test]
fn released_copies_gain_nothing() {
    for subject in ALL {
        let mut random = Rng::new(2);
        for seed in 1..=60 {
            let mut settings = [any_peers(&mut random), any_network(&mut random, seed)].concat();
            settings.push("contact.one_sided=true".into());
            // One push of 50 ms toward the object, which then flies free.
            settings.push("user.1.pulse_every_s=1000".into());
            settings.push("user.2.sine_n=0".into());
            settings.push("user.1.pulse_n=5".into());
            settings.push("user.1.pulse_s=0.05".into());
            settings.push("user.1.push_n=0".into());
            settings.push("user.2.push_n=0".into());
            let scene = scene(subject.law, &settings);
            let mut pair = Pair::<f64>::new(&scene).expect("a good scene");
            let mut books = Books::new(subject);
            for _ in 0..2000 {
                pair.step();
                if pair.fault().is_some() {
                    break;
                }
                books.book(&pair, &scene, 1e-12);
            }
            let made_j = books.made_j;
            assert!(made_j <= 2.0 * subject.start_j + 1e-9, "{subject:?}, run {seed}: {made_j} J of {settings:?}");
        }
    }
}

/// No drift: pushed against each other over a bad network for 4 s, then left alone on it, the copies come back beside each other.
fn comes_back(subject: Subject, extra: &[&str], within_m: f64) {
    let mut worst = (0.0_f64, 0.0_f64);
    for seed in 1..=20 {
        let mut random = Rng::new(100 + seed);
        let mut settings = any_network(&mut random, seed);
        settings.extend(extra.iter().map(|&setting| setting.to_owned()));
        for user in [1, 2] {
            settings.extend(["push_n=0.5", "sine_n=0", "pulse_n=0"].map(|what| format!("user.{user}.{what}")));
        }
        let mut bad = scene(subject.law, &settings);
        bad.users.iter_mut().for_each(|user| user.trace = Some(Trace::step(4.0, -0.5)));
        let mut pair = Pair::<f64>::new(&bad).expect("a good scene");
        let mut largest = 0.0_f64;
        let mut distance_m = 0.0;
        for _ in 0..20_000 {
            pair.step();
            assert_eq!(pair.fault(), None, "{subject:?}, seed {seed}");
            let [one, two] = pair.sides().map(|side| side.peer.observed()[0].object.position);
            distance_m = (one - two).abs();
            largest = largest.max(distance_m);
        }
        worst = (worst.0.max(distance_m), worst.1.max(largest));
    }
    println!("{subject:?}: {:.2e} m apart in the end, {:.2e} m at the most", worst.0, worst.1);
    assert!(worst.0 <= within_m, "{subject:?}: {} m apart", worst.0);
}

#[test]
fn copies_come_back() {
    comes_back(SET_POSITION, &["coordination.stiffness_n_per_m=1000", "coordination.damping_n_s_per_m=10"], 1e-4);
    comes_back(PASSIVE_SPRING, &["coordination.stiffness_n_per_m=1000"], 1e-4);
    comes_back(WAVE_INTEGRAL, &["coordination.stiffness_n_per_m=10000"], 1e-4);
}
