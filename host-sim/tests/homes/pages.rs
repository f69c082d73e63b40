//! As two people do it: one sends the other a link, each has a page in a browser, and both hold one cube over a network that loses datagrams. What a page says of the
//! path has to be what its recording says, and the recordings of both homes have to merge.
//!
//! Pictures of both pages are left in `target/tmp/homes`.

use std::collections::HashMap;
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use serde_json::Value;

use super::devtools::{Browser, Window, drag, middle};
use super::lab::{Lab, PLACE, Router};
use super::peers::{COHOLD, Running};

/// How a page and a recording call the paths, the longer before what it begins with.
const PATHS: [&str; 6] = ["no path", "relayed", "direct, relay beside it", "LAN, relay beside it", "direct", "LAN"];
/// How long two people behind routers hold it, s, where `COHOLD_HOMES_S` does not say.
const SECONDS: f64 = 40.0;

/// A new folder of one test.
pub(super) fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("homes").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn text(path: &Path) -> &str {
    path.to_str().expect("a name")
}

/// What follows another of the same is left out.
fn changes<'a>(said: impl IntoIterator<Item = &'a str>) -> Vec<&'a str> {
    let mut said: Vec<_> = said.into_iter().collect();
    said.dedup();
    said
}

/// A `play` that records itself, before its page is opened.
struct Started {
    play: Running,
    recording: PathBuf,
}

impl Started {
    fn new(mut cohold: Command, folder: &Path, number: usize, more: &[&str]) -> Self {
        let recording = folder.join(format!("{number}.mcap"));
        cohold.args(["play", "--json", "--record", text(&recording)]).args(more);
        Self { play: Running::start(cohold), recording }
    }

    /// In a browser that this shell starts.
    fn opened(self, shell: Command, folder: &Path, number: usize) -> Person {
        let line = self.play.says(&format!("hand {number} and operator:"));
        let address = line.find("http://").map(|at| &line[at..]).expect("an address");
        let mut browser = Browser::start_by(shell, folder.join(format!("profile-{number}")));
        let window = browser.open(address);
        let Self { play, recording } = self;
        Person { play, recording, browser, window, seen: Vec::new() }
    }
}

/// One of two people.
struct Person {
    play: Running,
    recording: PathBuf,
    browser: Browser,
    window: Window,
    /// What the page said of the path whenever it was looked at.
    seen: Vec<String>,
}

impl Person {
    fn wait(&mut self, expression: &str) {
        self.browser.wait(&self.window, expression);
    }

    /// Takes hold of the hand.
    fn takes(&mut self) -> [f64; 2] {
        let hand = middle(&mut self.browser, &self.window, "hand");
        self.browser.mouse(&self.window, "mousePressed", hand);
        hand
    }

    fn says(&mut self, id: &str) -> String {
        let said = self.browser.evaluate(&self.window, &format!("document.getElementById('{id}').textContent"));
        said.as_str().expect("text").to_owned()
    }

    /// Reads what the page says of the path, and that nothing has stopped.
    fn looks(&mut self) {
        let said = self.says("path");
        let path = PATHS.iter().find(|path| said.starts_with(**path)).unwrap_or_else(|| panic!("no path in {said:?}"));
        self.seen.push((*path).to_owned());
        let status = self.says("status");
        assert!(status.ends_with("has the other hand"), "{status}; {said}");
        assert!(*path == "no path" || said.contains("each newton between the hands"), "{said}");
        assert!(said.contains("; code ") && said.contains(": compare it aloud"), "{said}");
    }

    /// Ends; its report, and what it saw and what was recorded of the path, change by change.
    fn ends(self, folder: &Path, number: usize) -> Ended {
        let Self { play, recording, browser, window, seen } = self;
        let complaints = browser.complaints(&[&window]);
        assert!(complaints.is_empty(), "{complaints:?}");
        play.interrupt();
        let (good, report) = play.end();
        assert!(good, "{report}");
        let report = serde_json::from_str(&report).expect("one JSON document");
        let table = folder.join(format!("{number}.csv"));
        let converted = Command::new(COHOLD).args(["recording", "convert", text(&recording)]).arg(&table).output();
        assert!(converted.expect("it runs").status.success());
        let rows = std::fs::read_to_string(folder.join(format!("{number}-paths.csv"))).expect("a table of paths");
        let mut lines = rows.lines();
        let names: Vec<&str> = lines.next().expect("names").split(',').collect();
        let number_of = |line: &str, name: &str| {
            let at = names.iter().position(|there| *there == name).unwrap_or_else(|| panic!("{name} in {names:?}"));
            line.split(',').nth(at).and_then(|number| number.parse::<f64>().ok())
        };
        let recorded = lines.clone().map(|line| {
            let near = if number_of(line, "lan") == Some(1.0) { "LAN" } else { "direct" };
            match number_of(line, "way").expect("a way") as u8 {
                0 => "no path".to_owned(),
                1 => "relayed".to_owned(),
                2 => format!("{near}, relay beside it"),
                _ => near.to_owned(),
            }
        });
        let recorded: Vec<String> = recorded.collect();
        let lost = lines.next_back().and_then(|line| number_of(line, "relayed_lost"));
        Ended { report, recording, seen, recorded, relayed_lost: lost.unwrap_or(f64::NAN) }
    }
}

/// What there is of one of two people when it is over.
struct Ended {
    report: Value,
    recording: PathBuf,
    seen: Vec<String>,
    recorded: Vec<String>,
    relayed_lost: f64,
}

/// Two people hold one cube for so long, with a browser each; each second somebody may do something to the network.
fn hold(mut people: [Person; 2], folder: &Path, seconds: f64, mut meanwhile: impl FnMut(f64)) -> [Ended; 2] {
    for person in &mut people {
        person.wait("document.getElementById('status').textContent.endsWith('has the other hand')");
    }
    let [one, two] = &mut people;
    let mut at = one.takes();
    two.takes();
    let begun = Instant::now();
    let (mut far, mut went) = (25.0, [f64::INFINITY, f64::NEG_INFINITY]);
    while begun.elapsed().as_secs_f64() < seconds {
        // Person 1 carries the cube to and fro, person 2 holds on to it.
        at = drag(&mut one.browser, &one.window, at, far);
        far = -far;
        one.looks();
        two.looks();
        let [object] = two.browser.numbers(&two.window, "[1e3 * page.value('object_1')]");
        went = [went[0].min(object), went[1].max(object)];
        meanwhile(begun.elapsed().as_secs_f64());
    }
    // Half-way between two hands that are alike.
    assert!((5.0..20.0).contains(&(went[1] - went[0])), "the cube went from {} to {} mm", went[0], went[1]);
    for (person, name) in [(&mut *one, "1.png"), (&mut *two, "2.png")] {
        person.browser.picture(&person.window, &folder.join(name));
    }
    let [one, two] = people;
    let ended = [one.ends(folder, 1), two.ends(folder, 2)];
    for ended in &ended {
        let (seen, recorded) = (changes(ended.seen.iter().map(String::as_str)), &ended.recorded);
        // Each path that a page named was one that was taken, in this order.
        let mut recorded = changes(recorded.iter().map(String::as_str)).into_iter();
        let true_ones = seen.iter().all(|path| recorded.by_ref().any(|other| other == *path));
        assert!(true_ones, "the page said {seen:?}, the recording has {:?}", ended.recorded);
        // Who ends last misses the other one, and tells it to no page.
        let recorded = changes(ended.recorded.iter().map(String::as_str));
        assert!(recorded.iter().rev().take(2).any(|path| Some(path) == seen.last()), "{seen:?}, {recorded:?}");
        let way = ended.report["path"]["way"].as_str().expect("a way");
        let last = match recorded[recorded.len() - 1] {
            "no path" => "nowhere",
            "LAN" => "direct",
            beside if beside.contains("beside") => "both",
            other => other,
        };
        assert_eq!(last, way, "{}", ended.report);
        eprintln!("{seen:?}, {}", ended.report["path"]);
    }
    let [one, two] = ended.each_ref().map(|ended| text(&ended.recording));
    let merged = Command::new(COHOLD).args(["recording", "merge", "--json", one, two]).output().expect("it runs");
    let merged: Value = serde_json::from_slice(&merged.stdout).expect("JSON");
    let number = |name: &str| merged[name].as_f64().unwrap_or(f64::NAN);
    eprintln!("{merged}");
    assert!(number("instants") > 500.0 * seconds && number("largest_true_discrepancy_mm") < 10.0, "{merged}");
    assert!(number("same_machine_less_this_us").abs() <= number("clock_error_us"), "{merged}");
    ended
}

/// A meeting place behind a network that loses this share of all that goes there and comes back. Its address.
fn lossy(place: String, share: f64) -> String {
    /// Whether the next one passes.
    fn passes(state: &mut u64, share: f64) -> bool {
        *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 32) as f64 >= share * f64::from(u32::MAX)
    }
    let front = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    let address = front.local_addr().expect("an address").to_string();
    std::thread::spawn(move || {
        let (mut backs, mut room, mut state) = (HashMap::new(), [0; 2048], 1);
        while let Ok((length, from)) = front.recv_from(&mut room) {
            let back = backs.entry(from).or_insert_with(|| {
                let back = UdpSocket::bind("127.0.0.1:0").expect("a socket");
                back.connect(&place).expect("an address");
                let [answers, front] = [&back, &front].map(|socket| socket.try_clone().expect("the same socket"));
                std::thread::spawn(move || {
                    let (mut room, mut state) = ([0; 2048], u64::from(from.port()));
                    while let Ok(length) = answers.recv(&mut room) {
                        if passes(&mut state, share) {
                            let _ = front.send_to(&room[..length], from);
                        }
                    }
                });
                back
            });
            if passes(&mut state, share) {
                let _ = back.send(&room[..length]);
            }
        }
    });
    address
}

/// On this machine, by a relay that loses a tenth of what goes there and of what comes from there.
#[test]
fn two_people_hold_one_cube_by_a_lossy_relay_and_are_told_so() {
    let folder = folder("relay");
    let mut command = Command::new(COHOLD);
    command.args(["meet", "--listen", "127.0.0.1:0"]);
    let meet = Running::start(command);
    let line = meet.says("meeting place on");
    let place = lossy(line.split_whitespace().nth(3).expect("an address").to_owned(), 0.1);
    let cohold = || Command::new(COHOLD);
    let one = Started::new(cohold(), &folder, 1, &["--invite", "--meet", &place, "--relay-only"]);
    let link = one.play.says("haptic://");
    let two = Started::new(cohold(), &folder, 2, &["--accept", &link, "--relay-only"]);
    let people = [(one, 1), (two, 2)].map(|(started, number)| started.opened(Command::new("sh"), &folder, number));
    for ended in hold(people, &folder, 5.0, |_| {}) {
        assert!(ended.recorded.iter().all(|path| path == "relayed" || path == "no path"), "{:?}", ended.recorded);
        // Twice a tenth of what is left.
        assert!((0.05..0.4).contains(&ended.relayed_lost), "{}", ended.relayed_lost);
        assert_eq!(ended.report["path"]["direct"]["signals"], 0, "no address was told");
    }
    meet.kill();
}

/// In two homes whose routers lose a hundredth of what passes, each; in the middle the direct path is cut and given back.
#[test]
#[ignore = "needs root, ip and nft, and takes minutes: cargo xtask test --only homes"]
fn two_people_in_two_homes_hold_one_cube_and_are_told_which_way_it_goes() {
    let folder = folder("two");
    let seconds = std::env::var("COHOLD_HOMES_S").map_or(SECONDS, |said| said.parse().expect("a time"));
    let mut lab = Lab::new([Router::Kept; 2], [false; 2]);
    lab.loses(1);
    let one = Started::new(lab.program("a", COHOLD), &folder, 1, &["--invite", "--meet", PLACE]);
    let link = one.play.says("haptic://");
    let two = Started::new(lab.program("b", COHOLD), &folder, 2, &["--accept", &link]);
    let people = [(one, 1, "a"), (two, 2, "b")]
        .map(|(started, number, home)| started.opened(lab.program(home, "sh"), &folder, number));
    let mut is_cut = false;
    let ended = hold(people, &folder, seconds, |now_s| {
        let wanted = (0.3..0.5).contains(&(now_s / seconds));
        if wanted != is_cut {
            lab.cut(wanted);
            is_cut = wanted;
        }
    });
    for ended in ended {
        for path in ["relayed", "direct"] {
            assert!(
                ended.seen.iter().any(|seen| seen == path),
                "the page has not said {path}: {:?}",
                changes(ended.seen.iter().map(String::as_str))
            );
        }
    }
    lab.closes();
}
