//! The operator's client over a real socket: against an end that does what a board does, and against nobody.

use std::net::{SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use cohold_board_tools::operator::UNCONFIRMED;
use cohold_live::key_file;
use cohold_live::operator::Operator;
use cohold_protocol::ends::Ends;
use cohold_protocol::key::{Key, Role};
use cohold_protocol::lease::{AtBoard, Holder, Motors, Word};
use cohold_protocol::lines::{Heard, Lines};
use cohold_protocol::link::{Config, Link, Notice};
use cohold_protocol::parameters::{Parameters, Table};
use cohold_protocol::wire::{MAX_DATAGRAM, PeerId, Sample};

use crate::declared::has_columns_of;

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

/// Board 2: answers every line with `ok` and the line, `no` with an error, and sends a sample after each. Asked to stream
/// every tick, it sends ticks, until it is asked not to, or its operator was silent for as long as a board bears it. `away` pulls its cable.
/// `armed` says whether its motors are on, by its lease.
/// Asked for a key it says what a board says, and shares so many axes as it is told to say.
struct Board {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    away: Arc<AtomicBool>,
    armed: Arc<AtomicBool>,
    thread: Option<std::thread::JoinHandle<()>>,
}

impl Board {
    fn start(key: Key, version: f64) -> Self {
        Self::sharing("1", key, version)
    }

    fn sharing(axes: &'static str, key: Key, version: f64) -> Self {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_read_timeout(Some(Duration::from_millis(2))).unwrap();
        let address = socket.local_addr().unwrap();
        let [stop, away, armed] = [(); 3].map(|()| Arc::new(AtomicBool::new(false)));
        let (over, out_of_reach, on) = (stop.clone(), away.clone(), armed.clone());
        let thread = std::thread::spawn(move || {
            let mut parameters = Parameters::new();
            parameters.add(Table::new("operator").number("version", version)).unwrap();
            let ends = Ends { local: PeerId(2), remote: PeerId(0) };
            let config = Config { key, ends, packet_period_us: 20_000, parameters, entropy: [9; 32] };
            let (mut link, mut lines) = (Link::new(config).unwrap(), Lines::default());
            let (start, mut came, mut out, mut to) = (Instant::now(), [0; 2048], [0; MAX_DATAGRAM], None);
            let (mut streams, mut logs, mut holder) = (false, None, Holder::new(194_000));
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
                    if matches!(notice, Notice::NewPeer(_)) {
                        holder.step(now, AtBoard::Session).unwrap();
                    }
                    if matches!(notice, Notice::NewPeer(_) | Notice::Lost) {
                        streams = false;
                        lines.forget();
                    }
                }
                let said = link.heard().map(|(word, echo_us)| AtBoard::Heard { word: Word::of_byte(word), echo_us });
                said.into_iter().chain([AtBoard::Look]).for_each(|event| holder.step(now, event).unwrap());
                let Some(to) = to else { continue };
                let mut sample = streams.then(|| {
                    let mut record = [0; 108];
                    record[..4].copy_from_slice(&((now / 1000) as u32).to_le_bytes());
                    Sample::new(7, &record).unwrap()
                });
                if let Some(Heard { line, word, .. }) = lines.hear(now, &mut link) {
                    let start =
                        line.starts_with("arm").then(|| AtBoard::Start { word, alone: line.ends_with("alone") });
                    let answer = match line.as_str() {
                        "no" => "error never".to_owned(),
                        "get timing.control_period_s" => "ok timing.control_period_s = 0.001".to_owned(),
                        "get axis.shared" => format!("ok axis.shared = {axes}"),
                        "spell" => "ok armed\u{1b}[2J\u{9b}31m\nwarning: none\u{7}".to_owned(),
                        line => format!("ok {line}"),
                    };
                    start.into_iter().for_each(|start| holder.step(now, start).unwrap());
                    lines.say(&answer, Word::default());
                    sample = Some(Sample::new(7, line.as_bytes()).unwrap());
                    streams = line == "stream 1";
                    logs = streams.then(|| format!("log {now} peer: fading\u{1b}[2J"));
                }
                if !lines.is_saying()
                    && let Some(line) = logs.take()
                {
                    lines.say(&line, Word::default());
                }
                if let Some(length) = sample.and_then(|sample| link.send(now, sample, &mut out)) {
                    assert!(send(&out[..length], to));
                }
                lines.push(&mut link);
                on.store(holder.motors() != Motors::Off, Ordering::Relaxed);
                link.say_lease(holder.told(false).byte(), false);
                while let Some(length) = link.poll(now, &mut out) {
                    assert!(send(&out[..length], to));
                }
            }
        });
        Self { address, stop, away, armed, thread: Some(thread) }
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
    key_file::generate(&right, Role::Operator).unwrap();
    key_file::generate(&wrong, Role::Operator).unwrap();
    let board = Board::start(key_file::read(&right, Role::Operator).unwrap(), 2.0);

    let mut operator = Operator::connect(board.address, &right).unwrap();
    assert_eq!(operator.number, 2);
    let long = "set coordination.wave_impedance_n_s_per_m 10.000000000000002";
    assert_eq!(operator.ask(long).unwrap(), format!("ok {long}"));
    assert_eq!(operator.ask("arm").unwrap(), "ok arm");
    let samples = operator.samples(Duration::from_millis(20)).unwrap();
    let lines: [&[u8]; 2] = [long.as_bytes(), b"arm"];
    assert_eq!(samples.iter().map(|sample| sample.payload().to_vec()).collect::<Vec<_>>(), lines);
    assert!(operator.ask(&"x".repeat(400)).unwrap_err().to_string().contains("at most 384"));

    // The next operator takes over; from the command line.
    let run = |key: &Path, lines: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
        command.args(["board", "operator", "--board", &board.address.to_string(), "--key-file"]).arg(key).args(lines);
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    assert_eq!(run(&right, &["status", "get a"]), (Some(0), "ok status\nok get a\n".into(), String::new()));
    let refused = "cohold: board 2: no: never\n";
    assert_eq!(run(&right, &["one", "no", "two"]), (Some(2), "ok one\n".into(), refused.into()));
    // A board that never sends a tick is no reason for an empty file.
    let file = folder.join("ticks.csv");
    let (status, said, why) = run(&right, &["status", "--seconds", "0.1", "--record", &file.display().to_string()]);
    assert_eq!((status, said.as_str(), file.exists()), (Some(2), "ok status\n", false));
    assert_eq!(why, "cohold: board 2: no tick came in 0.1 s\n");
    let scene = folder.join("scene.toml");
    std::fs::write(&scene, "[object]\nmass_kg = 0.5\n").unwrap();
    let (status, said, why) = run(&right, &["--scene", &scene.display().to_string(), "status"]);
    assert_eq!((status, said.as_str()), (Some(0), "ok status\n"));
    assert!(why.starts_with("1 settings of "), "{why}");
    let (status, said, why) = run(&wrong, &["disarm"]);
    assert_eq!((status, said.as_str()), (Some(2), ""));
    assert!(why.contains("nobody who holds the key of") && why.lines().count() == 1, "{why}");
    // It was not said: nobody knows whether motors are on.
    assert!(why.ends_with(&format!("wrong.key; {UNCONFIRMED}\n")), "{why}");
    let (status, _, why) = run(&right, &["no", "disarm"]);
    assert_eq!((status, why), (Some(2), format!("cohold: board 2: no: never; {UNCONFIRMED}\n")));
}

/// Why: "stopped" was said of a board that had been armed alone and went on, and of one that nothing reached.
#[test]
fn disarm_is_confirmed_by_the_board_or_says_what_to_press() {
    let key = folder("operator-stop").join("a.key");
    key_file::generate(&key, Role::Operator).unwrap();
    let board = Board::start(key_file::read(&key, Role::Operator).unwrap(), 2.0);
    let run = |line: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
        command.args(["board", "operator", "--board", &board.address.to_string(), "--key-file"]).arg(&key).arg(line);
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let is_armed = || board.armed.load(Ordering::Relaxed);
    assert_eq!(run("arm alone").0, Some(0));
    std::thread::sleep(Duration::from_millis(400));
    assert!(is_armed(), "alone");
    assert_eq!(run("disarm"), (Some(0), "ok disarmed\n".into(), String::new()));
    assert!(!is_armed());

    assert_eq!(run("arm alone").0, Some(0));
    let mut operator = Operator::connect(board.address, &key).unwrap();
    board.away.store(true, Ordering::Relaxed);
    std::thread::sleep(Duration::from_millis(50));
    let why = operator.ask("disarm").unwrap_err().to_string();
    assert!(why.starts_with("stop not confirmed: press the stop at the board") && is_armed(), "{why}");
    let refused = operator.ask("arm").unwrap();
    assert_eq!(refused, "error the board has not confirmed the stop");
    // It goes on being said, and ends what runs as soon as it arrives.
    board.away.store(false, Ordering::Relaxed);
    operator.samples(Duration::from_millis(1500)).unwrap();
    assert!(!is_armed() && operator.reins().giver().is_stopped());
}

/// Records every tick of a board for so many seconds.
fn recording(board: &Board, key: &Path, seconds: &str, file: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
    command.args(["board", "operator", "--board", &board.address.to_string(), "--every", "1", "--seconds", seconds]);
    command.arg("--key-file").arg(key).arg("--record").arg(file);
    command
}

/// Why: a cable that was out for a quarter of a second ended a recording in silence, and one that was out at its end took
/// all of it away.
#[test]
fn a_recording_outlives_the_cable() {
    let folder = folder("operator-cable");
    let (key, file) = (folder.join("a.key"), folder.join("ticks.csv"));
    key_file::generate(&key, Role::Operator).unwrap();
    let board = Board::start(key_file::read(&key, Role::Operator).unwrap(), 2.0);
    let record = |seconds| recording(&board, &key, seconds, &file).stderr(Stdio::piped()).spawn().unwrap();
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
    has_columns_of("board", &file);
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
fn a_recording_has_what_the_board_logs_and_no_answer_is_taken_for_it() {
    let folder = folder("operator-log");
    let (key, file) = (folder.join("a.key"), folder.join("ticks.mcap"));
    key_file::generate(&key, Role::Operator).unwrap();
    let board = Board::start(key_file::read(&key, Role::Operator).unwrap(), 2.0);
    let output = recording(&board, &key, "1", &file).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let recording = cohold_live::recording::file::read(&file).unwrap();
    let said: Vec<_> = recording.log().map(|(_, line)| line.words.as_str()).collect();
    assert_eq!(said, ["ok status", "peer: fading\\u001b[2J", "ok status"]);
}

/// Why: a board that said it shared 18446744073709551615 axes ended the operator's program for want of memory.
#[test]
fn a_board_that_says_what_none_can_is_refused_by_name() {
    let folder = folder("operator-axes");
    let key = folder.join("a.key");
    key_file::generate(&key, Role::Operator).unwrap();
    for (axes, ending) in [("18446744073709551615", "csv"), ("4", "mcap"), ("0", "csv"), ("many", "mcap")] {
        let board = Board::sharing(axes, key_file::read(&key, Role::Operator).unwrap(), 2.0);
        let file = folder.join(format!("ticks.{ending}"));
        let output = recording(&board, &key, "0.2", &file).output().unwrap();
        let why = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{why}");
        assert_eq!(why, format!("cohold: the board has axis.shared = {axes}, which is not allowed\n"));
        assert!(!file.exists());
    }
}

/// Why: what a board answered went to the operator's terminal as it was, which obeyed it.
#[test]
fn what_a_board_answers_is_shown_and_not_obeyed() {
    let key = folder("operator-spell").join("a.key");
    key_file::generate(&key, Role::Operator).unwrap();
    let board = Board::start(key_file::read(&key, Role::Operator).unwrap(), 2.0);
    for more in [&["spell"][..], &["spell", "--json"], &["spell", "no"]] {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
        command.args(["board", "operator", "--board", &board.address.to_string(), "--key-file"]).arg(&key);
        let output = command.args(more).output().unwrap();
        let said = String::from_utf8([output.stdout, output.stderr].concat()).unwrap();
        assert!(!said.contains(|letter: char| letter.is_control() && letter != '\n'), "{said:?}");
        if more == ["spell"] {
            assert_eq!(said, "ok armed\\u001b[2J\\u009b31m\\u000awarning: none\\u0007\n");
        }
    }
}

#[test]
fn a_board_that_takes_other_commands_is_named() {
    let key = folder("operator-version").join("a.key");
    key_file::generate(&key, Role::Operator).unwrap();
    let board = Board::start(key_file::read(&key, Role::Operator).unwrap(), 1.0);
    let error = Operator::connect(board.address, &key).map(|_| ()).unwrap_err().to_string();
    assert!(error.contains("takes other commands than this program"), "{error}");
}

/// What `key image` says of these two files, and whether it made the image.
fn image(peers: &Path, operator: &Path, image: &Path) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
    command.args(["key", "image", "--key-file"]).arg(peers).arg("--operator-key-file").arg(operator);
    let output = command.arg(image).output().unwrap();
    (output.status.code(), String::from_utf8(output.stderr).unwrap())
}

#[test]
fn a_key_image_is_both_keys_and_is_never_overwritten() {
    let folder = folder("key-image");
    let [peers, operator, file] = ["bench.key", "operator.key", "board.bin"].map(|name| folder.join(name));
    key_file::generate(&peers, Role::Peers).unwrap();
    key_file::generate(&operator, Role::Operator).unwrap();
    assert_eq!(image(&peers, &operator, &file), (Some(0), String::new()));
    let bytes = std::fs::read(&file).unwrap();
    let halves = [(&bytes[..64], &peers, Role::Peers), (&bytes[64..], &operator, Role::Operator)];
    for (half, file, role) in halves {
        assert_eq!(Key::from_image(half.try_into().unwrap(), role), key_file::read(file, role).ok(), "{role:?}");
    }
    assert_eq!(image(&peers, &operator, &file).0, Some(2));
    assert_eq!(std::fs::read(&file).unwrap(), bytes);
}

/// Why: with one key for both, whoever holds the peers' can arm the board.
#[test]
fn one_key_in_two_files_is_no_pair_for_a_board() {
    let folder = folder("key-same");
    let [peers, operator, file] = ["bench.key", "operator.key", "board.bin"].map(|name| folder.join(name));
    let key = Key::new([7; Key::LEN]);
    key_file::write(&peers, Role::Peers, &key).unwrap();
    key_file::write(&operator, Role::Operator, &key).unwrap();
    let (status, why) = image(&peers, &operator, &file);
    assert!(status == Some(2) && why.contains("hold the same key") && why.lines().count() == 1, "{why}");
    assert!(!file.exists());
}

/// A key in the wrong place is refused by name, by every command, before anything is sent.
#[test]
fn a_key_file_of_the_other_role_is_refused_by_name() {
    let folder = folder("key-roles");
    let [peers, operator, file] = ["bench.key", "operator.key", "board.bin"].map(|name| folder.join(name));
    let text = |path: &Path| path.display().to_string();
    let run = |words: &[&str]| {
        let output = Command::new(env!("CARGO_BIN_EXE_cohold")).args(words).output().unwrap();
        (output.status.code(), String::from_utf8(output.stderr).unwrap())
    };
    assert_eq!(run(&["key", "generate", &text(&peers)]).0, Some(0));
    assert_eq!(run(&["key", "generate", &text(&operator), "--operator"]).0, Some(0));
    let is_of_peers = format!("{} is a key file of peers, and the operator's is needed here", text(&peers));
    let is_operators = format!("{} is an operator's key file, and one of peers is needed here", text(&operator));
    let nobody = UdpSocket::bind("127.0.0.1:0").unwrap();
    nobody.set_nonblocking(true).unwrap();
    let address = nobody.local_addr().unwrap().to_string();
    let (peers, operator, file, settings) =
        (text(&peers), text(&operator), text(&file), text(&folder.join("left.toml")));
    for (words, why) in [
        (&["board", "operator", "--board", &address, "--key-file", &peers, "disarm"][..], &is_of_peers),
        (
            &["board", "calibrate", "sign", "--board", &address, "--key-file", &peers, "--settings", &settings],
            &is_of_peers,
        ),
        (
            &["peer", "--number", "1", "--listen", "127.0.0.1:0", "--connect", &address, "--key-file", &operator],
            &is_operators,
        ),
        (&["shared", "hub", "--users", "2", "--listen", "127.0.0.1:0", "--key-file", &operator], &is_operators),
        (&["key", "generate", &file, "--line", "1", "--of", &operator], &is_operators),
        (&["key", "image", "--key-file", &operator, "--operator-key-file", &peers, &file], &is_operators),
        (&["key", "image", "--key-file", &peers, "--operator-key-file", &peers, &file], &is_of_peers),
    ] {
        let (status, said) = run(words);
        assert_eq!((status, said.lines().count()), (Some(2), 1), "{words:?}: {said}");
        assert!(said.contains(why), "{words:?}: {said}");
    }
    assert!(!Path::new(&file).exists());
    assert_eq!(nobody.recv_from(&mut [0; 64]).map_err(|cause| cause.kind()), Err(std::io::ErrorKind::WouldBlock));
    // A line of a hub's is never an operator's.
    let (status, said) = run(&["key", "generate", &file, "--operator", "--line", "1", "--of", &peers]);
    assert!(status == Some(2) && said.contains("--operator"), "{said}");
}

/// A file with a stack and an entry at the beginning of flash, as a linker writes it: its head, one segment, eight bytes.
fn image_file() -> Vec<u8> {
    let head = [0x464C_457F, 0x0001_0101, 0, 0, 0x0028_0002, 1, 0, 52, 0, 0, 0x0020_0034, 1, 0];
    let segment = [1, 84, 0x0800_0000, 0x0800_0000, 8, 8, 5, 4];
    let bytes = [0x2000_C000, 0x0800_0299_u32];
    head.iter().chain(&segment).chain(&bytes).flat_map(|word| word.to_le_bytes()).collect()
}

#[test]
fn an_update_writes_its_bytes_and_says_what_is_next_and_what_is_no_image_asks_nothing() {
    let folder = folder("operator-update");
    let key = folder.join("a.key");
    key_file::generate(&key, Role::Operator).unwrap();
    let run = |board: SocketAddr, image: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cohold"));
        command
            .args(["board", "update", "--board", &board.to_string(), "--key-file"])
            .arg(&key)
            .arg("--image")
            .arg(image);
        let output = command.output().unwrap();
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let image = folder.join("haptic-v0.1.0.elf");
    let bytes = folder.join("haptic-v0.1.0.elf.bin");
    std::fs::write(&image, image_file()).unwrap();
    let board = Board::start(key_file::read(&key, Role::Operator).unwrap(), 2.0);
    let (status, said, told) = run(board.address, &image);
    assert_eq!(status, Some(0), "{told}");
    assert_eq!(said, format!("dfu-util -d 0483:df11 -a 0 -s 0x08000000 -D {}\n", bytes.display()));
    assert!(told.starts_with("board 2: update\n"), "{told}");
    let begin = [0x00, 0xC0, 0x00, 0x20, 0x99, 0x02, 0x00, 0x08];
    assert_eq!(std::fs::read(&bytes).unwrap(), [&begin[..], &[0xFF; 24]].concat());

    let nobody = UdpSocket::bind("127.0.0.1:0").unwrap();
    nobody.set_nonblocking(true).unwrap();
    let other = folder.join("notes.txt");
    std::fs::write(&other, "no image").unwrap();
    let (status, said, why) = run(nobody.local_addr().unwrap(), &other);
    assert_eq!((status, said.as_str(), why.lines().count()), (Some(2), "", 1), "{why}");
    assert!(why.contains("notes.txt: it is no image for a board: it must be an ELF file for ARM"), "{why}");
    assert_eq!(nobody.recv_from(&mut [0; 64]).map_err(|cause| cause.kind()), Err(std::io::ErrorKind::WouldBlock));
    assert!(!folder.join("notes.txt.bin").exists());
}
