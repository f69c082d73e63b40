//! Whatever is wrong with what a user wrote: exit status 2, nothing on standard output, one line that names it.

use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bad-input");
    std::fs::create_dir_all(&folder).expect("a folder for bad files");
    folder
}

fn file(name: &str, text: &str) -> String {
    let path = folder().join(name);
    std::fs::write(&path, text).expect("write a bad file");
    path.display().to_string()
}

#[track_caller]
fn refused(arguments: &[&str], names: &[&str]) {
    let output = Command::new(env!("CARGO_BIN_EXE_cohold")).args(arguments).output().expect("cohold runs");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
    assert!(output.stdout.is_empty(), "{arguments:?} printed {}", String::from_utf8_lossy(&output.stdout));
    assert_eq!(error.trim_end().lines().count(), 1, "{arguments:?} said more than one line:\n{error}");
    for name in names {
        assert!(error.contains(name), "{arguments:?}: {name:?} is missing in: {error}");
    }
}

fn refused_set(set: &str, names: &[&str]) {
    refused(&["cooperate", "--json", "--set", set], names);
}

fn refused_scene(name: &str, text: &str, names: &[&str]) {
    refused(&["cooperate", "--json", "--scene", &file(name, text)], names);
}

#[test]
fn values_out_of_range() {
    refused_set("device.mass_kg=-1", &["device.mass_kg = -1", "0.0001 to 1000 kg"]);
    refused_set("device.mass_kg=0", &["device.mass_kg = 0"]);
    refused_set("object.mass_kg=nan", &["object.mass_kg = NaN"]);
    refused_set("object.mass_kg=inf", &["object.mass_kg = inf"]);
    refused_set("device.force_delay_ticks=20.5", &["device.force_delay_ticks = 20.5", "0 to 20 ticks"]);
    refused_set("object.force_delay_ticks=-0.1", &["object.force_delay_ticks = -0.1"]);
    refused_set("timing.control_period_s=0", &["timing.control_period_s = 0"]);
    refused_set("timing.ticks_per_packet=0", &["timing.ticks_per_packet = 0", "1 to 1000"]);
    refused_set("timing.ticks_per_packet=2.5", &["timing.ticks_per_packet = 2.5", "whole"]);
    refused_set("network.one_way_delay_packets=-1", &["network.one_way_delay_packets = -1"]);
    refused_set("contact.stiffness_n_per_m=1e9", &["contact.stiffness_n_per_m = 1000000000"]);
    refused_set("coordination.wave_impedance_n_s_per_m=0", &["coordination.wave_impedance_n_s_per_m = 0"]);
    refused_set("safety.max_force_n=1e6", &["safety.max_force_n = 1000000", "200 N"]);
    refused_set("user.1.push_n=1e9", &["user.1.push_n = 1000000000"]);
    refused_set("user.2.pulse_every_s=0", &["user.2.pulse_every_s = 0"]);
}

/// Who has no place for several shared axes says so, and what has none along several.
#[test]
fn several_axes_where_there_is_one() {
    let two = ["--set", "axis.count=2", "--set", "axis.shared=2"];
    let with = |command: &[&'static str]| [command, &two[..]].concat();
    let names = ["axis.shared = 2 is not allowed here", "cooperate"];
    refused(&with(&["shared", "cooperative", "--json"]), &names);
    let transparency = ["accuracy", "transparency", "--scene", "any-network", "--json"];
    refused(&with(&transparency), &["axis.shared = 2 is not allowed", "it must be 1", "an impedance is a matrix"]);
    refused(&with(&["cooperate", "--set", "contact.one_sided=true"]), &["contact.one_sided = true", "axis.shared"]);
    let weighs = "device.joint_inertia=0.1";
    refused_set(weighs, &["device.joint_inertia = 0.1", "axis.shared = 1"]);
    refused(&with(&["cooperate", "--set", weighs, "--set", "plant.coulomb_n=0.1"]), &["plant.coulomb_n = 0.1"]);
    refused_set("axis.shared=2", &["axis.shared = 2", "1 to 1"]);
}

#[test]
fn values_of_the_wrong_kind() {
    refused_set("object.mass_kg=heavy", &["object.mass_kg = \"heavy\"", "a number"]);
    refused_set("contact.one_sided=1", &["contact.one_sided = 1", "true or false"]);
    refused_set("coordination.comm=telepathy", &["coordination.comm = \"telepathy\"", "\"passive-wave\""]);
    for (before, now) in [("input-gated", "passivity-observer"), ("passivity-control", "passive-spring")] {
        let now = format!("it is {now} now");
        refused_set(&format!("coordination.comm={before}"), &["coordination.comm", "is not allowed", &now]);
    }
    refused_set("coordination.decode=5", &["coordination.decode = 5", "\"implicit\""]);
    refused_set("object.integrator=rk4", &["object.integrator = \"rk4\"", "\"semi-implicit\""]);
    refused_set("object.mass_kg=[1,2]", &["object.mass_kg"]);
    refused_set("object.mass_kg=.25.5", &["object.mass_kg = \".25.5\"", "a number"]);
    refused_set("object.mass_kg=infinity", &["object.mass_kg = \"infinity\"", "a number"]);
}

#[test]
fn keys_that_do_not_exist() {
    refused_set("object.mass=1", &["object.mass", "did you mean object.mass_kg?"]);
    refused_set("object.mass_g=300", &["object.mass_g", "object.mass_kg"]);
    refused_set("gravity.g=9.81", &["no table gravity", "device"]);
    refused_set("user.3.push_n=1", &["user.3.push_n"]);
    refused_set("contact.side=right", &["contact.side"]);
    refused_set("nonsense", &["nonsense", "table.key=value"]);
}

#[test]
fn combinations_that_cannot_be() {
    refused(
        &["cooperate", "--json", "--set", "kinematics.model=five-bar", "--set", "axis.count=1"],
        &["axis.count = 1", "2"],
    );
    refused(&["cooperate", "--json", "--set", "plant.encoder=true"], &["axis.velocity", "plant.encoder"]);
    refused(
        &["cooperate", "--json", "--set", "axis.velocity=filtered", "--set", "axis.velocity_cutoff_hz=900"],
        &["axis.velocity_cutoff_hz = 900", "500"],
    );
}

#[test]
fn scene_files() {
    refused(&["cooperate", "--json", "--scene", "/no/such/scene.toml"], &["/no/such/scene.toml"]);
    refused_scene("syntax.toml", "[object]\nmass_kg = = 3\n", &["syntax.toml:2"]);
    refused_scene("negative.toml", "[object]\n\nmass_kg = -3\n", &["negative.toml:3", "object.mass_kg = -3"]);
    refused_scene("table.toml", "[objet]\nmass_kg = 3\n", &["objet"]);
    refused_scene("twice.toml", "[object]\nmass_kg = 3\nmass_kg = 3\n", &["twice.toml:3"]);
    // The key has the same name in a table before it.
    let second = "[device]\nmass_kg = 3\n\n[object]\nmass_kg = -3\n";
    refused_scene("second.toml", second, &["second.toml:5", "object.mass_kg = -3"]);
    refused_scene("bare.toml", "mass_kg = 3\n", &["bare.toml:1", "mass_kg"]);
    refused(&["cooperate", "--scene", "matched-lin"], &["matched-lin", "did you mean matched-line?"]);
    refused(&["shared", "cooperative", "--scene", "match"], &["--scene match", "did you mean matched-line?"]);
}

#[test]
fn traces() {
    let traced = |csv: &str, text: &str, names: &[&str]| {
        file(csv, text);
        refused_scene(&format!("{csv}.toml"), &format!("[user.1]\ntrace = \"{csv}\"\n"), names);
    };
    traced("ragged.csv", "time_s,force_n\n0,1\n1\n", &["user.1.trace", "ragged.csv", "row 2"]);
    traced("words.csv", "time_s,force_n\n0,much\n", &["words.csv", "row 1", "two finite numbers"]);
    traced("nan.csv", "time_s,force_n\n0,NaN\n", &["nan.csv", "row 1"]);
    traced("back.csv", "time_s,force_n\n1,0\n0.5,0\n", &["back.csv", "row 2", "0.5 s"]);
    traced("header.csv", "t,f\n0,0\n", &["header.csv", "time_s,force_n"]);
    // A scene of somebody else's may name any file: what it holds is not told.
    let secret = "root:$6$salt:19000";
    for (csv, text) in [("shadow.csv", format!("{secret}\n0,0\n")), ("row.csv", format!("time_s,force_n\n{secret}\n"))]
    {
        let error = cohold_sim::user::Trace::read(Path::new(&file(csv, &text))).expect_err("no trace").to_string();
        assert!(error.contains(csv) && !error.contains("salt"), "{error}");
    }
    traced("empty.csv", "time_s,force_n\n", &["empty.csv", "no samples"]);
    refused_scene("gone.toml", "[user.2]\ntrace = \"gone.csv\"\n", &["user.2.trace", "gone.csv"]);
    refused_set("user.1.trace=5", &["user.1.trace = 5"]);
}

#[test]
fn arguments() {
    refused(&["cooperate", "--json", "--seconds", "-1"], &["--seconds"]);
    refused(&["cooperate", "--json", "--seconds", "nan"], &["--seconds"]);
    refused(&["cooperate", "--json", "--seconds", "0.0001"], &["--seconds 0.0001"]);
    refused(&["cooperate", "--json", "--out", "/proc/nowhere"], &["/proc/nowhere"]);
}

#[test]
fn live_peers_and_relays() {
    refused(&["network", "relay", "--listen-1", "nowhere", "--listen-2", "127.0.0.1:1"], &["nowhere"]);
    refused(&["cooperate", "--record", "run.csv"], &["--record", "run.csv", ".mcap", "cohold recording convert"]);
    let key = file("open.key", &"5a".repeat(32));
    let peer = ["peer", "--number", "1", "--listen", "127.0.0.1:0", "--connect", "127.0.0.1:9", "--key-file"];
    refused(&[&peer[..], &["/no/such.key"]].concat(), &["/no/such.key"]);
    refused(&[&peer[..], &[&key, "--seconds", "0"]].concat(), &["--seconds 0"]);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let mode = |mode| std::fs::set_permissions(&key, std::fs::Permissions::from_mode(mode)).expect("chmod");
        mode(0o644);
        refused(&[&peer[..], &[&key]].concat(), &["mode 644", "open to others", "chmod 600"]);
        mode(0o600);
        refused(&[&peer[..], &[&key, "--patience-s", "0.05"]].concat(), &["nobody answered", "127.0.0.1:9"]);
        let visit = [
            "shared",
            "world",
            "visit",
            "--line",
            "1",
            "--server",
            "1=127.0.0.1:9",
            "--seconds",
            "0.05",
            "--key-file",
            &key,
        ];
        refused(&visit, &["nobody answered from 127.0.0.1:9", "the key"]);
        let addresses = "127.0.0.1:0,127.0.0.1:9,127.0.0.1:10";
        let squash =
            ["shared", "squash", "live", "--number", "0", "--addresses", addresses, "--seconds", "0.05", "--key-file"];
        refused(
            &[&squash[..], &[&key]].concat(),
            &["nobody answered within 0.05 s: player 1 at 127.0.0.1:9 was silent, player 2 at 127.0.0.1:10 was silent"],
        );
    }
}

/// A negative number is a number out of range, not an unknown argument.
#[test]
fn negative_numbers() {
    let negative = |arguments: &[&str], names: &[&str]| {
        let words: Vec<&str> = arguments.iter().flat_map(|text| text.split(' ')).collect();
        refused(&words, names);
    };
    negative(&["shared world crowd --clients 10,-1"], &["--clients", "from 1 to 4096"]);
    negative(&["shared world crowd --clients -1"], &["--clients", "from 1 to 4096"]);
    negative(&["shared world crowd --seconds -1"], &["--seconds -1"]);
    negative(&["shared world crowd --warm-up-s -1"], &["--warm-up-s -1"]);
    negative(&["shared squash --players -1"], &["--players", "from 2 to 8"]);
    negative(&["shared squash --rtt-ms -1"], &["--rtt-ms -1", "2000 ms"]);
    negative(&["shared squash --seed -1"], &["--seed"]);
    negative(&["shared squash --rallies -1"], &["--rallies", "from 1 to 32767"]);
    let relay = "network relay --listen-1 127.0.0.1:0 --listen-2 127.0.0.1:0 --peer-1 127.0.0.1:9 --peer-2 127.0.0.1:9";
    negative(&[relay, "--seconds -1"], &["--seconds -1"]);
    negative(&["network trace --seconds -1 /no/such/trace.csv"], &["--seconds -1"]);
    let peer = "--listen 127.0.0.1:0 --connect 127.0.0.1:9 --key-file /no/such.key";
    negative(&["peer --number -1", peer], &["--number", "from 1 to 2"]);
    negative(&["peer --number 1 --seconds -1", peer], &["--seconds -1"]);
    negative(&["peer --number 1 --patience-s -1", peer], &["--patience-s -1"]);
    let serve = "shared world serve --world /no/such.toml --listen 127.0.0.1:0 --key-file /no/such.key";
    negative(&[serve, "--seconds -1"], &["--seconds -1"]);
    negative(&[serve, "--lines -1"], &["--lines", "from 1 to 4096"]);
    negative(&[serve, "--region -1"], &["--region"]);
    let visit = "shared world visit --key-file /no/such.key --server 1=127.0.0.1:1";
    negative(&[visit, "--line -1"], &["--line", "from 1 to 4096"]);
    for name in ["--seconds", "--stroke-s", "--radius-m"] {
        negative(&[visit, "--line 1", name, "-1"], &[&format!("{name} -1")]);
    }
    negative(&["key generate /tmp/x --line -1 --of /no/such.key"], &["--line", "from 1 to 4096"]);
}

#[test]
fn the_same_place_twice() {
    let visit = [
        "shared",
        "world",
        "visit",
        "--key-file",
        "/no/such.key",
        "--line",
        "1",
        "--server",
        "1=127.0.0.1:1",
        "--server",
    ];
    refused(&[&visit[..], &["1=127.0.0.1:2"]].concat(), &["--server 1=127.0.0.1:1", "--server 1=127.0.0.1:2"]);
    refused(&[&visit[..], &["2=127.0.0.1:1"]].concat(), &["--server 2=127.0.0.1:1", "an address of its own"]);
    let squash = ["shared", "squash", "live", "--number", "0", "--key-file", "/no/such.key", "--addresses"];
    let addresses = "127.0.0.1:1,127.0.0.1:2,127.0.0.1:1";
    refused(&[&squash[..], &[addresses]].concat(), &["--addresses has 127.0.0.1:1 twice"]);
}

#[test]
fn a_sweep_of_squash_chooses_for_itself() {
    for (name, value) in [("--rtt-ms", "50"), ("--bounder", "off"), ("--motion-bounder", "on")] {
        refused(&["shared", "squash", "--sweep", name, value], &["--sweep", name]);
    }
}

#[test]
fn stability_of_one_device() {
    let rendering = |arguments: &[&str], names: &[&str]| {
        refused(&[&["stability", "rendering", "--json"], arguments].concat(), names);
    };
    rendering(&["--device-mass-kg", "-1"], &["device_mass_kg = -1 is not allowed"]);
    rendering(&["--object-mass-kg", "nan"], &["object_mass_kg = NaN is not allowed"]);
    rendering(&["--device-damping-n-s-per-m", "0"], &["damping"]);
    rendering(&["--sampling-period-s", "0.0001"], &["delay_s", "0.02 s"]);
    refused(&["stability", "tune", "--json", "--margin", "-0.1"], &["margin = -0.1", "0 to 10"]);
}

#[test]
fn objects_that_cannot_be_stroked() {
    let world = file("shapes.toml", "[[strip]]\nid = 3\n[[block]]\nid = 4\n");
    let shape = |arguments: &[&str], names: &[&str]| {
        refused(&[&["shared", "world", "stroke", "--json"], arguments].concat(), names)
    };
    shape(&["--world", &world, "--object", "3"], &["a strip has no outline", "a wall, a body or a block"]);
    shape(&["--world", &world, "--object", "5"], &["--object 5", "shapes.toml", "3, 4"]);
    shape(&["--world", &world, "--object", "4", "--below-m", "0.06"], &["below_m = 0.06 is too much"]);
    shape(&["--world", &world], &["--object"]);
    shape(&["--mass-kg", "-1"], &["--mass-kg -1", "0.01 to 1000 kg"]);
    shape(&["--speed-m-per-s", "nan"], &["--speed-m-per-s nan", "0.001 to 1 m/s"]);
}

#[test]
fn calibrations_that_cannot_begin() {
    let out = folder().join("calibrated.toml").display().to_string();
    let calibrate = |rest: &[&str], names: &[&str]| refused(&[&["board", "calibrate"], rest].concat(), names);
    calibrate(&["counts", "--board", "simulated", "--out", &out], &["--distance-m", "--revolutions"]);
    calibrate(&["counts", "--board", "simulated", "--out", &out, "--distance-m", "-1"], &["a distance of -1"]);
    calibrate(&["motor", "--board", "simulated", "--out", &out], &["--gauge", "--added-mass-kg"]);
    calibrate(&["motor", "--board", "simulated", "--out", &out, "--added-mass-kg", "0"], &["an added mass of 0 kg"]);
    calibrate(&["inertia", "--board", "simulated", "--out", &out, "--joint", "2"], &["joint 2", "axis.count is 1"]);
    calibrate(&["sign", "--board", "here", "--out", &out], &["here is no address"]);
    calibrate(&["sign", "--board", "127.0.0.1", "--out", &out], &["--key-file is missing"]);
    calibrate(&["sign", "--board", "127.0.0.1", "--out", &out, "--set", "axis.count=2"], &["--board simulated"]);
    let broken = file("no-settings.toml", "encoder = 5\n");
    calibrate(&["sign", "--board", "simulated", "--out", &broken], &["no-settings.toml"]);
    assert!(!Path::new(&out).exists(), "a refused calibration leaves no file");
}

#[test]
fn recordings_that_cannot_be_made() {
    let out = folder().join("recording.bin").display().to_string();
    refused(&["board", "record", "--scene", "no-scene", &out], &["no-scene", "paper-5.2-power-16ms"]);
    refused(&["board", "record", "--scene", "impulsive", "--scene", "a.toml", &out], &["--scene", "multiple"]);
    refused(&["board", "record", "--seconds", "0", &out], &["--seconds 0"]);
    refused(&["board", "record", "--set", "network.clock_drift_ppm=5", &out], &["network.clock_drift_ppm"]);
    refused(&["board", "record", "/no/such/folder/recording.bin"], &["/no/such/folder/recording.bin"]);
}

#[test]
fn misspelt_words() {
    refused(&["coperate"], &["coperate", "did you mean cooperate?"]);
    refused(&["network", "relais"], &["relais", "did you mean relay?"]);
    refused(&["cooperate", "--secnds", "1"], &["--secnds", "did you mean --seconds?"]);
    refused(&["shared", "collaborate", "--mistake", "amnesa"], &["amnesa", "did you mean amnesia?"]);
    refused(&["paper", "--keys"], &["--keys"]);
}

/// What runs by the clock may run for longer than the day that a simulation is limited to.
#[test]
fn live_runs_may_last_for_weeks() {
    let key = file("long.key", &"5a".repeat(32));
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o600)).expect("chmod");
    }
    let peer = ["peer", "--number=1", "--listen=127.0.0.1:0", "--connect=127.0.0.1:9", "--key-file", &key];
    refused(&[&peer[..], &["--seconds=2592000", "--patience-s=0.05"]].concat(), &["nobody answered"]);
    refused(&["cooperate", "--seconds=2592000"], &["--seconds 2592000", "86400 s"]);
}
