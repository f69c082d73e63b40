//! What is proposed is stable with its margin everywhere below it, and nothing stiffer would be.

use haptic_core::couple::LawName;
use haptic_core::couple::wave::Decode;
use haptic_core::object::IntegratorName;

use super::*;

/// The three laws at their defaults and the matched settings, short and long delays, a late and a prompt loop.
fn scenes() -> Vec<SceneFile> {
    let mut scenes = Vec::new();
    for (comm, decode) in [
        (LawName::Power, Decode::Delayed),
        (LawName::Wave, Decode::Delayed),
        (LawName::PassiveWave, Decode::Delayed),
        (LawName::PassiveWave, Decode::Implicit),
    ] {
        for (delay, late) in [(1, 1.0), (3, 0.2)] {
            let mut scene = SceneFile::default();
            scene.peer.coordination.comm = comm;
            scene.peer.coordination.decode = decode;
            scene.peer.object.integrator = IntegratorName::SemiImplicit;
            scene.peer.object.force_delay_ticks = if decode == Decode::Implicit { 0.0 } else { 1.0 };
            scene.world.device.force_delay_ticks = late;
            scene.world.network.one_way_delay_packets = delay;
            scenes.push(scene);
        }
    }
    scenes
}

fn stable(scene: &SceneFile, contact: f64, coordination: f64) -> bool {
    verdict(&with(scene, contact, coordination).unwrap()).unwrap().stable
}

/// Every pair of gains up to (1 + m) times the proposal: a grid that the search does not use.
#[test]
fn all_gains_below_the_raised_proposal_are_stable() {
    for scene in scenes() {
        for margin in [0.0, 0.2, 1.0] {
            let proposal = tune(&scene, margin, || {}).unwrap().unwrap();
            let raised = 1.0 + margin;
            for at in 0..=400 {
                let (a, b) = (f64::from(at % 20) / 19.0, f64::from(at / 20) / 20.0);
                let gains = [
                    raised * a * proposal.contact_stiffness_n_per_m,
                    raised * b * proposal.coordination_stiffness_n_per_m,
                ];
                assert!(stable(&scene, gains[0], gains[1]), "{gains:?} below {proposal:?}");
            }
        }
    }
}

/// Nothing is given away: with both gains another 6 % up, something below is unstable, or the coordination is stiff enough
/// already.
#[test]
fn the_proposal_is_at_the_edge_of_its_margin() {
    for scene in scenes() {
        let proposal = tune(&scene, 0.2, || {}).unwrap().unwrap();
        let further = 1.2 * 1.06;
        let linear = scene.linear();
        let contact = further * proposal.contact_stiffness_n_per_m;
        let coordination = further * proposal.coordination_stiffness_n_per_m;
        let along_contact = first(&with(&linear, 0.0, coordination).unwrap(), CONTACT, contact).unwrap();
        let along_coordination = first(&with(&linear, contact, 0.0).unwrap(), COORDINATION, coordination).unwrap();
        assert!(along_contact.is_some() || along_coordination.is_some(), "{proposal:?}");
    }
}

/// A wider margin costs stiffness; less delay in the loop gives some.
#[test]
fn stiffness_is_traded_for_margin_and_latency() {
    let yields = |late: f64, margin: f64| {
        let mut scene = scenes().remove(6);
        scene.world.device.force_delay_ticks = late;
        tune(&scene, margin, || {}).unwrap().unwrap().compliance_mm_per_n
    };
    assert!(yields(1.0, 0.0) < yields(1.0, 0.2) && yields(1.0, 0.2) < yields(1.0, 1.0));
    assert!(yields(0.2, 0.2) < yields(1.0, 0.2));
}

/// The proposal runs, in f32, with the scene's own imperfections.
#[test]
fn proposals_run() {
    for scene in scenes().into_iter().chain([crate::scenes::load("real-device").unwrap()]) {
        let proposal = tune(&scene, 0.2, || {}).unwrap().unwrap();
        let outcome = try_out::<f32>(&scene, &proposal, 5.0).unwrap();
        assert!(outcome.bounded, "{proposal:?}: {:?}", outcome.fault);
    }
}

#[test]
fn nothing_is_proposed_where_nothing_is_stable() {
    let mut scene = SceneFile::default();
    // A damper this strong, a tick late, throws a device of 100 g about by itself.
    scene.peer.contact.damping_n_s_per_m = 500.0;
    assert_eq!(tune(&scene, 0.2, || {}).unwrap(), None);
    let refused = tune(&scene, -0.1, || {}).unwrap_err().to_string();
    assert!(refused.starts_with("--margin = -0.1 is not allowed"), "{refused}");
}

#[test]
fn gains_are_rounded_down_to_three_digits() {
    for (value, wanted) in [(1234.9, 1230.0), (1230.0, 1230.0), (0.099_99, 0.0999), (999.99, 999.0), (0.0, 0.0)] {
        assert_eq!(rounded_down(value), wanted);
    }
}
