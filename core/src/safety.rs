//! What stands between the computed force and the motor: modes, numbered faults, limits.
//!
//! Forces reach the motors only while [`Mode::Armed`], the duties of a probe only while [`Mode::Probing`]. Any fault turns
//! them off in the same tick and latches; leaving it takes [`Command::Clear`] and then [`Command::Arm`]. No setting
//! switches a guard off. Fault numbers are never reused. Limits come last: whatever the models compute, a force that is commanded is
//! finite, within ±max_force and never grows away from zero faster than the slew limit.
//!
//! **Why only growth is slow.** A force that rises jerks the hand and has to be followed by a current loop; a force that falls ends where the
//! motors are off, which any fault does to the hand at any time. A fall that is held back pushes on after its reason has gone: it gives back more
//! than it took, which is energy out of nothing at a port beside a person. So a force falls to zero as fast as what computes it has it, and rises
//! on the other side of zero as slowly as on this one.

use crate::{num::Scalar, settings::Settings};

/// Reasons with a number, never reused, and a sentence each.
#[doc(hidden)]
#[macro_export]
macro_rules! numbered {
    ($(#[$doc:meta])* pub enum $Name:ident { $( $number:literal $Reason:ident: $explained:literal, )+ }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub enum $Name { $( #[doc = $explained] $Reason = $number ),+ }

        impl $Name {
            /// Every fault, in the order of its number.
            pub const ALL: [Self; [$($number),+].len()] = [$(Self::$Reason),+];

            /// The fault with this number, if there is one.
            pub fn from_number(number: u8) -> Option<Self> {
                Self::ALL.into_iter().find(|reason| *reason as u8 == number)
            }

            /// One sentence for a person.
            pub fn explain(self) -> &'static str {
                match self { $( Self::$Reason => $explained ),+ }
            }
        }
    };
}

numbered! {
    /// Why a peer stopped.
    pub enum Fault {
        1 NonFiniteInput: "a sensor or a packet gave a value that is not a number",
        2 EncoderJump: "an encoder moved further in one tick than the device can",
        3 Overspeed: "braking did not keep the device below 1.5 times safety.max_speed_m_per_s or encoder.max_speed_m_per_s",
        4 ForceSaturated: "the device gave less than the object got, a motor at motor.max_duty, for safety.saturated_ticks",
        5 PeerLost: "the other peer was silent for safety.peer_lost_s",
        6 TickOverrun: "a tick began before the last one ended",
        7 Diverged: "the object ran away, at more than four times safety.max_speed_m_per_s, or a number left its range",
        8 EncoderStuck: "a motor's force changed and its encoder did not count: safety.stuck_duty",
        9 Runaway: "the device ran away against its motor, or was struck: safety.max_hand_power_w",
        10 PeerDelayed: "what the other peer said was older than safety.max_delay_s for safety.peer_lost_s",
        11 ForceTooLong: "the limit of force did not keep it below safety.max_rms_force_n over safety.rms_s",
        12 PowerTooLong: "the limit of force did not keep the power to the hand below safety.max_rms_power_w over safety.rms_s",
        13 OutOfWorkspace: "an axis was further than safety.workspace_m from where the encoders were first read",
        14 BridgeFailed: "a motor bridge reported that it is too hot, carries too much current or has too little supply",
        15 ChipFailed: "the supply, the clock or the core of the board's chip failed: its timer turned the motors off",
        16 MotorTooWarm: "a motor carried more than motor.continuous_a over motor.thermal_s, or its thermistor showed motor.max_temperature_c",
        17 CurrentNotFollowed: "a motor's current was not the one asked for: look at the motor, its wires and its bridge",
        18 CurrentSensor: "a current sensor read the end of its range, or a current with the bridges off",
        19 SupplyOutOfRange: "the supply of the bridges was below motor.min_supply_v or above motor.max_supply_v",
        20 LostCounts: "an encoder's index came at another count than before: it lost or made up counts",
        21 EncoderImplausible: "an encoder's speed was not the one that the motor's voltage and current show",
        22 EncoderWire: "one channel of an encoder showed edges and the other none: look at its wires",
        // 23 to 30 are those of devices at a PC (host-sim/live), 32 to 63 reasons of a board to start anew.
        31 EnableGate: "the gate that enables the amplifiers did not follow its inputs: look at it, and at the wire that shows its output",
        64 LoopMissed: "the current loop missed a period: its converter or the converter's trigger failed",
        65 DriveSilent: "a motor's own controller did not answer for 4 ticks, and may have lost count: look at its bus and its supply",
        66 DriveFailed: "a motor's own controller reported a fault of its own: `status` says which",
        67 DriveTooWarm: "a motor's own controller was too warm",
        68 DriveBusOff: "the board went off the bus of a motor's own controller: look at its wires and its ends",
        69 DriveLetGo: "a motor's own controller stopped without being told to: its watchdog heard no command, or somebody else commands it",
        70 EncoderSilent: "an encoder on SPI gave no whole reading three times in a row: `status` says which; look at its supply and its wires",
        71 EncoderMagnet: "the field of an encoder's magnet was too weak or too strong three times in a row: `status` says which",
        72 Halted: "a debugger halted the board's processor, and nobody saw what the device did",
        73 Thermistor: "the thermistor of a motor read the end of its range: look at its wires, and at motor.thermistor",
    }
}

impl Fault {
    /// Whether the fault casts doubt on the encoders, so that signs are to be checked again ([`crate::device::probe`]).
    pub fn doubts_encoders(self) -> bool {
        matches!(
            self,
            Self::EncoderJump
                | Self::Overspeed
                | Self::EncoderStuck
                | Self::Runaway
                | Self::LostCounts
                | Self::EncoderImplausible
                | Self::EncoderWire
                | Self::DriveSilent
                | Self::EncoderSilent
                | Self::EncoderMagnet
        )
    }

    /// The fault's number, for logs and telemetry.
    pub fn number(self) -> u8 {
        self as u8
    }
}

/// Whether forces reach the motors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// Motors off; positions are sensed.
    #[default]
    Disarmed,
    /// Motors on: forces are rendered.
    Armed,
    /// One motor on, open loop, within the limits of a probe ([`crate::device::probe`]); ends by itself.
    Probing,
    /// Motors off until cleared by command.
    Faulted(Fault),
}

/// What an operator may ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Motors on, from zero force. Only from [`Mode::Disarmed`].
    Arm,
    /// Motors off. From any mode but [`Mode::Faulted`], which stays.
    Disarm,
    /// Forget the fault; the motors stay off.
    Clear,
    /// Sets the joints' zero where they are now; an encoder's index has to be found anew. Only while disarmed.
    Home,
    /// The device comes free of the shared world, which stands where it is ([`crate::device::clutch`]). Only in [`Mode::Armed`], which stays.
    Clutch,
    /// The device takes hold of the shared world again from where it is now. Only in [`Mode::Armed`], which stays.
    Release,
}

impl Mode {
    /// The mode after a command; one that does not apply changes nothing.
    pub fn after(self, command: Command) -> Self {
        match (self, command) {
            (Self::Disarmed, Command::Arm) => Self::Armed,
            (Self::Armed | Self::Probing, Command::Disarm) | (Self::Faulted(_), Command::Clear) => Self::Disarmed,
            (mode, _) => mode,
        }
    }

    /// Name of the mode, for people and programs.
    pub fn name(self) -> &'static str {
        match self {
            Self::Disarmed => "disarmed",
            Self::Armed => "armed",
            Self::Probing => "probing",
            Self::Faulted(_) => "faulted",
        }
    }

    /// Number of the mode: 0 disarmed, 1 armed, 2 faulted, 3 probing.
    pub fn number(self) -> u8 {
        match self {
            Self::Disarmed => 0,
            Self::Armed => 1,
            Self::Faulted(_) => 2,
            Self::Probing => 3,
        }
    }

    /// Number of the latched fault; 0 if there is none.
    pub fn fault_number(self) -> u8 {
        if let Self::Faulted(fault) = self { fault.number() } else { 0 }
    }

    /// The mode called `name`, with the fault numbered `fault` latched (0: none); `None` if there is no such mode.
    pub fn named(name: &str, fault: u8) -> Option<Self> {
        let faulted = Fault::from_number(fault).map(Self::Faulted);
        let modes = [Some(Self::Disarmed), Some(Self::Armed), Some(Self::Probing), faulted];
        modes.into_iter().flatten().find(|mode| mode.name() == name && mode.fault_number() == fault)
    }
}

/// How many times `safety.max_speed_m_per_s` a device may move before its peer faults. Above once that speed it brakes.
const FASTEST: f64 = 1.5;

/// The fastest that a device with these settings may move while armed, m/s: 1.5 times `safety.max_speed_m_per_s`, but no faster than
/// `encoder.max_speed_m_per_s` if that is more than `max_speed_m_per_s`. An encoder that is faster than it may be is not believed.
pub fn fastest_m_per_s(settings: &Settings) -> f64 {
    let allowed = settings.safety.max_speed_m_per_s;
    (FASTEST * allowed).min(settings.encoder.max_speed_m_per_s.max(allowed))
}

/// Largest damping with which a device brakes, N·s/m: a device of 0.1 kg bears it at 1 kHz, with a velocity that is 3 ms old.
pub const MOST_BRAKING: f64 = 20.0;

/// Limits of force, slew and speed.
#[derive(Clone, Copy, Debug)]
pub struct Guard<S> {
    /// Of the forces of this tick.
    pub limits: Limits<S>,
    /// Largest force of either sign in any tick, N.
    pub full_force: S,
    /// Fastest motion while armed at which the device does not brake, m/s.
    pub max_speed: S,
    /// Fastest motion while armed, m/s: [`fastest_m_per_s`].
    pub fastest: S,
    /// Damping with which the device brakes above `max_speed`, N·s/m: all of its force at 1.5 times that, or [`MOST_BRAKING`].
    braking: S,
    /// Fastest that a copy of the object may be, m/s: four times as fast. What a device and its line are within their limits moves none faster.
    pub fastest_copy: S,
    /// Largest distance of an axis from where the encoders were first read, m.
    pub workspace: S,
    /// Ticks that a motor may stand at its largest duty before the peer faults, counted up while it does and down while not.
    pub saturated_ticks: u32,
    /// Packet periods of silence before a fault.
    pub silent_packets: u32,
}

configured!([S: Scalar] Guard<S> { limits, full_force, max_speed, fastest, braking, fastest_copy, workspace, saturated_ticks, silent_packets });

impl<S: Scalar> Guard<S> {
    /// The limits of the scene's table `safety`.
    pub fn build(settings: &Settings) -> Self {
        let safety = &settings.safety;
        let [most, step] =
            [safety.max_force_n, safety.max_slew_n_per_s * settings.timing.control_period_s].map(S::from_f64);
        let most_braking = MOST_BRAKING * settings.scale.force / settings.scale.position;
        let braking = safety.max_force_n / ((FASTEST - 1.0) * safety.max_speed_m_per_s);
        Self {
            limits: Limits { most, step, free: most.min(step) },
            full_force: most,
            max_speed: S::from_f64(safety.max_speed_m_per_s),
            fastest: S::from_f64(fastest_m_per_s(settings)),
            braking: S::from_f64(braking.min(most_braking)),
            fastest_copy: S::from_f64(4.0 * safety.max_speed_m_per_s),
            workspace: S::from_f64(safety.workspace_m),
            saturated_ticks: safety.saturated_ticks,
            silent_packets: settings.timing.packet_periods(safety.peer_lost_s).max(1),
        }
    }

    /// The force (N) with which a device of this velocity (m/s) brakes; 0 up to `max_speed`.
    #[inline]
    pub fn brake(&self, velocity: S) -> S {
        self.braking * (velocity.limit(self.max_speed) - velocity)
    }
}

/// What the forces of a device may be in a tick.
#[derive(Clone, Copy, Debug)]
pub struct Limits<S> {
    /// Largest force of either sign, N: `safety.max_force_n`, or less where its mean would be too much ([`crate::device::envelope`]).
    pub most: S,
    /// Largest growth of a force away from zero in one tick, N.
    pub step: S,
    /// Forces below this (N) are within both, whatever was commanded before.
    pub free: S,
}

configured!([S: Scalar] Limits<S> { most, step, free });

impl<S: Scalar> Limits<S> {
    /// From now on no force is larger than this (N).
    #[inline]
    pub fn ease(&mut self, most: S) {
        (self.most, self.free) = (most, most.min(self.step));
    }

    /// Whether a device can give this force (N) whatever it gave before; most are like this, and nothing else need be asked of them.
    #[inline]
    pub fn is_free(&self, force: S) -> bool {
        force.abs() < self.free
    }

    /// The force (N) that may follow `last` (N) when `wanted` (N) is asked for: within ±most, and no more than a step farther from zero
    /// than `last` was on that side. NaN asks for 0. Without a branch, of which a proof would have to go both ways.
    #[inline]
    pub fn limit(&self, last: S, wanted: S) -> S {
        let (least, most) = (last.min(S::ZERO) - self.step, last.max(S::ZERO) + self.step);
        wanted.limit(self.most).max(least).min(most)
    }

    /// The force on the object (N) whose reaction the device can give after it was commanded `commanded` (N), where `asked` (N) is asked
    /// for; 0 for no number.
    #[inline]
    pub fn reaction(&self, commanded: S, asked: S) -> S {
        -self.limit(commanded, -asked)
    }
}

/// A counter of ticks that goes up while a condition holds and down while it does not, to judge what lasts too long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Patience(u32);

impl Patience {
    /// Takes in one tick; true when the condition has held for `limit` ticks more than it has not.
    #[inline]
    pub fn spent(&mut self, holds: bool, limit: u32) -> bool {
        self.0 = if holds { self.0.saturating_add(1) } else { self.0.saturating_sub(1) };
        self.0 >= limit
    }
}
