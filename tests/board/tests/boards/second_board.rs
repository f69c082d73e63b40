//! The image for the NUCLEO-H753ZI, whose table of pins is its own: what the rig asks of it, by wires that end at pins by name, is what it is
//! for the first board. The emulated chip is an H743, which is the same but for CRYP and HASH.

use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::rig;

use crate::rig::test;

/// Pulses, both breaks, both encoders, the dead man, and every bit of a second.
const ASKED: [&str; 5] = ["tick-1-khz", "break-by-fault", "break-by-stop", "encoder-counts", "dead-man"];

#[test]
fn the_second_board_does_what_the_first_does() {
    let mut rigged = rig::start(Firmware::with("nucleo-h753zi").alone()).expect("both take it");
    for name in ASKED {
        let found = test(&mut rigged, name);
        println!("{name}: {found:?}");
        assert!(found.is_ok(), "{name}: {found:?}");
    }
    rigged.finish().iter().for_each(reviewed::check);
}

/// Drivers are shared, and the chips' dies are one: it is not much larger or smaller.
#[test]
fn its_image_is_as_large_as_the_first_boards() {
    let [first, second] = [Firmware::release(), Firmware::with("nucleo-h753zi")].map(|image| image.sections[".text"].1);
    assert!(first.abs_diff(second) < first / 100, "{first} and {second} bytes of program");
}
