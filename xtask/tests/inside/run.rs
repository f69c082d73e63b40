use super::*;

/// Two checkouts with one target folder run one binary; each is to work on its own files.
#[test]
fn the_checkout_is_that_of_the_package_or_else_of_the_directory() {
    let folder = std::env::temp_dir().join(format!("cohold-xtask-{}", std::process::id()));
    let [one, other] = ["one", "other"].map(|name| folder.join(name));
    for root in [&one, &other] {
        let xtask = root.join("xtask");
        std::fs::create_dir_all(xtask.join("src")).expect("a folder");
        std::fs::write(xtask.join("Cargo.toml"), "").expect("a file");
    }
    let (package, below) = (one.join("xtask"), other.join("xtask/src"));
    let found = [(Some(&*package), &*below), (None, &*below), (None, &*folder), (Some(&*folder), &*other)]
        .map(|(a, b)| checkout(a, b));
    std::fs::remove_dir_all(&folder).expect("they go");
    assert_eq!(found, [Some(one), Some(other.clone()), None, Some(other)]);
}

/// The tests' own cargo names this package.
#[test]
fn the_root_is_this_checkout() {
    assert_eq!(root(), Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("a parent"));
}
