//! The live page in a real browser: the program as a user starts it, Chromium without a screen, two windows.
//!
//! What is waited for is waited for up to half a minute; nothing here asserts a time. Pictures of the main states are left in
//! `target/tmp/suite/play`.

mod boards;
mod devtools;
mod environments;
mod files;
mod inputs;
mod lan;
mod merged;
mod phone;
mod remote;
mod socket;
mod stories;
mod timeline;

use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStderr, Command};
use std::time::{Duration, Instant};

use devtools::{Browser, Window, drag, middle};
use serde_json::json;
use socket::Socket;

use crate::program::cohold;

/// The program that serves the page, gone when dropped.
struct Play {
    child: Child,
    addresses: Vec<String>,
    /// Kept: who writes to a closed pipe ends.
    _said: BufReader<ChildStderr>,
}

impl Play {
    /// Two peers, where nothing else is asked for.
    fn start(arguments: &[&str]) -> Self {
        let asked = ["--environment", "--scene", "--listen", "--join", "--board", "--open"];
        let says = arguments.iter().any(|argument| asked.contains(argument));
        let first: &[&str] = if says { &[] } else { &["--environment", "pair"] };
        Self::plainly(&[first, arguments].concat())
    }

    /// As somebody who says just this.
    fn plainly(arguments: &[&str]) -> Self {
        let mut child = cohold(&[&["play"], arguments].concat()).spawn().expect("cohold runs");
        let mut said = BufReader::new(child.stderr.take().expect("its errors are kept"));
        let address = |line: String| line.split_once("http://").map(|(_, rest)| format!("http://{rest}"));
        let lines = said.by_ref().lines().map_while(Result::ok);
        let addresses = lines.take_while(|line| !line.starts_with("Ctrl-C")).filter_map(address).collect();
        Self { child, addresses, _said: said }
    }

    /// The address of a hand, 1 or 2, whose window orders, too. What is printed first is that of the first hand, then come each hand, the
    /// operator, and who watches.
    fn person(&self, number: usize) -> String {
        let (_, operator) = self.addresses[3].split_once('#').expect("an address");
        format!("{}+{operator}", self.addresses[number])
    }

    /// What it reports when it ends.
    fn report(mut self) -> serde_json::Value {
        assert!(self.child.wait().expect("it ends").success());
        let mut said = String::new();
        let out = self.child.stdout.as_mut().expect("its output is kept");
        out.read_to_string(&mut said).expect("text");
        serde_json::from_str(&said).expect("one JSON document")
    }
}

impl Drop for Play {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("suite/play");
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn click(browser: &mut Browser, window: &Window, id: &str) {
    browser.evaluate(window, &format!("document.getElementById('{id}').click()"));
}

/// Presses the button that says this.
fn press(browser: &mut Browser, window: &Window, text: &str) {
    let buttons = "[...document.querySelectorAll('button')]";
    browser.evaluate(window, &format!("{buttons}.find((button) => button.textContent === '{text}').click()"));
}

/// Types into a field or moves a range, as a person who then leaves it.
fn set(browser: &mut Browser, window: &Window, id: &str, value: &str) {
    let expression = format!(
        "{{ const e = document.getElementById('{id}'); e.value = {}; \
         for (const kind of ['input', 'change']) e.dispatchEvent(new Event(kind)); }}",
        json!(value)
    );
    browser.evaluate(window, &expression);
}

/// Asked to end, it closes its windows, reports its ticks and says so with status 0.
#[test]
fn it_ends_when_it_is_asked_to() {
    let play = Play::start(&["--json"]);
    std::thread::sleep(Duration::from_millis(300));
    let asked = Command::new("kill").args(["-s", "INT", &play.child.id().to_string()]).status();
    assert!(asked.expect("kill runs").success());
    let report = play.report();
    assert!(report["ticks"].as_u64() > Some(100), "{report}");
}

/// How punctual the control loop is without windows, with two, and with two of which one scrubs while ten others watch, and how soon a
/// moved pointer is a picture: a table for `cargo xtask page --measure`, which says for how long.
#[test]
#[ignore = "takes minutes, and tells of the machine"]
fn how_punctual_and_how_soon() {
    let seconds = std::env::var("COHOLD_MEASURE_S").unwrap_or_else(|_| "60".into());
    println!(
        "| pages | watchers | ticks | late | worst, ms | pointer to picture, ms at 50 and 95 % | frames a second |"
    );
    println!("|---|---|---|---|---|---|---|");
    for (pages, watchers) in [(0, 0), (2, 0), (2, 10)] {
        let play = Play::start(&["--json", "--partner", "follows", "--seconds", &seconds]);
        let watching: Vec<_> = (0..watchers)
            .map(|_| Socket::open(&play.addresses[4]).expect("it is let in"))
            .map(|socket| std::thread::spawn(|| socket.looks_on()))
            .collect();
        let seen = (pages > 0).then(|| pointer_to_picture(&play, watchers > 0));
        let kept = play.report();
        watching.into_iter().for_each(|thread| thread.join().expect("it ends with the program"));
        let late = format!("{} | {} | {:.2}", kept["ticks"], kept["late"], kept["worst_us"].as_f64().unwrap() * 1e-3);
        let soon = seen.map_or(" | ".to_owned(), |[half, most, frames]| format!("{half:.0}, {most:.0} | {frames:.0}"));
        println!("| {pages} | {watchers} | {late} | {soon} |");
    }
}

/// Drags the hand of window 1 to and fro while window 2 looks on, or is scrubbed, until the program ends; lags at 50 and 95 %, ms, and
/// frames a second.
fn pointer_to_picture(play: &Play, scrubs: bool) -> [f64; 3] {
    let mut browser = Browser::start(folder().join("measured"));
    let [one, two] = [1, 2].map(|person| browser.open(&play.person(person)));
    for window in [&one, &two] {
        browser.wait(window, "page.frames() > 20 && page.value('device_1', 500) === 0");
    }
    if scrubs {
        browser.evaluate(&two, "setInterval(() => page.seek((Date.now() % 7000) * 1e-3), 50)");
        browser.wait(&two, "!document.getElementById('now').hidden");
    }
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    let ([start, mut frames], started) = (browser.numbers(&one, "[page.frames(), 0]"), Instant::now());
    let (mut at, mut swing, mut seen, mut took) = (hand, 30.0, [f64::NAN; 2], 0.0);
    while browser.evaluate(&one, "document.getElementById('status').textContent.startsWith('closed')") != true {
        at = drag(&mut browser, &one, at, swing);
        swing = -swing;
        let [half, most, now] = browser.numbers(&one, "[page.lag(0.5), page.lag(0.95), page.frames()]");
        (seen, frames, took) = ([half, most], now, started.elapsed().as_secs_f64());
    }
    [seen[0], seen[1], (frames - start) / took]
}

#[test]
fn two_windows_hold_one_object() {
    let play = Play::start(&["--partner", "resists"]);
    let folder = folder();
    let mut browser = Browser::start(folder.join("profile"));
    let [one, two] = [1, 2].map(|person| browser.open(&play.person(person)));
    for window in [&one, &two] {
        browser.wait(window, "page.frames() > 20 && page.value('device_1', 500) === 0");
        browser.wait(window, "document.getElementById('status').textContent.startsWith('another person')");
        browser.wait(window, "document.getElementById('verdict').textContent.startsWith('stable')");
    }

    // The mouse of window 1 carries the object; window 2 sees both copies come along, and how far apart they truly are.
    let hand = middle(&mut browser, &one, "hand");
    browser.mouse(&one, "mousePressed", hand);
    let at = drag(&mut browser, &one, hand, 40.0);
    for window in [&one, &two] {
        browser.wait(window, "[1, 2].every((n) => Math.abs(page.value(`object_${n}`) - 0.04) < 0.004)");
        browser.wait(window, "Number(document.getElementById('true').textContent) < 5");
    }

    // How soon a hand is drawn on its way after its pointer has moved is reported.
    let lags: [f64; 2] = browser.numbers(&one, "[page.lag(0.5), page.lag(0.95)]");
    assert!(lags[0] > 0.0 && lags[1] >= lags[0], "{lags:?}");
    println!("pointer to picture, ms at 50 and 95 %: {lags:?}");

    // Person 2 holds on while person 1 pulls: both feel it, as a distance between pointer and device.
    let other = middle(&mut browser, &two, "hand");
    browser.mouse(&two, "mousePressed", other);
    let at = drag(&mut browser, &one, at, -25.0);
    browser.wait(&two, "page.value('hand_1') < -0.5 && page.value('hand_2') > 0.5");
    browser.picture(&one, &folder.join("two-hands.png"));

    // What one sets, the other sees; a key that names a file is refused.
    browser.evaluate(
        &two,
        "for (const [id, x] of [['delay', 60], ['loss', 20]]) { const e = document.getElementById(id); \
                            e.value = x; e.dispatchEvent(new Event('input')); }",
    );
    browser.wait(
        &one,
        "document.getElementById('delay').value === '60' && document.getElementById('loss').value === '20'",
    );
    browser.wait(&one, "Math.abs(page.value('delay_1') - 0.06) < 0.002");

    // Cut, the copies stand apart, each with its own hand; joined, they come together again.
    click(&mut browser, &two, "cut");
    browser.wait(
        &one,
        "document.getElementById('status').textContent === 'the cable is cut' && page.value('live_1') === 0",
    );
    let before: [f64; 1] = browser.numbers(&one, "[page.value('object_2')]");
    let at = drag(&mut browser, &one, at, -10.0);
    browser.wait(&one, "page.value('live_1', 300) === 0");
    let [stands, apart] =
        browser.numbers(&one, "[page.value('object_2'), Number(document.getElementById('true').textContent)]");
    assert!((stands - before[0]).abs() < 0.02 && apart.is_finite(), "{stands} {before:?} {apart}");
    browser.picture(&two, &folder.join("cut.png"));
    click(&mut browser, &two, "cut");
    browser.wait(&one, "page.value('live_1') === 1");
    browser.mouse(&two, "mouseReleased", other);
    browser.mouse(&one, "mouseReleased", at);
    browser.wait(&two, "Number.isNaN(page.value('wanted_1')) && Number.isNaN(page.value('wanted_2'))");

    // A gain outside its region asks first, and says what to change.
    browser.evaluate(
        &one,
        "[...document.querySelectorAll('#clicks button')].find((b) => b.textContent === 'paper, both push, 16 ms').click()",
    );
    browser.wait(&one, "document.getElementById('law').value === 'passive-wave'");
    browser.evaluate(
        &one,
        "{ const e = document.getElementById('law'); e.value = 'four-channel'; e.dispatchEvent(new Event('change')); }",
    );
    browser.wait(&two, "document.getElementById('law').value === 'four-channel'");
    browser.evaluate(
        &one,
        "{ const e = document.getElementById('stiffness'); e.value = 3.48; e.dispatchEvent(new Event('input')); }",
    );
    browser.wait(&one, "!document.getElementById('question').hidden");
    let asked = browser.evaluate(&one, "document.getElementById('question-text').textContent");
    assert!(
        asked.as_str().is_some_and(|text| text.contains("Lower coordination.stiffness_n_per_m from 3020 to")),
        "{asked}"
    );
    browser.picture(&one, &folder.join("asks-first.png"));
    click(&mut browser, &one, "anyway");
    browser.wait(&two, "document.getElementById('verdict').classList.contains('bad')");
    // Limits and faults end what it does, and say why; nothing moves again before somebody starts it.
    browser.wait(&two, "document.getElementById('status').textContent.includes('stopped: ')");
    browser.picture(&two, &folder.join("fault.png"));
    browser.evaluate(
        &one,
        "[...document.querySelectorAll('#clicks button')].find((b) => b.textContent === 'any network').click()",
    );
    browser.wait(&one, "document.getElementById('verdict').textContent.startsWith('stable')");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('stopped')");
    click(&mut browser, &one, "start");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('another person')");

    // Keys move the hand, Escape lets go, stop turns both motors off. A start lets go of what was held before.
    let [restarts, from] = browser.numbers(&one, "[page.value('restarts'), page.value('object_1')]");
    browser.wait(&two, &format!("page.value('restarts') === {restarts}"));
    browser.evaluate(&two, "document.getElementById('hand').focus()");
    for _ in 0..10 {
        browser.key(&two, "ArrowRight");
    }
    browser.wait(&one, &format!("page.value('object_1') > {from} + 0.01"));
    browser.key(&two, "Escape");
    browser.wait(&one, "Number.isNaN(page.value('wanted_2'))");
    click(&mut browser, &two, "stop");
    browser.wait(&one, "document.getElementById('status').textContent.startsWith('stopped: motors are off')");
    browser.wait(&one, "page.value('coordination_1') === 0 && page.value('coordination_2') === 0");
    click(&mut browser, &one, "start");
    browser.wait(&two, "document.getElementById('status').textContent.startsWith('another person')");

    // What is saved is a scene, what is exported has every column, and what is shown fits a phone, in the dark.
    let saved = browser.evaluate(&one, "page.asToml()");
    assert!(saved.as_str().is_some_and(|toml| toml.contains("comm = \"self-timed\"")), "{saved}");
    let csv = browser.evaluate(&one, "page.asCsv().split('\\n')[0]");
    assert!(csv.as_str().is_some_and(|head| head.starts_with("time_s,wanted_1_m,")), "{csv}");
    let dark = json!({ "features": [{ "name": "prefers-color-scheme", "value": "dark" }] });
    browser.call(&two, "Emulation.setEmulatedMedia", dark);
    let phone = json!({ "width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": true });
    browser.call(&two, "Emulation.setDeviceMetricsOverride", phone);
    browser.wait(&two, "document.documentElement.scrollWidth <= 390");
    browser.picture(&two, &folder.join("phone.png"));

    // A page from elsewhere gets nothing, even with the keys.
    let elsewhere = browser.open("data:text/html,elsewhere");
    let line = play.addresses[0].replace("http", "ws").replace("/#", "/ws/");
    let outcome = browser.evaluate(
        &elsewhere,
        &format!(
            "new Promise((done) => {{ const s = new WebSocket('{line}'); s.onopen = () => done('open'); \
             s.onerror = () => done('refused'); }})"
        ),
    );
    assert_eq!(outcome, "refused");
    let complaints = browser.complaints(&[&one, &two]);
    assert!(complaints.is_empty(), "{complaints:?}");
}
