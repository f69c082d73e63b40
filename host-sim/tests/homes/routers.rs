//! Behind routers: which path is found, how soon, and what a change costs. Each makes its own namespaces, which needs root, `ip` and `nft`: `cargo xtask test --only homes`
//! runs them, and says so where it cannot.

use std::path::PathBuf;
use std::process::Command;
use std::time::Duration;

use super::lab::{BESIDE, Lab, PLACE, Router};
use super::peers::{COHOLD, Running, Told, peer};

/// A packet each tick for so long.
const SECONDS: u32 = 10;

/// A key file of a test's own.
fn key(name: &str) -> PathBuf {
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("homes-routers-{name}.key"));
    let _ = std::fs::remove_file(&path);
    assert!(Command::new(COHOLD).args(["key", "generate"]).arg(&path).output().expect("it runs").status.success());
    path
}

/// Two peers at their homes; meanwhile something happens there.
fn meet(lab: &mut Lab, name: &str, seconds: u32, meanwhile: impl FnOnce(&mut Lab)) -> [Told; 2] {
    let key = key(name);
    let key = key.to_str().expect("a name");
    let ends = [("a", "1"), ("b", "2")]
        .map(|(home, number)| lab.peer(home, seconds, &["--number", number, "--meet", PLACE, "--key-file", key]));
    meanwhile(lab);
    let told = ends.map(|end| end.report());
    for told in &told {
        eprintln!("{name}: {:?} {}", told.ways, told.report["path"]);
        assert!(told.report["fault"].is_null(), "{}", told.report);
        assert!(told.number("/ticks") >= f64::from(seconds) * 1e3 - 1.0, "{}", told.report);
    }
    told
}

fn is_direct(told: &Told) {
    assert!(told.first(&["relayed", "both"]).is_some_and(|at| at <= 5.0), "{:?}", told.ways);
    assert!(told.first(&["both", "direct"]).is_some_and(|at| at <= 3.0), "{:?}", told.ways);
    assert!(matches!(told.way(), "direct" | "both"), "{:?}", told.ways);
    assert_eq!(told.report["path"]["lan"], false);
    assert_eq!(told.number("/datagrams_missing"), 0.0, "{}", told.report);
}

fn is_relayed(told: &Told) {
    assert!(told.first(&["relayed"]).is_some_and(|at| at <= 5.0), "{:?}", told.ways);
    assert!(told.first(&["both", "direct"]).is_none() && told.way() == "relayed", "{:?}", told.ways);
    assert_eq!(told.number("/datagrams_missing"), 0.0, "{}", told.report);
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn routers_that_keep_ports_let_flow_go_directly() {
    let mut lab = Lab::new([Router::Kept; 2], [false; 2]);
    meet(&mut lab, "kept", SECONDS, |_| {}).iter().for_each(is_direct);
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn where_either_router_gives_ports_at_random_the_relay_carries() {
    for (name, routers) in [("symmetric", [Router::Symmetric; 2]), ("one-symmetric", [Router::Kept, Router::Symmetric])]
    {
        let mut lab = Lab::new(routers, [false; 2]);
        meet(&mut lab, name, SECONDS, |_| {}).iter().for_each(is_relayed);
    }
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn a_router_that_takes_a_strangers_datagram_for_its_own_leaves_it_to_the_relay_or_not_and_says_which() {
    let mut lab = Lab::new([Router::Open; 2], [false; 2]);
    for told in meet(&mut lab, "open", SECONDS, |_| {}) {
        let heard = told.number("/path/direct/datagrams") > 0.0;
        assert_eq!(heard, told.first(&["both", "direct"]).is_some(), "what is said is what was: {}", told.report);
        assert_eq!(told.number("/datagrams_missing"), 0.0, "{}", told.report);
    }
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn ipv6_leads_past_routers_that_give_ports_at_random() {
    let mut lab = Lab::new([Router::Symmetric; 2], [true; 2]);
    meet(&mut lab, "v6", SECONDS, |_| {}).iter().for_each(is_direct);
    // On one side only it helps nobody, and harms nobody.
    let mut lab = Lab::new([Router::Kept; 2], [true, false]);
    meet(&mut lab, "v6-one", SECONDS, |_| {}).iter().for_each(is_direct);
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn a_port_that_a_router_was_told_to_pass_on_is_enough() {
    let lab = Lab::new([Router::Mapped, Router::Symmetric], [false; 2]);
    let key = key("mapped");
    let key = key.to_str().expect("a name");
    let meets = ["--meet", PLACE, "--key-file", key];
    let one = lab.peer("a", SECONDS, &[&meets[..], &["--number", "1", "--mapped", "203.0.113.11:40000"]].concat());
    let two = lab.peer("b", SECONDS, &[&meets[..], &["--number", "2"]].concat());
    [one, two].map(Running::report).iter().for_each(is_direct);
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn behind_one_router_that_keeps_them_apart_they_meet_by_its_hairpin_or_by_the_relay() {
    let key = key("hairpin");
    let key = key.to_str().expect("a name");
    let meets = ["--meet", PLACE, "--key-file", key];
    for hairpin in [true, false] {
        let lab = Lab::behind_one(hairpin);
        let of = |home, number, outer| {
            lab.peer(home, SECONDS, &[&meets[..], &["--number", number, "--mapped", outer]].concat())
        };
        let ends = [of("a", "1", "203.0.113.11:40001"), of("b", "2", "203.0.113.11:40002")];
        ends.map(Running::report).iter().for_each(if hairpin { is_direct } else { is_relayed });
    }
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn a_path_that_is_cut_and_given_back_changes_the_flow_twice() {
    let mut lab = Lab::new([Router::Kept; 2], [false; 2]);
    let told = meet(&mut lab, "cut", 20, |lab| {
        std::thread::sleep(Duration::from_secs(7));
        lab.cut(true);
        std::thread::sleep(Duration::from_secs(4));
        lab.cut(false);
    });
    for told in told {
        let relayed = told.ways.iter().position(|(at, way)| *at > 5.0 && way == "relayed");
        let after = relayed.and_then(|at| told.ways.get(at + 1)).map(|(_, way)| way.as_str());
        assert!(relayed.is_some() && after == Some("both"), "{:?}", told.ways);
        assert!(matches!(told.way(), "direct" | "both"), "{:?}", told.ways);
        // 15 ms until it is noticed, and what was under way; a busy machine makes more of it.
        let missing = told.number("/datagrams_missing");
        assert!(missing <= 250.0, "{missing} missing of one cut: {}", told.report);
    }
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn a_router_that_forgets_is_found_again() {
    let mut lab = Lab::new([Router::Kept; 2], [false; 2]);
    let told = meet(&mut lab, "forgets", 15, |lab| {
        std::thread::sleep(Duration::from_secs(7));
        lab.forgets();
    });
    for told in told {
        assert!(matches!(told.way(), "direct" | "both"), "{:?}", told.ways);
        let missing = told.number("/datagrams_missing");
        assert!(missing <= 1000.0, "{missing} missing of a line that was down: {}", told.report);
    }
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn a_meeting_place_that_is_killed_ends_no_direct_flow_and_is_found_again_by_a_relayed_one() {
    let kill = |lab: &mut Lab| {
        std::thread::sleep(Duration::from_secs(7));
        lab.closes();
        std::thread::sleep(Duration::from_millis(300));
        lab.opens();
    };
    let mut lab = Lab::new([Router::Kept; 2], [false; 2]);
    meet(&mut lab, "killed-direct", 12, kill).iter().for_each(is_direct);
    let mut lab = Lab::new([Router::Symmetric; 2], [false; 2]);
    for told in meet(&mut lab, "killed-relayed", 12, kill) {
        assert_eq!(told.way(), "relayed", "{:?}", told.ways);
        let missing = told.number("/datagrams_missing");
        assert!((200.0..=2000.0).contains(&missing), "{missing} missing of half a second or so: {}", told.report);
    }
}

#[test]
#[ignore = "needs root, ip and nft: cargo xtask test --only homes"]
fn a_board_on_a_network_of_its_own_is_reached_through_the_pc_beside_it() {
    for (name, routers) in [("board-kept", [Router::Kept; 2]), ("board-symmetric", [Router::Symmetric; 2])] {
        let mut lab = Lab::new(routers, [false; 2]);
        lab.puts_a_board_beside();
        let (key, [board, pc]) = (key(name), BESIDE);
        let key = key.to_str().expect("a name");
        let mut bridge = lab.exec("a");
        bridge.args([
            "board",
            "bridge",
            "--json-lines",
            "--board",
            board,
            "--number",
            "1",
            "--meet",
            PLACE,
            "--key-file",
            key,
        ]);
        let bridge = Running::start(bridge);
        bridge.says("carries board 1");
        let ends = ["--number", "1", "--listen", board, "--connect", pc, "--key-file", key];
        let board = peer(lab.exec("board"), SECONDS, &ends);
        let far = lab.peer("b", SECONDS, &["--number", "2", "--meet", PLACE, "--key-file", key]);
        let [board, far] = [board, far].map(Running::report);
        let is_what = if routers[0] == Router::Kept { is_direct } else { is_relayed };
        is_what(&far);
        for told in [&board, &far] {
            assert!(told.report["fault"].is_null(), "{}", told.report);
            assert!(told.number("/ticks") >= f64::from(SECONDS) * 1e3 - 1.0, "{}", told.report);
            assert_eq!(told.number("/datagrams_missing"), 0.0, "{}", told.report);
        }
        bridge.interrupt();
        let carried = bridge.report();
        eprintln!("{name}: {:?} {}", carried.ways, carried.report);
        let count = |count: &str| carried.number(&format!("/{count}"));
        assert!(count("from_board") > 9999.0 && count("to_board") > 9999.0, "{}", carried.report);
        assert_eq!(["strangers", "other_kinds", "too_long", "over_rate"].map(count), [0.0; 4], "{}", carried.report);
    }
}
