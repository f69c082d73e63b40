//! Fractal impedance: a spring to the other copy that pulls as a spring while they part, and brakes on the second half of the way while they come
//! together (Babarahmati, Tiseo, Smith, Lin, Erden & Mistry 2019; Tiseo et al. 2020, arXiv 2011.00390, eq. 1; for teleoperation Babarahmati, Tiseo, Rouxel,
//! Li & Mistry 2021, arXiv 2003.01463).
//!
//! With x̃ = x_d − x_o, x_d the other copy's position as last received, and x̃_M the x̃ at which the two began to come together,
//!
//! > divergence, |x̃| grows:    F = K_T·x̃
//! > convergence, |x̃| falls:   F = K_T·(2x̃ − x̃_M)
//!
//! a spring of 2K_T about half of the way. F is the same where the phases meet, x̃ = x̃_M. Whether |x̃| grows is seen from one tick to the next, packets included, as in the
//! published algorithm; where x̃ changes its sign there is divergence again.
//!
//! **Passive to a point that stands.** With V = ½K_T·x̃² in divergence and V = ½K_T·(x̃² + (x̃ − x̃_M)²) in convergence F·v = −dV/dt in either; divergence to
//! convergence leaves V as it is, convergence to divergence takes ½K_T·(x̃ − x̃_M)² away, whenever it happens. So ∫F·ẋ_o dt ≤ V at first, to the tick
//! by the midpoint rule, without a damper. A way to x̃_M and back to 0 costs ½K_T·x̃_M²: all of it. A mass m that is let go of at x̃_M comes to 0 after
//! π·√(m/2K_T) at rest.
//!
//! **Not passive to a point that moves**: x_d comes late and in steps, and a step of x_d does work that nobody pays for. The published claim is that the damping
//! of every swing outweighs that; it is not a proof, and none is promised here. Two copies that nobody holds, 310 N/m: stable without a damper at 8 ms each way,
//! where a spring both ways is not; not at 20 ms. So B_T is there, a damper to the ground that the papers do not have: 4 N·s/m carry 20 ms, 8 carry 50, where
//! a spring both ways takes K_T·T. K_T is constant here; the published force profile may bend and saturate, the limits of a device are in
//! [`cohold_core::safety`].
//!
//! **Promises** that nothing drifts, for positions are what is sent. It is not linear: no matrix says where it is stable.

use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::port::{Port, Solve, met_midway};
use cohold_core::settings::{Refused, Settings};

/// A spring that is another one on the way back.
#[derive(Clone, Copy, Debug)]
pub struct FractalImpedance<S> {
    spring: Spring<S>,
    /// K_T·T_c/2, N·s/m.
    half_step: S,
}

configured!([S: Scalar] FractalImpedance<S> { spring, half_step });

/// Where the other copy is, and in which phase the spring is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FractalImpedanceState<S> {
    /// x_d, m.
    desired: S,
    /// x̃ of the tick before, m.
    before: S,
    /// x̃_M, m; 0 in divergence.
    turned: S,
}

visited!([S: Scalar] FractalImpedanceState<S> { desired, before, turned });

impl<S: Scalar> Law<S> for FractalImpedance<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "fractal-impedance",
        // The networks of the campaign have up to 200 ms each way and hold a packet for 8: with 8 N·s/m the pair is unstable on three of 38.
        gains: &["coordination.stiffness_n_per_m=310", "coordination.damping_n_s_per_m=12"],
        source: "Tiseo et al. 2020 (arXiv 2011.00390), eq. 1; Babarahmati et al. 2021 (arXiv 2003.01463)",
        promises: &[Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    type State = FractalImpedanceState<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let half_step = met_midway(settings.coordination.stiffness_n_per_m, 0.0, settings);
        Ok(Self { spring: Spring::build(settings), half_step: S::from_f64(half_step) })
    }

    fn start(&self, local: Motion<S>) -> FractalImpedanceState<S> {
        FractalImpedanceState { desired: local.position, ..FractalImpedanceState::default() }
    }

    fn receive(&self, state: &mut FractalImpedanceState<S>, packet: Packet<S>) {
        state.desired = packet.motion.position;
    }

    #[inline]
    fn couple(
        &self,
        state: &mut FractalImpedanceState<S>,
        observed: &Observation<S>,
        solve: impl Solve<S>,
    ) -> Coupled<S> {
        let stretch = state.desired - observed.local.position;
        let grows = stretch.abs() > state.before.abs();
        state.before = stretch;
        if state.turned == S::ZERO {
            state.turned = stretch;
        }
        // One side of 0, and toward it.
        let converges = !grows && state.turned * stretch > S::ZERO;
        let (mut pull, mut impedance) = (stretch, self.half_step);
        if converges {
            pull = stretch + stretch - state.turned;
            impedance = impedance + impedance;
        } else {
            state.turned = S::ZERO;
        }
        let port = Port::new(self.spring.stiffness * pull, self.spring.damping);
        let force = if solve.is_staged() {
            port.at(observed.local.velocity)
        } else {
            let port = Port { impedance: port.impedance + impedance, ..port };
            port.at(solve.velocity(port))
        };
        // What is sent is a position: between two packets the far end of the spring stands, and no energy crosses.
        Coupled { desired: Motion::at(state.desired), force, ..Coupled::default() }
    }

    fn send(&self, _: &FractalImpedanceState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: Motion::at(local.position), ..Packet::default() }
    }
}
