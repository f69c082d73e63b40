//! The console: what the operator's lines do ([`firmware_parts::operator`]): arm, stop and set up the board.
//!
//! One line, one answer, `ok …` or `error …`; [`crate::port`] brings them, sealed. Settings go into a draft first; `apply`
//! checks the draft as a whole and gives it to the tick, which takes it at the next packet boundary if it is disarmed, and to
//! the link, which from then on wants a peer with the same settings. Arming is refused while anything stands against it,
//! with the reason: so it is until the signs of every joint's motor and encoder were checked (`check 1`, `check 2`), with the
//! encoders, mechanism and motors that are set now. Limits are lowered from afar, and raised only while somebody at the board holds
//! its blue button ([`firmware_parts::ceiling`]).

use core::fmt::{self, Write};

use cohold_core::contact::{Contact, Side};
use cohold_core::device::probe::{Outcome, Probe};
use cohold_core::device::velocity::VelocityName;
use cohold_core::names::MotorDrive;
use cohold_core::num::{Motion, Scalar};
use cohold_core::safety::{Command, Mode};
use cohold_core::settings::{Refused, SetError, Settings, Value};
use cohold_protocol::{lease::Word, lines::Line};
use embassy_time::{Duration, Instant, Timer};
use firmware_parts::ceiling::{self, Above};
use firmware_parts::contacts::Contacts;
use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::history::History;
use firmware_parts::image::{JOINTS, Peer, Real};
use firmware_parts::kept::{HOLD_SWITCH, Kept};
use firmware_parts::operator::{self, Misread, Request, Time, Whose};
use firmware_parts::rate::Rate;
use firmware_parts::signals::{Button, Order, Saving, Signals};
use firmware_parts::status;

use crate::board::drive::{Drive, Fitted};
use crate::board::{Number, bridges, clocks::CORE_HZ, current, pace, update};
use crate::storage::{self, Origin};
use crate::tick::Plan;
use crate::{fault::Cause, flow, lease::Lease, log::log, telemetry::Telemetry};

pub(crate) struct Console {
    pub(crate) number: Number,
    /// Why the board started; stands against arming until cleared if it was no ordinary start.
    pub(crate) cause: Cause,
    pub(crate) unacknowledged: bool,
    /// What stands against arming whatever anybody acknowledges.
    pub(crate) unfit: Option<&'static str>,
    /// The emergency stop's.
    pub(crate) contacts: Contacts,
    pub(crate) history: History,
    /// A fault holds the motors off that is in it.
    pub(crate) faulted: bool,
    pub(crate) origin: Origin,
    /// What the board started with, or what was applied last with its button held.
    pub(crate) ceiling: &'static mut Kept,
    pub(crate) applied: Kept,
    pub(crate) draft: Kept,
    /// [`Plan::device`] of what the tick runs.
    pub(crate) device: u32,
    pub(crate) plans: Writer<'static, Plan>,
    /// What it asks the tick, and what the others say.
    pub(crate) signals: &'static Signals,
    pub(crate) lease: &'static Lease,
    /// The word that the line at hand was said under.
    pub(crate) word: Word,
    pub(crate) probes: Writer<'static, (u32, Probe<Real>)>,
    pub(crate) probed: Reader<'static, Outcome>,
    /// When the bootloader is due that was ordered.
    pub(crate) leaves: Option<Instant>,
}

/// From the order to the bootloader: the answer is heard before.
const LEAVES_AFTER: Duration = Duration::from_millis(500);

/// Longest from packet to packet, ns: orders are carried out at packets, and answered within 50 ms.
const LONGEST_NS: u64 = 40_000_000;

/// The settings as this board runs them, turned into what the tick takes.
pub(crate) fn plan(settings: &Settings, number: Number) -> Result<Plan, Refused<'static>> {
    let mut settings = *settings;
    settings.contact.side = match number {
        Number::One => Side::Left,
        Number::Two => Side::Right,
    };
    let rate = Rate::of(&settings.timing);
    settings.all_fit(&[
        ("timing.control_period_s", rate.is_some(), Rate::PERIODS),
        (
            "timing.ticks_per_packet",
            settings.timing.packet_period_ns() <= LONGEST_NS,
            "at most 40 ms of ticks, because orders wait for a packet",
        ),
        (
            "axis.velocity",
            settings.axis.velocity != VelocityName::Measured,
            "difference, filtered or adaptive, because encoders measure no velocity",
        ),
        (
            "motor.thermistor",
            !settings.motor.thermistor || settings.motor.drive == MotorDrive::CurrentLoop,
            "false, because only a current loop reads one",
        ),
    ])?;
    cohold_core::device::encoder::check(&settings)?;
    // The object starts at zero, so the device starts where it is just clear of it.
    let clear = -Contact::build(&settings).clear_of(Real::ZERO);
    let mut device = [Motion::REST; JOINTS];
    device[0] = Motion::at(clear);
    let peer = Peer::build(&settings, device)?;
    let rate = rate.unwrap_or(Rate::Khz1);
    Ok(Plan { peer, rate, drive: Fitted::plan(&settings, rate)?, device: 0 })
}

/// Why the answer is `error`.
enum No<'a> {
    Misread(Misread),
    Key(&'a str),
    /// A value that is not allowed, or that this board does not run.
    Refused(Refused<'a>),
    /// A limit that only who is at the board may raise.
    Above(Above),
    Mode(Mode),
    Clear(&'static str),
    Because(&'static str),
    /// The answer is longer than a line: it is cut.
    Full,
}

impl fmt::Display for No<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Misread(misread) => f.write_str(misread.explain()),
            Self::Key(key) => write!(f, "there is no key {key}"),
            Self::Refused(refused) => refused.fmt(f),
            Self::Above(above) => above.fmt(f),
            Self::Mode(mode) => write!(f, "{}, fault {}", mode.name(), mode.fault_number()),
            Self::Clear(why) => write!(f, "clear first: {why}"),
            Self::Because(why) => f.write_str(why),
            Self::Full => Ok(()),
        }
    }
}

impl From<fmt::Error> for No<'_> {
    fn from(_: fmt::Error) -> Self {
        Self::Full
    }
}

impl Console {
    /// Does what a line says, and answers. An answer that does not fit is cut: the first words say what matters.
    pub(crate) async fn hear(&mut self, line: &str, telemetry: &mut Telemetry, to: &mut Line) {
        let done = match operator::parse(line) {
            Ok(request) => self.answer(request, telemetry, to).await,
            Err(misread) => Err(No::Misread(misread)),
        };
        let _ = match done {
            Ok(()) | Err(No::Full) => Ok(()),
            Err(no) => write!(to, "error {no}"),
        };
    }

    async fn answer<'a>(
        &mut self,
        request: Request<'a>,
        telemetry: &mut Telemetry,
        to: &mut Line,
    ) -> Result<(), No<'a>> {
        match request {
            Request::Status => self.status(to)?,
            Request::Arm { alone } => {
                let armed = self.arm(alone).await?.name();
                write!(to, "ok {armed}{}", if alone { ", alone: the operator may go" } else { "" })?;
            }
            Request::Disarm => {
                self.disarm().await?;
                write!(to, "ok disarmed")?;
            }
            Request::Clear => {
                self.unacknowledged = false;
                self.signals.emergency.set(false);
                write!(to, "ok {}", self.order(Command::Clear, Mode::Disarmed).await?.name())?;
            }
            Request::Home => {
                if self.signals.button.get() != Button::Held {
                    return Err(No::Because(
                        "hold the blue button down: home moves the room that the device may move in",
                    ));
                }
                self.order(Command::Home, Mode::Disarmed).await?;
                write!(to, "ok home here")?;
            }
            Request::Clutch => {
                self.order(Command::Clutch, Mode::Armed).await?;
                write!(to, "ok the device is free, the world stands")?;
            }
            Request::Release => {
                self.order(Command::Release, Mode::Armed).await?;
                write!(to, "ok the device holds the world again")?;
            }
            Request::Check(joint) => self.probe(Probe::check(&self.applied.settings, joint), to).await?,
            Request::Probe(probe) => self.probe(Probe::build(&self.applied.settings, &probe), to).await?,
            Request::Probed => self.probed(to)?,
            Request::Set(key, value) => match self.draft.set(key, value) {
                Ok(()) => write!(to, "ok {key} = {value}")?,
                Err(SetError::Unknown) => return Err(No::Key(key)),
                Err(SetError::Refused(refused)) => return Err(No::Refused(refused)),
            },
            Request::Get(key) => {
                let value = self.draft.get(key).ok_or(No::Key(key))?;
                write!(to, "ok {key} = {value}")?;
            }
            Request::Defaults => {
                // What is wired stays wired.
                self.draft = Kept { hold_switch: self.draft.hold_switch, ..Kept::default() };
                write!(to, "ok the draft holds the defaults")?;
            }
            Request::Apply => {
                self.apply()?;
                write!(to, "ok applied")?;
            }
            Request::Save => write!(to, "ok {}", self.save().await?)?,
            Request::Stream(every) => {
                telemetry.stream(every);
                write!(to, "ok every {every} ticks")?;
            }
            Request::Capture { ticks, at } => {
                telemetry.capture(ticks, at);
                write!(to, "ok the next {ticks} ticks{}", if at > 0 { " from then on" } else { "" })?;
            }
            Request::Blackbox => {
                let (ticks, periods) = telemetry.blackbox();
                if ticks == 0 {
                    return Err(No::Because("no fault has turned the motors off since power came on"));
                }
                write!(to, "ok {ticks} ticks, {periods} PWM periods")?;
            }
            Request::History => write!(to, "ok {}", self.history)?,
            Request::Time(whose, which) => {
                let times = match whose {
                    Whose::Tick => &pace::TIMES,
                    Whose::CurrentLoop => &pace::LOOP_TIMES,
                };
                let (what, times) = match which {
                    Time::Delay => ("from due to begun", &times.delay),
                    Time::Duration => ("from begun to ended", &times.duration),
                    Time::Spacing => ("off a period", &times.spacing),
                };
                write!(to, "ok {what}, cycles of {} MHz: {times}", CORE_HZ / 1_000_000)?;
            }
            Request::Load => {
                write!(to, "ok of the processor, in the last second:")?;
                for (what, load) in [(" current loop", &pace::LOOP_LOAD), (", tick", &pace::LOAD)] {
                    let share = load.share(CORE_HZ);
                    write!(to, "{what} {}.{:02} %", share / 100, share % 100)?;
                }
            }
            Request::Update => {
                self.disarmed()?;
                if let Some(why) = update::obstacle() {
                    return Err(No::Because(why));
                }
                self.leaves = Some(Instant::now() + LEAVES_AFTER);
                write!(
                    to,
                    "ok in 0.5 s the bootloader of the ROM runs, on the board's own USB; its black button starts the image"
                )?;
            }
        }
        Ok(())
    }

    fn status(&self, to: &mut Line) -> fmt::Result {
        let signals = self.signals;
        let mode = signals.mode.get();
        write!(to, "ok board {} {} fault {} ", self.number as u8 + 1, mode.name(), mode.fault_number())?;
        for (name, word) in [
            ("ticks", &signals.ticks),
            ("overruns", &signals.overruns),
            ("sent", &signals.sent),
            ("dropped", &signals.dropped),
            ("received", &signals.received),
        ] {
            write!(to, "{name} {} ", word.get())?;
        }
        let (stage, saves) = (status::stage(signals.stage.get()), signals.saves.get());
        let saving = match signals.saving.get() {
            Saving::Busy => ", saving",
            Saving::Failed => ", not saved",
            Saving::Done => "",
        };
        write!(to, "refused {}; link {stage}; ", signals.refused.get())?;
        let [now, last] = Fitted::says(signals);
        if let Some(why) = last.or(now) {
            write!(to, "{why}; ")?;
        }
        if let Some(why) = self.contacts() {
            write!(to, "{why}; ")?;
        }
        if signals.released.get() {
            to.write_str("motors off: the hold-to-run switch was released; ")?;
        }
        to.write_str(self.lease.with(|hold, _| hold.says()))?;
        if signals.button.get() == Button::Stuck {
            to.write_str("the blue button is down since before the start; ")?;
        }
        write!(to, "settings {} {saves}{saving}; ", self.origin.explain())?;
        write!(to, "started: {}{}", self.cause.stop.explain(), self.cause.place)
    }

    /// For who has no operator's key: why the motors are off, if they are and must be, and the status.
    #[cfg(feature = "usb")]
    pub(crate) fn tell(&self, to: &mut Line) -> fmt::Result {
        match (self.signals.mode.get(), self.armable()) {
            (Mode::Armed, _) => write!(to, "armed; ")?,
            (Mode::Faulted(fault), _) => write!(to, "not armed: fault, {}; ", fault.explain())?,
            (_, Err(why)) => write!(to, "not to be armed: {why}; ")?,
            (_, Ok(())) => write!(to, "not armed, nothing stands against it; ")?,
        }
        self.status(to)
    }

    /// Motors on, for as long as the operator lets them or, alone, for longer.
    async fn arm(&mut self, alone: bool) -> Result<Mode, No<'static>> {
        self.armable()?;
        let order = self.next(Command::Arm);
        self.start(alone, |console| console.signals.order.release(order))?;
        let armed = self.ordered(order, Mode::Armed).await;
        self.lease.with(|hold, _| hold.started());
        armed
    }

    /// Motors off at the next tick.
    async fn disarm(&self) -> Result<(), No<'static>> {
        self.lease.with(|hold, now_us| hold.off(now_us, self.signals));
        self.carried_out(|| !self.signals.disarm.acquire()).await
    }

    /// Gives the tick an order that turns motors on, if the lease lets them.
    fn start(&mut self, alone: bool, order: impl FnOnce(&mut Self)) -> Result<(), No<'static>> {
        let (lost_s, lease, signals) = (self.applied.settings.safety.operator_lost_s, self.lease, self.signals);
        let said = (self.word, alone);
        let started = lease.with(|hold, now_us| hold.start(now_us, said, lost_s, signals, || order(self)));
        started.map_err(|no| No::Because(no.explain()))?;
        signals.released.set(false);
        Ok(())
    }

    fn next(&self, command: Command) -> Order {
        self.signals.order.get().next(command)
    }

    /// Has the tick carry the command out; the mode that it led to, if that is the one that was asked for.
    async fn order(&self, command: Command, wanted: Mode) -> Result<Mode, No<'static>> {
        let order = self.next(command);
        self.signals.order.release(order);
        self.ordered(order, wanted).await
    }

    async fn ordered(&self, order: Order, wanted: Mode) -> Result<Mode, No<'static>> {
        self.carried_out(|| self.signals.done.acquire() == order).await?;
        let mode = self.signals.mode.get();
        if mode == wanted { Ok(mode) } else { Err(No::Mode(mode)) }
    }

    /// What stands against arming.
    fn armable(&self) -> Result<(), No<'static>> {
        self.ready()?;
        let why = "check first: the signs of motor and encoder were not checked, every joint in use";
        if self.signals.checked.get() { Ok(()) } else { Err(No::Because(why)) }
    }

    /// What stands against motors being on, before the tick is asked.
    fn ready(&self) -> Result<(), No<'static>> {
        if let Some(why) = self.unfit {
            Err(No::Because(why))
        } else if self.leaves.is_some() {
            Err(No::Because("the board starts its bootloader"))
        } else if self.unacknowledged {
            Err(No::Clear(self.cause.stop.explain()))
        } else if self.signals.emergency.get() {
            Err(No::Clear("the emergency stop was pressed"))
        } else if !bridges::stop_released() {
            Err(No::Because("the emergency stop is pressed, or not connected"))
        } else if let Some(why) = self.contacts() {
            Err(No::Because(why))
        } else if self.signals.by_switch.get() && !self.signals.held.get() {
            Err(No::Because("hold the hold-to-run switch: it is open, not connected, or closed since before the start"))
        } else if let [Some(why), _] = Fitted::says(self.signals) {
            Err(No::Because(why))
        } else if self.signals.saving.acquire() == Saving::Busy {
            Err(No::Because("the settings are being saved"))
        } else {
            match self.signals.mode.get() {
                Mode::Disarmed => Ok(()),
                mode => Err(No::Mode(mode)),
            }
        }
    }

    /// Supply of the bridges, mV, if it is measured.
    fn supply_mv(&self) -> Option<u32> {
        current::supply_mv(self.applied.settings.motor.drive)
    }

    /// What was found against the emergency stop's contacts; none while the supply is not measured.
    #[inline(never)]
    fn contacts(&self) -> Option<&'static str> {
        self.supply_mv().and_then(|_| self.contacts.says())
    }

    /// Compares the emergency stop's contacts, in every mode; to be called now and then.
    pub(crate) fn compare(&mut self) {
        let least_mv = (1e3 * self.applied.settings.motor.min_supply_v) as u32;
        let (now_us, open) = (Instant::now().as_micros() as u32, !bridges::stop_released());
        if self.contacts.look(now_us, open, self.supply_mv(), least_mv)
            && let Some(why) = self.contacts()
        {
            log!(error, "contacts of the stop: {}", why);
        }
    }

    /// Notes a fault that has turned the motors off; to be called now and then.
    pub(crate) fn note(&mut self) {
        let mode = self.signals.mode.get();
        if let (Mode::Faulted(fault), false) = (mode, self.faulted) {
            let at_ms = u32::try_from(Instant::now().as_millis()).unwrap_or(u32::MAX);
            if let Some(entry) = self.history.fault(fault, at_ms) {
                storage::note(entry);
            }
        }
        self.faulted = matches!(mode, Mode::Faulted(_));
    }

    /// Begins a probe; what comes of it is asked for later, so that `disarm` is heard in between.
    async fn probe(&mut self, probe: Result<Probe<Real>, Refused<'static>>, to: &mut Line) -> Result<(), No<'static>> {
        self.ready()?;
        let probe = probe.map_err(No::Refused)?;
        let signals = self.signals;
        let number = signals.begun.get().wrapping_add(1);
        self.start(false, |console| console.probes.write((number, probe)))?;
        let begun = self.carried_out(|| signals.begun.acquire() == number).await;
        self.lease.with(|hold, _| hold.started());
        begun?;
        if let mode @ Mode::Faulted(_) = signals.mode.get() {
            return Err(No::Mode(mode));
        }
        Ok(write!(to, "ok probing joint {} for {} ticks", probe.joint(), probe.ticks())?)
    }

    fn probed(&mut self, to: &mut Line) -> fmt::Result {
        self.probed.fetch();
        write!(to, "ok {}", self.probed.get())
    }

    fn disarmed(&self) -> Result<(), No<'static>> {
        if self.signals.mode.get() == Mode::Disarmed { Ok(()) } else { Err(No::Because("disarm first")) }
    }

    /// What is applied goes to flash. An erase takes longer than an answer may: then `status` says how it ended.
    async fn save(&mut self) -> Result<&'static str, No<'static>> {
        let signals = self.signals;
        self.disarmed()?;
        if !storage::save(signals, &self.applied) {
            return Err(No::Because("the settings are being saved"));
        }
        soon(|| signals.saving.acquire() != Saving::Busy).await;
        match signals.saving.acquire() {
            Saving::Busy => Ok("saving, a few seconds: flash is being erased"),
            Saving::Failed => Err(No::Because("the flash does not take it")),
            Saving::Done => Ok("saved"),
        }
    }

    fn apply(&mut self) -> Result<(), No<'static>> {
        self.disarmed()?;
        let plan = plan(&self.draft.settings, self.number).map_err(No::Refused)?;
        let at_the_board = self.signals.button.get() == Button::Held;
        if !at_the_board && self.ceiling.hold_switch && !self.draft.hold_switch {
            let value = Value::Flag(false);
            return Err(No::Above(Above { key: HOLD_SWITCH, value, ceiling: Value::Flag(true) }));
        }
        for above in ceiling::above(&self.draft.settings, &self.ceiling.settings) {
            if !at_the_board {
                return Err(No::Above(above));
            }
            let mut value = Line::new();
            let _ = write!(value, "{}", above.value);
            log!(warn, "set at the board, beyond what it was: {} = {}", above.key, value.as_str());
        }
        if at_the_board {
            *self.ceiling = self.draft;
        }
        let (before, now) = (&self.applied.settings, &self.draft.settings);
        let same = (before.axis.count == now.axis.count)
            && (before.encoder, before.kinematics, before.motor) == (now.encoder, now.kinematics, now.motor);
        self.device = if same { self.device } else { self.device.wrapping_add(1) };
        self.plans.write(Plan { device: self.device, ..plan });
        self.applied = self.draft;
        self.signals.by_switch.set(self.applied.hold_switch);
        flow::tell(self.draft.settings);
        Ok(())
    }

    /// Goes to the bootloader, if it is due and flash is not at work; nothing has turned motors on since it was ordered.
    pub(crate) fn leave(&self) {
        let due = self.leaves.is_some_and(|due| Instant::now() >= due);
        if due && self.signals.saving.acquire() != Saving::Busy {
            update::enter();
        }
    }

    /// Waits for the tick. If it does not do what it was asked for, it must not do it later either.
    async fn carried_out(&self, done: impl Fn() -> bool) -> Result<(), No<'static>> {
        if soon(done).await {
            return Ok(());
        }
        self.signals.disarm.release(true);
        Err(No::Because("the tick did not answer; motors off"))
    }
}

/// Waits up to 50 ms for something to be done.
async fn soon(done: impl Fn() -> bool) -> bool {
    for _ in 0..50 {
        if done() {
            return true;
        }
        Timer::after(Duration::from_millis(1)).await;
    }
    done()
}
