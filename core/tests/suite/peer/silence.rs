//! Silence on purpose, with a law that speaks on command: how long it lasts, who does not notice, and who does.

use cohold_core::device::{AXES, Reading};
use cohold_core::law::power::Power;
use cohold_core::law::{Coupled, Law, LawInfo, Observation, Packet, event};
use cohold_core::num::{Configured, Motion};
use cohold_core::object::Solve;
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::schema::Schema;
use cohold_core::settings::{Refused, SetError, Settings, Value};

/// Power-domain; worth a packet is a copy beyond the origin.
#[derive(Clone, Copy, Debug)]
struct Shy(Power<f64>);

impl Configured for Shy {}

impl Law<f64> for Shy {
    const LAWS: &'static [LawInfo] = &[LawInfo { name: "shy", keys: &[event::LONGEST], ..LawInfo::MOTION }];
    type State = Motion<f64>;

    fn build(settings: &Settings) -> Result<Self, Refused<'static>> {
        Power::build(settings).map(Self)
    }
    fn start(&self, local: Motion<f64>) -> Motion<f64> {
        self.0.start(local)
    }
    fn receive(&self, state: &mut Motion<f64>, packet: Packet<f64>) {
        self.0.receive(state, packet);
    }
    fn couple(&self, state: &mut Motion<f64>, seen: &Observation<f64>, solve: impl Solve<f64>) -> Coupled<f64> {
        self.0.couple(state, seen, solve)
    }
    fn send(&self, state: &Motion<f64>, local: Motion<f64>) -> Packet<f64> {
        self.0.send(state, local)
    }
    fn speaks(&self, _: &Motion<f64>, packet: &Packet<f64>) -> bool {
        packet.motion.position > 0.0
    }
}

const SCHEMA: Schema = Schema::new(Shy::LAWS);

/// Packets of 8 ms, silence for `longest_s`, fading from 0.4 s to 0.8 s.
fn settings(longest_s: f64) -> Settings {
    let mut settings = Settings::default();
    SCHEMA.set(&mut settings, "coordination.comm", Value::Text("shy")).expect("there is such a law");
    SCHEMA.set(&mut settings, "event.longest_s", Value::Number(longest_s)).expect("it has such a key");
    settings.coordination.stiffness_n_per_m = 310.0;
    settings.coordination.damping_n_s_per_m = 0.0;
    (settings.safety.fade_s, settings.safety.disengage_s) = (0.4, 0.8);
    settings
}

fn armed(settings: &Settings) -> Peer<f64, Shy> {
    let mut peer = Peer::new(settings, [Motion::REST; AXES]).expect("a good scene");
    peer.command(Command::Arm);
    peer
}

/// A packet period with or without a packet: whether it speaks, and the coordination force of its first tick.
fn period(peer: &mut Peer<f64, Shy>, incoming: Option<f64>) -> (bool, f64) {
    incoming.into_iter().for_each(|at| peer.hear(&[Packet { motion: Motion::at(at), ..Packet::default() }]));
    let spoke = peer.exchange().is_some();
    let mut force = None;
    for _ in 0..peer.ticks_per_packet() {
        peer.tick(&Sensors::of(Reading::Exact([Motion::REST; AXES])));
        force.get_or_insert(peer.observed()[0].coordination_force);
    }
    (spoke, force.unwrap_or_default())
}

/// The first packet goes at once. 100 ms are twelve and a half packet periods: thirteen, and never more.
#[test]
fn nobody_is_silent_for_longer_than_the_longest_silence() {
    for (longest_s, every) in [(0.0, 1), (0.004, 1), (0.016, 2), (0.1, 13)] {
        let mut peer = armed(&settings(longest_s));
        let spoke: Vec<bool> = (0..100).map(|_| period(&mut peer, None).0).collect();
        let expected: Vec<bool> = (0..100).map(|period| period % every == 0).collect();
        assert_eq!(spoke, expected, "{longest_s} s");
    }
}

/// What is worth a packet goes in its period, and silence counts from there.
#[test]
fn what_is_worth_a_packet_goes_at_once() {
    let mut scene = settings(0.1);
    scene.coordination.damping_n_s_per_m = 10.0;
    let mut peer = armed(&scene);
    let (mut quiet, mut spoken, mut due) = (12, 0, 0);
    for at in 0..800 {
        let (worth, over) = (peer.outgoing()[0].motion.position > 0.0, quiet + 1 == 13);
        // The other's copy pulls this one over the origin, and back.
        let (said, _) = period(&mut peer, Some(if at / 100 % 2 == 0 { -0.01 } else { 0.01 }));
        assert_eq!(said, worth || over, "period {at}");
        quiet = if said { 0 } else { quiet + 1 };
        (spoken, due) = (spoken + u32::from(worth), due + u32::from(over && !worth));
    }
    assert!(spoken > 50 && due > 5, "{spoken} worth a packet, {due} due");
}

#[test]
fn who_is_not_engaged_speaks_in_every_period() {
    let mut peer = armed(&settings(0.1));
    peer.part();
    assert!((0..30).all(|_| period(&mut peer, None).0));
    peer.command(Command::Disarm);
    assert!((0..30).all(|_| period(&mut peer, None).0));
}

#[test]
fn a_longest_silence_that_a_lost_packet_would_make_fade_is_refused() {
    let refused = |settings: &Settings| Peer::<f64, Shy>::new(settings, [Motion::REST; AXES]).map(drop);
    for (longest_s, good) in [(0.0, true), (0.12, true), (0.13, false), (0.21, false)] {
        let refused = refused(&settings(longest_s)).err().map(|refused| refused.key);
        assert_eq!(refused, (!good).then_some("event.longest_s"), "{longest_s} s");
    }
    let mut fades = settings(0.1);
    fades.safety.fade_s = 0.19;
    let text = refused(&fades).expect_err("too long").to_string();
    assert_eq!(
        text,
        "event.longest_s = 0.1 is not allowed: it must be at most half of safety.fade_s: one lost packet must not fade the \
         coordination"
    );
    assert!(matches!(
        SCHEMA.set(&mut fades, "event.longest_s", Value::Number(-0.1)),
        Err(SetError::Refused(refused)) if refused.key == "event.longest_s"
    ));
}

/// A peer that hears the other one only every 0.1 s loses it as soon as one that hears it in every period.
#[test]
fn a_dead_peer_is_noticed_in_the_same_time() {
    let noticed = |longest_s: f64, every: usize| {
        let mut scene = settings(longest_s);
        scene.safety.peer_lost_s = 2.0;
        let mut peer = armed(&scene);
        let mut parted = None;
        // The other one dies after its packet of period 208, the 17th of those that speak every 13th.
        for at in 0.. {
            let here = peer.outgoing()[0].motion.position;
            let comes = at <= 208 && at % every == 0;
            let (_, force) = period(&mut peer, comes.then_some(here + 0.01));
            let dead = usize::saturating_sub(at, 208);
            if dead == 0 {
                assert!(
                    at == 0 || force.abs() > 0.0 && peer.is_engaged(),
                    "period {at}: silence on purpose fades nothing"
                );
                continue;
            }
            if peer.mode() == Mode::Faulted(Fault::PeerLost) {
                return (parted, dead);
            }
            parted = parted.or((!peer.is_engaged()).then_some(dead));
        }
        unreachable!()
    };
    // 0.4 s, 0.8 s, 2 s of 8 ms, each after the last packet.
    assert_eq!(noticed(0.0, 1), (Some(100), 250));
    assert_eq!(noticed(0.1, 13), (Some(100), 250));
}

/// After a silence that disengaged, the coordination comes back in the same time, however few packets bring it.
#[test]
fn the_way_back_takes_as_long_as_with_every_packet() {
    // (safety.disengage_s − safety.fade_s)/T_n
    for (longest_s, every) in [(0.0, 1), (0.1, 10)] {
        let mut peer = armed(&settings(longest_s));
        peer.part();
        let mut whole = None;
        for at in 0..120_usize {
            let here = peer.outgoing()[0].motion.position;
            let (_, force) = period(&mut peer, at.is_multiple_of(every).then_some(here + 0.01));
            // K_T times the distance, once the peer is engaged in full.
            whole = whole.or(((force - 3.1).abs() < 1e-9).then_some(at));
        }
        let steps: usize = 50;
        let whole = whole.expect("it comes back");
        assert!(whole.abs_diff(steps) <= every, "{longest_s} s: after {whole} periods");
    }
}
