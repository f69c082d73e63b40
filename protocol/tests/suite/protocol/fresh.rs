//! Fresh or nothing: whoever holds back, stretches or carries over what two peers say makes nothing of it count. Nobody here has
//! the key but the two peers.

use cohold_protocol::lease::Word;
use cohold_protocol::lines::{FRESH_US, Heard, Lines};
use cohold_protocol::link::{Error, Link, Notice, Stage};
use cohold_protocol::wire::{Flow, Greeting, Header, MAX_DATAGRAM, Message, Telemetry};

use crate::protocol::world::{CLEAN, Impairment, PERIOD, World, config};

const SECOND: u64 = 1_000_000;

fn is_sealed(datagram: &[u8]) -> bool {
    datagram.get(1) == Some(&Header::KIND)
}

/// All that a link has to say.
fn said(link: &mut Link, now: u64) -> Vec<Vec<u8>> {
    let mut out = [0; MAX_DATAGRAM];
    std::iter::from_fn(|| link.poll(now, &mut out).map(|len| out[..len].to_vec())).collect()
}

fn hear(link: &mut Link, now: u64, datagrams: &[Vec<u8>]) {
    for datagram in datagrams {
        let _ = link.receive(now, &mut datagram.clone());
    }
}

/// A board and an operator, who says `arm`; somebody between them who decides when what is for the board gets there.
struct Held {
    board: Link,
    operator: Link,
    lines: [Lines; 2],
    now: u64,
    held: Vec<Vec<u8>>,
    heard: Vec<Heard>,
}

impl Held {
    fn new() -> Self {
        let [board, operator] = [config(1, 2, [1; 32]), config(2, 1, [2; 32])].map(|it| Link::new(it).unwrap());
        let lines = [Lines::default(), Lines::default()];
        Self { board, operator, lines, now: 3 * SECOND, held: Vec::new(), heard: Vec::new() }
    }

    /// One millisecond; of the operator's datagrams only what `passes` gets to the board, the rest is held.
    fn step(&mut self, operator_there: bool, passes: impl Fn(&[u8]) -> bool) {
        self.now += 1_000;
        if operator_there {
            self.lines[1].push(&mut self.operator);
            let (through, held) =
                said(&mut self.operator, self.now).into_iter().partition::<Vec<_>, _>(|one| passes(one));
            self.held.extend(held);
            hear(&mut self.board, self.now, &through);
        }
        let answers = said(&mut self.board, self.now);
        hear(&mut self.operator, self.now, &answers);
        while let Some(heard) = self.lines[0].hear(self.now, &mut self.board) {
            self.heard.push(heard);
        }
    }

    fn run(&mut self, ms: u64, operator_there: bool, passes: impl Fn(&[u8]) -> bool) {
        (0..ms).for_each(|_| self.step(operator_there, &passes));
    }

    /// Lets everything through that was held, in order, as fast as the board answers.
    fn release(&mut self) {
        for datagram in std::mem::take(&mut self.held) {
            hear(&mut self.board, self.now, &[datagram]);
            self.step(false, |_| true);
        }
        self.run(50, false, |_| true);
    }

    fn did(&self) -> Vec<&str> {
        self.heard.iter().filter(|heard| heard.is_fresh()).map(|heard| heard.line.as_str()).collect()
    }
}

#[test]
fn what_an_operator_says_is_done_if_it_gets_there() {
    let mut held = Held::new();
    assert!(held.lines[1].say("arm", Word::default()));
    held.run(100, true, |_| true);
    assert_eq!(held.did(), ["arm"]);
}

#[test]
fn an_operators_datagrams_held_for_two_minutes_arm_nothing() {
    // Everything is held; all that is sealed; all that is sealed once the session stands.
    for attack in 0..3 {
        let mut held = Held::new();
        if attack == 2 {
            held.run(100, true, |_| true);
            assert_eq!(held.operator.stage(), Stage::Idle);
        }
        assert!(held.lines[1].say("arm", Word::default()));
        held.run(300, true, |datagram| attack > 0 && !is_sealed(datagram));
        assert!(held.held.len() > 5, "attack {attack}: {}", held.held.len());
        // The operator has gone.
        held.run(120_000, false, |_| true);
        held.release();
        assert!(held.did().is_empty(), "attack {attack}: {:?}", held.heard);
        assert!(!held.board.is_up());
    }
}

#[test]
fn a_line_counts_from_when_it_was_said_however_often_it_was_sent() {
    for (late_ms, done) in [(100, true), (700, false)] {
        let mut held = Held::new();
        held.run(100, true, |_| true);
        assert!(held.lines[1].say("arm", Word::default()));
        // Events are held back for a while and everything else gets through: the link says them again and again, sealed anew.
        let event = 16 + 16 + 8 + 8 + 3 + 16;
        held.run(late_ms, true, |datagram| datagram.len() != event);
        assert!(!held.held.is_empty() && held.heard.is_empty() && held.board.is_up());
        held.run(1_500, true, |_| true);
        let [heard] = &held.heard[..] else { panic!("{:?}", held.heard) };
        assert_eq!((heard.is_fresh(), heard.line.as_str()), (done, "arm"), "{heard:?}");
        assert!(heard.age_us.is_some_and(|age_us| (age_us > FRESH_US) != done), "{heard:?}");
    }
}

#[test]
fn a_dead_peers_held_datagrams_engage_nobody() {
    let mut world = World::new(1, CLEAN);
    world.log = Some([vec![], vec![]]);
    // Peer 0 hears peer 1, and peer 1 hears of peer 0 no more than greetings.
    world.run(8);
    world.cut[1] = true;
    let (mut taken, mut greetings) = (0, 0);
    while world.now < 6 * SECOND {
        world.step();
        let log = world.log.as_ref().unwrap()[0][taken..].to_vec();
        taken += log.len();
        for greeting in log.iter().filter(|datagram| !is_sealed(datagram)) {
            greetings += 1;
            let now = world.clock(1);
            let _ = world.links[1].receive(now, &mut greeting.clone());
            world.poll(1);
        }
    }
    let held: Vec<_> = world.log.take().unwrap()[0].iter().filter(|datagram| is_sealed(datagram)).cloned().collect();
    assert!(held.len() >= 781 && greetings > 10, "{} held, {greetings} greetings", held.len());
    // Peer 0 is dead for 20 s; then all it ever said comes, one a millisecond.
    world.off[0] = true;
    world.run(20 * SECOND);
    world.cut[1] = false;
    world.notices[1].clear();
    for mut datagram in held {
        let now = world.clock(1);
        assert!(!matches!(world.links[1].receive(now, &mut datagram), Ok(Some(_))));
        world.step();
        assert!(!world.links[1].is_up());
    }
    assert!(world.notices[1].is_empty() && world.flows[1].is_empty(), "{:?}", world.notices[1]);
}

#[test]
fn a_session_that_nothing_is_answered_in_ends_within_a_second() {
    let mut world = World::new(2, CLEAN);
    world.run_until(SECOND, |world| world.stages().contains(&Stage::Joining)).unwrap();
    let peer = usize::from(world.stages()[1] == Stage::Joining);
    world.cut = [true; 2];
    world.off[1 - peer] = true;
    world.run(SECOND - 50_000);
    assert_eq!(world.stages()[peer], Stage::Joining, "a round trip of 0.9 s is waited for");
    world.run(100_000);
    assert_eq!(world.stages()[peer], Stage::Calling);
}

#[test]
fn a_challenge_is_good_for_a_second() {
    for (held_us, joins) in [(800_000, true), (SECOND, false), (120 * SECOND, false)] {
        let (mut one, mut two) = (Link::new(config(1, 2, [1; 32])).unwrap(), Link::new(config(2, 1, [2; 32])).unwrap());
        let hello = said(&mut one, 0);
        hear(&mut two, 0, &hello);
        let welcome = said(&mut two, 0);
        assert!(Greeting::parse(&welcome[0]).is_ok());
        // Asked for, and still the newest that the one has: held, then let through.
        let taken = one.receive(held_us, &mut welcome[0].clone());
        assert_eq!(taken, if joins { Ok(None) } else { Err(Error::Stale) }, "{held_us} µs");
        assert_eq!(one.stage() == Stage::Joining, joins);
    }
}

#[test]
fn nothing_is_handed_out_before_the_other_end_has_answered() {
    let (mut one, mut two) = (Link::new(config(1, 2, [1; 32])).unwrap(), Link::new(config(2, 1, [2; 32])).unwrap());
    let hello = said(&mut one, 0);
    hear(&mut two, 0, &hello);
    let welcome = said(&mut two, 0);
    hear(&mut one, 0, &welcome);
    let [hello, ..] = &said(&mut one, 0)[..] else { panic!("a hello") };
    let _ = two.receive(0, &mut hello.clone());
    assert_eq!((one.stage(), two.stage()), (Stage::Joining, Stage::Joining));
    // Under right keys, and all of it new: but nobody knows from when.
    let mut out = [0; MAX_DATAGRAM];
    for message in [Message::Flow(Flow::default()), Message::Telemetry(Telemetry::default())] {
        for now in [100, 100_000, 900_000] {
            let len = one.send(1, message, &mut out).unwrap();
            assert_eq!(two.receive(now, &mut out[..len]), Ok(None));
            assert_eq!(two.stage(), Stage::Joining);
        }
    }
}

#[test]
fn a_lan_joins_in_two_periods() {
    for seed in 0..20 {
        let mut world = World::new(seed, CLEAN);
        let met = world.run_until(SECOND, |world| world.stages() == [Stage::Running; 2]);
        assert!(met.is_some_and(|us| us <= 3 * PERIOD), "{met:?}");
    }
}

#[test]
fn peers_join_over_any_round_trip_up_to_nine_tenths_of_a_second() {
    for delay in [1_000, 50_000, 150_000, 300_000, 400_000, 430_000] {
        let mut world = World::new(delay, Impairment { delay, ..CLEAN });
        let up = world.run_until(10 * SECOND, |world| world.links.iter().all(Link::is_up));
        assert!(up.is_some_and(|us| us < 5 * delay + 100_000), "{delay} µs each way: {up:?}");
    }
    // Further away nobody is reached.
    let mut world = World::new(1, Impairment { delay: 600_000, ..CLEAN });
    assert_eq!(world.run_until(10 * SECOND, |world| world.links.iter().any(Link::is_up)), None);
}

#[test]
fn the_delay_of_flow_is_measured_and_added_delay_is_seen() {
    for (delay, added) in [(500, 0), (500, 50_000), (20_000, 50_000)] {
        let mut world = World::new(3, Impairment { delay: delay + added, ..CLEAN });
        world.run(2 * SECOND);
        for link in &world.links {
            let measured = u64::from(link.delay_us().unwrap());
            // Half of what the sender waited after the newest stamp came, a packet period at the most, and of a step of 1 ms.
            assert!(
                (delay + added..=delay + added + PERIOD / 2 + 1_000).contains(&measured),
                "{delay} + {added}: {measured}"
            );
        }
    }
}

/// The delay grows by `slope` µs each ms, from both peers or from one; what happens until it is `end` µs.
fn stretched(slope: u64, end: u64, both: bool) -> World {
    let mut world = World::engaged(4);
    world.notices = [vec![], vec![]];
    while world.impairment.delay < end {
        world.impairment.delay += slope;
        if !both {
            // Only what goes to peer 1 is stretched.
            world.ahead[0] = world.impairment.delay;
        }
        world.step();
    }
    world
}

#[test]
fn delay_that_grows_within_a_session_is_refused() {
    for (slope, both) in [(50, true), (500, true), (50, false), (500, false)] {
        let mut world = stretched(slope, 1_000_000, both);
        let old = world.links[1].counts().old;
        assert!(old > 0, "slope {slope}, both {both}: {:?}", world.links[1].counts());
        let told = world.notices[1].iter().position(|notice| matches!(notice, Notice::Old(250_000..)));
        let faded = world.notices[1].iter().position(|notice| *notice == Notice::Fading);
        assert!(told.is_some_and(|told| faded.is_some_and(|faded| told <= faded + 1)), "{:?}", world.notices[1]);
        let flows = world.flows[1].len();
        world.run(2 * SECOND);
        assert_eq!(world.flows[1].len(), flows, "slope {slope}, both {both}");
        assert!(!matches!(world.links[1].stage(), Stage::Running | Stage::Fading));
        // As soon as the way is short again, so is the delay.
        world.impairment.delay = 500;
        world.ahead = [0; 2];
        assert!(world.run_until(3 * SECOND, World::is_engaged).is_some(), "{:?}", world.stages());
        assert!(!world.links[1].is_old());
    }
}

#[test]
fn no_flow_is_older_than_twice_the_longest_delay() {
    for within in [20_000, 100_000, 250_000] {
        let mut world = World::engaged(5);
        for peer in 0..2 {
            let fresh = Link::new(config(1 + peer as u8, 2 - peer as u8, [9 + peer as u8; 32])).unwrap();
            world.links[peer] = fresh.within(within);
        }
        world.impairment = CLEAN;
        world.run(SECOND);
        world.flows = [vec![], vec![]];
        let mut oldest = 0;
        while world.impairment.delay < 600_000 {
            world.impairment.delay += 100;
            world.step();
            // A flow says the millisecond in which it was made.
            if let Some(flow) = world.flows[1].drain(..).next_back() {
                oldest = oldest.max(world.now - u64::from(flow.tick) * 1_000);
            }
        }
        let twice = 2 * u64::from(within);
        assert!(oldest <= twice, "within {within} µs: {oldest}");
        assert!(oldest >= twice / 3, "within {within} µs: {oldest}");
    }
}

/// `safety.max_delay_s` goes up to 1 s one way: a session is made, goes on, and hands out flow.
#[test]
fn every_delay_that_is_allowed_has_sessions() {
    for delay in [250_000, 500_000, 800_000, 990_000] {
        let mut world = World::new(11, Impairment { delay, ..CLEAN });
        for (peer, link) in world.links.iter_mut().enumerate() {
            let peer = peer as u8;
            *link = Link::new(config(1 + peer, 2 - peer, [9 + peer; 32])).unwrap().within(1_000_000);
        }
        assert!(world.run_until(8 * SECOND, World::is_engaged).is_some(), "{delay} µs: {:?}", world.stages());
        world.flows = [vec![], vec![]];
        world.run(5 * SECOND);
        let due = 5 * SECOND / PERIOD;
        let came = world.flows.each_ref().map(Vec::len);
        assert!(came.iter().all(|came| *came as u64 >= due - 2), "{delay} µs: {came:?} of {due}");
    }
}

#[test]
fn what_is_held_for_more_than_a_second_does_not_count_in_a_session_that_goes_on() {
    for (held_us, counts) in [(900_000, true), (1_100_000, false)] {
        let mut world = World::engaged(6);
        // Probes alone, so that the replay window does not decide.
        world.quiet = [true; 2];
        world.run(200_000);
        let now = world.clock(0);
        let mut out = [0; MAX_DATAGRAM];
        let len = world.links[0].send(now, Telemetry::default(), &mut out).unwrap();
        world.run(held_us);
        let now = world.clock(1);
        let taken = world.links[1].receive(now, &mut out[..len]);
        match taken {
            Ok(Some(Message::Telemetry(_))) => assert!(counts),
            Err(Error::Old(age_us)) => assert!(!counts && age_us >= held_us, "{age_us}"),
            other => panic!("{other:?}"),
        }
        assert!(world.links.iter().all(Link::is_up));
    }
}

#[test]
fn a_dead_peer_is_not_kept_alive_by_what_it_said() {
    let mut world = World::engaged(7);
    world.log = Some([vec![], vec![]]);
    world.cut[1] = true;
    world.run(90_000);
    // Peer 0 is dead. What it said last comes a datagram every 80 ms.
    world.off[0] = true;
    let mut held = world.log.take().unwrap()[0].clone();
    let (now, mut out) = (world.clock(0), [0; MAX_DATAGRAM]);
    for _ in 0..40 {
        let len = world.links[0].send(now, Telemetry::default(), &mut out).unwrap();
        held.push(out[..len].to_vec());
    }
    let mut lasted_us = 0;
    for mut datagram in held.iter().cycle().take(60).cloned() {
        let now = world.clock(1);
        let _ = world.links[1].receive(now, &mut datagram);
        world.run(80_000);
        lasted_us += if world.links[1].is_up() { 80_000 } else { 0 };
    }
    assert!((100_000..=1_300_000).contains(&lasted_us), "{lasted_us} µs");
    assert!(!world.links[1].is_up());
}
