//! A program in another language, written from protocol/FORMAT.md alone, is the other end of what a user runs (protocol/tests/inside/peer.py), or
//! attacks a meeting (thief.py beside it), or is a board (board.py). All need Python 3 and nothing else.

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use crate::peers::{Running, Told};
use crate::program::{Keys, cohold, free, in_python, report};
use crate::static_scene::TWO_ROOMS;

/// What the program in Python says for so many seconds.
#[derive(Clone, Copy)]
enum Says {
    Flow,
    /// Flow, and with each a message that no honest end would say, from this seed.
    Mutated(u32, f64),
    Asks,
}

/// A program beside this format's tests, with what it is told.
fn started(program: &str, told: &Value) -> Command {
    in_python(&Path::new("../protocol/tests/inside").join(program), told)
}

/// The program in Python as number `from` of this line, from one address to another.
fn python(key: &str, [from, to]: [u8; 2], line: u32, [listen, connect]: [&str; 2], says: Says) -> Child {
    let port = |address: &str| address.rsplit(':').next().and_then(|port| port.parse::<u16>().ok()).expect("a port");
    let (seconds, ask, mutate) = match says {
        Says::Flow => (2.5, false, 0),
        Says::Mutated(seed, seconds) => (seconds, false, seed),
        Says::Asks => (2.5, true, 0),
    };
    let told = json!({
        "key": key, "from": from, "to": to, "line": line, "listen": port(listen), "connect": port(connect), "seconds": seconds, "ask": ask,
        "mutate": mutate,
    });
    started("peer.py", &told).spawn().expect("these tests need Python 3")
}

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key} in {document}"))
}

/// What was reported of an end, in order.
fn notices(of: &Value) -> Vec<&str> {
    of["notices"].as_array().expect("a list").iter().filter_map(|one| one["notice"].as_str()).collect()
}

/// Flow both ways for a while, and a goodbye.
fn was_there(of: &Value, python: &Value) {
    assert_eq!(python["confirmed"], true, "{python}");
    assert!(number(python, "flows") > 50.0 && number(python, "replies") > 10.0, "{python}");
    let told = notices(of);
    for notice in ["Joined", "Engaged", "Disengaged", "Lost"] {
        assert!(told.contains(&notice), "{notice} is missing in {of}");
    }
    assert!(number(of, "datagrams_taken") > 100.0, "{of}");
}

#[test]
fn a_peer_meets_it() {
    let (keys, own, other) = (Keys::new("python-peer", 0), free(), free());
    let key = keys.file(0);
    // A packet every 8 ms, which Python keeps up with.
    let peer = cohold(&["peer", "--json", "--number", "1", "--listen", &own, "--connect", &other, "--seconds", "8"])
        .args(["--scene", "hub", "--key-file", &key])
        .spawn()
        .expect("cohold runs");
    let python = report(python(&key, [2, 1], 0, [&other, &own], Says::Flow));
    was_there(&report(peer), &python);
}

#[test]
fn a_hub_meets_two_of_it() {
    let (keys, hub, others) = (Keys::new("python-hub", 2), free(), [free(), free()]);
    let running = cohold(&[
        "shared",
        "hub",
        "--json",
        "--users",
        "2",
        "--listen",
        &hub,
        "--seconds",
        "8",
        "--key-file",
        &keys.file(0),
    ])
    .spawn()
    .expect("cohold runs");
    let one = python(&keys.file(1), [1, 2], 0, [&others[0], &hub], Says::Flow);
    let two = python(&keys.file(2), [2, 1], 0, [&others[1], &hub], Says::Flow);
    let (ends, hub) = ([one, two].map(report), report(running));
    (0..2).for_each(|line| was_there(&hub["lines"][line], &ends[line]));
}

#[test]
fn a_server_gives_it_the_whole_world() {
    let (keys, address, other) = (Keys::new("python-server", 3), free(), free());
    let server = ["shared", "world", "serve", "--json", "--world", TWO_ROOMS, "--listen", &address, "--seconds", "8"];
    let running = cohold(&server).args(["--key-file", &keys.file(0)]).spawn().expect("cohold runs");
    let (python, server) = (report(python(&keys.file(3), [0, 1], 3, [&other, &address], Says::Asks)), report(running));
    assert_eq!(python["confirmed"], true, "{python}");
    assert_eq!(
        (&python["objects"], &python["computed"], &python["world"]),
        (&json!(7), &server["world"], &server["world"])
    );
    let counts = &server["counts"];
    assert_eq!((number(&server, "clients"), number(counts, "refused")), (1.0, 0.0), "{server}");
    assert!(number(counts, "asks") > 50.0 && number(counts, "parts") > 50.0, "{server}");
}

/// For how long the ends below say what is mutated, s: ten minutes with `MUTATED_SECONDS=600`.
fn mutated_s() -> f64 {
    std::env::var("MUTATED_SECONDS").map_or(2.5, |seconds| seconds.parse().expect("MUTATED_SECONDS is a number"))
}

/// What a process that ends by itself printed, whether a fault has stopped it or not, and how much memory it had after two seconds
/// and at most, bytes.
fn watched(mut child: Child) -> (Value, [u64; 2]) {
    let resident = |id: u32| {
        let pages = std::fs::read_to_string(format!("/proc/{id}/statm")).ok()?;
        Some(4096 * pages.split(' ').nth(1)?.parse::<u64>().ok()?)
    };
    let mut seen = Vec::new();
    while child.try_wait().expect("it is a child").is_none() {
        seen.extend(resident(child.id()).filter(|bytes| *bytes > 0));
        std::thread::sleep(Duration::from_millis(100));
    }
    // It has met the other end by then.
    let early = seen[20.min(seen.len() - 1)];
    let output = child.wait_with_output().expect("it has ended");
    assert!(matches!(output.status.code(), Some(0 | 1)), "{}", String::from_utf8_lossy(&output.stderr));
    let said = serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else");
    (said, [early, seen.into_iter().max().expect("it ran")])
}

/// An end that has the key seals flows with numbers that are none or far too large, and messages with bits turned, cut, grown or made up (issue 52).
/// The peer that holds an object with it presses its hand with no more than `safety.max_force_n`, and takes no memory for it.
#[test]
fn a_peer_is_not_moved_by_what_no_honest_end_says() {
    let (keys, own, other, seconds) = (Keys::new("mutated-peer", 0), free(), free(), mutated_s());
    let [key, recording] = [keys.file(0), keys.0.join("run.mcap").display().to_string()];
    let table = keys.0.join("run.csv");
    let lasts = format!("{}", 6.0 + seconds.ceil());
    let peer = cohold(&["peer", "--json", "--quiet", "--number", "1", "--listen", &own, "--connect", &other])
        .args(["--scene", "any-network", "--set", "timing.ticks_per_packet=8", "--seconds", &lasts])
        .args(["--key-file", &key, "--record", &recording])
        .spawn()
        .expect("cohold runs");
    let python = python(&key, [2, 1], 0, [&other, &own], Says::Mutated(7, seconds));
    let (said, [early, most]) = watched(peer);
    let python = report(python);
    assert!(number(&python, "mutated") > 10.0 * seconds, "{python}");
    assert!(number(&said, "datagrams_refused") > 5.0 * seconds, "{said}");
    // In the end nobody is there any more.
    assert!(said["fault"].as_str().is_none_or(|fault| fault.starts_with("fault 5:")), "{said}");
    assert!(most < early + 8_000_000, "{early} bytes, and then {most}");
    assert!(cohold(&["recording", "convert", &recording]).arg(&table).output().expect("cohold runs").status.success());
    let table = std::fs::read_to_string(table).expect("a table");
    let (names, rows) = table.split_once('\n').expect("a row of names");
    for column in ["device_m", "object_m", "decoded_m", "contact_n", "coordination_n"] {
        let at = names.split(',').position(|name| name == column).expect("a column of every recording");
        let values = rows.lines().map(|row| row.split(',').nth(at).and_then(|cell| cell.parse::<f64>().ok()));
        let most = values.map(|value| value.expect("a number").abs()).fold(0.0, f64::max);
        assert!(most.is_finite() && (column != "contact_n" || most <= 40.1), "{column}: {most}");
    }
}

/// The same against a hub: whoever is on the other line has his flow, and is not let go of.
#[test]
fn a_hub_keeps_who_is_honest_from_who_is_not() {
    let (keys, hub, others, seconds) = (Keys::new("mutated-hub", 2), free(), [free(), free()], mutated_s());
    let lasts = format!("{}", 6.0 + seconds.ceil());
    let running = cohold(&[
        "shared",
        "hub",
        "--json",
        "--users",
        "2",
        "--listen",
        &hub,
        "--seconds",
        &lasts,
        "--key-file",
        &keys.file(0),
    ])
    .stderr(Stdio::null())
    .spawn()
    .expect("cohold runs");
    let wicked = python(&keys.file(1), [1, 2], 0, [&others[0], &hub], Says::Mutated(8, seconds));
    let honest = python(&keys.file(2), [2, 1], 0, [&others[1], &hub], Says::Flow);
    let (said, [early, most]) = watched(running);
    let [wicked, honest] = [wicked, honest].map(report);
    was_there(&said["lines"][1], &honest);
    assert!(number(&wicked, "mutated") > 10.0 * seconds && wicked["confirmed"] == true, "{wicked}");
    assert!(number(&said, "datagrams_refused") > 5.0 * seconds, "{said}");
    assert!(most < early + 8_000_000, "{early} bytes, and then {most}");
}

/// A meeting place on loopback, and its address.
fn meeting_place() -> (Running, String) {
    let meet = Running::start(cohold(&["meet", "--listen", "127.0.0.1:0"]));
    let place = meet.says("meeting place on").split_whitespace().nth(3).expect("an address").to_owned();
    (meet, place)
}

/// A peer for so many seconds, a packet every 8 ms, by the relay alone; `more` says whom it meets.
fn meets(seconds: &str, more: &[&str]) -> Command {
    let mut command = cohold(&["peer", "--json-lines", "--anyway", "--relay-only", "--seconds", seconds]);
    command.args(["--patience-s", "30", "--set", "timing.ticks_per_packet=8"]).args(more);
    command
}

/// The last line in Python is what an attacker gained, or what a board did.
fn gained(python: Running) -> Value {
    let (good, said) = python.end();
    assert!(good, "{said}");
    serde_json::from_str(&said).expect("JSON")
}

/// A thief has read a link before it was used. He agrees with the inviter, then takes the inviter's seat and answers whoever was invited: with the answer that he
/// got, and with answers of his own. Whoever was invited gets no code and is told why; the inviter is told that somebody else came. So the thief is
/// between nobody.
#[test]
fn a_thief_with_the_link_is_between_nobody_and_both_ends_are_told() {
    let (meet, place) = meeting_place();
    let inviter = Running::start(meets("30", &["--invite", "--meet", &place]));
    let link = inviter.says("haptic://");
    let thief = Running::start(started("thief.py", &json!({ "attack": "thief", "link": link })));
    let agreed = thief.says("agreed with the inviter: ");
    let code = inviter.says("code of this meeting: ");
    assert_eq!(code.rsplit(": ").next(), agreed.rsplit(": ").next(), "he was quicker: this code is his");
    // He keeps the inviter from the meeting place until he has answered every offer, with all that he can make.
    inviter.signal("STOP");
    thief.says("sits where the inviter sat");
    let invited = meets("30", &["--accept", &link]).stdin(Stdio::null()).spawn().expect("cohold runs");
    thief.says("has answered all offers");
    inviter.signal("CONT");
    inviter.says("warning: somebody else came with the link and was refused");
    let invited = invited.wait_with_output().expect("it ends");
    let said = String::from_utf8_lossy(&invited.stderr);
    assert!(invited.status.code().is_some_and(|code| code != 0), "{said}");
    assert!(said.contains("this link has been used") && said.contains("ask who has used it if you did not"), "{said}");
    assert!(!said.contains("code of this meeting") && invited.stdout.is_empty(), "no code and no session: {said}");
    let thief = gained(thief);
    let sent = thief["sent"].as_object().expect("how he answered");
    assert!(number(&thief, "offers") >= 10.0 && sent.len() == 7, "{thief}");
    assert!(sent.values().all(|times| times.as_f64() >= Some(10.0)), "{thief}");
    assert_eq!((number(&thief, "others"), number(&thief, "reads")), (0.0, 0.0), "offers are all that he got: {thief}");
    inviter.kill();
    meet.kill();
}

/// Both ends and their session, seen by an onlooker who passes everything on: they meet, flow both ways stays on the relay, and nearly nothing is lost.
fn met(ends: [Running; 2]) {
    let codes = [&ends[0], &ends[1]].map(|end| end.says("code of this meeting: "));
    assert_eq!(codes[0], codes[1]);
    let told: [Told; 2] = ends.map(Running::report);
    for told in &told {
        let engaged = told.noticed("Engaged").unwrap_or_else(|| panic!("{told:?}"));
        assert!(told.noticed("Lost").is_none_or(|at| at > engaged + 3.0), "the session stays: {told:?}");
        assert_eq!(told.way(), "relayed", "{}", told.report);
        assert!(told.ways.iter().all(|(_, way)| way == "relayed"), "{:?}", told.ways);
        let (taken, missing) = (told.number("/datagrams_taken"), told.number("/datagrams_missing"));
        assert!(taken > 300.0 && missing < 0.1 * taken, "{}", told.report);
        assert!(told.report["fault"].is_null() && told.number("/datagrams_refused") == 0.0, "{}", told.report);
    }
}

/// An onlooker without the link sees every join of both ends. He repeats them from other addresses, with cookies of his own and with proofs of all kinds, before the
/// second end comes and while the two have a session. He takes no seat and moves none.
#[test]
fn an_onlooker_of_a_meeting_takes_no_seat_and_its_session_stays() {
    let (meet, place) = meeting_place();
    let onlooker = Running::start(started("thief.py", &json!({ "attack": "onlooker", "place": place })));
    let between = onlooker.says("between: ");
    let inviter = Running::start(meets("4", &["--invite", "--meet", between.trim_start_matches("between: ")]));
    let link = inviter.says("haptic://");
    onlooker.says("has tried to take the free seat");
    let invited = Running::start(meets("4", &["--accept", &link]));
    met([inviter, invited]);
    onlooker.interrupt();
    let onlooker = gained(onlooker);
    // Two seats of the link's room and two of the session's: he saw them all, and tried each.
    assert_eq!(number(&onlooker, "seats_seen"), 4.0, "{onlooker}");
    assert!(number(&onlooker, "passed") > 600.0 && number(&onlooker, "live") > 30.0, "{onlooker}");
    assert!(number(&onlooker, "welcomes") > 80.0 && number(&onlooker, "refused") > 60.0, "{onlooker}");
    let tried = onlooker["tried"].as_object().expect("what he tried");
    assert!(tried.len() == 10 && tried.values().all(|times| times.as_f64() >= Some(5.0)), "{onlooker}");
    assert_eq!((number(&onlooker, "seated"), number(&onlooker, "others")), (0.0, 0.0), "no seat, no flow: {onlooker}");
    // His proofs are right where a key is his own, so the others were refused as wrong. Nobody is with him there.
    assert_eq!(onlooker["own_room"], json!({ "seated": true, "other": false, "others": 0 }), "{onlooker}");
    meet.kill();
}

/// A board in Python on loopback: number 2, with motors that run by its own reading of FORMAT.md.
pub(crate) struct Board {
    running: Running,
    /// The options by which the program reaches it, with the operator's key.
    pub(crate) reached: [String; 4],
}

impl Board {
    /// A board with this lease. Its manner is how it takes a stop, and its path drops datagrams of these lengths: board.py says more.
    pub(crate) fn start(name: &str, manner: &str, drops: &[u16], lease_s: f64) -> Self {
        let key = Keys::new(name, 0).0.join("operator.key").display().to_string();
        assert!(cohold(&["key", "generate", &key, "--operator"]).status().expect("cohold runs").success());
        let told = json!({ "key": key, "number": 2, "manner": manner, "drops": drops, "lease_s": lease_s });
        let running = Running::start(started("board.py", &told));
        let address = running.says("listens on ").trim_start_matches("listens on ").to_owned();
        Self { running, reached: ["--board".to_owned(), address, "--key-file".to_owned(), key] }
    }

    /// The next thing with this in it that happens to it.
    pub(crate) fn says(&self, what: &str) -> String {
        self.running.says(what)
    }

    /// The program that says these to it.
    fn operator(&self, lines: &[&str]) -> Command {
        let mut command = cohold(&["board", "operator"]);
        command.args(&self.reached).args(lines);
        command
    }

    /// What one run of the program that says these lines gives: its status, its answers, its errors.
    pub(crate) fn run(&self, lines: &[&str]) -> (Option<i32>, String, String) {
        ended(self.operator(lines).spawn().expect("cohold runs"))
    }

    /// Both it and its path are honest from now on.
    pub(crate) fn heal(&self) {
        self.running.signal("USR1");
        self.says("honest again");
    }

    /// What it did, and each turn of its motors: when, ms, and to what.
    pub(crate) fn end(self) -> (Value, Vec<(f64, String)>) {
        self.running.interrupt();
        let did = gained(self.running);
        let turns = did["motors"].as_array().expect("a list").iter();
        let turns =
            turns.map(|turn| (turn[0].as_f64().expect("a time"), turn[1].as_str().expect("a state").to_owned()));
        let turns = turns.collect();
        (did, turns)
    }
}

/// The status, answers and errors of a run of the program.
fn ended(run: Child) -> (Option<i32>, String, String) {
    let output = run.wait_with_output().expect("it ends");
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
    (output.status.code(), text(output.stdout), text(output.stderr))
}

fn states(turns: &[(f64, String)]) -> Vec<&str> {
    turns.iter().map(|(_, state)| state.as_str()).collect()
}

#[test]
fn a_board_that_runs_alone_is_stopped_by_another_run_of_the_program() {
    let board = Board::start("python-board", "honest", &[], 0.2);
    assert_eq!(board.run(&["arm alone"]), (Some(0), "ok armed alone\n".into(), String::new()));
    std::thread::sleep(Duration::from_millis(600));
    assert_eq!(board.run(&["status"]), (Some(0), "ok board 2 alone\n".into(), String::new()));
    assert_eq!(board.run(&["disarm"]), (Some(0), "ok disarmed\n".into(), String::new()));
    let (did, turns) = board.end();
    assert_eq!(states(&turns), ["alone", "off"], "{did}");
    let first = did["stops"][0][0].as_f64().expect("a stop came");
    assert!((first..first + 100.0).contains(&turns[1].0), "{did}");
}

/// Motors run alone and stay on, because the board is deaf to a stop or its path is cut when the stop arrives. The program never says that they are
/// off, even if the board says that it has heard the stop, or says *off* with the number of an older word. It says what to press.
#[test]
fn a_stop_that_a_board_does_not_confirm_is_no_stop() {
    let stopping = ["deaf", "stuck", "stale", "late"].map(|manner| {
        let board = Board::start(&format!("python-board-{manner}"), manner, &[], 0.2);
        assert_eq!(board.run(&["arm alone"]), (Some(0), "ok armed alone\n".into(), String::new()), "{manner}");
        let disarm = board.operator(&["disarm"]).spawn().expect("cohold runs");
        (manner, board, disarm)
    });
    for (manner, board, disarm) in stopping {
        board.says("ignores the stop");
        let (status, said, why) = ended(disarm);
        assert_eq!((status, said.as_str(), why.lines().count()), (Some(2), "", 1), "{manner}: {why}");
        assert!(why.starts_with("cohold: stop not confirmed: press the stop at the board."), "{manner}: {why}");
        board.heal();
        assert_eq!(board.run(&["disarm"]), (Some(0), "ok disarmed\n".into(), String::new()), "{manner}");
        let (did, turns) = board.end();
        assert_eq!(states(&turns), ["alone", "off"], "{manner}: {did}");
        let first = did["stops"][0][0].as_f64().expect("a stop came");
        assert!(turns[1].0 > first + 2000.0, "{manner}: its motors were on all the while: {did}");
    }
}

/// Motors that run for an operator are on as long as the program is there. They are off by the board's own lease when the program is killed, and
/// also when it ends by itself.
#[test]
fn a_board_is_off_within_its_lease_when_the_program_is_killed() {
    let board = Board::start("python-board-killed", "honest", &[], 1.0);
    let folder = Keys::new("python-board-recording", 0).0;
    let recorded = |file: &str, seconds: &str| {
        let mut command = board.operator(&["arm", "--seconds", seconds, "--record"]);
        command.arg(folder.join(file));
        command
    };
    let killed = Running::start(recorded("killed.csv", "60"));
    board.says("line stream 4");
    std::thread::sleep(Duration::from_secs(3));
    killed.kill();
    board.says("motors off: lease");
    let (status, said, why) = ended(recorded("ended.csv", "2").spawn().expect("cohold runs"));
    assert_eq!((status, said.as_str()), (Some(0), "ok armed\n"), "{why}");
    board.says("motors off");
    let (did, turns) = board.end();
    assert_eq!(states(&turns), ["leased", "off", "leased", "off"], "{did}");
    let runs: Vec<f64> = did["runs"].as_array().expect("a list").iter().filter_map(|run| run[0].as_f64()).collect();
    let last = runs.iter().copied().filter(|at| *at < turns[1].0).fold(0.0, f64::max);
    assert!(turns[1].0 - turns[0].0 > 3000.0, "on for three leases: {did}");
    assert!(turns[1].0 - last < 1500.0, "off within the lease: {last} {turns:?}");
    assert!(number(&did, "ticks") > 100.0, "{did}");
}
