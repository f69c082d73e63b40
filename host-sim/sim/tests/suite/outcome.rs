//! When a run is stable, what is reported of one that is not, and the energy at a peer's ports, against closed forms.

use cohold_core::num::Motion;
use cohold_core::peer::Observed;
use cohold_core::safety::{Fault, Mode};
use cohold_sim::measure::growth::Swings;
use cohold_sim::run::{APART_MM, Accounts, Options, Outcome, Reason, Ticked, Verdict, compliance_m_per_n, run};
use cohold_sim::{Laws, Scene};

const TICKS: u64 = 8000;
const OPTIONS: Options = Options { duration_s: 8.0, record_every: 0 };

fn scene(overrides: &[&str]) -> Scene {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Scene::load(Laws::built_in(), None, &overrides).expect("a good scene")
}

/// A peer whose copy is at `position`, moves at `velocity` and feels `force`, armed and engaged.
fn at(position: f64, velocity: f64, force: f64) -> Observed<f64> {
    let object = Motion { position, velocity };
    Observed { object, desired: object, coordination_force: force, ..Observed::default() }
}

fn peer_tick(observed: Observed<f64>, mode: Mode, engaged: bool) -> Ticked {
    Ticked::new(&observed, [0.0; 2], mode, engaged)
}

/// What comes of a run whose peer 1 does nothing and whose peer 2 is as said at each time, s.
fn outcome(second: impl Fn(f64) -> Ticked) -> Outcome {
    outcome_in(&scene(&[]), second)
}

/// The same in this scene.
fn outcome_in(scene: &Scene, second: impl Fn(f64) -> Ticked) -> Outcome {
    let mut account = Accounts::<1>::new(scene, TICKS, OPTIONS);
    for tick in 0..TICKS {
        account.ticked(0, [peer_tick(at(0.0, 0.0, 0.0), Mode::Armed, true)]);
        account.ticked(1, [second(1e-3 * tick as f64)]);
        account.period();
    }
    account.outcome()
}

fn armed(observed: Observed<f64>) -> Ticked {
    peer_tick(observed, Mode::Armed, true)
}

#[track_caller]
fn close(got: f64, want: f64, within: f64) {
    assert!((got - want).abs() <= within, "{got} is not {want}");
}

#[test]
fn every_figure_of_a_stable_run_is_told() {
    let outcome = outcome(|time| armed(at(1e-3, 0.01 * time.sin(), 2.0)));
    assert_eq!((outcome.reason, outcome.verdict(), outcome.is_stable()), (None, Verdict::Stable, true));
    close(outcome.metric(|o| o.whole.true_discrepancy_mm).expect("a figure"), 1.0, 1e-12);
    close(outcome.metric(|o| o.whole.coordination_force_n.mean).expect("a figure"), 2.0, 1e-12);
}

/// The copies stand 5 mm apart until the fault and together after it: a mean over that would be small.
#[test]
fn a_fault_takes_every_figure_and_names_itself() {
    let outcome = outcome(|time| match time < 6.0 {
        true => armed(at(5e-3, 0.0, 1.0)),
        false => peer_tick(at(0.0, 0.0, 0.0), Mode::Faulted(Fault::ForceSaturated), false),
    });
    let reason = outcome.reason.expect("a reason");
    let wanted = format!("peer 2 stopped at 6.000 s: ForceSaturated: {}", Fault::ForceSaturated.explain());
    assert_eq!(reason.to_string(), wanted);
    assert_eq!((outcome.verdict(), outcome.verdict().name(), outcome.bounded), (Verdict::Unstable, "NO", false));
    assert_eq!(outcome.metric(|o| o.whole.true_discrepancy_mm), None);
    assert_eq!(outcome.metric(|o| o.whole.true_discrepancy_mm), None);
    // What is behind it was averaged until the fault.
    close(outcome.whole.true_discrepancy_mm, 5.0, 1e-12);
}

#[test]
fn the_peer_that_stopped_first_is_named() {
    let mut account = Accounts::<1>::new(&scene(&[]), TICKS, OPTIONS);
    for tick in 0..TICKS {
        let since = |first, fault| if tick < first { Mode::Armed } else { Mode::Faulted(fault) };
        account.ticked(0, [peer_tick(at(0.0, 0.0, 0.0), since(3000, Fault::PeerLost), tick < 3000)]);
        account.ticked(1, [peer_tick(at(0.0, 0.0, 0.0), since(2000, Fault::Overspeed), tick < 2000)]);
        account.period();
    }
    let outcome = account.outcome();
    assert_eq!(outcome.reason, Some(Reason::Stopped { peer: 2, fault: Fault::Overspeed, time_s: 2.0 }));
}

/// e^t grows e-fold in each eighth of 8 s; t at most threefold over the last four of them.
#[test]
fn what_grows_without_bound_is_no_run() {
    let force = |time: f64| 1e-3 * time.exp() * (300.0 * time).sin();
    let oscillating = outcome(|time| armed(at(0.0, 0.0, force(time))));
    assert_eq!(oscillating.reason, Some(Reason::ForceGrew));
    assert!(!oscillating.bounded && oscillating.metric(|o| o.whole.contact_force_n).is_none());
    let faster = outcome(|time| armed(at(0.0, 1e-3 * time.exp(), 0.0)));
    assert_eq!(faster.reason, Some(Reason::EnergyGrew));
    // As large in the end, but not by growing on and on: a network that draws a bad burst late.
    let bursts = [1.0, 0.5, 0.1, 0.1, 0.4, 0.44, 0.9, 0.95];
    let unlucky = outcome(move |time| armed(at(0.0, bursts[time as usize], 0.0)));
    assert_eq!(unlucky.reason, None);
    let pushed = outcome(|time| armed(at(0.0, 0.1 * time, 0.0)));
    assert_eq!(pushed.reason, None);
    let no_number = outcome(|time| armed(at(0.0, if time < 1.0 { 0.0 } else { f64::NAN }, 0.0)));
    assert_eq!(no_number.reason, Some(Reason::EnergyGrew));
}

/// Issue 51: a run that swung at 32 N rms for seconds after the last push was called stable.
#[test]
fn a_swing_that_goes_on_is_named() {
    let wave = |time: f64| (std::f64::consts::TAU * 12.0 * time).sin();
    let swings = outcome(|time| armed(at(0.0, 0.0, 2.0 + 45.0 * wave(time))));
    let Some(Reason::Swings(Swings { hz, rms_n })) = swings.reason else { panic!("{:?}", swings.reason) };
    close(hz, 12.0, 1e-3);
    close(rms_n, 45.0 / 2.0_f64.sqrt(), 1e-9);
    assert_eq!((swings.verdict(), swings.bounded), (Verdict::Unstable, true));
    assert_eq!(
        swings.reason.expect("a reason").to_string(),
        "the coordination force goes on swinging at 12.0 Hz by 31.8 N rms"
    );
    // It dies away; it begins late; it is less than the hands push with.
    let dies = outcome(|time| armed(at(0.0, 0.0, 45.0 * (-0.1 * time).exp() * wave(time))));
    let late = outcome(|time| armed(at(0.0, 0.0, if time < 5.0 { 0.0 } else { 45.0 * wave(time) })));
    let pushed = outcome(|time| armed(at(0.0, 0.0, 0.6 * wave(time))));
    assert_eq!([dies.reason, late.reason, pushed.reason], [None; 3]);
}

#[test]
fn who_had_let_go_in_the_end_did_not_hold_an_object() {
    let let_go = |from: f64, to: f64| {
        outcome(move |time| peer_tick(at(0.0, 0.0, 0.0), Mode::Armed, time < from || time >= to)).reason
    };
    assert_eq!(let_go(7.0, 8.0), Some(Reason::LetGo { peer: 2 }));
    assert_eq!(let_go(5.0, 7.0), None);
    // Nothing is reported of copies that are close by chance; of those that are not, that they came apart.
    let close_by = outcome(|time| peer_tick(at(0.0, 0.0, 0.0), Mode::Armed, time < 7.0));
    assert_eq!((close_by.verdict(), close_by.metric(|o| o.whole.true_discrepancy_mm)), (Verdict::Unstable, None));
    let gone = outcome(|time| peer_tick(at(0.5, 0.0, 0.0), Mode::Armed, time < 7.0));
    assert_eq!(gone.verdict(), Verdict::Apart);
}

/// Of copies that came apart that is said, and every figure with it.
#[test]
fn copies_that_come_apart_are_no_object() {
    let standing = |mm: f64| outcome(move |_| armed(at(1e-3 * mm, 0.0, 1.0)));
    assert_eq!(standing(APART_MM - 0.01).verdict(), Verdict::Stable);
    let apart = standing(2400.0);
    assert_eq!((apart.verdict().name(), apart.is_stable(), apart.bounded), ("apart", false, true));
    assert_eq!(apart.reason.expect("a reason").to_string(), "the copies are 2.40 m apart");
    assert_eq!(standing(12.3).reason.expect("a reason").to_string(), "the copies are 12.3 mm apart");
    close(apart.metric(|o| o.whole.true_discrepancy_mm).expect("how far"), 2400.0, 1e-9);
    close(apart.metric(|o| o.whole.coordination_force_n.mean).expect("what holds them"), 1.0, 1e-12);
    // Not yet on average, but in the end.
    let leaving = outcome(|time| armed(at(1e-3 * (time - 5.0).max(0.0) * 6.0, 0.0, 1.0)));
    assert!(leaving.whole.true_discrepancy_mm < APART_MM);
    assert_eq!(leaving.verdict(), Verdict::Apart);
    // What the analyser knows counts for more, and a fault more than that.
    let doubt = Some(Reason::Unstable { spectral_radius: 1.01 });
    assert_eq!(leaving.doubted(doubt).reason, doubt);
    let stopped = outcome(|_| peer_tick(at(0.0, 0.0, 0.0), Mode::Faulted(Fault::Diverged), false));
    assert!(matches!(stopped.doubted(doubt).reason, Some(Reason::Stopped { .. })));
}

/// How far apart is too far is what springs and line leave at rest, and not a length: F·(2/K_T + T/b) (docs/reference/theory.md, section 4).
#[test]
fn soft_springs_are_not_copies_that_came_apart() {
    let verdict = |scene: &Scene, mm: f64, force: &dyn Fn(f64) -> f64| {
        outcome_in(scene, |time| armed(at(1e-3 * mm, 0.0, force(time)))).verdict()
    };
    let soft = scene(&["coordination.comm=power", "coordination.stiffness_n_per_m=80"]);
    // 2/80 N/m is 25 mm a newton, and 37.5 mm half as much again.
    assert_eq!(verdict(&soft, 37.4, &|_| 1.0), Verdict::Stable);
    assert_eq!(verdict(&soft, 37.6, &|_| 1.0), Verdict::Apart);
    assert_eq!(verdict(&soft, 74.9, &|_| -2.0), Verdict::Stable);
    // A swing has no mean force, and two copies that nothing holds have none: ten millimetres are too far.
    assert_eq!(verdict(&soft, 12.0, &|time| 0.6 * (40.0 * time).sin()), Verdict::Apart);
    assert_eq!(verdict(&soft, 12.0, &|_| 0.0), Verdict::Apart);
    // At one instant a swing may be twice as far, and no farther.
    let leaving = |mm: f64| {
        outcome_in(&soft, move |time| armed(at(if time > 7.9 { 1e-3 * mm } else { 0.0 }, 0.0, 1.0))).verdict()
    };
    assert_eq!((leaving(74.9), leaving(75.1)), (Verdict::Stable, Verdict::Apart));
    // A line of waves of 808 ms, b = 10: 80.8 mm a newton, and springs of 0.2.
    let long = scene(&["network.one_way_delay_packets=100"]);
    assert_eq!(verdict(&long, 121.0, &|_| 1.0), Verdict::Stable);
    assert_eq!(verdict(&long, 122.0, &|_| 1.0), Verdict::Apart);
}

/// Two users press copies together, for a minute over three kinds of line: statics are what they come to rest at, to a percent, or more. Springs of 80 N/m are
/// 12.5 mm a newton each, of which positions sent at once need one; a line of 32 ms and a packet, b = 10 N·s/m, is 3.2 to 4 mm, and a tick in store 0.1 mm more.
#[test]
fn a_run_rests_where_statics_say() {
    let midpoint = &["object.integrator=midpoint", "coordination.decode=implicit", "object.force_delay_ticks=0"][..];
    for (comm, solved, expected_mm) in [
        ("power", &[][..], 12.49..=12.51),
        ("passive-wave", &[][..], 28.2..=29.0),
        ("self-timed", midpoint, 28.2..=29.3),
    ] {
        let comm = format!("coordination.comm={comm}");
        let pressed = ["user.1.push_n=1", "user.2.push_n=1", "network.one_way_delay_packets=4"];
        let scene = scene(&[&pressed[..], solved, &["coordination.stiffness_n_per_m=80", &comm]].concat());
        let outcome = run::<f64>(&scene, Options { duration_s: 60.0, record_every: 0 }, &|_| {}).expect("a good scene");
        let (found_mm, force_n) = (outcome.whole.true_discrepancy_mm, outcome.whole.coordination_force_n.mean.abs());
        let statics_mm = 1e3 * compliance_m_per_n(&scene) * force_n;
        assert_eq!(outcome.verdict(), Verdict::Stable, "{comm}: {found_mm} mm, {:?}", outcome.reason);
        assert!(
            (0.99 * found_mm..=2.01 * found_mm).contains(&statics_mm),
            "{comm}: {found_mm} mm, statics {statics_mm} mm"
        );
        assert!(
            (0.999..=1.001).contains(&force_n) && expected_mm.contains(&found_mm),
            "{comm}: {found_mm} mm, {force_n} N"
        );
    }
}

/// A constant force on a copy that moves to and fro does F·v·t, either way; a spring holds ½·K·s².
#[test]
fn energy_at_the_object_is_force_times_way() {
    let scene = scene(&["coordination.stiffness_n_per_m=1000"]);
    let mut account = Accounts::<1>::new(&scene, TICKS, OPTIONS);
    for tick in 0..TICKS {
        let velocity = if tick < 6000 { 0.5 } else { -0.25 };
        let mut seen = at(0.0, velocity, 2.0);
        seen.desired.position = 3e-3;
        account.ticked(0, [Ticked::new(&seen, [1.0, 2.0], Mode::Armed, true)]);
        account.ticked(1, [armed(at(0.0, 0.0, 0.0))]);
        account.period();
    }
    let outcome = account.outcome();
    let [energy, still] = outcome.whole.energy;
    // The tick in which it turns moves at the mean of both.
    close(energy.to_object_j, 2.0 * (0.5 * 5.999 + 0.125e-3), 1e-9);
    close(energy.from_object_j, 2.0 * 0.25 * 1.999, 1e-9);
    close(energy.stored_j, 0.5 * 1000.0 * 9e-6, 1e-12);
    assert_eq!((still.to_object_j, still.from_object_j, still.stored_j), (0.0, 0.0, 0.0));
    // The most when it turned: what came out until then, beyond what had come from the network.
    close(energy.made_j, 2.0 - 1.0 + energy.to_object_j, 1e-12);
    assert_eq!(outcome.peer_energy_made_mj(), Some(1e3 * energy.made_j));
    // Of the channel: peer 1 took 1 J and nobody gave any.
    assert_eq!(outcome.energy_made_mj(), 1e3);
}

/// Nothing escapes the books: what coordination and contact do to a copy without damping is its kinetic energy, to rounding, whoever
/// integrates it.
#[test]
fn work_on_a_copy_is_its_kinetic_energy() {
    for integrator in ["forward-euler", "semi-implicit", "exact", "midpoint", "backward-euler"] {
        let scene = scene(&[
            &format!("object.integrator={integrator}"),
            "object.force_delay_ticks=0",
            "object.damping_n_s_per_m=0",
            "coordination.decode=implicit",
            "coordination.stiffness_n_per_m=300",
            "contact.stiffness_n_per_m=200",
            "user.1.pulse_n=1",
            "user.2.sine_n=0.5",
        ]);
        let outcome = run::<f64>(&scene, Options { record_every: 1, ..OPTIONS }, &|_| {}).expect("a good scene");
        assert_eq!(outcome.fault, None);
        let column = |name: &str| outcome.axes[0].table.column(name).expect("a column");
        for peer in [1, 2] {
            let [velocity, contact] = [format!("object_{peer}_m_per_s"), format!("contact_{peer}_n")];
            let (velocity, contact) = (column(&velocity), column(&contact));
            let pushed: f64 = velocity.windows(2).zip(contact).map(|(v, f)| 1e-3 * f * 0.5 * (v[0] + v[1])).sum();
            let last = velocity.last().expect("a tick");
            let energy = outcome.whole.energy[peer - 1];
            let kinetic = 0.5 * scene.peer.object.mass_kg * last * last;
            assert!(energy.to_object_j > 1e-3, "{energy:?}");
            close(energy.to_object_j - energy.from_object_j + pushed, kinetic, 1e-9);
        }
    }
}

/// A wave line whose decode is explicit and whose copy is moved by forward Euler makes energy at every tick: its peers are caught, and
/// a passive pair is not.
#[test]
fn a_peer_that_makes_energy_is_caught() {
    let made_mj = |overrides: &[&str]| {
        let both = [&["user.1.pulse_n=1", "coordination.comm=wave"], overrides].concat();
        let outcome = run::<f64>(&scene(&both), OPTIONS, &|_| {}).expect("a good scene");
        outcome.peer_energy_made_mj().expect("continuous contact")
    };
    let staged = made_mj(&["coordination.stiffness_n_per_m=20000", "object.force_delay_ticks=0"]);
    assert!(staged > 1.0, "{staged} mJ");
    let soft = [
        "coordination.decode=implicit",
        "object.integrator=semi-implicit",
        "object.force_delay_ticks=0",
        "coordination.stiffness_n_per_m=300",
    ];
    let implicit = made_mj(&soft);
    assert!(implicit < 1e-6, "{implicit} mJ");
}

/// 40 ms of delay and nobody at the copies but for a touch at the start: the staged peers feed a limit cycle over a line that is passive,
/// the midpoint peers make nothing.
#[test]
fn a_limit_cycle_is_told_whoever_feeds_it() {
    let let_go = |integrator: &str| {
        let scene = scene(&[
            &format!("object.integrator={integrator}"),
            "object.force_delay_ticks=0",
            "coordination.comm=passive-mean",
            "coordination.stiffness_n_per_m=4000",
            "coordination.decode=implicit",
            "coordination.ledger=true",
            "coordination.drift_correction=true",
            "network.one_way_delay_packets=5",
            "contact.one_sided=true",
            "contact.gap_m=0.005",
            "user.1.pulse_n=1",
            "user.1.pulse_every_s=100000",
            "user.1.push_n=-0.01",
            "user.2.push_n=-0.01",
        ]);
        run::<f64>(&scene, Options { duration_s: 400.0, record_every: 0 }, &|_| {}).expect("a good scene")
    };
    let staged = let_go("semi-implicit");
    assert!(matches!(staged.reason, Some(Reason::Swings(_))), "{:?}", staged.reason);
    let (line, peer) = (staged.energy_made_mj(), staged.peer_energy_made_mj().expect("booked"));
    assert!(line <= 1e-6 && peer > 1.0, "{line}, {peer} mJ");
    let midpoint = let_go("midpoint");
    assert!(midpoint.is_stable(), "{:?}", midpoint.reason);
    let peer = midpoint.peer_energy_made_mj().expect("booked");
    assert!(peer <= 1e-6, "{peer} mJ");
}

/// Nothing is said where the velocity of the copy jumps between two ticks.
#[test]
fn impacts_are_not_booked() {
    let outcome = run::<f64>(&scene(&["contact.rendering=impulsive", "contact.one_sided=true"]), OPTIONS, &|_| {})
        .expect("a good scene");
    assert_eq!(outcome.peer_energy_made_mj(), None);
}

/// A limit of speed far below what the users do: the run stops, and nothing of it is a figure of merit.
#[test]
fn a_run_that_is_broken_on_purpose_says_why() {
    let broken = scene(&["safety.max_speed_m_per_s=0.01", "user.1.push_n=1", "user.2.push_n=1"]);
    let outcome = run::<f64>(&broken, OPTIONS, &|_| {}).expect("a good scene");
    let reason = outcome.reason.expect("a reason").to_string();
    assert!(reason.contains(": Overspeed: "), "{reason}");
    assert_eq!(outcome.metric(|o| o.whole.true_discrepancy_mm), None);
    // Half of everything lost a second at a time: what is left of the object is two of them, or none.
    let torn = scene(&[
        "network.loss=0.5",
        "network.loss_burst_packets=125",
        "coordination.comm=wave",
        "user.1.push_n=1",
        "user.2.push_n=1",
    ]);
    let outcome = run::<f64>(&torn, OPTIONS, &|_| {}).expect("a good scene");
    assert!(!outcome.is_stable() && outcome.metric(|o| o.whole.true_discrepancy_mm).is_none(), "{:?}", outcome.reason);
}

#[test]
fn a_number_may_begin_or_end_with_its_point() {
    for (text, mass_kg) in [("object.mass_kg=.25", 0.25), ("object.mass_kg=2.", 2.0), ("object.mass_kg=+.5", 0.5)] {
        assert_eq!(scene(&[text]).peer.object.mass_kg, mass_kg, "{text}");
    }
}

/// A packet that is older than `safety.max_delay_s` is not used, as on a live link; the limit itself is no delay beyond it.
#[test]
fn what_is_too_old_is_not_used() {
    let reason = |ms: u32, most_s: &str| {
        let pushed = [
            "user.1.pulse_n=0.1",
            "user.1.pulse_every_s=100000",
            "timing.ticks_per_packet=1",
            "coordination.comm=passive-mean",
        ];
        let network = [format!("network.one_way_delay_packets={ms}"), format!("safety.max_delay_s={most_s}")];
        let scene = scene(&[&pushed[..], &network.each_ref().map(String::as_str)].concat());
        let outcome = run::<f64>(&scene, Options { duration_s: 15.0, record_every: 0 }, &|_| {}).expect("a good scene");
        (outcome.reason, outcome.whole.energy[0].received_j > 0.0)
    };
    assert_eq!(reason(251, "0.25"), (Some(Reason::LetGo { peer: 1 }), false));
    assert!(reason(250, "0.25").1 && reason(251, "0.3").1);
}
