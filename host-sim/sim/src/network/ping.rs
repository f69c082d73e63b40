//! Round trips that `ping -D` printed, as a trace: half of each, each way. The end that sent them is peer 1.
//!
//! > `[1764150000.123456] 64 bytes from 192.0.2.1: icmp_seq=1 ttl=64 time=12.3 ms`
//!
//! What is not answered is lost in both directions. `-D` has ping print when each answer came, which tells how often it asked.

use super::measured::{Measured, RoundTrip};

/// Most numbers of one log, answered or not: 1000 a second for an hour, as `network measure` asks at the most.
const MOST: usize = 3_600_000;

/// An answer.
#[derive(Clone, Copy, Debug)]
struct Answer {
    /// As counted since the first one.
    number: usize,
    /// When it was asked, s.
    asked_s: f64,
    round_trip_s: f64,
}

/// Whether these are lines of ping.
pub(super) fn is(text: &str) -> bool {
    text.starts_with("PING ") || text.starts_with('[')
}

/// Reads what ping printed.
///
/// # Errors
/// What is missing or wrong, in one sentence.
pub(super) fn read(text: &str) -> Result<Measured, String> {
    let mut answers: Vec<Answer> = Vec::new();
    let mut last: Option<(u16, usize)> = None;
    for (at, line) in text.lines().enumerate().filter(|(_, line)| line.contains(" time=") && !line.contains("DUP!")) {
        let wrong = |what: &str| format!("line {}: {what}", at + 1);
        let number_after = |key: &str| {
            let (_, rest) = line.split_once(key)?;
            rest.split([' ', ']']).next()?.parse::<f64>().ok()
        };
        let came_s = line.starts_with('[').then(|| number_after("[")).flatten();
        let came_s = came_s.ok_or_else(|| wrong("it does not begin with the time in brackets: ping needs -D"))?;
        let (Some(sequence), Some(ms)) = (number_after(" icmp_seq="), number_after(" time=")) else {
            return Err(wrong("icmp_seq and time must be numbers"));
        };
        // Numbers have 16 bits, and answers may overtake each other.
        let sequence = sequence as u16;
        let (before, counted) = *last.get_or_insert((sequence, 0));
        let further = isize::from(sequence.wrapping_sub(before).cast_signed());
        // What was asked before the first answer of the log, and came after it, is left out.
        let Some(number) = counted.checked_add_signed(further) else { continue };
        if number >= MOST {
            return Err(wrong(&format!("it is more than {MOST} numbers after the first")));
        }
        last = Some((sequence, number));
        answers.push(Answer { number, asked_s: came_s - 1e-3 * ms, round_trip_s: 1e-3 * ms });
    }
    answers.sort_by_key(|answer| answer.number);
    let mut every: Vec<f64> = answers
        .windows(2)
        .filter(|two| two[1].number > two[0].number)
        .map(|two| (two[1].asked_s - two[0].asked_s) / (two[1].number - two[0].number) as f64)
        .collect();
    every.sort_by(f64::total_cmp);
    let every_s = every.get(every.len() / 2).filter(|every_s| (1e-6..1e4).contains(*every_s));
    let every_s = every_s.ok_or("at least two answers of different times are needed")?;
    let lost = RoundTrip { lost: [true; 2], delay_ns: None };
    let mut trips = vec![lost; answers.last().map_or(0, |last| last.number + 1)];
    for Answer { number, round_trip_s, .. } in &answers {
        let half_ns = (0.5e9 * round_trip_s).round() as i64;
        trips[*number] = RoundTrip { lost: [false; 2], delay_ns: Some([half_ns; 2]) };
    }
    Measured::of((1e9 * every_s).round() as u64, &trips).map_err(|(_, what)| what.to_owned())
}
