//! One peer's augmented open loop and the feedback that closes it, tick by tick.
//!
//! Open loop z⁺ = A·z + B·u: states z ([`State`]) under fast inputs u (`Input`): the contact force, the coordination force,
//! the decoded velocity, the outgoing wave sample. Feedback u = F·z + G·u + H·s, where s is what the packet of this
//! period brought, held for M ticks. G is the algebraic part: inputs of a tick that need each other, which is how the
//! implicit decode is written here (core solves it by hand). Equations: THEORY §2.

use haptic_core::device::velocity::VelocityName;
use haptic_core::object::IntegratorName;

use super::hold::{Held, exponential};
use crate::matrix::Matrix;
use haptic_sim::scene::Scene;

/// What a state of one peer is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub(crate) enum State {
    DevicePosition,
    DeviceVelocity,
    /// Motor force of the tick before.
    DeviceForce,
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
}

/// Open loop and feedback of one peer.
#[derive(Clone, Debug)]
pub(super) struct Peer {
    /// What the states are, in order.
    pub states: Vec<State>,
    /// Which states are sent; as many as there are held inputs s.
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
    /// The peer can stand anywhere: no arm pulls it back.
    pub free: bool,
}

use Input::{Contact, Coordination};
use State::{
    CoordinationForce, DesiredPosition, DesiredVelocity, DeviceForce, DevicePosition, DeviceVelocity, FilteredVelocity,
    LastReading, ObjectForce, ObjectPosition, ObjectVelocity, Outgoing,
};

impl Peer {
    /// Peer `index` of the scene, or `None` where its models are not known here.
    pub(super) fn new(scene: &Scene, index: usize) -> Option<Self> {
        let comm = scene.peer.coordination.comm;
        let (wave, sends) = match comm {
            "power" => (false, vec![ObjectPosition, ObjectVelocity]),
            "wave" | "passive-wave" | "passive-mean" => (true, vec![Outgoing]),
            "none" => (false, vec![]),
            _ => return None,
        };
        let mut states = vec![DevicePosition, DeviceVelocity, DeviceForce, ObjectPosition, ObjectVelocity, ObjectForce];
        if wave {
            states.extend([DesiredPosition, DesiredVelocity, CoordinationForce, Outgoing]);
        }
        match scene.peer.axis.velocity {
            VelocityName::Measured => {}
            VelocityName::Difference => states.push(LastReading),
            VelocityName::Filtered => states.extend([LastReading, FilteredVelocity]),
            #[allow(unreachable_patterns)]
            _ => return None,
        }
        let (z, u, s) = (states.len(), 4, sends.len());
        let mut peer = Self {
            sends,
            a: Matrix::zeros(z, z),
            b: Matrix::zeros(z, u),
            f: Matrix::zeros(u, z),
            g: Matrix::zeros(u, u),
            h: Matrix::zeros(u, s),
            restarts: (comm == "passive-mean").then_some(Outgoing),
            free: scene.users[index].settings.user.arm_stiffness_n_per_m == 0.0,
            states,
        };
        peer.device(scene, index);
        peer.object(scene)?;
        peer.velocity(scene);
        match comm {
            "power" => peer.power(scene),
            "none" => {}
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
        let (device, arm) = (&scene.world.device, &scene.users[index].settings.user);
        let held = Held::exact(
            device.mass_kg + arm.arm_mass_kg,
            device.damping_n_s_per_m + arm.arm_damping_n_s_per_m,
            arm.arm_stiffness_n_per_m,
            device.force_delay_ticks,
            scene.peer.timing.control_period_s,
        );
        self.moves([DevicePosition, DeviceVelocity, DeviceForce], &held, &[(Contact, -1.0)]);
    }

    fn object(&mut self, scene: &Scene) -> Option<()> {
        let (object, period) = (&scene.peer.object, scene.peer.timing.control_period_s);
        let (mass, damping, late) = (object.mass_kg, object.damping_n_s_per_m, object.force_delay_ticks);
        let held = match object.integrator {
            IntegratorName::ForwardEuler => Held::forward_euler(mass, damping, late, period),
            IntegratorName::SemiImplicit => Held::semi_implicit(mass, damping, late, period),
            IntegratorName::Exact => Held::exact(mass, damping, 0.0, late, period),
            #[allow(unreachable_patterns)]
            _ => return None,
        };
        self.moves([ObjectPosition, ObjectVelocity, ObjectForce], &held, &[(Contact, 1.0), (Coordination, 1.0)]);
        Some(())
    }

    /// F_LC = K_LC·(x_h − x_o) + B_LC·(ẋ_h − ẋ_o), with ẋ_h as the estimator gives it.
    fn velocity(&mut self, scene: &Scene) {
        let (contact, period) = (&scene.peer.contact, scene.peer.timing.control_period_s);
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
        for (state, gain) in [(DevicePosition, k), (ObjectPosition, -k), (ObjectVelocity, -b)] {
            let at = self.at(state);
            self.f[(Contact as usize, at)] += gain;
        }
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
    exponential(&faer::mat![[-std::f64::consts::TAU * cutoff_hz * period]])[(0, 0)]
}
