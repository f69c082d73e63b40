//! The operator's client over a real socket: against an end that does what a board does, and against nobody.

use std::net::{SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use haptic_protocol::ends::Ends;
use haptic_protocol::key::Key;
use haptic_protocol::lines::{Heard, Lines};
use haptic_protocol::link::{Config, Link, Notice};
use haptic_protocol::parameters::{Parameters, Table};
use haptic_protocol::wire::{MAX_DATAGRAM, PeerId, Sample};
use haptic_sim::key_file;
use host_sim::live::operator::Operator;

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Board 2: answers every line with `ok` and the line, `no` with an error, and sends a sample after each. Told to stream
/// every tick, it sends ticks, until it is told not to, or its operator was silent for as long as a board bears it. `away` pulls its cable.
struct Board {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    away: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Board {
    fn start(key: Key, version: f64) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
        let address = socket.local_addr().unwrap();
        let [stop, away] = [(); 2].map(|()| Arc::new(AtomicBool::new(false)));
        let (over, out_of_reach) = (stop.clone(), away.clone());
        let thread = std::thread::spawn(move || {
            let mut parameters = Parameters::new();
            parameters.add(Table::new("operator").number("version", version)).unwrap();
            let ends = Ends { local: PeerId(2), remote: PeerId(0) };
            let config = Config { key, ends, packet_period_us: 20_000, parameters, entropy: [9; 32] };
            let (mut link, mut lines) = (Link::new(config).unwrap(), Lines::default());
            let (start, mut came, mut out, mut to) = (Instant::now(), [0; 2048], [0; MAX_DATAGRAM], None);
            let mut streams = false;
            while !over.load(Ordering::Relaxed) {
                let now = start.elapsed().as_micros() as u64;
                let away = out_of_reach.load(Ordering::Relaxed);
                let send = |bytes: &[u8], to: SocketAddr| away || socket.send_to(bytes, to).is_ok();
                if let Ok((length, from)) = socket.recv_from(&mut came)
                    && !away
                    && link.receive(now, &mut came[..length]).is_ok()
                {
                    to = Some(from);
                }
                while let Some(notice) = link.take_notice() {
                    if matches!(notice, Notice::NewPeer(_) | Notice::Lost) {
                        streams = false;
                        lines.forget();
                    }
                }
                let Some(to) = to else { continue };
                let mut sample = streams.then(|| {
                    let mut record = [0; 92];
                    record[..4].copy_from_slice(&((now / 1000) as u32).to_le_bytes());
                    Sample::new(7, &record).unwrap()
                });
                if let Some(Heard { line, .. }) = lines.hear(now, &mut link) {
                    lines.say(&if line == "no" { "error never".to_owned() } else { format!("ok {line}") });
                    sample = Some(Sample::new(7, line.as_bytes()).unwrap());
                    streams = line == "stream 1";
                }
                if let Some(length) = sample.and_then(|sample| link.send(now, sample, &mut out)) {
                    assert!(send(&out[..length], to));
                }
                lines.push(&mut link);
                while let Some(length) = link.poll(now, &mut out) {
                    assert!(send(&out[..length], to));
                }
            }
        });
        Self { address, stop, away, thread: Some(thread) }
    }
}

impl Drop for Board {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        let _ = self.thread.take().map(std::thread::JoinHandle::join);
    }
}

#[test]
fn lines_are_answered_and_samples_come_under_the_right_key_only() {
    let folder = folder("operator");
    let (right, wrong) = (folder.join("right.key"), folder.join("wrong.key"));
    key_file::generate(&right).unwrap();
    key_file::generate(&wrong).unwrap();
    let board = Board::start(key_file::read(&right).unwrap(), 1.0);

    let mut operator = Operator::connect(board.address, &right).unwrap();
    assert_eq!(operator.number(), 2);
    let long = "set coordination.wave_impedance_n_s_per_m 10.000000000000002";
    assert_eq!(operator.ask(long), Ok(format!("ok {long}")));
    assert_eq!(operator.ask("arm"), Ok("ok arm".to_owned()));
    let samples = operator.samples(Duration::from_millis(20)).unwrap();
    assert_eq!(samples.iter().map(|sample| sample.payload().to_vec()).collect::<Vec<_>>(), [long.as_bytes(), b"arm"]);
    assert!(operator.ask(&"x".repeat(400)).unwrap_err().contains("at most 384"));

    // The next operator takes over; from the command line.
    let run = |key: &Path, lines: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        command.args(["board", "operator", "--board", &board.address.to_string(), "--key-file"]).arg(key).args(lines);
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    assert_eq!(run(&right, &["status", "get a"]), (Some(0), "ok status\nok get a\n".into(), String::new()));
    let refused = "host-sim: board 2: no: never\n";
    assert_eq!(run(&right, &["one", "no", "two"]), (Some(2), "ok one\n".into(), refused.into()));
    // A board that never sends a tick is no reason for an empty file.
    let file = folder.join("ticks.csv");
    let (status, said, why) = run(&right, &["status", "--seconds", "0.1", "--record", &file.display().to_string()]);
    assert_eq!((status, said.as_str(), file.exists()), (Some(2), "ok status\n", false));
    assert_eq!(why, "host-sim: board 2: no tick came in 0.1 s\n");
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, "[object]\nmass_kg = 0.5\n").unwrap();
    let (status, said, why) = run(&right, &["--scene", &scene.display().to_string(), "status"]);
    assert_eq!((status, said.as_str()), (Some(0), "ok status\n"));
    assert!(why.starts_with("1 settings of "), "{why}");
    let (status, said, why) = run(&wrong, &["disarm"]);
    assert_eq!((status, said.as_str()), (Some(2), ""));
    assert!(why.contains("nobody who holds the key of") && why.lines().count() == 1, "{why}");
}

/// Why: a cable that was out for a quarter of a second ended a recording in silence, and one that was out at its end took
/// all of it away.
#[test]
fn a_recording_outlives_the_cable() {
    let folder = folder("operator-cable");
    let (key, file) = (folder.join("a.key"), folder.join("ticks.csv"));
    key_file::generate(&key).unwrap();
    let board = Board::start(key_file::read(&key).unwrap(), 1.0);
    let record = |seconds: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_host-sim"));
        command.args([
            "board",
            "operator",
            "--board",
            &board.address.to_string(),
            "--every",
            "1",
            "--seconds",
            seconds,
        ]);
        command.arg("--key-file").arg(&key).arg("--record").arg(&file);
        command.stderr(Stdio::piped()).spawn().unwrap()
    };
    let said = |child: Child| {
        let output = child.wait_with_output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    let times = || -> Vec<f64> {
        let text = std::fs::read_to_string(&file).unwrap();
        text.lines().skip(1).map(|line| line.split(',').next().unwrap().parse().unwrap()).collect()
    };
    let out = |out: bool, ms: u64| {
        board.away.store(out, Ordering::Relaxed);
        std::thread::sleep(Duration::from_millis(ms));
    };

    let child = record("4");
    out(false, 1500);
    out(true, 800);
    out(false, 0);
    let (status, why) = said(child);
    assert_eq!((status, why.lines().count()), (Some(0), 1), "{why}");
    assert!(why.contains(" ticks written to ") && why.contains("; none came from "), "{why}");
    let times = times();
    let gap = times.windows(2).map(|two| two[1] - two[0]).fold(0.0, f64::max);
    assert!(gap > 0.7, "{gap} s without a tick");
    let after = times.last().unwrap() - times.windows(2).find(|two| two[1] - two[0] == gap).unwrap()[1];
    assert!(after > 0.0, "ticks come again after the gap");

    std::fs::remove_file(&file).unwrap();
    let child = record("2");
    out(false, 1500);
    out(true, 0);
    let (status, why) = said(child);
    assert_eq!((status, why.lines().count()), (Some(2), 2), "{why}");
    assert!(why.contains(" ticks written to ") && why.contains("no answer from "), "{why}");
    assert!(file.exists());
}

#[test]
fn a_board_that_takes_other_commands_is_named() {
    let key = folder("operator-version").join("a.key");
    key_file::generate(&key).unwrap();
    let board = Board::start(key_file::read(&key).unwrap(), 2.0);
    let error = Operator::connect(board.address, &key).map(|_| ()).unwrap_err();
    assert!(error.contains("takes other commands than this program"), "{error}");
}

#[test]
fn a_key_image_is_the_keys_and_is_never_overwritten() {
    let folder = folder("key-image");
    let (key, image) = (folder.join("a.key"), folder.join("a.bin"));
    key_file::generate(&key).unwrap();
    let make = || {
        Command::new(env!("CARGO_BIN_EXE_host-sim"))
            .args(["key".as_ref(), "image".as_ref(), key.as_os_str(), image.as_os_str()])
            .output()
    };
    assert!(make().unwrap().status.success());
    let bytes = std::fs::read(&image).unwrap();
    assert_eq!(Key::from_image(&bytes.try_into().unwrap()), key_file::read(&key).ok());
    assert_eq!(make().unwrap().status.code(), Some(2));
}
