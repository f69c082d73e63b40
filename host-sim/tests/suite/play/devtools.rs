//! As much of a browser's debugging protocol as a test needs: JSON over two pipes, which reach a browser in any network namespace.
//!
//! Chromium without a screen, with a profile of its own. `CHROMIUM` names another binary than the one on the path.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Longest that a browser may take to start, and a page to come to what is waited for.
const PATIENCE: Duration = Duration::from_secs(30);

/// A browser, gone when dropped.
pub(super) struct Browser {
    child: Child,
    profile: PathBuf,
    says: ChildStdin,
    /// What it says, each a message.
    said: Receiver<Vec<u8>>,
    calls: u64,
    events: Vec<Value>,
}

/// A window, by its session.
pub(super) struct Window(String);

impl Browser {
    /// Starts it, with a profile in this folder.
    pub(super) fn start(profile: PathBuf) -> Self {
        Self::start_by(Command::new("sh"), profile)
    }

    /// Starts it by a shell that somebody has prepared, with a profile in this folder.
    pub(super) fn start_by(mut shell: Command, profile: PathBuf) -> Self {
        let binary = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".into());
        let _ = std::fs::remove_dir_all(&profile);
        std::fs::create_dir_all(&profile).expect("a folder");
        // It reads what it is told from 3, and answers on 4.
        let mut child = shell
            .args(["-c", "exec \"$0\" \"$@\" 3<&0 4>&1 </dev/null >/dev/null", &binary])
            .args(["--headless=new", "--no-sandbox", "--remote-debugging-pipe", "--no-first-run", "--disable-gpu"])
            .args(["--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update"])
            .args(["--disable-sync", "--hide-scrollbars", "--window-size=1000,1200", "--touch-events=enabled"])
            .args(["about:blank", &format!("--user-data-dir={}", profile.display())])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("a shell runs");
        let (says, answers) = (child.stdin.take().expect("a pipe"), child.stdout.take().expect("a pipe"));
        let (put, said) = channel();
        std::thread::spawn(move || {
            let messages = BufReader::new(answers).split(0).map_while(Result::ok);
            messages.for_each(|message| drop(put.send(message)));
        });
        let mut browser = Self { child, profile, says, said, calls: 0, events: Vec::new() };
        let there = browser.tell(&json!({ "id": 0, "method": "Browser.getVersion" })) && browser.hear().is_some();
        assert!(
            there,
            "{binary} says nothing: install Debian's chromium, as `cargo xtask test` does, or name one in CHROMIUM"
        );
        browser
    }

    /// Sends a message; whether the browser is there.
    fn tell(&mut self, message: &Value) -> bool {
        self.says.write_all(format!("{message}\0").as_bytes()).and_then(|()| self.says.flush()).is_ok()
    }

    /// The next message, if one comes.
    fn hear(&mut self) -> Option<Value> {
        let message = self.said.recv_timeout(PATIENCE).ok()?;
        Some(serde_json::from_slice(&message).expect("JSON"))
    }

    fn send(&mut self, session: Option<&str>, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let mut call = json!({ "id": self.calls, "method": method, "params": params });
        if let Some(session) = session {
            call["sessionId"] = session.into();
        }
        assert!(self.tell(&call), "the browser listens");
        loop {
            let mut said = self.hear().expect("the browser answers");
            if said["id"] == self.calls {
                assert!(said["error"].is_null(), "{method}: {}", said["error"]);
                return said["result"].take();
            }
            self.events.push(said);
        }
    }

    /// Opens a window of its own: of two tabs in one window, one is in the background and draws nothing.
    pub(super) fn open(&mut self, url: &str) -> Window {
        let target = self.send(None, "Target.createTarget", &json!({ "url": "about:blank", "newWindow": true }));
        let attach = json!({ "targetId": target["targetId"], "flatten": true });
        let session = self.send(None, "Target.attachToTarget", &attach);
        let window = Window(session["sessionId"].as_str().expect("a session").to_owned());
        for domain in ["Page.enable", "Runtime.enable", "Log.enable"] {
            self.call(&window, domain, json!({}));
        }
        // Keys reach a window that believes it is in front.
        self.call(&window, "Emulation.setFocusEmulationEnabled", json!({ "enabled": true }));
        self.call(&window, "Page.navigate", json!({ "url": url }));
        window
    }

    pub(super) fn call(&mut self, window: &Window, method: &str, params: Value) -> Value {
        self.send(Some(&window.0), method, &params)
    }

    /// What an expression gives, awaited.
    pub(super) fn evaluate(&mut self, window: &Window, expression: &str) -> Value {
        let params = json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut outcome = self.call(window, "Runtime.evaluate", params);
        assert!(outcome["exceptionDetails"].is_null(), "{expression}: {}", outcome["exceptionDetails"]);
        outcome["result"]["value"].take()
    }

    /// Numbers that an expression gives as a list, once all are there: a page that begins again has none for a moment.
    #[track_caller]
    pub(super) fn numbers<const N: usize>(&mut self, window: &Window, expression: &str) -> [f64; N] {
        let start = Instant::now();
        loop {
            let value = self.evaluate(window, expression);
            let numbers: [Option<f64>; N] = std::array::from_fn(|at| value[at].as_f64());
            if numbers.iter().all(Option::is_some) {
                return numbers.map(Option::unwrap_or_default);
            }
            assert!(start.elapsed() < PATIENCE, "no numbers: {expression}: {value}");
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// Until an expression is true.
    #[track_caller]
    pub(super) fn wait(&mut self, window: &Window, expression: &str) {
        let start = Instant::now();
        let wanted = format!("(() => {{ try {{ return Boolean({expression}); }} catch {{ return false; }} }})()");
        while self.evaluate(window, &wanted) != true {
            if start.elapsed() > PATIENCE {
                let page = self.evaluate(window, "document.body.innerText");
                panic!("never: {expression}\n{page}\n{:?}", self.complaints(&[window]));
            }
            std::thread::sleep(Duration::from_millis(30));
        }
    }

    /// Mouse: "mousePressed", "mouseMoved" or "mouseReleased", in pixels of the window.
    pub(super) fn mouse(&mut self, window: &Window, kind: &str, [x, y]: [f64; 2]) {
        let event = json!({ "type": kind, "x": x, "y": y, "button": "left", "buttons": 1, "clickCount": 1 });
        self.call(window, "Input.dispatchMouseEvent", event);
    }

    /// A key, pressed.
    pub(super) fn key(&mut self, window: &Window, key: &str) {
        self.call(window, "Input.dispatchKeyEvent", json!({ "type": "keyDown", "key": key, "code": key }));
    }

    /// A key as a keyboard sends it, which moves the focus and presses buttons as well; with Shift, or without.
    pub(super) fn press(&mut self, window: &Window, key: &str, shift: bool) {
        let (code, text) = match key {
            "Tab" => (9, ""),
            "Enter" => (13, "\r"),
            "End" => (35, ""),
            "Home" => (36, ""),
            "ArrowLeft" => (37, ""),
            "ArrowRight" => (39, ""),
            _ => panic!("{key}: its number is not known"),
        };
        for kind in ["keyDown", "keyUp"] {
            let mut event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code });
            event["modifiers"] = json!(if shift { 8 } else { 0 });
            if kind == "keyDown" && !text.is_empty() {
                event["text"] = text.into();
            }
            self.call(window, "Input.dispatchKeyEvent", event);
        }
    }

    /// Where what pages save goes.
    pub(super) fn downloads(&mut self, folder: &Path) {
        let allow = json!({ "behavior": "allow", "downloadPath": folder.display().to_string() });
        self.send(None, "Browser.setDownloadBehavior", &allow);
    }

    /// The window as a PNG.
    pub(super) fn picture(&mut self, window: &Window, file: &Path) {
        let picture = self.call(window, "Page.captureScreenshot", json!({ "format": "png" }));
        std::fs::write(file, from_base64(picture["data"].as_str().expect("a picture"))).expect("a file");
    }

    /// Processor time of the browser's processes so far, s, as the system counts it.
    pub(super) fn processor_s(&self) -> f64 {
        /// Clock ticks in a second, as Linux counts the time of processes.
        const PER_S: f64 = 100.0;
        let processes = std::fs::read_dir("/proc").expect("a system that has it").flatten();
        // Its number, its parent's, and what it took: the words behind the name, which may hold anything.
        let read = |process: std::fs::DirEntry| {
            let stat = std::fs::read_to_string(process.path().join("stat")).ok()?;
            let (number, rest) = stat.split_once(' ')?;
            let words: Vec<&str> = rest.rsplit_once(')')?.1.split_whitespace().collect();
            let of = |at: usize| words.get(at)?.parse::<u64>().ok();
            Some((number.parse::<u64>().ok()?, of(1)?, of(11)? + of(12)?))
        };
        let all: Vec<_> = processes.filter_map(read).collect();
        let (mut ours, mut sum) = (vec![u64::from(self.child.id())], 0);
        let mut at = 0;
        while let Some(process) = ours.get(at).copied() {
            ours.extend(all.iter().filter(|(_, parent, _)| *parent == process).map(|(number, ..)| *number));
            sum += all.iter().find(|(number, ..)| *number == process).map_or(0, |(.., took)| *took);
            at += 1;
        }
        sum as f64 / PER_S
    }

    /// What these windows complained about: exceptions, refused policies, errors.
    pub(super) fn complaints(&self, windows: &[&Window]) -> Vec<&Value> {
        let ours = |event: &&Value| windows.iter().any(|window| event["sessionId"] == window.0);
        let bad = |event: &&Value| {
            event["method"] == "Runtime.exceptionThrown" || event["params"]["entry"]["level"] == "error"
        };
        self.events.iter().filter(ours).filter(bad).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        // Asked to, it ends its own processes as well; killed, it would leave them.
        self.tell(&json!({ "id": 0, "method": "Browser.close" }));
        for _ in 0..200 {
            if !matches!(self.child.try_wait(), Ok(None)) {
                break;
            }
            std::thread::sleep(Duration::from_millis(20));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        let _ = std::fs::remove_dir_all(&self.profile);
    }
}

/// The middle of an element, pixels.
pub(super) fn middle(browser: &mut Browser, window: &Window, id: &str) -> [f64; 2] {
    let expression = format!(
        "(() => {{ const r = document.getElementById('{id}').getBoundingClientRect(); \
         return [r.x + r.width / 2, r.y + r.height / 2]; }})()"
    );
    browser.numbers(window, &expression)
}

/// Moves a pressed mouse by so many mm of the scene, as a hand does, in 40 frames.
pub(super) fn drag(browser: &mut Browser, window: &Window, [x, y]: [f64; 2], mm: f64) -> [f64; 2] {
    let [per_mm] = browser.numbers(window, "[scene.getScreenCTM().a]");
    for step in 1..=40 {
        browser.mouse(window, "mouseMoved", [x + per_mm * mm * f64::from(step) / 40.0, y]);
        std::thread::sleep(Duration::from_millis(16));
    }
    [x + per_mm * mm, y]
}

fn from_base64(text: &str) -> Vec<u8> {
    let digit = |byte: u8| match byte {
        b'A'..=b'Z' => byte - b'A',
        b'a'..=b'z' => byte - b'a' + 26,
        b'0'..=b'9' => byte - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let mut bytes = Vec::new();
    for four in text.trim_end_matches('=').as_bytes().chunks(4) {
        let bits = four.iter().fold(0_u32, |bits, byte| bits << 6 | u32::from(digit(*byte))) << (6 * (4 - four.len()));
        bytes.extend(&bits.to_be_bytes()[1..four.len()]);
    }
    bytes
}
