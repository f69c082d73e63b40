//! Laws that pay for their energy, one end at a time: numbers of their papers and closed forms.

use crate::setup::settings;
use cohold_core::contact::Side;
use cohold_core::law::{Coupled, Law, Observation, Packet};
use cohold_core::num::Motion;
use cohold_core::settings::{Settings, Value};
use cohold_laws::passive_spring::PassiveSpring;
use cohold_laws::set_position::SetPosition;
use cohold_laws::two_layer::TwoLayer;
use cohold_laws::wave_compensator::WaveCompensator;
use cohold_laws::wave_integral::WaveIntegral;

/// A law with its state, and a copy that moves on command.
struct End<L: Law<f64>> {
    law: L,
    state: L::State,
    position: f64,
    sent_j: f64,
    received_j: f64,
    /// ∫F_T·v dt, J.
    work_j: f64,
}

impl<L: Law<f64>> End<L> {
    fn new(settings: &Settings) -> Self {
        let law = L::build(settings).expect("good settings");
        let state = law.start(Motion::REST);
        Self { law, state, position: 0.0, sent_j: 0.0, received_j: 0.0, work_j: 0.0 }
    }

    fn hear(&mut self, position: f64, velocity: f64, energy_j: f64) {
        let motion = Motion { position, velocity };
        self.law.receive(&mut self.state, Packet { motion, energy_j, ..Packet::default() });
    }

    /// A tick of 1 ms in which the copy moves at this mean velocity.
    fn tick(&mut self, velocity: f64) -> Coupled<f64> {
        let local = Motion { position: self.position, velocity };
        let seen = Observation { local, ..Observation::default() };
        let coupled = self.law.couple(&mut self.state, &seen, |_| velocity);
        self.position += 1e-3 * velocity;
        self.sent_j += 1e-3 * coupled.power_out;
        self.received_j += 1e-3 * coupled.power_in;
        self.work_j += 1e-3 * coupled.force * velocity;
        coupled
    }
}

impl<L: Law<f64>> End<L> {
    fn ticks(&mut self, ticks: core::ops::Range<u32>, velocity: f64) {
        for _ in ticks {
            self.tick(velocity);
        }
    }
}

fn near(got: f64, wanted: f64, within: f64) {
    assert!((got - wanted).abs() <= within, "{got}, not {wanted}");
}

/// Lee & Huang: the first set position with E in the tank and the spring at rest is √(2E/K) away, and the force √(2EK); with
/// more to spend it is where it was wanted.
#[test]
fn the_first_set_position_is_what_the_tank_pays_for() {
    for (start_j, wanted_m) in [(0.02, 1.0), (0.005, -1.0), (0.0, 0.5), (1.0, 0.01)] {
        let settings = settings("set-position", &[("coordination.tank_j", start_j)]);
        let mut end = End::<SetPosition<f64>>::new(&settings);
        end.hear(wanted_m, 0.0, 0.0);
        let coupled = end.tick(0.0);
        let most = (2.0_f64 * start_j / 1000.0).sqrt();
        near(coupled.desired.position, wanted_m.clamp(-most, most), 1e-12);
        near(coupled.force, 1000.0 * wanted_m.clamp(-most, most), 1e-9);
    }
}

/// What the damper takes buys the next set position: B·v²·t of it, exactly; and what is more than the tank began with goes to the other.
#[test]
fn harvest_is_spent_or_sent() {
    let mut settings = settings("set-position", &[("coordination.tank_j", 0.01)]);
    settings.coordination.damping_n_s_per_m = 10.0;
    settings.coordination.stiffness_n_per_m = 0.0;
    let mut end = End::<SetPosition<f64>>::new(&settings);
    end.ticks(0..1000, 0.1);
    // The tank is full from the start: 10·0.1²·1 s goes out.
    near(end.sent_j, 0.1, 1e-12);
    near(end.work_j, -0.1, 1e-12);

    settings.coordination.stiffness_n_per_m = 1000.0;
    crate::SCHEMA.set(&mut settings, "coordination.tank_j", Value::Number(0.0)).expect("allowed");
    let mut other = End::<SetPosition<f64>>::new(&settings);
    other.hear(1.0, 0.0, 0.0);
    other.tick(0.0);
    // What the first sent is heard; a sum that comes again, or an older one, brings nothing.
    for heard in [0.05, 0.05, 0.02] {
        other.hear(1.0, 0.0, heard);
        near(other.tick(0.0).force, 10.0, 1e-9);
    }
    near(other.received_j, 0.05, 1e-15);
}

/// Ryu et al.: a port that emits exactly what the other is known to have absorbed. A step of the other copy by d costs K·(d/2)²;
/// with W below that the middle goes √(W/K) and the force is 2√(WK).
#[test]
fn the_controller_lets_through_what_was_absorbed_and_no_more() {
    let mut settings = settings("passive-spring", &[("coordination.tank_j", 0.0)]);
    settings.coordination.damping_n_s_per_m = 0.0;
    let mut end = End::<PassiveSpring<f64>>::new(&settings);
    end.hear(0.01, 0.0, 0.0);
    assert_eq!(end.tick(0.0).force, 0.0);
    for heard in [0.001, 0.004, 0.02] {
        end.hear(0.01, 0.0, heard);
        let wanted = (2.0 * (heard * 1000.0_f64).sqrt()).min(1000.0 * 0.01);
        near(end.tick(0.0).force, wanted, 1e-9);
    }
    // The copy goes to where the other is: the spring gives back what was put in, to the copy or to the other end.
    end.ticks(0..1000, 0.01);
    let left = end.tick(0.0);
    near(left.force, 0.0, 1e-6);
    near(end.work_j + end.sent_j, 0.02, 1e-9);
}

/// Of two ends without delay, one moved and one held, what the one emits the other absorbs: nothing is held back, and the force is that
/// of the power-domain spring at every tick, with nothing in the tanks but what a tick's own delay costs.
#[test]
fn without_delay_nothing_is_held_back() {
    let mut settings = settings("passive-spring", &[("coordination.tank_j", 1e-4)]);
    settings.coordination.damping_n_s_per_m = 0.0;
    let mut ends = [(); 2].map(|()| End::<PassiveSpring<f64>>::new(&settings));
    for tick in 0..5000 {
        let said = [&ends[0], &ends[1]].map(|end| (end.position, end.sent_j));
        for (at, velocity) in [0.02 * (3e-3 * f64::from(tick)).cos(), 0.0].into_iter().enumerate() {
            let (position, sent_j) = said[1 - at];
            ends[at].hear(position, 0.0, sent_j);
            // Through the tick the middle stands, and half of the spring gives way.
            let wanted = 1000.0 * (position - ends[at].position) - 1.0 * velocity;
            near(ends[at].tick(velocity).force, wanted, 1e-6);
        }
    }
}

/// Franken et al.: energy transfer levels the tanks, H₁ = H₂ = E/(2 + 2βd) with d ticks each way and nobody who moves.
#[test]
fn two_tanks_level_out() {
    for (share, delay) in [(0.01, 1), (0.01, 20), (0.05, 50)] {
        let own = [("coordination.tank_j", 0.02), ("coordination.tank_share", share)];
        let settings = settings("two-layer", &own);
        let mut ends = [(); 2].map(|()| End::<TwoLayer<f64>>::new(&settings));
        let mut sums = vec![[0.0; 2]];
        for tick in 0..20_000_usize {
            let heard = tick.checked_sub(delay - 1).map_or([0.0; 2], |at| sums[at]);
            let mut out = [0.0; 2];
            for at in 0..2 {
                ends[at].hear(0.0, 0.0, heard[1 - at]);
                out[at] = 1e-3 * ends[at].tick(0.0).power_out;
            }
            let last = sums[tick];
            sums.push([last[0] + out[0], last[1] + out[1]]);
        }
        // A quantum is taken from what is there when the tick begins.
        let level = 0.04 / (2.0 + 2.0 * share * delay as f64);
        for end in &mut ends {
            let quantum = 1e-3 * end.tick(0.0).power_out;
            near(quantum / share, level, 0.05 * level);
        }
    }
}

/// The tank bounds the force whatever the copy does: the worst velocity, f/2z, empties it to nothing and no further.
#[test]
fn the_worst_velocity_empties_the_tank_exactly() {
    let own = [("coordination.tank_j", 0.001), ("coordination.tank_share", 0.0), ("coordination.tank_level_j", 0.0)];
    let settings = settings("two-layer", &own);
    let (stiffness, damping) = (1000.0, 2.0);
    let impedance = stiffness * 5e-4 + damping;
    let mut end = End::<TwoLayer<f64>>::new(&settings);
    end.hear(1.0, 0.0, 0.0);
    let most = (4.0_f64 * impedance * 0.001 / 1e-3).sqrt();
    end.tick(most / (2.0 * impedance));
    near(end.work_j, 0.001, 1e-15);
    // Nothing is left to push with; a copy that is moved against it is damped, which fills the tank.
    end.hear(1.0, 0.0, 0.0);
    near(end.tick(0.0).force, 0.0, 1e-6);
    near(end.tick(-0.1).force, 0.1 * impedance, 1e-6);
    assert!(end.tick(0.0).force > 0.1);
}

/// Level controller: an empty tank makes the copy drag α·H_d.
#[test]
fn an_empty_tank_is_filled_by_whoever_moves() {
    let own = [
        ("coordination.tank_j", 0.0),
        ("coordination.tank_share", 0.0),
        ("coordination.tank_level_j", 0.05),
        ("coordination.tank_damping_n_s_per_m_j", 100.0),
    ];
    let mut settings = settings("two-layer", &own);
    settings.coordination.stiffness_n_per_m = 0.0;
    settings.coordination.damping_n_s_per_m = 0.0;
    let mut end = End::<TwoLayer<f64>>::new(&settings);
    near(end.tick(0.1).force, -0.5, 1e-9);
    // dH/dt = α·(H_d − H)·v², so H = H_d·(1 − e^(−αv²t)) and the drag dies with it.
    end.ticks(1..1000, 0.1);
    near(end.tick(0.1).force, -0.5 * (-1.0_f64).exp(), 0.001);
}

/// An end of a line whose copy follows the line: no spring force, all that comes in is taken up.
fn line(own: &[(&str, f64)], ticks_per_packet: u32) -> End<WaveIntegral<f64>> {
    let mut settings = settings("wave-integral", own);
    settings.timing.ticks_per_packet = ticks_per_packet;
    End::new(&settings)
}

fn heard(end: &mut End<WaveIntegral<f64>>, live_ticks: u32, wave_integral: f64, energy_j: f64) {
    end.law.receive(&mut end.state, Packet { wave_integral, energy_j, live_ticks, ..Packet::default() });
}

/// u_in of a tick, √W, as far as its power tells.
fn taken(end: &mut End<WaveIntegral<f64>>) -> f64 {
    (2.0 * end.tick(0.0).power_in).sqrt()
}

/// Waves that come one after the other come out as they are, for as many ticks as they were; after that nothing does.
#[test]
fn a_wave_that_comes_in_time_comes_out_as_it_is() {
    let mut end = line(&[], 4);
    end.ticks(0..4, 0.0);
    let (mut integral, mut energy) = (0.0, 0.0);
    for (sent, sample) in (1..).zip([1.0, 0.5, 0.25, 2.0, 0.0, 1.5]) {
        integral += 4e-3 * sample;
        energy += 2e-3 * sample * sample;
        heard(&mut end, 4 * sent, integral, energy);
        (0..4).for_each(|_| near(taken(&mut end), sample, 1e-9));
    }
    (0..20).for_each(|_| near(taken(&mut end), 0.0, 1e-6));
}

/// Niemeyer & Slotine: what is owed with W to pay for it comes out at 2W/ε for ε²/2W, and then there is nothing left of either.
#[test]
fn a_debt_and_its_energy_end_together() {
    let mut end = line(&[], 1);
    end.tick(0.0);
    // 0.1 √W·s and 0.01 J: 0.2 √W for half a second.
    heard(&mut end, 1, 0.1, 0.01);
    for tick in 0..490 {
        let got = taken(&mut end);
        // The packet's own mean is 100 √W, which nothing pays for.
        assert!((got - 0.2).abs() < 1e-6, "tick {tick}: {got}");
    }
    // The last 0.2/λ of it dies away, which costs half.
    end.ticks(0..100, 0.0);
    near(taken(&mut end), 0.0, 1e-6);
    near(end.received_j, 0.01 - 0.25 * 0.2 * 0.2 * 4e-3, 2e-5);
}

/// With energy to spare the debt dies away as e^(−λt), λ = 1/(4·T_n).
#[test]
fn a_debt_that_is_paid_for_dies_away_in_four_packets() {
    let mut end = line(&[], 8);
    end.ticks(0..16, 0.0);
    // Nothing in the first packet, so that what the second brings is its own; half of it is of the packet that was lost between.
    heard(&mut end, 8, 0.0, 0.0);
    end.ticks(0..8, 0.0);
    heard(&mut end, 24, 2e-3, 0.01);
    end.ticks(0..8, 0.0);
    let first = taken(&mut end);
    near(first, 1e-3 / 0.032 * (1.0_f64 - 1.0 / 32.0).powi(8), 1e-9);
    end.ticks(1..32, 0.0);
    let later = taken(&mut end);
    near(later / first, (-1.0_f64).exp(), 0.02);
}

/// What was lost on the way comes with the next packet: of every third only, all of the integral comes out.
#[test]
fn what_is_lost_comes_later() {
    let mut end = line(&[], 1);
    let (mut integral, mut energy, mut out) = (0.0, 0.0, 0.0);
    end.tick(0.0);
    for tick in 0..3000_u32 {
        let sample = 0.5 * (1.0 + (0.01 * f64::from(tick)).sin());
        integral += 1e-3 * sample;
        energy += 0.5e-3 * sample * sample;
        if tick % 3 == 0 {
            heard(&mut end, tick + 1, integral, energy);
        }
        out += 1e-3 * taken(&mut end);
        assert!(end.received_j <= energy * (1.0 + 1e-12), "tick {tick}");
    }
    heard(&mut end, 3001, integral, energy);
    for _ in 0..2000 {
        out += 1e-3 * taken(&mut end);
    }
    near(out, integral, 1e-6);
}

/// Ye & Liu: the reflected force of an end that is held is −F_r with a bias of b·ẋ_r, which the master's end takes out as e^(−λt); the
/// other end leaves it.
#[test]
fn the_bias_of_the_reflected_force_dies_away_at_the_master() {
    let mut settings = settings("wave-compensator", &[("coordination.compensator_hz", 2.0)]);
    settings.coordination.stiffness_n_per_m = 1e6;
    settings.coordination.damping_n_s_per_m = 0.0;
    let (impedance, speed, pushed) = (10.0_f64, 0.1, 2.0);
    let wave = (impedance * speed + pushed) / (2.0 * impedance).sqrt();
    for (side, left) in [(Side::Left, true), (Side::Right, false)] {
        settings.contact.side = side;
        let mut end = End::<WaveCompensator<f64>>::new(&settings);
        let rate = core::f64::consts::TAU * 2.0;
        for tick in 0..1000 {
            let motion = Motion { position: 0.0, velocity: speed };
            let energy_j = 1e-3 * f64::from(tick);
            end.law.receive(&mut end.state, Packet { motion, wave, energy_j, ..Packet::default() });
            let coupled = end.tick(0.0);
            let bias = impedance * speed * if left { (-rate * 1e-3 * f64::from(tick)).exp() } else { 1.0 };
            // The spring takes the first few ticks.
            if tick > 50 {
                near(coupled.force, pushed + bias, 0.02);
            }
        }
    }
}

/// A wave that is not paid for does not come out; what comes out is what was heard, to the joule.
#[test]
fn a_compensated_wave_is_paid_for() {
    let settings = settings("wave-compensator", &[]);
    let mut end = End::<WaveCompensator<f64>>::new(&settings);
    for (heard, out) in [(0.0, 0.0), (1e-3, 1e-3), (1e-3, 1e-3), (0.5e-3, 1e-3), (3e-3, 3e-3)] {
        end.law.receive(&mut end.state, Packet { wave: 100.0, energy_j: heard, ..Packet::default() });
        end.tick(0.0);
        near(end.received_j, out, 1e-12);
    }
}

/// After a long session a small wave does not show in the sum of energies: it comes out all the same, from what averaging has saved.
#[test]
fn a_wave_that_is_too_small_for_the_counter_is_not_lost() {
    let mut end = line(&[], 1);
    end.tick(0.0);
    heard(&mut end, 1, 0.0, 1e6);
    let mut integral = 0.0;
    for tick in 2..100 {
        integral += 1e-3 * 1e-6;
        heard(&mut end, tick, integral, 1e6);
        near(taken(&mut end), 1e-6, 1e-12);
    }
}

/// What was sent before the first packet came is not lost, of an end that began no earlier; of one that did, its past stays its own.
#[test]
fn the_first_packet_brings_what_was_sent_since_both_began() {
    for (live_ticks, brought) in [(30, 0.02), (31, 0.0)] {
        let mut end = line(&[], 4);
        end.ticks(0..30, 0.0);
        heard(&mut end, live_ticks, 0.02, 0.05);
        let out: f64 = (0..500).map(|_| 1e-3 * taken(&mut end)).sum();
        near(out, brought, 1e-6);
    }
}
