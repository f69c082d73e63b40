//! Bring-up: one person, one board and its device, from the first light to the first contact; each step checks before it goes on.
//!
//! | step | passes if |
//! |---|---|
//! | light | the board answers, nothing stands against it, and its ticks come one after the other |
//! | emergency stop | pressed, each of its contacts is seen by its own sign before anything may move: arming is refused (the first), and the supply falls below [`OFF_V`] (the second) |
//! | supply | a voltmeter and the board agree on it, and it is what the settings allow |
//! | encoder | it counts over a known distance, and stands still where the joint does |
//! | winding | by voltages without a loop: resistance and inductance within what the data sheet says, which the loop is set by before anything drives; the sensor's zero, and its sign |
//! | sign | a weak push moves the encoder the way the motor pushes |
//! | motor | newtons per ampere against a gauge or a known mass, and what moves: mass and friction; the voltage that it makes by moving says the same |
//! | lowest force | armed with [`LOWEST_N`] and nobody at it, the joint stays where it is |
//! | first contact | pushed against, the object pushes back, within that force |
//! | stop | pressed while armed, the motors are off, and stay off until they are armed anew |
//! | cable | out for longer than `safety.operator_lost_s`, the motors go off, and the board says why |
//! | time | in all of that no tick began more than [`LATE_US`] late or off its period, or took more than [`LONG_US`] |
//!
//! What is found goes to the settings file and to the board; the limit of force is put back to what it was. A step that does not pass
//! ends it, with what to look at. A board without a current loop passes "winding" with nothing measured, and its supply is what the voltmeter says.

use std::path::Path;

use cohold_core::safety::Mode;
use cohold_core::settings::Settings;

use super::calibrate::board::{self, Board, Joint, Tick, say, settings};
use super::calibrate::counts::{self, Distance};
use super::calibrate::motor::{self, Against};
use super::calibrate::winding::{self, Sheet};
use super::calibrate::{Found, Person, Task, motion, settings_file};
use super::operator::UNCONFIRMED;
use super::status::Status;
use crate::Error;

/// The limit of force of the steps in which the board is armed, N.
pub const LOWEST_N: f64 = 0.5;
/// Supply below which no bridge drives, V: the lock-out of bridges for 12 V and more.
pub const OFF_V: f64 = 4.5;
/// How long the supply may take to get there once it is cut, s, and by when its fall must show, s, as this share.
const FALL_S: f64 = 10.0;
const SHOWS_S: f64 = 1.0;
const SHOWS: f64 = 0.95;
/// A board's tick, s; of one that is faster the winding's step refuses.
const TICK_S: f64 = 1e-3;
/// How long it may take to come back, s.
const RISE_S: f64 = 5.0;
/// What the board may read beside a voltmeter: divider and converter, of the voltage.
const METER: f64 = 0.05;
/// What a person reads the supply by.
pub const VOLTMETER: &str = "what a voltmeter shows across the supply of the motors, at the bridges, V";
/// How far a joint may creep in a second in which nothing should push it, m.
const CREEP_M: f64 = 0.002;
/// How far the hand is pushed into the object, m.
const PUSH_M: f64 = 0.02;
/// Between two looks at whether the person is done, s.
const LOOK_S: f64 = 0.02;
/// How late a tick may begin, and how far from a period two may be apart, µs: a twentieth of the period.
pub const LATE_US: f64 = 50.0;
/// How long a tick may take, µs: half a period.
pub const LONG_US: f64 = 500.0;
/// How long the cable stays out beyond the operator's patience, s.
const OUT_S: f64 = 2.0;

/// What is brought up: a joint, with the settings and measurements that belong to it.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// Number of the joint, 1 or 2.
    pub joint: u32,
    /// By how much the person moves it for its scale.
    pub distance: Distance,
    /// What its motor's data sheet says.
    pub sheet: Sheet,
    /// What its motor is measured against.
    pub against: Against,
    /// Where what is found is kept.
    pub file: &'a Path,
}

/// A step that passed.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Passed {
    /// Name of the step.
    pub step: &'static str,
    /// What was measured, in a sentence.
    pub seen: String,
}

/// The parties, and what they are about.
struct BringUp<'a> {
    board: &'a mut dyn Board,
    person: &'a mut dyn Person,
    plan: Plan<'a>,
}

/// A step: its name, what it does and sees, and what to look at if it does not pass.
type Step<'a> = (&'static str, fn(&mut BringUp<'a>) -> Result<String, Error>, &'static str);

fn steps<'a>() -> [Step<'a>; 12] {
    [
        ("light", BringUp::light, "docs/guides/board/assembly.md, step 1"),
        (
            "emergency stop",
            BringUp::stop_is_seen,
            "the stop's contacts, both normally closed: the first from PE15 to 3.3 V, the second in the supply of the bridges, and 2.2 kΩ across that",
        ),
        ("supply", BringUp::supply, "the supply of the bridges, and the divider at PB1: 100 kΩ and 10 kΩ"),
        ("encoder", BringUp::encoder, "the encoder's supply and its wires A and B"),
        ("winding", BringUp::winding, "the motor's wires, the current's sensor, and the data sheet"),
        ("sign", BringUp::sign, "the bridge's supply and enable, the motor's wires, and that nothing holds the joint"),
        ("motor", BringUp::motor, "that nothing but the motor moves the joint, and that it moves freely"),
        ("lowest force", BringUp::lowest_force, "what pulls the joint: its weight, a cable, a spring"),
        ("first contact", BringUp::first_contact, "scale and signs of encoder and motor in the settings file"),
        ("stop", BringUp::stop, "the stop's first contact, and do not use the device before it works"),
        ("cable", BringUp::cable, "safety.operator_lost_s, and do not use the device before this works"),
        ("time", BringUp::time, "`time` in docs/guides/board/operate.md, and what the board did in that tick"),
    ]
}

/// Goes through the steps, tells `each` that passes, and gives them all.
///
/// # Errors
/// The first that does not pass: its name, what was seen, what to look at. The board is disarmed then, if it can be reached.
pub fn bring_up(
    board: &mut dyn Board,
    person: &mut dyn Person,
    plan: Plan<'_>,
    mut each: impl FnMut(&Passed),
) -> Result<Vec<Passed>, Error> {
    let mut bring_up = BringUp { board, person, plan };
    let mut passed = Vec::new();
    for (step, run, look_at) in steps() {
        let seen = run(&mut bring_up).map_err(|why| {
            let fault = bring_up.status().ok().and_then(|status| match status.mode {
                Mode::Faulted(fault) => Some(format!("; fault {}: {}", fault.number(), fault.explain())),
                _ => None,
            });
            let off = say(bring_up.board, "disarm").map_or_else(|_| format!("; {UNCONFIRMED}"), |_| String::new());
            format!("{step}: {why}{}; look at {look_at}{off}", fault.unwrap_or_default())
        })?;
        let row = Passed { step, seen };
        each(&row);
        passed.push(row);
    }
    Ok(passed)
}

/// What was found, in a row.
fn listed(found: &[Found]) -> String {
    found.iter().map(|found| format!("{} = {}", found.key, found.said)).collect::<Vec<_>>().join(", ")
}

impl BringUp<'_> {
    fn status(&mut self) -> Result<Status, Error> {
        Status::parse(&say(self.board, "status")?)
    }

    /// The answer to a line that must be refused, for this reason.
    fn refused(&mut self, line: &str, why: &str) -> Result<(), Error> {
        let answer = self.board.ask(line)?;
        if answer.starts_with("error") && answer.contains(why) {
            return Ok(());
        }
        Err(format!("the board answers {line:?} with {answer:?}, and should refuse: {why}").into())
    }

    /// Keeps what was found, gives it to the board, and says it.
    fn keep(&mut self, found: &[Found]) -> Result<String, Error> {
        settings_file::add(self.plan.file, found)?;
        // What a newton and a metre are is set at the board only.
        self.person.please(&Task::HoldButton)?;
        let given = settings_file::give(self.board, self.plan.file);
        self.person.please(&Task::LetGoOfButton)?;
        given.map(|_| listed(found))
    }

    /// Sets a key and has the board take it.
    fn set(&mut self, key: &str, value: f64) -> Result<(), Error> {
        say(self.board, &format!("set {key} {value:?}"))?;
        say(self.board, "apply").map(drop)
    }

    fn get(&mut self, key: &str) -> Result<f64, Error> {
        let text = board::get(self.board, key)?;
        text.parse().map_err(|_| format!("{key} is no number: {text:?}").into())
    }

    /// Has the person do something while the board is kept, and gives the ticks meanwhile.
    fn meanwhile(&mut self, task: &Task) -> Result<Vec<Tick>, Error> {
        self.person.begin(task)?;
        let mut ticks = self.board.ticks(LOOK_S)?;
        while !self.person.is_done()? {
            ticks.extend(self.board.ticks(LOOK_S)?);
        }
        Ok(ticks)
    }

    /// Every tick of something: the joint's way along its axis (m), and the force on it as a share of full duty.
    fn watch(
        &mut self,
        settings: &Settings,
        act: impl FnOnce(&mut Self) -> Result<Vec<Tick>, Error>,
    ) -> Result<Vec<[f64; 2]>, Error> {
        let at = self.plan.joint as usize - 1;
        let joint = Joint::of(settings, self.plan.joint)?;
        let sign = if settings.motor.reversed { -1.0 } else { 1.0 } * joint.lever.signum();
        self.board.ticks(0.0)?;
        say(self.board, "stream 1")?;
        let ticks = act(self)?;
        say(self.board, "stream off")?;
        let Some(first) = ticks.first() else { return Err("no tick came from the board".into()) };
        let along = |counts: u16| f64::from(counts.wrapping_sub(first.counts[at]).cast_signed()) * joint.m_per_count;
        Ok(ticks.iter().map(|tick| [along(tick.counts[at]), sign * f64::from(tick.duties[at]) / 32767.0]).collect())
    }

    fn light(&mut self) -> Result<String, Error> {
        self.person.please(&Task::SeeLight)?;
        let status = self.status()?;
        cohold_sim::refuse_if!(status.mode != Mode::Disarmed, "it should be disarmed and without a fault: {status}");
        say(self.board, "stream 1")?;
        self.board.ticks(0.1)?;
        let ticks = self.board.ticks(0.5)?;
        say(self.board, "stream off")?;
        let gaps = ticks.windows(2).filter(|two| two[1].number.wrapping_sub(two[0].number) != 1).count();
        cohold_sim::refuse_if!(
            ticks.len() < 400 || gaps > 0,
            "{} of 500 ticks came, with {gaps} gaps: the network loses them",
            ticks.len()
        );
        Ok(status.to_string())
    }

    fn stop_is_seen(&mut self) -> Result<String, Error> {
        let before_v = self.supply_v()?;
        self.person.please(&Task::PressStop)?;
        self.refused("arm", "the emergency stop is pressed, or not connected")?;
        let (after_s, left_v) = self.supply_falls(before_v)?;
        self.person.please(&Task::ReleaseStop)?;
        // Whatever else stands against arming, the stop does not.
        let answer = self.board.ask("clear")?;
        cohold_sim::refuse_if!(answer != "ok disarmed", "released, the board answers \"clear\" with {answer:?}");
        self.supply_returns(before_v)?;
        let after = after_s.map_or("by the voltmeter".to_owned(), |after_s| format!("after {after_s:.1} s"));
        Ok(format!("pressed, arming is refused, and of {before_v:.1} V of supply {left_v:.1} V are left {after}"))
    }

    /// The supply of the bridges, V: as the board measures it, or as a person does.
    fn supply_v(&mut self) -> Result<f64, Error> {
        match winding::supply_v(self.board)? {
            Some(volts) => Ok(volts),
            None => self.person.reading(VOLTMETER),
        }
    }

    /// With the stop pressed: what is left of the supply, V, and after which time, where the board looks. Whatever the first contact
    /// does, no program of the board's cuts the supply: what makes it fall is the second.
    fn supply_falls(&mut self, before_v: f64) -> Result<(Option<f64>, f64), Error> {
        cohold_sim::refuse_if!(before_v < 2.0 * OFF_V, "{before_v:.1} V of supply are too little to see it fall");
        let cut = |volts: f64| {
            let uncut = "the second contact does not cut it";
            Err(format!("the stop is pressed, and the supply stands at {volts:.1} V: {uncut}").into())
        };
        let mut first = None;
        loop {
            let Some((tick, volts)) = winding::supply_at(self.board)? else {
                self.board.ticks(FALL_S)?;
                let volts = self.person.reading(VOLTMETER)?;
                return if volts < OFF_V { Ok((None, volts)) } else { cut(volts) };
            };
            let seconds = TICK_S * f64::from(tick.wrapping_sub(*first.get_or_insert(tick)));
            if volts < OFF_V {
                return Ok((Some(seconds), volts));
            }
            if seconds > SHOWS_S && volts > SHOWS * before_v {
                return cut(volts);
            }
            cohold_sim::refuse_if!(
                seconds > FALL_S,
                "{seconds:.0} s after the stop was pressed the supply is still {volts:.1} V, must be {OFF_V} V: something holds it, \
                     which a resistor across it empties"
            );
            self.board.ticks(LOOK_S)?;
        }
    }

    /// With the stop released: the supply is back.
    fn supply_returns(&mut self, before_v: f64) -> Result<(), Error> {
        let mut first = None;
        while let Some((tick, volts)) = winding::supply_at(self.board)?
            && volts <= SHOWS * before_v
        {
            cohold_sim::refuse_if!(
                TICK_S * f64::from(tick.wrapping_sub(*first.get_or_insert(tick))) > RISE_S,
                "{RISE_S} s after the stop was released the supply is {volts:.1} V, was {before_v:.1}"
            );
            self.board.ticks(LOOK_S)?;
        }
        Ok(())
    }

    fn supply(&mut self) -> Result<String, Error> {
        let read_v = self.person.reading(VOLTMETER)?;
        let Some(volts) = winding::supply_v(self.board)? else {
            return Ok(format!("{read_v:.1} V by the voltmeter; this board does not measure it"));
        };
        cohold_sim::refuse_if!(
            (volts - read_v).abs() > METER * read_v.abs(),
            "the board reads {volts:.2} V, the voltmeter {read_v:.2} V"
        );
        let [least_v, most_v] = [self.get("motor.min_supply_v")?, self.get("motor.max_supply_v")?];
        cohold_sim::refuse_if!(volts < least_v || volts > most_v, "{volts:.1} V, may be {least_v} to {most_v} V");
        Ok(format!("{volts:.2} V, {read_v:.2} V by the voltmeter"))
    }

    fn encoder(&mut self) -> Result<String, Error> {
        let found = counts::calibrate(self.board, self.person, self.plan.joint, self.plan.distance)?;
        self.keep(&found)
    }

    fn sign(&mut self) -> Result<String, Error> {
        self.person.please(&Task::LetGo { joint: self.plan.joint })?;
        let found = motor::sign(self.board, self.plan.joint)?;
        self.keep(&found)
    }

    /// No loop is closed around a winding that nobody knows.
    fn winding(&mut self) -> Result<String, Error> {
        let nothing = || Ok("this board has no current loop: nothing was measured".to_owned());
        if winding::supply_v(self.board)?.is_none() {
            return nothing();
        }
        let of_sheet = self.plan.sheet.found().ok_or(
            "this board closes a loop around the current, which is set by the winding: give --resistance-ohm and --inductance-h, of the motor's \
             data sheet",
        )?;
        self.keep(&of_sheet)?;
        self.person.please(&Task::LetGo { joint: self.plan.joint })?;
        let Some(found) = winding::winding(self.board, self.plan.joint, self.plan.sheet)? else { return nothing() };
        self.keep(&found)
    }

    fn motor(&mut self) -> Result<String, Error> {
        let joint = self.plan.joint;
        let mut found = motor::constant(self.board, self.person, joint, self.plan.against)?;
        self.keep(&found)?;
        if let Against::Mass(_) = self.plan.against {
            self.person.please(&Task::Unfasten { joint })?;
        }
        self.person.please(&Task::LetGo { joint })?;
        let moves = [motion::inertia(self.board, joint)?, motion::friction(self.board, joint)?].concat();
        settings_file::add(self.plan.file, &moves)?;
        found.extend(moves);
        Ok(listed(&found))
    }

    /// Armed with the lowest force, signs checked anew; calls `then`, and leaves the board disarmed with the limit that it had.
    fn armed<T>(&mut self, then: impl FnOnce(&mut Self, &Settings) -> Result<T, Error>) -> Result<T, Error> {
        let limit = self.get("safety.max_force_n")?;
        self.set("safety.max_force_n", limit.min(LOWEST_N))?;
        for joint in 1..=settings(self.board)?.axis.count {
            self.person.please(&Task::LetGo { joint })?;
            motor::sign(self.board, joint)?;
        }
        let settings = settings(self.board)?;
        say(self.board, "arm")?;
        let outcome = then(self, &settings)?;
        say(self.board, "disarm")?;
        self.set("safety.max_force_n", limit)?;
        Ok(outcome)
    }

    fn lowest_force(&mut self) -> Result<String, Error> {
        self.armed(|this, settings| {
            let seen = this.watch(settings, |this| this.board.ticks(1.0))?;
            let crept = seen.iter().fold(0.0, |most: f64, [way, _]| most.max(way.abs()));
            let status = this.status()?;
            cohold_sim::refuse_if!(
                status.mode != Mode::Armed || crept > CREEP_M,
                "in a second it moved by {:.2} mm; {status}",
                1e3 * crept
            );
            Ok(format!("armed with {LOWEST_N} N, moved by {:.2} mm in a second", 1e3 * crept))
        })
    }

    fn first_contact(&mut self) -> Result<String, Error> {
        self.armed(|this, settings| {
            let joint = this.plan.joint;
            let toward = if board::get(this.board, "contact.side")? == "left" { 1.0 } else { -1.0 };
            let seen = this.watch(settings, |this| this.meanwhile(&Task::Push { joint, metres: toward * PUSH_M }))?;
            // Work on the hand, in metres of full duty: what pushes back takes it.
            let work: f64 = seen.windows(2).map(|two| two[0][1] * (two[1][0] - two[0][0])).sum();
            let duty = seen.iter().fold(0.0, |most: f64, [_, duty]| most.max(duty.abs()));
            let newtons = duty * motion::newton_per_duty(settings, &Joint::of(settings, joint)?);
            let status = this.status()?;
            if status.mode != Mode::Armed || work >= 0.0 || newtons > 1.1 * LOWEST_N {
                let which = if work >= 0.0 { "nothing pushed back" } else { "it pushed back" };
                return Err(format!("{which}, with {newtons:.2} N at the most; {status}").into());
            }
            Ok(format!("pushed back with {newtons:.2} N at the most"))
        })
    }

    fn stop(&mut self) -> Result<String, Error> {
        let before_v = winding::supply_v(self.board)?.unwrap_or_default();
        self.armed(|this, _| {
            this.meanwhile(&Task::PressStop)?;
            let status = this.status()?;
            cohold_sim::refuse_if!(status.mode != Mode::Disarmed, "the motors are not off: {status}");
            this.refused("arm", "emergency stop")?;
            this.person.please(&Task::ReleaseStop)?;
            this.refused("arm", "clear first: the emergency stop was pressed")?;
            say(this.board, "clear")?;
            this.supply_returns(before_v)?;
            Ok("off, and off until cleared and armed anew".to_owned())
        })
    }

    fn cable(&mut self) -> Result<String, Error> {
        let patience_s = self.get("safety.operator_lost_s")?;
        self.armed(|this, _| {
            this.meanwhile(&Task::PullCable)?;
            this.board.ticks(patience_s + OUT_S)?;
            this.person.please(&Task::PlugCable)?;
            let mut status = this.status();
            for _ in 0..10 {
                if status.is_ok() {
                    break;
                }
                this.board.ticks(1.0)?;
                status = this.status();
            }
            let status = status?;
            cohold_sim::refuse_if!(
                status.mode != Mode::Disarmed || !status.let_go,
                "the motors should be off because the operator was silent: {status}"
            );
            Ok("off while the operator was silent, and said so".to_owned())
        })
    }

    fn time(&mut self) -> Result<String, Error> {
        let mut seen = Vec::new();
        for (what, budget_us) in [("delay", LATE_US), ("duration", LONG_US), ("spacing", LATE_US)] {
            let answer = say(self.board, &format!("time {what}"))?;
            // `…, cycles of 480 MHz: most 312 in tick 41 …`
            let number = |after: &str| {
                let (_, rest) = answer.split_once(after)?;
                rest.split_whitespace().next()?.parse::<f64>().ok()
            };
            let (Some(megahertz), Some(most)) = (number("cycles of "), number(": most ")) else {
                return Err(format!("no times in {answer:?}").into());
            };
            let most_us = most / megahertz;
            cohold_sim::refuse_if!(most_us > budget_us, "{what} {most_us:.1} µs, may be {budget_us} µs: {answer}");
            seen.push(format!("{what} {most_us:.1} µs of {budget_us}"));
        }
        Ok(seen.join(", "))
    }
}
