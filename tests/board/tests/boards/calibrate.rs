//! A person calibrates a board: host-sim's procedures against the release image, closed around a device whose numbers they are
//! not told.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use board_bench::bench::{Bench, PWM_STEPS};
use board_bench::image::Firmware;
use board_bench::wire::Line;
use haptic_sim::board::calibrate::board::{Board, Tick};
use haptic_sim::board::calibrate::counts::{self, Distance};
use haptic_sim::board::calibrate::motor;
use haptic_sim::board::calibrate::{Found, Person, Task, motion, settings_file};
use haptic_sim::scene::Scene;

/// The bench with one board, as its operator and the person at its device share it.
#[derive(Clone)]
struct Table {
    bench: Rc<RefCell<Bench>>,
    truth: Scene,
    taken: Rc<RefCell<usize>>,
}

impl Board for Table {
    fn ask(&mut self, line: &str) -> Result<String, String> {
        Ok(self.bench.borrow_mut().ask(1, line))
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, String> {
        let mut bench = self.bench.borrow_mut();
        bench.run_for_ms((1e3 * seconds).round() as u64);
        let mut taken = self.taken.borrow_mut();
        let new = bench.pc.records[0][*taken..].iter();
        let ticks = new.filter_map(|record| Tick::from_record(&record.bytes())).collect();
        *taken = bench.pc.records[0].len();
        Ok(ticks)
    }
}

impl Person for Table {
    fn please(&mut self, task: &Task) -> Result<(), String> {
        let mut bench = self.bench.borrow_mut();
        match *task {
            Task::MoveMetres { metres, .. } => bench.carry(1, metres, 500),
            Task::Fasten { kilograms, .. } => {
                let mut heavier = self.truth.clone();
                heavier.world.device.mass_kg += kilograms;
                bench.let_go(Some(&heavier));
            }
            _ => bench.run_for_ms(100),
        }
        Ok(())
    }

    fn reading(&mut self, what: &str) -> Result<f64, String> {
        Err(format!("there is no gauge on the bench to read {what}"))
    }
}

fn number(found: &[Found], key: &str) -> f64 {
    let found = found.iter().find(|found| found.key == key);
    found.and_then(|found| found.value.as_float()).unwrap_or_else(|| panic!("{key} was not found"))
}

#[track_caller]
fn near(key: &str, found: &[Found], truth: f64, relative: f64) {
    let got = number(found, key);
    assert!((got - truth).abs() <= relative * truth, "{key}: {got}, should be {truth}");
}

#[test]
fn a_person_calibrates_a_board_whose_signs_are_wrong() {
    let mut truth = Scene::default();
    for text in [
        "plant.encoder=true",
        "plant.motor=true",
        "axis.velocity=filtered",
        "device.mass_kg=0.15",
        "device.damping_n_s_per_m=0.8",
        "plant.coulomb_n=0.2",
        "encoder.counts_per_m=170000",
        "encoder.reversed=true",
        "motor.newton_or_newton_metre_per_a=6.5",
    ] {
        truth.apply_override(text).expect("a good override");
    }
    truth.world.plant.pwm_steps = PWM_STEPS;
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.let_go(Some(&truth));
    // What the device is, is said at the board.
    bench.hold_buttons(true);
    let bench = Rc::new(RefCell::new(bench));
    let mut board = Table { bench: bench.clone(), truth: truth.clone(), taken: Rc::default() };
    let mut person = board.clone();
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("calibrated.toml");
    let _ = std::fs::remove_file(&file);
    let keep = |found: &[Found], board: &mut Table| {
        found.iter().for_each(|found| println!("{} = {}", found.key, found.said));
        settings_file::add(&file, found).expect("a settings file");
        settings_file::give(board, &file).expect("the board takes it");
    };

    // As it came, the encoder against the motor: arming is refused, and so is a check.
    assert!(board.ask("arm").expect("an answer").starts_with("error check first: "));
    board.ask("check 1").expect("an answer");
    board.ticks(0.1).expect("it runs");
    let probed = board.ask("probed").expect("an answer");
    assert!(probed.contains("; disagree: "), "{probed}");
    assert!(board.ask("arm").expect("an answer").starts_with("error check first: "));

    let found = counts::calibrate(&mut board, &mut person, 1, Distance::Metres(0.05)).expect("counts");
    near("encoder.counts_per_m", &found, 170_000.0, 1e-3);
    assert_eq!(found[1], Found::flag("encoder.reversed", true));
    keep(&found, &mut board);

    let found = motor::sign(&mut board, 1).expect("sign");
    assert_eq!(found, [Found::flag("motor.reversed", false)]);
    keep(&found, &mut board);

    let found = motor::mass(&mut board, &mut person, 1, 0.2).expect("motor");
    near("motor.newton_or_newton_metre_per_a", &found, 6.5, 0.02);
    keep(&found, &mut board);

    let found = motion::inertia(&mut board, 1).expect("inertia");
    near("device.mass_kg", &found, 0.35, 0.02);
    keep(&found, &mut board);

    let found = motion::friction(&mut board, 1).expect("friction");
    near("device.damping_n_s_per_m", &found, 0.8, 0.15);
    near("plant.coulomb_n", &found, 0.2, 0.1);
    keep(&found, &mut board);

    // Settings of the device have changed since the last check: once more, and then it arms.
    assert!(board.ask("arm").expect("an answer").starts_with("error check first: "));
    assert_eq!(motor::sign(&mut board, 1).expect("sign"), [Found::flag("motor.reversed", false)]);
    assert_eq!(board.ask("arm").expect("an answer"), "ok armed");
    Scene::load(haptic_sim::Laws::built_in(), Some(&file), &[]).expect("the simulator takes the file");
}
