//! The step `recordings`: what cohold records is read by a library that is not its own, Python's `mcap` from the registry, in the
//! versions of tests/recordings/requirements.txt, in a virtual environment below target/.

use std::process::Command;

use crate::python::environment;
use crate::run::{self, Failure, command, run};

/// Records a run in memory and two live peers, converts both, and has tests/recordings/check.py compare them.
pub(crate) fn recordings() -> Result<(), Failure> {
    let folder = run::root().join("target/recordings");
    let python = environment("python3", &folder, "tests/recordings/requirements.txt", &[])?;
    let program = run::cohold(false)?.display().to_string();
    let made = folder.join("made");
    // What an earlier run left: nothing is written over it.
    let _ = std::fs::remove_dir_all(&made);
    std::fs::create_dir(&made).map_err(|cause| Failure::new(format!("cannot make {}: {cause}", made.display())))?;
    let file = |name: &str| made.join(name);
    let cohold = |words: &[&str]| command(&program, words);
    let scene = ["--scene", "any-network", "--set=user.1.push_n=1", "--set=user.2.push_n=1", "--seconds=2", "--json"];
    run(cohold(&["cooperate"]).args(scene).arg("--record").arg(file("memory.mcap")))?;
    run(cohold(&["key", "generate", "--json"]).arg(file("key")))?;
    let peer = |number: &str, listen: &str, connect: &str| -> Command {
        let mut peer = cohold(&["peer", "--quiet", "--number", number, "--listen", listen, "--connect", connect]);
        peer.args(scene).arg("--key-file").arg(file("key")).arg("--record").arg(file(&format!("peer-{number}.mcap")));
        peer
    };
    let [one, two] = ["127.0.0.1:47101", "127.0.0.1:47102"];
    let mut second = peer("2", two, one);
    let mut second = second.spawn().map_err(|cause| Failure::new(format!("cohold does not start: {cause}")))?;
    let first = run(&mut peer("1", one, two));
    let ended = second.wait().map_err(|cause| Failure::new(format!("cohold does not end: {cause}")))?;
    first?;
    if !ended.success() {
        return Err(Failure::new("the second of two live peers failed"));
    }
    for name in ["memory", "peer-1", "peer-2"] {
        let [recording, table] = ["mcap", "csv"].map(|ending| file(&format!("{name}.{ending}")));
        run(cohold(&["recording", "convert", "--json"]).arg(&recording).arg(&table))?;
        let mut check = command(&python.to_string_lossy(), &["tests/recordings/check.py"]);
        run(check.arg(recording).arg(table))?;
    }
    Ok(())
}
