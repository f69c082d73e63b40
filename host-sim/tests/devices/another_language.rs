//! A service in another language goes wrong: service.py, from RFC 6455 and the vendor's messages alone, which needs Python 3 and nothing else.

use std::io::{BufRead, BufReader, Write};
use std::path::Path;
use std::process::{Child, Stdio};
use std::time::Duration;

use serde_json::{Value, json};

use super::{armed, number};
use crate::program::{in_python, signal};

/// How old a reading may be here, s: twice the default, as the service may have to wait for a processor.
const SILENT_S: f64 = 0.1;
/// What a busy machine may take until a thread runs, s. A reading that is believed fresh for ever is over a second old by the end.
const BUSY_S: f64 = 0.4;

/// The service in Python, and where it listens. It is ended when it is dropped.
struct Service(Child, String);

impl Service {
    fn start(wrong: &str) -> Self {
        let mut command = in_python(Path::new("tests/devices/service.py"), &json!({ "wrong": wrong }));
        let child = command.stdin(Stdio::piped()).spawn().expect("these tests need Python 3");
        let mut service = Self(child, String::new());
        let mut said = BufReader::new(service.0.stderr.as_mut().expect("kept"));
        said.read_line(&mut service.1).expect("text");
        service.1 = service.1.trim().rsplit(' ').next().expect("a word").to_owned();
        service
    }

    fn order(&mut self, words: &str) {
        writeln!(self.0.stdin.as_mut().expect("kept"), "{words}").expect("it reads");
    }

    /// What was asked of it since it went wrong.
    fn told(mut self) -> Value {
        let mut told = String::new();
        BufReader::new(self.0.stdout.as_mut().expect("kept")).read_line(&mut told).expect("text");
        serde_json::from_str(&told).expect("JSON")
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// A hand holds an object by a device whose service goes wrong in this way. Gives what was asked of the service, and the fault.
fn goes_wrong(wrong: &str) -> (Value, String) {
    let mut service = Service::start(wrong);
    let device = format!("haply:{}", service.1);
    let silent = SILENT_S.to_string();
    let more = ["--device", &device, "--device-lets-go-s", "0.02", "--device-silent-s", &silent];
    let [first, second] = armed(&format!("devices-service-{wrong}"), "any-network", "60", &more);
    service.order("reach");
    std::thread::sleep(Duration::from_millis(1_500));
    service.order("go wrong");
    let told = service.told();
    let (ended, live, said) = first.end();
    let fault = live["fault"].as_str().unwrap_or_default().to_owned();
    assert!(!ended && said.contains("the motors are off: fault"), "{said}\n{live}");
    signal(&second.child, "INT");
    let (_, other, said) = second.end();
    let told_other = other["other"]["state"].as_str().unwrap_or_default();
    assert!(told_other.starts_with("fault ") && fault.starts_with(told_other), "{said}\n{fault}: {other}");
    println!("{wrong}: {told}; {fault}");
    assert!(
        number(&told, "most_before_n") > 1.0 && number(&told, "oldest_before_s") < SILENT_S,
        "it was well before: {told}"
    );
    (told, fault)
}

/// It says states that nobody asked for. Whoever took them for answers would believe older and older readings.
#[test]
fn a_service_that_says_what_nobody_asked_for_is_let_go_of_at_once() {
    let (told, fault) = goes_wrong("unasked");
    assert!(fault.starts_with("fault 24: ") && fault.contains("nobody asked for"), "{fault}");
    // By count, which a busy machine does not change: the second state is there at the next look, or at the one after that.
    assert!(number(&told, "pushes") <= 5.0 && told["gone"] == true, "{told}");
    assert!(number(&told, "oldest_s") < SILENT_S + BUSY_S, "{told}");
}

/// The same, and before each state a ping. A look that takes the ping for all that has come misses the state behind it: readings became 1.5 s old within 3 s, and were
/// believed fresh.
#[test]
fn a_state_that_nobody_asked_for_is_seen_behind_a_ping() {
    let (told, fault) = goes_wrong("hidden");
    assert!(number(&told, "oldest_s") < SILENT_S + BUSY_S && told["gone"] == true, "{told}");
    assert!(fault.starts_with("fault 24: ") && fault.contains("nobody asked for"), "{fault}");
}

/// It says the same moving state for ever, to each question at once. So each answer is new, and none of them is news.
#[test]
fn a_service_whose_moving_state_is_frozen_is_let_go_of_in_time() {
    let (told, fault) = goes_wrong("frozen");
    assert!(fault.starts_with("fault 23: ") && fault.contains("ms old, of 100 allowed"), "{fault}");
    // No force rests on a place that is older than readings may be.
    assert!(number(&told, "asked") > 5.0 && number(&told, "pushes") > 0.0, "{told}");
    assert!(
        number(&told, "oldest_s") < SILENT_S + BUSY_S && number(&told, "last_push_s") < SILENT_S + BUSY_S,
        "{told}"
    );
}
