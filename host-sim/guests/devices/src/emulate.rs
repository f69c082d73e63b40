//! `cohold devices emulate`: a device that is not there, to attach in the place of one, with a hand on it that does what the scene's
//! user does. What it speaks, and what can go wrong with it, is [`crate::emulators`]'s.

use std::net::SocketAddr;
use std::time::Duration;

use crate::emulators::hand::{Grip, Hand, Task};
use crate::emulators::{Emulated, Seen, inverse3};
#[cfg(unix)]
use crate::emulators::{carrier::Place, mit, moteus};
use clap::{Args, ValueEnum};
use cohold_live::endpoint::{Stop, realtime_beneath};
use cohold_sim::scene::Scene;
use cohold_sim::user::User;
use serde::Serialize;

use cohold_cli::flags::number;
use cohold_cli::{Failure, SceneArgs, Ui};

/// The hand of a user of whom the scene says nothing: it holds on; and what moves with an Inverse3.
const HOLDS_ON: [(&str, f64); 3] =
    [("device.mass_kg", 0.3), ("arm_stiffness_n_per_m", 300.0), ("arm_damping_n_s_per_m", 8.0)];
/// How often it says how it is.
const SAYS: Duration = Duration::from_secs(1);
/// How often it looks whether something is due.
const LOOKS: Duration = Duration::from_millis(2);

cohold_cli::commands! {
    /// Below `devices`.
    pub(crate) Emulation {
        /// A device that is not there, to attach in the place of one: its protocol on the real transport, a hand on it, and faults to plant.
        Emulate(Emulate),
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// Haply's service with an Inverse3.
    Inverse3,
    /// Two moteus motors with the five-bar of the scene `plane`; where there are Unix's terminals and sockets, as the next.
    #[cfg(unix)]
    Moteus,
    /// Two DM4310 that take MIT's frame, likewise.
    #[cfg(unix)]
    Mit,
}

/// A device that is not there, with a hand on it that does what the scene's user does (`user.N.…`: pushes, sines, traces, an arm that reaches and
/// trembles; `clutch_…` presses button a), until Ctrl-C. Prints the words by which `cohold` attaches it.
#[derive(Debug, Args)]
#[command(mut_arg("scene", |scene| scene.help("Scene file (TOML) or built-in scene [default: any-network at rest]")))]
pub(crate) struct Emulate {
    /// Which device.
    #[arg(value_name = "DEVICE")]
    kind: Kind,
    /// Where it is: ADDRESS:PORT of the service; a bus as `serial` or `serial:LINK`, a pseudo-terminal with an fdcanusb's lines and a link to it,
    /// as a path with a slash, a Unix socket that carries the kernel's frames, or as a CAN interface, such as vcan0.
    #[arg(long, value_name = "PLACE")]
    at: Option<String>,
    /// Plant this fault so many seconds after the start, as silent@20; may be repeated, `none` ends the one before.
    #[arg(long = "fault", value_name = "NAME@S", value_parser = planned)]
    faults: Vec<Planned>,
    /// After so long without an order it lets go, s; moteus motors are told that in every frame.
    #[arg(long, value_name = "S", value_parser = number(0.001..=3.0, "s"))]
    lets_go_s: Option<f64>,
    /// How long the hand rests once somebody has spoken to the device, s.
    #[arg(long, default_value = "5", value_name = "S", value_parser = number(0.0..=86400.0, "s"))]
    rest_s: f64,
    /// Which of the scene's users has the hand: 1 (left) or 2 (right).
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    number: u8,
    #[command(flatten)]
    scene: SceneArgs,
    /// How long, s; until Ctrl-C without it.
    #[arg(long, value_name = "S", value_parser = number(0.01..=3.2e9, "s"))]
    seconds: Option<f64>,
}

/// A fault, and when it is planted.
#[derive(Clone, Debug)]
struct Planned {
    fault: String,
    at_s: f64,
}

fn planned(text: &str) -> Result<Planned, String> {
    let parts = text.split_once('@').and_then(|(fault, at)| Some((fault, at.parse().ok()?)));
    let (fault, at_s) = parts
        .filter(|(_, at_s)| (0.0..=3.2e9).contains(at_s))
        .ok_or("a fault's name, @ and seconds from 0 on, as silent@20")?;
    Ok(Planned { fault: fault.to_owned(), at_s })
}

/// What was planted, and how long the device was still asked for a force after it, s; none where it was not at all.
#[derive(Debug, Serialize)]
struct Planted {
    fault: String,
    at_s: f64,
    last_push_after_s: Option<f64>,
}

/// What an emulator saw.
#[derive(Debug, Serialize)]
struct Report<'a> {
    words: String,
    seconds: f64,
    orders: u64,
    place_mm: Vec<f64>,
    force_n: Vec<f64>,
    last_push_s: Option<f64>,
    faults: &'a [Planted],
}

/// What a user of a scene does with a hand.
struct Hands {
    user: User,
    toward: f64,
}

impl Task for Hands {
    fn force_n(&self, time_s: f64) -> [f64; 3] {
        let profile = &self.user.settings.user;
        let (wanted_m, wanted_m_per_s) = self.user.wanted(time_s);
        let arm_n = profile.arm_stiffness_n_per_m * wanted_m + profile.arm_damping_n_s_per_m * wanted_m_per_s;
        let push_n = self.toward * (self.user.force_n(time_s) + arm_n);
        let along = self.user.direction().map(|part| part * push_n);
        [along[0], along[1] + profile.side_push_n, along[2] + profile.side_push_n]
    }

    fn presses(&self, time_s: f64) -> bool {
        self.user.clutches(time_s)
    }
}

impl Emulate {
    /// Emulates it until it is stopped, and reports what it saw.
    pub(crate) fn run(&self, ui: &Ui) -> Result<(), Failure> {
        let stop = Stop::on_signals()?;
        let faults = self.known();
        if let Some(planned) = self.faults.iter().find(|planned| !faults.contains(&planned.fault.as_str())) {
            return Err(format!("--fault {} is not allowed: it is one of {}", planned.fault, faults.join(", ")).into());
        }
        // A device has a processor of its own: what serves here runs beside peers that have to be in time. Its threads inherit this.
        realtime_beneath();
        let device = self.start(&self.scene.over(self.number, &self.beneath())?.load_or(ui, "any-network")?)?;
        let words = device.words().join(" ");
        ui.status(format_args!("it serves; attach it with\n    {words}"));
        let mut planted: Vec<Planted> = Vec::new();
        let mut due: Vec<&Planned> = self.faults.iter().collect();
        due.sort_by(|one, other| other.at_s.total_cmp(&one.at_s));
        let (mut says_s, mut told) = (0.0, 0);
        let seen = loop {
            let seen = device.look();
            if let Some(newest) = planted.last_mut() {
                newest.last_push_after_s =
                    seen.last_push_s.map(|last_s| last_s - newest.at_s).filter(|after_s| *after_s > 0.0);
            }
            if stop.is_asked() || self.seconds.is_some_and(|seconds| seen.time_s >= seconds) {
                break seen;
            }
            while let Some(Planned { fault, .. }) = due.pop_if(|planned| planned.at_s <= seen.time_s) {
                let at_s = device.plant(fault).unwrap_or(seen.time_s);
                ui.status(format_args!("{at_s:.3} s  fault {fault}"));
                planted.push(Planted { fault: fault.clone(), at_s, last_push_after_s: None });
            }
            if seen.time_s >= says_s {
                says_s += SAYS.as_secs_f64();
                ui.status(line(&seen, seen.orders - told));
                told = seen.orders;
            }
            std::thread::sleep(LOOKS);
        };
        let Seen { time_s: seconds, place_m, force_n, orders, last_push_s } = seen;
        let place_mm = place_m.iter().map(|place_m| 1e3 * place_m).collect();
        ui.report("", &Report { words, seconds, orders, place_mm, force_n, last_push_s, faults: &planted })
    }

    /// Settings of a hand that holds on, under what the scene says.
    fn beneath(&self) -> Vec<(&'static str, String)> {
        let of = |key: &str| if key.contains('.') { key.to_owned() } else { format!("user.{}.{key}", self.number) };
        HOLDS_ON.iter().map(|(key, value)| (*key, format!("{}={value}", of(key)))).collect()
    }

    /// The hand of the scene's user.
    fn hand<const N: usize>(&self, scene: &Scene) -> Result<Hand<N>, Failure> {
        let index = usize::from(self.number == 2);
        let user = scene.users[index].clone();
        if user.has_wall() {
            return Err(format!(
                "user.{}.wall_stiffness_n_per_m is not allowed: a hand meets no wall here",
                self.number
            )
            .into());
        }
        let (device, profile) = (&scene.devices()[index], &user.settings.user);
        let grip = Grip {
            mass_kg: device.mass_kg + profile.arm_mass_kg,
            stiffness_n_per_m: profile.arm_stiffness_n_per_m,
            damping_n_s_per_m: device.damping_n_s_per_m + profile.arm_damping_n_s_per_m,
        };
        let toward = if index == 0 { 1.0 } else { -1.0 };
        Ok(Hand::of(grip, self.rest_s, Box::new(Hands { user, toward })))
    }

    fn place_of_service(&self) -> Result<SocketAddr, Failure> {
        let at = self.at.as_deref().unwrap_or(super::haply::LISTENS);
        at.parse().map_err(|cause| self.refused(at, &format_args!("{cause}, as {} is one", super::haply::LISTENS)))
    }

    fn refused(&self, at: &str, why: &dyn std::fmt::Display) -> Failure {
        format!("--at {at} is not allowed: {why}").into()
    }

    /// Names of the faults that such a device can have.
    fn known(&self) -> Vec<&'static str> {
        match self.kind {
            Kind::Inverse3 => inverse3::FAULTS.map(|(name, _)| name).to_vec(),
            #[cfg(unix)]
            Kind::Moteus => moteus::FAULTS.map(|(name, _)| name).to_vec(),
            #[cfg(unix)]
            Kind::Mit => mit::FAULTS.map(|(name, _)| name).to_vec(),
        }
    }

    fn start(&self, scene: &Scene) -> Result<Box<dyn Emulated>, Failure> {
        Ok(match self.kind {
            Kind::Inverse3 => {
                let (at, holds_s) = (self.place_of_service()?, self.lets_go_s.unwrap_or(inverse3::HOLDS_S));
                let served = inverse3::Emulator::start(at, self.hand(scene)?, holds_s);
                Box::new(served.map_err(|cause| self.refused(&at.to_string(), &cause))?)
            }
            #[cfg(unix)]
            Kind::Moteus => {
                if self.lets_go_s.is_some() {
                    return Err("--lets-go-s is not allowed for moteus: a peer tells them (--device-lets-go-s)".into());
                }
                let place = self.bus(Place::Serial(None));
                let served = moteus::start(&place, self.hand(scene)?);
                Box::new(served.map_err(|cause| self.refused(&said(&place), &cause))?)
            }
            #[cfg(unix)]
            Kind::Mit => {
                let own = std::env::temp_dir().join(format!("cohold-mit-{}.can", std::process::id()));
                let place = self.bus(Place::Socket(own));
                let timeout_s = self.lets_go_s.unwrap_or(mit::TIMEOUT_AFTER_S);
                let served = mit::start(&place, self.hand(scene)?, timeout_s);
                Box::new(served.map_err(|cause| self.refused(&said(&place), &cause))?)
            }
        })
    }

    /// The bus that is meant, or this one.
    #[cfg(unix)]
    fn bus(&self, own: Place) -> Place {
        match self.at.as_deref().map(|at| (at, at.split_once(':'))) {
            None => own,
            Some((_, Some(("serial", link)))) => Place::Serial(Some(link.into())),
            Some(("serial", _)) => Place::Serial(None),
            Some((at, _)) if at.contains('/') => Place::Socket(at.into()),
            Some((at, _)) => Place::Interface(at.to_owned()),
        }
    }
}

/// A place as it is said.
#[cfg(unix)]
fn said(place: &Place) -> String {
    match place {
        Place::Serial(None) => "serial".to_owned(),
        Place::Serial(Some(link)) => format!("serial:{}", link.display()),
        Place::Socket(at) => at.display().to_string(),
        Place::Interface(name) => name.clone(),
    }
}

/// How it is, for people.
fn line(seen: &Seen, orders: u64) -> String {
    let all = |of: &[f64], by: f64, digits: usize| {
        // What rounds to nothing has no sign.
        let unit = 10_f64.powi(digits as i32);
        let rounded = of.iter().map(|one| (by * one * unit).round() / unit + 0.0);
        rounded.map(|one| format!("{one:.digits$}")).collect::<Vec<_>>().join(", ")
    };
    let (place_mm, force_n) = (all(&seen.place_m, 1e3, 2), all(&seen.force_n, 1.0, 3));
    format!("{:.0} s  hand at {place_mm} mm, pushed with {force_n} N, {orders} orders since", seen.time_s)
}
