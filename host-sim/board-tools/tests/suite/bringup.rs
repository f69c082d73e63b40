//! The first hour, on simulated boards: it passes whichever signs are wrong, and each thing that does not work ends it at its step.

use std::path::PathBuf;

use cohold_board_tools::Error;
use cohold_board_tools::bringup::{OFF_V, Passed, Plan, VOLTMETER, bring_up};
use cohold_board_tools::calibrate::board::{Board, Tick};
use cohold_board_tools::calibrate::counts::Distance;
use cohold_board_tools::calibrate::motor::Against;
use cohold_board_tools::calibrate::simulated::{Currents, SharedSimulation, Stop};
use cohold_board_tools::calibrate::winding::Sheet;
use cohold_board_tools::calibrate::{Person, Task};
use cohold_board_tools::status::{Probed, Status};
use cohold_core::device::probe::{End, Outcome, Verdict};
use cohold_core::safety::{Fault, Mode};
use cohold_core::settings::Choice;
use cohold_sim::scene::Scene;

const DEVICE: &str = "device.mass_kg=0.17";

/// A person who does all that is asked but these tasks.
struct Careless {
    careful: SharedSimulation,
    leaves_out: fn(&Task) -> bool,
}

impl Person for Careless {
    fn please(&mut self, task: &Task) -> Result<(), Error> {
        if (self.leaves_out)(task) { Ok(()) } else { self.careful.please(task) }
    }

    fn reading(&mut self, what: &str) -> Result<f64, Error> {
        self.careful.reading(what)
    }
}

/// Brings up a new board with this device, as `wrap` shows it; gives what the settings file says of the device, the board, and the outcome.
fn run<B: Board>(
    name: &str,
    device: &str,
    leaves_out: fn(&Task) -> bool,
    wrap: fn(SharedSimulation) -> B,
) -> (Option<Scene>, B, Result<Vec<Passed>, Error>) {
    let (found, board, outcome, _) = run_by(name, device, sheet(device), leaves_out, wrap);
    (found, board, outcome)
}

/// The same by a data sheet that may be another motor's; and the current that flowed by voltages until the winding was known, A.
fn run_by<B: Board>(
    name: &str,
    device: &str,
    sheet: Sheet,
    leaves_out: fn(&Task) -> bool,
    wrap: fn(SharedSimulation) -> B,
) -> (Option<Scene>, B, Result<Vec<Passed>, Error>, f64) {
    let overrides: Vec<String> = device.split_whitespace().map(str::to_owned).collect();
    let truth = Scene::load(cohold_sim::Laws::built_in(), None, &overrides).unwrap_or_else(|error| panic!("{error}"));
    let careful = SharedSimulation::new(&truth).expect("a board");
    let (mut board, mut person) = (wrap(careful.clone()), Careless { careful: careful.clone(), leaves_out });
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("brought-up-{name}.toml"));
    let _ = std::fs::remove_file(&file);
    let turns = device.contains("capstan");
    let distance = if turns { Distance::Revolutions(2.0) } else { Distance::Metres(0.05) };
    let plan = Plan { joint: 1, distance, sheet, against: Against::Mass(0.2), file: &file };
    let mut before_the_loop_a = None;
    let outcome = bring_up(&mut board, &mut person, plan, |passed| {
        if passed.step == "winding" {
            before_the_loop_a = Some(careful.currents().open_a);
        }
    });
    let before_the_loop_a = before_the_loop_a.unwrap_or(careful.currents().open_a);
    let found = outcome.is_ok().then(|| {
        let before = cohold_core::settings::Settings::default().safety.max_force_n;
        assert_eq!(careful.settings().safety.max_force_n, before, "the limit is put back");
        Scene::load(cohold_sim::Laws::built_in(), Some(&file), &[]).expect("the simulator takes the file")
    });
    (found, board, outcome, before_the_loop_a)
}

/// The data sheet that fits a device.
fn sheet(device: &str) -> Sheet {
    let number = |key: &str| {
        let word = device.split_whitespace().find_map(|word| word.strip_prefix(key)?.strip_prefix('='));
        word.map(|text| text.parse().expect("a number"))
    };
    let [resistance_ohm, inductance_h] = ["motor.resistance_ohm", "motor.inductance_h"].map(number);
    Sheet { resistance_ohm, inductance_h, tolerance: 0.3 }
}

/// A device with this winding, in a loop.
fn wound(ohm: f64, henry: f64) -> String {
    format!(
        "device.mass_kg=0.17 plant.drive=current plant.pwm_steps=3000 motor.resistance_ohm={ohm} motor.inductance_h={henry} \
         encoder.counts_per_m=157000 motor.newton_or_newton_metre_per_a=6.3 plant.coulomb_n=0.1"
    )
}

/// What a probe commands at the most, A: `probe.max_duty` of `motor.full_scale_a`.
const ASKED_A: f64 = 0.5;

/// Motors of 0.3 to 20 Ω and 0.05 to 5 mH, on boards that know no more of them than the data sheet: those that a loop can be closed around pass, and
/// no more than 120 % of what was asked for, and 20 mA, flows at any step. `BRINGUP_WINDINGS` says how many.
#[test]
fn windings_of_any_kind_pass_and_take_no_more_than_was_asked_for() {
    let mut rng = cohold_sim::rng::Rng::new(1);
    let mut between = |low: f64, high: f64| low * (high / low).powf(rng.unit());
    let windings = std::env::var("BRINGUP_WINDINGS").map_or(12, |text| text.parse().expect("a number"));
    let (mut counts, mut most_a, mut most_closed): ([u32; 2], f64, f64) = Default::default();
    for _ in 0..windings {
        let [ohm, henry] = [between(0.3, 20.0), between(0.05e-3, 5e-3)];
        let device = wound(ohm, henry);
        let (_, board, passed, before_a) = run_by("windings", &device, sheet(&device), |_| false, |board| board);
        let Currents { closed, open_a } = board.currents();
        let what = format!("{ohm:.3} ohm, {:.4} mH: {before_a:.3} A, {open_a:.3} A, {closed:.3}", 1e3 * henry);
        println!("{what}: {}", passed.as_ref().map_or_else(ToString::to_string, |_| "passed".to_owned()));
        assert!(before_a < 1.2 * ASKED_A && open_a < 1.2 * ASKED_A && closed < 1.25, "{what}");
        (most_a, most_closed) = (most_a.max(before_a), most_closed.max(closed));
        match passed {
            Ok(passed) => counts[0] += u32::from(passed.len() == 12),
            Err(why) => {
                let why = why.to_string();
                let quick = why.starts_with("winding: ") && why.contains("put an inductor in series");
                assert!(quick && henry / ohm < 40e-6, "{what}: {why}");
                counts[1] += 1;
            }
        }
    }
    println!(
        "{windings} windings: {counts:?} passed, too quick; at most {most_a:.3} A before the loop was closed, and {most_closed:.3} of what it asked for after"
    );
    assert!(counts[0] > windings / 2);
}

/// A data sheet of another motor is refused before a loop is closed, and before more flows than is asked for; so is none.
#[test]
fn another_motors_data_sheet_is_refused() {
    for (ohm, henry) in [(0.5, 0.0002), (2.0, 0.001), (8.0, 0.0015)] {
        let device = wound(ohm, henry);
        let of = |ohm: f64, henry: f64| Sheet { resistance_ohm: Some(ohm), inductance_h: Some(henry), tolerance: 0.3 };
        for wrong in
            [of(3.0 * ohm, henry), of(ohm / 3.0, henry), of(ohm, 3.0 * henry), of(ohm, henry / 3.0), of(henry, ohm)]
        {
            let (_, board, outcome, before_a) = run_by("another", &device, wrong, |_| false, |board| board);
            let why = outcome.expect_err("another motor").to_string();
            assert!(why.starts_with("winding: "), "{ohm} ohm, {henry} H by {wrong:?}: {why}");
            assert!(before_a < 1.2 * ASKED_A, "{ohm} ohm, {henry} H by {wrong:?}: {before_a} A");
            assert_eq!(board.currents().closed, 0.0, "no loop was closed");
        }
        let (_, board, outcome, before_a) = run_by("another", &device, Sheet::default(), |_| false, |board| board);
        let why = outcome.expect_err("no data sheet").to_string();
        assert!(why.contains("give --resistance-ohm and --inductance-h"), "{why}");
        assert_eq!((before_a, board.currents().closed), (0.0, 0.0));
    }
}

#[test]
fn a_new_board_passes_every_step_whichever_signs_are_wrong() {
    const SLIDE: &str = "plant.coulomb_n=0.1 encoder.counts_per_m=157000 motor.newton_or_newton_metre_per_a=6.3";
    const CAPSTAN: &str = "kinematics.model=capstan encoder.counts_per_rev=4000 kinematics.capstan_ratio=12 \
                           kinematics.paddle_radius_m=0.07 motor.newton_or_newton_metre_per_a=0.05 plant.coulomb_n=0.1";
    const LOOP: &str = "plant.drive=current plant.pwm_steps=3000 motor.resistance_ohm=3 motor.inductance_h=0.0007 \
                        encoder.counts_per_m=157000 motor.newton_or_newton_metre_per_a=6.3 plant.coulomb_n=0.1";
    for (kind, device) in [("slide", SLIDE), ("capstan", CAPSTAN), ("loop", LOOP)] {
        for (motor, encoder) in [(false, false), (true, false), (false, true), (true, true)] {
            let signs = format!("device.mass_kg=0.17 motor.reversed={motor} encoder.reversed={encoder}");
            let (found, _, passed) =
                run(&format!("{kind}-{motor}-{encoder}"), &format!("{device} {signs}"), |_| false, |board| board);
            let passed = passed.unwrap_or_else(|why| panic!("{kind} {signs}: {why}"));
            assert_eq!(passed.len(), 12);
            let found = found.expect("what it found");
            assert_eq!((found.peer.motor.reversed, found.peer.encoder.reversed), (motor, encoder), "{kind}");
            assert!((found.world.device.mass_kg / 0.17 - 1.0).abs() < 0.03, "{kind}: {}", found.world.device.mass_kg);
            let seen = &passed.iter().find(|passed| passed.step == "winding").expect("the step").seen;
            if kind == "loop" {
                assert!((found.peer.motor.resistance_ohm / 3.0 - 1.0).abs() < 0.02, "{seen}");
                assert!((found.peer.motor.inductance_h / 0.0007 - 1.0).abs() < 0.05, "{seen}");
            } else {
                assert_eq!(seen, "this board has no current loop: nothing was measured");
            }
        }
    }
}

/// Each of these is something that does not work, seen from the PC.
#[test]
fn what_does_not_work_ends_it_at_its_step_with_what_to_look_at() {
    type Case = (&'static str, fn(&Task) -> bool, &'static str);
    let cases: [Case; 5] = [
        ("stop", |task| *task == Task::PressStop, "emergency stop: the board answers \"arm\" with \"error check first"),
        ("encoder", |task| matches!(task, Task::MoveMetres { .. }), "encoder: the encoder counted 0"),
        ("motor", |task| matches!(task, Task::Fasten { .. }), "motor: the added mass shows as "),
        ("contact", |task| matches!(task, Task::Push { .. }), "first contact: nothing pushed back"),
        ("cable", |task| *task == Task::PullCable, "cable: the motors should be off because"),
    ];
    for (name, leaves_out, expected) in cases {
        let (_, _, outcome) = run(name, DEVICE, leaves_out, |board| board);
        let why = outcome.expect_err(name).to_string();
        assert!(why.starts_with(expected) && why.contains("; look at "), "{name}: {why}");
    }
}

/// Brings up a board with this device and stop by a voltmeter that shows so much of the truth; why it ended, if it did, and its second step.
fn stopped_by(device: &str, stop: Stop, shows: f64) -> Result<String, String> {
    struct Reader(SharedSimulation, f64);
    impl Person for Reader {
        fn please(&mut self, task: &Task) -> Result<(), Error> {
            self.0.please(task)
        }
        fn reading(&mut self, what: &str) -> Result<f64, Error> {
            Ok(self.0.reading(what)? * if what == VOLTMETER { self.1 } else { 1.0 })
        }
    }
    let overrides: Vec<String> = device.split_whitespace().map(str::to_owned).collect();
    let truth = Scene::load(cohold_sim::Laws::built_in(), None, &overrides).expect("a device");
    let mut board = SharedSimulation::new(&truth).expect("a board");
    board.wire_stop(stop);
    let file = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("brought-up-stop.toml");
    let _ = std::fs::remove_file(&file);
    let (distance, against) = (Distance::Metres(0.05), Against::Mass(0.2));
    let plan = Plan { joint: 1, distance, sheet: sheet(device), against, file: &file };
    let mut person = Reader(board.clone(), shows);
    let passed = bring_up(&mut board, &mut person, plan, |_| {}).map_err(|why| why.to_string())?;
    Ok(passed[1].seen.clone())
}

/// Each contact by itself, with a board that measures its supply and with one that does not.
#[test]
fn a_stop_passes_only_if_both_contacts_do_what_they_are_for() {
    let looped = wound(3.0, 0.0007);
    for (device, measures) in [(looped.as_str(), true), (DEVICE, false)] {
        let seen = stopped_by(device, Stop::default(), 1.0);
        if measures {
            // ln(24/4.5)·2.2 s = 3.68 s, and at the most two looks more.
            let seen = seen.expect("it passes");
            let after_s: f64 = seen
                .split(" after ")
                .nth(1)
                .and_then(|rest| rest.split(' ').next())
                .expect("a time")
                .parse()
                .expect("s");
            let falls_s = 2.2 * (24.0 / OFF_V).ln();
            assert!((after_s - falls_s).abs() < 0.2, "{seen}: by its time constant {falls_s:.2} s");
        }
        let refused = |stop: Stop, shows: f64| stopped_by(device, stop, shows).expect_err("it may not pass");
        let why = refused(Stop { first_opens: false, ..Stop::default() }, 1.0);
        assert!(why.starts_with("emergency stop: the board answers \"arm\""), "{why}");
        let why = refused(Stop { second_opens: false, ..Stop::default() }, 1.0);
        assert!(why.starts_with("emergency stop: the stop is pressed, and the supply stands at 24.0 V"), "{why}");
        // 1000 µF behind 110 kΩ.
        let why = refused(Stop { falls_s: 110.0, ..Stop::default() }, 1.0);
        assert!(why.starts_with("emergency stop: ") && why.contains("2.2 kΩ across"), "{why}");
        // 5 s of it are not enough to stop, and show.
        let why = refused(Stop { falls_s: 7.0, ..Stop::default() }, 1.0);
        assert!(why.starts_with("emergency stop: "), "{why}");
        assert_eq!(why.contains("something holds it"), measures, "{why}");
        if measures {
            let why = refused(Stop::default(), 1.1);
            assert!(why.starts_with("supply: the board reads 24.00 V, the voltmeter 26.40 V; "), "{why}");
        }
    }
}

/// A board whose device is pulled as soon as nobody looks for a second.
struct Pulled(SharedSimulation);

impl Board for Pulled {
    fn ask(&mut self, line: &str) -> Result<String, Error> {
        self.0.ask(line)
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error> {
        if seconds == 1.0 {
            self.0.please(&Task::Push { joint: 1, metres: 0.005 })?;
        }
        self.0.ticks(seconds)
    }
}

#[test]
fn a_joint_that_moves_by_itself_does_not_pass_the_lowest_force() {
    let (_, mut board, outcome) = run("pulled", DEVICE, |_| false, Pulled);
    let why = outcome.expect_err("pulled").to_string();
    assert!(why.starts_with("lowest force: in a second it moved by "), "{why}");
    assert!(board.0.ask("status").expect("an answer").contains(" disarmed "), "it is disarmed");
}

/// A board one of whose ticks began 0.1 ms late.
struct Late(SharedSimulation);

impl Board for Late {
    fn ask(&mut self, line: &str) -> Result<String, Error> {
        match line {
            "time delay" => {
                Ok("ok from due to begun, cycles of 480 MHz: most 48000 in tick 41 sent; from:ticks 0:9".to_owned())
            }
            _ => self.0.ask(line),
        }
    }

    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error> {
        self.0.ticks(seconds)
    }
}

#[test]
fn a_tick_that_begins_late_does_not_pass() {
    let (_, _, outcome) = run("late", DEVICE, |_| false, Late);
    let why = outcome.expect_err("late").to_string();
    assert!(why.starts_with("time: delay 100.0 µs, may be 50 µs: "), "{why}");
}

/// Every mode that a board can be in is read back from what it says; what is none is refused.
/// Whatever a board may say of a probe is read back as what it was.
#[test]
fn an_outcome_is_read_as_end_and_verdict() {
    let electric = Outcome { check: true, joint: 2, ..Outcome::default() };
    for end in End::ALL {
        let said = Outcome { end: *end, ..electric }.to_string();
        let probed = Probed::parse(&said).expect("an outcome");
        assert_eq!((probed.end, probed.is_running(), probed.to_string()), (*end, *end == End::Running, said));
        assert_eq!(probed.verdict.is_some(), !matches!(end, End::None | End::Running), "{probed}");
    }
    for verdict in Verdict::ALL {
        let said = format!("joint 1 done work 9 0 of 8: its time was over; {}: {}", verdict.name(), verdict.explain());
        assert_eq!(Probed::parse(&said).expect("an outcome").verdict, Some(*verdict));
    }
    for said in ["", "joint 1", "joint 1 tired: it sleeps"] {
        let why = Probed::parse(said).expect_err("no outcome").to_string();
        assert!(why.contains("how the probe ended") && why.contains(said), "{why}");
    }
}

#[test]
fn a_status_is_read_as_a_mode() {
    let modes = [Mode::Disarmed, Mode::Armed, Mode::Probing].into_iter().chain(Fault::ALL.map(Mode::Faulted));
    for mode in modes {
        let said = format!(
            "board 2 {} fault {} ticks 7; motors off: the operator was silent",
            mode.name(),
            mode.fault_number()
        );
        let status = Status::parse(&said).expect("a status");
        assert_eq!((status.mode, status.let_go, status.to_string()), (mode, true, said));
    }
    assert!(!Status::parse("board 1 armed fault 0 ticks 7; silent").expect("a status").let_go);
    for said in
        ["", "board 1 armed", "board 1 armed fault 3 ticks 7", "board 1 faulted fault 0", "board 1 faulted fault 200"]
    {
        let why = Status::parse(said).expect_err("no status").to_string();
        assert!(why.contains("no mode") && why.contains(said), "{why}");
    }
}
