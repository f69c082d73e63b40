//! The console: what the operator's lines do ([`firmware_parts::operator`]): arm, stop and set up the board.
//!
//! One line, one answer, `ok …` or `error …`; [`crate::port`] brings them, sealed. Settings go into a draft first; `apply`
//! checks the draft as a whole and gives it to the tick, which takes it at the next packet boundary if it is disarmed, and to
//! the link, which from then on wants a peer that was told the same. Arming is refused while anything stands against it,
//! with the reason: so it is until the signs of every joint's motor and encoder were checked (`check 1`, `check 2`), with the
//! encoders, mechanism and motors that are set now.

use core::fmt::Write;
use core::sync::atomic::Ordering;

use embassy_time::{Duration, Timer};
use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::kept::Kept;
use firmware_parts::operator::{self, Request};
use firmware_parts::status;
use haptic_core::contact::{Contact, Side};
use haptic_core::device::probe::{End, Outcome, Probe};
use haptic_core::device::velocity::VelocityName;
use haptic_core::num::Motion;
use haptic_core::safety::Command;
use haptic_core::scene::Scene;
use haptic_core::settings::{Refused, SetError, Settings};
use haptic_protocol::lines::Line;

use crate::board::{Number, bridges, pace};
use crate::fault::Cause;
use crate::storage::{self, Origin};
use crate::tick::{self, Plan};
use crate::{net, telemetry};

/// An answer.
type Answer = Line;

/// What the operator works on.
pub(crate) struct Console {
    /// Which of the pair.
    pub(crate) number: Number,
    /// Why the board started; stands against arming until cleared if it was no ordinary start.
    pub(crate) cause: Cause,
    /// Nobody has acknowledged it yet.
    pub(crate) unacknowledged: bool,
    /// Where the settings of this start came from.
    pub(crate) origin: Origin,
    /// What the tick runs.
    pub(crate) applied: Kept,
    /// What `set` changes.
    pub(crate) draft: Kept,
    /// [`Plan::device`] of what the tick runs.
    pub(crate) device: u32,
    /// Scenes for the tick.
    pub(crate) plans: Writer<'static, Plan>,
    /// Numbers the orders.
    pub(crate) orders: u32,
    /// Probes for the tick.
    pub(crate) probes: Writer<'static, (u32, Probe<f32>)>,
    /// What came of them.
    pub(crate) probed: Reader<'static, Outcome>,
}

/// Most ticks between two packets: orders are carried out at packets, and answered within 50 ms.
const MAX_TICKS_PER_PACKET: u32 = 40;

/// Why a board does not run settings that a scene may have.
pub(crate) enum Unfit {
    /// Another control period than the timer's.
    Period,
    /// Packet boundaries so far apart that the operator would wait longer than an answer may take.
    PacketPeriod,
    /// A velocity that encoders do not measure.
    Velocity,
    /// Settings that nobody runs.
    Refused(Refused<'static>),
}

impl core::fmt::Display for Unfit {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Period => {
                write!(f, "timing.control_period_s must be {}: the board's tick is fixed", pace::PERIOD_S)
            }
            Self::PacketPeriod => {
                write!(f, "timing.ticks_per_packet must be at most {MAX_TICKS_PER_PACKET}: orders wait for a packet")
            }
            Self::Velocity => {
                f.write_str("axis.velocity must be difference, filtered or adaptive: encoders measure no velocity")
            }
            Self::Refused(refused) => refused.fmt(f),
        }
    }
}

/// The settings as this board runs them, turned into what the tick takes.
///
/// # Errors
/// Why this board does not run them.
pub(crate) fn plan(settings: &Settings, number: Number) -> Result<Plan, Unfit> {
    let mut settings = *settings;
    settings.contact.side = match number {
        Number::One => Side::Left,
        Number::Two => Side::Right,
    };
    if settings.timing.control_period_s != pace::PERIOD_S {
        return Err(Unfit::Period);
    }
    if settings.timing.ticks_per_packet > MAX_TICKS_PER_PACKET {
        return Err(Unfit::PacketPeriod);
    }
    if settings.axis.velocity == VelocityName::Measured {
        return Err(Unfit::Velocity);
    }
    haptic_core::device::encoder::check(&settings).map_err(Unfit::Refused)?;
    let scene = Scene::build(&settings).map_err(Unfit::Refused)?;
    // The object starts at zero, so the device starts where it is just clear of it.
    let clear = -Contact::<f32>::build(&settings).clear_of(0.0);
    Ok(Plan { scene, home: [Motion::at(clear), Motion::REST], device: 0 })
}

impl Console {
    /// Does what a line says, and answers. An answer that does not fit is cut: the first words say what matters.
    pub(crate) async fn hear(&mut self, line: &str, to: &mut Answer) {
        let _ = match operator::parse(line) {
            Ok(request) => self.answer(request, to).await,
            Err(misread) => write!(to, "error {}", misread.explain()),
        };
    }

    async fn answer(&mut self, request: Request<'_>, to: &mut Answer) -> core::fmt::Result {
        match request {
            Request::Status => self.status(to),
            Request::Command(command) => self.command(command, to).await,
            Request::Check(joint) => self.probe(Probe::check(&self.applied.settings, joint), to).await,
            Request::Probe(probe) => self.probe(Probe::build(&self.applied.settings, &probe), to).await,
            Request::Probed => self.probed(to),
            Request::Set(key, value) => match self.draft.set(key, value) {
                Ok(()) => write!(to, "ok {key} = {value}"),
                Err(SetError::Unknown) => write!(to, "error there is no key {key}"),
                Err(SetError::Refused(refused)) => write!(to, "error {refused}"),
            },
            Request::Get(key) => match self.draft.get(key) {
                Some(value) => write!(to, "ok {key} = {value}"),
                None => write!(to, "error there is no key {key}"),
            },
            Request::Defaults => {
                self.draft = Kept::default();
                write!(to, "ok the draft holds the defaults")
            }
            Request::Apply => self.apply(to).await,
            Request::Save => self.save(to).await,
            Request::Stream(every) => {
                telemetry::stream(every);
                write!(to, "ok every {every} ticks")
            }
            Request::Capture(ticks) => {
                telemetry::capture(ticks);
                write!(to, "ok the next {ticks} ticks")
            }
        }
    }

    fn status(&self, to: &mut Answer) -> core::fmt::Result {
        let (mode, fault) = status::unpack(tick::STATUS.load(Ordering::Relaxed));
        let number = |word: &core::sync::atomic::AtomicU32| word.load(Ordering::Relaxed);
        write!(
            to,
            "ok board {} {mode} fault {fault} ticks {} overruns {} sent {} dropped {} received {} refused {}; link {}; settings {} {}{}; started: {}{}",
            self.number as u8 + 1,
            number(&tick::TICKS),
            number(&tick::OVERRUNS),
            number(&net::SENT),
            number(&net::DROPPED),
            number(&net::RECEIVED),
            number(&net::REFUSED),
            net::stage(),
            self.origin.explain(),
            number(&storage::SETTINGS_GENERATION),
            if storage::BUSY.load(Ordering::Relaxed) {
                ", saving"
            } else if storage::FAILED.load(Ordering::Relaxed) {
                ", not saved"
            } else {
                ""
            },
            self.cause.stop.explain(),
            self.cause.place,
        )
    }

    async fn command(&mut self, command: Command, to: &mut Answer) -> core::fmt::Result {
        match command {
            Command::Disarm => {
                tick::DISARM.store(true, Ordering::Release);
                return match carried_out(|| !tick::DISARM.load(Ordering::Acquire)).await {
                    true => write!(to, "ok disarmed"),
                    false => unanswered(to),
                };
            }
            Command::Clear => {
                self.unacknowledged = false;
                tick::EMERGENCY.store(false, Ordering::Relaxed);
            }
            Command::Arm => {
                if let Some((first, why)) = self.obstacle() {
                    return write!(to, "error {first}{why}");
                }
                let (mode, fault) = status::unpack(tick::STATUS.load(Ordering::Relaxed));
                if mode == "disarmed" && !tick::CHECKED.load(Ordering::Relaxed) {
                    return write!(
                        to,
                        "error check first: the signs of motor and encoder were not checked, every joint in use"
                    );
                }
                if mode != "disarmed" {
                    return write!(to, "error {mode}, fault {fault}");
                }
            }
        }
        self.orders = self.orders.wrapping_add(1);
        let order = status::order(self.orders, command);
        tick::ORDER.store(order, Ordering::Release);
        if !carried_out(|| tick::DONE.load(Ordering::Acquire) == order).await {
            return unanswered(to);
        }
        let (mode, fault) = status::unpack(tick::STATUS.load(Ordering::Relaxed));
        match (command, mode) {
            (Command::Arm, "armed") | (Command::Clear, "disarmed") => write!(to, "ok {mode}"),
            _ => write!(to, "error {mode}, fault {fault}"),
        }
    }

    /// What stands against motors being on, before the tick is asked: what to do first, and why.
    fn obstacle(&self) -> Option<(&'static str, &'static str)> {
        if self.unacknowledged {
            Some(("clear first: ", self.cause.stop.explain()))
        } else if tick::EMERGENCY.load(Ordering::Relaxed) {
            Some(("clear first: ", "the emergency stop was pressed"))
        } else if !bridges::stop_released() {
            Some(("", "the emergency stop is pressed, or not connected"))
        } else if storage::BUSY.load(Ordering::Acquire) {
            Some(("", "the settings are being saved"))
        } else {
            None
        }
    }

    /// Begins a probe; what comes of it is asked for later, so that `disarm` is heard in between.
    async fn probe(&mut self, probe: Result<Probe<f32>, Refused<'static>>, to: &mut Answer) -> core::fmt::Result {
        if let Some((first, why)) = self.obstacle() {
            return write!(to, "error {first}{why}");
        }
        let (mode, fault) = status::unpack(tick::STATUS.load(Ordering::Relaxed));
        if mode != "disarmed" {
            return write!(to, "error {mode}, fault {fault}");
        }
        let probe = match probe {
            Ok(probe) => probe,
            Err(refused) => return write!(to, "error {refused}"),
        };
        let number = tick::BEGUN.load(Ordering::Relaxed).wrapping_add(1);
        self.probes.write((number, probe));
        if !carried_out(|| tick::BEGUN.load(Ordering::Acquire) == number).await {
            return unanswered(to);
        }
        let (mode, fault) = status::unpack(tick::STATUS.load(Ordering::Relaxed));
        if mode == "faulted" {
            return write!(to, "error {mode}, fault {fault}");
        }
        write!(to, "ok probing joint {} for {} ticks", probe.joint(), probe.ticks())
    }

    fn probed(&mut self, to: &mut Answer) -> core::fmt::Result {
        self.probed.fetch();
        let outcome = *self.probed.get();
        let Outcome { joint, end, most_counts, least_counts, verdict_counts, check } = outcome;
        write!(to, "ok joint {joint} {}", end.name())?;
        if matches!(end, End::None | End::Running) {
            return write!(to, ": {}", end.explain());
        }
        write!(to, " work {most_counts} {least_counts} of {verdict_counts}: {}", end.explain())?;
        if check {
            let verdict = outcome.verdict();
            write!(to, "; {}: {}", verdict.name(), verdict.explain())?;
        }
        Ok(())
    }

    /// What is applied goes to flash. An erase takes longer than an answer may: then `status` says how it ended.
    async fn save(&mut self, to: &mut Answer) -> core::fmt::Result {
        if !disarmed() {
            return write!(to, "error disarm first");
        }
        if !storage::save(&self.applied) {
            return write!(to, "error the settings are being saved");
        }
        match carried_out(|| !storage::BUSY.load(Ordering::Acquire)).await {
            false => write!(to, "ok saving, a few seconds: flash is being erased"),
            true if storage::FAILED.load(Ordering::Relaxed) => write!(to, "error the flash does not take it"),
            true => write!(to, "ok saved"),
        }
    }

    async fn apply(&mut self, to: &mut Answer) -> core::fmt::Result {
        if !disarmed() {
            return write!(to, "error disarm first");
        }
        match plan(&self.draft.settings, self.number) {
            Ok(plan) => {
                let (before, now) = (&self.applied.settings, &self.draft.settings);
                let same = (before.axis.count == now.axis.count)
                    && (before.encoder, before.kinematics, before.motor) == (now.encoder, now.kinematics, now.motor);
                self.device = if same { self.device } else { self.device.wrapping_add(1) };
                self.plans.write(Plan { device: self.device, ..plan });
                self.applied = self.draft;
                net::TOLD.signal(self.draft.settings);
                write!(to, "ok applied")
            }
            Err(why) => write!(to, "error {why}"),
        }
    }
}

fn disarmed() -> bool {
    status::unpack(tick::STATUS.load(Ordering::Relaxed)).0 == "disarmed"
}

/// The tick has not done what it was asked for: it must not do it later either.
fn unanswered(to: &mut Answer) -> core::fmt::Result {
    tick::DISARM.store(true, Ordering::Release);
    write!(to, "error the tick did not answer; motors off")
}

/// Waits up to 50 ms for something to be done.
async fn carried_out(done: impl Fn() -> bool) -> bool {
    for _ in 0..50 {
        if done() {
            return true;
        }
        Timer::after(Duration::from_millis(1)).await;
    }
    done()
}
