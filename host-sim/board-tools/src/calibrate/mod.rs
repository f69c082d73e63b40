//! Calibration: what a person and a board find out together about a device, and leave in a settings file.
//!
//! Counts and their sign by a known distance, moved by hand; a motor's sign by a weak push both ways, its constant by a force gauge
//! or a mass that is added; friction, mass and delay by least squares on how a joint moves under cosines of force. On a board with a
//! current loop also resistance, inductance and the sensor's zero, and the motor's constant once more, by the voltage that it makes.
//!
//! Every number comes with an interval that holds it in about 19 of 20 calibrations, as far as noise goes; one that the
//! data do not give is refused, with what to do about it.

pub mod board;
pub mod counts;
pub mod emf;
mod least_squares;
pub mod motion;
pub mod motor;
pub mod settings_file;
pub mod simulated;
pub mod winding;

use cohold_sim::student::student_95;

use crate::Error;

/// A number with the half width of its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Estimate {
    /// Estimated value, in the unit of what was estimated.
    pub value: f64,
    /// Half the width of the interval that holds the true one in 19 of 20 calibrations.
    pub within: f64,
}

impl Estimate {
    /// This value, to within so much.
    pub fn new(value: f64, within: f64) -> Self {
        Self { value, within }
    }

    /// The mean of as many values that were found independently, two or more, with Student's interval.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let value = values.iter().sum::<f64>() / count;
        let squares: f64 = values.iter().map(|one| (one - value).powi(2)).sum();
        Self { value, within: student_95(values.len() as u32 - 1) * (squares / (count - 1.0) / count).sqrt() }
    }

    /// The estimate in another unit, `factor` times as large.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { value: self.value * factor, within: self.within * factor.abs() }
    }
}

impl std::fmt::Display for Estimate {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = |number: f64| cohold_report::significant(number, 4);
        write!(f, "{} ± {}", digits(self.value), digits(self.within))
    }
}

/// What a calibration found: a key of the settings file and its value, as TOML.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Found {
    /// Name of the key, `table.key`.
    pub key: &'static str,
    /// Value of the key, in its unit.
    pub value: toml::Value,
    /// Interval and circumstances, for a person.
    pub said: String,
}

impl Found {
    /// A number with its interval; `unit` is for the person.
    pub fn number(key: &'static str, estimate: Estimate, unit: &str) -> Self {
        // Six digits are more than any calibration gives, and no rounding shows in them.
        let value = format!("{:.6e}", estimate.value).parse().unwrap_or(estimate.value);
        Self { key, value: toml::Value::Float(value), said: format!("{estimate} {unit}").trim_end().to_owned() }
    }

    /// A switch that was found to be on or off.
    pub fn flag(key: &'static str, value: bool) -> Self {
        Self { key, value: toml::Value::Boolean(value), said: value.to_string() }
    }
}

/// What a person is asked to do.
#[derive(Clone, Copy, Debug, PartialEq)]
#[allow(missing_docs, reason = "the sentences say it")]
pub enum Task {
    HoldStill { joint: u32 },
    MoveMetres { joint: u32, metres: f64 },
    Turn { joint: u32, revolutions: f64 },
    Gauge { joint: u32 },
    LetGo { joint: u32 },
    PassIndex { joint: u32 },
    Fasten { joint: u32, kilograms: f64 },
    Unfasten { joint: u32 },
    SeeLight,
    HoldButton,
    LetGoOfButton,
    Push { joint: u32, metres: f64 },
    PressStop,
    ReleaseStop,
    PullCable,
    PlugCable,
}

impl std::fmt::Display for Task {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::HoldStill { joint } => write!(f, "hold joint {joint} still at the first mark"),
            Self::MoveMetres { joint, metres } => {
                write!(f, "move joint {joint} by {metres} m the way its axis points, and hold it still there")
            }
            Self::Turn { joint, revolutions } => write!(
                f,
                "turn the motor of joint {joint} by {revolutions} revolutions the way its axis points, and hold it still there"
            ),
            Self::Gauge { joint } => {
                write!(f, "hold joint {joint} against the gauge, so that a push along the axis presses on it")
            }
            Self::LetGo { joint } => write!(f, "let go of joint {joint}, with room to both sides"),
            Self::PassIndex { joint } => {
                write!(f, "move joint {joint} to and fro past its index, and let go of it with room to both sides")
            }
            Self::Fasten { joint, kilograms } => {
                write!(f, "fasten {kilograms} kg to the hand of joint {joint}, and let go of it")
            }
            Self::Unfasten { joint } => write!(f, "take the mass off the hand of joint {joint} again"),
            Self::SeeLight => write!(f, "see that the board's green light blinks and its red one is off"),
            Self::HoldButton => write!(f, "hold the board's blue button down"),
            Self::LetGoOfButton => write!(f, "let go of the blue button"),
            Self::Push { joint, metres } => {
                write!(
                    f,
                    "push joint {joint} gently by {metres} m along its axis, against the object that you will feel, and stay there"
                )
            }
            Self::PressStop => write!(f, "press the emergency stop, and leave it pressed"),
            Self::ReleaseStop => write!(f, "release the emergency stop"),
            Self::PullCable => write!(f, "pull the board's network cable"),
            Self::PlugCable => write!(f, "put the network cable back, and wait until its lights are on"),
        }
    }
}

/// The person at the device.
pub trait Person {
    /// Asks for something to be done, and comes back when it is.
    fn please(&mut self, task: &Task) -> Result<(), Error>;

    /// Asks for something to be done while a board has to be kept: comes back at once.
    fn begin(&mut self, task: &Task) -> Result<(), Error> {
        self.please(task)
    }

    /// Whether what was asked for is done.
    fn is_done(&mut self) -> Result<bool, Error> {
        Ok(true)
    }

    /// Asks for a number.
    fn reading(&mut self, what: &str) -> Result<f64, Error>;
}
