//! Tests of `src/provision.rs` from inside.

use super::*;

#[test]
fn a_command_line() {
    let plan = Plan::parse(&["--probe", "0483:374e", "--key-file", "lab.key"]).map_err(|failure| failure.to_string());
    assert_eq!(plan, Ok(Plan { key_file: "lab.key", probe: Some("0483:374e") }));
    for wrong in [&[][..], &["--key-file"], &["--probe", "a"], &["--key-file", "a", "b"], &["--kee-file", "a"]] {
        assert!(Plan::parse(wrong).is_err(), "{wrong:?}");
    }
}

#[test]
fn the_key_has_the_sector_that_memory_x_says() {
    assert_eq!(address().map_err(|failure| failure.to_string()), Ok("0x081A0000".to_owned()));
}
