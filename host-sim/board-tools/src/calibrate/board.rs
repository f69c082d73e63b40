//! What a calibration needs of a board: a line and its answer, what its ticks saw, and the settings it has.
//!
//! Lines are those of firmware/src/operator.rs.

use cohold_core::device::probe::End;
use cohold_core::device::stage::Measured;
use cohold_core::settings::{Choice, Settings, Value};
use cohold_core::{device::AXES, device::kinematics::KinematicsName, num::Motion};
use cohold_protocol::record::Record;

use crate::Error;
use crate::status::Probed;

/// One tick of a board, as far as a calibration needs it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tick {
    /// Ticks since the board started.
    pub number: u32,
    /// 0 disarmed, 1 armed, 2 faulted, 3 probing.
    pub mode: u8,
    /// Encoder counts that it read.
    pub counts: [u16; AXES],
    /// Duties that it commanded, 1/32767 of full scale.
    pub duties: [i16; AXES],
    /// Where the first axis was, m in the shared world.
    pub at_m: f32,
    /// What the power stage measured since the tick before; none without a current loop.
    pub stage: Option<Measured>,
}

/// [`Tick::mode`] of a probe under way.
pub const PROBING: u8 = 3;
/// [`Tick::mode`] after a fault.
pub const FAULTED: u8 = 2;

impl Tick {
    /// A tick from its record.
    pub fn from_record(record: &[u8]) -> Option<Self> {
        let record = Record::from_bytes(record)?;
        Some(Self {
            number: record.tick(),
            mode: record.of_peer().mode,
            counts: record.counts().map(|counts| counts.0),
            duties: record.duties().map(|duty| duty.0),
            at_m: record.observed().device.position,
            stage: record.stage(),
        })
    }
}

/// A board, or what stands for one.
pub trait Board {
    /// Says a line and gives the answer, which begins with `ok` or `error`.
    fn ask(&mut self, line: &str) -> Result<String, Error>;

    /// Lets so much time pass, and gives the ticks that came since the last time.
    fn ticks(&mut self, seconds: f64) -> Result<Vec<Tick>, Error>;
}

/// Sends a line that must be answered with `ok`, and gives what follows it.
///
/// # Errors
/// The board's refusal, or its silence.
pub fn say(board: &mut dyn Board, line: &str) -> Result<String, Error> {
    let answer = board.ask(line)?;
    match answer.strip_prefix("ok") {
        Some(rest) => Ok(rest.trim_start().to_owned()),
        None => Err(Error::Answer { line: line.to_owned(), answer }),
    }
}

/// The outcome of the board's last probe.
///
/// # Errors
/// No answer, or one that cannot be read.
pub fn probed(board: &mut dyn Board) -> Result<Probed, Error> {
    Probed::parse(&say(board, "probed")?)
}

/// The value of a key on the board, as text.
///
/// # Errors
/// No answer, or a key that the board does not know.
pub fn get(board: &mut dyn Board, key: &str) -> Result<String, Error> {
    let answer = say(board, &format!("get {key}"))?;
    Ok(answer.split_once('=').map_or(answer.as_str(), |(_, value)| value).trim().trim_matches('"').to_owned())
}

/// The settings that a calibration depends on, as the board has them.
///
/// # Errors
/// No answer, or a value that the key does not accept.
pub fn settings(board: &mut dyn Board) -> Result<Settings, Error> {
    const TABLES: [&str; 7] = ["timing.", "axis.", "encoder.", "kinematics.", "scale.", "motor.", "probe."];
    let mut settings = Settings::default();
    for key in Settings::keys().filter(|key| TABLES.iter().any(|table| key.name.starts_with(table))) {
        take(board, &mut settings, key.name)?;
    }
    Ok(settings)
}

/// Takes over the value that a key has on the board.
///
/// # Errors
/// No answer, or a value that the key does not accept.
pub fn take(board: &mut dyn Board, settings: &mut Settings, key: &str) -> Result<(), Error> {
    let text = get(board, key)?;
    settings
        .set(key, Value::of_text(&text))
        .map_err(|_| format!("the board has {key} = {text}, which is not allowed").into())
}

/// How one joint of a device is configured, and what one count of it is worth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Joint {
    /// Number of the joint, 1 or 2.
    pub number: u32,
    /// Metres of the hand for a count along the joint, near where it stands; negative where counts grow against the axis.
    pub m_per_count: f64,
    /// Metres of the hand for a metre, or a radian, of the joint.
    pub lever: f64,
    /// Control period of the board, s.
    pub period_s: f64,
}

impl Joint {
    /// Joint `number` of the device that the settings describe.
    ///
    /// # Errors
    /// A joint that the device does not have.
    pub fn of(settings: &Settings, number: u32) -> Result<Self, Error> {
        if !(1..=settings.axis.count).contains(&number) {
            let allowed = format!("axis.count is {}", settings.axis.count);
            return Err(cohold_sim::Error::not_allowed(format!("joint {number}"), allowed).into());
        }
        let (encoder, kinematics) = (&settings.encoder, &settings.kinematics);
        let counts_per_unit = match kinematics.model {
            KinematicsName::Direct => encoder.counts_per_m,
            KinematicsName::Capstan => encoder.counts_per_rev / std::f64::consts::TAU,
            model @ (KinematicsName::FiveBar | KinematicsName::Arm) => {
                return Err(format!(
                    "kinematics.model = \"{}\" is not allowed here: what one joint moves depends on the pose; `calibrate sign` \
                     works, the rest is for \"direct\" and \"capstan\"",
                    model.name()
                ).into());
            }
        };
        let model = cohold_core::device::kinematics::AnyKinematics::<f64>::build(settings)?;
        let lever = model.forward([Motion::REST; AXES]).jacobian[number as usize - 1][number as usize - 1];
        let sign = if encoder.reversed { -1.0 } else { 1.0 };
        Ok(Self {
            number,
            m_per_count: sign * lever / counts_per_unit,
            lever,
            period_s: settings.timing.control_period_s,
        })
    }
}

/// One joint during a probe: where it was at every tick (counts from the first), and the duty from then on (of full scale).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Where the first axis was when it began, m in the shared world.
    pub start_m: f64,
    /// Counts from where it began.
    pub counts: Vec<f64>,
    /// Duties, fractions of full scale, as they go to the bridge.
    pub duties: Vec<f64>,
    /// What the power stage measured since the tick before; empty without a current loop.
    pub stage: Vec<Measured>,
    /// How the probe ended.
    pub end: End,
}

/// What a line's probe of a joint gives, tick by tick.
///
/// # Errors
/// The board refused the probe, fell silent, or lost records.
pub fn run(board: &mut dyn Board, joint: u32, line: &str) -> Result<Run, Error> {
    say(board, "stream 1")?;
    let outcome = record(board, line);
    say(board, "stream off")?;
    let ticks = outcome?;
    let end = probed(board)?.end;
    let at = joint as usize - 1;
    let start_m = ticks.first().map_or(0.0, |tick| tick.at_m.into());
    let mut run = Run { end, start_m, ..Run::default() };
    let mut last: Option<Tick> = None;
    let mut total = 0.0;
    for tick in ticks {
        if let Some(last) = last {
            cohold_sim::refuse_if!(
                tick.number.wrapping_sub(last.number) != 1,
                "ticks {} to {} got lost on the way: try again",
                last.number,
                tick.number
            );
            total += f64::from(tick.counts[at].wrapping_sub(last.counts[at]).cast_signed());
        }
        run.counts.push(total);
        run.duties.push(f64::from(tick.duties[at]) / 32767.0);
        run.stage.extend(tick.stage);
        last = Some(tick);
    }
    Ok(run)
}

/// The newest tick.
///
/// # Errors
/// No answer, or no tick.
pub fn seen(board: &mut dyn Board) -> Result<Tick, Error> {
    board.ticks(0.0)?;
    say(board, "stream 1")?;
    let ticks = board.ticks(0.05)?;
    say(board, "stream off")?;
    ticks.last().copied().ok_or_else(|| "no tick came from the board".into())
}

/// The ticks of a probe, with the one after it.
fn record(board: &mut dyn Board, line: &str) -> Result<Vec<Tick>, Error> {
    /// Longer than any probe.
    const PATIENCE_S: f64 = 15.0;
    const LOOK_S: f64 = 0.05;
    board.ticks(0.0)?;
    say(board, line)?;
    let mut ticks: Vec<Tick> = Vec::new();
    let (mut waited_s, mut over) = (0.0, false);
    while waited_s < PATIENCE_S {
        for tick in board.ticks(LOOK_S)? {
            let begun = !ticks.is_empty();
            match tick.mode {
                PROBING => ticks.push(tick),
                FAULTED => {
                    return Err(format!("the board stopped with a fault during {line:?}: `status` says which").into());
                }
                _ if begun => {
                    ticks.push(tick);
                    return Ok(ticks);
                }
                _ => {}
            }
        }
        waited_s += LOOK_S;
        // One that ended at its first tick leaves none; what is still on its way has come by the next look.
        if ticks.is_empty() {
            if over {
                return Ok(ticks);
            }
            over = !probed(board)?.is_running();
        }
    }
    Err(format!("no ticks of {line:?} came within {PATIENCE_S} s").into())
}
