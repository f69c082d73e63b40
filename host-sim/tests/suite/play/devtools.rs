//! As much of a browser's debugging protocol as a test needs: the WebSocket that the page has anyway, and JSON.
//!
//! Chromium without a screen, with a profile of its own. `CHROMIUM` names another binary than the one on the path.

use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// Longest that a browser may take to start, and a page to come to what is waited for.
const PATIENCE: Duration = Duration::from_secs(30);

/// A browser, gone when dropped.
pub(super) struct Browser {
    child: Child,
    profile: PathBuf,
    socket: WebSocket<TcpStream>,
    calls: u64,
    events: Vec<Value>,
}

/// A window, by its session.
pub(super) struct Window(String);

impl Browser {
    /// Starts it, with a profile in this folder.
    pub(super) fn start(profile: PathBuf) -> Self {
        let binary = std::env::var("CHROMIUM").unwrap_or_else(|_| "chromium".into());
        let _ = std::fs::remove_dir_all(&profile);
        std::fs::create_dir_all(&profile).expect("a folder");
        let child = Command::new(&binary)
            .args(["--headless=new", "--no-sandbox", "--remote-debugging-port=0", "--no-first-run", "--disable-gpu"])
            .args(["--disable-dev-shm-usage", "--disable-background-networking", "--disable-component-update"])
            .args(["--disable-sync", "--hide-scrollbars", "--window-size=1000,1200", "--touch-events=enabled"])
            .args(["about:blank", &format!("--user-data-dir={}", profile.display())])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap_or_else(|cause| {
                panic!(
                    "{binary}: {cause}: install Debian's chromium, as `cargo xtask test` does, or name one in CHROMIUM"
                )
            });
        // Port and path are in this file once it listens.
        let said = profile.join("DevToolsActivePort");
        let start = Instant::now();
        let (port, path) = loop {
            let text = std::fs::read_to_string(&said).unwrap_or_default();
            if let Some((port, path)) = text.trim().split_once('\n') {
                break (port.to_owned(), path.to_owned());
            }
            assert!(start.elapsed() < PATIENCE, "{binary} does not listen");
            std::thread::sleep(Duration::from_millis(20));
        };
        let stream = TcpStream::connect(format!("127.0.0.1:{port}")).expect("the browser listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        let (socket, _) =
            tungstenite::client(format!("ws://127.0.0.1:{port}{path}"), stream).expect("the browser talks");
        Self { child, profile, socket, calls: 0, events: Vec::new() }
    }

    fn send(&mut self, session: Option<&str>, method: &str, params: &Value) -> Value {
        self.calls += 1;
        let mut call = json!({ "id": self.calls, "method": method, "params": params });
        if let Some(session) = session {
            call["sessionId"] = session.into();
        }
        self.socket.send(Message::text(call.to_string())).expect("the browser listens");
        loop {
            let Message::Text(text) = self.socket.read().expect("the browser answers") else { continue };
            let mut said: Value = serde_json::from_str(&text).expect("JSON");
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
        let _ = self.socket.send(Message::text(json!({ "id": 0, "method": "Browser.close" }).to_string()));
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
