//! Speed against error: the references are right, the front is a front, the insights hold, the command says all of it.

use std::collections::BTreeSet;
use std::process::Command;
use std::sync::LazyLock;

use cohold_cases::{Meter, reach};
use cohold_core::device::kinematics::five_bar::HOME_RAD;
use cohold_core::device::kinematics::{KinematicsName, Maths};
use cohold_core::device::velocity::VelocityName;
use cohold_core::law::wave::Decode;
use cohold_core::num::Scalar;
use cohold_core::object::IntegratorName;
use cohold_core::settings::{Choice, Settings};
use cohold_sim::scenes;
use cohold_studies::accuracy::counts::{Processor, parse};
use cohold_studies::accuracy::filters::{Exact, Filter};
use cohold_studies::accuracy::integrators::{Test, closed_form, energy_error, errors};
use cohold_studies::accuracy::{
    Comparison, Family, continuous, decodes, estimators, families, filters, integrators, mechanisms, pair,
    pareto_front, rigid,
};
use proptest::prelude::{prop, prop_assert, proptest};
use serde_json::Value;

const PROCESSORS: [Processor; 2] = [Processor::CortexM7, Processor::X86];

static FAMILIES: LazyLock<Vec<Family>> = LazyLock::new(|| families(Processor::CortexM7).expect("every scene builds"));

/// As a Cortex-M7 counts; the errors are the same everywhere.
fn family(name: &str) -> &'static Family {
    FAMILIES.iter().find(|family| family.name == name).unwrap_or_else(|| panic!("no family {name}"))
}

fn comparison(name: &str, title: &str, unit: &str) -> &'static Comparison {
    let found = family(name).comparisons.iter().find(|one| one.title.contains(title) && one.unit == unit);
    found.unwrap_or_else(|| panic!("{name} does not compare {title} in {unit}"))
}

#[test]
fn a_front_holds_what_nobody_beats() {
    let points = [(1.0, 100.0), (0.1, 200.0), (0.5, 300.0), (0.01, 250.0), (2.0, 100.0), (f64::NAN, 1.0)];
    assert_eq!(pareto_front(&points), [true, true, false, true, false, false]);
    assert!(pareto_front(&[]).is_empty());
}

/// A tenth of a per cent is no reason to pay more, nor to be thrown out.
#[test]
fn equals_are_equal() {
    assert_eq!(pareto_front(&[(1.0, 100.0), (0.999, 100.5)]), [true, true]);
    assert_eq!(pareto_front(&[(1.0, 100.0), (0.999, 150.0)]), [true, false]);
    assert_eq!(pareto_front(&[(0.0, 22.0), (1e-9, 21.0)]), [true, true]);
    assert_eq!(pareto_front(&[(0.0, 22.0), (0.0, 22.0)]), [true, true]);
}

proptest! {
    /// Someone is always on the front, and who is not, is beaten by someone.
    #[test]
    fn a_front_is_never_empty(points in prop::collection::vec((1e-3..1.1e-3_f64, 100.0..110.0_f64), 1..40)) {
        let front = pareto_front(&points);
        prop_assert!(front.iter().any(|on_front| *on_front));
        for (point, on_front) in points.iter().zip(front) {
            let beaten = points.iter().any(|other| other.0 < point.0 / 1.02 && other.1 < point.1 / 1.03);
            prop_assert!(!(on_front && beaten));
        }
    }
}

/// Error at twice the period over error at the period: 2 for a method of first order.
fn growth(error: impl Fn(f64) -> f64) -> f64 {
    error(2.5e-4) / error(1.25e-4)
}

/// On a contact that is sampled and held every integrator is of first order, the exact one included; solved with the object it
/// is of second order.
#[test]
fn on_a_sampled_contact_all_are_of_first_order() {
    for &name in IntegratorName::ALL {
        let orders = if name == IntegratorName::Midpoint { 3.8..4.2 } else { 1.8..2.3 };
        let (position, velocity) = (
            growth(|period| errors::<f64>(Test::Contact, name, period).0),
            growth(|period| errors::<f64>(Test::Contact, name, period).1),
        );
        for ratio in [position, velocity] {
            assert!(orders.contains(&ratio), "{}: {position} {velocity}", name.name());
        }
    }
}

/// A constant force on a damped mass: the Euler forms are of first order, the exact one has no error but rounding.
#[test]
fn the_exact_integrator_is_exact_where_the_force_is_held() {
    for name in [IntegratorName::ForwardEuler, IntegratorName::SemiImplicit] {
        let ratio = growth(|period| errors::<f64>(Test::Push, name, period).0);
        assert!((1.9..2.1).contains(&ratio), "{}: {ratio}", name.name());
    }
    for period in [1e-2, 1e-3, 1e-4] {
        let (position, velocity) = errors::<f64>(Test::Push, IntegratorName::Exact, period);
        assert!(position < 1e-14 && velocity < 1e-13, "{period}: {position} {velocity}");
    }
}

/// The closed forms solve their differential equations, by central differences.
#[test]
fn the_closed_forms_solve_their_equations() {
    for test in [Test::Contact, Test::Undamped, Test::Push] {
        let settings = integrators::settings(test, IntegratorName::Exact, 1e-3);
        let at = |time: f64| closed_form(test, &settings, time);
        let step = 1e-5;
        for time in [0.01, 0.1, 0.33] {
            let (before, now, after) = (at(time - step), at(time), at(time + step));
            let slope = (after.position - before.position) / (2.0 * step);
            let acceleration = (after.velocity - before.velocity) / (2.0 * step);
            let (contact, object) = (&settings.contact, &settings.object);
            let force = match test {
                Test::Push => 1.0 - object.damping_n_s_per_m * now.velocity,
                _ => -contact.stiffness_n_per_m * now.position - contact.damping_n_s_per_m * now.velocity,
            };
            assert!((slope - now.velocity).abs() < 1e-7, "{test:?} at {time}: {slope} {}", now.velocity);
            assert!((acceleration - force / object.mass_kg).abs() < 1e-5, "{test:?} at {time}");
        }
    }
}

/// Symplectic: without damping the energy wobbles, within ωT, and does not grow with time.
#[test]
fn only_the_semi_implicit_integrator_keeps_energy_and_the_midpoint_rule_exactly() {
    let [euler, semi, exact, midpoint, backward] = [
        IntegratorName::ForwardEuler,
        IntegratorName::SemiImplicit,
        IntegratorName::Exact,
        IntegratorName::Midpoint,
        IntegratorName::BackwardEuler,
    ]
    .map(|name| energy_error::<f64>(name, 1e-3));
    assert!(midpoint < 1e-12, "{midpoint}");
    let turn = (1000.0_f64 / 0.3).sqrt() * 1e-3;
    assert!(semi < turn, "{semi}");
    // Each tick multiplies the energy by 1 + K·T²/m, or by 1 + K·T²/2m where the step itself is exact.
    assert!((euler + 1.0).ln() / 500.0 / (turn * turn) > 0.95, "{euler}");
    assert!(((exact + 1.0).ln() / 500.0 / (turn * turn) - 0.5).abs() < 0.05, "{exact}");
    // And by 1/(1 + (ωT)²) with backward Euler: of 500 motions 499 ticks apart, what is left.
    assert!((1.0 - backward - (1.0 + turn * turn).powi(-499)).abs() < 1e-9, "{backward}");
}

#[test]
fn both_decodes_converge_to_the_closed_form() {
    for &decode in Decode::ALL {
        let error = |halvings: u32| {
            let mut settings = decodes::settings(decode, 1590.0);
            settings.timing.control_period_s /= f64::from(1 << halvings);
            settings.timing.ticks_per_packet <<= halvings;
            decodes::errors::<f64>(&settings)
        };
        let (coarse, fine) = (error(3), error(4));
        for ratio in [coarse.0 / fine.0, coarse.1 / fine.1] {
            assert!((1.7..2.4).contains(&ratio), "{}: {ratio}", decode.name());
        }
    }
}

/// The pair that flies, ever faster, comes to the matrix exponential of continuous control: two unrelated programs.
#[test]
fn the_pair_converges_to_continuous_control() {
    let duration_s = 3.0;
    let exact = continuous::run(&pair::scene(IntegratorName::Exact, Decode::Implicit, 1), duration_s);
    for (integrator, decode) in [
        (IntegratorName::ForwardEuler, Decode::Delayed),
        (IntegratorName::SemiImplicit, Decode::Implicit),
        (IntegratorName::Exact, Decode::Implicit),
    ] {
        let error = |rate| {
            let run = pair::run::<f64>(&pair::scene(integrator, decode, rate), duration_s).expect("a valid scene");
            let deviation = pair::deviation(&run, &exact);
            [deviation.position_rms_m, deviation.force_rms_n]
        };
        for (slow, fast) in error(8).into_iter().zip(error(16)) {
            assert!((1.7..2.3).contains(&(slow / fast)), "{integrator:?} {decode:?}: {slow} {fast}");
        }
    }
}

/// Both solves come to one solution of the self-timed line, at first order: what its device's sampling costs. Its reference has an error of a thirty-second
/// of that at 1 kHz.
#[test]
fn a_self_timed_line_converges_under_both_solves() {
    let line = comparison("whole-peer", "self-timed", "N");
    for integrator in ["midpoint", "backward-euler"] {
        let error = |rate: u32| line.error_of(&format!("self-timed, {integrator}, {rate} kHz"));
        for rate in [1, 2, 4] {
            let ratio = error(rate) / error(2 * rate);
            assert!((1.8..2.5).contains(&ratio), "{integrator}, {rate} kHz: {ratio}");
        }
    }
    let [midpoint, backward] =
        ["midpoint", "backward-euler"].map(|integrator| line.error_of(&format!("self-timed, {integrator}, 1 kHz")));
    assert!((midpoint / backward - 1.0).abs() < 0.1, "{midpoint} {backward}");
}

/// Error and time beside each other: the errors are the family's, a tick takes time, twice as many ticks take twice as long; and a page gets the table.
#[test]
fn times_stand_beside_the_errors() {
    let page = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("times.md");
    std::fs::write(&page, "before\n<!-- times begin -->\nold\n<!-- times end -->\nafter\n").expect("a page");
    let command = |arguments: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_cohold")).args(["accuracy", "time"]).args(arguments).output();
        let output = output.expect("cohold runs");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).expect("text")
    };
    let rows: Vec<Value> = serde_json::from_str(&command(&["--json"])).expect("rows");
    let of = |choice: &str, rate: u64| {
        let found = rows.iter().find(|row| row["choice"] == choice && row["rate_khz"] == rate);
        found.unwrap_or_else(|| panic!("no {choice} at {rate} kHz in {rows:?}"))
    };
    let number = |row: &Value, name: &str| row[name].as_f64().unwrap_or_else(|| panic!("no {name} in {row}"));
    for (choice, title) in [("midpoint, implicit", "coordination force"), ("self-timed, backward-euler", "self-timed")]
    {
        let known = comparison("whole-peer", title, "N").error_of(&format!("{choice}, 2 kHz"));
        assert!((number(of(choice, 2), "force_n") / known - 1.0).abs() < 1e-12, "{choice}");
        let [once, twice] = [1, 2].map(|rate| number(of(choice, rate), "time_s"));
        assert!(once > 1e-9 && (twice / once - 2.0).abs() < 1e-9, "{choice}: {once} s, {twice} s");
    }
    command(&["--page", page.to_str().expect("a path")]);
    let text = std::fs::read_to_string(page).expect("a page");
    assert!(text.starts_with("before\n<!-- times begin -->\n```text\nchoice "), "{text}");
    assert!(text.ends_with("```\n<!-- times end -->\nafter\n") && !text.contains("old"), "{text}");
}

/// The gain of y ← a·y + (1 − a)·u is (1 − a)/|1 − a·e^(−jωT)|; the impulse response must say the same.
#[test]
fn the_measured_gain_is_the_known_one() {
    let settings = Settings::default();
    let (cutoff, period) = (std::f64::consts::TAU * settings.coordination.cutoff_hz, settings.timing.control_period_s);
    let keep = (-cutoff * period).exp();
    let square = |at: i32| {
        let angular = std::f64::consts::TAU * 62.5 * f64::from(at) / 1000.0;
        let (sine, cosine) = (angular * period).sin_cos();
        let gain = (1.0 - keep) / (1.0 - keep * cosine).hypot(keep * sine);
        (gain * 1.0_f64.hypot(angular / cutoff) - 1.0).powi(2)
    };
    let known = ((1..=1000).map(square).sum::<f64>() / 1000.0).sqrt();
    let (_, measured) = filters::errors::<f64, Exact<f64>>(&settings);
    assert!((measured / known - 1.0).abs() < 1e-9, "{measured} {known}");
    let mut filter = <Exact<f64> as Filter<f64>>::build(&settings);
    assert!((filter.push(1.0) - (1.0 - keep)).abs() < 1e-15);
}

/// Both distal links have their length at every pose, and the Jacobian is core's in f64 to rounding.
#[test]
fn the_five_bar_closes() {
    let settings = mechanisms::settings(KinematicsName::FiveBar, Maths::Libm);
    let lengths = &settings.kinematics;
    let home = mechanisms::truth(&settings, [0.0, 0.0]);
    assert_eq!(home.0.map(Scalar::to_f64), [0.0, 0.0]);
    // Home by hand: elbows 0.16 m apart at height l₁·sin 60°, hand √(l₂² − 0.08²) above them.
    let home_y = 0.1 * HOME_RAD.sin() + (0.12_f64.powi(2) - 0.08_f64.powi(2)).sqrt();
    let joints = mechanisms::joints(KinematicsName::FiveBar);
    assert_eq!(joints.len(), 1089);
    let truths: Vec<_> = joints.into_iter().map(|joints| (joints, mechanisms::truth(&settings, joints))).collect();
    for ([a, b], (hand, _)) in &truths {
        let [x, y] = hand.map(Scalar::to_f64);
        for (angle, side) in [(std::f64::consts::PI - HOME_RAD + a, -0.5), (HOME_RAD + b, 0.5)] {
            let elbow_x = side * lengths.base_m + lengths.proximal_m * angle.cos();
            let elbow_y = lengths.proximal_m * angle.sin();
            let link = (x - elbow_x).hypot(y + home_y - elbow_y);
            assert!((link - lengths.distal_m).abs() < 1e-15, "{a} {b}: {link}");
        }
    }
    let (hand, jacobian) = mechanisms::errors::<f64>(&settings, &truths);
    assert!(hand < 1e-15 && jacobian < 1e-14, "{hand} {jacobian}");
}

/// With an encoder that hardly rounds, a difference errs by the half tick it is late: T_c/2 times the acceleration.
#[test]
fn a_fine_encoder_leaves_the_lag() {
    let error = estimators::error::<f64>(&estimators::settings(VelocityName::Difference, 2e8));
    let settings = Settings::default();
    let readings = estimators::readings::<f64>(&settings);
    let velocities: Vec<f64> = readings.iter().map(|(_, velocity)| *velocity).collect();
    let lag: f64 = velocities.windows(2).map(|pair| ((pair[1] - pair[0]) / 2.0).powi(2)).sum();
    let lag = (lag / velocities.len() as f64).sqrt();
    assert!((error / lag - 1.0).abs() < 0.05, "{error} {lag}");
}

/// What the insights say, beyond their numbers.
#[test]
fn the_insights_hold() {
    let (rounding, whole) = (comparison("number-type", "rounding", "m"), comparison("number-type", "whole", "m"));
    assert!(rounding.error_of("f32") < 0.02 * whole.error_of("f32"));
    assert!(rounding.error_of("f64") < 1e-12);

    // What flies keeps its sums where they lose nothing.
    let apart = comparison("number-type", "self-timed", "m");
    assert!(apart.error_of("f32, sums in f64") < 0.25 * apart.error_of("f32, sums in f32"));
    assert!(apart.error_of("f64") < 1e-12);

    let force = comparison("whole-peer", "force", "N");
    let good = force.error_of("semi-implicit, implicit, 1 kHz");
    assert!(good < force.error_of("forward-euler, delayed, 2 kHz"));
    assert!(good > 0.8 * force.error_of("forward-euler, delayed, 4 kHz"));

    let contact = comparison("integrator", "contact", "m");
    assert!(contact.error_of("midpoint") < 0.1 * contact.error_of("backward-euler"));
    assert!(contact.error_of("semi-implicit") < contact.error_of("exact"));
    assert!(contact.error_of("exact") < contact.error_of("forward-euler"));
    let push = comparison("integrator", "push", "m");
    assert!(push.error_of("exact") < 1e-3 * push.error_of("semi-implicit"));

    let stiff = comparison("decode", "10620", "N");
    assert!(stiff.error_of("implicit") < 0.5 * stiff.error_of("delayed"));

    let gain = comparison("filter", "250 Hz", "1");
    assert!(gain.error_of("exact") < 0.5 * gain.error_of("forward-euler"));

    let hand = comparison("kinematics", "five-bar", "m");
    assert!(hand.error_of("f32, micromath") > 1000.0 * hand.error_of("f32, libm"));
    for processor in PROCESSORS {
        let hand = &mechanisms::measure(processor).expect("every scene builds").comparisons[0];
        let count = |name| hand.instructions_of(name) as f64;
        assert!(count("f32, micromath") > 0.8 * count("f32, libm"), "{processor:?}");
    }

    let usual = comparison("velocity", "200000", "m/s");
    assert!(usual.error_of("filtered") < usual.error_of("adaptive"));
    assert!(usual.error_of("filtered") < usual.error_of("difference"));
    let fine = comparison("velocity", "16777216", "m/s");
    assert!(fine.error_of("difference") < fine.error_of("filtered"));
}

/// The reviewed files hold the cases that are measured, no more and no less. What is not in them is shown without a count,
/// so this fails for a new integrator or estimator, and for nothing else, until it has been counted.
#[test]
fn every_case_was_counted() {
    struct Nothing;
    impl Meter for Nothing {
        fn call<I, O>(body: &mut impl FnMut(I) -> O, input: I) -> O {
            body(input)
        }
    }
    let names: BTreeSet<String> =
        cohold_cases::all::<f32, cohold_laws::EveryLaw<f32>, Nothing>().map(|case| case.name).collect();
    for processor in PROCESSORS {
        let counted: BTreeSet<String> = parse(processor.reviewed()).into_keys().map(str::to_owned).collect();
        let (missing, stale) = (&names - &counted, &counted - &names);
        assert!(
            missing.is_empty() && stale.is_empty(),
            "{processor:?}: not counted are {missing:?}, no cases any more {stale:?}; host-sim/studies/src/accuracy/counts.rs says how to \
             count"
        );
    }
}

/// The reach is the one of `scenes/person-reach.toml`, and its velocity is its slope.
#[test]
fn the_reach_is_the_persons() {
    let [person, _] = scenes::load(cohold_guest_laws::laws(), "person-reach").expect("a built-in scene").users;
    for tick in 0..2000 {
        let (time_s, step_s) = (f64::from(tick) * 1e-3, 1e-6);
        let (hand, (position, velocity)) = (reach::hand(time_s), person.wanted(time_s));
        assert!((hand.position - position).abs() < 1e-15 && (hand.velocity - velocity).abs() < 1e-13, "{time_s}");
        let slope = (reach::hand(time_s + step_s).position - reach::hand(time_s - step_s).position) / (2.0 * step_s);
        assert!((slope - hand.velocity).abs() < 1e-6, "{time_s}: {slope} {}", hand.velocity);
    }
}

#[test]
fn the_command_says_everything() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("accuracy");
    let _ = std::fs::remove_dir_all(&folder);
    let start = std::time::Instant::now();
    let output = Command::new(env!("CARGO_BIN_EXE_cohold"))
        .args(["accuracy", "--json", "--out"])
        .arg(&folder)
        .output()
        .expect("cohold runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let took = start.elapsed();
    crate::declared::has_columns_of("accuracy", &folder.join("accuracy.csv"));
    crate::letters::are_readable(&folder, 8, true);
    // What a person waits for, in a release build; a test build on a busy machine has more.
    let limit_s = if cfg!(debug_assertions) { 240 } else { 20 };
    assert!(took.as_secs() < limit_s, "{took:?}");
    let document: Value = serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else");
    assert_eq!(document["processor"], "cortex-m7");
    let list =
        |value: &Value| value.as_array().filter(|list| !list.is_empty()).expect("a list with something in it").clone();
    let families = list(&document["families"]);
    let names: Vec<&str> = families.iter().filter_map(|family| family["name"].as_str()).collect();
    assert_eq!(names, ["number-type", "whole-peer", "integrator", "decode", "filter", "kinematics", "velocity"]);
    for family in &families {
        for text in ["motion", "reference", "insight", "instructions_per"] {
            assert!(family[text].as_str().is_some_and(|text| text.len() > 5), "{text} of {}", family["name"]);
        }
        for comparison in list(&family["comparisons"]) {
            let points = list(&comparison["points"]);
            assert!(points.len() > 1 && points.iter().any(|point| point["on_front"] == true), "{comparison}");
            for point in points {
                assert!(point["error"].as_f64().is_some_and(|error| error >= 0.0 && error.is_finite()), "{point}");
                let counted = &point["instructions"];
                assert!(counted.is_null() || counted.as_u64().is_some_and(|count| count > 0), "{point}");
            }
        }
    }
    let costs = list(&document["cost_per_scene"]);
    let scene = |name: &str| costs.iter().find(|cost| cost["scene"] == name).unwrap_or_else(|| panic!("no {name}"));
    for cost in &costs {
        if let Some(over) = cost["over"].as_str() {
            for column in 0..3 {
                let of = |cost: &Value| cost["instructions"][column].as_i64().expect("a count");
                assert_eq!(cost["added"][column].as_i64(), Some(of(cost) - of(scene(over))));
            }
        }
    }
    let pictures = list(&document["pictures"]);
    assert_eq!(pictures.len(), 3 * (families.len() + 1));
    for picture in pictures {
        let size = std::fs::metadata(picture.as_str().expect("a path")).expect("the picture is there").len();
        assert!(size > 5000, "{picture}");
    }
}

/// Of what nobody pushes nothing may change; a top lags by a quarter at half the step.
#[test]
fn a_free_body_keeps_what_it_has_and_lags_by_the_square_of_its_step() {
    let rows = rigid::study(20.0, &[1.0, 2.0], &|| ());
    let of = |number: &str, period_ms: f64| {
        *rows.iter().find(|row| row.number_type == number && row.period_ms == period_ms).expect("a row")
    };
    let [fine, coarse] = [1.0, 2.0].map(|period_ms| of("f64", period_ms));
    for row in [fine, coarse] {
        assert!(row.energy_drift < 1e-12 && row.momentum_drift < 1e-12, "{row:?}");
    }
    assert!(fine.late > 0.0 && (coarse.late / fine.late - 4.0).abs() < 0.02, "{fine:?} {coarse:?}");
    let single = of("f32", 1.0);
    assert!((1e-9..1e-5).contains(&single.energy_drift) && single.momentum_drift < 1e-5, "{single:?}");
    assert!((single.late / fine.late - 1.0).abs() < 0.5, "{single:?}");
}
