use cohold_sim::scenes;

use super::*;
use crate::environment::{MOST, OFF};
use crate::pair_columns::columns;

fn session(name: &str, partner: Model) -> Session<1, { cohold_sim::AXES }> {
    Session::new(scenes::load(cohold_sim::Laws::built_in(), name).expect("a scene"), partner).expect("a session")
}

/// The scene `any-network`, whose users do nothing here.
fn any_network() -> Scene {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), "any-network").expect("a scene");
    scene.users = Default::default();
    scene
}

fn column(sample: &Sample, name: &str) -> f64 {
    f64::from(sample[columns(3).iter().position(|(known, ..)| *known == name).expect("a column")])
}

/// So many ticks with hand 1 where it is wanted and the partner at hand 2.
fn carry<const SHARED: usize, const N: usize>(
    session: &mut Session<SHARED, N>,
    ticks: usize,
    wanted: Option<f64>,
) -> Sample
where
    f32: Builds<SHARED, N>,
{
    let mut sample = [f32::NAN; MOST];
    for _ in 0..ticks {
        session.point(0, wanted.map(|along| [along, 0.0, 0.0]), session.restarts);
        session.play(1);
        sample = session.step().expect("a tick");
    }
    sample
}

/// Without hands a session is the pair of every other run, to the bit.
#[test]
fn without_hands_it_is_the_simulators_pair() {
    let mut session = session("paper-5.2-wave-16ms", Model::Absent);
    let mut pair = Pair::<f32>::new(&session.scene).expect("a pair");
    for _ in 0..500 {
        session.step().expect("a tick");
        pair.step();
    }
    assert_eq!(session.pair.hash(7), pair.hash(7));
}

/// At rest two hands pull on one chain of springs, so that the force is their difference over the sum of all compliances: both hands,
/// both contacts, and what the line's tautness leaves of both K_T and of its round trip over its impedance (THEORY §4 and §15).
#[test]
fn two_hands_pull_on_one_chain() {
    let mut session = Session::<1, { cohold_sim::AXES }>::new(any_network(), Model::Resists).expect("a session");
    let sample = carry(&mut session, 4000, Some(0.02));
    let compliance = 2.0 / 200.0 + 2.0 / 1000.0 + (1.0 - 0.9) * (2.0 / 10000.0 + 0.016 / 60.0);
    let [hand_1, hand_2] = ["hand_1", "hand_2"].map(|name| column(&sample, name));
    assert!(
        (hand_1 - 0.02 / compliance).abs() < 1e-3 && (hand_2 + 0.02 / compliance).abs() < 1e-3,
        "{hand_1} {hand_2}"
    );
    assert!((column(&sample, "object_1") - 0.01).abs() < 0.001, "{sample:?}");
    assert!((column(&sample, "delay_1") - 0.008).abs() < 1e-6, "{sample:?}");
    assert_eq!([column(&sample, "live_1"), column(&sample, "live_2")], [1.0; 2]);
    // A passive law: the line holds energy, and a peer has made no more than its slip gives, ½α·C·F².
    let slip_j = 0.5 * 0.9 * (2.0 / 10000.0 + 0.016 / 60.0) * hand_1 * hand_1;
    assert!(column(&sample, "line") >= 0.0 && column(&sample, "kept_1") > -1e-4 - slip_j, "{sample:?}");
}

/// What the scene's users do is told beside what hands do: at rest a push, less what its arm takes back, is what its device hands on.
#[test]
fn the_scenes_users_are_told() {
    let mut session = session("paper-5.2-power-16ms", Model::Absent);
    session.scene.apply_override("user.2.sine_n=0").expect("a key");
    session.scene.apply_override("user.1.arm_stiffness_n_per_m=50").expect("a key");
    session.scene.apply_override("user.1.arm_damping_n_s_per_m=5").expect("a key");
    session.start().expect("it starts");
    let sample = carry(&mut session, 8000, None);
    let of = |name: &str| column(&sample, name);
    assert_eq!((of("hand_1"), of("hand_2"), of("push_2")), (0.0, 0.0, -1.0));
    assert!((of("push_1") - (1.0 - 50.0 * of("device_1"))).abs() < 0.02, "{sample:?}");
    // At rest what pushes a copy is what pulls it.
    assert!((of("push_1") - of("contact_1")).abs() < 0.02 && of("push_1") > 0.5, "{sample:?}");
    assert!((of("contact_1") + of("coordination_1")).abs() < 0.02, "{sample:?}");
}

/// The tick of a fault is the last one: no copy runs away behind it, and what is started anew goes on.
#[test]
fn a_fault_ends_it() {
    let mut session = session("paper-5.2-power-16ms", Model::Absent);
    session.scene.apply_override("coordination.stiffness_n_per_m=3000").expect("a key");
    session.start().expect("it starts");
    let mut last = [f32::NAN; MOST];
    for _ in 0..20_000 {
        if session.stands() {
            break;
        }
        last = carry(&mut session, 1, None);
    }
    assert!(session.stands() && session.fault().is_some());
    assert!((column(&last, "object_1") - column(&last, "object_2")).abs() < 1.0, "{last:?}");
    session.start().expect("it starts");
    assert!(!session.stands());
}

/// A delay that is set in flight is that of the packets sent from then on; nothing starts anew.
#[test]
fn the_network_changes_in_flight() {
    let mut session = Session::<1, { cohold_sim::AXES }>::new(any_network(), Model::Follows).expect("a session");
    let before = carry(&mut session, 1000, Some(0.03));
    let mut slower = session.scene.clone();
    (slower.world.network.one_way_delay_packets, slower.world.network.extra_delay_s) = (0, 0.050);
    session.set(slower).expect("a good scene");
    let after = carry(&mut session, 1, Some(0.03));
    assert!((column(&after, "object_1") - column(&before, "object_1")).abs() < 1e-3);
    let later = carry(&mut session, 200, Some(0.03));
    assert!((column(&later, "delay_1") - 0.050).abs() < 1e-6, "{later:?}");
    assert_eq!(column(&later, "restarts"), 0.0);
}

/// A gain starts both anew where they are, and what a pointer says of the world before is nothing.
#[test]
fn a_gain_starts_both_anew_where_they_are() {
    let mut session = Session::<1, { cohold_sim::AXES }>::new(any_network(), Model::Follows).expect("a session");
    let before = carry(&mut session, 2000, Some(0.04));
    let mut softer = session.scene.clone();
    softer.peer.coordination.stiffness_n_per_m = 5000.0;
    session.set(softer).expect("a good scene");
    session.point(0, Some([0.04, 0.0, 0.0]), 0);
    let after = session.step().expect("a tick");
    assert!((column(&after, "object_1") - column(&before, "object_1")).abs() < 2e-3, "{before:?} {after:?}");
    assert_eq!((column(&after, "restarts"), column(&after, "hand_1")), (1.0, 0.0));
}

/// Motors that are off stay off through a change, and come back only when they are asked to.
#[test]
fn stopped_stays_stopped() {
    let mut session = session("paper-5.2-power-16ms", Model::Absent);
    session.stop();
    let mut other = session.scene.clone();
    other.peer.object.mass_kg = 0.5;
    session.set(other).expect("a good scene");
    let sample = session.step().expect("a tick");
    assert_eq!((session.modes(), column(&sample, "contact_1")), ([OFF; 2], 0.0));
    session.start().expect("it starts");
    assert_eq!(session.modes(), [ARMED; 2]);
}

/// A cut line delivers nothing; a copy is moved by its own hand alone.
#[test]
fn a_cut_line_leaves_each_alone() {
    let mut session = session("paper-5.2-power-16ms", Model::Absent);
    session.scene.users = Default::default();
    session.start().expect("it starts");
    carry(&mut session, 100, None);
    session.command(Command::Cut(true)).expect("it is cut");
    let sample = carry(&mut session, 3000, Some(0.05));
    assert!(column(&sample, "object_1") > 0.04 && column(&sample, "object_2").abs() < 1e-6, "{sample:?}");
    assert_eq!([column(&sample, "live_1"), column(&sample, "live_2")], [0.0; 2]);
    // Starting anew does not join it.
    session.start().expect("it starts");
    let before = carry(&mut session, 1, None);
    let after = carry(&mut session, 1000, Some(0.05));
    assert_eq!(column(&after, "object_2"), column(&before, "object_2"));
    assert_eq!([column(&after, "live_1"), column(&after, "live_2")], [0.0; 2]);
}

/// Ends of travel: a strong hand gets a device no further than they give, F/k.
#[test]
fn a_device_stays_within_its_travel() {
    let mut session = Session::<1, { cohold_sim::AXES }>::new(any_network(), Model::Absent).expect("a session");
    let sample = carry(&mut session, 6000, Some(0.2));
    // Both ends push back: the devices hold one object.
    let most = REACH_M + cohold_live::hand::STRENGTH / cohold_live::hand::END_STIFFNESS;
    assert!((REACH_M..most).contains(&column(&sample, "device_1")), "{sample:?}");
}

/// In the plane, what a hand does along both axes each of them shows to the bit as one axis alone does; and what it does across only,
/// the other copy follows across only.
#[test]
fn each_axis_of_the_plane_is_one_axis() {
    let fitting = |axes: u32| {
        let mut scene = any_network();
        (scene.peer.axis.count, scene.peer.axis.shared) = (axes, axes);
        scene
    };
    let mut one = Session::<1, { cohold_sim::AXES }>::new(any_network(), Model::Resists).expect("a session");
    let mut plane = Session::<2, 2>::new(fitting(2), Model::Resists).expect("a session");
    let mut space = Session::<3, 3>::new(fitting(3), Model::Resists).expect("a session");
    for tick in 0..3000 {
        // Slow enough to be within a hand's speed and strength along all axes together.
        let at = 0.02 * (f64::from(tick) / 1000.0).min(1.0);
        let sessions: [&mut dyn Environment; 3] = [&mut one, &mut plane, &mut space];
        let [alone, both, all] = sessions.map(|session| {
            session.point(0, Some([at; 3]), 0);
            session.play(1);
            session.step().expect("a tick")
        });
        for name in ["object_1", "object_2", "hand_1", "coordination_2", "decoded_1", "wanted_1"] {
            let bits = |sample: &Sample, suffix: &str| column(sample, &format!("{name}{suffix}")).to_bits();
            let wanted = bits(&alone, "");
            assert_eq!([bits(&both, ""), bits(&both, "_y")], [wanted; 2], "{name} at tick {tick}");
            assert_eq!([bits(&all, ""), bits(&all, "_y"), bits(&all, "_z")], [wanted; 3], "{name} at tick {tick}");
        }
        if tick == 2999 {
            assert!(column(&both, "object_2_y") > 0.004 && column(&both, "object_2_z").is_nan(), "{both:?}");
            assert_eq!(both[MOST - 1], 0.0);
        }
    }
    let mut plane = Session::<2, 2>::new(fitting(2), Model::Follows).expect("a session");
    let mut last = [0.0; MOST];
    for _ in 0..4000 {
        plane.point(0, Some([0.0, 0.03, 0.0]), 0);
        plane.play(1);
        last = plane.step().expect("a tick");
    }
    assert!(column(&last, "object_2_y") > 0.02 && column(&last, "object_2") == 0.0, "{last:?}");
}
