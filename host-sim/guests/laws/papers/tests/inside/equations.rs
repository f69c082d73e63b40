//! The equations of the laws' papers at the values of the bench, and what the laws do there. Most of these papers have no public text: a row
//! shows that a law follows its equation, and no author has measured it.

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
use cohold_studies::reproduce::paper::DURATION_S;

use super::super::measure::{EACH_TICK, PERIOD_S, scene, wall};

/// Law, source and quantity; what the equation gives; what the law does.
type Row = (&'static str, &'static str, fn() -> f64, fn() -> Result<f64, Error>);

#[rustfmt::skip]
pub(super) const EQUATIONS: &[Row] = &[
    ("passive-mean", "Niemeyer & Slotine 1991, a line's inertia b·T: mass of both copies and a line of 16 ms", || 2.0 * MASS_KG + IMPEDANCE * LINE_S, || mass_kg("passive-mean")),
    ("self-timed", "docs/reference/theory.md, section 8, a line of constant delay in its own time: apart under 1 N: 2F/K_T + F·T/b, T = (mass − 2m_O)/b", || distance_by_its_mass_mm("self-timed").unwrap_or(f64::NAN), || distance_mm("self-timed")),
    ("set-position", "Lee & Huang 2010, ΔP ≤ E of the set position: first set position with E = 20 mJ: √(2E/K)", || 1e3 * (2.0 * TANK_J / 1000.0_f64).sqrt(), first_set_position_mm),
    ("passive-spring", "docs/reference/theory.md, section 12, ΔV ≤ W of the spring's middle: force when 4 mJ are known to be absorbed: 2√(W·K)", || 2.0 * (4e-3 * 1000.0_f64).sqrt(), force_of_what_was_absorbed_n),
    ("two-layer", "Franken et al. 2011, simple energy transfer protocol, share β: level of two tanks and the line, 20 ticks each way: E/(2 + 2βd)", || 40.0 / (2.0 + 2.0 * 0.01 * 20.0), tank_level_mj),
    ("wave-integral", "Niemeyer & Slotine 2004, a line's stiffness b/T: apart under 1 N: 2F/K_T + F·T/b, a line of 16 ms", || 1e3 * (2.0 / 1e4 + LINE_S / IMPEDANCE), || distance_mm("wave-integral")),
    ("wave-compensator", "Ye & Liu 2009, bias b·(ẋ_r − ẋ_d), low-passed at λ: bias of the force left after 1/λ, of b·ẋ_r", || (-1.0_f64).exp(), bias_left),
    ("four-channel", "Lawrence 1993, transparency-optimised: Z_t = Z_e: stiffness felt of the far hand's contact, without delay", || 500.0, || stiffness_felt_n_per_m(&["four_channel.remote_force=1"])),
    ("p-plus-d", "Lee & Spong 2006, dissipation K_d ≥ K_p·T, in motion: drag of each of two who push alike, by positions 12 ms old: B + K·T", || 30.0 + 310.0 * POSITIONS_S, drag_of_a_common_push),
    ("average-position", "Rakhsha & Constantinescu, Average-Position Coordination, effective gain K_T instead of N·K_T: ω² of the copies' swing, power-domain over average, N = 2", || 2.0, gain_of_the_others_over_the_mean),
    ("remote-dynamic-proxy", "Li & Constantinescu 2010, proxy K_p behind the coupling K_T: apart under 1 N: F/K_T + F/K_p", || 1e3 * (1.0 / 1590.0 + 1.0 / 310.0), || distance_mm("remote-dynamic-proxy")),
    ("fractal-impedance", "Tiseo et al. 2020, arXiv 2011.00390, eq. 1, divergence and convergence: what a way there and back keeps, of ½K·X²", || 1.0, kept_of_a_way_there_and_back),
    ("deadband", "Hirche, Hinterseer, Steinbach & Buss 2007, Weber's law, threshold k·|ẋ|: packets for a speed that grows tenfold, k = 0.1: ln 10/ln 1.1", || 10.0_f64.ln() / 1.1_f64.ln(), packets_of_a_ramp),
    ("passive-deadband", "Hirche, Hinterseer, Steinbach & Buss 2007, modified hold, ẋ* − Δ·sign(F): velocity that is held over the one that was sent, k = 0.1", || 0.9, velocity_held),
    ("passivity-observer", "Hannaford & Ryu 2002, observer and controller of one port: largest force with 0.4 mJ observed: √(4κW/T_c)", || (4.0 * 2.5 * 4e-4 / 1e-3_f64).sqrt(), gated_force_n),
    ("model-mediated", "Mitra & Niemeyer 2008, the model becomes the environment: stiffness learned of a hand of 600 N/m", || 600.0, stiffness_learned_n_per_m),
    ("none", "Gil, Sánchez, Hulin, Preusche & Hirzinger 2009, K < b/(T/2 + t_d): b/(K·T) with a tick of computing", || 1.5, || wall(1.0)),
];

#[test]
fn each_law_follows_its_equation() {
    for (law, what, equation, measured) in EQUATIONS {
        let [wanted, found] = [equation(), measured().expect("a measurement")];
        assert!((found / wanted - 1.0).abs() <= super::WITHIN, "{law}, {what}: {found}, and {wanted} by the equation");
    }
}

/// m_O of the bench, kg.
const MASS_KG: f64 = 0.3;

/// b of the bench, N·s/m.
const IMPEDANCE: f64 = 10.0;

/// Transit time of a line of means with packets of 8 ms, one of them under way, s: both ends average over a packet, and the sample is one tick old.
const LINE_S: f64 = 0.016;

/// Mean age of a position with packets of 8 ms, one of them under way: on the way, then held for a packet, s.
const POSITIONS_S: f64 = 0.012;

/// What laws with a tank begin with, J.
const TANK_J: f64 = 0.02;

/// Apparent mass of the shared object, kg.
fn mass_kg(law: &str) -> Result<f64, Error> {
    Ok(apparent_mass::measure(&scene(law, &[])?)?)
}

/// 2F/K_T + F·T/b of 1 N, with the T that the line's own mass shows, mm.
fn distance_by_its_mass_mm(law: &str) -> Result<f64, Error> {
    let stiffness = scene(law, &[])?.peer.coordination.stiffness_n_per_m;
    let line_s = (mass_kg(law)? - 2.0 * MASS_KG) / IMPEDANCE;
    Ok(1e3 * (2.0 / stiffness + line_s / IMPEDANCE))
}

/// How far apart the copies stand in the end whose users push 1 N against each other, mm, if no line is taut.
fn distance_mm(law: &str) -> Result<f64, Error> {
    let scene = scene(law, &["user.2.sine_n=0", "coordination.tautness=0"])?;
    let outcome = run::<f64>(&scene, Options::unrecorded(DURATION_S), &|_| {})?;
    Ok(outcome.metric(|outcome| outcome.whole.true_discrepancy_mm).unwrap_or(f64::NAN))
}

/// Static stiffness that a slow hand feels while the far one holds its device, without delay, N/m.
fn stiffness_felt_n_per_m(set: &[&str]) -> Result<f64, Error> {
    const SLOW_HZ: f64 = 0.5;
    let scene = scene("four-channel", &[set, &[EACH_TICK, "network.one_way_delay_packets=0"]].concat())?;
    let impedance = felt(&scene, RemoteEnd::Held, SLOW_HZ, 0.05)?;
    Ok(impedance.map_or(f64::NAN, |z| -z.im * core::f64::consts::TAU * SLOW_HZ))
}

/// ω² of two copies that swing against each other in the power-domain law, over that at their mean.
fn gain_of_the_others_over_the_mean() -> Result<f64, Error> {
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
fn drag_of_a_common_push() -> Result<f64, Error> {
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
fn first_set_position_mm() -> Result<f64, Error> {
    let mut end = End::new("set-position", &[])?;
    end.hear(1.0, 0.0, 0.0, 0.0);
    Ok(1e3 * end.held(0).desired.position)
}

/// Force of an end with an empty tank that has heard of 4 mJ, the other copy 1 m away, N.
fn force_of_what_was_absorbed_n() -> Result<f64, Error> {
    let mut end = End::new("passive-spring", &["coordination.tank_j=0", "coordination.damping_n_s_per_m=0"])?;
    end.hear(1.0, 0.0, 0.0, 0.0);
    end.held(0);
    end.hear(1.0, 0.0, 0.0, 4e-3);
    Ok(end.held(0).force)
}

/// What a spring keeps that is led away from its far end by 20 mm and back, of the ½K·X² that it took.
fn kept_of_a_way_there_and_back() -> Result<f64, Error> {
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
fn tank_level_mj() -> Result<f64, Error> {
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
fn bias_left() -> Result<f64, Error> {
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
fn packets_of_a_ramp() -> Result<f64, Error> {
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

/// ẋ_d/ẋ* under a force that pulls forward.
fn velocity_held() -> Result<f64, Error> {
    let mut end = End::new("passive-deadband", &["coordination.tank_j=1", "deadband.weber=0.1"])?;
    end.hear(0.01, 0.2, 0.0, 0.0);
    let velocity = (0..10).fold(0.0, |_, tick| end.held(tick).desired.velocity);
    Ok(velocity / 0.2)
}

/// Force on a copy that is held, with 0.4 mJ in the account and 100 N asked for, N.
fn gated_force_n() -> Result<f64, Error> {
    let set = ["coordination.stiffness_n_per_m=1000", "coordination.damping_n_s_per_m=2", "coordination.tank_j=0.0004"];
    let mut end = End::new("passivity-observer", &set)?;
    end.hear(0.1, 0.0, 0.0, 0.0);
    Ok(end.held(0).force)
}

/// What the model at the end of a hand that shakes has become after 6 s: its k̂, where the other copy hangs on 600 N/m and 3 N·s/m, N/m.
fn stiffness_learned_n_per_m() -> Result<f64, Error> {
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
