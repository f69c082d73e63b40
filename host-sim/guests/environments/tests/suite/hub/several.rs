//! An object that is shared along two and three axes around a hub: what belongs to an axis is that of a trial of one, to the bit, and what
//! belongs to a line goes with all axes at once.

use cohold_core::device::AXES;
use cohold_core::safety::Mode;
use cohold_environments::cooperative::hub::Hub;
use cohold_protocol::key::Key;
use cohold_protocol::wire::{AxisFlow, Flows};
use cohold_sim::peers::Builds;
use cohold_sim::plant::Plant;
use cohold_sim::scene::Scene;

use super::trial::{HubTrial, Participant, built_in, key};

/// What meets in nodes, and what meets in copies.
const SCENES: [&str; 2] = ["hub", "any-network"];
const LINES: usize = 3;
/// Stiffness of every arm, N/m.
const ARM_N_PER_M: f64 = 200.0;

const BAD: [&str; 4] =
    ["network.loss=0.1", "network.jitter=uniform", "network.jitter_s=0.006", "network.duplicate=0.1"];

/// People with arms, who push obliquely to all axes and to each other.
fn people(name: &str, axes: u32, network: &[&str]) -> Scene {
    let own = [
        ("axis.count", f64::from(axes)),
        ("axis.shared", f64::from(axes)),
        ("user.1.push_n", 1.0),
        ("user.1.direction_rad", 0.7),
        ("user.1.elevation_rad", 0.4),
        ("user.2.push_n", 0.8),
        ("user.2.direction_rad", -1.9),
        ("user.2.elevation_rad", 0.9),
    ];
    let arms = [1, 2].map(|user| {
        [format!("user.{user}.arm_stiffness_n_per_m={ARM_N_PER_M}"), format!("user.{user}.arm_damping_n_s_per_m=5")]
    });
    let own = own.map(|(key, value)| format!("{key}={value}"));
    let network = network.iter().map(|key| (*key).to_owned());
    built_in(name, &own.into_iter().chain(arms.into_iter().flatten()).chain(network).collect::<Vec<_>>())
}

/// The one axis of which the shares of both users' forces are these.
fn alone(of_several: &Scene, axis: usize) -> Scene {
    let mut scene = of_several.clone();
    (scene.peer.axis.count, scene.peer.axis.shared) = (1, 1);
    for user in &mut scene.users {
        let share = user.direction()[axis];
        let profile = &mut user.settings.user;
        profile.push_n *= share;
        (profile.direction_rad, profile.elevation_rad) = (0.0, 0.0);
    }
    scene
}

/// Along each axis the bits of every copy, of where the lines meet and of every account, tick by tick; with `goes` a line falls silent for
/// so long that it is let go of and comes back, and another life begins on another line.
fn course<const SHARED: usize, const N: usize>(scene: &Scene, goes: bool) -> Vec<Vec<u64>>
where
    f32: Builds<SHARED, N>,
{
    let mut trial = HubTrial::<SHARED, N>::new(scene.clone(), LINES);
    let mut bits = vec![Vec::new(); SHARED];
    let mut let_go = 0;
    for tick in 0..5_000 {
        trial.engine.seats[2].off = goes && (1_500..2_500).contains(&tick);
        if goes && tick == 4_000 {
            let device = trial.peers().nth(1).expect("a peer").device();
            trial.restart(1, device);
        }
        trial.step();
        let junction = &trial.hub().junction;
        let_go += u32::from(tick > 1_000 && !junction.ports[2].is_engaged());
        for (axis, bits) in bits.iter_mut().enumerate() {
            for peer in trial.peers() {
                let seen = peer.peer.observed()[axis];
                let numbers = [seen.object.position, seen.object.velocity, seen.coordination_force];
                bits.extend(numbers.map(|number| u64::from(number.to_bits())));
            }
            bits.push(junction.motion[axis].position.to_bits());
            for port in &junction.ports {
                let energy = port.axes[axis].energy;
                bits.extend([energy.put_in_j, energy.taken_j, energy.sent_j].map(f64::to_bits));
            }
        }
    }
    assert_eq!((trial.lives_on(1), trial.lives_on(2)), (1 + u64::from(goes), 1));
    assert!(trial.peers().all(|peer| peer.peer.mode() == Mode::Armed && peer.peer.is_engaged()));
    assert!(!goes || let_go > 200, "let go of for {let_go} ticks");
    bits
}

/// `name` with two or three axes, beside a trial of one for each of them. Who comes back is answered with no more bytes than it has sent
/// until it has answered a probe, and flow of several axes is longer: where probes are lost, or several packets in a row, other datagrams
/// would be sent.
fn beside<const SHARED: usize, const N: usize>(name: &str)
where
    f32: Builds<SHARED, N>,
{
    // A line with a time of its own is let go of in the silence, too.
    let soon = ["safety.fade_s=0.2", "safety.disengage_s=0.5"];
    for (goes, network) in [(true, &soon[..]), (false, &BAD)] {
        let scene = people(name, SHARED as u32, network);
        let several = course::<SHARED, N>(&scene, goes);
        for (axis, bits) in several.iter().enumerate() {
            let [one] = course::<1, AXES>(&alone(&scene, axis), goes).try_into().expect("one axis");
            let first = bits.iter().zip(&one).position(|(bits, one)| bits != one);
            assert!(
                first.is_none() && bits.len() == one.len(),
                "{name}, axis {axis} of {SHARED}, {network:?}: {first:?}"
            );
        }
        assert!(several[0] != several[1], "all axes alike");
    }
}

#[test]
fn each_axis_around_a_hub_is_a_trial_of_one_to_the_bit() {
    for name in SCENES {
        beside::<2, 2>(name);
        beside::<3, 3>(name);
    }
}

/// Largest distance of two copies along an axis, m.
fn apart_m<const SHARED: usize, const N: usize>(trial: &HubTrial<SHARED, N>, axis: usize) -> f64
where
    f32: Builds<SHARED, N>,
{
    let places = || trial.peers().map(|peer| f64::from(peer.peer.observed()[axis].object.position));
    places().fold(f64::MIN, f64::max) - places().fold(f64::MAX, f64::min)
}

/// At rest the hands' forces are in balance along every axis, whatever lies between them: Σ(F_i − k·x_i) = 0 of all who hold on, so that
/// their devices' mean is ΣF_i/(k·n). It is checked with three, with the two that are left, and with three again.
fn meet<const SHARED: usize, const N: usize>(name: &str, network: &[&str])
where
    f32: Builds<SHARED, N>,
{
    let scene = people(name, SHARED as u32, network);
    let pushes: Vec<[f64; 3]> = (0..LINES)
        .map(|line| {
            let user = &scene.users[line % 2];
            // User 2 sits at the other end: what is toward the other one is the other way.
            let toward = if line % 2 == 0 { 1.0 } else { -1.0 };
            user.direction().map(|share| toward * share * user.settings.user.push_n)
        })
        .collect();
    let mut trial = HubTrial::<SHARED, N>::new(scene, LINES);
    for (ticks, off) in [(6_000, false), (14_000, true), (14_000, false)] {
        if trial.engine.seats[2].off && !off {
            let device = Plant::build(&trial.scene, 0);
            trial.restart(2, device);
        }
        trial.engine.seats[2].off = off;
        (0..ticks).for_each(|_| trial.step());
        let there = trial.peers().count();
        assert!(trial.peers().all(|peer| peer.peer.mode() == Mode::Armed && peer.peer.is_engaged()));
        for axis in 0..SHARED {
            let sum: f64 = trial.peers().map(|peer| f64::from(peer.peer.observed()[axis].device.position)).sum();
            let pushed: f64 = pushes.iter().take(there).map(|push| push[axis]).sum();
            let (mean, wanted) = (sum / there as f64, pushed / (ARM_N_PER_M * there as f64));
            let at = format!("{name}, {there} on axis {axis} of {SHARED}, {network:?}");
            assert!((mean - wanted).abs() < 0.05 * wanted.abs() + 5e-5, "{at}: {mean} m, not {wanted} m");
            let apart_m = apart_m(&trial, axis);
            println!("{at}: {mean} m of {wanted} m, {apart_m} m apart");
            // One that began anew began where its own device was.
            let most_m = if network.is_empty() { 3e-3 } else { 10e-3 };
            assert!(trial.lives_on(2) > 1 || apart_m < most_m, "{at}: {apart_m} m apart");
        }
    }
    assert_eq!(trial.lives_on(2), 2);
}

#[test]
fn copies_of_people_who_push_along_several_axes_meet_along_all() {
    for name in SCENES {
        for network in [&[][..], &BAD] {
            meet::<2, 2>(name, network);
            meet::<3, 3>(name, network);
        }
    }
}

/// What cannot be along the last axis alone: the flow is refused whole, its line is named, and the others hold on along every axis.
#[test]
fn what_cannot_be_along_the_last_axis_is_refused_along_all() {
    for name in SCENES {
        let mut trial = HubTrial::<3, 3>::new(people(name, 3, &[]), LINES);
        (0..2_000).for_each(|_| trial.step());
        let Participant::Peer(node, hub) = &mut trial.engine.seats[2].actor else { panic!("a peer") };
        let (hub, mut said) = (*hub, vec![]);
        let usual = AxisFlow { live_ticks: 5_000, ..AxisFlow::default() };
        let axes = [usual, usual, AxisFlow { wave_integral: 1.7e308, ..usual }];
        assert!(node.line.link.say(2_000_000, Flows { engaged: true, fading: false, tick: 5_000, axes }, |bytes| {
            said.push(bytes.to_vec());
        }));
        let Participant::Hub(hub) = &mut trial.engine.seats[hub].actor else { panic!("the hub sits last") };
        said.iter_mut().for_each(|bytes| hub.receive(2_000_000, 2, bytes, |_, _| {}));
        let news = hub.news(2_000_000).join("\n");
        assert!(news.contains("line 3: 2 says what cannot be") && news.contains("wave_integral"), "{news}");
        trial.engine.seats[2].off = true;
        for _ in 0..12_000 {
            trial.step();
            assert!(trial.hub().junction.motion.iter().all(|motion| motion.is_finite()));
        }
        assert!(trial.peers().all(|peer| peer.peer.is_engaged()));
        let apart_m = [0, 1, 2].map(|axis| apart_m(&trial, axis));
        assert!(apart_m.iter().all(|apart_m| *apart_m < 2e-3), "{name}: {apart_m:?} m");
    }
}

/// A hub of so many axes is made for scenes of as many.
#[test]
fn a_hub_of_another_number_of_axes_is_refused() {
    let said = |axes: u32| {
        let scene = people("hub", axes, &[]);
        let hub = Hub::<usize, 2>::new(&scene, 2, &key(), || Ok([1; Key::LEN]));
        hub.map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(said(2), Ok(()));
    let error = said(3).expect_err("no hub");
    assert_eq!(error, "axis.shared = 3 is not allowed: it must be a whole number from 2 to 2");
}
