//! A drive: what turns a command into a force at the motors, chosen when the image is built.
//!
//! | drive | makes the current | joints are read by | feature |
//! |---|---|---|---|
//! | `pwm` | the board's own loop, or an amplifier behind the PWM; `motor.drive` says which | quadrature counters | none |
//! | `pwm` | the same | absolute encoders on SPI | `spi-encoders` |
//! | `moteus` | a controller with its own loop, on a CAN bus | that controller's encoder | `moteus` |
//!
//! The tick knows this page only ([`Drive`]): it senses, asks whether the drive went off by itself, has it act, and lets it rest. An image has
//! the code of its own drive and of no other.

#[cfg(feature = "moteus")]
pub(crate) mod fdcan;
#[cfg(feature = "moteus")]
mod moteus;
#[cfg(not(feature = "moteus"))]
mod pwm;

use core::fmt::Debug;

use cohold_core::device::encoder::{Counts, Marks};
use cohold_core::device::stage::Measured;
use cohold_core::safety::Fault;
use cohold_core::settings::{Refused, Settings};
use firmware_parts::image::{Actuators, JOINTS};
use firmware_parts::rate::Rate;
use firmware_parts::signals::Signals;

/// The drive of this image.
#[cfg(not(feature = "moteus"))]
pub(crate) type Fitted = pwm::Pwm;
/// The drive of this image.
#[cfg(feature = "moteus")]
pub(crate) type Fitted = moteus::Moteus;
/// What the settings make of it.
pub(crate) type Plan = <Fitted as Drive>::Plan;

/// What a drive has at the beginning of a tick.
pub(crate) struct Sensed {
    /// Where the joints are.
    pub(crate) counts: [Counts; JOINTS],
    /// What it has against itself: motors off.
    pub(crate) fault: Option<Fault>,
}

/// Why a drive went off by itself.
pub(crate) struct Cut {
    /// The emergency stop was pressed.
    pub(crate) by_stop: bool,
    /// Something failed.
    pub(crate) fault: Option<Fault>,
}

/// What is asked of a drive: its plan, its start and what it says by tasks, everything else by the tick, where nothing panics and nothing waits.
pub(crate) trait Drive: Sized {
    /// What the settings make of it.
    type Plan: Copy + Debug;

    /// Of these settings, with ticks at this rate.
    ///
    /// # Errors
    /// It cannot do what they ask for.
    fn plan(settings: &Settings, rate: Rate) -> Result<Self::Plan, Refused<'static>>;

    /// The only one; call once, before the tick runs.
    fn start(signals: &'static Signals) -> Self;

    /// What stands against driving it now, and what it turned the motors off for since they were last on; one sentence each, for a person.
    fn says(signals: &Signals) -> [Option<&'static str>; 2];

    /// At the beginning of a tick: what it has read, and in `stage` what its power stage measured since the tick before; none of a drive that does
    /// not tell.
    fn sense(&mut self, plan: &Self::Plan, stage: &mut Option<Measured<JOINTS>>) -> Sensed;

    /// Marks that the encoders showed since this was asked last; none where there were none, as in most ticks.
    fn marks(&mut self) -> Option<[Marks; JOINTS]>;

    /// Whether it was driven, and is off without having been told so.
    fn went_off(&self) -> bool;

    /// After that: why.
    fn cut(&self, plan: &Self::Plan) -> Cut;

    /// Does what the peer wants, from its arming on; `counts` are those of this tick.
    ///
    /// # Errors
    /// It cannot: motors off.
    fn act(&mut self, plan: &Self::Plan, actuators: &Actuators, counts: [Counts; JOINTS]) -> Result<(), Fault>;

    /// Motors off, in every tick that wants nothing of them.
    fn rest(&mut self, plan: &Self::Plan, counts: [Counts; JOINTS]);
}

#[cfg(all(feature = "spi-encoders", any(feature = "moteus", feature = "three-axes")))]
compile_error!(
    "--features spi-encoders reads the joints of one or two motors behind the PWM, and goes with no other drive"
);
#[cfg(all(feature = "moteus", feature = "three-axes"))]
compile_error!(
    "an image has one drive: --features moteus drives one motor, and --features three-axes is for three behind the PWM"
);
