//! The model is learned to be what the other hand is, is felt without delay, and never gives more than its account has.

use cohold_core::law::{Law, Observation, Packet};
use cohold_core::num::Motion;
use cohold_core::object::Port;
use cohold_core::settings::Settings;
use cohold_laws::model_mediated::ModelMediated;

use super::draws;
use crate::two_copies::{Copies, PERIOD, Phasor, settings, swing};

type State = <ModelMediated<f64> as Law<f64>>::State;

fn scene(keys: &[(&str, f64)]) -> Settings {
    let base = [
        ("coordination.stiffness_n_per_m", 3000.0),
        ("coordination.damping_n_s_per_m", 5.0),
        ("contact.stiffness_n_per_m", 600.0),
        ("contact.damping_n_s_per_m", 3.0),
    ];
    settings("model-mediated", &[&base[..], keys].concat())
}

/// Two ends of the law by themselves, each on a copy of 0.3 kg; what else pushes on the copies is said.
struct Ends {
    law: ModelMediated<f64>,
    states: [State; 2],
    copies: [Motion<f64>; 2],
    /// Energy that each end gave to the network, J.
    sent_j: [f64; 2],
    /// Energy that each end took from the network, J, and gave to its copy, J.
    received_j: [f64; 2],
    to_copy_j: [f64; 2],
}

const MASS_KG: f64 = 0.3;

impl Ends {
    fn new(settings: &Settings) -> Self {
        let law = <ModelMediated<f64> as Law<f64>>::build(settings).expect("good settings");
        let states = [Motion::REST; 2].map(|rest| law.start(rest));
        Self { law, states, copies: [Motion::REST; 2], sent_j: [0.0; 2], received_j: [0.0; 2], to_copy_j: [0.0; 2] }
    }

    fn packet(&self, at: usize) -> Packet<f64> {
        Packet { energy_j: self.sent_j[at], ..self.law.send(&self.states[at], self.copies[at]) }
    }

    /// A tick: on each copy a spring and damper to a place (N/m, N·s/m, m) and a push, N.
    fn tick(&mut self, hands: [[f64; 4]; 2]) {
        for (at, [stiffness, damping, place, push]) in hands.into_iter().enumerate() {
            let copy = self.copies[at];
            let hand = Port {
                force: stiffness * (place - copy.position) + push,
                impedance: stiffness * PERIOD / 2.0 + damping,
            };
            let mut mean = 0.0;
            let seen = Observation { local: copy, ..Observation::default() };
            let coupled = self.law.couple(&mut self.states[at], &seen, |port: Port<f64>| {
                let all = port + hand;
                let inertia = 2.0 * MASS_KG / PERIOD;
                mean = (inertia * copy.velocity + all.force) / (inertia + all.impedance);
                mean
            });
            self.copies[at] = Motion { position: copy.position + PERIOD * mean, velocity: 2.0 * mean - copy.velocity };
            self.sent_j[at] += PERIOD * coupled.power_out;
            self.received_j[at] += PERIOD * coupled.power_in;
            self.to_copy_j[at] += PERIOD * coupled.force * mean;
        }
    }
}

/// Copy 2 is held by a spring and damper of known values; hand 1 shakes. After 6 s the model at peer 1 is that hand with the copy's own mass.
#[test]
fn the_model_becomes_the_other_hand_and_copy() {
    for ticks_per_packet in [1_usize, 8] {
        for (stiffness, damping, place) in [(600.0, 3.0, 0.0), (150.0, 8.0, 0.004), (0.0, 2.0, 0.0)] {
            let settings = scene(&[("timing.ticks_per_packet", ticks_per_packet as f64)]);
            let mut ends = Ends::new(&settings);
            for tick in 0..6000_usize {
                if tick % ticks_per_packet == 0 {
                    let [one, two] = [0, 1].map(|at| ends.packet(at));
                    ends.law.receive(&mut ends.states[0], two);
                    ends.law.receive(&mut ends.states[1], one);
                }
                let t = tick as f64 * PERIOD;
                let push = 2.0 * (9.0 * t).sin() + 1.5 * (23.0 * t).sin() + (47.0 * t).sin();
                ends.tick([[0.0, 1.0, 0.0, push], [stiffness, damping, place, 0.0]]);
            }
            let model = ends.states[0].model();
            let label = format!("{ticks_per_packet} ticks a packet, {stiffness} N/m, {damping} N·s/m: {model:?}");
            assert!((model.mass / MASS_KG - 1.0).abs() < 0.05, "{label}");
            assert!((model.damping - damping).abs() < 0.05 * damping + 0.1, "{label}");
            assert!((model.stiffness - stiffness).abs() < 0.05 * stiffness + 5.0, "{label}");
            if stiffness > 0.0 {
                assert!((model.rest - place).abs() < 5e-4, "{label}");
            }
        }
    }
}

/// What hand 1 feels at 100 ms each way: the shared object's two copies and the other hand, m̂·s + … + Z_e, as a model that knows them renders it; by the
/// power-domain law's standards no delay at all.
#[test]
fn what_was_learned_is_felt_without_delay() {
    let felt = |delay: usize| {
        let settings =
            scene(&[("model_mediated.correction_n_per_m", 20.0), ("model_mediated.correction_n_s_per_m", 0.2)]);
        let mut copies = Copies::<f64>::new(&settings, delay);
        let omega = std::f64::consts::TAU * 2.0;
        let (mut force, mut speed) = (Phasor::default(), Phasor::default());
        for tick in 0..20_000_u32 {
            let time = f64::from(tick) * PERIOD;
            let [one, _] = copies.tick([swing(omega, time), Motion::REST]);
            if tick >= 15_000 {
                force.see(one.contact_force, omega * time);
                speed.see(one.object.velocity, omega * time);
            }
        }
        force.over(speed)
    };
    let omega = std::f64::consts::TAU * 2.0;
    // Both copies, and the contact of a hand that stands behind the coordination spring.
    let behind = Phasor { re: 3.0, im: MASS_KG * omega - 600.0 / omega };
    let link = Phasor { re: 5.0, im: -3000.0 / omega };
    let series = {
        let sum = Phasor { re: behind.re + link.re, im: behind.im + link.im };
        let product =
            Phasor { re: behind.re * link.re - behind.im * link.im, im: behind.re * link.im + behind.im * link.re };
        product.over(sum)
    };
    let wanted = Phasor { re: series.re, im: series.im + MASS_KG * omega };
    for delay in [0, 20, 100] {
        let got = felt(delay);
        assert!(got.off(wanted) < 0.15, "{delay} ms: {got:?}, {wanted:?}");
    }
}

/// Whatever comes, in whatever order: the account is never below nothing, what is taken from the network was sent, and a copy never gets more than was heard, was in
/// the account, and was done on it.
#[test]
fn nothing_comes_out_that_was_not_put_in() {
    for seed in 0..50_u64 {
        let mut random = draws(seed);
        let start = 0.02;
        let settings = scene(&[("model_mediated.rate_per_s", 100.0), ("model_mediated.memory_s", 0.05)]);
        let mut ends = Ends::new(&settings);
        let (mut heard, mut said) = (0.0, 0.0);
        for tick in 0..3000_u32 {
            // Motions and forces that no copy makes, and now and then energy.
            if random() > 0.0 {
                if random() > 0.4 {
                    said += 0.01 * (random() + 0.5);
                }
                let packet = Packet {
                    motion: Motion { position: 0.2 * random(), velocity: 4.0 * random() },
                    wave: 40.0 * random(),
                    energy_j: said,
                    live_ticks: if random() > -0.4 { tick } else { 7 },
                    ..Packet::default()
                };
                if tick > 0 {
                    heard = said;
                }
                ends.law.receive(&mut ends.states[0], packet);
            }
            ends.tick([[50.0, 1.0, 0.05 * random(), 20.0 * random()], [0.0; 4]]);
            let account = ends.states[0].account_j();
            assert!(account >= 0.0, "seed {seed}, tick {tick}: {account} J");
            // What the copy got by itself came from the account and from what was heard; what is still in model and spring counts for the law.
            let out = ends.to_copy_j[0] + ends.sent_j[0];
            assert!(out <= start + heard + 1e-9, "seed {seed}, tick {tick}: {out} J out, {heard} J heard");
        }
        assert!(heard > 0.3, "seed {seed}: {heard} J");
    }
}
