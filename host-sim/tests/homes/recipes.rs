//! The recipes of docs/guides/own-network.md that measure a network with irtt or ping, as they are printed there, between this machine and itself and
//! for a shorter time. The programs are Debian's; `cargo xtask test --only homes` installs them.

use std::path::Path;
use std::process::{Command, Stdio};

use super::pages::folder;
use super::peers::{COHOLD, Running};

const PAGE: &str = include_str!("../../../docs/guides/own-network.md");
/// What is printed, and what is run instead.
const HERE: [(&str, &str); 4] =
    [("ADDRESS", "127.0.0.1"), ("-i 1ms", "-i 1ms -b 127.0.0.1:2112"), ("-d 5m", "-d 2s"), ("-c 30000", "-c 300")];

/// The commands on the page from the one that begins like this to the next that is cohold's, without remarks.
fn recipe(beginning: &str) -> Vec<String> {
    let commands = PAGE.lines().filter_map(|line| line.strip_prefix("    "));
    let from: Vec<&str> = commands.skip_while(|line| !line.starts_with(beginning)).collect();
    let end = from.iter().position(|line| line.starts_with("cohold")).expect("a command of cohold");
    let bare = |line: &&str| line.split(" # ").next().unwrap_or(line).trim_end().to_owned();
    from[..=end].iter().map(bare).collect()
}

/// A command of the page, to run in a folder.
fn command(printed: &str, folder: &Path) -> Command {
    let here = HERE.iter().fold(printed.to_owned(), |printed, (from, to)| printed.replace(from, to));
    let mut words = here.split(' ').filter(|word| !word.is_empty());
    let name = words.next().expect("a program");
    let mut command = Command::new(if name == "cohold" { COHOLD } else { name });
    command.args(words).current_dir(folder).stderr(Stdio::inherit());
    command
}

/// What a command of the page prints, which must end well; into the file that follows `>`, if one does.
fn runs(printed: &str, folder: &Path) -> String {
    let (printed, file) = printed.split_once(" > ").map_or((printed, None), |(printed, file)| (printed, Some(file)));
    let out = command(printed, folder).output().unwrap_or_else(|error| panic!("{printed}: {error}"));
    let said = String::from_utf8(out.stdout).expect("text");
    // 1 says that the copies came apart: over a machine that was busy meanwhile they may.
    let most = i32::from(printed.starts_with("cohold"));
    assert!(out.status.code().is_some_and(|code| code <= most), "{printed}: {}\n{said}", out.status);
    if let Some(file) = file {
        std::fs::write(folder.join(file), &said).expect("a file");
    }
    said
}

#[test]
#[ignore = "needs irtt: cargo xtask test --only homes"]
fn a_network_that_irtt_measured_is_simulated() {
    let folder = folder("irtt");
    let commands = recipe("irtt server");
    let [server, client, run] = commands.as_slice() else { panic!("a server, a client and a run: {commands:?}") };
    let _server = Running::start(command(server, &folder));
    // A client that comes before it listens, at port 2112, is refused.
    let listens = || std::fs::read_to_string("/proc/net/udp").expect("Linux").contains(":0840 ");
    (0..500).take_while(|_| !listens()).for_each(|_| std::thread::sleep(std::time::Duration::from_millis(20)));
    runs(client, &folder);
    assert!(runs(run, &folder).contains("any-network"), "{run}");
    // The same, compressed as irtt does it where a name has no ending.
    runs(&client.replace("mine.json", "packed"), &folder);
    let packed = runs(&run.replace("mine.json", "packed.json.gz"), &folder);
    assert!(packed.contains("any-network"), "{packed}");
}

#[test]
#[ignore = "needs ping: cargo xtask test --only homes"]
fn a_network_that_was_pinged_is_simulated() {
    let folder = folder("ping");
    let said: Vec<String> = recipe("ping -D").iter().map(|printed| runs(printed, &folder)).collect();
    assert!(said[0].lines().filter(|line| line.contains("icmp_seq=")).count() > 250, "{}", said[0]);
    assert!(said[1].contains("any-network"), "{}", said[1]);
}
