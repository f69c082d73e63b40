//! Motor constant, force (or torque) per ampere, against something known; and the sign of a motor.
//!
//! With a gauge: the joint pushes against a force gauge at three duties, the person reads it, and the slope over the duties is the
//! constant; friction and the gauge's zero are in the intercept. With a mass: the joint is moved alone and with a known mass
//! fastened to it; the masses come out in units of duty, and what they differ by is known in kilograms. Or by its voltage ([`emf`]).

use cohold_core::device::probe::{End, Verdict};
use cohold_core::settings::Settings;
use cohold_sim::student::student_95;

use super::board::{Board, Joint, probed, run, say, settings};
use super::{Estimate, Found, Person, Task, emf, motion};
use crate::Error;

/// Slope of a line through points, with its 95 % interval.
///
/// # Errors
/// Too few points for a slope.
pub fn slope(points: &[(f64, f64)]) -> Result<Estimate, Error> {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let squares: f64 = points.iter().map(|point| (point.0 - x).powi(2)).sum();
    let value = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum::<f64>() / squares;
    let left: f64 = points.iter().map(|point| (point.1 - y - value * (point.0 - x)).powi(2)).sum();
    cohold_sim::refuse_if!(points.len() < 3, "two readings make no line: give at least three");
    let t = student_95(points.len() as u32 - 2);
    let within = t * (left / (count - 2.0) / squares).sqrt();
    cohold_sim::refuse_if!(
        value <= 0.0 || within > 0.25 * value,
        "the readings lie on no line: {} N per full duty; hold the joint firmly against the gauge, and read it in newtons",
        Estimate::new(value, within)
    );
    Ok(Estimate::new(value, within))
}

/// What a motor's constant is measured against.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Against {
    /// A force gauge, which the person reads.
    Gauge,
    /// A mass that the person fastens, kg.
    Mass(f64),
    /// The voltage that it makes by moving, on a board that measures currents; and what its data sheet says, N/A or N·m/A.
    Emf(Option<f64>),
}

/// Finds the constant of joint `number`'s motor. By a force, it is held against the voltage that the motor makes by moving, where the board
/// measures currents.
///
/// # Errors
/// The board refused, the person gave up, or the two constants disagree.
pub fn constant(
    board: &mut dyn Board,
    person: &mut dyn Person,
    number: u32,
    against: Against,
) -> Result<Vec<Found>, Error> {
    let ((estimate, unit), way) = match against {
        Against::Gauge => (gauge(board, person, number)?, "by the gauge"),
        Against::Mass(kilograms) => (mass(board, person, number, kilograms)?, "by the mass"),
        Against::Emf(sheet) => {
            let found =
                emf::constant(board, number)?.ok_or("this board does not measure currents: give a gauge or a mass")?;
            let sheet = sheet.map(|value| Estimate::new(value, 0.0));
            sheet.map_or(Ok(()), |sheet| emf::against(found, sheet, "by its data sheet"))?;
            let joint = Joint::of(&settings(board)?, number)?;
            return Ok(vec![Found::number(KEY, found, unit_of(&joint))]);
        }
    };
    person.please(&Task::LetGo { joint: number })?;
    if let Some(by_voltage) = emf::constant(board, number)? {
        emf::against(by_voltage, estimate, way)?;
    }
    Ok(vec![Found::number(KEY, estimate, unit)])
}

const KEY: &str = "motor.newton_or_newton_metre_per_a";

fn unit_of(joint: &Joint) -> &'static str {
    if joint.lever == 1.0 { "N/A" } else { "N·m/A" }
}

/// The constant for a force per full duty at the hand.
fn per_ampere(newton_per_duty: Estimate, settings: &Settings, joint: &Joint) -> (Estimate, &'static str) {
    (newton_per_duty.times(joint.lever.abs() / settings.motor.full_scale_a), unit_of(joint))
}

/// Finds the constant of joint `number`'s motor with a force gauge, which the person reads.
fn gauge(board: &mut dyn Board, person: &mut dyn Person, number: u32) -> Result<(Estimate, &'static str), Error> {
    let settings = settings(board)?;
    let joint = Joint::of(&settings, number)?;
    let most = settings.probe.max_duty.min(settings.motor.max_duty);
    person.please(&Task::Gauge { joint: number })?;
    let mut points = Vec::new();
    for step in 1..=4 {
        let duty = most * f64::from(step) / 4.0;
        let pushed = run(board, number, &format!("probe {number} pulse {duty:.4} {}", settings.probe.max_s))?;
        cohold_sim::refuse_if!(pushed.end != End::Done, "the joint gave way: hold it against the gauge all the time");
        points.push((
            duty,
            person.reading(&format!("the force that the gauge showed at {:.1} % of full duty, N", 100.0 * duty))?,
        ));
    }
    Ok(per_ampere(slope(&points)?, &settings, &joint))
}

/// Finds it with a mass, kg, that the person fastens to the hand.
fn mass(
    board: &mut dyn Board,
    person: &mut dyn Person,
    number: u32,
    kilograms: f64,
) -> Result<(Estimate, &'static str), Error> {
    if !(kilograms > 0.0 && kilograms <= 100.0) {
        let allowed = "it must be above 0 and up to 100";
        return Err(cohold_sim::Error::not_allowed(format!("an added mass of {kilograms} kg"), allowed).into());
    }
    person.please(&Task::LetGo { joint: number })?;
    let (alone, joint, settings) = motion::identify(board, number)?;
    person.please(&Task::Fasten { joint: number, kilograms })?;
    let (loaded, ..) = motion::identify(board, number)?;
    let (difference, within) = (loaded.mass.value - alone.mass.value, loaded.mass.within.hypot(alone.mass.within));
    cohold_sim::refuse_if!(
        difference <= 0.0 || within > 0.2 * difference,
        "the added mass shows as {} of {} of what moves: fasten it well, or take a larger one",
        Estimate::new(difference / loaded.mass.value, within / loaded.mass.value),
        1.0
    );
    let newton_per_duty = kilograms / difference;
    let estimate = Estimate::new(newton_per_duty, newton_per_duty * within / difference);
    Ok(per_ampere(estimate, &settings, &joint))
}

/// Checks joint `number` before arming, on a board that may still have it wrong, and gives `motor.reversed` as it should be. The
/// encoder's own sign comes first ([`super::counts`]): it says which way the axis points.
///
/// # Errors
/// The board refused the probe, or motor and encoder do not agree on a sign.
pub fn sign(board: &mut dyn Board, number: u32) -> Result<Vec<Found>, Error> {
    let reversed = settings(board)?.motor.reversed;
    say(board, &format!("check {number}"))?;
    let mut outcome = probed(board)?;
    // A check takes 0.4 s at the most.
    for _ in 0..20 {
        board.ticks(0.05)?;
        outcome = probed(board)?;
        if !outcome.is_running() {
            break;
        }
    }
    match outcome.verdict {
        // What else stands against arming is found and set after the signs.
        Some(Verdict::Agree | Verdict::Winding | Verdict::Scale) => Ok(vec![Found::flag("motor.reversed", reversed)]),
        Some(Verdict::Disagree) => Ok(vec![Found::flag("motor.reversed", !reversed)]),
        // How it ended, and what that means.
        _ => {
            let said = outcome.to_string();
            Err(said.split_once(": ").map_or(said.as_str(), |(_, why)| why).into())
        }
    }
}
