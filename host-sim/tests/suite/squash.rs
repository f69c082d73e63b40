//! Squash as a command and as processes on loopback.

use std::path::Path;
use std::process::{Child, Command, Stdio};

use super::program::free;

const PROGRAM: &str = env!("CARGO_BIN_EXE_cohold");

#[test]
fn the_command_line_plays_and_refuses() {
    let run = |line: &str| Command::new(PROGRAM).args(line.split(' ')).output().unwrap();
    let good = run("shared squash --players 2 --rtt-ms 50 --seconds 20 --json");
    let document: serde_json::Value = serde_json::from_slice(&good.stdout).unwrap();
    assert!(good.status.success() && document["agreed"] == true && document["left_the_court"] == 0, "{document}");
    for (line, part) in [
        ("shared squash --players 9", "from 2 to 8"),
        ("shared squash --rtt-ms -1", "from 0 to 2000 ms"),
        ("shared squash --seconds NaN", "up to 86400 s"),
        ("shared squash --set network.loss=2", "network.loss"),
        ("shared squash --set network.asymmetry_s=0.01", "network.asymmetry_s is not allowed here"),
        ("shared squash --rallies 0", "--rallies"),
        ("shared squash live --number 1 --addresses 127.0.0.1:1 --key-file /nowhere", "/nowhere"),
        ("shared collaborate --users 1", "from 2 to 8"),
        ("shared collaborate --mistake no-fence --scheme ring", "only with --scheme lock"),
    ] {
        let bad = run(line);
        let said = String::from_utf8_lossy(&bad.stderr);
        assert_eq!(bad.status.code(), Some(2), "{line}: {said}");
        assert!(said.contains(part) && said.lines().count() == 1 && bad.stdout.is_empty(), "{line}: {said}");
    }
}

/// A folder of this process's own, gone at the end.
struct Folder(std::path::PathBuf);

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

impl Folder {
    fn new(name: &str) -> Self {
        let folder = Self(std::env::temp_dir().join(format!("haptic-{name}-{}", std::process::id())));
        std::fs::create_dir_all(&folder.0).unwrap();
        folder
    }

    /// A new key file.
    fn key(&self, name: &str) -> std::path::PathBuf {
        let key = self.0.join(name);
        assert!(Command::new(PROGRAM).args(["key", "generate"]).arg(&key).output().unwrap().status.success());
        key
    }
}

/// One process of a game.
fn join(number: usize, addresses: &[&String], key: &Path, seconds: &str) -> Child {
    let addresses = addresses.iter().map(|address| address.as_str()).collect::<Vec<_>>().join(",");
    Command::new(PROGRAM)
        .args(["shared", "squash", "live", "--json", "--seconds", seconds])
        .args(["--number", &number.to_string(), "--addresses", &addresses, "--key-file"])
        .arg(key)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// What the server and three players report of a game of 8 s, each a process of its own.
fn game(key: &Path) -> [serde_json::Value; 4] {
    let addresses = [(); 4].map(|()| free());
    let addresses = addresses.each_ref();
    let games = [0, 1, 2, 3].map(|number| join(number, &addresses, key, if number == 0 { "9" } else { "8" }));
    games.map(|game| {
        let output = game.wait_with_output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        serde_json::from_slice::<serde_json::Value>(&output.stdout).unwrap()
    })
}

/// Four processes on loopback: a server and three players, sealed.
#[test]
fn processes_play_over_udp_and_agree() {
    let folder = Folder::new("squash");
    let key = folder.key("key");
    let ruled =
        |reports: &[serde_json::Value]| reports[0]["rallies"].as_array().is_some_and(|rallies| !rallies.is_empty());
    // Real time: now and then one rally fills a game.
    let games = (0..4).map(|_| game(&key));
    let reports = games.into_iter().find(|reports| ruled(reports)).expect("a rally ends in one of four games");
    let rallies = |at: usize| reports[at]["rallies"].as_array().unwrap();
    for player in 1..4 {
        // All but the last, which may have been on its way when the player stopped.
        assert!(rallies(player).len() + 2 >= rallies(0).len(), "{reports:?}");
        assert!(rallies(player).iter().zip(rallies(0)).all(|(one, two)| one == two), "{reports:?}");
        assert_eq!(reports[player]["refused"], 0, "{reports:?}");
    }
    assert!((1..4).any(|player| reports[player]["strokes"].as_u64() > Some(0)), "{reports:?}");
    for (number, report) in reports.iter().enumerate() {
        let others = report["others"].as_array().unwrap();
        let numbers: Vec<_> = others.iter().filter_map(|other| other["number"].as_u64()).collect();
        assert!(numbers == (0..4).filter(|other| *other != number as u64).collect::<Vec<_>>(), "{reports:?}");
        let heard = |other: &serde_json::Value| {
            let [first_s, last_s] = ["first_heard_s", "last_heard_s"].map(|when| other[when].as_f64().unwrap());
            0.0 < first_s && first_s <= last_s && last_s < 9.5
        };
        assert!(others.iter().all(heard), "{reports:?}");
    }
}

/// A server; a player with another key; one that is not where the others look for it; one that is not there.
#[test]
fn whoever_meets_nobody_says_so_and_what_to_check() {
    let folder = Folder::new("nobody");
    let [right, wrong] = ["right", "wrong"].map(|name| folder.key(name));
    let [server, one, two, elsewhere] = [(); 4].map(|()| free());
    let games = [
        join(0, &[&server, &one, &two], &right, "1"),
        join(1, &[&server, &one, &two], &wrong, "1"),
        join(2, &[&server, &one, &elsewhere], &right, "1"),
    ];
    let [by_server, by_one, by_two] = games.map(|game| {
        let output = game.wait_with_output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.code() == Some(2) && output.stdout.is_empty() && said.lines().count() == 1, "{said}");
        assert!(said.contains("nobody answered within 1 s") && said.contains("check that they run now"), "{said}");
        said
    });
    let silent = |said: &str, who: &str| assert!(said.contains(&format!("{who} was silent")), "{said}");
    for said in [&by_server, &by_one] {
        assert!(said.contains("another shared key"), "{said}");
        silent(said, &format!("player 2 at {two}"));
        assert!(said.contains(&format!("from elsewhere, the last from {elsewhere}")), "{said}");
    }
    silent(&by_two, &format!("the server at {server}"));
    silent(&by_two, &format!("player 1 at {one}"));
}
