//! Scenes of a kind, which several tests ask about; those with an integrator are Figure 4's.

use cohold_core::law::wave::Decode;
use cohold_core::object::IntegratorName;
use cohold_sim::scene::Scene;

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
