//! `cohold board calibrate`: a person, a board and its device find each other's numbers; one command a quantity.
//!
//! In this order, each into the same settings file: counts, winding, sign, motor, friction, cogging, inertia. What is found is given to the board at
//! once, until power goes off; `cohold board operator … save` keeps it.

use std::io::{BufRead, IsTerminal};
use std::sync::mpsc::{Receiver, TryRecvError};
use std::{net::SocketAddr, path::PathBuf};

use clap::{Args, Subcommand};
use cohold_board_tools::Error;
use cohold_board_tools::calibrate::{Found, Person, Task, motion, settings_file};
use cohold_board_tools::{calibrate::board::Board, calibrate::simulated::SharedSimulation};
use cohold_board_tools::{calibrate::counts, calibrate::counts::Distance};
use cohold_board_tools::{calibrate::motor, calibrate::motor::Against};
use cohold_board_tools::{calibrate::winding, calibrate::winding::Sheet};
use cohold_live::operator::Operator;

use super::operator;
use crate::flags::number;
use crate::{Failure, SceneArgs, Ui};

#[derive(Debug, Subcommand)]
pub(crate) enum Calibrate {
    /// Counts per metre (or revolution) and sign of an encoder: you move the joint by a known distance.
    Counts {
        #[command(flatten)]
        at: At,
        #[command(flatten)]
        by: By,
    },
    /// Resistance and inductance of a motor's winding and the zero of its current's sensor, by small voltages to and fro: boards with a
    /// current loop. Before `sign`, which closes it; what the data sheet says is given to the board first.
    Winding {
        #[command(flatten)]
        at: At,
        #[command(flatten)]
        sheet: DataSheet,
    },
    /// Sign of a motor: a weak push both ways. After `counts`, and `winding`.
    Sign(At),
    /// Motor constant, against a force gauge that you read, with a known mass that you fasten, or by the voltage that the motor makes by
    /// moving, which is held against the other two as well. After `sign`.
    Motor {
        #[command(flatten)]
        at: At,
        #[command(flatten)]
        reference: Reference,
    },
    /// Viscous and dry friction, from how the joint moves. After `motor`.
    Friction(At),
    /// Amplitude and place of a motor's cogging, from how the joint moves, with an encoder that has an index. After `motor`; its period,
    /// motor.cogging_period_m_or_rad, is of a motor a turn over the least common multiple of poles and slots.
    Cogging(At),
    /// Moving mass and delay of the force, from how the joint moves. After `motor`.
    Inertia(At),
}

/// How far a joint is moved by hand.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct By {
    /// By how much you will move it, m: a slide.
    #[arg(long, value_name = "M")]
    distance_m: Option<f64>,
    /// By how much you will turn its motor: a joint that turns.
    #[arg(long, value_name = "N", conflicts_with = "distance_m")]
    revolutions: Option<f64>,
}

impl By {
    pub(super) fn distance(self) -> Result<Distance, Failure> {
        match (self.distance_m, self.revolutions) {
            (Some(metres), _) => Ok(Distance::Metres(metres)),
            (_, Some(turns)) => Ok(Distance::Revolutions(turns)),
            _ => Err("give --distance-m or --revolutions: how far you will move the joint".into()),
        }
    }
}

/// What a motor is measured against.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct Reference {
    /// A force gauge.
    #[arg(long)]
    gauge: bool,
    /// A mass, kg.
    #[arg(long, value_name = "KG", conflicts_with = "gauge")]
    added_mass_kg: Option<f64>,
    /// The voltage that it makes by moving: boards with a current loop.
    #[arg(long, conflicts_with_all = ["gauge", "added_mass_kg"])]
    emf: bool,
    /// The data sheet's constant, N/A or N·m/A, which that must not contradict.
    #[arg(long, value_name = "N", requires = "emf", value_parser = number(1e-4..=1e3, "N/A or N·m/A"))]
    newton_or_newton_metre_per_a: Option<f64>,
}

impl Reference {
    pub(super) fn against(self) -> Result<Against, Failure> {
        match (self.gauge, self.added_mass_kg, self.emf) {
            (true, ..) => Ok(Against::Gauge),
            (_, Some(kilograms), _) => Ok(Against::Mass(kilograms)),
            (.., true) => Ok(Against::Emf(self.newton_or_newton_metre_per_a)),
            _ => Err("give --gauge, --added-mass-kg or --emf: what the motor is measured against".into()),
        }
    }
}

/// What a motor's data sheet says.
#[derive(Clone, Copy, Debug, Args)]
pub(crate) struct DataSheet {
    /// The data sheet's resistance: the board's current loop is set by it until the winding is measured, and another one is refused.
    #[arg(long, value_name = "OHM", value_parser = number(0.001..=1e4, "Ω"))]
    resistance_ohm: Option<f64>,
    /// The data sheet's inductance, likewise.
    #[arg(long, value_name = "H", value_parser = number(1e-6..=10.0, "H"))]
    inductance_h: Option<f64>,
    /// How far off either may be, as a share of it.
    #[arg(long, default_value_t = 0.3, value_name = "SHARE", value_parser = number(0.01..=1.0, ""))]
    tolerance: f64,
}

impl DataSheet {
    pub(super) fn sheet(self) -> Sheet {
        let Self { resistance_ohm, inductance_h, tolerance } = self;
        Sheet { resistance_ohm, inductance_h, tolerance }
    }
}

/// Which joint of which board, and where the result goes.
#[derive(Clone, Debug, Args)]
pub(crate) struct At {
    /// The board's address; its port is 7702 unless another is given. Or `simulated`: a software device, to practise.
    #[arg(long, value_name = "ADDRESS[:PORT]")]
    board: String,
    /// The operator's key file that the board was provisioned with (`cohold key generate --operator`).
    #[arg(long, value_name = "FILE")]
    key_file: Option<PathBuf>,
    /// Which joint, 1 or 2.
    #[arg(long, default_value_t = 1, value_name = "N")]
    pub(super) joint: u32,
    /// Settings file: what it holds is given to the board first, what is found is added to it.
    #[arg(long, alias = "out", value_name = "FILE")]
    pub(super) settings: PathBuf,
    #[command(flatten)]
    truth: SceneArgs,
}

/// Asks on standard error, hears on standard input.
#[derive(Default)]
struct Terminal {
    /// What is typed, if something was asked for.
    typed: Option<Receiver<Result<String, Error>>>,
}

impl Terminal {
    fn line() -> Result<String, Error> {
        let mut line = String::new();
        match std::io::stdin().lock().read_line(&mut line) {
            Ok(0) => Err("standard input has ended: somebody has to be at the device".into()),
            Ok(_) => Ok(line.trim().to_owned()),
            Err(cause) => Err(cohold_sim::Error::cannot("read", &"standard input")(cause).into()),
        }
    }
}

impl Person for Terminal {
    fn please(&mut self, task: &Task) -> Result<(), Error> {
        cohold_io::say(format_args!("{task}; then press Enter"));
        Self::line().map(|_| ())
    }

    fn begin(&mut self, task: &Task) -> Result<(), Error> {
        cohold_io::say(format_args!("{task}; then press Enter"));
        let (say, typed) = std::sync::mpsc::channel();
        self.typed = Some(typed);
        std::thread::spawn(move || say.send(Self::line()));
        Ok(())
    }

    fn is_done(&mut self) -> Result<bool, Error> {
        let Some(typed) = &self.typed else { return Ok(true) };
        match typed.try_recv() {
            Ok(line) => {
                self.typed = None;
                line.map(|_| true)
            }
            Err(TryRecvError::Empty) => Ok(false),
            Err(TryRecvError::Disconnected) => Err("nobody reads standard input any more".into()),
        }
    }

    fn reading(&mut self, what: &str) -> Result<f64, Error> {
        cohold_io::say(format_args!("{what}:"));
        let line = Self::line()?;
        let number: Option<f64> = line.parse().ok();
        number.filter(|number| number.is_finite()).ok_or_else(|| format!("{line:?} is no number").into())
    }
}

type Parties = (Box<dyn Board>, Box<dyn Person>);

impl At {
    pub(super) fn parties(&self, ui: &Ui) -> Result<Parties, Failure> {
        let truth = self.truth.load_of_one_axis(ui)?;
        if self.board == "simulated" {
            let simulation = SharedSimulation::new(&truth)?;
            return Ok((Box::new(simulation.clone()), Box::new(simulation)));
        }
        if self.truth.is_given() {
            return Err(
                "--scene and --set describe the device of --board simulated; a real one describes itself".into()
            );
        }
        let address: SocketAddr = operator::address(&self.board)?;
        let key_file = self
            .key_file
            .as_ref()
            .ok_or("--key-file is missing: the operator's, that the board was provisioned with")?;
        if std::io::stdin().is_terminal() {
            cohold_io::say("motors will move: keep the emergency stop at hand");
        }
        Ok((Box::new(Operator::connect(address, key_file)?), Box::<Terminal>::default()))
    }

    fn run(
        &self,
        ui: &Ui,
        find: impl FnOnce(&mut dyn Board, &mut dyn Person) -> Result<Vec<Found>, Error>,
    ) -> Result<(), Failure> {
        let (mut board, mut person) = self.parties(ui)?;
        if self.settings.exists() {
            settings_file::give(&mut *board, &self.settings)?;
        }
        let found = find(&mut *board, &mut *person)?;
        settings_file::add(&self.settings, &found)?;
        settings_file::give(&mut *board, &self.settings)?;
        ui.report("", &found)?;
        writeln!(ui, "added to {}", self.settings.display());
        Ok(())
    }
}

impl Calibrate {
    pub(super) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        match self {
            Self::Counts { at, by } => {
                let distance = by.distance()?;
                at.run(ui, |board, person| counts::calibrate(board, person, at.joint, distance))
            }
            Self::Sign(at) => at.run(ui, |board, _| motor::sign(board, at.joint)),
            Self::Winding { at, sheet } => at.run(ui, |board, person| {
                if let Some(found) = sheet.sheet().found() {
                    settings_file::add(&at.settings, &found)?;
                    person.please(&Task::HoldButton)?;
                    settings_file::give(board, &at.settings)?;
                    person.please(&Task::LetGoOfButton)?;
                }
                winding::winding(board, at.joint, sheet.sheet())?
                    .ok_or_else(|| "this board has no current loop: nothing measures the current".into())
            }),
            Self::Motor { at, reference } => {
                let against = reference.against()?;
                at.run(ui, |board, person| motor::constant(board, person, at.joint, against))
            }
            Self::Friction(at) => at.run(ui, |board, _| motion::friction(board, at.joint)),
            Self::Cogging(at) => at.run(ui, |board, person| motion::cogging(board, person, at.joint)),
            Self::Inertia(at) => at.run(ui, |board, _| motion::inertia(board, at.joint)),
        }
    }
}
