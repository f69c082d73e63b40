//! One end of a wave line: a copy that moves, waves that arrive.
//!
//! What comes out is compared in [the decodes](../../decodes/index.html). Unit: m, m/s, √W, s.

use cohold_core::law::Packet;
use cohold_core::law::wave::Decode;
use cohold_core::num::{Motion, Scalar};
use cohold_core::settings::Settings;

/// Amplitude of the copy's motion, m.
pub const AMPLITUDE_M: f64 = 0.005;
/// Angular frequency of the copy's motion and of the wave, rad/s.
pub const ANGULAR_RAD_PER_S: f64 = core::f64::consts::TAU * 2.0;
/// Height of the incoming wave, √W.
const WAVE: f64 = 0.3;
/// Length of the test, s.
const DURATION_S: f64 = 4.0;

/// The settings of the line.
pub fn settings(decode: Decode, stiffness_n_per_m: f64) -> Settings {
    let mut settings = Settings::default();
    settings.coordination.decode = decode;
    settings.coordination.stiffness_n_per_m = stiffness_n_per_m;
    settings
}

/// Ticks of the test.
pub fn ticks(settings: &Settings) -> usize {
    libm::round(DURATION_S / settings.timing.control_period_s) as usize
}

/// The copy's motion at `time_s`.
pub fn local(time_s: f64) -> Motion<f64> {
    let (sine, cosine) = libm::sincos(ANGULAR_RAD_PER_S * time_s);
    Motion::new(AMPLITUDE_M * sine, AMPLITUDE_M * ANGULAR_RAD_PER_S * cosine)
}

/// u_in of the packet that arrives at `time_s`, √W.
pub fn wave(time_s: f64) -> f64 {
    WAVE * libm::sin(ANGULAR_RAD_PER_S * time_s + 1.0)
}

/// What the law is given at a tick: the copy's motion and, when one is due, a packet.
pub fn input<S: Scalar>(settings: &Settings, tick: usize) -> (Motion<S>, Option<Packet<S>>) {
    let time_s = tick as f64 * settings.timing.control_period_s;
    let local = local(time_s);
    let packet = Packet { wave: S::from_f64(wave(time_s)), ..Packet::default() };
    let due = tick.is_multiple_of(settings.timing.ticks_per_packet as usize);
    (Motion::new(S::from_f64(local.position), S::from_f64(local.velocity)), due.then_some(packet))
}
