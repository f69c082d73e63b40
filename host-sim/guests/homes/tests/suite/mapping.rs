//! A port asked of a router that is written here from the RFCs, and of routers that lie, refuse, forget and are silent.

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use cohold_homes::mapping::Mapping;
use cohold_protocol::key::Key;

const ROUTER: &str = "192.168.1.1:5351";
const OWN: &str = "192.168.1.10:40000";
const OUTER: [u8; 4] = [203, 0, 113, 11];

/// What a router makes of a question.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Pcp,
    /// Knows NAT-PMP alone, and says so to who asks in PCP.
    NatPmp,
    /// The same, and says nothing to who asks in PCP.
    MuteNatPmp,
}

struct Router {
    kind: Kind,
    result: u8,
    life_s: u32,
    /// The port that is passed on, and until when it was asked for.
    passes: Option<u16>,
    asked: usize,
}

impl Router {
    fn new(kind: Kind) -> Self {
        Self { kind, result: 0, life_s: 600, passes: None, asked: 0 }
    }

    fn answer(&mut self, question: &[u8]) -> Option<Vec<u8>> {
        self.asked += 1;
        let epoch = 1000_u32.to_be_bytes();
        match (self.kind, question) {
            // RFC 6887, figure 2 and 10: version, R and opcode, reserved, life, address; then the MAP opcode's own.
            (Kind::Pcp, [2, 1, ..]) if question.len() == 60 => {
                assert_eq!(question[8..24], [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255, 192, 168, 1, 10], "its address");
                assert_eq!((question[36], &question[40..42]), (17, &40_000_u16.to_be_bytes()[..]), "UDP, its port");
                let asked_s = u32::from_be_bytes(question[4..8].try_into().unwrap());
                let life_s = if self.result == 0 { asked_s.min(self.life_s) } else { self.life_s };
                self.passes = (asked_s > 0 && self.result == 0).then_some(51_000);
                let mut answer = vec![2, 0x81, 0, self.result];
                answer.extend(life_s.to_be_bytes());
                answer.extend(epoch);
                answer.extend([0; 12]);
                answer.extend(&question[24..42]);
                answer.extend(51_000_u16.to_be_bytes());
                answer.extend([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 255]);
                answer.extend(OUTER);
                Some(answer)
            }
            (Kind::NatPmp, [2, ..]) => Some([&[0, 0x81, 0, 1][..], &epoch].concat()),
            // RFC 6886, 3.2.
            (Kind::NatPmp | Kind::MuteNatPmp, [0, 0]) => Some([&[0, 128, 0, self.result][..], &epoch, &OUTER].concat()),
            // 3.3: version, opcode, reserved, inner and outer port, life.
            (Kind::NatPmp | Kind::MuteNatPmp, [0, 1, 0, 0, inner_high, inner_low, ..]) if question.len() == 12 => {
                let asked_s = u32::from_be_bytes(question[8..].try_into().unwrap());
                self.passes = (asked_s > 0 && self.result == 0).then_some(51_000);
                let mut answer = [&[0, 129, 0, self.result][..], &epoch, &[*inner_high, *inner_low]].concat();
                answer.extend(51_000_u16.to_be_bytes());
                answer.extend(asked_s.min(self.life_s).to_be_bytes());
                Some(answer)
            }
            _ => None,
        }
    }
}

struct Asks {
    mapping: Mapping,
    start: Instant,
    router: SocketAddr,
}

impl Asks {
    fn new() -> Self {
        let (start, router) = (Instant::now(), ROUTER.parse().unwrap());
        let mapping = Mapping::new(router, OWN.parse().unwrap(), &Key::new([5; 32]), start);
        Self { mapping, start, router }
    }

    fn at(&self, ms: u64) -> Instant {
        self.start + Duration::from_millis(ms)
    }

    /// Each ms of these; what the router answers passes through `path`, which says from where it comes.
    fn run(
        &mut self,
        ms: std::ops::Range<u64>,
        router: &mut Router,
        mut path: impl FnMut(Vec<u8>) -> Vec<(SocketAddr, Vec<u8>)>,
    ) {
        for ms in ms {
            let now = self.at(ms);
            for question in self.mapping.poll(now) {
                for (from, answer) in router.answer(&question).map(&mut path).unwrap_or_default() {
                    self.mapping.hear(now, from, &answer);
                }
            }
        }
    }

    fn straight(&mut self, ms: std::ops::Range<u64>, router: &mut Router) {
        let from = self.router;
        self.run(ms, router, |answer| vec![(from, answer)]);
    }
}

#[test]
fn a_port_is_had_within_a_second_of_a_router_that_speaks_either_protocol() {
    for (kind, by_ms) in [(Kind::Pcp, 1), (Kind::NatPmp, 2), (Kind::MuteNatPmp, 2000)] {
        let (mut asks, mut router) = (Asks::new(), Router::new(kind));
        asks.straight(0..by_ms, &mut router);
        let outer = asks.mapping.outer(asks.at(by_ms));
        assert_eq!(outer, Some("203.0.113.11:51000".parse().unwrap()), "after {by_ms} ms");
        // It is kept for an hour by being renewed, with few questions, and given back at the end.
        let before = router.asked;
        for ms in (by_ms..3_600_000).step_by(100) {
            asks.straight(ms..ms + 1, &mut router);
            assert!(asks.mapping.outer(asks.at(ms)).is_some(), "at {ms} ms");
        }
        assert!((59..=122).contains(&(router.asked - before)), "{} questions in an hour", router.asked - before);
        assert_eq!(router.passes, Some(51_000));
        let last = asks.mapping.goodbye();
        assert_eq!(last.len(), 1);
        router.answer(&last[0]);
        assert_eq!((router.passes, asks.mapping.goodbye().len()), (None, 0));
    }
}

#[test]
fn what_another_than_the_router_says_or_without_the_nonce_is_not_believed() {
    let (mut asks, mut router) = (Asks::new(), Router::new(Kind::Pcp));
    let at = asks.router;
    let elsewhere: [SocketAddr; 2] = [SocketAddr::new(at.ip(), 5350), "192.168.1.66:5351".parse().unwrap()];
    asks.run(0..5000, &mut router, |answer| {
        let mut lies: Vec<_> = elsewhere.iter().map(|from| (*from, answer.clone())).collect();
        // Every bit of kind, nonce, protocol and inner port, and every length that is too short.
        for bit in (0..16).chain(24 * 8..37 * 8).chain(40 * 8..42 * 8) {
            let mut forged = answer.clone();
            forged[bit / 8] ^= 1 << (bit % 8);
            lies.push((at, forged));
        }
        lies.extend((0..60).map(|length| (at, answer[..length].to_vec())));
        lies
    });
    assert_eq!(asks.mapping.outer(asks.at(5000)), None);
    assert_eq!(asks.mapping.refused, None);
    // An hour later the router is heard at last.
    asks.straight(3_600_000..3_665_000, &mut router);
    assert!(asks.mapping.outer(asks.at(3_665_000)).is_some());
}

#[test]
fn nat_pmp_is_believed_from_the_router_and_for_the_own_port_alone() {
    let (mut asks, mut router) = (Asks::new(), Router::new(Kind::NatPmp));
    let at = asks.router;
    asks.run(0..60_000, &mut router, |answer| match answer.len() {
        16 => {
            let mut other = answer.clone();
            other[9] ^= 1;
            vec![("192.168.1.66:5351".parse().unwrap(), answer.clone()), (at, other), (at, answer[..15].to_vec())]
        }
        _ => vec![(at, answer)],
    });
    assert_eq!(asks.mapping.outer(asks.at(60_000)), None);
}

#[test]
fn a_router_that_says_no_is_asked_once_a_minute_and_a_silent_one_ever_more_seldom() {
    for (kind, result) in [(Kind::Pcp, 2), (Kind::NatPmp, 2)] {
        let (mut asks, mut router) = (Asks::new(), Router::new(kind));
        router.result = result;
        for ms in (0..600_000).step_by(50) {
            asks.straight(ms..ms + 1, &mut router);
        }
        assert_eq!((asks.mapping.outer(asks.at(600_000)), asks.mapping.refused), (None, Some(2)));
        assert!((10..=24).contains(&router.asked), "{} questions", router.asked);
        assert!(asks.mapping.goodbye().is_empty(), "there is nothing to give back");
        // It is a yes that counts in the end.
        router.result = 0;
        asks.straight(600_000..662_000, &mut router);
        assert!(asks.mapping.outer(asks.at(662_000)).is_some() && asks.mapping.refused.is_none());
    }
    let (mut asks, mut sent) = (Asks::new(), 0);
    for ms in (0..600_000).step_by(50) {
        sent += asks.mapping.poll(asks.at(ms)).len();
    }
    assert!((10..=40).contains(&sent), "{sent} datagrams to nobody in ten minutes");
}

#[test]
fn a_life_of_nothing_is_a_no_and_one_that_is_over_is_over() {
    let (mut asks, mut router) = (Asks::new(), Router::new(Kind::Pcp));
    router.life_s = 0;
    asks.straight(0..1000, &mut router);
    assert_eq!(asks.mapping.outer(asks.at(1000)), None);
    let (mut asks, mut router) = (Asks::new(), Router::new(Kind::Pcp));
    router.life_s = 20;
    asks.straight(0..1, &mut router);
    assert!(asks.mapping.outer(asks.at(19_999)).is_some() && asks.mapping.outer(asks.at(20_001)).is_none());
}

#[test]
fn a_router_that_has_begun_anew_passes_the_port_on_again_within_a_minute() {
    let (mut asks, mut router) = (Asks::new(), Router::new(Kind::Pcp));
    asks.straight(0..1, &mut router);
    router.passes = None;
    asks.straight(1..60_001, &mut router);
    assert_eq!((router.passes, router.asked), (Some(51_000), 2));
}

#[test]
fn addresses_that_are_nobodys_are_no_candidates() {
    for ip in [[0, 0, 0, 0], [224, 0, 0, 1], [255, 255, 255, 255], [127, 0, 0, 1]] {
        let (mut asks, mut router) = (Asks::new(), Router::new(Kind::Pcp));
        let at = asks.router;
        asks.run(0..5000, &mut router, |mut answer| {
            answer[56..].copy_from_slice(&ip);
            vec![(at, answer)]
        });
        assert_eq!(asks.mapping.outer(asks.at(5000)), None, "{ip:?}");
    }
}

#[test]
fn noise_from_the_router_itself_ends_nothing() {
    let mut rng = 7_u64;
    let mut next = || {
        rng = rng.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        rng >> 33
    };
    let mut asks = Asks::new();
    for round in 0..200_000 {
        let now = asks.at(round / 10);
        asks.mapping.poll(now);
        let mut bytes: Vec<u8> = (0..next() % 70).map(|_| next() as u8).collect();
        if let [version, kind, ..] = &mut bytes[..] {
            (*version, *kind) = ([0, 2][next() as usize % 2], [0, 0x80, 0x81][next() as usize % 3]);
        }
        asks.mapping.hear(now, asks.router, &bytes);
    }
}
