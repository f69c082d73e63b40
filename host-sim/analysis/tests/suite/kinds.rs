//! Scenes of a kind, which several tests ask about; those with an integrator are Figure 4's.

use haptic_core::law::wave::Decode;
use haptic_core::object::IntegratorName;
use haptic_sim::scene::Scene;

use super::random::{self, Random};
use crate::figure4;

pub(crate) fn midpoint(law: &'static str, delay_packets: u32) -> Scene {
    let mut scene = figure4::scene(law, delay_packets);
    scene.peer.object.integrator = IntegratorName::Midpoint;
    scene.peer.object.force_delay_ticks = 0.0;
    scene.peer.object.mass_kg = 0.3;
    scene.peer.coordination.decode = Decode::Implicit;
    scene
}

pub(crate) fn backward_euler(law: &'static str, delay_packets: u32) -> Scene {
    let mut scene = midpoint(law, delay_packets);
    scene.peer.object.integrator = IntegratorName::BackwardEuler;
    scene
}

pub(crate) fn self_timed(ticks_per_packet: u32, delay_packets: u32, credit_ticks: u32) -> Scene {
    let mut scene = midpoint("self-timed", delay_packets);
    scene.peer.timing.ticks_per_packet = ticks_per_packet;
    scene.set_number("coordination.credit_ticks", f64::from(credit_ticks)).expect("it is allowed");
    scene
}

/// The longest delay that a scene may have, ticks.
const LONGEST: f64 = 20.0;

/// Random scenes whose two devices hold forces back for whole ticks or fractions more, each as long as it likes.
pub(crate) fn held_back(seed: u64) -> Scene {
    let (mut scene, mut random) = (random::scene(seed), Random::new(!seed));
    let delays = [(); 2].map(|()| {
        let delay = LONGEST * random.unit();
        random.one(&[delay, delay.ceil()])
    });
    let same = random.whole(0, 1) == 0;
    for (key, delay) in ["peer.1.device.force_delay_ticks", "peer.2.device.force_delay_ticks"].into_iter().zip(delays) {
        scene.set_number(key, if same { delays[0] } else { delay }).expect("it is allowed");
    }
    // Most would be unstable otherwise.
    let softer = random.spread(0.01, 1.0);
    scene.peer.contact.stiffness_n_per_m *= softer;
    scene.peer.contact.damping_n_s_per_m *= softer;
    scene
}
