//! What a meeting place is installed by: the recipe of an image and the unit of systemd name what is there, and give the program what it takes. An image is not built.

use std::path::Path;
use std::process::Command;

use super::peers::COHOLD;

fn read(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("guests/homes").join(name);
    std::fs::read_to_string(&path).unwrap_or_else(|cause| panic!("{}: {cause}", path.display()))
}

/// What stands behind each word like this at the beginning of a line.
fn lines<'a>(text: &'a str, word: &str) -> Vec<&'a str> {
    text.lines().filter_map(|line| line.strip_prefix(word)).map(str::trim).collect()
}

/// The program takes these arguments, on any port, and ends well.
fn serves(arguments: &[&str]) {
    let [all @ .., listen] = arguments else { panic!("no arguments") };
    let (address, _port) = listen.rsplit_once(':').expect("an address and a port");
    let mut command = Command::new(COHOLD);
    let output = command.args(all).args([&format!("{address}:0"), "--seconds", "0.2"]).output().expect("it runs");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn the_recipe_of_an_image_names_what_is_there_and_the_program_takes_what_it_is_given() {
    let (recipe, root) = (read("Dockerfile"), Path::new(env!("CARGO_MANIFEST_DIR")).join(".."));
    // The compiler is the one that the repository asks for.
    let toolchain = std::fs::read_to_string(root.join("rust-toolchain.toml")).expect("a toolchain");
    let wanted = toolchain.lines().find_map(|line| line.strip_prefix("channel = \"")).expect("a channel");
    let images = lines(&recipe, "FROM ");
    let compiler = images[0].strip_prefix("rust:").and_then(|image| image.split('-').next()).expect("an image of rust");
    assert!(wanted.starts_with(compiler), "{compiler} for {wanted}");
    // The whole repository is copied, but for what its build does not need.
    let copied = lines(&recipe, "COPY ");
    let [all, program] = copied[..] else { panic!("{copied:?}") };
    assert_eq!(all, ". .");
    let left_out = read("Dockerfile.dockerignore");
    let left_out: Vec<_> =
        left_out.lines().filter(|line| !line.starts_with('#')).map(|line| line.trim_start_matches("**/")).collect();
    let files = Command::new("git").args(["ls-files", "-z"]).current_dir(&root).output().expect("git runs");
    let files = String::from_utf8(files.stdout).expect("names");
    assert!(files.split('\0').any(|file| file == "Cargo.lock"), "--locked needs it");
    let of_it = files.split('\0').find(|file| file.split('/').any(|part| left_out.contains(&part)));
    assert_eq!(of_it, None, "it is part of the repository and left out");
    // What is built is what is copied on, and what runs.
    let built = lines(&recipe, "RUN ")[0];
    assert_eq!(built, format!("cargo build --locked --release --package {} --bin cohold", env!("CARGO_PKG_NAME")));
    let placed = program.split_whitespace().collect::<Vec<_>>();
    let [_, from, to] = placed[..] else { panic!("{program}") };
    assert_eq!((from, to), ("/src/target/release/cohold", "/usr/local/bin/cohold"));
    let list = |word: &str| serde_json::from_str::<Vec<String>>(lines(&recipe, word)[0]).expect("a list");
    let (entry, given) = (list("ENTRYPOINT "), list("CMD "));
    assert_eq!(entry[0], to);
    serves(&entry[1..].iter().chain(&given).map(String::as_str).collect::<Vec<_>>());
    let port = given.last().and_then(|listen| listen.rsplit(':').next()).expect("a port");
    assert_eq!(lines(&recipe, "EXPOSE ")[0], format!("{port}/udp"));
}

#[test]
fn the_unit_of_systemd_gives_the_program_what_it_takes() {
    let unit = read("meet.service");
    let words: Vec<&str> = lines(&unit, "ExecStart=")[0].split_whitespace().collect();
    assert_eq!(words[0], "/usr/local/bin/cohold");
    serves(&words[1..]);
}
