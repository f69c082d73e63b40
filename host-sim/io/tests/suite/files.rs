use std::fs;
use std::path::{Path, PathBuf};

use cohold_io::{Kind, Most, append, is, read, text, write};

fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("io").join(name);
    let _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).expect("a folder");
    folder
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").file_name());
    let mut names: Vec<_> = entries.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

#[test]
fn a_file_is_replaced_whole_and_keeps_its_mode() {
    let folder = folder("whole");
    let file = folder.join("out.csv");
    write(&file, b"one", Kind::Named).expect("written");
    #[cfg(unix)]
    fs::set_permissions(&file, std::os::unix::fs::PermissionsExt::from_mode(0o640)).expect("own file");
    write(&file, b"two", Kind::Named).expect("written");
    assert_eq!(fs::read(&file).expect("there"), b"two");
    assert_eq!(names(&folder), ["out.csv"]);
    assert!(write(&folder.join("nowhere/out.csv"), b"two", Kind::Named).is_err());
    #[cfg(unix)]
    assert_eq!(
        std::os::unix::fs::PermissionsExt::mode(&fs::metadata(&file).expect("there").permissions()) & 0o777,
        0o640
    );
}

#[test]
fn what_was_not_named_is_never_written_over() {
    let folder = folder("beside");
    let file = folder.join("out.toml");
    write(&file, b"one", Kind::Beside).expect("written");
    write(&file, b"one", Kind::Beside).expect("the same");
    for kind in [Kind::Beside, Kind::New, Kind::Secret] {
        let refused = write(&file, b"two", kind).expect_err("it is there").to_string();
        assert_eq!(refused, "it exists, and is not written over");
    }
    assert!(write(&file, b"one", Kind::New).is_err());
    assert!(is(&file, b"one") && !is(&file, b"on") && !is(&file, b"ones"));
    assert_eq!(names(&folder), ["out.toml"]);
}

#[test]
fn what_is_read_has_bounds_that_are_named() {
    let file = folder("long").join("scene.toml");
    fs::write(&file, "12345678").expect("a file");
    assert_eq!(text(&file, Most::new(8, "a scene")).expect("eight"), "12345678");
    let refused = read(&file, Most::new(7, "a scene")).expect_err("too long").to_string();
    assert_eq!(refused, "a scene has at most 7 bytes, and it has more");
    fs::write(&file, b"\xff").expect("a file");
    assert_eq!(text(&file, Most::new(8, "a scene")).expect_err("no text").to_string(), "it is no text in UTF-8");
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_a_link_nor_beside_one() {
    let folder = folder("link");
    let (secret, link, gone) = (folder.join("secret"), folder.join("out"), folder.join("gone"));
    fs::write(&secret, "mine").expect("a file");
    std::os::unix::fs::symlink(&secret, &link).expect("a link");
    std::os::unix::fs::symlink(folder.join("nowhere"), &gone).expect("a link");
    // What an older version wrote into first.
    std::os::unix::fs::symlink(&secret, folder.join("fresh.part")).expect("a link");
    write(&folder.join("fresh"), b"theirs", Kind::Named).expect("written");
    for kind in [Kind::Named, Kind::Beside, Kind::New, Kind::Secret] {
        for path in [&link, &gone] {
            let refused = write(path, b"theirs", kind).expect_err("a link").to_string();
            assert_eq!(refused, "it is a link: it must be a regular file");
        }
    }
    assert!(append(&link).is_err() && append(&gone).is_err());
    assert_eq!(fs::read_to_string(&secret).expect("there"), "mine");
    assert_eq!(names(&folder), ["fresh", "fresh.part", "gone", "out", "secret"]);
    // To read through one is no harm: users link their scenes.
    assert_eq!(text(&link, Most::new(8, "a scene")).expect("a link to a file"), "mine");
}

#[cfg(unix)]
#[test]
fn what_has_no_end_is_not_begun() {
    let fifo = folder("fifo").join("scene.toml");
    assert!(std::process::Command::new("mkfifo").arg(&fifo).status().expect("mkfifo").success());
    for path in [&fifo, Path::new("/dev/zero"), Path::new("/dev/tty")] {
        // A terminal that there is not cannot be opened at all.
        let refused = read(path, Most::new(1 << 20, "a scene")).expect_err("no file").to_string();
        assert!(path.ends_with("tty") || refused == "it is a pipe or a device: it must be a regular file", "{refused}");
        for kind in [Kind::Named, Kind::Beside, Kind::New] {
            assert!(write(path, b"x", kind).is_err());
        }
        assert!(append(path).is_err());
    }
    let refused = read(fifo.parent().expect("a folder"), Most::new(1, "a scene")).expect_err("a folder").to_string();
    assert_eq!(refused, "it is a folder: it must be a regular file");
}

#[cfg(unix)]
#[test]
fn a_secret_is_its_owners_alone() {
    use std::os::unix::fs::PermissionsExt;
    let file = folder("secret").join("lab.key");
    write(&file, b"key", Kind::Secret).expect("written");
    assert_eq!(fs::metadata(&file).expect("there").permissions().mode() & 0o777, 0o600);
}
