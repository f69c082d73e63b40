use std::net::UdpSocket;
use std::sync::Mutex;

use cohold_live::road::{Change, PathReport, Road, Way};
use cohold_live::verdict::{Measured, Verdict};
use cohold_sim::scenes;

use super::*;

type One = Remote<1, { cohold_sim::AXES }>;

fn pair(scene: &str, to: &str) -> [One; 2] {
    ends([scene, to].map(still))
}

/// The scene of this name, whose users do nothing here.
fn still(name: &str) -> Scene {
    let mut scene = scenes::load(cohold_sim::Laws::built_in(), name).expect("a scene");
    scene.users = Default::default();
    scene
}

fn ends<const SHARED: usize, const N: usize>([here, there]: [Scene; 2]) -> [Remote<SHARED, N>; 2]
where
    f32: Builds<SHARED, N>,
{
    let key = || Key::new([7; Key::LEN]);
    let listening = End::listening("127.0.0.1:0".parse().expect("an address"), key(), 1).expect("a socket");
    let joining = End::joining(listening.endpoint.address, key(), 2).expect("a socket");
    [Remote::new(here, listening).expect("an end"), Remote::new(there, joining).expect("an end")]
}

/// Both ends tick by the clock, each hand where it is wanted, until `done`, and no longer than half a minute.
#[track_caller]
fn until<const SHARED: usize, const N: usize>(
    ends: &mut [Remote<SHARED, N>; 2],
    wanted: [Option<f64>; 2],
    done: impl Fn(&[Sample; 2]) -> bool,
) -> [Sample; 2]
where
    f32: Builds<SHARED, N>,
{
    let start = Instant::now();
    loop {
        let samples = [0, 1].map(|at| {
            let end = &mut ends[at];
            end.point(at, wanted[at].map(|at| [at; 3]), end.restarts);
            end.step().expect("a tick")
        });
        if done(&samples) {
            return samples;
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{samples:?}");
        std::thread::sleep(Duration::from_micros(900));
    }
}

const DEVICE: usize = 2;
const OBJECT: usize = 4;
const HAND: usize = 12;

/// The hands of two processes pull on one chain of springs (`play_session.rs`), and each end knows where the other copy is.
#[test]
fn two_ends_hold_one_object() {
    let mut ends = pair("any-network", "any-network");
    assert_eq!(ends[0].standing().modes, [WAITS; 2]);
    until(&mut ends, [None; 2], |samples| {
        samples.iter().all(|sample| sample[OBJECT].is_finite() && sample[OBJECT + 1].is_finite())
    });
    until(&mut ends, [Some(0.02), Some(0.0)], |[one, two]| {
        // The line is a spring as well, of the round trip over its impedance, which is short on loopback.
        let stiffness = 1.0 / (2.0 / 200.0 + 2.0 / 1000.0 + 2.0 / 10000.0);
        (f64::from(one[HAND]) - 0.02 * stiffness).abs() < 0.1
            && (f64::from(two[HAND + 1]) + 0.02 * stiffness).abs() < 0.1
    });
    let [one, two] = until(&mut ends, [Some(0.02), Some(0.0)], |[one, two]| {
        // What was reported to each of the other's copy is where that is, once nothing moves.
        (one[OBJECT + 1] - two[OBJECT + 1]).abs() < 5e-4 && (two[OBJECT] - one[OBJECT]).abs() < 5e-4
    });
    assert!((one[DEVICE] - one[DEVICE + 1]).abs() > 0.002 && two[DEVICE] > two[DEVICE + 1], "{one:?} {two:?}");
    assert_eq!(ends.each_ref().map(|end| end.standing().modes), [[ARMED; 2]; 2]);
}

/// A stop holds although packets come, a start lets go of the hand; the other end hears of both.
#[test]
fn a_stop_holds_until_it_is_taken_back() {
    let mut ends = pair("any-network", "any-network");
    until(&mut ends, [None; 2], |samples| samples.iter().all(|sample| sample[OBJECT + 1].is_finite()));
    until(&mut ends, [Some(0.02), None], |[one, _]| one[HAND] > 0.3);
    ends[0].command(Command::Stop).expect("it stops");
    let begin = ends[0].tick;
    until(&mut ends, [Some(0.02), None], |[one, _]| one[19] >= 0.0 && one[DEVICE].is_finite() && one[10] == 0.0);
    for _ in 0..1500 {
        until(&mut ends, [None; 2], |_| true);
    }
    assert!(ends[0].tick > begin + 1000);
    assert_eq!([ends[0].standing().modes[0], ends[1].standing().modes[0]], [OFF; 2]);
    ends[0].command(Command::Start).expect("it starts");
    until(&mut ends, [None; 2], |samples| samples.iter().all(|sample| sample[OBJECT + 1].is_finite()));
    let start = Instant::now();
    while ends[1].standing().modes != [ARMED; 2] || ends[0].standing().modes != [ARMED; 2] {
        until(&mut ends, [None; 2], |_| true);
        assert!(start.elapsed() < Duration::from_secs(30));
    }
    assert_eq!(ends[0].restarts, 1);
}

/// Who was configured with another scene is not let in.
#[test]
fn other_settings_are_refused() {
    let mut ends = pair("any-network", "matched-line");
    for _ in 0..500 {
        until(&mut ends, [None; 2], |_| true);
    }
    assert_eq!(ends[0].standing().modes, [WAITS; 2]);
    assert!(ends.iter().any(|end| end.peer.node.line.link.refused().is_some()));
}

/// In the plane hands hold one object along both axes; of the second each end knows what it believes of the other, and says no more.
#[test]
fn two_ends_hold_one_object_in_the_plane() {
    let plane = || {
        let mut scene = still("any-network");
        (scene.peer.axis.count, scene.peer.axis.shared) = (2, 2);
        scene
    };
    let mut ends: [Remote<2, 2>; 2] = ends([plane(), plane()]);
    // Behind the columns of one axis.
    const ACROSS: usize = 24;
    until(&mut ends, [None; 2], |samples| samples.iter().all(|sample| sample[OBJECT + 1].is_finite()));
    let stiffness = 1.0 / (2.0 / 200.0 + 2.0 / 1000.0 + 2.0 / 10000.0);
    let near = |pull: f32| (f64::from(pull) - 0.02 * stiffness).abs() < 0.1;
    let [one, two] = until(&mut ends, [Some(0.02), Some(0.0)], |[one, two]| {
        [0, ACROSS].iter().all(|axis| near(one[axis + HAND]) && near(-two[axis + HAND + 1]))
    });
    assert!(one[ACROSS + OBJECT].is_finite() && one[ACROSS + OBJECT + 1].is_nan(), "{one:?}");
    // Peer 2 decodes where copy 1 is.
    assert!((two[ACROSS + 7] - one[ACROSS + OBJECT]).abs() < 1e-3, "{one:?} {two:?}");
}

/// A road to one place, whose way changes with time: to nowhere, by a relay, then within a local network.
#[derive(Debug)]
struct Changing {
    to: SocketAddr,
    began: Instant,
    told: Mutex<Way>,
}

impl Changing {
    fn way(&self) -> Way {
        match self.began.elapsed().as_millis() {
            0..100 => Way::Nowhere,
            100..1500 => Way::Relayed,
            _ => Way::Direct,
        }
    }
}

impl Road for Changing {
    fn address(&self) -> SocketAddr {
        self.to
    }

    fn poll(&self, _: &UdpSocket) {}

    fn sift(&self, _: &mut ReceivedBatch, _: &UdpSocket) {}

    fn release(&self, _: &mut ReceivedBatch) {}

    fn say(&self, datagram: &[u8], each: &mut dyn FnMut(SocketAddr, &[u8])) -> bool {
        let goes = self.way() != Way::Nowhere;
        if goes {
            each(self.to, datagram);
        }
        goes
    }

    fn take_change(&self) -> Option<Change> {
        let mut told = self.told.lock().expect("nobody panics");
        let way = self.way();
        (std::mem::replace(&mut *told, way) != way).then(|| Change { at: Instant::now(), way, lan: way == Way::Direct })
    }

    fn report(&self) -> PathReport {
        let way = self.way();
        PathReport { way, lan: way == Way::Direct, ..PathReport::default() }
    }
}

/// The road of the end that has this socket.
#[derive(Debug)]
struct Known {
    socket: UdpSocket,
    to: SocketAddr,
}

impl Roads for Known {
    fn place(&self) -> SocketAddr {
        self.to
    }

    fn open(&self, _: Option<SocketAddr>, _: Key, _: u8) -> Result<Endpoint, cohold_live::Error> {
        let road = Changing { to: self.to, began: Instant::now(), told: Mutex::default() };
        Endpoint::on_road(self.socket.try_clone().expect("a socket"), Arc::new(road))
    }
}

/// Windows are told which path a line takes, and what it can hold.
#[test]
fn windows_are_told_of_the_path_and_of_what_the_line_can_hold() {
    let sockets = [(); 2].map(|()| UdpSocket::bind("127.0.0.1:0").expect("a socket"));
    let places = sockets.each_ref().map(|socket| socket.local_addr().expect("an address"));
    let [one, two] = sockets;
    let roads = [Known { socket: one, to: places[1] }, Known { socket: two, to: places[0] }];
    {
        let mut number = 0;
        let mut ends = roads.map(|road| {
            number += 1;
            let end = End::meeting(&road, Key::new([7; Key::LEN]), number, Some("012 345".into())).expect("a socket");
            One::new(still("any-network"), end).expect("an end")
        });
        let start = Instant::now();
        let mut told = [Vec::new(), Vec::new()];
        let is_told = |news: &Vec<String>| {
            let last = news.last().map(String::as_str).unwrap_or_default();
            last.contains("\"says\":\"LAN") && last.contains("each newton") && last.contains("\"bad\":false")
        };
        while !told.iter().all(is_told) {
            assert!(start.elapsed() < Duration::from_secs(30), "{told:?}");
            for (end, told) in ends.iter_mut().zip(&mut told) {
                end.step().expect("a tick");
                told.extend(end.news());
            }
            std::thread::sleep(Duration::from_micros(900));
        }
        for told in &told {
            assert!(told.iter().all(|news| news.contains("\"code 012 345: compare it aloud")), "{told:?}");
            assert!(told.iter().any(|news| news.contains("\"bad\":true") && news.contains("no path")), "{told:?}");
            assert!(told.iter().any(|news| news.contains("relayed") || news.contains("relay beside it")), "{told:?}");
        }
    }
}

/// Two ends over whose line a judge finds their scene unstable.
fn judged_unstable(unless: Option<&'static str>) -> [One; 2] {
    let key = || Key::new([7; Key::LEN]);
    let scene = || still("any-network");
    let verdict = |measured: Measured| Verdict {
        one_way_ms: measured.one_way_s.map(|s| 1e3 * s),
        stable: Some(false),
        text: "unstable: lower something".to_owned(),
        ..Verdict::default()
    };
    let judge = Judge { find: Arc::new(verdict), unless };
    let listening = End::listening("127.0.0.1:0".parse().expect("an address"), key(), 1).expect("a socket");
    let joining = End::joining(listening.endpoint.address, key(), 2).expect("a socket");
    [listening, joining].map(|end| One::new(scene(), End { judge: Some(judge.clone()), ..end }).expect("an end"))
}

/// Who shares a line over which the scene is unstable is told so, and stays off, whatever a person starts.
#[test]
fn an_end_does_not_arm_where_its_scene_is_unstable_at_the_delays_measured() {
    let mut ends = judged_unstable(Some("say anyway"));
    let news = |end: &mut One| {
        let news: serde_json::Value = serde_json::from_str(&end.news()?).expect("JSON");
        Some(news["path"].clone())
    };
    let mut told = [None, None];
    let start = Instant::now();
    while !told.iter().flatten().all(|told: &serde_json::Value| told["held"] == true) || told.contains(&None) {
        until(&mut ends, [Some(0.02), None], |_| true);
        for (end, told) in ends.iter_mut().zip(&mut told) {
            *told = news(end).or(told.take());
        }
        assert!(start.elapsed() < Duration::from_secs(30), "{told:?}");
    }
    for told in told.into_iter().flatten() {
        let holds = told["holds"].as_str().expect("words");
        assert!(holds.contains("unstable: lower something") && told["bad"] == true, "{told}");
        assert!(told["says"].as_str().is_some_and(|says| says.starts_with("round trip")), "{told}");
    }
    ends[0].command(Command::Start).expect("it starts");
    for _ in 0..1000 {
        until(&mut ends, [Some(0.02), None], |_| true);
        assert!(ends.iter().all(|end| end.peer.node.armed_ticks == 0 && end.standing().modes[end.own] == WAITS));
    }
    let line = ends[0].line().expect("a line");
    assert!(line.path.is_none() && line.verdict.is_some_and(|verdict| verdict.stable == Some(false)));
    assert_eq!(line.verdicts.len(), 1);
}

/// With the leave to, it arms; and a person's stop holds under any verdict.
#[test]
fn an_end_that_is_to_arm_anyway_does_and_stops_when_it_is_told_to() {
    let mut ends = judged_unstable(None);
    let start = Instant::now();
    while ends.each_ref().map(|end| end.standing().modes) != [[ARMED; 2]; 2] {
        until(&mut ends, [None; 2], |_| true);
        assert!(start.elapsed() < Duration::from_secs(30));
    }
    ends[0].command(Command::Stop).expect("it stops");
    for _ in 0..500 {
        until(&mut ends, [None; 2], |_| true);
        assert_eq!(ends[0].standing().modes[0], OFF);
    }
}
