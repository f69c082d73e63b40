//! Tests of `src/rooms.rs` from inside.

use super::*;

/// A package of these files, laid out in a folder that ends with the test.
fn package(name: &str, files: &[(&str, &str)]) -> Package {
    let folder = std::env::temp_dir().join(format!("rooms-{name}-{}", std::process::id()));
    let write = |file: &str, text: &str| {
        let path = folder.join(file);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        std::fs::write(path, text).expect("a file");
    };
    write("Cargo.toml", "[package]\nname = \"a-room\"\n");
    for (file, text) in files {
        write(&format!("src/{file}"), text);
    }
    let package = Package::read(&folder).expect("a package");
    std::fs::remove_dir_all(&folder).expect("gone");
    package
}

#[test]
fn a_circle_is_found_through_a_re_export_and_none_where_there_is_none() {
    let lib = ("lib.rs", "mod a;\nmod b;\npub use b::Two;\n");
    let round = package(
        "round",
        &[lib, ("a.rs", "use crate::Two;\n"), ("b.rs", "pub struct Two;\nfn f() { crate::a::f(); }\n")],
    );
    assert_eq!(round.circles(), [["a.rs", "b.rs"]]);
    let down = package(
        "down",
        &[
            lib,
            ("a.rs", "use crate::Two; // crate::b\n"),
            ("b.rs", "pub struct Two;\n#[cfg(test)]\nmod tests { use crate::a; }\n"),
        ],
    );
    assert!(down.circles().is_empty(), "{:?}", down.circles());
}

#[test]
fn an_import_that_climbs_is_named() {
    let order = vec![vec!["top".to_owned()], vec!["ground".to_owned()]];
    let files =
        [("lib.rs", "mod top;\nmod ground;\n"), ("top.rs", "use crate::ground::{self, One};\n"), ("ground.rs", "")];
    assert!(package("falls", &files).climbs(&order).is_empty());
    let files = [files[0], ("top.rs", "pub struct Two;"), ("ground.rs", "use super::top::Two;\n")];
    assert_eq!(package("climbs", &files).climbs(&order), ["ground.rs climbs to top.rs"]);
}
