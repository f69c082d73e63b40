//! Files that others made, and names that others chose: pipes, devices, links, orders to a terminal, tables without end.
#![cfg(unix)]

use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("outside").join(name);
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// The program in this folder, with two gigabytes of addresses and 20 s: whoever needs more is stuck.
fn bounded(folder: &Path, arguments: &[&str]) -> Output {
    let line = format!("ulimit -v 2097152; exec {} \"$@\"", env!("CARGO_BIN_EXE_cohold"));
    let mut command = Command::new("sh");
    command.args(["-c", &line, "sh"]).args(arguments).current_dir(folder).env("RAYON_NUM_THREADS", "1");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("a shell");
    let start = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if start.elapsed() > Duration::from_secs(20) {
            child.kill().expect("it runs");
            panic!("{arguments:?} took more than 20 s");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().expect("it has ended")
}

/// What it says in one line, having done nothing.
fn refusal(output: &Output) -> String {
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{error}");
    assert!(output.stdout.is_empty() && error.trim_end().lines().count() == 1, "{error}");
    error
}

#[test]
fn a_pipe_or_a_device_is_no_file() {
    let folder = folder("pipes");
    assert!(Command::new("mkfifo").arg(folder.join("pipe")).status().expect("mkfifo").success());
    for place in ["./pipe", "/dev/zero"] {
        let why = "it is a pipe or a device: it must be a regular file";
        for arguments in [
            &["cooperate", "--json", "--scene", place][..],
            &["cooperate", "--json", "--set", &format!("user.1.trace={place}")],
            &["cooperate", "--json", "--set", &format!("network.trace={place}")],
            &["study", place, "matched-line", "--json"],
            &["study", "sweep", "--json", "--over", "network.loss=0,0.1", "--scene", place],
            &["recording", "convert", place, "out.csv"],
            &["recording", "merge", place],
            &["shared", "world", "show", "--world", place],
            &["shared", "world", "serve", "--world", place, "--listen", "127.0.0.1:0", "--key-file", place],
            &["board", "calibrate", "counts", "--board", "simulated", "--distance-m", "0.1", "--settings", place],
        ] {
            let error = refusal(&bounded(&folder, arguments));
            assert!(error.contains("cannot read") && error.contains(why), "{arguments:?}: {error}");
        }
    }
}

/// A recording as FORMAT says, by hand: MCAP with these channels, each a topic and its columns, and rows that say these of them.
struct Mcap(Vec<u8>);

fn counted(bytes: &[u8]) -> Vec<u8> {
    [&(bytes.len() as u32).to_le_bytes(), bytes].concat()
}

/// A field of a protobuf message: text or message.
fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
    [&[number << 3 | 2][..], &varint(bytes.len() as u64), bytes].concat()
}

fn varint(mut value: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    while value >= 0x80 {
        bytes.push(value as u8 | 0x80);
        value >>= 7;
    }
    bytes.push(value as u8);
    bytes
}

impl Mcap {
    fn new(facts: &[(&str, &str)]) -> Self {
        let mut file = Self(b"\x89MCAP0\r\n".to_vec());
        file.record(1, &[counted(b""), counted(b"by hand")].concat());
        let facts: Vec<u8> = facts
            .iter()
            .flat_map(|(name, value)| [counted(name.as_bytes()), counted(value.as_bytes())])
            .flatten()
            .collect();
        file.record(12, &[counted(b"recording"), counted(&facts)].concat());
        file
    }

    fn record(&mut self, opcode: u8, content: &[u8]) {
        self.0.push(opcode);
        self.0.extend((content.len() as u64).to_le_bytes());
        self.0.extend(content);
    }

    fn channel(&mut self, number: u16, topic: &str, columns: &[String]) {
        let mut message = field(1, b"Row");
        for (at, column) in (1..).zip(columns) {
            let of = [field(1, column.as_bytes()), vec![3 << 3], varint(at), vec![5 << 3, 1]].concat();
            message.extend(field(2, &of));
        }
        let set = field(1, &field(4, &message));
        self.record(3, &[&number.to_le_bytes()[..], &counted(b"Row"), &counted(b"protobuf"), &counted(&set)].concat());
        let names = [counted(topic.as_bytes()), counted(b"protobuf"), counted(b"")].concat();
        self.record(4, &[&number.to_le_bytes()[..], &number.to_le_bytes(), &names].concat());
    }

    fn row(&mut self, number: u16, values: &[f64]) {
        let head = [&number.to_le_bytes()[..], &[0; 4 + 8 + 8]].concat();
        let value = |(at, value): (u64, &f64)| [varint(at << 3 | 1), value.to_le_bytes().to_vec()].concat();
        let values: Vec<u8> = (1..).zip(values).flat_map(value).collect();
        self.record(5, &[head, values].concat());
    }

    fn write(mut self, path: &Path) {
        self.record(2, &[0; 20]);
        self.0.extend(b"\x89MCAP0\r\n");
        std::fs::write(path, self.0).expect("a recording");
    }
}

fn names(count: usize) -> Vec<String> {
    (0..count).map(|at| format!("x{at}_m")).collect()
}

/// A recording that is right: what the hostile ones below differ from.
fn honest(path: &Path, more: &[(&str, &str)]) {
    let mut file = Mcap::new(&[&[("who", "peer 1"), ("scene", "[object]\nmass_kg = 0.5\n")], more].concat());
    file.channel(1, "/peer_1/ticks", &names(2));
    file.channel(2, "/peer_1/exchanges", &names(1));
    file.row(1, &[1.0, 2.0]);
    file.row(2, &[3.0]);
    file.write(path);
}

#[test]
fn convert_writes_over_nothing_that_was_not_named_and_through_no_link() {
    let folder = folder("convert");
    honest(&folder.join("in.mcap"), &[]);
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    let convert = |to: &str| bounded(&folder, &["recording", "convert", "in.mcap", to]);
    // Files of the user's, of names that the recording's author could guess.
    for (beside, to) in
        [("Cargo.toml", "Cargo.csv"), ("mine-exchanges.csv", "mine.csv"), ("two-exchanges.parquet", "two.parquet")]
    {
        std::fs::write(folder.join(beside), "mine").expect("a file");
        let error = refusal(&convert(to));
        assert!(error.contains(beside) && error.contains("it exists, and is not written over"), "{error}");
        assert_eq!(read(beside), "mine");
        assert!(!folder.join(to).exists(), "{to}: all of it or nothing");
    }
    // A name that an older version wrote into first, and links where the files go.
    std::fs::write(folder.join("secret"), "mine").expect("a file");
    for link in ["out.csv.part", "linked.csv", "deep.toml", "far-exchanges.csv"] {
        symlink(folder.join("secret"), folder.join(link)).expect("a link");
    }
    for (to, link) in [("linked.csv", "linked.csv"), ("deep.csv", "deep.toml"), ("far.csv", "far-exchanges.csv")] {
        let error = refusal(&convert(to));
        assert!(error.contains(link) && error.contains("it is a link: it must be a regular file"), "{error}");
    }
    // The same again is the same, and the file that was named is replaced.
    std::fs::write(folder.join("out.csv"), "old").expect("a file");
    for _ in 0..2 {
        let output = convert("out.csv");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        assert_eq!(read("out.csv"), "row,x0_m,x1_m\n0,1.0,2.0\n");
        assert_eq!(
            (read("out-exchanges.csv").as_str(), read("out.toml").as_str()),
            ("row,x0_m\n0,3.0\n", "[object]\nmass_kg = 0.5\n")
        );
    }
    assert_eq!(read("secret"), "mine");
}

#[test]
fn what_a_recording_calls_things_is_shown_and_names_no_file() {
    const ORDER: &str = "\u{1b}]0;owned\u{7}\u{9b}2J\u{202e}\nwarning: none";
    let folder = folder("escapes");
    let mut file = Mcap::new(&[("who", ORDER), ("scene", "")]);
    file.channel(1, &format!("/{ORDER}/ticks"), &[format!("{ORDER}_m")]);
    file.row(1, &[1.0]);
    file.write(&folder.join("in.mcap"));
    let mut file = Mcap::new(&[("who", "x"), ("scene", "")]);
    file.channel(1, "/a/ticks", &names(1));
    file.channel(2, "/a/..\\..\\x", &names(1));
    file.row(2, &[1.0]);
    file.write(&folder.join("beside.mcap"));
    let mut file = Mcap::new(&[("who", "x"), ("scene", &format!("# {ORDER}"))]);
    file.channel(1, "/a/ticks", &names(1));
    file.write(&folder.join("toml.mcap"));
    std::fs::write(folder.join("bad.toml"), "\"\\u001b[2J\\nx\" = 1\n[user.1]\ntrace = \"\\u001b[2J\"\n")
        .expect("a scene");
    std::fs::write(folder.join("worse.toml"), "[user.1]\ntrace = \"\\u001b[2J\\nhost-sim: done\"\n").expect("a scene");
    for (arguments, status) in [
        (&["recording", "convert", "in.mcap", "out.csv"][..], 0),
        (&["recording", "convert", "in.mcap", "out.csv", "--json"], 0),
        (&["recording", "merge", "in.mcap"], 2),
        (&["recording", "merge", "in.mcap", "in.mcap"], 2),
        (&["recording", "convert", "beside.mcap", "beside.csv"], 2),
        (&["recording", "convert", "toml.mcap", "toml.csv"], 2),
        (&["cooperate", "--json", "--scene", "bad.toml"], 2),
        (&["cooperate", "--json", "--scene", "worse.toml"], 2),
        (&["cooperate", "--json", "--set", "\u{1b}[2J=1"], 2),
        (&["\u{1b}[2J"], 2),
    ] {
        let output = bounded(&folder, arguments);
        let said = String::from_utf8([output.stdout, output.stderr].concat()).expect("text");
        assert_eq!(output.status.code(), Some(status), "{arguments:?}: {said}");
        assert!(!said.contains(|letter: char| letter.is_control() && letter != '\n'), "{arguments:?}: {said:?}");
        assert!(!said.contains('\u{202e}') && !said.contains("\nwarning: none"), "{arguments:?}: {said:?}");
        assert!(status == 0 || said.trim_end().lines().count() == 1, "{arguments:?}: {said}");
    }
    assert!(!folder.join("toml.toml").exists() && !folder.join("out.toml.half").exists());
}

/// Why: 100,000 columns in 1.9 MB took 3 GB; every row of 31 bytes made a number in each of them.
#[test]
fn a_recording_takes_no_more_than_it_is_long() {
    let folder = folder("tables");
    let mut wide = Mcap::new(&[("who", "x"), ("scene", "")]);
    wide.channel(1, "/a/ticks", &names(100_000));
    (0..4000).for_each(|_| wide.row(1, &[]));
    wide.write(&folder.join("wide.mcap"));
    let mut many = Mcap::new(&[("who", "x"), ("scene", "")]);
    (0..3000).for_each(|number| many.channel(number, "/a/ticks", &names(60)));
    many.write(&folder.join("many.mcap"));
    let mut long = Mcap::new(&[("who", "x"), ("scene", "")]);
    long.channel(1, "/a/ticks", &["x".repeat(1 << 20)]);
    long.write(&folder.join("long.mcap"));
    let mut text = Mcap::new(&[("who", "x"), ("scene", &"#".repeat(17 << 20))]);
    text.channel(1, "/a/ticks", &names(1));
    text.write(&folder.join("text.mcap"));
    for (name, cap) in [
        ("wide", "64 columns in a channel"),
        ("many", "64 channels"),
        ("long", "128 bytes in the name of a column"),
        ("text", "16777216 bytes in a record"),
    ] {
        let error = refusal(&bounded(&folder, &["recording", "convert", &format!("{name}.mcap"), "out.csv"]));
        assert!(error.contains(&format!("it has more than {cap}, which no recording has")), "{error}");
    }
    // Rows that leave numbers out: two million of them in 62 MB would be a table of a gigabyte.
    let mut empty = Mcap::new(&[("who", "x"), ("scene", "")]);
    empty.channel(1, "/a/ticks", &names(64));
    empty.row(1, &[1.0; 64]);
    (0..2_000_000).for_each(|_| empty.row(1, &[]));
    empty.write(&folder.join("empty.mcap"));
    let output = bounded(&folder, &["recording", "convert", "empty.mcap", "empty.csv", "--json"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(std::fs::read_to_string(folder.join("empty.csv")).expect("a table").lines().count(), 2);
}

/// Why: whether a session is in both was asked of every exchange by looking at all of them.
#[test]
fn exchanges_of_as_many_sessions_take_no_longer_than_of_one() {
    let folder = folder("sessions");
    for (end, sign) in [("one", 1.0), ("two", -1.0)] {
        let name = &format!("{end}.mcap");
        let mut file = Mcap::new(&[("who", name), ("scene", "")]);
        let of = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        file.channel(1, &format!("/{end}/ticks"), &of(&["time_s", "mode", "object_m", "object_m_per_s"]));
        file.channel(2, &format!("/{end}/exchanges"), &of(&["sent_s", "there_s", "answered_s", "back_s", "session"]));
        (0..100).for_each(|at| file.row(1, &[f64::from(at), 1.0, 0.0, 0.0]));
        (1..300_000).for_each(|at| file.row(2, &[0.0, 0.0, 0.0, 0.0, sign * f64::from(at)]));
        file.write(&folder.join(name));
    }
    let error = refusal(&bounded(&folder, &["recording", "merge", "one.mcap", "two.mcap"]));
    assert!(error.contains("in no session with each other"), "{error}");
}
