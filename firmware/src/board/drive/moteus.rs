//! A moteus controller on FDCAN1 ([`fdcan`], [`firmware_parts::moteus`]): a brushless motor with its own current loop, encoder and watchdog.
//!
//! Each tick sends one command of torque and hears the answer of the tick before, which is where the joint was then. While nothing is wanted of the
//! motor it is told to stop, in every tick, so that its place is known and what stood in its way is cleared.
//!
//! **Off, twice over**: the tick stops it; a tick that does not come, a program that stands, a chip that starts anew send nothing, and the controller
//! lets go by its own watchdog ([`firmware_parts::moteus::WATCHDOG_MS`]). The emergency stop's first contact breaks the timer as it does with
//! bridges, which nothing hangs at here: the next tick sees it and stops the motor; its second contact cuts the controller's supply.

use cohold_core::device::encoder::{Counts, Marks};
use cohold_core::device::stage::Measured;
use cohold_core::safety::Fault;
use cohold_core::settings::{Refused, Settings};
use firmware_parts::image::{Actuators, JOINTS};
use firmware_parts::moteus::{Design, Motor, Told, Trouble};
use firmware_parts::rate::Rate;
use firmware_parts::signals::Signals;

use super::{Cut, Drive, Sensed, fdcan};
use crate::board::bridges;

/// Identifiers: of a question to motor 1 from 0 that wants an answer, and of that answer, as the first word of a frame has them.
const QUESTION: u32 = 0x8001;
const ANSWER: u32 = 0x100 << 18;

/// The first joint's motor; the image has no other.
pub(crate) struct Moteus {
    motor: Motor,
    /// It is driven.
    driving: bool,
    signals: &'static Signals,
}

impl Drive for Moteus {
    type Plan = Design;

    fn plan(settings: &Settings, _: Rate) -> Result<Self::Plan, Refused<'static>> {
        Design::build(settings)
    }

    fn start(signals: &'static Signals) -> Self {
        Self { motor: Motor::default(), driving: false, signals }
    }

    fn says(signals: &Signals) -> [Option<&'static str>; 2] {
        [signals.drive.get(), signals.drive_last.get()].map(Trouble::explain)
    }

    #[inline(always)]
    fn sense(&mut self, plan: &Self::Plan, _: &mut Option<Measured<JOINTS>>) -> Sensed {
        let answer = fdcan::newest(ANSWER).and_then(|words| Told::read(&words));
        let bus_off = fdcan::is_off();
        let fault = self.motor.hear(plan, answer, bus_off);
        let trouble = self.motor.trouble();
        self.signals.drive.set(trouble);
        if fault.is_some() && self.driving {
            self.signals.drive_last.set(trouble);
        }
        let mut counts = [Counts(0); JOINTS];
        counts[0] = self.motor.counts();
        Sensed { counts, fault }
    }

    #[inline(always)]
    fn marks(&mut self) -> Option<[Marks; JOINTS]> {
        None
    }

    #[inline(always)]
    fn went_off(&self) -> bool {
        self.driving && !bridges::live()
    }

    fn cut(&self, _: &Self::Plan) -> Cut {
        bridges::cut()
    }

    #[inline(always)]
    fn act(&mut self, plan: &Self::Plan, actuators: &Actuators, _: [Counts; JOINTS]) -> Result<(), Fault> {
        if !self.driving {
            self.driving = true;
            self.signals.drive_last.set(Trouble::None);
            bridges::forget();
            bridges::enable(true);
            bridges::on();
        }
        fdcan::send(QUESTION, &self.motor.drive(plan, actuators.duties[0]));
        Ok(())
    }

    #[inline(always)]
    fn rest(&mut self, _: &Self::Plan, _: [Counts; JOINTS]) {
        bridges::off();
        self.driving = false;
        if self.motor.trouble() != Trouble::None {
            fdcan::come_back();
        }
        fdcan::send(QUESTION, self.motor.stop());
    }
}
