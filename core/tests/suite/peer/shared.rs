//! Peers that share the object along two and three axes, against as many peers that share it along one.

use cohold_core::device::kinematics::{AnyKinematics, AnySpatial, Kinematics};
use cohold_core::device::{Counts, Reading};
use cohold_core::law::{AnyLaw, Law, Packet};
use cohold_core::names::{Decode, IntegratorName};
use cohold_core::num::{Motion, Scalar};
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::settings::{Settings, Value};

type Plane<S> = Peer<S, AnyLaw<S>, 2>;
type Space<S> = Peer<S, AnyLaw<S>, 3, 3, AnySpatial<S>>;

/// A scene of this law with as many axes, all of them shared.
fn scene(law: &'static str, axes: u32) -> Settings {
    let mut settings = Settings::default();
    (settings.coordination.comm, settings.axis.count, settings.axis.shared) = (law, axes, axes);
    settings.timing.ticks_per_packet = 3;
    settings.object.force_delay_ticks = 0.0;
    settings.coordination.decode = Decode::Implicit;
    settings
}

/// Where the hand is at a tick, m and m/s: another way along every axis.
fn hand<S: Scalar>(tick: u32, axis: usize, peer: usize) -> Motion<S> {
    let (rate, size) = ([3.0, 5.0, 7.0][axis] + peer as f64, [0.004, -0.003, 0.002][axis]);
    let angle = rate * f64::from(tick) * 1e-3;
    Motion { position: S::from_f64(size * angle.sin()), velocity: S::from_f64(size * rate * angle.cos()) }
}

/// Packets are lost here and there, all axes' together.
fn lost(exchange: u32) -> bool {
    exchange % 7 == 3 || (60..75).contains(&exchange)
}

/// Everything that a run of two peers sent, felt and saw.
fn together<S: Scalar, const SHARED: usize, K: Kinematics<S, SHARED>>(settings: &Settings) -> Vec<[u64; 5]> {
    let mut peers = [0; 2].map(|_| {
        Peer::<S, AnyLaw<S>, SHARED, SHARED, K>::build(settings, [Motion::REST; SHARED]).expect("a good scene")
    });
    peers.iter_mut().for_each(|peer| peer.command(Command::Arm));
    let mut record = Vec::new();
    let mut exchanges = 0;
    for tick in 0..900 {
        if peers[0].packet_due() {
            exchanges += 1;
            let [to_two, to_one] = peers.each_ref().map(|peer| peer.outgoing());
            if !lost(exchanges) {
                peers[0].hear(&to_one);
                peers[1].hear(&to_two);
            }
            for peer in &mut peers {
                peer.exchange();
            }
        }
        for (at, peer) in peers.iter_mut().enumerate() {
            let actuators = peer.tick(&Sensors::of(Reading::Exact(core::array::from_fn(|axis| hand(tick, axis, at)))));
            assert_eq!(peer.mode(), Mode::Armed, "{tick}");
            for (axis, (seen, ledger)) in peer.observed().into_iter().zip(peer.ledger()).enumerate() {
                let told = [seen.object.position, seen.coordination_force, ledger.sent_j(), actuators.forces[axis]];
                let [a, b, c, d] = told.map(S::bits);
                record.push([a, b, c, d, (axis * 2 + at) as u64]);
            }
        }
    }
    record
}

/// The same of one axis alone.
fn alone<S: Scalar>(settings: &Settings, axis: usize) -> Vec<[u64; 5]> {
    let settings =
        { Settings { axis: cohold_core::settings::Axis { count: 1, shared: 1, ..settings.axis }, ..*settings } };
    let mut peers = [0; 2].map(|_| Peer::<S, AnyLaw<S>>::new(&settings, [Motion::REST; 2]).expect("a good scene"));
    peers.iter_mut().for_each(|peer| peer.command(Command::Arm));
    let (mut record, mut exchanges) = (Vec::new(), 0);
    for tick in 0..900 {
        if peers[0].packet_due() {
            exchanges += 1;
            let [to_two, to_one] = peers.each_ref().map(|peer| peer.outgoing()[0]);
            if !lost(exchanges) {
                peers[0].hear(&[to_one]);
                peers[1].hear(&[to_two]);
            }
            for peer in &mut peers {
                peer.exchange();
            }
        }
        for (at, peer) in peers.iter_mut().enumerate() {
            let actuators = peer.tick(&Sensors::of(Reading::Exact([hand(tick, axis, at), Motion::REST])));
            let (seen, ledger) = (peer.observed()[0], peer.ledger()[0]);
            let told = [seen.object.position, seen.coordination_force, ledger.sent_j(), actuators.forces[0]];
            let [a, b, c, d] = told.map(S::bits);
            record.push([a, b, c, d, (axis * 2 + at) as u64]);
        }
    }
    record
}

fn axes_that_nothing_couples_are_as_if_they_were_alone<S: Scalar>() {
    for kind in <AnyLaw<S> as Law<S>>::LAWS {
        for integrator in [IntegratorName::SemiImplicit, IntegratorName::Midpoint] {
            if integrator != IntegratorName::Midpoint && (kind.own_time || kind.budgets().next().is_some()) {
                // Only with one solve a tick.
                continue;
            }
            for axes in [2, 3] {
                let mut settings = scene(kind.name, axes);
                settings.object.integrator = integrator;
                settings.coordination.stiffness_n_per_m = 300.0;
                let all = if axes == 2 {
                    together::<S, 2, AnyKinematics<S>>(&settings)
                } else {
                    together::<S, 3, AnySpatial<S>>(&settings)
                };
                for axis in 0..axes as usize {
                    let of_it = |record: &&[u64; 5]| record[4] / 2 == axis as u64;
                    let found: Vec<_> = all.iter().filter(of_it).copied().collect();
                    let expected = alone::<S>(&settings, axis);
                    assert!(found.len() == 1800 && found == expected, "{} {integrator:?} {axis} of {axes}", kind.name);
                }
            }
        }
    }
}

#[test]
fn axes_that_nothing_couples_are_as_if_they_were_alone_to_the_bit() {
    axes_that_nothing_couples_are_as_if_they_were_alone::<f32>();
    axes_that_nothing_couples_are_as_if_they_were_alone::<f64>();
}

/// A five-bar with both axes shared: the contact is felt along both, and the motors do the work that the hand gets.
#[test]
fn a_five_bar_renders_the_contact_along_both_axes_through_its_encoders() {
    let mut settings = scene("power", 2);
    settings.set("kinematics.model", Value::Text("five-bar")).expect("a word");
    settings.set("axis.velocity", Value::Text("difference")).expect("a word");
    settings.motor.newton_or_newton_metre_per_a = 0.5;
    settings.object.mass_kg = 1000.0;
    let kinematics = AnyKinematics::<f64>::build(&settings).expect("good settings");
    let mut peer = Plane::<f64>::build(&settings, [Motion::REST; 2]).expect("a good scene");
    peer.command(Command::Arm);
    let counts_per_rad = settings.encoder.counts_per_rev / core::f64::consts::TAU;
    let motor = cohold_core::device::motor::Motor::<f64>::build(&settings);
    let mut felt = [0.0_f64; 2];
    for tick in 0..400_i16 {
        let counts = [tick / 4, -(tick / 6)];
        let actuators = peer.tick(&Sensors::of(Reading::Counts(counts.map(|count| Counts(count as u16)))));
        assert_eq!(peer.mode(), Mode::Armed, "{tick}");
        let seen = peer.observed();
        let pose = kinematics.forward(counts.map(|count| Motion::at(f64::from(count) / counts_per_rad)));
        for axis in 0..2 {
            assert!((seen[axis].device.position - pose.axes[axis].position).abs() < 1e-12, "{tick} {axis}");
            assert_eq!(actuators.forces[axis], -seen[axis].contact_force, "{tick} {axis}");
            felt[axis] = felt[axis].max(actuators.forces[axis].abs());
        }
        // τ = Jᵀ·F, to half a code of the motor.
        for joint in 0..2 {
            let torque = pose.jacobian[0][joint] * actuators.forces[0] + pose.jacobian[1][joint] * actuators.forces[1];
            let given = motor.joint_force(actuators.duties[joint]);
            assert!((given - torque).abs() <= 0.51 * motor.joint_force(cohold_core::device::motor::Duty(1)), "{tick}");
        }
    }
    assert!(felt.iter().all(|most| *most > 1.0), "{felt:?}");
}

/// The third axis of a device in space that shares two is held on its line.
#[test]
fn an_axis_that_is_not_shared_is_held() {
    let mut settings = scene("power", 3);
    settings.axis.shared = 2;
    let mut peer =
        Peer::<f64, AnyLaw<f64>, 2, 3, AnySpatial<f64>>::build(&settings, [Motion::REST; 3]).expect("a good scene");
    peer.command(Command::Arm);
    let at = Motion { position: 1e-3, velocity: 0.01 };
    let [x, y, z] = peer.tick(&Sensors::of(Reading::Exact([at; 3]))).forces;
    let (contact, axis) = (settings.contact, settings.axis);
    assert_eq!([x, y], [-(contact.stiffness_n_per_m * 1e-3 + contact.damping_n_s_per_m * 0.01); 2]);
    assert_eq!(z, -(axis.hold_stiffness_n_per_m * 1e-3 + axis.hold_damping_n_s_per_m * 0.01));
}

#[test]
fn a_packet_that_is_no_number_along_any_axis_turns_all_motors_off() {
    for bad in 0..3 {
        let mut peer = Space::<f32>::build(&scene("wave", 3), [Motion::REST; 3]).expect("a good scene");
        peer.command(Command::Arm);
        let mut packets = [Packet::default(); 3];
        packets[bad].wave = f32::NAN;
        peer.hear(&packets);
        assert_eq!(peer.mode(), Mode::Faulted(Fault::NonFiniteInput));
        let actuators = peer.tick(&Sensors::of(Reading::Exact([Motion::REST; 3])));
        assert!(!actuators.enable && actuators.forces == [0.0; 3], "{bad}");
    }
}

#[test]
fn a_pose_that_cannot_be_pushed_every_way_is_a_fault_while_armed() {
    let mut settings = scene("power", 3);
    settings.set("kinematics.model", Value::Text("arm")).expect("a word");
    settings.set("axis.velocity", Value::Text("difference")).expect("a word");
    let mut peer = Space::<f32>::build(&settings, [Motion::REST; 3]).expect("a good scene");
    // The fore link is let down, a hundred counts a tick, until both are in line.
    let mut count = 0_u16;
    let mut down = |peer: &mut Space<f32>| {
        count += 20;
        peer.tick(&Sensors::of(Reading::Counts([0, 0, count].map(Counts))))
    };
    for _ in 0..120 {
        down(&mut peer);
    }
    assert_eq!(peer.mode(), Mode::Disarmed, "nobody is pushed, so nothing is wrong");
    peer.command(Command::Arm);
    let actuators = down(&mut peer);
    assert_eq!(peer.mode(), Mode::Faulted(Fault::OutOfWorkspace));
    assert!(!actuators.enable);
}

#[test]
fn what_is_along_one_axis_is_refused_along_several() {
    let refused = |change: &dyn Fn(&mut Settings)| {
        let mut settings = scene("power", 2);
        change(&mut settings);
        settings.check().unwrap_err().to_string()
    };
    assert_eq!(
        refused(&|settings| settings.axis.count = 1),
        "axis.shared = 2 is not allowed: it must be a whole number from 1 to 1"
    );
    assert_eq!(
        refused(&|settings| settings.contact.one_sided = true),
        "contact.one_sided = true is not allowed: it must be false where axis.shared is more than 1: a side belongs to one axis"
    );
    assert_eq!(
        refused(&|settings| settings.contact.rendering = cohold_core::names::RenderingName::Impulsive),
        "contact.rendering = \"impulsive\" is not allowed: it must be \"continuous\" where axis.shared is more than 1: impacts \
         are along one axis"
    );
    // A peer that shares one axis does not take a scene of two.
    assert!(Peer::<f32, AnyLaw<f32>>::new(&scene("power", 2), [Motion::REST; 2]).is_err());
    assert!(Plane::<f32>::build(&scene("power", 2), [Motion::REST; 2]).is_ok());
}

/// Two axes with this fixture, and nobody else; every other setting that it needs.
fn beside_a_wall(axes: u32) -> Settings {
    let mut settings = scene("none", axes);
    settings.object.integrator = IntegratorName::Midpoint;
    settings.fixture.kind = cohold_core::names::FixtureName::ForbiddenAbove;
    settings.fixture.position_m = 0.002;
    settings.fixture.stiffness_n_per_m = 3000.0;
    settings
}

/// Where the copy is and what is felt, tick by tick, of a hand that is at `hand` (m, m/s along every axis).
fn ride<const N: usize, K: Kinematics<f64, N>>(
    settings: &Settings,
    ticks: u32,
    hand: impl Fn(f64) -> [Motion<f64>; N],
) -> Vec<([f64; N], [f64; N])> {
    let mut peer = Peer::<f64, AnyLaw<f64>, N, N, K>::build(settings, [Motion::REST; N]).expect("a good scene");
    peer.command(Command::Arm);
    (0..ticks)
        .map(|tick| {
            peer.tick(&Sensors::of(Reading::Exact(hand(1e-3 * f64::from(tick)))));
            assert_eq!(peer.mode(), Mode::Armed, "{tick}");
            let seen = peer.observed();
            (seen.map(|axis| axis.object.position), seen.map(|axis| axis.contact_force))
        })
        .collect()
}

/// In and out of a wall across x, and to and fro along y and z.
fn strokes(time: f64) -> [Motion<f64>; 3] {
    [(0.006, 4.0), (0.004, 7.0), (-0.005, 5.0)].map(|(size, rate): (f64, f64)| Motion {
        position: size * (rate * time).sin(),
        velocity: size * rate * (rate * time).cos(),
    })
}

#[test]
fn a_wall_along_an_axis_is_that_of_one_axis_and_leaves_the_others_alone() {
    let settings = beside_a_wall(3);
    let all = ride::<3, AnySpatial<f64>>(&settings, 3000, strokes);
    for axis in 0..3 {
        let mut one =
            Settings { axis: cohold_core::settings::Axis { count: 1, shared: 1, ..settings.axis }, ..settings };
        if axis > 0 {
            one.fixture.kind = cohold_core::names::FixtureName::None;
        }
        let mut peer = Peer::<f64, AnyLaw<f64>>::new(&one, [Motion::REST; 2]).expect("a good scene");
        peer.command(Command::Arm);
        for (tick, (object, felt)) in all.iter().enumerate() {
            peer.tick(&Sensors::of(Reading::Exact([strokes(1e-3 * tick as f64)[axis], Motion::REST])));
            let seen = peer.observed()[0];
            let difference = (seen.object.position - object[axis]).abs();
            assert!(
                difference < 1e-12 && (seen.contact_force - felt[axis]).abs() < 1e-8,
                "{axis} {tick}: {difference:e}"
            );
        }
    }
    assert!(all.iter().any(|(object, _)| object[0] > 0.0022), "never at the wall");
}

/// What happens at a wall turned by 45° is what happens at one along an axis, turned.
#[test]
fn a_wall_at_45_degrees_is_one_along_an_axis_turned() {
    let mut settings = beside_a_wall(2);
    (settings.fixture.friction, settings.fixture.drag_n_s_per_m) = (0.4, 0.5);
    let straight = ride::<2, AnyKinematics<f64>>(&settings, 3000, |time| {
        let [x, y, _] = strokes(time);
        [x, y]
    });
    settings.fixture.direction_rad = core::f64::consts::FRAC_PI_4;
    let (sine, cosine) = settings.fixture.direction_rad.sin_cos();
    let turned = |[x, y]: [f64; 2]| [cosine * x - sine * y, sine * x + cosine * y];
    let askew = ride::<2, AnyKinematics<f64>>(&settings, 3000, |time| {
        let [x, y, _] = strokes(time);
        let (at, speed) = (turned([x.position, y.position]), turned([x.velocity, y.velocity]));
        [0, 1].map(|axis| Motion { position: at[axis], velocity: speed[axis] })
    });
    for (tick, ((object, felt), (there, there_felt))) in straight.iter().zip(&askew).enumerate() {
        let (object, felt) = (turned(*object), turned(*felt));
        for axis in 0..2 {
            assert!((object[axis] - there[axis]).abs() < 1e-10, "{tick} {axis}");
            assert!((felt[axis] - there_felt[axis]).abs() < 1e-6, "{tick} {axis}");
        }
    }
}

/// Drawn along a wall at a steady speed, the object is felt with μ·N + B_f·v; pulled by less than that from rest it stays.
#[test]
fn friction_along_a_wall_is_felt_as_coulomb_has_it() {
    let mut settings = beside_a_wall(2);
    (settings.fixture.friction, settings.fixture.drag_n_s_per_m) = (0.4, 0.5);
    let (contact, speed, pressed) = (settings.contact.stiffness_n_per_m, 0.02, 0.006);
    let slides = ride::<2, AnyKinematics<f64>>(&settings, 3000, |time| {
        let moved = Motion { position: speed * time, velocity: speed };
        [Motion::at(pressed), moved]
    });
    let (_, [push, along]) = slides[2999];
    // Two springs, one behind the other.
    let wall = settings.fixture.stiffness_n_per_m;
    assert!((push - (pressed - 0.002) * contact * wall / (contact + wall)).abs() < 1e-6, "{push} N");
    assert!((along - (0.4 * push + 0.5 * speed)).abs() < 1e-6, "{along} N along, {push} N against it");
    // Pressed on at first, and drawn along once it rests there.
    let stays = ride::<2, AnyKinematics<f64>>(&settings, 3000, |time| {
        [Motion::at(pressed), Motion::at((0.3 * push / contact) * (time - 1.0).clamp(0.0, 1.0))]
    });
    let ([_, before], [_, after]) = (stays[1000].0, stays[2999].0);
    assert!((after - before).abs() < 1e-9 && (stays[2999].1[1] - 0.3 * push).abs() < 1e-3 * push, "{before} {after}");
}

#[test]
fn a_fixture_askew_is_refused_where_it_has_no_sense() {
    let refused = |axes: u32, change: &dyn Fn(&mut Settings)| {
        let mut settings = beside_a_wall(axes);
        change(&mut settings);
        settings.check().unwrap_err().to_string()
    };
    assert_eq!(
        refused(1, &|settings| settings.fixture.friction = 0.1),
        "fixture.friction = 0.1 is not allowed: it must be 0 where axis.shared is 1"
    );
    assert!(refused(2, &|settings| settings.fixture.elevation_rad = 0.1).contains("0 where axis.shared is 1 or 2"));
    assert!(refused(2, &|settings| settings.contact.gap_m = 0.001).contains("0 beside a fixture"));
    let guide = |settings: &mut Settings| {
        settings.fixture.kind = cohold_core::names::FixtureName::Guide;
        settings.fixture.friction = 0.1;
    };
    assert!(refused(2, &guide).contains("0 of a guide"));
}
