//! The junction behind a hub: its closed form while a line fades, and that it is passive whatever the network does.

use cohold_core::law::Packet;
use cohold_environments::cooperative::junction::{Energy, Junction};
use cohold_environments::cooperative::node::Node;
use cohold_sim::{Scene, scenes};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Impedance and packet period of the defaults.
const B: f64 = 10.0;
const PACKET_S: f64 = 0.008;

fn scene(ledger: bool) -> Scene {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), "hub").expect("a built-in scene");
    scene.peer.coordination.ledger = ledger;
    scene.peer.coordination.drift_correction = ledger;
    scene
}

fn wave(wave: f64) -> Option<[Packet<f64>; 1]> {
    Some([Packet { wave, ..Packet::default() }])
}

#[test]
fn lines_that_are_there_meet_in_the_plain_node() {
    let mut junction = Junction::new(&scene(false), 3).expect("waves");
    let node = Node::<f64, 3>::new([B; 3]);
    for waves in [[0.3, -0.7, 0.1], [1.0, 2.0, -5.0], [0.0, 0.0, 1e-3]] {
        junction.exchange(waves.map(wave), true);
        let scattered = node.scatter(waves);
        assert!((junction.motion[0].velocity - scattered.velocity).abs() < 1e-15);
        for ((port, back), wave) in junction.ports.iter().zip(scattered.back).zip(waves) {
            let [port] = port.axes;
            assert!((port.back.wave - back).abs() < 1e-14, "{port:?}");
            // What is left over of force is nothing; what each line gives is √(b/2)·(u − w).
            assert!((port.force_n - (B / 2.0).sqrt() * (wave - back)).abs() < 1e-14);
        }
        assert!(junction.ports.iter().map(|port| port.axes[0].force_n).sum::<f64>().abs() < 1e-13);
    }
}

/// Three packet periods as if nothing were, then nine steps, each as in closed form: v = √(2b)·Σs·u/(b·Σs).
#[test]
fn a_line_that_falls_silent_goes_quiet_step_by_step() {
    let mut junction = Junction::new(&scene(false), 3).expect("waves");
    let waves = [0.04, 0.02, 0.09];
    let velocity = |share: f64| (2.0 * B).sqrt() * (0.06 + share * 0.09) / (B * (2.0 + share));
    junction.exchange(waves.map(wave), true);
    assert!((junction.motion[0].velocity - velocity(1.0)).abs() < 1e-15);
    for silent in 1..=20_u32 {
        junction.exchange([wave(0.04), wave(0.02), None], true);
        let share = 1.0 - f64::from(silent.clamp(3, 12) - 3) / 9.0;
        assert!((junction.motion[0].velocity - velocity(share)).abs() < 1e-14, "{silent} periods");
        let back = share * ((2.0 * B).sqrt() * velocity(share) - 0.09);
        assert!((junction.ports[2].axes[0].back.wave - back).abs() < 1e-13, "{silent} periods");
        let energy = junction.energy();
        assert!(energy.sent_j <= energy.taken_j * (1.0 + 1e-12), "{energy:?}");
    }
    assert!(!junction.ports[2].is_engaged() && junction.ports[1].is_engaged());
    for packet in 1..=10 {
        junction.exchange(waves.map(wave), true);
        let share = f64::from(packet.min(9)) / 9.0;
        assert!((junction.motion[0].velocity - velocity(share)).abs() < 1e-14, "{packet} packets");
    }
}

/// However much a line pulls with, what it and the others feel falls by no more than 0.02 N a tick, in silence and when its peer is known to be gone;
/// and only then is it let go.
#[test]
fn a_large_force_falls_as_slowly_as_a_small_one() {
    for (name, parts) in [("is silent", false), ("is gone", true)] {
        for own in [0.5, 1.0, -2.0, 8.0] {
            let mut junction = Junction::<1>::new(&scene(false), 3).expect("waves");
            let waves = [0.4, 0.2, own];
            (0..10).for_each(|_| junction.exchange(waves.map(wave), true));
            // What each line does to the node: √(b/2)·(√s·u − w) for what of its wave goes in and what the node answers.
            let force_n = |share: f64, velocity: f64| share * ((2.0 * B).sqrt() * own - B * velocity);
            let mut before = (1.0, force_n(1.0, junction.motion[0].velocity), junction.ports[0].axes[0].force_n);
            let first_n = before.1.abs();
            if parts {
                junction.part(2);
            }
            let mut periods = 0;
            while junction.ports[2].is_engaged() {
                junction.exchange([wave(0.4), wave(0.2), None], true);
                let [port] = junction.ports[2].axes;
                let velocity = junction.motion[0].velocity;
                // Of what comes back, w = s·(√(2b)·v − u).
                let share = port.back.wave / ((2.0 * B).sqrt() * velocity - own);
                let now = (share, force_n(share, velocity), junction.ports[0].axes[0].force_n);
                let told = format!("{own} √W, {name}, period {periods}: {now:?} after {before:?}");
                assert!(share <= before.0 + 1e-12, "{told}");
                let most_n = 8.0 * 0.02;
                assert!((now.1 - before.1).abs() < most_n && (now.2 - before.2).abs() < most_n, "{told}");
                (before, periods) = (now, periods + 1);
                assert!(periods < 1_000, "{told}");
            }
            assert!(f64::from(periods) > first_n / (8.0 * 0.02), "{own} √W: {first_n} N in {periods} periods");
            assert_eq!(junction.ports[2].axes[0].back.wave, 0.0);
        }
    }
}

/// Whoever begins anew on a line is let in when what was there before has faded.
#[test]
fn another_life_waits_until_the_line_is_quiet() {
    let mut junction = Junction::new(&scene(true), 2).expect("waves");
    // A wave that varies between packets costs more than its mean: what is left over pays for holding.
    let packet = |wave: f64, count: u32| {
        let energy_j = 1.5 * 0.5 * PACKET_S * wave * wave * f64::from(count);
        Some([Packet { wave, energy_j, wave_integral: PACKET_S * wave * f64::from(count), ..Packet::default() }])
    };
    for count in 1..100 {
        junction.exchange([packet(0.3, count), packet(0.3, count)], true);
    }
    let before = junction.motion[0].velocity;
    junction.part(1);
    let mut last = before;
    for count in 1..=12 {
        junction.exchange([packet(0.3, 99 + count), packet(-0.8, count)], true);
        let step = (junction.motion[0].velocity - last).abs();
        // Both pushed alike, so the velocity does not change while one of them lets go.
        assert!(step < 1e-12, "period {count}: {step} m/s");
        last = junction.motion[0].velocity;
    }
    assert!(!junction.ports[1].is_engaged());
    for count in 13..60 {
        junction.exchange([packet(0.3, 99 + count), packet(-0.8, count)], true);
        // At most a ninth of the line comes at once.
        assert!((junction.motion[0].velocity - last).abs() < 0.2 * (2.0_f64 * B).sqrt() * 1.1 / B, "period {count}");
        last = junction.motion[0].velocity;
    }
    let velocity = (2.0 * B).sqrt() * (0.3 - 0.8) / (2.0 * B);
    assert!((last - velocity).abs() < 1e-9, "{last} m/s, not {velocity}");
}

/// Loss, reorder, duplicates, silence and restarts, waves at random: never more out than the peers have put in, at any time.
#[test]
fn passive_whatever_the_network_does() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(5);
    let mut unit = move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    for users in [2, 3, 16] {
        let mut junction = Junction::new(&scene(true), users).expect("waves");
        (0..users).for_each(|line| junction.part(line));
        let mut sent = vec![Packet::<f64>::default(); users];
        let mut held = sent.clone();
        let mut truly_in_j = 0.0;
        for period in 0..20_000 {
            let mut came = vec![None; users];
            for line in 0..users {
                if unit() < 1e-3 {
                    // A new life: its counters begin anew.
                    sent[line] = Packet::default();
                    junction.part(line);
                }
                let level = if period / 500 % 2 == 0 { 0.5 } else { 0.01 };
                let wave = level * (2.0 * unit() - 1.0);
                let energy_j = 0.5 * PACKET_S * wave * wave;
                truly_in_j += energy_j;
                let before = sent[line];
                sent[line] = Packet {
                    wave,
                    energy_j: before.energy_j + energy_j,
                    wave_integral: before.wave_integral + PACKET_S * wave,
                    ..before
                };
                came[line] = match unit() {
                    lost if lost < 0.3 => None,
                    old if old < 0.4 => Some([held[line]]),
                    _ => Some([sent[line]]),
                };
                if unit() < 0.2 {
                    held[line] = sent[line];
                }
            }
            junction.exchange(came, true);
            let energy = junction.energy();
            assert!(energy.sent_j <= energy.taken_j * (1.0 + 1e-9) + 1e-12, "{users} users, {period}: {energy:?}");
            assert!(
                energy.taken_j <= truly_in_j + 1e-12,
                "{users} users, {period}: {energy:?}, {truly_in_j} J in truth"
            );
        }
        let energy = junction.energy();
        assert!(energy.put_in_j <= truly_in_j && energy.sent_j > 0.2 * truly_in_j, "{energy:?} of {truly_in_j} J");
    }
}

#[test]
fn laws_without_waves_are_refused() {
    let mut scene = scene(true);
    for (law, name) in [("power", "power"), ("none", "none")] {
        scene.peer.coordination.comm = law;
        let said = Junction::<1>::new(&scene, 2).expect_err("no waves").to_string();
        assert!(said.contains(&format!("coordination.comm = \"{name}\"")), "{said}");
    }
}

/// A peer that claims whatever its numbers can say: what the others get stays finite, what it puts in is what the junction would
/// give out, and the figures of all are off by the credit that is kept, 0.1 J, at the most.
#[test]
fn claims_of_one_line_forge_no_figure_of_another() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let mut any = |of: &[f64]| of[random.next_u64() as usize % of.len()];
    let mut junction = Junction::new(&scene(true), 3).expect("waves");
    (0..3).for_each(|line| junction.part(line));
    let (mut honest, mut truly_in_j) = ([Packet::<f64>::default(); 2], [0.0; 2]);
    for period in 0..5_000 {
        for (line, (packet, truly_in_j)) in honest.iter_mut().zip(&mut truly_in_j).enumerate() {
            let wave = 0.2 * (0.02 * f64::from(period) + line as f64).sin();
            let energy_j = 0.5 * PACKET_S * wave * wave;
            *truly_in_j += energy_j;
            (packet.wave, packet.energy_j) = (wave, packet.energy_j + energy_j);
            packet.wave_integral += PACKET_S * wave;
        }
        // Ever more, from the first packet to the largest number there is; and less than nothing in between.
        let most = 10.0_f64.powf(-300.0 + f64::from(period) / 8.2);
        let claims = [most, most, -most, f64::MIN, 0.0];
        let waves = [0.0, 1.0, -1.0, 1e30, -3.4e38, 3.4e38];
        let forged =
            Packet { wave: any(&waves), energy_j: any(&claims), wave_integral: any(&claims), ..Packet::default() };
        junction.exchange([Some([honest[0]]), Some([honest[1]]), Some([forged])], true);
        for port in &junction.ports {
            let [back] = port.back();
            assert!([back.wave, back.energy_j, back.wave_integral].iter().all(|number| number.is_finite()), "{port:?}");
        }
    }
    for (port, truly_in_j) in junction.ports.iter().zip(truly_in_j) {
        assert!((port.energy().put_in_j / truly_in_j - 1.0).abs() < 1e-9, "{port:?}, {truly_in_j} J in truth");
    }
    let Energy { put_in_j, taken_j, .. } = junction.ports[2].energy();
    assert!(put_in_j <= taken_j + 0.1 + 1e-9, "{put_in_j} J claimed, {taken_j} J taken");
    let Energy { put_in_j, sent_j, .. } = junction.energy();
    assert!(sent_j <= put_in_j && sent_j > 0.1 * put_in_j, "{sent_j} J out, {put_in_j} J in");
}

/// Loss, old packets, silences and restarts, other waves along every axis: a junction of three axes is three of one, to the bit.
#[test]
fn each_axis_of_a_junction_is_a_junction_of_one() {
    const LINES: usize = 4;
    let mut random = Xoshiro256PlusPlus::seed_from_u64(13);
    let mut unit = move || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    for name in ["hub", "any-network"] {
        let alone = scenes::load(cohold_sim::Laws::built_in(), name).expect("a built-in scene");
        let mut space = alone.clone();
        (space.peer.axis.count, space.peer.axis.shared) = (3, 3);
        let mut whole = Junction::<3>::new(&space, LINES).expect("waves");
        let mut ones = [(); 3].map(|()| Junction::<1>::new(&alone, LINES).expect("waves"));
        let part = |whole: &mut Junction<3>, ones: &mut [Junction<1>; 3], line: usize| {
            whole.part(line);
            ones.iter_mut().for_each(|one| one.part(line));
        };
        (0..LINES).for_each(|line| part(&mut whole, &mut ones, line));
        let packet_s = alone.peer.timing.packet_period_s();
        let mut sent = [[Packet::<f64>::default(); 3]; LINES];
        let mut held = sent;
        let (mut let_go, mut farthest_m) = (0, 0.0_f64);
        for period in 0..20_000 {
            let mut came = [None; LINES];
            for (line, came) in came.iter_mut().enumerate() {
                if unit() < 1e-3 {
                    sent[line] = [Packet::default(); 3];
                    part(&mut whole, &mut ones, line);
                }
                for packet in &mut sent[line] {
                    packet.wave = 0.15 * (unit() - 0.45);
                    packet.energy_j += 0.5 * packet_s * packet.wave * packet.wave;
                    packet.wave_integral += packet_s * packet.wave;
                    packet.live_ticks += alone.peer.timing.ticks_per_packet;
                }
                // Each line in its turn is silent for longer than it is held.
                let silent = period / 200 % 8 == line;
                *came = match unit() {
                    lost if silent || lost < 0.3 => None,
                    old if old < 0.4 => Some(held[line]),
                    _ => Some(sent[line]),
                };
                if unit() < 0.2 {
                    held[line] = sent[line];
                }
            }
            whole.exchange(came, true);
            for (axis, one) in ones.iter_mut().enumerate() {
                one.exchange(came.map(|came| came.map(|packets| [packets[axis]])), true);
                let at = format!("{name}, axis {axis}, period {period}");
                assert_eq!((whole.motion[axis], whole.energies()[axis]), (one.motion[0], one.energy()), "{at}");
                for (port, own) in whole.ports.iter().zip(&one.ports) {
                    let (of_axis, own_axis) = (&port.axes[axis], &own.axes[0]);
                    assert_eq!((of_axis.back, of_axis.force_n), (own_axis.back, own_axis.force_n), "{at}");
                    assert_eq!(port.is_engaged(), own.is_engaged(), "{at}");
                }
                farthest_m = farthest_m.max(one.motion[0].position.abs());
            }
            let_go += whole.ports.iter().filter(|port| !port.is_engaged()).count();
        }
        assert!(let_go > 20 && farthest_m > 0.01, "{name}: {let_go} periods without a line, {farthest_m} m");
    }
}

/// Two lines along two axes, and a third that is honest along the first and claims what it likes along the second: along the first all is
/// as around a junction of one axis, to the bit, and along the second the figures are off by the credit that is kept, at the most.
#[test]
fn claims_along_one_axis_forge_no_figure_along_another() {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let mut any = |of: &[f64]| of[random.next_u64() as usize % of.len()];
    let mut plane = scene(true);
    (plane.peer.axis.count, plane.peer.axis.shared) = (2, 2);
    let mut both = Junction::<2>::new(&plane, 3).expect("waves");
    let mut first = Junction::<1>::new(&scene(true), 3).expect("waves");
    let mut honest = [Packet::<f64>::default(); 3];
    for period in 0..5_000 {
        for (line, packet) in honest.iter_mut().enumerate() {
            packet.wave = 0.2 * (0.02 * f64::from(period) + line as f64).sin();
            packet.energy_j += 0.5 * PACKET_S * packet.wave * packet.wave;
            packet.wave_integral += PACKET_S * packet.wave;
        }
        let most = 10.0_f64.powf(-300.0 + f64::from(period) / 8.2);
        let claims = [most, most, -most, f64::MIN, 0.0];
        let waves = [0.0, 1.0, -1.0, 1e30, -3.4e38, 3.4e38];
        let forged =
            Packet { wave: any(&waves), energy_j: any(&claims), wave_integral: any(&claims), ..Packet::default() };
        let second = [honest[0], honest[1], forged];
        both.exchange([0, 1, 2].map(|line| Some([honest[line], second[line]])), true);
        first.exchange(honest.map(|packet| Some([packet])), true);
        assert_eq!((both.motion[0], both.energies()[0]), (first.motion[0], first.energy()), "period {period}");
        for (port, alone) in both.ports.iter().zip(&first.ports) {
            assert_eq!((port.back()[0], port.is_engaged()), (alone.back()[0], alone.is_engaged()), "period {period}");
            assert!(port.back()[1].is_finite(), "{port:?}");
        }
    }
    let Energy { put_in_j, taken_j, .. } = both.ports[2].axes[1].energy;
    assert!(put_in_j <= taken_j + 0.1 + 1e-9, "{put_in_j} J claimed, {taken_j} J taken");
    assert!(both.energies().iter().all(|energy| energy.sent_j <= energy.put_in_j && energy.sent_j > 0.0));
}
