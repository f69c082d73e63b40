//! The measurements behind [`super::NUMBERS`]: runs of pairs, and single ends of laws whose other end is prescribed.
//!
//! Errors: every function fails where its scene or its law cannot be built, run or judged.

use cohold_analysis::tune::CONTACT;
use cohold_analysis::{Effort, Hands, Range, limit};
use cohold_core::law::{Coupled, Law, Observation, Packet};
use cohold_core::names::Side;
use cohold_core::num::Motion;
use cohold_core::object::Port;
use cohold_core::settings::Settings;
use cohold_laws::model_mediated::ModelMediated;
use cohold_laws::{EveryLaw, EveryLawState};
use cohold_sim::measure::apparent_mass;
use cohold_sim::measure::impedance::{RemoteEnd, felt};
use cohold_sim::pair::Pair;
use cohold_sim::run::{Options, run};
use cohold_sim::scene::Scene;
use cohold_sim::user::{Trace, User};

use cohold_studies::Error;
use cohold_studies::campaign::laws::{asked_for, law_scene};
use cohold_studies::reproduce::paper::{self, DURATION_S};

/// m_O of the bench, kg.
pub(crate) const MASS_KG: f64 = 0.3;

/// b of the bench, N·s/m.
pub(crate) const IMPEDANCE: f64 = 10.0;

/// Transit time of a line of means with packets of 8 ms, one of them under way, s: both ends average over a packet, and the sample is one tick old.
pub(crate) const LINE_S: f64 = 0.016;

/// Mean age of a position with packets of 8 ms, one of them under way: on the way, then held for a packet, s.
pub(crate) const POSITIONS_S: f64 = 0.012;

/// What laws with a tank begin with, J.
pub(crate) const TANK_J: f64 = 0.02;

/// Control period of the bench, s.
const PERIOD_S: f64 = 1e-3;

/// A packet a tick.
const EACH_TICK: &str = "timing.ticks_per_packet=1";

/// The scene in which the bench tries a law, at the gains that it declares, then with these settings.
pub(crate) fn scene(law: &str, set: &[&str]) -> Result<Scene, Error> {
    let laws = cohold_guest_laws::laws();
    let law = asked_for(laws, law)?[0];
    let set: Vec<String> = set.iter().map(|text| (*text).to_owned()).collect();
    law_scene(laws, law, None, &set)
}

/// Decoded discrepancy in the cooperation paper's §5.2, mm.
pub(crate) fn discrepancy_mm(law: &str) -> Result<f64, Error> {
    let outcome = paper::run_at(law, 1.0)?;
    Ok(outcome.metric(|outcome| outcome.whole.decoded_discrepancy_mm).unwrap_or(f64::NAN))
}

/// Where this model turns unstable, nearest to the gain of the paper's §5.1, N/m.
pub(crate) fn boundary_n_per_m(law: &str, near_n_per_m: f64) -> Result<f64, Error> {
    paper::boundary_n_per_m(law, near_n_per_m)
}

/// Apparent mass of the shared object, kg.
pub(crate) fn mass_kg(law: &str) -> Result<f64, Error> {
    Ok(apparent_mass::measure(&scene(law, &[])?)?)
}

/// 2F/K_T + F·T/b of 1 N, with the T that the line's own mass shows, mm.
pub(crate) fn distance_by_its_mass_mm(law: &str) -> Result<f64, Error> {
    let stiffness = scene(law, &[])?.peer.coordination.stiffness_n_per_m;
    let line_s = (mass_kg(law)? - 2.0 * MASS_KG) / IMPEDANCE;
    Ok(1e3 * (2.0 / stiffness + line_s / IMPEDANCE))
}

/// How far apart the copies stand in the end whose users push 1 N against each other, mm, if no line is taut.
pub(crate) fn distance_mm(law: &str) -> Result<f64, Error> {
    let scene = scene(law, &["user.2.sine_n=0", "coordination.tautness=0"])?;
    let outcome = run::<f64>(&scene, Options::unrecorded(DURATION_S), &|_| {})?;
    Ok(outcome.metric(|outcome| outcome.whole.true_discrepancy_mm).unwrap_or(f64::NAN))
}

/// Static stiffness that a slow hand feels while the far one holds its device, without delay, N/m.
pub(crate) fn stiffness_felt_n_per_m(set: &[&str]) -> Result<f64, Error> {
    const SLOW_HZ: f64 = 0.5;
    let scene = scene("four-channel", &[set, &[EACH_TICK, "network.one_way_delay_packets=0"]].concat())?;
    let impedance = felt(&scene, RemoteEnd::Held, SLOW_HZ, 0.05)?;
    Ok(impedance.map_or(f64::NAN, |z| -z.im * core::f64::consts::TAU * SLOW_HZ))
}

/// ω² of two copies that swing against each other in the power-domain law, over that at their mean.
pub(crate) fn gain_of_the_others_over_the_mean() -> Result<f64, Error> {
    let squared = |law: &str| -> Result<f64, Error> {
        let set = [
            EACH_TICK,
            "network.one_way_delay_packets=0",
            "coordination.stiffness_n_per_m=100",
            "coordination.damping_n_s_per_m=0",
            "contact.stiffness_n_per_m=0.1",
            "contact.damping_n_s_per_m=0",
        ];
        let mut pair = Pair::<f64>::new(&kicked(&scene(law, &set)?.linear()))?;
        let mut rises = Vec::new();
        let mut before = 0.0;
        for tick in 0..20_000_u32 {
            pair.step();
            let [one, other] = pair.sides().map(|side| side.peer.observed()[0].object.position);
            let apart = one - other;
            if before < 0.0 && apart >= 0.0 {
                rises.push(f64::from(tick) - apart / (apart - before));
            }
            before = apart;
        }
        let periods = rises.len().saturating_sub(1) as f64;
        let ticks = rises.last().copied().unwrap_or(f64::NAN) - rises.first().copied().unwrap_or(f64::NAN);
        Ok((core::f64::consts::TAU * periods / (PERIOD_S * ticks)).powi(2))
    };
    Ok(squared("power")? / squared("average-position")?)
}

/// What holds each of two copies that go on together under a common push, over their speed, N·s/m: mean of the last packet.
pub(crate) fn drag_of_a_common_push() -> Result<f64, Error> {
    const STEADY_TICKS: u32 = 4000;
    let mut alike = scene("p-plus-d", &[])?.linear();
    // What is positive pushes toward the other one.
    for (user, push_n) in alike.users.iter_mut().zip([1e-3, -1e-3]) {
        *user = User::default();
        user.settings.user.push_n = push_n;
    }
    let mut pair = Pair::<f64>::new(&alike)?;
    (0..STEADY_TICKS).for_each(|_| pair.step());
    let (mut force, mut speed) = (0.0, 0.0);
    for _ in 0..alike.peer.timing.ticks_per_packet {
        pair.step();
        let [seen, _] = pair.sides().map(|side| *side.peer.observed()[0]);
        (force, speed) = (force - seen.coordination_force, speed + seen.object.velocity);
    }
    Ok(force / speed)
}

/// Two users who kick a linear scene at its beginning, against each other, far below every limit.
fn kicked(linear: &Scene) -> Scene {
    const KICK_N: f64 = 1e-3;
    const KICK_S: f64 = 0.05;
    let mut kicked = linear.clone();
    for user in &mut kicked.users {
        *user = User { trace: Some(Trace::step(KICK_S, -KICK_N)), ..User::default() };
        user.settings.user.push_n = KICK_N;
    }
    kicked
}

/// b/(K·T) at the first unstable stiffness of a wall that does not move, forces acting `late` ticks late.
pub(crate) fn wall(late: f64) -> Result<f64, Error> {
    const DAMPING: f64 = 5.0;
    let late = format!("device.force_delay_ticks={late}");
    let set =
        ["device.mass_kg=1", "device.damping_n_s_per_m=5", "object.mass_kg=1000", "contact.damping_n_s_per_m=0", &late];
    let range = Range { key: CONTACT.to_owned(), from: 1.0, to: 20_000.0 };
    let found = limit(&scene("none", &set)?, range, Effort { hands: Some(Hands::Both), ..Effort::default() })?;
    Ok(DAMPING / (PERIOD_S * found.crossings.first().copied().unwrap_or(f64::NAN)))
}

/// One end of a law whose copy and other end are prescribed.
struct End {
    law: EveryLaw<f64>,
    state: EveryLawState<f64>,
}

impl End {
    fn new(law: &str, set: &[&str]) -> Result<Self, Error> {
        Self::at(Side::Left, law, set)
    }

    fn at(side: Side, law: &str, set: &[&str]) -> Result<Self, Error> {
        let mut settings: Settings = scene(law, &[&[EACH_TICK], set].concat())?.peer;
        settings.contact.side = side;
        let law = <EveryLaw<f64> as Law<f64>>::build(&settings)?;
        Ok(Self { law, state: law.start(Motion::REST) })
    }

    fn hear(&mut self, position: f64, velocity: f64, wave: f64, energy_j: f64) {
        let motion = Motion { position, velocity };
        self.law.receive(&mut self.state, Packet { motion, wave, energy_j, ..Packet::default() });
    }

    /// A tick in which the copy stays where it began.
    fn held(&mut self, age_ticks: u32) -> Coupled<f64> {
        let seen = Observation { age_ticks, ..Observation::default() };
        self.law.couple(&mut self.state, &seen, |_| 0.0)
    }
}

/// First step of the set position modulation, with its tank as it begins and the other copy 1 m away, mm.
pub(crate) fn first_set_position_mm() -> Result<f64, Error> {
    let mut end = End::new("set-position", &[])?;
    end.hear(1.0, 0.0, 0.0, 0.0);
    Ok(1e3 * end.held(0).desired.position)
}

/// Force of an end with an empty tank that has heard of 4 mJ, the other copy 1 m away, N.
pub(crate) fn force_of_what_was_absorbed_n() -> Result<f64, Error> {
    let mut end = End::new("passive-spring", &["coordination.tank_j=0", "coordination.damping_n_s_per_m=0"])?;
    end.hear(1.0, 0.0, 0.0, 0.0);
    end.held(0);
    end.hear(1.0, 0.0, 0.0, 4e-3);
    Ok(end.held(0).force)
}

/// What a spring keeps that is led away from its far end by 20 mm and back, of the ½K·X² that it took.
pub(crate) fn kept_of_a_way_there_and_back() -> Result<f64, Error> {
    const TICKS: u32 = 2000;
    const SPEED: f64 = 0.01;
    let set = ["coordination.stiffness_n_per_m=400", "coordination.damping_n_s_per_m=0"];
    let mut end = End::new("fractal-impedance", &set)?;
    let (mut position, mut kept_j) = (0.0, 0.0);
    for velocity in [SPEED, -SPEED] {
        for _ in 0..TICKS {
            let seen = Observation { local: Motion { position, velocity }, ..Observation::default() };
            let coupled = end.law.couple(&mut end.state, &seen, |_| velocity);
            position += PERIOD_S * velocity;
            kept_j -= PERIOD_S * velocity * coupled.force;
        }
    }
    let most_m = PERIOD_S * SPEED * f64::from(TICKS);
    Ok(kept_j / (0.5 * 400.0 * most_m * most_m))
}

/// Where two tanks of 20 mJ come to rest that share 1 % a tick over 20 ticks each way, mJ.
pub(crate) fn tank_level_mj() -> Result<f64, Error> {
    const TICKS: usize = 20_000;
    const DELAY: usize = 20;
    let share = "coordination.tank_share=0.01";
    let mut ends = [End::new("two-layer", &[share])?, End::new("two-layer", &[share])?];
    let mut sums = vec![[0.0; 2]];
    let mut quantum_j = 0.0;
    for tick in 0..TICKS {
        let heard = tick.checked_sub(DELAY - 1).map_or([0.0; 2], |at| sums[at]);
        let mut next = sums[tick];
        for (at, end) in ends.iter_mut().enumerate() {
            end.hear(0.0, 0.0, 0.0, heard[1 - at]);
            quantum_j = PERIOD_S * end.held(0).power_out;
            next[at] += quantum_j;
        }
        sums.push(next);
    }
    Ok(1e3 * quantum_j / 0.01)
}

/// What is left of the bias of the reflected force after the compensator's 1/λ, of the bias b·ẋ_r.
pub(crate) fn bias_left() -> Result<f64, Error> {
    const SPEED: f64 = 0.1;
    const PUSHED_N: f64 = 2.0;
    let set =
        ["coordination.stiffness_n_per_m=1000000", "coordination.damping_n_s_per_m=0", "coordination.compensator_hz=2"];
    let mut end = End::new("wave-compensator", &set)?;
    let wave = (IMPEDANCE * SPEED + PUSHED_N) / (2.0 * IMPEDANCE).sqrt();
    let ticks = (1.0 / (core::f64::consts::TAU * 2.0) / PERIOD_S).round() as u32;
    let mut force = 0.0;
    for tick in 0..=ticks {
        end.hear(0.0, SPEED, wave, 1e-3 * f64::from(tick));
        force = end.held(0).force;
    }
    Ok((force - PUSHED_N) / (IMPEDANCE * SPEED))
}

/// Packets while the speed grows from 0.1 to 1 m/s by 0.1 mm/s a tick.
pub(crate) fn packets_of_a_ramp() -> Result<f64, Error> {
    let mut end = End::new("deadband", &["deadband.weber=0.1", "deadband.least_m_per_s=0.001"])?;
    let mut packets = 0.0;
    for tick in 1000..10_000 {
        let motion = Motion { position: 0.0, velocity: 1e-4 * f64::from(tick) };
        let packet = Packet { motion, ..Packet::default() };
        if end.law.speaks(&end.state, &packet) {
            end.law.spoke(&mut end.state, &packet);
            packets += 1.0;
        }
    }
    Ok(packets)
}

/// Packets saved of 1000 a second, by a pair of which one hand goes to and fro by 5 cm once a second, %.
pub(crate) fn packets_saved_percent() -> Result<f64, Error> {
    let set = [
        EACH_TICK,
        "network.one_way_delay_packets=0",
        "user.1.push_n=0",
        "user.2.push_n=0",
        "user.2.sine_n=0",
        "user.1.sine_n=4",
        "user.1.sine_rad_per_s=6.2832",
    ];
    let mut pair = Pair::<f64>::new(&scene("deadband", &set)?)?;
    (0..20_000).for_each(|_| pair.step());
    Ok(100.0 * (1.0 - PERIOD_S * pair.packets_per_s()))
}

/// ẋ_d/ẋ* under a force that pulls forward.
pub(crate) fn velocity_held() -> Result<f64, Error> {
    let mut end = End::new("passive-deadband", &["coordination.tank_j=1", "deadband.weber=0.1"])?;
    end.hear(0.01, 0.2, 0.0, 0.0);
    let velocity = (0..10).fold(0.0, |_, tick| end.held(tick).desired.velocity);
    Ok(velocity / 0.2)
}

/// Force on a copy that is held, with 0.4 mJ in the account and 100 N asked for, N.
pub(crate) fn gated_force_n() -> Result<f64, Error> {
    let set = ["coordination.stiffness_n_per_m=1000", "coordination.damping_n_s_per_m=2", "coordination.tank_j=0.0004"];
    let mut end = End::new("passivity-observer", &set)?;
    end.hear(0.1, 0.0, 0.0, 0.0);
    Ok(end.held(0).force)
}

/// What the model at the end of a hand that shakes has become after 6 s: its k̂, where the other copy hangs on 600 N/m and 3 N·s/m, N/m.
pub(crate) fn stiffness_learned_n_per_m() -> Result<f64, Error> {
    let settings =
        scene("model-mediated", &["coordination.stiffness_n_per_m=3000", "coordination.damping_n_s_per_m=5"])?.peer;
    let law = <ModelMediated<f64> as Law<f64>>::build(&settings)?;
    let mut states = [Motion::REST; 2].map(|rest| Law::<f64>::start(&law, rest));
    let (mut copies, mut sent_j) = ([Motion::REST; 2], [0.0; 2]);
    let inertia = 2.0 * MASS_KG / PERIOD_S;
    for tick in 0..6000_u32 {
        if tick.is_multiple_of(settings.timing.ticks_per_packet) {
            let packets = [0, 1].map(|at: usize| Packet { energy_j: sent_j[at], ..law.send(&states[at], copies[at]) });
            law.receive(&mut states[0], packets[1]);
            law.receive(&mut states[1], packets[0]);
        }
        let time_s = PERIOD_S * f64::from(tick);
        let shake = 2.0 * (9.0 * time_s).sin() + 1.5 * (23.0 * time_s).sin() + (47.0 * time_s).sin();
        let hands = [
            Port { force: shake, impedance: 1.0 },
            Port { force: -600.0 * copies[1].position, impedance: 600.0 * PERIOD_S / 2.0 + 3.0 },
        ];
        for (at, hand) in hands.into_iter().enumerate() {
            let copy = copies[at];
            let mut mean = 0.0;
            let seen = Observation { local: copy, ..Observation::default() };
            let coupled = law.couple(&mut states[at], &seen, |port: Port<f64>| {
                let all = port + hand;
                mean = (inertia * copy.velocity + all.force) / (inertia + all.impedance);
                mean
            });
            copies[at] = Motion { position: copy.position + PERIOD_S * mean, velocity: 2.0 * mean - copy.velocity };
            sent_j[at] += PERIOD_S * coupled.power_out;
        }
    }
    Ok(states[0].model().stiffness)
}
