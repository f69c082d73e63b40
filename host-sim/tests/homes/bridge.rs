//! A board behind the PC beside it, as processes on loopback. The board is a peer on a plain socket, which knows the bridge's address and nothing of a meeting.

use std::net::UdpSocket;
use std::time::Duration;

use super::loopback::{cohold, fresh, meet};
use super::peers::{Running, Told, peer};

/// A port that nobody has now.
fn port() -> u16 {
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback");
    socket.local_addr().expect("an address").port()
}

fn key(name: &str) -> String {
    let file = fresh(&format!("bridge-{name}.key"));
    assert!(cohold().args(["key", "generate"]).arg(&file).output().expect("it runs").status.success());
    file.to_str().expect("a name").to_owned()
}

/// A board, and where the PC beside it listens to it.
struct Beside<'a> {
    number: &'static str,
    board: String,
    pc: String,
    key: &'a str,
    place: &'a str,
}

impl<'a> Beside<'a> {
    fn new(number: &'static str, key: &'a str, place: &'a str) -> Self {
        let at = |port| format!("127.0.0.1:{port}");
        Self { number, board: at(port()), pc: at(port()), key, place }
    }

    fn bridge(&self) -> Running {
        let mut command = cohold();
        command.args(["board", "bridge", "--json-lines", "--board", &self.board, "--listen", &self.pc]);
        command.args(["--number", self.number, "--meet", self.place, "--key-file", self.key]);
        let bridge = Running::start(command);
        bridge.says(&format!("carries board {} at {}", self.number, self.board));
        bridge
    }

    fn plays_the_board(&self, seconds: u32) -> Running {
        let ends = ["--number", self.number, "--listen", &self.board, "--connect", &self.pc, "--key-file", self.key];
        peer(cohold(), seconds, &ends)
    }
}

fn held_to_the_end(told: &Told, seconds: u32) {
    assert!(told.report["fault"].is_null() && told.noticed("Engaged").is_some(), "{told:?}");
    assert!(told.noticed("Lost").is_none_or(|at| at > f64::from(seconds)), "{told:?}");
    assert!(told.number("/ticks") >= f64::from(seconds) * 1e3 - 1.0, "{}", told.report);
    assert_eq!(told.number("/datagrams_refused"), 0.0, "{}", told.report);
}

#[test]
fn a_board_and_a_peer_far_away_hold_one_object_and_a_stranger_beside_the_board_changes_nothing() {
    let ((meet, place), key) = (meet("127.0.0.1:0"), key("one"));
    let beside = Beside::new("1", &key, &place);
    let bridge = beside.bridge();
    let board = beside.plays_the_board(5);
    let far = peer(cohold(), 5, &["--number", "2", "--meet", &place, "--key-file", &key]);
    let stranger = UdpSocket::bind("127.0.0.1:0").expect("a socket on loopback");
    for _ in 0..100 {
        stranger.send_to(&[3; 88], &beside.pc).expect("it is sent");
        std::thread::sleep(Duration::from_millis(10));
    }
    let told = [board.report(), far.report()];
    told.iter().for_each(|told| held_to_the_end(told, 5));
    // The board has no path but its PC; the peer far away has one, and it becomes direct.
    assert!(told[0].report["path"].is_null(), "{}", told[0].report);
    assert!(told[1].first(&["both", "direct"]).is_some_and(|at| at < 8.0), "{:?}", told[1].ways);
    bridge.interrupt();
    let carried = bridge.report();
    let count = |name: &str| carried.number(&format!("/{name}"));
    assert!(count("from_board") >= 4999.0 && count("to_board") >= 4999.0, "{}", carried.report);
    assert_eq!(["strangers", "other_kinds", "too_long", "over_rate"].map(count), [100.0, 0.0, 0.0, 0.0]);
    assert!(carried.first(&["both", "direct"]).is_some() && count("arrivals") == 1.0, "{}", carried.report);
    meet.kill();
}

#[test]
fn two_boards_behind_a_pc_each_outlive_one_of_the_pcs() {
    let ((meet, place), key) = (meet("127.0.0.1:0"), key("two"));
    let ends = ["1", "2"].map(|number| Beside::new(number, &key, &place));
    let [first, second] = ends.each_ref().map(Beside::bridge);
    let boards = ends.each_ref().map(|end| end.plays_the_board(8));
    std::thread::sleep(Duration::from_secs(5));
    first.kill();
    std::thread::sleep(Duration::from_millis(300));
    let again = ends[0].bridge();
    // What the boards miss is less than safety.fade_s of the scene, and both go on holding.
    boards.map(Running::report).iter().for_each(|told| held_to_the_end(told, 8));
    for bridge in [again, second] {
        bridge.interrupt();
        let carried = bridge.report();
        assert!(carried.number("/to_board") > 1000.0 && carried.number("/from_board") > 1000.0, "{}", carried.report);
        assert!(matches!(carried.way(), "both" | "direct" | "relayed" | "nowhere"), "{}", carried.report);
    }
    meet.kill();
}

#[test]
fn what_makes_no_bridge_is_refused_in_one_line() {
    let key = key("refused");
    let operator = fresh("bridge-operator.key");
    assert!(
        cohold().args(["key", "generate", "--operator"]).arg(&operator).output().expect("it runs").status.success()
    );
    let operator = operator.to_str().expect("a name");
    let whole = |board, listen, key| {
        ["--board", board, "--listen", listen, "--number", "1", "--meet", "127.0.0.1:9", "--key-file", key]
    };
    for (words, says) in [
        (whole("192.168.77", "127.0.0.1:0", &key), "192.168.77 is no address: it must be like 192.168.77.1"),
        (whole("::1", "127.0.0.1:0", &key), "one is IPv6 and the other IPv4"),
        (whole("127.0.0.1:7701", "0.0.0.0:7701", &key), "is where this end listens itself"),
        (whole("127.0.0.1", "127.0.0.1:0", operator), "operator"),
        (whole("127.0.0.1", "127.0.0.1:0", "none.key"), "none.key"),
    ] {
        let output = cohold().args(["board", "bridge"]).args(words).output().expect("it runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(says) && said.lines().count() == 1, "{said}");
    }
    let output =
        cohold().args(["board", "bridge", "--board", "127.0.0.1", "--key-file", &key, "--number", "3"]).output();
    let said = String::from_utf8_lossy(&output.expect("it runs").stderr).into_owned();
    assert!(said.contains("--number 3 is not allowed"), "{said}");
}
