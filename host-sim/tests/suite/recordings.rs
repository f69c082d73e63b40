//! Recordings of processes as a user runs them: killed in the middle, on a full disk, and what two of them say together.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use cohold_live::node::Node;
use cohold_protocol::key::Key;
use cohold_sim::engine::{Actor, Engine, Out, Seat};
use cohold_sim::network::{link::Route, rule::Direction};
use cohold_sim::scenes;
use parquet::basic::Type as PhysicalType;
use parquet::file::reader::{FileReader as _, SerializedFileReader};
use serde_json::Value;

use crate::declared::has_columns_of;
use crate::program::{Keys, cohold, free};

/// The scene of a person's first try on a bad network: both hold still for a second and a half, then push; one of them to and fro. So
/// it does not matter which of them is armed some milliseconds before the other.
const SCENE: [&str; 3] = ["--scene", "any-network", "--set=network.one_way_delay_packets=8"];

/// A fifth of all datagrams is lost, ten in a row. The two ways have periods of their own, so that every combination comes.
fn bursts(folder: &Path) -> PathBuf {
    let way = |direction: u32, period: u32| {
        let fate = |packet: u32| if packet < period - 10 { "0,arrives" } else { ",lost" };
        (0..period).map(move |packet| format!("{direction},{packet},{}\n", fate(packet))).collect::<String>()
    };
    let file = folder.join("trace.csv");
    std::fs::write(&file, format!("direction,packet,delay_s,fate\n{}{}", way(1, 50), way(2, 53))).expect("a trace");
    file
}

/// What the users do, as settings.
fn pushes(folder: &Path) -> Vec<String> {
    let push = |user: u32, swing_n: f64| {
        let force = |at: u32| {
            let since_s = 0.01 * f64::from(at);
            format!("{},{}\n", 1.5 + since_s, since_s.min(1.0) * (1.0 + swing_n * (3.0 * since_s).sin()))
        };
        let file = folder.join(format!("user-{user}.csv"));
        let text: String = (0..2_000).map(force).collect();
        std::fs::write(&file, format!("time_s,force_n\n0,0\n{text}")).expect("a trace");
        format!("--set=user.{user}.trace={}", file.display())
    };
    vec![push(1, 0.0), push(2, 0.25)]
}

/// A sealed peer with its device in virtual time, as it runs in real time.
struct Sealed {
    node: Node,
    to: usize,
}

impl Actor<usize> for Sealed {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, _: usize, datagram: &mut [u8], _: &mut Out<'_, usize, [u8]>) {
        let _ = self.node.receive(now_ns / 1_000, datagram);
    }

    fn act(&mut self, now_ns: u64, out: &mut Out<'_, usize, [u8]>) {
        self.node.tick(now_ns / 1_000, |bytes| out(self.to, bytes));
    }
}

/// Mean true discrepancy of the two of them over the last half of a run, mm.
fn in_process(settings: &[String], seconds: f64) -> f64 {
    let settings: Vec<String> = settings.iter().map(|one| one.trim_start_matches("--set=").to_owned()).collect();
    let scene = scenes::find(cohold_guest_laws::laws(), Some(Path::new("any-network")), &settings).expect("a scene");
    let seat = |number: u8| {
        let node = <Node>::build(&scene, number, Key::new([0x5a; Key::LEN]), [number; Key::LEN]).expect("a scene");
        // As often as live ends tell each other how they are.
        Seat::new(Sealed { node: node.telling_every(0.02), to: usize::from(number == 1) })
    };
    let direction = |from| if from == 0 { Direction::OneToTwo } else { Direction::TwoToOne };
    let route = |from, _| Route::of_scene(&scene, direction(from), 0);
    let mut engine = Engine::new(scene.peer.timing.control_period_ns(), vec![seat(1), seat(2)], route);
    let (ticks, mut sum) = ((1e3 * seconds) as u64, 0.0);
    for tick in 0..ticks {
        engine.step(&mut |_| ());
        let at = |seat: usize| f64::from(engine.seats[seat].actor.node.observed().object.position);
        if tick >= ticks / 2 {
            sum += 1e3 * (at(0) - at(1)).abs() / (ticks / 2) as f64;
        }
    }
    sum
}

fn json(command: &mut Command) -> Value {
    let output = command.output().expect("cohold runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("one JSON document and nothing else")
}

fn number(document: &Value, key: &str) -> f64 {
    document[key].as_f64().unwrap_or_else(|| panic!("{key} in {document}"))
}

fn peer(keys: &Keys, own: &str, [listen, connect]: [&str; 2], record: &Path) -> Child {
    let mut command = cohold(&["peer", "--json", "--number", own, "--listen", listen, "--connect", connect]);
    command.args(["--seconds", "60", "--key-file", &keys.file(0)]).args(SCENE).args(pushes(&keys.0));
    command.arg("--record").arg(record);
    command.stdout(Stdio::null()).spawn().expect("cohold runs")
}

/// How long before they are killed.
const SECONDS: f64 = 12.0;

/// Two processes over a relay that loses in bursts, both killed in the middle; what their recordings say together.
fn killed(keys: &Keys) -> Value {
    let file = |name: &str| keys.0.join(name);
    let trace = bursts(&keys.0);
    let [one, two, for_one, for_two] = [(); 4].map(|()| free());
    let mut relay = cohold(&["network", "relay", "--seconds", "30", "--listen-1", &for_one, "--listen-2", &for_two])
        .args(["--peer-1", &one, "--peer-2", &two, "--trace"])
        .arg(&trace)
        .args(SCENE)
        .spawn()
        .expect("cohold runs");
    let recordings = [file("one.mcap"), file("two.mcap")];
    recordings.iter().for_each(|recording| drop(std::fs::remove_file(recording)));
    let mut first = peer(keys, "1", [&one, &for_one], &recordings[0]);
    let mut second = peer(keys, "2", [&two, &for_two], &recordings[1]);
    std::thread::sleep(Duration::from_secs_f64(SECONDS));
    // SIGKILL: nothing of it is reported.
    first.kill().expect("it is running");
    let _ = first.wait();
    for child in [&mut second, &mut relay] {
        child.kill().expect("it is running");
        let _ = child.wait();
    }
    // Up to the last second: a chunk of a quarter of a second is what a kill may cost.
    for recording in &recordings {
        let table = recording.with_extension("csv");
        let converted = json(cohold(&["recording", "convert", "--json"]).arg(recording).arg(&table));
        assert!(converted["cut"]["whole_bytes"].as_f64().is_some_and(|bytes| bytes > 1e5), "{converted}");
        let text = std::fs::read_to_string(&table).expect("a table");
        let last = text.lines().last().and_then(|line| line.split(',').nth(1)?.parse::<f64>().ok()).expect("a time");
        assert!(last > SECONDS - 1.5, "the last tick is of {last} s");
        for (kind, name) in [("peer-ticks", ""), ("peer-exchanges", "-exchanges"), ("peer-seconds", "-seconds")] {
            let stem = recording.file_stem().expect("a name").to_string_lossy();
            has_columns_of(kind, &recording.with_file_name(format!("{stem}{name}.csv")));
        }
        assert!(std::fs::read_to_string(recording.with_extension("toml")).expect("a scene").contains("self-timed"));
    }
    let table = file("merged.parquet");
    let merged = json(cohold(&["recording", "merge", "--json"]).args(&recordings).arg(&table));
    assert!(table.exists() && number(&merged, "instants") > 1000.0 * (SECONDS - 3.0), "{merged}");
    // The clocks are known to half of a round trip of 16 ms and some; as both are those of one machine, it is seen how well: what a
    // busy relay makes of the two ways is less.
    assert!((8_000.0..20_000.0).contains(&number(&merged, "clock_error_us")), "{merged}");
    assert!(number(&merged, "same_machine_less_this_us").abs() < 4_000.0, "{merged}");

    assert!(number(&merged, "largest_true_discrepancy_mm") < 5.0, "{merged}");
    merged
}

/// What the recordings of two killed processes say together is what the same two sealed peers do in virtual time on the same network,
/// and below 5 mm, as the simulator says. A machine that is busy with something else is another network than the trace: of three
/// runs one must be that network.
#[test]
fn two_killed_processes_have_the_true_discrepancy_of_the_run_in_memory() {
    let keys = Keys::new("recordings", 0);
    let network = format!("--set=network.trace={}", bursts(&keys.0).display());
    let settings = [vec![SCENE[2].to_owned(), network.clone()], pushes(&keys.0)].concat();
    let wanted = in_process(&settings, SECONDS);
    let near = |merged: &Value| {
        let (real, clock_mm) = (number(merged, "true_discrepancy_mm"), number(merged, "rms_clock_error_mm"));
        println!("true discrepancy {real} mm, {wanted} mm in memory, clocks ±{clock_mm} mm");
        clock_mm < 1.0 && (real - wanted).abs() < 0.05 * wanted + clock_mm
    };
    assert!((0..3).any(|_| near(&killed(&keys))), "{wanted} mm in memory");
    let mut simulated = cohold(&["cooperate", "--json", "--seconds", "12"]);
    let simulated = json(simulated.args(SCENE).args(pushes(&keys.0)).arg(network));
    assert!(number(&simulated, "true_discrepancy_mm") < 5.0, "{simulated}");
}

/// A file that may not grow further, as on a full disk: the run goes on to its end, says so, and what is there is read.
#[cfg(unix)]
#[test]
fn a_full_disk_ends_the_recording_and_not_the_run() {
    let keys = Keys::new("full-disk", 0);
    let recording = keys.0.join("full.mcap");
    let run = format!(
        "trap '' XFSZ; ulimit -f 400; exec '{}' cooperate --json --seconds 10 --scene any-network --set user.1.push_n=1 --record '{}'",
        env!("CARGO_BIN_EXE_cohold"),
        recording.display()
    );
    let output = Command::new("bash").args(["-c", &run]).output().expect("bash runs");
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && error.contains("takes no more"), "{error}");
    let document: Value = serde_json::from_slice(&output.stdout).expect("the run's result");
    assert_eq!(number(&document, "ticks"), 10_000.0, "{document}");
    let table = keys.0.join("full.parquet");
    let converted = json(cohold(&["recording", "convert", "--json"]).arg(&recording).arg(&table));
    let rows = number(&converted["channels"][0], "rows");
    assert!(rows > 100.0 && rows < 10_000.0, "{converted} {error}");
    let said = format!("recorded {rows} rows in {}, ", recording.display());
    assert!(error.contains(&said), "{said} is not in {error}");
    // Never written over.
    let again = cohold(&["cooperate", "--seconds", "1", "--record"]).arg(&recording).output().expect("cohold runs");
    let error = String::from_utf8_lossy(&again.stderr);
    assert!(again.status.code() == Some(2) && error.contains("never written over"), "{error}");
}

/// What was recorded is the other table, but for the number of each row.
fn same_rows(recorded: &Path, whole: &Path) {
    let [recorded, whole] = [recorded, whole].map(|file| std::fs::read_to_string(file).expect("a table"));
    let without: Vec<&str> = recorded.lines().map(|line| line.split_once(',').map_or("", |(_, rest)| rest)).collect();
    assert!(without.iter().copied().eq(whole.lines()), "{:?} {:?}", without.first(), whole.lines().next());
}

/// Of several shared axes each has a channel, whose rows are those of the table that `--out` writes of it.
#[test]
fn both_peers_along_three_axes() {
    let keys = Keys::new("in-space", 0);
    let recording = keys.0.join("space.mcap");
    let run = ["cooperate", "--json", "--seconds", "1", "--scene", "space", "--out"];
    let run = json(cohold(&run).arg(&keys.0).arg("--record").arg(&recording));
    json(cohold(&["recording", "convert", "--json"]).arg(&recording).arg(keys.0.join("table.csv")));
    let files: Vec<&str> = run["files"].as_array().expect("files").iter().filter_map(Value::as_str).collect();
    for (recorded, axis) in [("table.csv", "-x.csv"), ("table-ticks-y.csv", "-y.csv"), ("table-ticks-z.csv", "-z.csv")]
    {
        let whole = files.iter().find(|file| file.ends_with(axis)).unwrap_or_else(|| panic!("{axis} in {files:?}"));
        same_rows(&keys.0.join(recorded), Path::new(whole));
    }
}

/// A recording of both peers is the table that `--out` writes, and their true discrepancy is the run's.
#[test]
fn both_peers_of_a_run_in_memory() {
    let keys = Keys::new("in-memory", 0);
    let recording = keys.0.join("both.mcap");
    let run = ["cooperate", "--json", "--seconds", "2", "--scene", "matched-line", "--set", "user.1.push_n=1", "--out"];
    let run = json(cohold(&run).arg(&keys.0).arg("--record").arg(&recording));
    let merged = json(cohold(&["recording", "merge", "--json"]).arg(&recording));
    let near = (number(&merged, "true_discrepancy_mm") - number(&run, "true_discrepancy_mm")).abs();
    assert!(near < 1e-12 && number(&merged, "instants") == 2000.0, "{merged} {run}");
    let table = keys.0.join("table.csv");
    json(cohold(&["recording", "convert", "--json"]).arg(&recording).arg(&table));
    let files = run["files"].as_array().expect("files").iter().filter_map(Value::as_str);
    let whole: Vec<PathBuf> = files.filter(|file| file.ends_with(".csv")).map(PathBuf::from).collect();
    same_rows(&table, &whole[0]);
    for (arguments, names) in [
        (
            &["recording", "convert", "a.mcap", "b.txt"][..],
            "b.txt is not allowed: its name must end in .csv or .parquet",
        ),
        (&["recording", "convert", "nowhere.mcap", "b.csv"], "cannot read nowhere.mcap"),
        (&["recording", "merge", "nowhere.mcap"], "cannot read nowhere.mcap"),
    ] {
        let output = cohold(arguments).output().expect("cohold runs");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && error.contains(names), "{error}");
    }
}

/// Issue 52, finding 9: of a run that faulted, rows and log say which fault came and when, and the tables have the types that docs/reference/columns.md says.
#[test]
fn a_run_that_faults_says_so() {
    let keys = Keys::new("fault", 0);
    let file = |name: &str| keys.0.join(name);
    let run = cohold(&FAULTS).arg("--record").arg(file("run.mcap")).output().expect("cohold runs");
    assert_eq!(run.status.code(), Some(1), "{}", String::from_utf8_lossy(&run.stderr));
    let converted = json(cohold(&["recording", "convert", "--json"]).arg(file("run.mcap")).arg(file("run.csv")));
    let channels = converted["channels"].as_array().expect("channels");
    assert!(channels.iter().any(|channel| channel["channel"] == "/log"), "{converted}");
    let table = |name: &str| {
        let text = std::fs::read_to_string(file(name)).expect("a table");
        text.lines().map(|line| line.splitn(5, ',').map(str::to_owned).collect()).collect::<Vec<Vec<String>>>()
    };
    let rows = std::fs::read_to_string(file("run.csv")).expect("a table");
    let mut rows = rows.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = rows.next().expect("a heading");
    let at = |name: &str| head.iter().position(|known| *known == name).unwrap_or_else(|| panic!("{name} in {head:?}"));
    let (mode, fault, time) = (at("mode_1"), at("fault_1"), at("time_s"));
    let rows: Vec<_> = rows.collect();
    let first = rows.iter().find(|row| row[mode] == "2").expect("a row that says it");
    assert!(rows[0][mode] == "1" && rows[0][fault] == "0" && first[fault] == "3", "{first:?}");
    // The log says it at the same time, with its reason, and what the run came to at its end.
    has_columns_of("recording-log", &file("run-log.csv"));
    let log = table("run-log.csv");
    let said = log.iter().find(|line| line[2] == "4").expect("a line that says what stopped it");
    let apart_s = said[1].parse::<f64>().expect("a time") - first[time].parse::<f64>().expect("a time");
    let words = "peer 1 stopped at 0.007 s: Overspeed: braking did not keep the device below 1.5 times safety.max_speed_m_per_s or encoder.max_speed_m_per_s";
    assert!(said[3] == words && said[4] == "both peers" && apart_s.abs() < 1e-6, "{said:?} {apart_s}");
    // A flag is a flag, a count a count, a text a text.
    let converted = json(cohold(&["recording", "convert", "--json"]).arg(file("run.mcap")).arg(file("run.parquet")));
    assert_eq!(number(&converted["channels"][0], "rows"), rows.len() as f64);
    for (name, column, kind) in [
        ("run", "row", PhysicalType::INT64),
        ("run", "mode_1", PhysicalType::INT64),
        ("run", "fault_2", PhysicalType::INT64),
        ("run", "time_s", PhysicalType::DOUBLE),
        ("run-log", "level", PhysicalType::INT64),
        ("run-log", "message", PhysicalType::BYTE_ARRAY),
    ] {
        let reader = SerializedFileReader::new(File::open(file(&format!("{name}.parquet"))).expect("a file"));
        let reader = reader.expect("Parquet");
        let schema = reader.metadata().file_metadata().schema_descr();
        let found = schema.columns().iter().find(|found| found.name() == column).expect("a column");
        assert_eq!(found.physical_type(), kind, "{column} of {name}");
    }
}

/// A run that is stopped by a limit.
const FAULTS: [&str; 7] = [
    "cooperate",
    "--json",
    "--scene=any-network",
    "--set=user.1.push_n=5",
    "--set=user.2.push_n=-5",
    "--set=safety.max_speed_m_per_s=0.2",
    "--seconds=2",
];

/// What a live command says: words on standard error, or a JSON object a line on standard output, or nothing; and the page records.
#[test]
fn live_commands_talk_and_record() {
    let keys = Keys::new("talk", 0);
    let [one, two] = [free(), free()];
    let live = |number: &str, ends: [&str; 2], more: &str| {
        cohold(&["peer", "--number", number, "--listen", ends[0], "--connect", ends[1], "--seconds", "2.5", more])
            .args([
                "--key-file",
                &keys.file(0),
                "--set=user.1.push_n=1",
                "--set=user.2.push_n=1",
                "--set=user.2.sine_n=0.25",
            ])
            .args(SCENE)
            .spawn()
            .expect("cohold runs")
    };
    let (first, second) = (live("1", [&one, &two], "--json-lines"), live("2", [&two, &one], "--quiet"));
    let output = first.wait_with_output().expect("it ends");
    assert!(output.status.success() && output.stderr.is_empty(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = String::from_utf8(output.stdout).expect("text");
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).expect("an object")).collect();
    let of = |kind: &str| lines.iter().filter(|line| line["kind"] == kind).cloned().collect::<Vec<_>>();
    assert!((2..=3).contains(&of("second").len()) && of("report").len() == 1 && of("notice").len() >= 3, "{text}");
    let last = of("second").pop().expect("a second");
    assert_eq!((last["state"].as_str(), last["fault"].is_null()), (Some("armed"), true), "{last}");
    for (key, most) in [
        ("rms_true_discrepancy_mm", 5.0),
        ("largest_true_discrepancy_mm", 5.0),
        ("true_discrepancy_error_mm", 0.5),
        ("clock_error_us", 2000.0),
        ("live_share", 1.0),
    ] {
        assert!((1e-9..=most).contains(&number(&last, key)), "{key} in {last}");
    }
    assert!(of("notice")[1]["words"].as_str().is_some_and(|words| words.contains("a session has begun")), "{text}");
    assert!(lines.last().is_some_and(|line| line["kind"] == "report" && line["ticks"] == 2500.0), "{text}");
    let quiet = second.wait_with_output().expect("it ends");
    assert!(quiet.status.success() && quiet.stderr.is_empty() && !quiet.stdout.is_empty());

    let recording = keys.0.join("page.mcap");
    let start = Instant::now();
    let page = cohold(&["play", "--seconds", "1", "--record"]).arg(&recording).output().expect("cohold runs");
    assert!(
        page.status.success() && start.elapsed() < Duration::from_secs(20),
        "{}",
        String::from_utf8_lossy(&page.stderr)
    );
    let converted = json(cohold(&["recording", "convert", "--json"]).arg(&recording).arg(keys.0.join("page.csv")));
    assert_eq!((number(&converted["channels"][0], "rows"), number(&converted, "lost")), (1000.0, 0.0), "{converted}");
    let heads = std::fs::read_to_string(keys.0.join("page.csv")).expect("a table");
    assert!(heads.starts_with("row,time_s,wanted_1_m,wanted_2_m,device_1_m"), "{heads:.200}");
}
