//! What current and voltage say, on simulated boards with a current loop: the true winding and constant are within their intervals, and
//! each thing that is broken or wrong is refused before the board can be armed.

use cohold_board_tools::calibrate::board::{Board, Run, run as run_line};
use cohold_board_tools::calibrate::simulated::SharedSimulation;
use cohold_board_tools::calibrate::winding::{Sheet, Winding, identify, winding};
use cohold_board_tools::calibrate::{Estimate, emf};
use cohold_board_tools::{calibrate::motor, calibrate::motor::Against};
use cohold_sim::scene::Scene;

use crate::calibrate::refused;

const DEVICE: &str = "plant.drive=current plant.pwm_steps=3000 device.mass_kg=0.17";

fn scene(overrides: &str) -> Scene {
    let overrides: Vec<String> = format!("{DEVICE} {overrides}").split_whitespace().map(str::to_owned).collect();
    Scene::load(cohold_sim::Laws::built_in(), None, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

fn board(overrides: &str) -> SharedSimulation {
    SharedSimulation::new(&scene(overrides)).expect("a board")
}

fn ask(board: &mut SharedSimulation, lines: &[&str]) {
    for line in lines {
        let answer = board.ask(line).expect("an answer");
        assert!(answer.starts_with("ok"), "{line}: {answer}");
    }
}

/// What a check says, and what `arm` does after it.
fn checked(board: &mut SharedSimulation) -> (String, String) {
    ask(board, &["check 1"]);
    board.ticks(0.2).expect("it runs");
    (board.ask("probed").expect("an answer"), board.ask("arm").expect("an answer"))
}

/// Another noise each time: the intervals hold the truth about as often as they say, and say little more than a percent.
#[test]
fn the_true_winding_and_constant_are_within_their_intervals() {
    const SEEDS: u32 = 20;
    for (ohm, henry, newton, narrow) in [
        (4.8, 5e-4, 8.0, [0.01, 0.02, 0.004]),
        (1.5, 5e-4, 6.25, [0.012, 0.015, 0.004]),
        (10.0, 1e-3, 12.0, [0.01, 0.03, 0.004]),
    ] {
        let mut held = [0; 4];
        for seed in 1..=SEEDS {
            let mut board = board(&format!(
                "motor.resistance_ohm={ohm} motor.inductance_h={henry} motor.newton_or_newton_metre_per_a={newton} \
                 network.seed={seed}"
            ));
            let (full, half) = (run(&mut board, "0.1"), run(&mut board, "0.05"));
            let Winding { resistance_ohm, inductance_h, zero_a } =
                identify([&full, &half], &board.settings(), 1).expect("a winding");
            ask(&mut board, &[&format!("set motor.resistance_ohm {}", resistance_ohm.value)]);
            ask(&mut board, &[&format!("set motor.inductance_h {}", inductance_h.value), "apply"]);
            let constant = emf::constant(&mut board, 1).expect("a constant").expect("it is measured");
            let all = [(resistance_ohm, ohm), (inductance_h, henry), (constant, newton), (zero_a, 0.0)];
            for (held, (Estimate { value, within }, truth)) in held.iter_mut().zip(all) {
                *held += u32::from((value - truth).abs() <= within);
            }
            for ((Estimate { value, within }, _), narrow) in all.into_iter().zip(narrow) {
                assert!(within < narrow * value, "{value} ± {within}");
            }
        }
        println!("{ohm} Ω, {henry} H, {newton} N/A: held {held:?} of {SEEDS}");
        // Of the sensor's zero 16 do, at these seeds.
        assert!(
            held[..3].iter().all(|held| *held >= 17) && held[3] >= 16,
            "{held:?} of {SEEDS} intervals hold the truth"
        );
    }
}

fn run(board: &mut SharedSimulation, duty: &str) -> Run {
    run_line(board, 1, &format!("probe 1 winding {duty} 0.68")).expect("a run")
}

/// Dead time takes the same at both amplitudes: the resistance does not see it, the inductance hardly.
#[test]
fn dead_time_is_no_resistance() {
    let mut board = board("plant.dead_time_s=0.0000005");
    let (full, half) = (run(&mut board, "0.1"), run(&mut board, "0.05"));
    let found = identify([&full, &half], &board.settings(), 1).expect("a winding");
    assert!((found.resistance_ohm.value / 4.8 - 1.0).abs() < 0.005, "{found:?}");
    assert!((found.inductance_h.value / 5e-4 - 1.0).abs() < 0.15, "{found:?}");
    // 0.48 V of 2.4 V: alone, the larger of them would say 20 % more.
    let mut none = full.clone();
    none.duties.iter_mut().for_each(|duty| *duty = 0.0);
    none.stage.iter_mut().for_each(|stage| stage.motors[0] = Default::default());
    let alone = identify([&full, &none], &board.settings(), 1).expect("a winding");
    assert!(alone.resistance_ohm.value > 1.15 * 4.8, "{alone:?}");
}

/// Each of these is refused by calibration with one sentence, and by the check, so that the board does not arm.
#[test]
fn what_is_broken_is_refused_before_the_board_is_armed() {
    for (defect, calibration, end) in [
        ("ignored-enable", None, " enable "),
        ("reversed-sense", Some("the current flows against the voltage"), " sensor "),
        ("dead-sense", Some("no current flows"), " open "),
        ("open-motor", Some("no current flows"), " open "),
        ("shorted-motor", Some("far beyond what was asked for"), " current "),
    ] {
        let new = || board(&format!("plant.fault={defect} plant.fault_at_s=0"));
        match calibration {
            Some(said) => refused(winding(&mut new(), 1, Sheet::default()), said),
            // A winding is a winding, however long it is driven.
            None => drop(winding(&mut new(), 1, Sheet::default()).expect(defect)),
        }
        let mut board = new();
        let (probed, armed) = checked(&mut board);
        assert!(probed.contains(end) && probed.contains("; stage: "), "{defect}: {probed}");
        assert!(armed.starts_with("error check first: "), "{defect}: {armed}");
        refused(motor::sign(&mut new(), 1), "; stage: so the loop around the current may not be closed");
    }
    // The same device, whole.
    let (probed, armed) = checked(&mut board(""));
    assert!(probed.contains("; agree: ") && armed == "ok armed", "{probed} {armed}");
}

/// The settings say other counts than the encoder has; every way to the constant that knows of it says so.
#[test]
fn an_encoder_of_another_scale_is_refused_before_the_board_is_armed() {
    for counts in ["400000", "100000", "300000", "130000"] {
        let new = || {
            let mut board = board("");
            ask(
                &mut board,
                &[&format!("set encoder.counts_per_m {counts}"), "set probe.max_speed_counts_per_s 1000000"],
            );
            ask(&mut board, &["set motor.newton_or_newton_metre_per_a 8", "apply"]);
            board
        };
        let (probed, armed) = checked(&mut new());
        assert!(probed.contains("; scale: "), "{counts}: {probed}");
        assert!(armed.starts_with("error check first: "), "{counts}: {armed}");
        // Signs it has, all the same.
        assert!(motor::sign(&mut new(), 1).is_ok());
        let mut person = new();
        for against in [Against::Mass(0.2), Against::Gauge, Against::Emf(Some(8.0))] {
            person = new();
            refused(motor::constant(&mut person.clone(), &mut person, 1, against), "the encoder's scale is wrong");
        }
        let alone = motor::constant(&mut person.clone(), &mut person, 1, Against::Emf(None)).expect("a constant");
        let ratio = counts.parse::<f64>().expect("a number") / 200_000.0;
        let constant = alone[0].value.as_float().expect("a number");
        assert!((constant / (8.0 * ratio) - 1.0).abs() < 0.01, "{counts}: {constant}");
    }
}

#[test]
fn a_motor_that_cannot_be_explained_is_refused() {
    let sheet = |resistance_ohm, inductance_h| Sheet { resistance_ohm, inductance_h, tolerance: 0.3 };
    let good = sheet(Some(4.0), Some(4e-4));
    assert!(winding(&mut board(""), 1, good).is_ok());
    refused(
        winding(&mut board("motor.resistance_ohm=3"), 1, sheet(Some(4.8), None)),
        "A flowed where a winding of 4.8 Ω",
    );
    refused(winding(&mut board("motor.resistance_ohm=4"), 1, sheet(Some(6.4), None)), "the resistance is 4.0");
    refused(winding(&mut board("motor.inductance_h=0.001"), 1, sheet(None, Some(5e-4))), "the inductance is 0.00");
    let found = winding(&mut board("plant.current_zero_a=0.05"), 1, good).expect("a winding").expect("it is measured");
    assert!((found[2].value.as_float().expect("a number") - 0.05).abs() < 0.001, "{found:?}");
    refused(winding(&mut board("plant.current_zero_a=0.2"), 1, good), "A while none flows");
    // So little inductance that the current is gone before it is sampled.
    for gone in ["0.00002", "0.00001", "0.000005", "0.000002"] {
        let mut fast = board(&format!("motor.inductance_h={gone}"));
        refused(winding(&mut fast, 1, Sheet::default()), "not those of a winding");
    }
    // Also where the probe ends within its rest.
    for short in ["set probe.max_s 0.1", "set probe.max_s 0.02"] {
        let mut held = board("");
        ask(&mut held, &[short, "apply"]);
        refused(winding(&mut held, 1, good), "raise probe.max_s");
    }
    // Without a loop there is nothing to see.
    let plain = Scene::load(cohold_sim::Laws::built_in(), None, &[]).expect("defaults");
    assert!(matches!(winding(&mut SharedSimulation::new(&plain).expect("a board"), 1, good), Ok(None)));
    assert!(matches!(emf::constant(&mut SharedSimulation::new(&plain).expect("a board"), 1), Ok(None)));
}
