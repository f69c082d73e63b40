//! A person brings a board up: cohold's steps against the release image, closed around a device whose numbers they are not given. What ends
//! it becomes a table in docs/guides/board/calibrate.md; `COHOLD_BLESS=1` writes it, otherwise it must be there.

use std::cell::RefCell;
use std::path::Path;
use std::rc::Rc;
use std::sync::Arc;

use board_bench::bench::{AMPLIFIER_STEPS, Bench, PWM_STEPS};
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::part::Gate;
use board_bench::wire::Line;
use cohold_board_tools::Error;
use cohold_board_tools::bringup::{Plan, VOLTMETER, bring_up};
use cohold_board_tools::calibrate::board::{Board, Tick};
use cohold_board_tools::calibrate::counts::Distance;
use cohold_board_tools::calibrate::motor::Against;
use cohold_board_tools::calibrate::winding::Sheet;
use cohold_board_tools::calibrate::{Person, Task};
use cohold_sim::scene::Scene;

/// The bench with one board, as its operator and the person at its device share it.
#[derive(Clone)]
struct Table {
    bench: Rc<RefCell<Bench>>,
    truth: Scene,
    taken: Rc<RefCell<usize>>,
    /// What the voltmeter shows of the supply.
    shows: f64,
}

impl Board for Table {
    fn ask(&mut self, line: &str) -> Result<String, Error> {
        Ok(self.bench.borrow_mut().ask(1, line))
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error> {
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
    fn please(&mut self, task: &Task) -> Result<(), Error> {
        let mut bench = self.bench.borrow_mut();
        match *task {
            Task::MoveMetres { metres, .. } | Task::Push { metres, .. } => bench.carry(1, metres, 500),
            Task::Fasten { kilograms, .. } => {
                let mut heavier = self.truth.clone();
                heavier.world.device.mass_kg += kilograms;
                bench.let_go(Some(&heavier));
            }
            Task::Unfasten { .. } => bench.let_go(Some(&self.truth)),
            Task::HoldButton | Task::LetGoOfButton => {
                bench.hold_buttons(*task == Task::HoldButton);
                bench.run_for_ms(5);
            }
            Task::PressStop | Task::ReleaseStop => {
                bench.press_stop(1, *task == Task::PressStop);
                bench.run_for_ms(5);
                assert!(!bench.stopped[0].bridges.on(), "off, pressed or released");
            }
            Task::PullCable => bench.input(1).cable = Some(false),
            Task::PlugCable => {
                assert!(!bench.stopped[0].bridges.on(), "off while the operator was silent");
                bench.input(1).cable = Some(true);
                bench.run_for_ms(2500);
                bench.meet(1);
            }
            _ => bench.run_for_ms(100),
        }
        Ok(())
    }

    fn reading(&mut self, what: &str) -> Result<f64, Error> {
        if what == VOLTMETER {
            return Ok(self.shows * self.bench.borrow().supply_v(1));
        }
        Err(format!("there is no gauge on the bench to read {what}").into())
    }
}

/// A device whose numbers a board is not given, as somebody at a table has it; `set` says what it is beside that.
fn table(set: &[&str]) -> Table {
    let mut truth = Scene::default();
    for text in [
        "plant.encoder=true",
        "plant.motor=true",
        "axis.velocity=filtered",
        "device.mass_kg=0.15",
        "device.damping_n_s_per_m=0.8",
        "plant.coulomb_n=0.2",
        "encoder.counts_per_m=170000",
        "motor.newton_or_newton_metre_per_a=6.5",
    ]
    .iter()
    .chain(set)
    {
        truth.apply_override(text).expect("a good override");
    }
    truth.world.plant.pwm_steps = if truth.world.plant.winding { PWM_STEPS } else { AMPLIFIER_STEPS };
    truth.world.plant.current_bits = 16;
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    if !truth.world.plant.winding {
        bench.tell_of_amplifiers(1);
    }
    bench.let_go(Some(&truth));
    Table { bench: Rc::new(RefCell::new(bench)), truth, taken: Rc::default(), shows: 1.0 }
}

/// The motors of a board with a current loop.
const LOOP: [&str; 4] =
    ["plant.winding=true", "plant.drive=current", "motor.resistance_ohm=3", "motor.inductance_h=0.0007"];

/// What a check of joint 1 says, and what `arm` does after it.
fn checked(board: &mut Table) -> (String, String) {
    let begun = board.ask("check 1").expect("an answer");
    assert!(begun.starts_with("ok probing"), "{begun}");
    board.ticks(0.2).expect("it runs");
    let [probed, armed] = ["probed", "arm"].map(|line| board.ask(line).expect("an answer"));
    (probed, armed)
}

/// The data sheet of the device's motor, with these factors.
fn sheet(board: &Table, resistance: f64, inductance: f64) -> Sheet {
    let motor = &board.truth.peer.motor;
    let (resistance_ohm, inductance_h) =
        (Some(resistance * motor.resistance_ohm), Some(inductance * motor.inductance_h));
    Sheet { resistance_ohm, inductance_h, tolerance: 0.3 }
}

/// All steps, or why not, by this data sheet; what was found is in the file.
fn steps(file: &Path, board: &mut Table, sheet: Sheet) -> Result<usize, Error> {
    let _ = std::fs::remove_file(file);
    let (distance, against) = (Distance::Metres(0.05), Against::Mass(0.2));
    let plan = Plan { joint: 1, distance, sheet, against, file };
    let mut person = board.clone();
    let passed = bring_up(board, &mut person, plan, |passed| println!("{}: {}", passed.step, passed.seen))?;
    Ok(passed.len())
}

/// Nothing was driven that was not known: each ends before the first step that a fault would make dangerous.
#[test]
fn what_is_wrong_ends_the_first_hour_before_anything_drives() {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("brought-up-wrong.toml");
    let looped = || table(&LOOP);
    let uncut = |board: Table| {
        board.bench.borrow_mut().bridged[1] = true;
        board
    };
    let ungated = || {
        let board = table(&[]);
        board.bench.borrow_mut().input(1).gate = Some(Gate::EnableAlone);
        board
    };
    type Case<'a> = (&'a str, Table, [f64; 2], &'a str);
    let exchanged = [0.0007 / 3.0, 3.0 / 0.0007];
    let cases: [Case<'_>; 8] = [
        ("the stop's second contact is in no supply", uncut(looped()), [1.0; 2], "emergency stop: "),
        ("the same, with amplifiers", uncut(table(&[])), [1.0; 2], "emergency stop: "),
        ("the divider at PB1 is off by 10 %", Table { shows: 1.1, ..looped() }, [1.0; 2], "supply: "),
        ("data sheet of three times the resistance", looped(), [3.0, 1.0], "winding: "),
        ("of a third of it", looped(), [1.0 / 3.0, 1.0], "winding: "),
        ("of three times the inductance", looped(), [1.0, 3.0], "winding: "),
        ("ohms and henries exchanged", looped(), exchanged, "winding: "),
        ("amplifiers without a gate", ungated(), [1.0; 2], "sign: "),
    ];
    let mut rows = Vec::new();
    for (what, mut board, [resistance, inductance], step) in cases {
        let of = sheet(&board, resistance, inductance);
        let why = steps(&file, &mut board, of).expect_err(what).to_string();
        assert!(why.starts_with(step), "{what}: {why}");
        let bench = board.bench.borrow();
        assert!(bench.stopped[0].bridges.currents().is_none() && !bench.stopped[0].bridges.on(), "{what}: off");
        let told = why.split("; look at ").next().expect("a sentence").trim_start_matches(step);
        // A value that no motor has is refused by its line in the file, whose name depends on where this runs.
        let told = told.split_once(".toml:").and_then(|(_, rest)| rest.split_once(": ")).map_or(told, |(_, told)| told);
        rows.push(format!("| {what} | {} | {told} |", step.trim_end_matches(": ")));
    }
    docs::table("guides/board/calibrate.md", "calibrate", "| what is wrong | ends at | saying |", &rows);
}

/// Every step, and what was found against the truth.
fn brings_up(name: &str, board: &mut Table) -> Scene {
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("brought-up-{name}.toml"));
    let of = sheet(board, 1.0, 1.0);
    assert_eq!(steps(&file, board, of).unwrap_or_else(|why| panic!("{why}")), 12);

    let found = Scene::load(cohold_sim::Laws::built_in(), Some(&file), &[]).expect("the simulator takes the file");
    for (what, found, truth, relative) in [
        ("counts", found.peer.encoder.counts_per_m, 170_000.0, 1e-3),
        ("motor", found.peer.motor.newton_or_newton_metre_per_a, 6.5, 0.02),
        ("mass", found.world.device.mass_kg, 0.15, 0.02),
        ("damping", found.world.device.damping_n_s_per_m, 0.8, 0.15),
        ("friction", found.world.plant.coulomb_n, 0.2, 0.1),
    ] {
        assert!((found - truth).abs() <= relative * truth, "{what}: {found}, should be {truth}");
    }
    // The limit is what it was, and the device has been checked since it is known: it arms.
    assert_eq!(board.ask("get safety.max_force_n").expect("an answer"), "ok safety.max_force_n = 3");
    assert_eq!(board.ask("arm").expect("an answer"), "ok armed");
    found
}

#[test]
fn a_person_brings_up_a_board_whose_signs_are_wrong() {
    let mut board = table(&["encoder.reversed=true"]);
    // As it came, the encoder against the motor: arming is refused, and so is a check.
    assert!(board.ask("arm").expect("an answer").starts_with("error check first: "));
    let (probed, armed) = checked(&mut board);
    assert!(probed.contains("; disagree: ") && armed.starts_with("error check first: "), "{probed} {armed}");
    let found = brings_up("amplifier", &mut board);
    assert_eq!((found.peer.encoder.reversed, found.peer.motor.reversed), (true, false));
}

#[test]
fn a_person_brings_up_a_board_with_a_current_loop() {
    let found = brings_up("loop", &mut table(&[&LOOP[..], &["motor.reversed=true"]].concat()));
    assert_eq!((found.peer.encoder.reversed, found.peer.motor.reversed), (false, true));
    let motor = &found.peer.motor;
    assert!((motor.resistance_ohm / 3.0 - 1.0).abs() < 0.02, "{} Ω", motor.resistance_ohm);
    assert!((motor.inductance_h / 0.0007 - 1.0).abs() < 0.05, "{} H", motor.inductance_h);
}

/// A bridge that ignores its enable, a current sensor of the wrong sign, an encoder of the wrong scale: none of them is armed.
#[test]
fn what_a_current_loop_may_not_be_closed_around_is_not_armed() {
    for (wrong, end) in [
        ("plant.fault=ignored-enable", " enable "),
        ("plant.fault=reversed-sense", " sensor "),
        ("plant.fault=open-motor", " open "),
        // The settings say 200 counts a millimetre.
        ("encoder.counts_per_m=400000", "; scale: "),
    ] {
        let mut board = table(&[&LOOP[..], &["plant.fault_at_s=0", wrong]].concat());
        let (probed, armed) = checked(&mut board);
        assert!(probed.contains(end), "{wrong}: {probed}");
        assert!(armed.starts_with("error check first: "), "{wrong}: {armed}");
    }
}
