//! The self-timed line (THEORY §8) between two peers over networks that lose, delay, repeat and reorder: what is sent is emitted,
//! once; no energy is made; a silence stands still or carries on (§11); a peer that begins anew takes the other with it.

use cohold_core::law::Packet;
use cohold_core::law::wave::Decode;
use cohold_core::num::{Fixed, Motion, Scalar};
use cohold_core::object::IntegratorName;
use cohold_core::safety::Mode;
use cohold_core::settings::{Settings, Value};

use super::Bench;
use crate::contact::setup::Random;

fn settings(credit_ticks: f64) -> Settings {
    with(credit_ticks, &[])
}

/// And keys of the law's own.
fn with(credit_ticks: f64, own: &[(&str, f64)]) -> Settings {
    let mut settings = Settings::default();
    settings.timing.ticks_per_packet = 1;
    settings.object.integrator = IntegratorName::Midpoint;
    settings.object.force_delay_ticks = 0.0;
    settings.coordination.comm = "self-timed";
    settings.coordination.decode = Decode::Implicit;
    settings.coordination.stiffness_n_per_m = 4000.0;
    settings.safety.fade_s = 50.0;
    settings.safety.disengage_s = 60.0;
    settings.safety.peer_lost_s = 100.0;
    for (key, value) in [("coordination.credit_ticks", credit_ticks)].iter().chain(own) {
        settings.set(key, Value::Number(*value)).expect("it is allowed");
    }
    settings
}

/// One way of a network: packets with the tick at which they come.
struct Direction<S: Scalar> {
    random: Random,
    flying: Vec<(u32, Packet<S>)>,
    delay: u32,
    jitter: f64,
    loss: f64,
    twice: f64,
    /// Ticks of a burst that are left.
    burst: u32,
}

impl<S: Scalar> Direction<S> {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed);
        let [delay, jitter, loss, twice] = [(); 4].map(|()| random.unit());
        Self {
            random,
            flying: Vec::new(),
            delay: (20.0 * delay) as u32,
            jitter: 30.0 * jitter * jitter,
            loss: 0.6 * loss,
            twice: 0.3 * twice,
            burst: 0,
        }
    }

    /// Nothing is lost, and all takes as long.
    fn steady(delay: u32) -> Self {
        Self { delay, jitter: 0.0, loss: 0.0, twice: 0.0, ..Self::new(1) }
    }

    /// What is sent at this tick, and the newest that comes.
    fn cross(&mut self, tick: u32, sent: Option<Packet<S>>) -> Option<Packet<S>> {
        if self.burst == 0 && self.random.unit() < self.loss / 20.0 {
            self.burst = (100.0 * self.random.unit()) as u32;
        }
        self.burst = self.burst.saturating_sub(1);
        let copies = 1 + u32::from(self.random.unit() < self.twice);
        for _ in 0..copies {
            if self.burst == 0
                && self.random.unit() >= self.loss
                && let Some(sent) = sent
            {
                let late = self.delay + (self.jitter * self.random.unit()) as u32;
                self.flying.push((tick + late, sent));
            }
        }
        let mut newest = None;
        self.flying.retain(|(due, packet)| {
            let comes = *due <= tick;
            if comes {
                // Whatever order they come in: the last one that came is what the peer looks at.
                newest = Some(*packet);
            }
            !comes
        });
        newest
    }
}

/// Two peers whose hands do what they want, over two ways.
struct Couple<S: Scalar> {
    benches: [Bench<S>; 2],
    directions: [Direction<S>; 2],
    tick: u32,
    /// Packets of both.
    sent: u32,
}

impl<S: Scalar> Couple<S> {
    fn new(settings: &Settings, seed: u64) -> Self {
        let directions = [Direction::new(2 * seed), Direction::new(2 * seed + 1)];
        Self { benches: [(); 2].map(|()| Bench::armed(settings)), directions, tick: 0, sent: 0 }
    }

    fn step(&mut self, hands: [Motion<f64>; 2]) {
        let sent = [0, 1].map(|at| self.benches[at].peer.speak().map(|[packet]| packet));
        for at in 0..2 {
            self.sent += u32::from(sent[at].is_some());
            let incoming = self.directions[at].cross(self.tick, sent[1 - at]);
            let bench = &mut self.benches[at];
            incoming.into_iter().for_each(|packet| bench.peer.hear(&[packet]));
            bench.peer.listen();
            bench.at(S::from_f64(hands[at].position), S::from_f64(hands[at].velocity));
            assert_eq!(bench.peer.mode(), Mode::Armed);
        }
        self.tick += 1;
    }

    /// Energy that came out of each end and what the other put in, J.
    fn energies(&self) -> [(f64, f64); 2] {
        [0, 1].map(|at| {
            let out = self.benches[at].peer.ledger()[0].received_j();
            (out.to_f64(), self.benches[1 - at].peer.ledger()[0].sent_j().to_f64())
        })
    }

    /// x_d of the one less x_d of the other, m.
    fn distance(&self) -> f64 {
        let [one, other] = [0, 1].map(|at| self.benches[at].peer.observed()[0].desired.position.to_f64());
        one - other
    }
}

fn hands(tick: u32) -> [Motion<f64>; 2] {
    let t = 1e-3 * f64::from(tick);
    let hand = |amplitude: f64, rate: f64| Motion {
        position: amplitude * (rate * t).sin(),
        velocity: amplitude * rate * (rate * t).cos(),
    };
    [hand(0.02, 7.0), hand(-0.03, 4.3)]
}

/// At no moment has an end emitted more than the other has sent; and once all is at rest and has come, both ends are as far
/// apart as they began, however much was lost on the way.
fn is_passive_and_does_not_drift<S: Scalar>(settings: &Settings, seeds: u64, rounding_m: f64) {
    for seed in 0..seeds {
        let mut couple = Couple::<S>::new(settings, seed);
        // Armed at rest: what is sent before the other end has heard anything is not in the line.
        (0..500).for_each(|_| couple.step([Motion::REST; 2]));
        for tick in 0..4000 {
            couple.step(hands(tick));
            for (out, sent) in couple.energies() {
                assert!(out <= sent * (1.0 + 1e-6) + 1e-9, "seed {seed}, tick {tick}: {out} J of {sent} J");
            }
        }
        // Nothing is lost any more, and the hands rest.
        for direction in &mut couple.directions {
            (direction.loss, direction.burst) = (0.0, 0);
        }
        for _ in 0..6000 {
            couple.step([Motion::REST; 2]);
        }
        // Slips come together while the tank pays for it: here both hands hold what they have.
        let distance = couple.distance().abs();
        assert!(distance < rounding_m, "seed {seed}: {distance:.1e} m apart");
    }
}

#[test]
fn any_network_is_passive_and_without_drift() {
    let settings = settings(30.0);
    is_passive_and_does_not_drift::<f64>(&settings, 60, 2e-6);
    is_passive_and_does_not_drift::<f32>(&settings, 20, 2e-6);
    is_passive_and_does_not_drift::<Fixed>(&settings, 10, 2e-6);
}

#[test]
fn a_line_that_follows_the_network_is_passive_too() {
    let settings = settings(0.0);
    is_passive_and_does_not_drift::<f64>(&settings, 60, 2e-6);
    is_passive_and_does_not_drift::<f32>(&settings, 20, 2e-6);
}

/// The same line, which says only what is worth a packet.
fn of_events(together: f64, threshold: f64) -> Settings {
    let own = [("event.longest_s", 0.05), ("event.together_ticks", together), ("event.threshold_root_w", threshold)];
    let mut settings = with(0.0, &own);
    // Hands that do not give way to a line that stands.
    settings.safety.saturated_ticks = 10_000;
    settings
}

#[test]
fn whatever_is_not_worth_a_packet_makes_no_energy_and_no_drift() {
    for (together, threshold) in [(1.0, 0.01), (9.0, 0.2), (40.0, 0.2), (9.0, 0.001), (9.0, 100.0)] {
        let settings = of_events(together, threshold);
        is_passive_and_does_not_drift::<f64>(&settings, 20, 2e-6);
        is_passive_and_does_not_drift::<f32>(&settings, 5, 2e-6);
    }
}

/// In motion a packet each N ticks, and at rest each longest silence, where the threshold is out of reach.
#[test]
fn packets_go_as_often_as_the_keys_say() {
    for (together, threshold, every) in [(9.0, 0.2, 9), (40.0, 0.2, 40), (9.0, 100.0, 50)] {
        let mut couple = Couple::<f64>::new(&of_events(together, threshold), 1);
        couple.directions = [(); 2].map(|()| Direction::steady(5));
        // Both press with the same force for ever: the waves are F/√(2b) each, some 0.4 √W, and do not change.
        let press = |at: f64| [Motion::at(at), Motion::at(-at)];
        (0..4000).for_each(|tick| couple.step(press(0.01 * f64::min(1.0, f64::from(tick) / 1000.0))));
        couple.sent = 0;
        (0..1800).for_each(|_| couple.step(press(0.01)));
        assert_eq!(couple.sent, 2 * 1800 / every, "{together} ticks together, {threshold} √W");
    }
}

/// Both ends may stand because a packet was lost, each with less to tell than is worth a packet: they say again every N ticks what they have said, and
/// do not wait out the longest silence.
#[test]
fn two_ends_that_stand_do_not_wait_for_each_other() {
    for phase in 0..9 {
        let mut couple = Couple::<f64>::new(&of_events(9.0, 1.0), 1);
        couple.directions = [(); 2].map(|()| Direction::steady(5));
        let press = |at: f64| [Motion::at(at), Motion::at(-at)];
        (0..4000).for_each(|tick| couple.step(press(0.01 * f64::min(1.0, f64::from(tick) / 1000.0))));
        (0..phase).for_each(|_| couple.step(press(0.01)));
        let live = |couple: &Couple<f64>| couple.benches.each_ref().map(|bench| bench.peer.outgoing()[0].live_ticks);
        couple.directions.iter_mut().for_each(|direction| direction.burst = 13);
        let before = live(&couple);
        (0..100).for_each(|_| couple.step(press(0.01)));
        let lived = live(&couple).into_iter().zip(before).map(|(after, before)| after - before);
        let least = lived.min().unwrap_or(0);
        println!("{phase}: {least}");
        assert!(least >= 70, "{phase}: {least} of 100 ticks");
    }
}

/// A wave that jumps is announced in the tick after.
#[test]
fn a_jolt_goes_at_once() {
    let mut couple = Couple::<f64>::new(&of_events(40.0, 0.2), 1);
    couple.directions = [(); 2].map(|()| Direction::steady(5));
    (0..500).for_each(|_| couple.step([Motion::REST; 2]));
    couple.sent = 0;
    let struck = [Motion { position: 0.01, velocity: 0.0 }, Motion::REST];
    (0..3).for_each(|_| couple.step(struck));
    assert!(couple.sent >= 1, "{} packets in the 3 ms after a blow", couple.sent);
}

/// THEORY §11: what an end does to its copy, ∫F_T·v, is never more than came out of the line less what went into it, and E₀: whatever
/// the network does, however the hands move and whatever the other end claims.
fn carries_on_at_its_own_expense<S: Scalar>(seeds: u64, rounding_j: f64) {
    let (mut borrowed_j, mut stood) = (0.0_f64, 0);
    for seed in 0..seeds {
        let mut random = Random(1000 + seed);
        let capital_j = [0.0, 0.001, 0.02][seed as usize % 3];
        let own = [
            ("coordination.carry_damping_n_s_per_m", 1.0 + 50.0 * random.unit()),
            ("coordination.carry_s", 0.02 + random.unit()),
            ("coordination.carry_return_s", 0.01 + 0.2 * random.unit()),
            ("coordination.carry_energy_j", capital_j),
            ("coordination.damping_n_s_per_m", 10.0 * random.unit()),
            ("coordination.tautness", if seed % 4 < 2 { 0.0 } else { 1.5 * random.unit() }),
            ("coordination.taut_s", 0.001 + 0.1 * random.unit()),
            ("coordination.even_s", [0.0, 0.01, 0.1][seed as usize / 3 % 3]),
        ];
        let mut settings = with(if seed % 2 == 0 { 0.0 } else { 15.0 }, &own);
        settings.safety.saturated_ticks = 10_000;
        let mut couple = Couple::<S>::new(&settings, seed);
        let (mut done_j, mut before) = ([0.0; 2], [None; 2]);
        for tick in 0..4000 {
            couple.step(hands(tick));
            let energies = [0, 1].map(|at| {
                let ledger = &couple.benches[at].peer.ledger()[0];
                (ledger.received_j().to_f64(), ledger.sent_j().to_f64())
            });
            for at in 0..2 {
                let seen = couple.benches[at].peer.observed()[0];
                let (velocity, force) = (seen.object.velocity.to_f64(), seen.coordination_force.to_f64());
                // The tick before, at the mean velocity that is known now, with what the line had done by its end.
                if let Some((earlier, pulled, into_j)) = before[at] {
                    done_j[at] += 1e-3 * pulled * 0.5 * (earlier + velocity);
                    let made_j: f64 = done_j[at] - into_j;
                    assert!(made_j <= capital_j + rounding_j, "seed {seed}, tick {tick}: {made_j} J of {capital_j} J");
                    borrowed_j = borrowed_j.max(made_j);
                }
                let (received_j, sent_j) = energies[at];
                stood += u32::from(before[at].is_some_and(|(_, _, into_j)| into_j == received_j - sent_j));
                before[at] = Some((velocity, force, received_j - sent_j));
            }
        }
    }
    assert!(borrowed_j > 1e-4, "the test must borrow: {borrowed_j} J");
    assert!(stood > 1000, "ticks that stand are among them: {stood}");
}

#[test]
fn carrying_on_gives_no_more_than_its_capital() {
    carries_on_at_its_own_expense::<f64>(120, 1e-12);
    carries_on_at_its_own_expense::<f32>(30, 1e-5);
    carries_on_at_its_own_expense::<Fixed>(9, 1e-5);
}

/// Nothing has come yet, or nothing carries on: x_d stands, and the copy hangs on the spring there.
#[test]
fn silence_is_a_wall() {
    for settings in [with(10.0, &[("coordination.carry_damping_n_s_per_m", 0.0)]), settings(10.0)] {
        let mut bench = Bench::<f64>::armed(&settings);
        for tick in 0..500 {
            let [hand, _] = hands(tick);
            bench.peer.exchange();
            bench.at(hand.position, hand.velocity);
            let seen = bench.peer.observed()[0];
            assert!(
                seen.desired.position.abs() < 1e-15 && seen.desired.velocity == 0.0,
                "tick {tick}: {:?}",
                seen.desired
            );
            // F_T = K_T·s + κ·(0 − v), v by how far the copy moved: seen at the next tick.
            assert!(seen.coordination_force * seen.object.position <= 0.0 || seen.object.position.abs() < 1e-3);
        }
        assert_eq!((bench.peer.ledger()[0].received_j(), bench.peer.ledger()[0].sent_j()), (0.0, 0.0));
        assert_eq!(bench.peer.outgoing()[0].live_ticks, 0);
        assert!(bench.peer.observed()[0].object.position.abs() > 1e-4, "the hand must have moved it");
    }
}

/// One packet has come and nothing since, from rest: the copy is tied to a damper D that is drawn back to where the other end should be, at 1 m/s at the
/// most, F_T = −D·(v + r), with what the spring in between takes.
#[test]
fn silence_yields_like_a_damper() {
    let mut bench = Bench::<f64>::armed(&with(10.0, &[("coordination.carry_damping_n_s_per_m", 8.0)]));
    bench.peer.hear(&[Packet::default()]);
    let velocity = 0.05;
    for tick in 0..1000 {
        bench.peer.exchange();
        bench.at(1e-3 * velocity * f64::from(tick), velocity);
    }
    let seen = bench.peer.observed()[0];
    // And F̄ is what ten live ticks were.
    assert!((seen.coordination_force / (-8.0 * (velocity + 1.0)) - 1.0).abs() < 0.01, "{} N", seen.coordination_force);
    assert!((seen.desired.velocity / velocity - 1.0).abs() < 1e-3, "{} m/s", seen.desired.velocity);
    assert_eq!(bench.peer.outgoing()[0].live_ticks, 10, "no more than its credit");
}

/// Both ends have carried on a long way together, and one begins anew, or both: nothing pulls at anybody for that.
#[test]
fn a_slip_is_agreed_where_a_line_begins_anew() {
    for parted in [[true, false], [false, true], [true, true]] {
        let mut settings = settings(12.0);
        settings.safety.workspace_m = 3.0;
        let mut couple = Couple::<f64>::new(&settings, 3);
        couple.directions = [(); 2].map(|()| Direction::steady(5));
        // Led together, most of it through an outage.
        let led = |tick: u32| [Motion { position: 2e-4 * f64::from(tick), velocity: 0.2 }; 2];
        (0..500).for_each(|tick| couple.step(led(tick)));
        couple.directions.iter_mut().for_each(|direction| direction.burst = 1000);
        (500..2000).for_each(|tick| couple.step(led(tick)));
        let rest = [Motion::at(0.4); 2];
        (0..2000).for_each(|_| couple.step(rest));
        let slip = couple.benches[0].peer.outgoing()[0].motion.position;
        assert!(slip > 0.15, "{slip} m");
        for (bench, _) in couple.benches.iter_mut().zip(parted).filter(|(_, parted)| *parted) {
            bench.peer.part();
        }
        let most = (0..2000).fold(0.0_f64, |most, _| {
            couple.step(rest);
            couple.benches.iter().map(|bench| bench.peer.observed()[0].coordination_force.abs()).fold(most, f64::max)
        });
        assert!(most < 0.01, "{parted:?}: {most} N");
        let [one, other] = couple.benches.each_ref().map(|bench| bench.peer.outgoing()[0].motion.position);
        assert!((one - other).abs() < 1e-4, "{parted:?}: {one} m, {other} m");
    }
}

/// Both ends are led 10 m through an outage, farther than a slip is told: nobody feels it, and what is told stays within its bounds.
#[test]
fn a_slip_may_go_as_far_as_it_likes() {
    let mut settings = settings(12.0);
    (settings.safety.workspace_m, settings.safety.max_speed_m_per_s) = (50.0, 2.0);
    let mut couple = Couple::<f64>::new(&settings, 3);
    couple.directions = [(); 2].map(|()| Direction::steady(5));
    let led = |tick: u32| [Motion { position: 1e-3 * f64::from(tick), velocity: 1.0 }; 2];
    (0..100).for_each(|_| couple.step([Motion::REST; 2]));
    let (mut turned, mut last) = (0, 0.0);
    for tick in 0..10_000 {
        // Something comes now and then, so that neither is let go of.
        if tick % 1_000 == 100 {
            couple.directions.iter_mut().for_each(|direction| direction.burst = 950);
        }
        couple.step(led(tick));
        let told = couple.benches[0].peer.outgoing()[0].motion.position;
        assert!(told.abs() <= 8.01, "{told} m");
        turned += u32::from((told - last).abs() > 8.0);
        last = told;
        let force = couple.benches[0].peer.observed()[0].coordination_force;
        assert!(tick < 200 || force.abs() < 9.0, "tick {tick}: {force} N");
    }
    assert!(turned > 0, "it went beyond what is told: {last} m");
    (0..4_000).for_each(|_| couple.step([Motion::at(10.0); 2]));
    assert!(couple.distance().abs() < 1e-4, "{} m", couple.distance());
}

/// A line of d₀ samples each way that the network does not starve has a constant delay of d₀: a pulse of the one arrives at
/// the other d₀ ticks later, spread over as many ticks as there are outstanding.
#[test]
fn the_delay_is_the_credit_whatever_the_networks_is() {
    for (delay, credit) in [(0_u32, 8_u32), (3, 8), (7, 8), (20, 30)] {
        let mut couple = Couple::<f64>::new(&settings(f64::from(credit)), 1);
        couple.directions = [(); 2].map(|()| Direction::steady(delay));
        (0..100).for_each(|_| couple.step([Motion::REST; 2]));
        let live = couple.benches.each_ref().map(|bench| bench.peer.outgoing()[0].live_ticks);
        // Nothing is emitted before the first packet has come.
        assert_eq!(live, [100 - delay; 2], "delay {delay}");
        let hand = Motion { position: 0.001, velocity: 0.0 };
        let felt = (0_u32..).find(|_| {
            couple.step([hand, Motion::REST]);
            couple.benches[1].peer.observed()[0].desired.velocity != 0.0
        });
        // Sent with the packet after its tick, and heard after the delay.
        assert_eq!(felt, Some(delay + 1), "delay {delay}");
    }
}

/// Two ends that call each other before either is engaged, as they do over a link, begin with d₀ samples each and no more, whichever hears the other
/// first and however long either is deaf: once nothing comes any more, an end has emitted d₀ samples more than it has heard of.
#[test]
fn a_line_begins_with_the_samples_of_both_ends_and_no_more() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let mut below = |most: f64| (most * random.unit()) as u32;
        let credit = [16, 8, 30][below(3.0) as usize];
        let mut couple = Couple::<f64>::new(&settings(f64::from(credit)), 1);
        couple.directions = [(); 2].map(|()| Direction::steady(below(60.0)));
        couple.benches.iter_mut().for_each(|bench| bench.peer.part());
        // Twice deaf, each end for itself, and then not.
        let deaf = [(); 4].map(|()| (below(100.0), below(60.0)));
        let hears =
            |at: usize, tick: u32| !deaf[2 * at..][..2].iter().any(|(from, long)| (*from..from + long).contains(&tick));
        let mut heard = [0; 2];
        for tick in 0..1000 {
            let sent = couple.benches.each_ref().map(|bench| bench.peer.outgoing()[0]);
            for at in 0..2 {
                let incoming = couple.directions[at].cross(tick, Some(sent[1 - at]).filter(|_| tick < 500));
                let bench = &mut couple.benches[at];
                if let Some(packet) = incoming.filter(|_| hears(at, tick)) {
                    heard[at] = packet.live_ticks;
                    bench.peer.hear(&[packet]);
                }
                bench.peer.exchange();
                bench.at(0.0, 0.0);
            }
        }
        // Each life of an end counts from a multiple of 2²⁰ on.
        let life = |ticks: u32| ticks % (1 << 20);
        let more = [0, 1].map(|at| life(couple.benches[at].peer.outgoing()[0].live_ticks) - life(heard[at]));
        assert_eq!(more, [credit; 2], "seed {seed}: credit {credit}, deaf {deaf:?}");
    }
}

/// One peer disengages and begins anew; the other sees its counters jump and begins anew with it: the line goes on.
#[test]
fn a_peer_that_begins_anew_takes_the_other_with_it() {
    let mut couple = Couple::<f64>::new(&settings(12.0), 3);
    couple.directions = [(); 2].map(|()| Direction::steady(5));
    (0..2000).for_each(|tick| couple.step(hands(tick)));
    let before = couple.energies();
    couple.benches[0].peer.part();
    let forces = |couple: &Couple<f64>| [0, 1].map(|at| couple.benches[at].peer.observed()[0].coordination_force);
    let at_parting = forces(&couple);
    (2000..6000).for_each(|tick| couple.step(hands(tick)));
    for (at, ((out, sent), (_, sent_before))) in couple.energies().into_iter().zip(before).enumerate() {
        assert!(sent > 1.5 * sent_before, "end {at} goes on sending: {sent_before} J, then {sent} J");
        assert!(out <= sent, "end {at}: {out} J of {sent} J");
    }
    assert!(at_parting.iter().any(|force| *force != 0.0));
}

/// Lines that may weigh different things at either end, that grow, and that begin anew: what comes out is paid for at any ρ, positions
/// stay what they are, and where nothing is lost both ends come to the smaller mass.
#[test]
fn a_light_line_is_passive_and_without_drift() {
    for (most_kg, credit) in [(0.15, 30.0), (0.1, 0.0), (0.01, 0.0)] {
        let settings = with(credit, &[("coordination.most_line_mass_kg", most_kg)]);
        is_passive_and_does_not_drift::<f64>(&settings, 30, 2e-6);
        is_passive_and_does_not_drift::<f32>(&settings, 10, 2e-6);
        is_passive_and_does_not_drift::<Fixed>(&settings, 3, 2e-6);
    }
}

/// Both hands move a line of d₀ ticks together, faster and faster up to 20 mm/s: what is in it then is ½·b·T·v²,
/// T = d₀·T_c whatever delay the network has; with a bound on its mass, of that mass.
#[test]
fn a_line_weighs_what_it_may() {
    // b = 10 N·s/m and 300 ms: 3 kg. No end is lighter than a quarter of b.
    for (most_kg, weighs_kg) in [(0.0, 3.0), (4.0, 3.0), (1.0, 1.0), (0.05, 3.0 / 4.0)] {
        let own = [("coordination.carry_damping_n_s_per_m", 0.0), ("coordination.most_line_mass_kg", most_kg)];
        let mut couple = Couple::<f64>::new(&with(300.0, &own), 1);
        couple.directions = [(); 2].map(|()| Direction::steady(20));
        (0..500).for_each(|_| couple.step([Motion::REST; 2]));
        // Up to 20 mm/s within 40 s, so that emitting means of what is outstanding loses less than 1 %.
        let led = |tick: u32| {
            let t = 1e-3 * f64::from(tick);
            [Motion { position: 2.5e-4 * t * t, velocity: 5e-4 * t }; 2]
        };
        (0..=40_000).for_each(|tick| couple.step(led(tick)));
        let held_j: f64 = couple.energies().into_iter().map(|(out, sent)| sent - out).sum();
        let mass_kg = 2.0 * held_j / 0.02_f64.powi(2);
        assert!((mass_kg / weighs_kg - 1.0).abs() < 0.02, "at most {most_kg} kg: {mass_kg} kg, {weighs_kg} expected");
    }
}

/// Two ends that were told different masses: the line is as light as the lighter one makes it, and no energy is made on the way there.
#[test]
fn the_lighter_end_decides() {
    let [light, heavy] = [1.0, 100.0].map(|most_kg| with(300.0, &[("coordination.most_line_mass_kg", most_kg)]));
    let mut couple = Couple::<f64>::new(&heavy, 1);
    couple.benches[0] = Bench::armed(&light);
    couple.directions = [(); 2].map(|()| Direction::steady(20));
    for tick in 0..6000 {
        couple.step(hands(tick));
        for (out, sent) in couple.energies() {
            assert!(out <= sent * (1.0 + 1e-9) + 1e-9, "tick {tick}: {out} J of {sent} J");
        }
    }
    // Both push against each other, F = K_T·s: what is between them is F·T/b of the lighter end, and a spring at either.
    let press = |at: f64| [Motion::at(at), Motion::at(-at)];
    (0..20_000).for_each(|_| couple.step(press(0.01)));
    let force = couple.benches[0].peer.observed()[0].coordination_force.abs();
    let other = couple.benches[1].peer.observed()[0].coordination_force.abs();
    assert!((force / other - 1.0).abs() < 0.01, "{force} N and {other} N");
    let expected_m = force * 0.3 / (10.0 / 3.0);
    let apart_m = couple.distance().abs();
    assert!((apart_m / expected_m - 1.0).abs() < 0.02, "{apart_m} m, {expected_m} m of a line of 1 kg");
}

#[test]
fn what_it_needs_is_said() {
    let mut wrong = settings(0.0);
    wrong.object.integrator = IntegratorName::SemiImplicit;
    let said = wrong.check().expect_err("no solve").to_string();
    assert!(
        said.starts_with("object.integrator = \"semi-implicit\" is not allowed: it must be \"midpoint\""),
        "{said}"
    );
    let mut wrong = settings(0.0);
    wrong.coordination.ledger = true;
    let said = wrong.check().expect_err("a ledger beside it").to_string();
    assert!(said.starts_with("coordination.ledger = true is not allowed: it must be false, unless"), "{said}");
    let refused =
        settings(0.0).set("coordination.credit_ticks", Value::Number(2.5)).expect_err("half a tick").to_owned();
    assert!(format!("{refused:?}").contains("Whole"), "{refused:?}");
}
