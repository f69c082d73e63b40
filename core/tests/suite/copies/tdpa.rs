//! The two ports beside a model that is written down from the paper, what they hold back, and that neither ever gives more than it may.

use haptic_core::contact::Side;
use haptic_core::device::AXES;
use haptic_core::law::tdpa::Tdpa;
use haptic_core::law::{Coupled, Law, Observation, Packet};
use haptic_core::num::{Fixed, Motion, Scalar};
use haptic_core::object::Port;
use haptic_core::peer::Peer;
use haptic_core::safety::Command;
use haptic_core::settings::Settings;

use super::{Copies, PERIOD, draws, settings};

const MASS_KG: f64 = 0.3;
/// 2m_O/T_c, N·s/m.
const INERTIA: f64 = 2.0 * MASS_KG / PERIOD;

type State = <Tdpa<f64> as Law<f64>>::State;

/// One port, with its copy and what it has put in, J.
struct End {
    law: Tdpa<f64>,
    state: State,
    copy: Motion<f64>,
    sent_j: f64,
    /// What the copy got, J.
    given_j: f64,
}

impl End {
    fn new(mut settings: Settings, side: Side) -> Self {
        settings.contact.side = side;
        let law = <Tdpa<f64> as Law<f64>>::build(&settings).expect("good settings");
        let state = Law::<f64>::start(&law, Motion::REST);
        Self { law, state, copy: Motion::REST, sent_j: 0.0, given_j: 0.0 }
    }

    fn packet(&self) -> Packet<f64> {
        Packet { energy_j: self.sent_j, ..self.law.send(&self.state, self.copy) }
    }

    fn hear(&mut self, packet: Packet<f64>) {
        self.law.receive(&mut self.state, packet);
    }

    /// A tick under this hand.
    fn tick(&mut self, hand: Port<f64>, age_ticks: u32) -> Coupled<f64> {
        let copy = self.copy;
        let seen = Observation { local: copy, age_ticks, ..Observation::default() };
        let mut mean = 0.0;
        let coupled = self.law.couple(&mut self.state, &seen, |port: Port<f64>| {
            let all = port + hand;
            mean = (INERTIA * copy.velocity + all.force) / (INERTIA + all.impedance);
            mean
        });
        self.copy = Motion { position: copy.position + PERIOD * mean, velocity: 2.0 * mean - copy.velocity };
        self.sent_j += PERIOD * coupled.power_out;
        self.given_j += PERIOD * coupled.force * mean;
        coupled
    }
}

fn hand(push: f64, copy: Motion<f64>) -> Port<f64> {
    let (stiffness, damping) = (150.0, 4.0);
    Port { force: push - stiffness * copy.position, impedance: stiffness * PERIOD / 2.0 + damping }
}

/// With plenty in the accounts nothing is held back, and the pair is the paper's architecture: written down here as the equations of a tick, two masses,
/// a point that follows and a force that comes back, `delay` packets late, packets of `ticks`.
#[test]
fn with_plenty_it_is_velocity_out_and_force_back() {
    let (stiffness, damping) = (300.0, 3.0);
    for (delay, ticks, drift_s) in [(0, 1, 0.0), (1, 1, 0.1), (3, 4, 0.05), (2, 8, 0.0)] {
        let keys = [
            ("coordination.stiffness_n_per_m", stiffness),
            ("coordination.damping_n_s_per_m", damping),
            ("coordination.tank_j", haptic_core::settings::PLENTY_J),
            ("tdpa.drift_s", drift_s),
            ("timing.ticks_per_packet", f64::from(ticks)),
        ];
        let scene = settings("tdpa", &keys);
        let mut ends = [Side::Left, Side::Right].map(|side| End::new(scene, side));
        let mut on_the_way = Vec::new();
        // The paper's: both copies, x_sd, f_s; and the packets of each [x, v, f].
        let (mut master, mut slave, mut point, mut force) = (Motion::<f64>::REST, Motion::<f64>::REST, 0.0, 0.0);
        let (mut heard, mut packets) = ([[0.0; 3]; 2], Vec::new());
        let share = if drift_s > 0.0 { 1.0 - (-PERIOD / drift_s).exp() } else { 0.0 };
        for tick in 0..4000_usize {
            let age = (tick % ticks as usize) as u32;
            if age == 0 {
                on_the_way.push([ends[0].packet(), ends[1].packet()]);
                packets.push([[master.position, master.velocity, 0.0], [slave.position, slave.velocity, force]]);
                if on_the_way.len() > delay {
                    let [one, two] = on_the_way[on_the_way.len() - 1 - delay];
                    ends[0].hear(two);
                    ends[1].hear(one);
                    let [one, two] = packets[packets.len() - 1 - delay];
                    heard = [two, one];
                }
            }
            let t = tick as f64 * PERIOD;
            let push = 2.0 * (9.0 * t).sin() + (23.0 * t).sin();
            for (at, end) in ends.iter_mut().enumerate() {
                end.tick(hand(if at == 0 { push } else { 0.0 }, end.copy), age);
            }
            // Master: 2m/T·(v̄ − v) = hand − f_s, the hand at the middle of the tick.
            let mean = (INERTIA * master.velocity + push - 150.0 * master.position - heard[0][2])
                / (INERTIA + 150.0 * PERIOD / 2.0 + 4.0);
            master = Motion { position: master.position + PERIOD * mean, velocity: 2.0 * mean - master.velocity };
            // Slave: the point goes on at the velocity heard and toward where the master was, then the spring pulls.
            let reference = heard[1][0] + PERIOD * heard[1][1] * f64::from(age);
            let step = PERIOD * heard[1][1] + share * (reference - point);
            point += step;
            let mean = (INERTIA * slave.velocity - 150.0 * slave.position
                + stiffness * (point - slave.position)
                + damping * step / PERIOD)
                / (INERTIA + 150.0 * PERIOD / 2.0 + 4.0 + stiffness * PERIOD / 2.0 + damping);
            force = stiffness * (point - slave.position - PERIOD / 2.0 * mean) + damping * (step / PERIOD - mean);
            slave = Motion { position: slave.position + PERIOD * mean, velocity: 2.0 * mean - slave.velocity };
            for (ours, theirs) in [(ends[0].copy, master), (ends[1].copy, slave)] {
                let off = (ours.position - theirs.position).abs();
                assert!(off < 1e-9, "{delay} packets of {ticks}, tick {tick}: {off} m apart");
            }
        }
        assert!(slave.position.abs() > 1e-4, "nothing moved");
    }
}

/// Packets that no copy makes and hands that throw: W ≥ 0 in every tick, and no copy gets more than was heard, was in the account and it gave.
#[test]
fn either_port_is_passive() {
    for (seed, start) in (0..60_u64).zip([0.0, 0.001, 0.02].into_iter().cycle()) {
        for side in [Side::Left, Side::Right] {
            let mut random = draws(seed);
            let keys = [
                ("coordination.stiffness_n_per_m", 10.0_f64.powf(3.0 + 2.0 * random())),
                ("coordination.damping_n_s_per_m", 10.0 * (random() + 0.5)),
                ("coordination.tank_j", start),
                ("timing.ticks_per_packet", 4.0),
            ];
            let mut end = End::new(settings("tdpa", &keys), side);
            let (mut said, mut heard, mut age, mut least) = (0.0, 0.0, 0, start);
            let mut first = true;
            for _ in 0..4000 {
                if random() > 0.2 {
                    if random() > 0.3 {
                        said += 0.002 * (random() + 0.5);
                    }
                    let motion = Motion { position: 0.1 * random(), velocity: 3.0 * random() };
                    end.hear(Packet { motion, wave: 20.0 * random(), energy_j: said, ..Packet::default() });
                    // The first brings no past.
                    heard = if first { 0.0 } else { said };
                    if first {
                        said = 0.0;
                        end.state = Law::<f64>::start(&end.law, Motion::REST);
                        end.hear(Packet::default());
                    }
                    (first, age) = (false, 0);
                }
                let push = Port { force: 8.0 * random(), impedance: 1.0 };
                end.tick(push, age);
                age += 1;
                least = least.min(end.state.account_j());
                assert!(end.state.account_j() >= 0.0, "seed {seed}, {side:?}");
                let out = end.given_j + end.sent_j;
                assert!(out <= start + heard + 1e-9, "seed {seed}, {side:?}: {out} J out, {heard} J heard");
            }
            assert!(end.sent_j > 0.001 && heard > 0.01, "seed {seed}, {side:?}: {} J in, {heard} J heard", end.sent_j);
            assert!(least < 0.001, "seed {seed}, {side:?}: never short, {least} J");
        }
    }
}

/// The admittance controller: of a step that W does not cover so much is made that ½K·Δ² = W, and the next only when more was put in.
#[test]
fn the_slave_s_point_goes_as_far_as_was_put_in() {
    let stiffness = 1000.0;
    let keys = [
        ("coordination.stiffness_n_per_m", stiffness),
        ("coordination.damping_n_s_per_m", 0.0),
        ("coordination.tank_j", 0.0),
        ("tdpa.drift_s", 1e-4),
    ];
    let mut end = End::new(settings("tdpa", &keys), Side::Right);
    let held = Port { force: 0.0, impedance: 1e12 };
    let far = |energy_j: f64| Packet { motion: Motion::at(1.0), energy_j, ..Packet::default() };
    end.hear(far(0.0));
    assert_eq!(end.tick(held, 0).force, 0.0);
    for put_in in [0.001, 0.001, 0.004, 0.02] {
        end.hear(far(put_in));
        let force = end.tick(held, 0).force;
        let wanted = (2.0 * put_in * stiffness).sqrt();
        assert!((force / wanted - 1.0).abs() < 1e-6, "{put_in} J: {force} N, {wanted} N");
    }
}

/// The impedance controller: the worst velocity, f/2α, takes all of W, and no other takes more.
#[test]
fn the_worst_velocity_takes_all_that_the_master_s_port_has() {
    let (start, pushed) = (0.001, 4.0);
    for share in [0.25, 1.0, 2.0, -1.0] {
        let mut end = End::new(settings("tdpa", &[("coordination.tank_j", start)]), Side::Left);
        end.hear(Packet { wave: -pushed, ..Packet::default() });
        let resistance = PERIOD * pushed * pushed / (4.0 * start);
        let velocity = share * pushed / (2.0 * resistance);
        let seen = Observation::default();
        let coupled = end.law.couple(&mut end.state, &seen, |port: Port<f64>| {
            assert!((port.impedance / resistance - 1.0).abs() < 1e-12 && port.force == pushed, "{port:?}");
            velocity
        });
        let given = PERIOD * coupled.force * velocity;
        // Of what was taken from the copy −f·v is for the other end, and α·v² is dissipated: that W may give again.
        let wanted = start - given - PERIOD * coupled.power_out;
        assert!((end.state.account_j() - wanted).abs() < 1e-15, "{share}: {} J", end.state.account_j());
        assert!(if share == 1.0 { end.state.account_j() < 1e-15 } else { end.state.account_j() > 0.0 }, "{share}");
    }
}

/// A slave that was held back while packets were lost comes to where the master is by e^(−t/τ), and without a compensator stays behind.
#[test]
fn drift_dies_away_with_its_time_constant() {
    let run = |drift_s: f64, ticks: u32| {
        let keys = [("coordination.stiffness_n_per_m", 100.0), ("tdpa.drift_s", drift_s), ("coordination.tank_j", 1.0)];
        let mut end = End::new(settings("tdpa", &keys), Side::Right);
        end.hear(Packet { motion: Motion::at(0.01), ..Packet::default() });
        let mut point = 0.0;
        for _ in 0..ticks {
            point = end.tick(Port { force: 0.0, impedance: 1e9 }, 5).desired.position;
        }
        0.01 - point
    };
    let left = run(0.05, 50) / 0.01;
    assert!((left - (-1.0_f64).exp()).abs() < 1e-9, "{left}");
    assert_eq!(run(0.0, 2000), 0.01);
}

/// Both ends over a network that loses half, hands that push and throw: at no tick have the copies more than both accounts had at first and was done on them.
fn copies_get_no_more<S: Scalar>(rounding_j: f64) {
    let start = 0.005;
    let mut least = f64::MAX;
    for seed in 0..20_u64 {
        let mut random = draws(seed);
        let keys = [
            ("coordination.stiffness_n_per_m", 10.0_f64.powf(3.0 + 2.0 * random())),
            ("coordination.damping_n_s_per_m", 10.0 * (random() + 0.5)),
            ("coordination.tank_j", start),
            ("timing.ticks_per_packet", (4.0 * (random() + 0.5)).floor() + 1.0),
            ("contact.stiffness_n_per_m", 200.0),
        ];
        let scene = settings("tdpa", &keys);
        let mut copies = Copies::<S>::new(&scene, 3);
        copies.peers = [Side::Left, Side::Right].map(|side| {
            let mut settings = scene;
            settings.contact.side = side;
            let mut peer = Peer::new(&settings, [Motion::REST; AXES]).expect("a good scene");
            peer.command(Command::Arm);
            peer
        });
        let (mut work, mut before, mut hands) = (0.0, None::<[(f64, f64); 2]>, [Motion::<f64>::REST; 2]);
        for tick in 0..3000 {
            for hand in &mut hands {
                if tick % 50 == 0 {
                    hand.velocity = 0.4 * random() - 2.0 * hand.position;
                }
                hand.position += PERIOD * hand.velocity;
            }
            let mut luck = draws(seed * 10_000 + tick);
            let seen = copies.tick_over(hands, || luck() > 0.0);
            let now = seen.map(|seen| (seen.object.velocity.to_f64(), seen.contact_force.to_f64()));
            if let Some(before) = before {
                for at in 0..2 {
                    work += PERIOD * before[at].1 * 0.5 * (before[at].0 + now[at].0);
                }
            }
            before = Some(now);
            let kinetic: f64 = now.iter().map(|(velocity, _)| 0.5 * MASS_KG * velocity * velocity).sum();
            let made = kinetic - work;
            assert!(made <= 2.0 * start + rounding_j, "seed {seed}, tick {tick}: {made} J");
            least = least.min(2.0 * start - made);
        }
        assert!(work.abs() > 0.001, "seed {seed}: {work} J of work");
    }
    assert!(least < 2.0 * start, "nothing was ever given");
}

#[test]
fn copies_get_no_more_than_both_accounts_over_a_bad_network() {
    copies_get_no_more::<f64>(1e-12);
    copies_get_no_more::<f32>(1e-6);
    copies_get_no_more::<Fixed>(1e-6);
}
