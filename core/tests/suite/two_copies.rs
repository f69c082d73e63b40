//! Two peers that a law holds together, hands and packets prescribed.

use std::collections::VecDeque;

use cohold_core::device::{AXES, Reading};
use cohold_core::law::Packet;
use cohold_core::law::wave::Decode;
use cohold_core::num::{Motion, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::peer::{Observed, Peer, Sensors};
use cohold_core::safety::Command;
use cohold_core::settings::{Settings, Value};

/// T_c, s.
pub(crate) const PERIOD: f64 = 0.001;

/// Contact so soft, N/m, that a hand far away is a constant push.
pub(crate) const SOFT: f64 = 0.1;

/// A packet each tick and the copy moved by ports, with these keys.
pub(crate) fn settings(law: &'static str, keys: &[(&str, f64)]) -> Settings {
    let mut settings = Settings::default();
    settings.timing.ticks_per_packet = 1;
    settings.object.integrator = IntegratorName::Midpoint;
    settings.object.force_delay_ticks = 0.0;
    settings.object.damping_n_s_per_m = 0.0;
    settings.coordination.decode = Decode::Implicit;
    settings.coordination.comm = law;
    settings.safety.max_force_n = 200.0;
    for (key, number) in keys {
        crate::SCHEMA
            .set(&mut settings, key, Value::Number(*number))
            .unwrap_or_else(|error| panic!("{key}: {error:?}"));
    }
    settings
}

/// Two armed peers, and what is under way between them.
pub(crate) struct Copies<S: Scalar> {
    pub(crate) peers: [Peer<S, crate::AnyLaw<S>>; 2],
    /// What peer 2 and peer 1 have yet to hear, newest last.
    pub(crate) under_way: [VecDeque<Packet<S>>; 2],
    /// Packet periods on the way.
    pub(crate) delay: usize,
}

impl<S: Scalar> Copies<S> {
    pub(crate) fn new(settings: &Settings, delay: usize) -> Self {
        let armed = || {
            let mut peer = Peer::new(settings, [Motion::REST; AXES]).expect("a good scene");
            peer.command(Command::Arm);
            peer
        };
        Self { peers: [armed(), armed()], under_way: Default::default(), delay }
    }

    /// A tick, the devices here; what may come through is said by `lets_through`, which is asked of each packet that is due.
    pub(crate) fn tick_over(
        &mut self,
        devices: [Motion<f64>; 2],
        mut lets_through: impl FnMut() -> bool,
    ) -> [Observed<S>; 2] {
        if self.peers[0].packet_due() {
            let sent = self.peers.each_ref().map(|peer| peer.outgoing()[0]);
            for (to, packet) in [(1, sent[0]), (0, sent[1])] {
                self.under_way[to].push_back(packet);
                if self.under_way[to].len() > self.delay
                    && let Some(packet) = self.under_way[to].pop_front()
                    && lets_through()
                {
                    self.peers[to].hear(&[packet]);
                }
                self.peers[to].exchange();
            }
        }
        for (peer, device) in self.peers.iter_mut().zip(devices) {
            let device = Motion { position: S::from_f64(device.position), velocity: S::from_f64(device.velocity) };
            peer.tick(&Sensors::of(Reading::Exact([device, Motion::REST])));
        }
        self.peers.each_ref().map(|peer| *peer.observed()[0])
    }

    pub(crate) fn tick(&mut self, devices: [Motion<f64>; 2]) -> [Observed<S>; 2] {
        self.tick_over(devices, || true)
    }

    /// A tick in which the hands push with these forces, N, through a contact that is [`SOFT`].
    pub(crate) fn pushed(&mut self, forces: [f64; 2]) -> [Observed<S>; 2] {
        self.tick(forces.map(|push| Motion::at(push / SOFT)))
    }
}

/// A complex amplitude: value = Re(z·e^(iωt)), z = re + i·im.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Phasor {
    pub(crate) re: f64,
    pub(crate) im: f64,
}

impl Phasor {
    pub(crate) fn see(&mut self, value: f64, angle: f64) {
        self.re += value * angle.cos();
        self.im -= value * angle.sin();
    }

    pub(crate) fn over(self, other: Self) -> Self {
        let size = other.re * other.re + other.im * other.im;
        Self {
            re: (self.re * other.re + self.im * other.im) / size,
            im: (self.im * other.re - self.re * other.im) / size,
        }
    }

    /// |this − other| over |other|.
    pub(crate) fn off(self, other: Self) -> f64 {
        (self.re - other.re).hypot(self.im - other.im) / other.re.hypot(other.im)
    }
}

/// A device that swings, 1 cm at this angular frequency (rad/s).
pub(crate) fn swing(omega: f64, time: f64) -> Motion<f64> {
    Motion { position: 0.01 * (omega * time).sin(), velocity: 0.01 * omega * (omega * time).cos() }
}
