//! Tests of `src/probe.rs` from inside.

use super::*;

#[test]
fn a_command_line() {
    let given = crate::read("provision", &["--probe", "0483:374e", "--key-file", "lab.key"]).unwrap();
    assert_eq!((given.value("--key-file"), given.value("--probe")), (Some("lab.key"), Some("0483:374e")));
    for wrong in [&["--key-file"][..], &["--key-file", "a", "b"], &["--kee-file", "a"]] {
        assert!(crate::read("provision", wrong).is_err(), "{wrong:?}");
    }
    for wrong in [&[][..], &["--probe", "a"]] {
        assert!(provision(&crate::read("provision", wrong).unwrap()).is_err(), "{wrong:?}");
    }
}

#[test]
fn the_key_has_the_sector_that_memory_x_says() {
    assert_eq!(address().map_err(|failure| failure.to_string()), Ok("0x081A0000".to_owned()));
}
