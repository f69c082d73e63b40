//! Four channels: position and force both ways, the reference of transparency where there is no delay (Lawrence 1993).
//!
//! Beside its motion a peer sends what its own hand pushes on its copy with, F_LC of the newest tick, as the packet's wave field (N).
//! With C = K_T + B_T·s (the paper's C₁ and −C₄), λ = C₂ = C₃ on the force of the other hand and μ = C₅ = C₆ on the own one,
//!
//! > F_T1 = C·(x_2 − x_1) + λ·F_LC2 + μ·F_LC1 − d·ẋ_1   and the same with 1 and 2 exchanged, so that for b_O = d = 0
//! > m_O·s²·x_1 = (1 + μ)·F_LC1 + λ·F_LC2 + C·(x_2 − x_1).
//!
//! The difference of both copies is (m_O·s² + 2C)·(x_1 − x_2) = (1 + μ − λ)·(F_LC1 − F_LC2): **with λ = 1 + μ nothing drives it** and x_1 = x_2
//! whatever K_T is and the hands do; else they part by (1 + μ − λ)·ΔF_LC/(2K_T). The sum is m_O·s²·x = λ·(F_LC1 + F_LC2). In Hannaford's hybrid matrix,
//! \[F_LC1; −ẋ_2\] = H·\[ẋ_1; −F_LC2\],
//!
//! > h11 = m_O·s/λ,   h12 = 1,   h21 = −1,   h22 = 0:
//!
//! a hand feels m_O·s/λ and the impedance of the other hand. The shared object is there once, where most laws make it weigh 2·m_O; more local feedback μ
//! makes it lighter still. Lawrence's accelerations (the mass in C₁ and C₄), which would take the last m_O away, are left out: here m_O is the object
//! that is meant to be felt, and each peer's acceleration would need the other's of the same instant.
//!
//! **Promises** nothing: positions are sent, so that nothing drifts while it is stable, but a push that comes back late makes energy, the more the larger λ is.
//! What arrives does work on the copy at once and is booked as energy from the network.
//!
//! **At the device** (`four_channel.at_device`), as Lawrence has it, there is no copy between hand and law: the motion is the device's own, and F_T acts on the
//! device ([`Law::acts_on_device`]). What a hand pushes with is not measured there, so that none is sent; told is the force that acts, as the limits let it
//! through. With no spring (K_T = B_T = 0) and λ = 1 that is a device which is told a force and tells where it is, and no more: what a PC's peer drives.
//!
//! Where the copy is moved by ports its contact is solved together with the law, which learns F_LC from how the copy moved,
//! F_LC = (2m_O/T_c)·(v − ẋ_o) + b_O·v − F_T, in time for what is sent; its own hand it then feeds back a tick late.

use super::bounds::WITHIN;
use super::{Coupled, Law, LawInfo, Observation, Packet, Spring};
use crate::num::{Motion, Scalar};
use crate::object::{Port, Solve};
use crate::settings::{Allowed, Key, Refused, Settings};

const REMOTE: Key = Key::number("four_channel.remote_force", 1.0, [0.0, 5.0], "")
    .means("Four channels: how much of the other hand's force acts on the copy; transparent at 1 + local_force.");
const LOCAL: Key = Key::number("four_channel.local_force", 0.0, [-0.9, 4.0], "")
    .means("Four channels: how much more of the own hand's force acts on the copy (local force feedback).");
const DAMPING: Key = Key::number("four_channel.local_damping_n_s_per_m", 0.0, [0.0, 1e3], "N·s/m")
    .means("Four channels: damper d of the copy to the ground (local controller).");

const AT_DEVICE: Key = Key::flag("four_channel.at_device", false).means(
    "Four channels: there is no copy, and the law's force acts on the device itself; told is the force that acts.",
);

/// A spring to where the other copy is, and the forces of both hands.
#[derive(Clone, Copy, Debug)]
pub struct FourChannel<S> {
    spring: Spring<S>,
    /// λ.
    remote: S,
    /// μ.
    local: S,
    /// 2m_O/T_c, N·s/m.
    inertia: S,
    /// b_O, N·s/m.
    damping: S,
    /// d, N·s/m.
    ground: S,
    at_device: bool,
    /// What may be told of a device that has left its workspace, or is too fast, m and m/s: the other end takes no more.
    most_told: [S; 2],
}

configured!([S: Scalar] FourChannel<S> { spring, remote, local, inertia, damping, ground, at_device, most_told });

/// The other peer's motion and hand force as last received, and the own hand's force, which is sent.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FourChannelState<S> {
    /// x_d, ẋ_d.
    desired: Motion<S>,
    /// The other hand's force on its copy, N.
    remote_force: S,
    /// The own hand's, of the newest tick that is known, N.
    own_force: S,
}

visited!([S: Scalar] FourChannelState<S> { desired, remote_force, own_force });

impl<S: Scalar> FourChannel<S> {
    /// λ·F_LC of the other hand and μ·F_LC of the own, N.
    #[inline]
    fn hands(&self, state: &FourChannelState<S>) -> S {
        self.remote * state.remote_force + self.local * state.own_force
    }

    /// Motion of a device as a packet may say it.
    fn told(&self, device: Motion<S>) -> Motion<S> {
        let [position, velocity] = self.most_told;
        Motion::new(device.position.limit(position), device.velocity.limit(velocity))
    }
}

impl<S: Scalar> Law<S> for FourChannel<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "four-channel",
        keys: &[REMOTE, LOCAL, DAMPING, AT_DEVICE],
        // Transparent at 1, without delay; at 8 ms each way stable to some 0.4. Without local damping it is so on few networks that lose or jitter.
        gains: &[
            "coordination.stiffness_n_per_m=310",
            "coordination.damping_n_s_per_m=6",
            "four_channel.remote_force=0.3",
            "four_channel.local_damping_n_s_per_m=8",
        ],
        source: "Lawrence 1993, transparency-optimised law (C2 = 1 + C6, C3 = 1 + C5, C4 = -C1), without accelerations",
        ..LawInfo::MOTION
    }];
    type State = FourChannelState<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let object = &settings.object;
        let at_device = settings.own(&AT_DEVICE) != 0.0;
        if at_device && object.integrator.solves() {
            let staged = Allowed::Only("\"forward-euler\", \"semi-implicit\" or \"exact\" with four_channel.at_device");
            return Err(settings.refuses("object.integrator", staged));
        }
        let safety = settings.in_the_world().safety;
        Ok(Self {
            spring: Spring::build(settings),
            remote: S::from_f64(settings.own(&REMOTE)),
            local: S::from_f64(settings.own(&LOCAL)),
            inertia: S::from_f64(2.0 * object.mass_kg / settings.timing.control_period_s),
            damping: S::from_f64(object.damping_n_s_per_m),
            ground: S::from_f64(settings.own(&DAMPING)),
            at_device,
            most_told: [2.0 * safety.workspace_m, safety.max_speed_m_per_s].map(|most| S::from_f64(WITHIN * most)),
        })
    }

    fn start(&self, local: Motion<S>) -> FourChannelState<S> {
        FourChannelState { desired: local, ..FourChannelState::default() }
    }

    fn receive(&self, state: &mut FourChannelState<S>, packet: Packet<S>) {
        (state.desired, state.remote_force) = (packet.motion, packet.wave);
    }

    #[inline]
    fn couple(&self, state: &mut FourChannelState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let (local, desired) = (observed.local, state.desired);
        let (velocity, spring, hands);
        if solve.is_staged() {
            state.own_force = observed.contact_force;
            (velocity, hands) = (local.velocity, self.hands(state));
            spring = self.spring.force(desired, local, solve) - self.ground * velocity;
        } else {
            let mut port = self.spring.port(desired, local);
            port.impedance = port.impedance + self.ground;
            hands = self.hands(state);
            velocity = solve.velocity(port + Port::of_force(hands));
            spring = port.at(velocity);
            let inert = self.inertia * (velocity - local.velocity) + self.damping * velocity;
            state.own_force = inert - (spring + hands);
        }
        // The spring's power comes in where the other copy moves, the other hand's where this one does; the damper's nowhere.
        let between = spring + self.ground * velocity;
        let power = between * desired.velocity + self.remote * state.remote_force * velocity;
        Coupled::of_power(desired, spring + hands, power)
    }

    fn send(&self, state: &FourChannelState<S>, local: Motion<S>) -> Packet<S> {
        if self.at_device {
            let wave_integral = (-state.own_force).to_counter();
            return Packet { motion: self.told(local), wave_integral, ..Packet::default() };
        }
        Packet { motion: local, wave: state.own_force, ..Packet::default() }
    }

    fn acts_on_device(&self) -> bool {
        self.at_device
    }

    /// What does not act on a device is none.
    fn idle(&self, packet: Packet<S>, local: Motion<S>) -> Packet<S> {
        let motion = Motion::at(if self.at_device { self.told(local).position } else { local.position });
        Packet { motion, wave: S::ZERO, wave_integral: S::Counter::ZERO, ..packet }
    }
}
