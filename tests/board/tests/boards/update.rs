//! Another image without a probe: an order leads to the ROM's bootloader, only while disarmed, with the chip as a reset leaves it; and what `cohold
//! board update` writes for it starts, and finds keys and settings where they were.

use std::path::Path;
use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::{self, Firmware};
use board_bench::part::rom;
use board_bench::power::{STORE, board};
use board_bench::reviewed;
use rigless::image::Image;

/// GPIOF_MODER, and what a reset leaves in it: every pin floats, PF3 among them, which enables bridges and amplifiers.
const PORT_F: (u64, u32) = (0x5802_1400, 0xFFFF_FFFF);
/// Bank 1.
const BANK_1: u64 = 0x0800_0000;

/// Runs the board until it is in its ROM; whether it comes there within so many ms.
fn comes_to_the_rom(bench: &mut Bench, ms: u64) -> bool {
    (0..ms).any(|_| {
        bench.step();
        bench.stopped[0].hits.iter().any(|hit| hit.address == u64::from(rom::ENTRY))
    })
}

#[test]
fn an_order_leads_to_the_bootloader_and_only_while_disarmed() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = board(&firmware, &[]);
    bench.tell_of_amplifiers(1);
    bench.input(1).watch.push(rom::ENTRY.into());
    bench.check(1).expect("it passes");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    assert_eq!(bench.ask(1, "update"), "error disarm first");
    assert!(!comes_to_the_rom(&mut bench, 1000) && bench.stopped[0].resets == 0);
    assert!(bench.stopped[0].bridges.enable, "the motors stay on");

    assert_eq!(bench.ask(1, "disarm"), "ok disarmed");
    let answer = bench.ask(1, "update");
    assert_eq!(
        answer,
        "ok in 0.5 s the bootloader of the ROM runs, on the board's own USB; its black button starts the image"
    );
    // Until then nothing moves.
    for line in ["arm", "check 1"] {
        assert_eq!(bench.ask(1, line), "error the board starts its bootloader", "{line}");
    }
    assert!(comes_to_the_rom(&mut bench, 600));
    bench.step();
    let (pins, bridges) = (bench.peek(1, [PORT_F.0]), bench.stopped[0].bridges);
    assert_eq!(pins, [PORT_F.1]);
    assert!(!bridges.enable && !bridges.outputs, "{bridges:?}");
    // The ROM's own stack, and no word left that leads there again.
    let left = firmware.address("LEFT_FOR_START");
    assert_eq!(bench.peek(1, [u64::from(rom::STACK) - 4, left, left + 4]), [rom::STACK, 0, 0]);
    // No watchdog ends it.
    assert!(!comes_to_the_rom(&mut bench, 200) && bench.stopped[0].resets == 1);

    // Done there, any reset starts the image.
    bench.input(1).poke.push((u64::from(rom::STACK) - 4, 0));
    assert!(!comes_to_the_rom(&mut bench, 60) && bench.stopped[0].resets == 2);
    bench.align(&firmware);
    bench.meet(1);
    assert!(bench.ask(1, "status").contains(" disarmed fault 0 "));
    bench.finish().iter().for_each(reviewed::check);
}

#[test]
fn what_the_bootloader_is_given_starts_and_finds_keys_and_settings() {
    let bytes =
        cohold_board_tools::image::flash(&std::fs::read(image::path()).expect("it is there")).expect("an image");
    let mut bench = board(&Arc::new(Firmware::release()), &[]);
    for line in ["set safety.max_force_n 2.5", "apply", "save"] {
        assert!(bench.ask(1, line).starts_with("ok"), "{line}");
    }
    bench.run_for_ms(1100);
    // The emulator's own loader has put the same words into bank 1.
    let words = bytes.as_chunks().0.iter().map(|bytes| u32::from_le_bytes(*bytes));
    let given = (BANK_1..).step_by(4).zip(words).filter(|(_, word)| *word != u32::MAX);
    assert_eq!(bench.flash(1, BANK_1..BANK_1 + bytes.len() as u64), given.collect::<Vec<_>>());
    let kept = bench.flash(1, STORE);
    bench.finish();

    let image = Image::new(Path::new("update.bin"), bytes, Some(BANK_1)).expect("bytes at an address");
    // Its keys are in bank 2, as those of every board of the bench.
    let mut updated = Firmware::release();
    updated.image = image;
    let mut bench = board(&Arc::new(updated), &kept);
    assert!(bench.ask(1, "status").contains("settings stored 1;"));
    assert_eq!(bench.ask(1, "get safety.max_force_n"), "ok safety.max_force_n = 2.5");
    bench.finish().iter().for_each(reviewed::check);
}
