//! `cohold study bench` and `cohold network measure` as a user runs them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::declared::{declared, has_columns_of};
use crate::program::{cohold, free, report};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bench").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// One law and one network of one's own, in one command: a row more, files with the columns that are told, and the page between its lines.
#[test]
fn anybody_s_law_on_anybody_s_network() {
    let folder = folder("one");
    let [page, front, bare] = ["page.md", "front.md", "bare.md"].map(|name| folder.join(name));
    fs::write(&page, "before\nlaws-bench.png\n<!-- bench fronts begin -->\nold\n<!-- bench fronts end -->\nafter\n")
        .expect("a page");
    fs::write(&front, "before\n<!-- chooser begin -->\nold\n<!-- chooser end -->\nafter\n").expect("a page");
    fs::write(&bare, "nothing\n").expect("a page");
    let trace = Path::new(env!("CARGO_MANIFEST_DIR")).join("sim/tests/data/irtt.json");
    let (out, trace) = (folder.join("out"), trace.display().to_string());
    let asked = [
        "study",
        "bench",
        "--json",
        "--law",
        "p-plus-d",
        "--budget",
        "2",
        "--searches",
        "2",
        "--seeds",
        "1",
        "--trace",
        &trace,
    ];
    let [out_path, page_path, front_path] = [&out, &page, &front].map(|path| path.to_str().expect("UTF-8"));
    let places = ["--out", out_path, "--page", page_path, "--page", front_path];
    let done = report(cohold(&[&asked[..], &places].concat()).spawn().expect("cohold runs"));
    let points = done["points"].as_array().expect("points");
    assert_eq!((points[0]["law"].as_str(), points[0]["gains"].as_str()), (Some("p-plus-d"), Some("declared")));
    // Five motions over ten networks and the one that was measured.
    assert_eq!(points[0]["runs"], 55);
    assert_eq!(done["fronts"].as_array().map(Vec::len), Some(1));
    // Three bounds, of all laws and of those that promise passivity.
    assert_eq!(done["nearest"].as_array().map(Vec::len), Some(6));
    for (kind, name) in [
        ("bench", "gains"),
        ("bench-fronts", "fronts"),
        ("bench-nearest", "nearest"),
        ("bench-runs", "all-runs"),
        ("bench-tunings", "all-tunings"),
        ("bench-runs", "runs-1-of-1"),
        ("bench-tunings", "tunings-1-of-1"),
    ] {
        has_columns_of(kind, &out.join(name).with_extension("csv"));
    }
    let runs = fs::read_to_string(out.join("all-runs.csv")).expect("runs");
    assert_eq!(runs.lines().filter(|line| line.contains(",irtt,")).count(), 5 * points.len());
    // Every mode of this law is stable over the one that was measured, and each row says so.
    let modes = |line: &str| line.split(',').skip(6).take(2).map(str::to_owned).collect::<Vec<_>>();
    assert!(runs.lines().filter(|line| line.contains(",irtt,")).all(|line| modes(line) == ["1", ""]), "{runs}");
    let text = fs::read_to_string(&page).expect("the page");
    assert!(text.starts_with("before\n") && text.ends_with("after\n") && !text.contains("\nold\n"), "{text}");
    assert!(text.contains("p-plus-d") && folder.join("laws-bench.png").exists(), "{text}");
    let text = fs::read_to_string(&front).expect("the page");
    assert!(text.starts_with("before\n") && text.ends_with("after\n") && text.contains("under pushes"), "{text}");
    let quick = ["study", "bench", "--law", "p-plus-d", "--budget", "1", "--searches", "1", "--seeds", "1", "--page"];
    for (words, line) in
        [(&quick[..], "bench fronts begin"), (&["study", "laws", "power", "--page"], "laws felt begin")]
    {
        let refused = cohold(words).arg(&bare).output().expect("cohold runs");
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && said.contains(line), "{said}");
    }
    assert!(declared("bench").iter().any(|[name, unit, _]| name == "led_peak_n" && unit == "N"));
}

#[test]
fn what_cannot_be_benched_is_refused_by_name() {
    for (arguments, says) in [
        (&["study", "bench", "--law", "p-plus"][..], "did you mean p-plus-d?"),
        (&["study", "bench", "--law", "power", "--trace", "nowhere.csv"], "--trace: cannot read nowhere.csv"),
        (&["study", "bench", "--budget", "0"], "--budget 0 is not allowed"),
        (&["network", "measure", "--to", "127.0.0.1:9"], "FILE"),
    ] {
        let output = cohold(arguments).output().expect("cohold runs");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && said.contains(says), "{arguments:?}: {said}");
    }
}

/// On loopback: the listener ends by itself, every probe is a row each way, and a scene takes the file.
#[test]
fn a_network_between_two_programs_is_measured() {
    let (folder, address) = (folder("measured"), free());
    let file = folder.join("mine.csv").display().to_string();
    let listen = ["network", "measure", "--listen", &address, "--seconds", "6", "--json"];
    let listening = cohold(&listen).spawn().expect("cohold runs");
    std::thread::sleep(std::time::Duration::from_secs(1));
    let probe = ["network", "measure", "--to", &address, "--every-ms", "10", "--seconds", "1", "--json", &file];
    let found = report(cohold(&probe).spawn().expect("cohold runs"));
    let listened = report(listening);
    assert_eq!(found["probes"]["sent"], 100);
    assert_eq!(found["probes"]["answered"], listened["answered"], "{found} {listened}");
    assert_eq!(found["constant"]["network.one_way_delay_packets"], 0.0, "{found}");
    has_columns_of("network-trace", Path::new(&file));
    assert_eq!(fs::read_to_string(&file).expect("a trace").lines().count(), 1 + 2 * 100);
    let scene = ["cooperate", "--scene", "any-network", "--set", "user.1.push_n=1", "--seconds", "1", "--json"];
    let set = format!("network.trace={file}");
    assert_eq!(report(cohold(&[&scene[..], &["--set", &set]].concat()).spawn().expect("cohold runs"))["ticks"], 1000);
}
