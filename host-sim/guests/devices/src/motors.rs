//! Up to three motors on a bus that turn the joints of a scene's mechanism: what adapters of moteus and of MIT motors share.
//!
//! Each tick a frame goes to each motor, and the answers to it are the reading that the next tick takes. A frame may be lost: after
//! [`LOST`] the motors are asked again. Answers bear no number, so each is taken for the one to the oldest question that is open: a lost one
//! makes all later readings look a question older than they are, never younger.
//!
//! Torques are those of [`Mechanism`]. A motor that says that something is wrong with it ends it for all.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use cohold_core::settings::Settings;
use cohold_sim::device::{DeviceFault, Gone};
use moteus_protocol::CanFdFrame;

use cohold_live::Error;
use cohold_live::devices::threaded::{Acts, Desk, Line, Threaded, stopped};
use cohold_live::devices::{AXES, Abilities, DeviceOptions, Health, Port, Sensed};

use super::can::{self, Bus};
use super::mechanism::{Mechanism, Pose};

/// Longest wait for answers before the orders are looked at again.
const LOOK: Duration = Duration::from_millis(1);
/// A question that is not answered by then is asked again.
const LOST: Duration = Duration::from_millis(10);
/// How long motors may take to answer when they are opened.
const PATIENCE: Duration = Duration::from_millis(500);

/// What a motor said.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Told {
    pub(super) angle_rad: f64,
    pub(super) speed_rad_per_s: f64,
    pub(super) torque_nm: f64,
    pub(super) supply_v: Option<f64>,
    pub(super) temperature_c: f64,
    /// It gives less torque than it was asked for.
    pub(super) limited: bool,
}

/// What motors of a kind understand.
pub(super) trait Protocol: Send + 'static {
    /// Adds the frames that make motor `at` (from 0) give this torque, N·m, or let go; each is answered once.
    fn command(&mut self, at: usize, torque_nm: Option<f64>, frames: &mut Vec<CanFdFrame>);

    /// The frame that asks motor `at` how it is, and commands nothing; answered once.
    fn ask(&self, at: usize) -> CanFdFrame;

    /// Which motor an answer is of, what it says, and why that motor must not be driven, if so.
    fn hear(&mut self, frame: &CanFdFrame) -> Option<(usize, Told, Option<Gone>)>;
}

/// Motors that were looked at and are fit.
pub(super) struct Ready<P> {
    pub(super) protocol: P,
    /// Of their kind.
    pub(super) name: &'static str,
    pub(super) is_homed: bool,
    /// How long they go on after the last frame, s; none if that is not known, or for ever.
    pub(super) lets_go_s: Option<f64>,
    pub(super) most_nm: f64,
}

/// Refuses a bus without a name.
pub(super) fn is_named(at: &str) -> Result<(), String> {
    cohold_sim::refuse_if!(at.is_empty(), "its bus is not named, as moteus:/dev/ttyACM0 or mit:can0");
    Ok(())
}

/// What is wrong where nothing comes from a motor.
pub(super) fn silent(id: impl std::fmt::Display) -> String {
    format!("motor {id} does not answer: look at its id, its supply and the ends of the bus")
}

/// The motors at this place, which drive the mechanism of these settings, once they are made ready on their bus, by their identifiers and
/// the largest torque, N·m.
///
/// # Errors
/// One does not answer, or is not fit; or they do not fit the mechanism.
pub(super) fn open<P: Protocol>(
    kind: &str,
    (at, options, settings): (&str, &DeviceOptions, &Settings),
    ready: impl FnOnce(&mut dyn Bus, Vec<u8>, f64) -> Result<Ready<P>, Error>,
) -> Result<Box<dyn Port>, Error> {
    let open = || {
        let most_nm =
            options.max_torque_nm.ok_or("the largest torque of a motor is not said: --device-max-torque-nm")?;
        let (ids, signs): (Vec<u8>, Vec<f64>) = options.motors.iter().copied().unzip();
        let (axes, list) = (ids.len(), ids.iter().map(u8::to_string).collect::<Vec<_>>().join(", "));
        let mechanism = Mechanism::build(settings, axes)?;
        let mut bus = super::once_there(|| can::open(at))?;
        let ready = ready(&mut *bus, ids, most_nm)?;
        let mut motors = Motors::new(bus, ready.protocol, mechanism, signs, ready.most_nm);
        let pose = motors.first()?;
        let abilities = Abilities {
            name: format!("{} {list} at {at}", ready.name),
            axes,
            max_force_n: Some(pose.weakest_n(ready.most_nm)),
            is_homed: ready.is_homed || options.is_homed,
            lets_go_s: ready.lets_go_s,
            ..Abilities::default()
        };
        Threaded::start(abilities, Duration::from_secs_f64(options.silent_s), motors)
    };
    Ok(Box::new(open().map_err(|cause: Error| format!("{kind} at {at}: {cause}"))?))
}

/// A motor as this end knows it.
#[derive(Default)]
struct Motor {
    /// When those questions were asked that are open.
    asked: VecDeque<Instant>,
    /// Questions of this round that are not answered yet.
    open: usize,
    /// What it said last, when that was asked for, and when it was heard.
    newest: Option<(Told, [Instant; 2])>,
}

/// The motors, their bus and their mechanism.
pub(super) struct Motors<P> {
    pub(super) bus: Box<dyn Bus>,
    pub(super) protocol: P,
    mechanism: Mechanism,
    /// +1 of a motor that turns as its joint, −1 of one that turns against it.
    signs: Vec<f64>,
    most_nm: f64,
    motors: Vec<Motor>,
    pose: Option<Pose>,
    health: Health,
    frames: Vec<CanFdFrame>,
    came: Vec<CanFdFrame>,
}

impl<P: Protocol> Motors<P> {
    pub(super) fn new(bus: Box<dyn Bus>, protocol: P, mechanism: Mechanism, signs: Vec<f64>, most_nm: f64) -> Self {
        let motors = signs.iter().map(|_| Motor::default()).collect();
        let (frames, came, health) = (Vec::new(), Vec::new(), Health::default());
        Self { bus, protocol, mechanism, signs, most_nm, motors, pose: None, health, frames, came }
    }

    /// Lets all motors go and hears of each: where the hand is.
    ///
    /// # Errors
    /// One does not answer, by its place in the list; or is not fit.
    pub(super) fn first(&mut self) -> Result<Pose, Error> {
        let by = Instant::now() + PATIENCE;
        // What is wrong from before is cleared by letting go, so that what is said next counts.
        for round in 0..2 {
            self.say(None).map_err(|gone| gone.cause)?;
            while self.is_asking() && Instant::now() < by {
                let heard = self.hear(LOOK).map_err(|gone| gone.to_string());
                if round > 0 {
                    heard?;
                }
            }
        }
        if let Some(at) = self.motors.iter().position(|motor| motor.newest.is_none()) {
            return Err(silent(format!("{} of the list", at + 1)).into());
        }
        Ok(self.sense().map_err(|gone| gone.to_string())?.0)
    }

    fn is_asking(&self) -> bool {
        self.motors.iter().any(|motor| motor.open > 0)
    }

    /// Sends what is to be sent, each frame a question to its motor.
    fn send(&mut self) -> Result<(), Gone> {
        self.bus.send(&self.frames).map_err(stopped)?;
        self.frames.clear();
        Ok(())
    }

    fn say(&mut self, force_n: Option<[f64; AXES]>) -> Result<(), Gone> {
        let torques = force_n.zip(self.pose).map(|(force_n, pose)| pose.torques(force_n, self.most_nm));
        let now = Instant::now();
        for at in 0..self.motors.len() {
            let before = self.frames.len();
            let torque_nm = torques.map(|torques| self.signs[at] * torques[at]);
            self.protocol.command(at, torque_nm, &mut self.frames);
            let said = self.frames.len() - before;
            self.motors[at].open += said;
            self.motors[at].asked.extend(std::iter::repeat_n(now, said));
        }
        self.send()
    }

    /// Takes what has come; waits for the first as long as this.
    fn hear(&mut self, wait: Duration) -> Result<(), Gone> {
        self.bus.receive(wait, &mut self.came).map_err(stopped)?;
        let now = Instant::now();
        let mut trouble = None;
        for frame in self.came.drain(..) {
            let Some((at, told, wrong)) = self.protocol.hear(&frame) else { continue };
            let Some(motor) = self.motors.get_mut(at) else { continue };
            // An answer to nothing is not taken for news.
            let Some(asked) = motor.asked.pop_front() else { continue };
            motor.open = motor.open.saturating_sub(1);
            motor.newest = Some((told, [asked, now]));
            self.health.limited += u64::from(told.limited);
            trouble = trouble.or(wrong);
        }
        trouble.map_or(Ok(()), Err)
    }

    /// Where the hand is, of what all motors have said.
    fn sense(&mut self) -> Result<(Pose, [Instant; 2]), Gone> {
        let (mut angles, mut speeds) = ([0.0; AXES], [0.0; AXES]);
        let mut between: Option<[Instant; 2]> = None;
        let Health { supply_v, warmest_c, .. } = &mut self.health;
        for (at, motor) in self.motors.iter().enumerate() {
            let Some((told, [asked, heard])) = motor.newest else { return Err(stopped("a motor has not answered")) };
            (angles[at], speeds[at]) = (self.signs[at] * told.angle_rad, self.signs[at] * told.speed_rad_per_s);
            between = Some(between.map_or([asked, heard], |[first, last]| [first.min(asked), last.max(heard)]));
            if let Some(volts) = told.supply_v {
                let [least, most] = supply_v.unwrap_or([volts; 2]);
                *supply_v = Some([least.min(volts), most.max(volts)]);
            }
            *warmest_c = Some(warmest_c.unwrap_or(f64::NEG_INFINITY).max(told.temperature_c));
        }
        let pose = self.mechanism.pose(angles, speeds);
        let finite = angles.iter().chain(&speeds).all(|number| number.is_finite());
        if finite && pose.is_singular() {
            let cause = format!("joints at {angles:.2?} rad");
            return Err(Gone::new(DeviceFault::Singular, cause));
        }
        self.pose = Some(pose);
        Ok((pose, between.unwrap_or([Instant::now(); 2])))
    }
}

impl<P: Protocol> Line for Motors<P> {
    fn exchange(&mut self, desk: &Desk) -> Result<(), Gone> {
        let force_n = desk.wanted();
        let mut pushes = force_n.is_some();
        self.motors.iter_mut().for_each(|motor| motor.open = 0);
        self.say(force_n)?;
        let by = Instant::now() + LOST;
        while self.is_asking() && Instant::now() < by && !desk.ends() {
            self.hear(LOOK)?;
            // While no answer comes, the motors are told once if the peer lets go.
            if pushes && desk.wanted().is_none() {
                pushes = false;
                self.say(None)?;
            }
        }
        if self.is_asking() {
            return Ok(());
        }
        let (pose, between) = self.sense()?;
        let Pose { position_m, velocity_m_per_s, .. } = pose;
        desk.note(self.health);
        desk.tell(Ok(Some(Sensed { position_m, velocity_m_per_s, between, buttons: 0 })));
        Ok(())
    }

    fn let_go(&mut self) {
        let _ = self.say(None);
    }

    fn acts(&mut self) -> Acts {
        let now = Instant::now();
        for at in 0..self.motors.len() {
            self.frames.push(self.protocol.ask(at));
            self.motors[at].open = 1;
            self.motors[at].asked.push_back(now);
        }
        self.send()?;
        let mut acts: f64 = 0.0;
        while self.is_asking() && now.elapsed() < PATIENCE {
            match self.hear(LOOK) {
                // That it let go is what is asked about.
                Ok(()) | Err(Gone { fault: DeviceFault::LetGo, .. }) => {}
                Err(gone) => return Err(gone),
            }
        }
        for motor in &self.motors {
            let (told, _) =
                motor.newest.filter(|_| motor.open == 0).ok_or_else(|| stopped("a motor does not answer"))?;
            acts = acts.max(told.torque_nm.abs());
        }
        Ok(Some(acts))
    }
}
