//! The page as the operator of two simulated boards: what turns motors on is confirmed, Stop is always there, a closed page lets go.

use std::time::{Duration, Instant};

use serde_json::Value;

use super::{Browser, Play, Socket, click, folder, press};
use crate::another_language::Board;

/// How the motors of a board are shown, as a page gets it.
const OFF: u8 = 0;
const NOT_KNOWN: u8 = 2;
const ALONE: u8 = 3;

/// The page of a board in Python, and its operator's window.
fn page_of(board: &Board) -> (Play, Socket) {
    let play = Play::start(&board.reached.each_ref().map(String::as_str));
    let page = Socket::open(&play.addresses[0]).expect("it is let in");
    (play, page)
}

/// Until board 2 is shown so.
fn until(page: &mut Socket, shown: impl Fn(u8) -> bool) {
    let start = Instant::now();
    while !shown(page.looks().0[1]) {
        assert!(start.elapsed() < Duration::from_secs(30), "{:?}", page.looks());
    }
}

/// What the page is told of its stop, and whether board 2 was shown as off before that.
fn stopped(page: &mut Socket) -> (String, bool) {
    page.say("stop");
    let (start, mut shown_off) = (Instant::now(), false);
    while start.elapsed() < Duration::from_secs(30) {
        let ([_, shown], boards) = page.looks();
        let said = boards.as_ref().and_then(|boards| boards[0]["told"]["said"].as_array()).into_iter().flatten();
        let mut answers = said.filter(|one| one[0] == "stop").filter_map(|one| one[1].as_str());
        if let Some(answer) = answers.find(|answer| !answer.starts_with("stop sent: ")) {
            return (answer.to_owned(), shown_off);
        }
        shown_off |= shown == OFF;
    }
    panic!("nothing is said of the stop");
}

/// An attacker on the path, without a key, drops what a board sends by its length once its motors are on: samples, or probes and replies, or
/// everything. The page never shows them as off while they are on, and they go off when the page is closed.
#[test]
fn a_path_that_drops_by_length_hides_no_motor_and_keeps_none_on() {
    for (name, drops) in [("samples", &[160][..]), ("probes", &[60, 76]), ("all", &[0])] {
        let board = Board::start(&format!("python-dropped-{name}"), "honest", drops, 1.0);
        let (_play, mut page) = page_of(&board);
        // Without its ticks, which are asked for after half a second, nothing of a board without probes arrives.
        board.says("line stream 4");
        until(&mut page, |shown| shown == OFF);
        page.say("board 2 arm");
        board.says("motors leased");
        until(&mut page, |shown| shown != OFF);
        let (start, mut shown) = (Instant::now(), OFF);
        while start.elapsed() < Duration::from_secs(3) {
            shown = page.looks().0[1];
            assert_ne!(shown, OFF, "{name}");
        }
        assert!(name != "all" || shown == NOT_KNOWN, "{name}: {shown}");
        let closed = Instant::now();
        drop(page);
        board.says("motors off");
        // The page may be silent for a second, and the lease is another.
        assert!(closed.elapsed() < Duration::from_secs(4), "{name}: {:?}", closed.elapsed());
        let (did, turns) = board.end();
        let states: Vec<_> = turns.iter().map(|(_, state)| state.as_str()).collect();
        assert_eq!(states, ["leased", "off"], "{name}: {did}");
        assert!(did["lost"].as_f64() > Some(50.0), "{name}: {did}");
    }
}

/// A board runs alone. The page says so, and its Stop is *stopped* only if the board says so itself.
#[test]
fn stop_on_a_page_ends_what_runs_alone_or_says_what_to_press() {
    let alone = |manner: &str| {
        let board = Board::start(&format!("python-page-{manner}"), manner, &[], 0.2);
        assert_eq!(board.run(&["arm alone"]).0, Some(0));
        let (play, mut page) = page_of(&board);
        until(&mut page, |shown| shown == ALONE);
        (board, play, page)
    };
    let last = |did: &Value| did["motors"].as_array().and_then(|turns| turns.last()).map(|turn| turn[1].clone());

    let (board, _play, mut page) = alone("honest");
    assert_eq!(stopped(&mut page).0, "stopped: the board says that its motors are off");
    let (did, _) = board.end();
    assert_eq!(last(&did), Some("off".into()), "{did}");

    for manner in ["deaf", "late"] {
        let (board, _play, mut page) = alone(manner);
        let (said, shown_off) = stopped(&mut page);
        assert!(said.starts_with("stop not confirmed: press the stop at the board"), "{manner}: {said}");
        assert!(!shown_off && page.looks().0[1] != OFF, "{manner}: {:?}", page.looks());
        let (did, _) = board.end();
        assert_eq!(last(&did), Some("alone".into()), "{manner}: {did}");
    }
}

#[test]
fn two_boards_are_commanded_from_a_page() {
    let play = Play::start(&["--board", "simulated"]);
    let mut browser = Browser::start(folder().join("boards"));
    let one = browser.open(&play.addresses[0]);
    let status = "document.getElementById('status').textContent";
    browser.wait(&one, &format!("{status} === 'all motors are off'"));
    assert_eq!(browser.evaluate(&one, "getComputedStyle(document.getElementById('controls')).display"), "none");

    // A check, and what it found.
    browser.evaluate(
        &one,
        "[...document.querySelectorAll('#board2 button')].find((b) => b.textContent.startsWith('Check joint 1')).click()",
    );
    browser.wait(&one, "document.querySelector('#board2 .said').textContent.includes('motor and encoder agree')");
    browser.picture(&one, &folder().join("boards.png"));

    // Armed only when that was confirmed.
    press(&mut browser, &one, "Arm board 2");
    browser.wait(&one, "!document.getElementById('question').hidden");
    browser.picture(&one, &folder().join("boards-asks.png"));
    click(&mut browser, &one, "leave");
    browser.wait(&one, "document.getElementById('question').hidden");
    assert_eq!(browser.evaluate(&one, status), "all motors are off");
    press(&mut browser, &one, "Arm board 2");
    click(&mut browser, &one, "anyway");
    browser.wait(&one, &format!("{status}.startsWith('the motors of board 2 are on')"));
    click(&mut browser, &one, "stop");
    browser.wait(&one, &format!("{status} === 'all motors are off'"));
    let answer = "document.querySelector('#board2 .said').textContent";
    browser.wait(&one, &format!("{answer}.endsWith('stop: stopped: the board says that its motors are off')"));

    // A line of another making is none.
    browser.evaluate(&one, "page.command('board 1 set safety.max_force_n 40')");
    browser.wait(&one, "document.getElementById('refused').textContent.includes('board operator')");

    // Who only watches sees the same and commands nothing; a window that is gone has let go.
    let watching = browser.open(&play.addresses[1]);
    browser.wait(&watching, "document.querySelectorAll('#boards button').length === 8");
    let buttons = "[...document.querySelectorAll('#boards button, #stop, #start')]";
    assert_eq!(browser.evaluate(&watching, &format!("{buttons}.every((b) => b.disabled)")), true);
    browser.evaluate(&watching, "page.command('board 1 arm')");
    browser.wait(&watching, "document.getElementById('refused').textContent.startsWith('only the operator')");
    // With another role before its key, its address opens nothing.
    let changed = browser.open(&play.addresses[1]);
    let (host, ring) = play.addresses[1].split_once("/#watch-").expect("an address");
    for role in ["operator", "hand1", "hand2"] {
        let outcome = browser.evaluate(
            &changed,
            &format!(
                "new Promise((done) => {{ const s = new WebSocket('{}/ws/{role}-{ring}'); s.onopen = () => done('open'); \
                 s.onerror = () => done('refused'); }})",
                host.replace("http", "ws")
            ),
        );
        assert_eq!(outcome, "refused", "{role}");
    }
    press(&mut browser, &one, "Arm board 2");
    click(&mut browser, &one, "anyway");
    browser.wait(&watching, &format!("{status}.startsWith('the motors of board 2 are on')"));
    browser.call(&one, "Page.navigate", serde_json::json!({ "url": "about:blank" }));
    browser.wait(&watching, &format!("{status} === 'all motors are off'"));
    let complaints = browser.complaints(&[&one, &watching]);
    assert!(complaints.is_empty(), "{complaints:?}");

    // Until it has heard of a board, a window says nothing of motors.
    let keeps_back = "const { set } = Object.getOwnPropertyDescriptor(WebSocket.prototype, 'onmessage'); \
        Object.defineProperty(WebSocket.prototype, 'onmessage', { set(hear) { \
        set.call(this, (event) => `${event.data}`.startsWith('{\"boards\"') || hear(event)); } });";
    let script = serde_json::json!({ "source": keeps_back });
    browser.call(&watching, "Page.addScriptToEvaluateOnNewDocument", script);
    browser.call(&watching, "Page.reload", serde_json::json!({}));
    browser.wait(&watching, &format!("{status} === 'waiting for the boards'"));
    assert_eq!(browser.evaluate(&watching, "document.getElementById('status').className"), "bad");
}
