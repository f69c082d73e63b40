//! One peer's augmented open loop and the feedback that closes it, tick by tick.
//!
//! Open loop z⁺ = A·z + B·u: states z ([`State`]) under fast inputs u (`Input`): the contact force, the coordination force,
//! the decoded velocity, the outgoing wave sample, the object's mean velocity. Feedback u = F·z + G·u + H·s, where s is what the packet of this
//! period brought, held for M ticks. G is the algebraic part: inputs of a tick that need each other, which is how the
//! implicit decode and the midpoint rule's one solve are written here (core solves them by hand). Equations: THEORY §2, §7.

use cohold_core::device::velocity::VelocityName;
use cohold_core::names::FixtureName;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;

use super::hold::Held;
use super::law::{TAUTNESS, number};
use super::rows;
use crate::exponential::exponential;
use crate::matrix::Matrix;

/// What a state of one peer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum State {
    DevicePosition,
    DeviceVelocity,
    /// Motor force of the tick before.
    DeviceForce,
    /// A motor force that the device holds back, of which 0 acts next.
    DeviceWaiting(usize),
    ObjectPosition,
    ObjectVelocity,
    /// F_LC + F_T of the tick before.
    ObjectForce,
    DesiredPosition,
    DesiredVelocity,
    /// F_T of the tick before.
    CoordinationForce,
    /// u_out or y of the tick before, or the mean so far.
    Outgoing,
    /// What a self-timed line has heard and not yet emitted, √W·s.
    Outstanding,
    /// f₁, f₂ and g of a taut line's end (THEORY §15).
    TautSooner,
    TautForce,
    TautWay,
    /// Device position of the tick before.
    LastReading,
    FilteredVelocity,
}

/// A fast input. Order of the columns of B and G, and of the rows of F, G and H.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Input {
    Contact,
    Coordination,
    Decoded,
    Wave,
    /// u_in of a line that emits the mean of what is outstanding.
    Emitted,
    /// v: the object's mean velocity through the tick, where it is moved by ports.
    Mean,
}

/// Open loop and feedback of one peer.
#[derive(Clone, Debug)]
pub(super) struct ConstructedPeer {
    /// What the states are, in order.
    pub states: Vec<State>,
    /// The states that are sent; as many as there are held inputs s.
    pub sends: Vec<State>,
    /// State → next state.
    pub a: Matrix,
    /// Fast input → next state.
    pub b: Matrix,
    /// State → fast input.
    pub f: Matrix,
    /// Fast input → fast input of the same tick.
    pub g: Matrix,
    /// Held input → fast input.
    pub h: Matrix,
    /// A state that starts from zero in every period, once it has been sent.
    pub restarts: Option<State>,
    force_timing: ForceTiming,
    /// The peer can stand anywhere: no arm pulls it back.
    pub free: bool,
}

/// How the forces of a tick meet the object.
#[derive(Clone, Copy, Debug, PartialEq)]
enum ForceTiming {
    /// As it was when the tick began.
    Before,
    /// Where it is after this part of the tick: midway, or as it ends.
    Within(f64),
}

use Input::{Contact, Coordination, Mean};
use State::{
    CoordinationForce, DesiredPosition, DesiredVelocity, DeviceForce, DevicePosition, DeviceVelocity, DeviceWaiting,
    FilteredVelocity, LastReading, ObjectForce, ObjectPosition, ObjectVelocity, Outgoing, Outstanding, TautForce,
    TautSooner, TautWay,
};

impl ConstructedPeer {
    /// Peer `index` of the scene, or `None` where its models are not known here.
    pub(super) fn new(scene: &Scene, index: usize) -> Option<Self> {
        if scene.peers()[index].fixture.kind != FixtureName::None || scene.is_shared_along_several() {
            return None;
        }
        let law = scene.peer.coordination.comm;
        let (wave, sends) = match law {
            "power" => (false, vec![ObjectPosition, ObjectVelocity]),
            "wave" | "passive-wave" | "passive-mean" | "self-timed" => (true, vec![Outgoing]),
            "none" => (false, vec![]),
            _ => return None,
        };
        let mut states = vec![DevicePosition, DeviceVelocity, DeviceForce];
        states.extend((0..scene.devices()[index].delay().0).map(DeviceWaiting));
        states.extend([ObjectPosition, ObjectVelocity]);
        let force_timing = match scene.peer.object.integrator {
            IntegratorName::Midpoint => ForceTiming::Within(0.5),
            IntegratorName::BackwardEuler => ForceTiming::Within(1.0),
            _ => ForceTiming::Before,
        };
        if force_timing == ForceTiming::Before {
            states.push(ObjectForce);
        }
        if wave {
            states.extend([DesiredPosition, DesiredVelocity, CoordinationForce, Outgoing]);
        }
        if law == "self-timed" {
            states.push(Outstanding);
            if number(scene, TAUTNESS) > 0.0 {
                states.extend([TautSooner, TautForce, TautWay]);
            }
        }
        match scene.peer.axis.velocity {
            VelocityName::Measured => {}
            VelocityName::Difference => states.push(LastReading),
            VelocityName::Filtered => states.extend([LastReading, FilteredVelocity]),
            #[allow(unreachable_patterns)]
            _ => return None,
        }
        let (z, u, s) = (states.len(), 6, sends.len());
        let mut peer = Self {
            sends,
            a: Matrix::zeros(z, z),
            b: Matrix::zeros(z, u),
            f: Matrix::zeros(u, z),
            g: Matrix::zeros(u, u),
            h: Matrix::zeros(u, s),
            force_timing,
            restarts: matches!(law, "passive-mean" | "self-timed").then_some(Outgoing),
            free: scene.users[index].settings.user.arm_stiffness_n_per_m == 0.0,
            states,
        };
        peer.device(scene, index);
        peer.object(scene)?;
        peer.velocity(scene, index);
        match law {
            "power" => peer.power(scene),
            "none" => {}
            "self-timed" => {
                peer.emitted(scene)?;
                peer.wave(scene);
            }
            _ => peer.wave(scene),
        }
        Some(peer)
    }

    /// Where a state stands; states that are asked for are there.
    pub(super) fn at(&self, state: State) -> usize {
        self.states.iter().position(|known| *known == state).unwrap_or(usize::MAX)
    }

    fn moves(&mut self, body: [State; 3], held: &Held, forces: &[(Input, f64)]) {
        let [position, velocity, force] = body.map(|state| self.at(state));
        for (row, (i, at)) in [position, velocity].into_iter().enumerate().map(|(row, at)| (row, (row, at))) {
            self.a[(at, position)] = held.motion[i][0];
            self.a[(at, velocity)] = held.motion[i][1];
            self.a[(at, force)] = held.before[row];
            for (input, sign) in forces {
                self.b[(at, *input as usize)] = sign * held.now[row];
            }
        }
        for (input, sign) in forces {
            self.b[(force, *input as usize)] = *sign;
        }
    }

    fn device(&mut self, scene: &Scene, index: usize) {
        let (device, arm) = (&scene.devices()[index], &scene.users[index].settings.user);
        let held = Held::exact(
            device.mass_kg + arm.arm_mass_kg,
            device.damping_n_s_per_m + arm.arm_damping_n_s_per_m,
            arm.arm_stiffness_n_per_m,
            device.delay().1,
            scene.peer.timing.control_period_s,
        );
        let Some(newest) = device.delay().0.checked_sub(1) else {
            self.moves([DevicePosition, DeviceVelocity, DeviceForce], &held, &[(Contact, -1.0)]);
            return;
        };
        // What is felt now acts when all that waits has.
        self.moves([DevicePosition, DeviceVelocity, DeviceForce], &held, &[]);
        let [position, velocity, force, next] =
            [DevicePosition, DeviceVelocity, DeviceForce, DeviceWaiting(0)].map(|state| self.at(state));
        (self.a[(position, next)], self.a[(velocity, next)]) = (held.now[0], held.now[1]);
        self.a[(force, next)] = 1.0;
        for at in 0..newest {
            let (to, from) = (self.at(DeviceWaiting(at)), self.at(DeviceWaiting(at + 1)));
            self.a[(to, from)] = 1.0;
        }
        let newest = self.at(DeviceWaiting(newest));
        self.b[(newest, Contact as usize)] = -1.0;
    }

    fn object(&mut self, scene: &Scene) -> Option<()> {
        let (object, period) = (&scene.peer.object, scene.peer.timing.control_period_s);
        let (mass, damping, late) = (object.mass_kg, object.damping_n_s_per_m, object.force_delay_ticks);
        let held = match object.integrator {
            IntegratorName::ForwardEuler => Held::forward_euler(mass, damping, late, period),
            IntegratorName::SemiImplicit => Held::semi_implicit(mass, damping, late, period),
            IntegratorName::Exact => Held::exact(mass, damping, 0.0, late, period),
            IntegratorName::Midpoint | IntegratorName::BackwardEuler => {
                self.moved_by_ports(mass, damping, period);
                return Some(());
            }
            #[allow(unreachable_patterns)]
            _ => return None,
        };
        self.moves([ObjectPosition, ObjectVelocity, ObjectForce], &held, &[(Contact, 1.0), (Coordination, 1.0)]);
        Some(())
    }

    /// v = ẋ_o + θ·T_c/m_O·(F_LC + F_T − b_O·v), x_o ← x_o + T_c·v, ẋ_o ← ẋ_o + (v − ẋ_o)/θ: with θ = ½ the midpoint rule,
    /// with 1 backward Euler.
    fn moved_by_ports(&mut self, mass: f64, damping: f64, period: f64) {
        let Some(part) = self.within() else { return };
        let [position, velocity] = [ObjectPosition, ObjectVelocity].map(|state| self.at(state));
        let mean = Mean as usize;
        self.f[(mean, velocity)] = 1.0;
        for force in [Contact, Coordination] {
            self.g[(mean, force as usize)] = part * period / mass;
        }
        self.g[(mean, mean)] = -part * period / mass * damping;
        self.a[(position, position)] = 1.0;
        self.b[(position, mean)] = period;
        self.a[(velocity, velocity)] = 1.0 - 1.0 / part;
        self.b[(velocity, mean)] = 1.0 / part;
    }

    /// What a force with this stiffness and damping toward the object takes from where the object is: −K·x_o − B·ẋ_o as the
    /// tick begins, or both after a part of the tick, −K·(x_o + θ·T_c·v) − B·v.
    pub(super) fn resist(&mut self, force: Input, stiffness: f64, damping: f64, period: f64) {
        let [position, velocity] = [ObjectPosition, ObjectVelocity].map(|state| self.at(state));
        let row = force as usize;
        self.f[(row, position)] -= stiffness;
        match self.force_timing {
            ForceTiming::Before => self.f[(row, velocity)] -= damping,
            ForceTiming::Within(part) => self.g[(row, Mean as usize)] -= stiffness * part * period + damping,
        }
    }

    /// θ, if the object is moved by ports: after which part of a tick forces are taken.
    pub(super) fn within(&self) -> Option<f64> {
        match self.force_timing {
            ForceTiming::Before => None,
            ForceTiming::Within(part) => Some(part),
        }
    }

    /// F_LC = K_LC·(x_h − x_o) + B_LC·(ẋ_h − ẋ_o), with ẋ_h as the estimator gives it.
    fn velocity(&mut self, scene: &Scene, index: usize) {
        let (contact, period) = (&scene.peers()[index].contact, scene.peer.timing.control_period_s);
        let (k, b) = (contact.stiffness_n_per_m, contact.damping_n_s_per_m);
        let estimate: Vec<(State, f64)> = match scene.peer.axis.velocity {
            VelocityName::Difference => vec![(DevicePosition, 1.0 / period), (LastReading, -1.0 / period)],
            VelocityName::Filtered => {
                let keep = decay(scene.peer.axis.velocity_cutoff_hz, period);
                let share = (1.0 - keep) / period;
                vec![(DevicePosition, share), (LastReading, -share), (FilteredVelocity, keep)]
            }
            _ => vec![(DeviceVelocity, 1.0)],
        };
        let device = self.at(DevicePosition);
        self.f[(Contact as usize, device)] += k;
        self.resist(Contact, k, b, period);
        for (state, share) in estimate {
            let at = self.at(state);
            self.f[(Contact as usize, at)] += b * share;
            if self.states.contains(&FilteredVelocity) {
                let filtered = self.at(FilteredVelocity);
                self.a[(filtered, at)] = share;
            }
        }
        if self.states.contains(&LastReading) {
            let (last, device) = (self.at(LastReading), self.at(DevicePosition));
            self.a[(last, device)] = 1.0;
        }
    }
}

/// What is left after one period (s) of a first-order lag with this cutoff (Hz).
pub(super) fn decay(cutoff_hz: f64, period: f64) -> f64 {
    exponential(&rows([[-std::f64::consts::TAU * cutoff_hz * period]]))[(0, 0)]
}
