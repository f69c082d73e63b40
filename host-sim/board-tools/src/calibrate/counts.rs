//! Counts per metre (or revolution) and the sign of an encoder: a person moves the joint by a known distance along its axis.
//!
//! Both marks are taken as the mean over a fifth of a second in which the joint must stand still. What is not in the
//! interval: how well the person meets the marks. For a relative error e of the scale they must be met to e times the distance.

use cohold_core::device::kinematics::KinematicsName;

use super::board::{Board, Joint, Tick, say, settings};
use super::{Estimate, Found, Person, Task};
use crate::Error;

/// By how much the joint is to be moved.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Distance {
    /// A slide's distance, m.
    Metres(f64),
    /// Revolutions of a joint that turns.
    Revolutions(f64),
}

/// Ticks between two records: motion of less than half a turn of the counter in between.
const EVERY: u32 = 10;
/// Fewest counts that make a scale.
const FEWEST: f64 = 200.0;
/// A joint that moves by more than this is not standing, counts.
const RESTING: f64 = 4.0;

/// Counts and sign, from what the two marks differ by.
///
/// # Errors
/// Too few counts for the distance, or marks that scatter too much.
pub fn scale(moved_counts: f64, spread_counts: f64, distance: Distance) -> Result<Vec<Found>, Error> {
    cohold_sim::refuse_if!(
        moved_counts.abs() < FEWEST,
        "the encoder counted {moved_counts:.0}: too few for a scale, it must be at least {FEWEST:.0}; move it further, \
             or look at its wiring"
    );
    let (key, unit, length) = match distance {
        Distance::Metres(metres) => ("encoder.counts_per_m", "counts/m", metres),
        Distance::Revolutions(turns) => ("encoder.counts_per_rev", "counts/rev", turns),
    };
    let estimate = Estimate::new(moved_counts.abs(), spread_counts.max(1.0)).times(1.0 / length);
    Ok(vec![Found::number(key, estimate, unit), Found::flag("encoder.reversed", moved_counts < 0.0)])
}

/// Mean position and spread of a joint at rest, in counts from `from`, and the last tick.
fn rest(board: &mut dyn Board, at: usize, last: &mut Option<Tick>, total: &mut f64) -> Result<(f64, f64), Error> {
    follow(board.ticks(0.05)?, at, last, total, |_| ())?;
    let mut seen = Vec::new();
    follow(board.ticks(0.2)?, at, last, total, |total| seen.push(total))?;
    let (low, high) = seen.iter().fold((f64::MAX, f64::MIN), |(low, high), &at| (at.min(low), at.max(high)));
    cohold_sim::refuse_if!(seen.len() < 5, "the board's ticks do not come: is something else listening to it?");
    cohold_sim::refuse_if!(high - low > RESTING, "it moved by {:.0} counts at a mark: hold it still there", high - low);
    Ok((seen.iter().sum::<f64>() / seen.len() as f64, high - low))
}

/// Adds up the counts of a stream.
fn follow(
    ticks: Vec<Tick>,
    at: usize,
    last: &mut Option<Tick>,
    total: &mut f64,
    mut each: impl FnMut(f64),
) -> Result<(), Error> {
    for tick in ticks {
        if let Some(last) = last {
            cohold_sim::refuse_if!(
                tick.number.wrapping_sub(last.number) != EVERY,
                "ticks got lost on the way: try again, and do not take longer than 20 s"
            );
            *total += f64::from(tick.counts[at].wrapping_sub(last.counts[at]).cast_signed());
        }
        *last = Some(tick);
        each(*total);
    }
    Ok(())
}

/// Asks the person to move joint `number`, and gives its scale.
///
/// # Errors
/// The board refused, the person gave up, or the scale cannot be distinguished from the marks.
pub fn calibrate(
    board: &mut dyn Board,
    person: &mut dyn Person,
    number: u32,
    distance: Distance,
) -> Result<Vec<Found>, Error> {
    let (length, turn, task) = match distance {
        Distance::Metres(metres) => (metres, false, Task::MoveMetres { joint: number, metres }),
        Distance::Revolutions(revolutions) => (revolutions, true, Task::Turn { joint: number, revolutions }),
    };
    if !(length > 0.0 && length <= 100.0) {
        let allowed = "it must be above 0 and up to 100";
        return Err(cohold_sim::Error::not_allowed(format!("a distance of {length}"), allowed).into());
    }
    let settings = settings(board)?;
    let turns = settings.kinematics.model != KinematicsName::Direct;
    if !turns {
        Joint::of(&settings, number)?;
    }
    match (turns, turn) {
        (true, false) => return Err("this joint turns: say by how many revolutions, not by what distance".into()),
        (false, true) => {
            return Err("this joint is a slide: say by what distance, not by how many revolutions".into());
        }
        _ => {}
    }
    person.please(&Task::HoldStill { joint: number })?;
    board.ticks(0.0)?;
    say(board, &format!("stream {EVERY}"))?;
    let outcome = (|| {
        let (at, mut last, mut total) = (number as usize - 1, None, 0.0);
        let (start, first) = rest(board, at, &mut last, &mut total)?;
        person.please(&task)?;
        let (end, second) = rest(board, at, &mut last, &mut total)?;
        scale(end - start, first.max(second), distance)
    })();
    say(board, "stream off")?;
    outcome
}
