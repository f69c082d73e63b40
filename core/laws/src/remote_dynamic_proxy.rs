//! Remote dynamic proxy: a body of its own stands for the remote copy, and moves on smoothly between packets (Li & Constantinescu 2010).
//!
//! What arrives drives a proxy of mass m_p through the network's coupling K_p, B_p; the local copy hangs on the proxy by K_T, B_T:
//!
//! > m_p·ẍ_p = K_p·(x_r − x_p) + B_p·(ẋ_r − ẋ_p) − F_T,   F_T = K_T·(x_p − x_o) + B_T·(ẋ_p − ẋ_o)
//!
//! with x_r, ẋ_r as last received, held between packets. So x_d = x_p is continuous and of finite acceleration whatever the packet rate is: a packet that moves
//! x_r by Δ changes F_T by no more than K_p·Δ·(κ/m_p)·T_c in its tick, where the power-domain law jumps by K_T·Δ. The proxy is what the other user is felt
//! as; a light one follows better, a heavy one is smoother. Alone (K_T = B_T = 0) its modes are s = (−B_p ± √(B_p² − 4·m_p·K_p))/(2m_p).
//!
//! One solve a tick, by the implicit midpoint rule. With w the proxy's mean velocity, v the copy's, s = x_p − x_o, κ = K_T·T_c/2 + B_T,
//! κ_p = K_p·T_c/2 + B_p and D = 2m_p/T_c + κ_p,
//!
//! > D·w + F_T = d = (2m_p/T_c)·ẋ_p + K_p·(x_r − x_p) + B_p·ẋ_r,   F_T = K_T·s + κ·(w − v)
//! > so F_T is the port f = K_T·s + κ·(d − K_T·s)/(D + κ), z = κ·D/(D + κ), and then w = (d − K_T·s + κ·v)/(D + κ),
//! > x_p ← x_p + T_c·w, ẋ_p ← 2w − ẋ_p.
//!
//! A mode s of the proxy becomes z = (1 + s·T_c/2)/(1 − s·T_c/2): stable at every K_p ≥ 0, B_p > 0, and no energy is made between proxy and copy. Where the copy is
//! not moved by ports it is taken to move on at ẋ_o through the tick.
//!
//! **Promises** that nothing drifts. The proxy does not make the link passive: x_r is late and held, and the work K_p, B_p do on the proxy at ẋ_r is the
//! network's.

use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, Promise, Spring};
use cohold_core::num::{Carry, Motion, Scalar};
use cohold_core::object::port::{Port, Solve, met_midway};
use cohold_core::settings::{Key, Refused, Settings};

const MASS: Key =
    Key::number("remote_proxy.mass_kg", 0.02, [1e-4, 10.0], "kg").means("Remote dynamic proxy: mass m_p.");
const STIFFNESS: Key = Key::number("remote_proxy.stiffness_n_per_m", 310.0, [0.0, 1e6], "N/m")
    .means("Remote dynamic proxy: stiffness K_p that draws it to the motion that was received.");
const DAMPING: Key = Key::number("remote_proxy.damping_n_s_per_m", 4.0, [0.0, 1e3], "N·s/m")
    .means("Remote dynamic proxy: damping B_p toward the motion that was received.");

/// A proxy between the copy and what is received.
#[derive(Clone, Copy, Debug)]
pub struct RemoteDynamicProxy<S> {
    spring: Spring<S>,
    /// 2m_p/T_c, N·s/m.
    inertia: S,
    /// K_p, N/m.
    stiffness: S,
    /// B_p, N·s/m.
    damping: S,
    /// κ_p, N·s/m.
    impedance: S,
    /// 1/(D + κ).
    inverse_sum: S,
    /// κ/(D + κ).
    share: S,
    /// κ·D/(D + κ), N·s/m.
    seen_impedance: S,
    period: S,
}

configured!([S: Scalar] RemoteDynamicProxy<S> {
    spring, inertia, stiffness, damping, impedance, inverse_sum, share, seen_impedance, period
});

/// Motion of the proxy x_p, ẋ_p, and the remote motion x_r, ẋ_r as last received, toward which it is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProxyState<S> {
    /// x_p, ẋ_p.
    proxy: Motion<S>,
    /// x_r, ẋ_r.
    remote: Motion<S>,
    /// What x_p could not hold: rounding, no state.
    carry: Carry<S>,
}

visited!([S: Scalar] ProxyState<S> { proxy, remote });

impl<S: Scalar> Law<S> for RemoteDynamicProxy<S> {
    const LAWS: &'static [LawInfo] = &[LawInfo {
        name: "remote-dynamic-proxy",
        keys: &[MASS, STIFFNESS, DAMPING],
        gains: &["coordination.stiffness_n_per_m=1590"],
        source: "Li & Constantinescu 2010, proxy of second order under virtual coupling",
        promises: &[Promise::NoDrift],
        ..LawInfo::MOTION
    }];
    type State = ProxyState<S>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        let [mass, stiffness, damping] = [MASS, STIFFNESS, DAMPING].map(|key| settings.own(&key));
        let period = settings.timing.control_period_s;
        let (kappa, impedance) = (Spring::<S>::impedance(settings), met_midway(stiffness, damping, settings));
        let inertia = 2.0 * mass / period;
        let own = inertia + impedance;
        Ok(Self {
            spring: Spring::build(settings),
            inertia: S::from_f64(inertia),
            stiffness: S::from_f64(stiffness),
            damping: S::from_f64(damping),
            impedance: S::from_f64(impedance),
            inverse_sum: S::from_f64(1.0 / (own + kappa)),
            share: S::from_f64(kappa / (own + kappa)),
            seen_impedance: S::from_f64(own * kappa / (own + kappa)),
            period: S::from_f64(period),
        })
    }

    fn start(&self, local: Motion<S>) -> ProxyState<S> {
        ProxyState { proxy: local, remote: local, carry: Carry::default() }
    }

    fn receive(&self, state: &mut ProxyState<S>, packet: Packet<S>) {
        state.remote = packet.motion;
    }

    fn only_holds(&self) -> bool {
        true
    }

    #[inline]
    fn couple(&self, state: &mut ProxyState<S>, observed: &Observation<S>, solve: impl Solve<S>) -> Coupled<S> {
        let (proxy, remote) = (state.proxy, state.remote);
        let pull = self.stiffness * (remote.position - proxy.position) + self.damping * remote.velocity;
        let spring = self.spring.stiffness * (proxy.position - observed.local.position);
        let drive = self.inertia * proxy.velocity + pull - spring;
        let port = Port::new(spring + self.share * drive, self.seen_impedance);
        let mean = solve.velocity(port);
        let velocity = (drive + self.spring.impedance * mean) * self.inverse_sum;
        state.proxy = Motion {
            position: state.carry.add(proxy.position, self.period * velocity),
            velocity: velocity + velocity - proxy.velocity,
        };
        let desired = Motion { position: proxy.position, velocity };
        let from_network = (pull - self.impedance * velocity) * remote.velocity;
        Coupled::of_power(desired, port.at(mean), from_network)
    }

    fn send(&self, _: &ProxyState<S>, local: Motion<S>) -> Packet<S> {
        Packet { motion: local, ..Packet::default() }
    }
}
