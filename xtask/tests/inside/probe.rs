//! Tests of `src/probe.rs` from inside.

use super::*;

#[test]
fn a_command_line() {
    let both = ["--probe", "0483:374e", "--key-file", "lab.key", "--operator-key-file", "own.key"];
    let given = crate::read("provision", &both).unwrap();
    let given = ["--key-file", "--operator-key-file", "--probe"].map(|option| given.value(option));
    assert_eq!(given, [Some("lab.key"), Some("own.key"), Some("0483:374e")]);
    for wrong in [&["--key-file"][..], &["--key-file", "a", "b"], &["--kee-file", "a"]] {
        assert!(crate::read("provision", wrong).is_err(), "{wrong:?}");
    }
    for wrong in [&[][..], &["--probe", "a"], &["--key-file", "a"], &["--operator-key-file", "a"]] {
        let why = provision(&crate::read("provision", wrong).unwrap()).unwrap_err().to_string();
        assert!(why.contains("-key-file FILE is needed"), "{wrong:?}: {why}");
    }
}

#[test]
fn the_keys_have_the_sector_that_memory_x_says() {
    assert_eq!(address().map_err(|failure| failure.to_string()), Ok("0x081A0000".to_owned()));
}
