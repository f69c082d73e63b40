//! Tests of `src/rig.rs` from inside.

use super::*;

const LIST: &str = "The following debug probes were found:
[0]: STLink V3 -- 0483:374e:003A0041 (ST-LINK)
[1]: STLink V3 -- 0483:374e:00420058 (ST-LINK)
[2]: J-Link -- 1366:0101-0:000760 (J-Link)
";

#[test]
fn two_boards_are_found_by_their_probes_or_what_is_missing_is_said() {
    let connected = probe::probes(LIST);
    assert_eq!(connected, ["0483:374e:003A0041", "0483:374e:00420058", "1366:0101-0:000760"]);
    let port = || Some(PathBuf::from("/dev/ttyACM1"));
    let found = find(["00420058", "003A0041"], &connected, port()).unwrap();
    assert_eq!(found.probes, ["0483:374e:00420058", "0483:374e:003A0041"]);
    assert_eq!(
        find(["0042", "003A0041"], &connected, None).unwrap_err(),
        "no probe has the serial number 0042 (connected: 003A0041, 00420058, 000760); no serial port in /dev/serial/by-id has the rig's 003A0041 in \
         its name: --port names it"
    );
    let none = probe::probes("No debug probes were found.");
    let why = find(["a", "b"], &none, port()).unwrap_err();
    assert_eq!(why.matches("(none is connected)").count(), 2, "{why}");
}

#[test]
fn the_command_line_names_two_boards_and_a_key() {
    for wrong in ["", "a", "a,", "a,a", "a,b,c"] {
        let why = two(wrong).unwrap_err().to_string();
        assert!(why.contains("must be the serial numbers of two probes, DUT,RIG"), "{wrong:?}: {why}");
    }
    let given = crate::read("rig", &["--boards", "a,b"]).unwrap();
    let why = rig(&given).unwrap_err().to_string();
    assert!(why.starts_with("--operator-key-file FILE is needed"), "{why}");
}

#[test]
fn a_board_starts_anew_by_its_own_probe() {
    assert_eq!(
        run::spelled(&reset("0483:374e:003A0041")),
        "openocd -f board/st_nucleo_h743zi.cfg -c adapter serial 003A0041 -c init; reset run; shutdown"
    );
}
