//! Processes of a meeting, and what they say.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::Value;

pub(crate) const COHOLD: &str = env!("CARGO_BIN_EXE_cohold");
/// Nothing takes longer to begin, however busy the machine is.
const PATIENCE: Duration = Duration::from_secs(60);

/// A process that is ended when it is dropped.
pub(crate) struct Running {
    child: Child,
    lines: Receiver<String>,
}

impl Running {
    pub(crate) fn start(mut command: Command) -> Self {
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("it starts");
        let (say, lines) = channel();
        let error: ChildStderr = child.stderr.take().expect("standard error");
        std::thread::spawn(move || {
            BufReader::new(error).lines().map_while(Result::ok).for_each(|line| drop(say.send(line)));
        });
        Self { child, lines }
    }

    /// The next line on standard error that has this in it.
    pub(crate) fn says(&self, what: &str) -> String {
        let until = Instant::now() + PATIENCE;
        while let Ok(line) = self.lines.recv_timeout(until.saturating_duration_since(Instant::now())) {
            if line.contains(what) {
                return line;
            }
        }
        panic!("it does not say {what:?}");
    }

    /// Asks it to end.
    pub(crate) fn interrupt(&self) {
        self.signal("INT");
    }

    /// Sends it this signal of the system.
    pub(crate) fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args(["-s", name, &id]).status().expect("kill runs").success());
    }

    pub(crate) fn kill(mut self) {
        self.child.kill().expect("it is ended");
        let _ = self.child.wait();
    }

    /// Whether it ended well, and its standard output.
    pub(crate) fn end(mut self) -> (bool, String) {
        let mut said = String::new();
        self.child.stdout.take().expect("standard output").read_to_string(&mut said).expect("text");
        (self.child.wait().expect("it ends").success(), said)
    }

    /// What a peer has reported, and the changes of its path: when, s, and to what.
    pub(crate) fn report(self) -> Told {
        let (good, said) = self.end();
        let lines: Vec<Value> = said.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
        let of = |kind: &'static str| lines.iter().filter(move |line| line["kind"] == kind);
        let ways = of("path").map(|line| {
            (line["time_s"].as_f64().expect("a time"), line["path"]["way"].as_str().expect("a way").to_owned())
        });
        let ways = ways.collect();
        let notices = of("notice").map(|line| (line["time_s"].as_f64().expect("a time"), line["notice"].to_string()));
        let notices = notices.collect();
        let report = of("report").next().cloned().unwrap_or_else(|| panic!("it has reported ({good}): {said}"));
        Told { report, ways, notices }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// What a peer has told.
#[derive(Debug)]
pub(crate) struct Told {
    pub(crate) report: Value,
    pub(crate) ways: Vec<(f64, String)>,
    pub(crate) notices: Vec<(f64, String)>,
}

impl Told {
    /// When flow first went one of these ways, s.
    pub(crate) fn first(&self, ways: &[&str]) -> Option<f64> {
        self.ways.iter().find(|(_, way)| ways.contains(&way.as_str())).map(|(at, _)| *at)
    }

    /// When this was noticed first, s.
    pub(crate) fn noticed(&self, what: &str) -> Option<f64> {
        self.notices.iter().find(|(_, notice)| notice.contains(what)).map(|(at, _)| *at)
    }

    pub(crate) fn way(&self) -> &str {
        self.report["path"]["way"].as_str().expect("a way")
    }

    pub(crate) fn number(&self, path: &str) -> f64 {
        self.report.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path} in {}", self.report))
    }
}

/// A peer that pushes gently, for so many seconds, a packet each tick; `more` says whom it meets and how.
pub(crate) fn peer(mut command: Command, seconds: u32, more: &[&str]) -> Running {
    command.args(["peer", "--json-lines", "--anyway", "--seconds", &seconds.to_string(), "--patience-s", "30"]);
    command.args(["--set", "timing.ticks_per_packet=1", "--set", "user.1.push_n=1", "--set", "user.2.push_n=1"]);
    command.args(more);
    Running::start(command)
}
