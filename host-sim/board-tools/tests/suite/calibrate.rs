//! Calibration against devices whose numbers are known: the whole procedure on a simulated board, the fit against closed
//! forms with noise, and what is refused instead of guessed.

use cohold_board_tools::Error;
use cohold_board_tools::calibrate::board::{Board, Joint, Run, Tick};
use cohold_board_tools::calibrate::simulated::SharedSimulation;
use cohold_board_tools::calibrate::{Found, Person, Task, motion, settings_file};
use cohold_board_tools::{calibrate::counts, calibrate::counts::Distance};
use cohold_board_tools::{calibrate::motor, calibrate::motor::Against};
use cohold_core::device::probe::End;
use cohold_core::settings::Value;
use cohold_sim::scene::Scene;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

fn scene(overrides: &str) -> Scene {
    let overrides: Vec<String> = overrides.split_whitespace().map(str::to_owned).collect();
    Scene::load(cohold_sim::Laws::built_in(), None, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

fn number(found: &[Found], key: &str) -> f64 {
    let found = found.iter().find(|found| found.key == key).unwrap_or_else(|| panic!("{key} was not found"));
    found.value.as_float().unwrap_or_else(|| panic!("{key} is no number"))
}

fn flag(found: &[Found], key: &str) -> bool {
    found.iter().find(|found| found.key == key).and_then(|found| found.value.as_bool()).expect("a flag")
}

/// Gives the board what was found, as the command line does.
fn give(board: &mut SharedSimulation, found: &[Found], name: &str) {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("calibrated-{name}.toml"));
    let _ = std::fs::remove_file(&path);
    settings_file::add(&path, found).expect("a settings file");
    settings_file::give(board, &path).expect("the board takes it");
    Scene::load(cohold_sim::Laws::built_in(), Some(&path), &[]).expect("the simulator takes it");
}

#[track_caller]
fn near(name: &str, got: f64, truth: f64, relative: f64) {
    assert!((got - truth).abs() <= relative * truth.abs(), "{name}: {got}, should be {truth}");
}

/// From a new board to a calibrated one, whichever signs are wrong, on a slide and on a capstan.
#[test]
fn a_new_board_finds_out_everything_about_its_device() {
    let devices = [
        ("slide", "plant.coulomb_n=0.25 encoder.counts_per_m=157000 motor.newton_or_newton_metre_per_a=6.3", 1.0),
        ("heavy", "device.mass_kg=0.6 plant.coulomb_n=0.5 device.damping_n_s_per_m=3 encoder.counts_per_m=80000", 1.0),
        (
            "capstan",
            "kinematics.model=capstan encoder.counts_per_rev=4000 motor.newton_or_newton_metre_per_a=0.05 \
             kinematics.capstan_ratio=12 kinematics.paddle_radius_m=0.07 plant.coulomb_n=0.1 device.damping_n_s_per_m=0.4",
            0.07 / 12.0,
        ),
    ];
    for (name, device, lever) in devices {
        for (motor_reversed, encoder_reversed) in [(false, false), (true, false), (false, true), (true, true)] {
            let truth = scene(&format!(
                "device.mass_kg=0.17 device.force_delay_ticks=0.7 {device} plant.pwm_steps=3000 \
                 motor.reversed={motor_reversed} encoder.reversed={encoder_reversed}"
            ));
            let (peer, world) = (&truth.peer, &truth.world.device);
            let name = format!("{name}-{motor_reversed}-{encoder_reversed}");
            let mut board = SharedSimulation::new(&truth).expect("a board");
            let mut person = board.clone();
            let (key, distance, counts) = if lever == 1.0 {
                ("encoder.counts_per_m", Distance::Metres(0.1), peer.encoder.counts_per_m)
            } else {
                ("encoder.counts_per_rev", Distance::Revolutions(2.0), peer.encoder.counts_per_rev)
            };
            let found = counts::calibrate(&mut board, &mut person, 1, distance).expect("counts");
            near(&name, number(&found, key), counts, 5e-4);
            assert_eq!(flag(&found, "encoder.reversed"), encoder_reversed, "{name}");
            give(&mut board, &found, &name);

            // Heavy ones need more than the weakest push.
            for line in ["set probe.check_duty 0.08", "apply"] {
                assert!(board.ask(line).expect("an answer").starts_with("ok"));
            }
            let found = motor::sign(&mut board, 1).expect("sign");
            assert_eq!(flag(&found, "motor.reversed"), motor_reversed, "{name}");
            give(&mut board, &found, &name);

            let found = motor::constant(&mut board, &mut person, 1, Against::Mass(0.2)).expect("motor");
            let constant = number(&found, "motor.newton_or_newton_metre_per_a");
            near(&name, constant, peer.motor.newton_or_newton_metre_per_a, 0.02);
            give(&mut board, &found, &name);

            // The mass is still there: it is one device now.
            let found = motion::inertia(&mut board, 1).expect("inertia");
            near(&name, number(&found, "device.mass_kg"), world.mass_kg + 0.2, 0.02);
            let delay = number(&found, "device.force_delay_ticks");
            assert!((delay - 0.7).abs() < 0.15, "{name}: {delay} ticks");

            let found = motion::friction(&mut board, 1).expect("friction");
            near(&name, number(&found, "device.damping_n_s_per_m"), world.damping_n_s_per_m, 0.15);
            near(&name, number(&found, "plant.coulomb_n"), truth.world.plant.coulomb_n, 0.1);
        }
    }
}

#[test]
fn a_gauge_gives_the_motor_constant() {
    let truth = scene("motor.newton_or_newton_metre_per_a=5.5 plant.coulomb_n=0.3");
    let mut board = SharedSimulation::new(&truth).expect("a board");
    let mut person = board.clone();
    let found = motor::constant(&mut board, &mut person, 1, Against::Gauge).expect("a constant");
    near("gauge", number(&found, "motor.newton_or_newton_metre_per_a"), 5.5, 0.001);
}

/// m·v̇ + b·v = F, exactly, for a force that stands from tick to tick and comes late by a fraction of one.
fn closed_form(
    mass: f64,
    damping: f64,
    late_ticks: f64,
    hertz: f64,
    counts_per_m: f64,
    noise: &mut dyn FnMut() -> f64,
) -> Run {
    let (period, mut x, mut v, mut before) = (1e-3, 0.0, 0.0, 0.0);
    let mut run = Run { end: End::Done, ..Run::default() };
    for n in 0..2000 {
        let duty = 0.1 * (std::f64::consts::TAU * hertz * f64::from(n) * period).cos();
        run.counts.push((x * counts_per_m + noise()).floor());
        run.duties.push(duty);
        for (force, time) in [(before, late_ticks * period), (duty, (1.0 - late_ticks) * period)] {
            let (end, decay) = (force / damping, (-damping * time / mass).exp());
            x += end * time + (v - end) * (1.0 - decay) * mass / damping;
            v = end + (v - end) * decay;
        }
        before = duty;
    }
    run
}

/// Uniform between ± `counts`.
fn noise(random: &mut Xoshiro256PlusPlus, counts: f64) -> f64 {
    ((random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0) * counts
}

/// Mass, damping and delay of a linear device, from counts with 5 counts of noise: right on average, and the interval holds
/// the truth about as often as it says.
#[test]
fn the_fit_finds_what_a_closed_form_was_made_with() {
    let (mass, damping, late) = (0.004, 0.03, 0.6);
    let counts_per_m = 100_000.0;
    let joint = Joint { number: 1, m_per_count: 1.0 / counts_per_m, lever: 1.0, period_s: 1e-3 };
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let (mut held, mut sum) = ([0; 3], [0.0; 3]);
    const TIMES: u32 = 100;
    for _ in 0..TIMES {
        let runs: Vec<Run> = [4.0, 9.0, 18.0]
            .iter()
            .map(|hertz| closed_form(mass, damping, late, *hertz, counts_per_m, &mut || noise(&mut random, 5.0)))
            .collect();
        let motion = motion::fit(&runs, &joint).expect("a fit");
        let all = [(motion.mass, mass), (motion.damping, damping), (motion.delay_s, 1e-3 * late)];
        for (at, (estimate, truth)) in all.into_iter().enumerate() {
            held[at] += u32::from((estimate.value - truth).abs() <= estimate.within);
            sum[at] += estimate.value / truth / f64::from(TIMES);
        }
        assert!(motion.dry.value.abs() < 0.002, "{:?} of dry friction", motion.dry);
    }
    println!("held {held:?} of {TIMES}, mean {sum:?} of the truth");
    assert!(held.iter().all(|held| (85..=100).contains(held)), "{held:?} of {TIMES} intervals hold the truth");
    for (mean, tolerance) in sum.into_iter().zip([0.001, 0.02, 0.05]) {
        near("mean", mean, 1.0, tolerance);
    }
}

/// Does nothing that it is asked.
struct Idle;

impl Person for Idle {
    fn please(&mut self, _: &Task) -> Result<(), Error> {
        Ok(())
    }
    fn reading(&mut self, _: &str) -> Result<f64, Error> {
        Ok(1.0)
    }
}

/// One line that says this is what came of it.
#[track_caller]
pub(crate) fn refused<T: std::fmt::Debug>(outcome: Result<T, Error>, said: &str) {
    let error = outcome.expect_err(said).to_string();
    assert!(error.contains(said), "{error:?} does not say {said:?}");
    assert_eq!(error.lines().count(), 1);
}

#[test]
fn what_the_data_do_not_give_is_refused() {
    let new = |overrides: &str| SharedSimulation::new(&scene(overrides)).expect("a board");
    refused(counts::calibrate(&mut new(""), &mut Idle, 1, Distance::Metres(0.1)), "the encoder counted 0: too few");
    refused(counts::calibrate(&mut new(""), &mut Idle, 2, Distance::Metres(0.1)), "joint 2 is not allowed");
    refused(counts::calibrate(&mut new(""), &mut Idle, 1, Distance::Metres(-0.1)), "a distance of -0.1");
    refused(counts::calibrate(&mut new(""), &mut Idle, 1, Distance::Revolutions(1.0)), "by what distance");
    // Held, or stuck: friction beyond what any probe can do.
    let held = "plant.coulomb_n=50";
    refused(motor::sign(&mut new(held), 1), "did not move: let go of it");
    refused(motion::friction(&mut new(held), 1), "too little");
    refused(motion::inertia(&mut new(held), 1), "too little");
    refused(motor::constant(&mut new(held), &mut Idle, 1, Against::Mass(0.2)), "too little");
    // Pushed by a hand all the time.
    refused(motor::sign(&mut new("user.1.push_n=5"), 1), "let go of it");
    // The wrong sign is no mass below zero.
    refused(motion::inertia(&mut new("motor.reversed=true"), 1), "`calibrate sign` first");
    // Readings of somebody who looks elsewhere, and a device that is not at the gauge.
    refused(motor::constant(&mut new("plant.coulomb_n=50"), &mut Idle, 1, Against::Gauge), "lie on no line");
    refused(motor::constant(&mut new(""), &mut Idle, 1, Against::Gauge), "the joint gave way");
    refused(motor::constant(&mut new(""), &mut Idle, 1, Against::Mass(0.2)), "the added mass shows as");
    refused(motion::inertia(&mut new("axis.count=2 kinematics.model=five-bar"), 1), "five-bar");
}

/// A board whose telemetry loses every hundredth tick.
struct Lossy(SharedSimulation);

impl Board for Lossy {
    fn ask(&mut self, line: &str) -> Result<String, Error> {
        self.0.ask(line)
    }
    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error> {
        Ok(self.0.ticks(seconds)?.into_iter().filter(|tick| tick.number % 100 != 0).collect())
    }
}

#[test]
fn ticks_that_get_lost_are_noticed() {
    let mut board = Lossy(SharedSimulation::new(&scene("")).expect("a board"));
    refused(motion::inertia(&mut board, 1), "got lost on the way");
    let mut person = board.0.clone();
    refused(counts::calibrate(&mut board, &mut person, 1, Distance::Metres(0.1)), "got lost on the way");
}

/// What is found goes beside what the file holds, and comes back as it was.
#[test]
fn the_settings_file_grows() {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("grows.toml");
    std::fs::write(&path, "[object]\nmass_kg = 0.25\n[encoder]\ncounts_per_m = 1000.0\n").expect("a file");
    let estimate = cohold_board_tools::calibrate::Estimate { value: 123_456.0, within: 10.0 };
    settings_file::add(
        &path,
        &[Found::number("encoder.counts_per_m", estimate, ""), Found::flag("motor.reversed", true)],
    )
    .expect("it takes them");
    let scene = Scene::load(cohold_sim::Laws::built_in(), Some(&path), &[]).expect("a scene");
    assert_eq!(scene.get("object.mass_kg"), Some(Value::Number(0.25)));
    assert_eq!(scene.get("encoder.counts_per_m"), Some(Value::Number(123_456.0)));
    assert_eq!(scene.get("motor.reversed"), Some(Value::Flag(true)));
    let mut board = SharedSimulation::new(&Scene::default()).expect("a board");
    assert_eq!(settings_file::give(&mut board, &path).expect("it takes them"), 3);
    assert_eq!(board.settings().get("encoder.counts_per_m"), Some(Value::Number(123_456.0)));
    // What is outside a key's range never reaches the file.
    let far = cohold_board_tools::calibrate::Estimate { value: 1e12, within: 1.0 };
    let before = std::fs::read_to_string(&path).expect("a file");
    refused(settings_file::add(&path, &[Found::number("encoder.counts_per_m", far, "")]), "encoder.counts_per_m");
    assert_eq!(std::fs::read_to_string(&path).expect("a file"), before);
}

/// A board that knows its device as the truth has it, but for the cogging.
fn told(truth: &Scene) -> SharedSimulation {
    let mut board = SharedSimulation::new(truth).expect("a board");
    for table in ["encoder.", "motor."] {
        for key in cohold_core::settings::Settings::keys().filter(|key| key.name.starts_with(table)) {
            let value = truth.peer.get(key.name).expect("a value").to_string();
            let answer = board.ask(&format!("set {} {}", key.name, value.trim_matches('"'))).expect("an answer");
            assert!(answer.starts_with("ok"), "{answer}");
        }
    }
    assert_eq!(board.ask("apply").expect("an answer"), "ok applied");
    board
}

/// The plant's own numbers, of a slide and of a capstan, whichever signs are wrong; of the wrong periods none is taken.
#[test]
fn cogging_is_found_where_it_is() {
    const SLIDE: &str = "plant.coulomb_n=0.2 plant.cogging_n_or_n_m=0.3 motor.cogging_period_m_or_rad=0.004 \
                         plant.cogging_at_m_or_rad=0.0009 encoder.index_at_m_or_rad=0.003";
    const CAPSTAN: &str = "plant.coulomb_n=0.1 plant.cogging_n_or_n_m=0.002 kinematics.model=capstan \
                           motor.cogging_period_m_or_rad=0.5235987755982988 plant.cogging_at_m_or_rad=-0.2 \
                           encoder.index_at_m_or_rad=0.3 encoder.counts_per_rev=4000 kinematics.paddle_radius_m=0.07 \
                           motor.newton_or_newton_metre_per_a=0.05";
    for device in [SLIDE, CAPSTAN] {
        for reversed in [[false, false], [true, false], [false, true], [true, true]] {
            let [motor, encoder] = reversed;
            let truth = scene(&format!(
                "device.mass_kg=0.17 encoder.index=true motor.reversed={motor} encoder.reversed={encoder} {device}"
            ));
            let plant = &truth.world.plant;
            let period = truth.peer.motor.cogging_period_m_or_rad;
            let mut board = told(&truth);
            let mut person = board.clone();
            let found = motion::cogging(&mut board, &mut person, 1).expect("cogging");
            for found in &found {
                println!("{reversed:?} {} {}", found.key, found.said);
            }
            let of = |key: &str| number(&found, key);
            near("amplitude", of("plant.cogging_n_or_n_m"), plant.cogging_n_or_n_m, 0.05);
            let off = (of("motor.cogging_at_m_or_rad") - plant.cogging_at_m_or_rad) / period;
            let degrees = 360.0 * (off - off.round());
            assert!(degrees.abs() < 5.0, "{degrees}° of phase");
            give(&mut board, &found, "cogging");
        }
    }
}

/// None is found where there is none, and nothing without an index.
#[test]
fn no_cogging_is_found_where_there_is_none() {
    let truth = scene("encoder.index=true encoder.index_at_m_or_rad=0.003 plant.coulomb_n=0.2");
    let mut board = told(&truth);
    let mut person = board.clone();
    // Its zero is not that of the index.
    person.please(&Task::MoveMetres { joint: 1, metres: 0.0013 }).expect("it moves");
    let found = motion::cogging(&mut board, &mut person, 1).expect("none");
    println!("{}", found[0].said);
    assert_eq!((found.len(), number(&found, "plant.cogging_n_or_n_m")), (1, 0.0), "{}", found[0].said);
    refused(motion::cogging(&mut board, &mut Idle, 1), "the index was not met");
    refused(motion::cogging(&mut told(&scene("")), &mut Idle, 1), "encoder.index = false");
}
