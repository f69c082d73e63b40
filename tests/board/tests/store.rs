//! Settings in flash: saved while disarmed, there at the next start, and whole whenever power goes.
//!
//! The flash controller is the emulator's: it programs 256-bit words after an unlock, takes the data sheet's time, and
//! flags what is done out of order.

use std::ops::Range;
use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::node::{Inputs, Node};
use board_bench::pair::Bench;
use board_bench::pc::{Pc, key, key_in_flash};
use board_bench::reviewed;
use board_bench::wire::Line;

/// The two sectors of the settings, and one slot (firmware/src/store.rs).
const STORE: Range<u64> = 0x081C_0000..0x0820_0000;
const SLOT: u64 = 8192;
/// Flash's status of bank 2, and the errors in it.
const STATUS: u64 = 0x5200_2110;
const ERRORS: u32 = 0x07EE_0000;

fn board(firmware: &Arc<Firmware>, flash: &[(u64, u32)]) -> Bench {
    Bench::start_with(firmware, 1, Line::default(), flash)
}

fn set(bench: &mut Bench, mass: &str) {
    assert!(bench.ask(1, &format!("set object.mass_kg {mass}")).starts_with("ok"));
    assert_eq!(bench.ask(1, "apply"), "ok applied");
}

fn mass(bench: &mut Bench) -> String {
    bench.ask(1, "get object.mass_kg")
}

/// What a board that starts with this flash says it holds: how often it was saved.
fn generation(firmware: &Arc<Firmware>, flash: &[(u64, u32)]) -> u32 {
    let node = Node::new(firmware.clone(), 1);
    node.run(60_000_000, Inputs { poke: flash.to_vec(), ..Inputs::default() });
    assert_eq!(node.wait().resets, 0);
    let at = firmware.address("SETTINGS_GENERATION");
    node.run(60_001_000, Inputs { peek: vec![at], ..Inputs::default() });
    let [generation] = node.wait().peeked[..] else { panic!("one word") };
    node.finish();
    generation
}

#[test]
fn power_may_go_at_any_word_and_during_an_erase() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = board(&firmware, &[]);
    assert!(bench.ask(1, "status").contains("settings defaults 0;"));

    // The first save erases a sector that nothing is known of; the tick, the watchdog and the console go on.
    set(&mut bench, "0.5");
    assert_eq!(bench.ask(1, "save"), "ok saving, a few seconds: flash is being erased");
    assert_eq!(bench.ask(1, "arm"), "error the settings are being saved");
    assert_eq!(bench.ask(1, "save"), "error the settings are being saved");
    bench.count_instructions();
    bench.run_for_ms(1100);
    assert!(bench.ask(1, "status").contains("settings defaults 1;"));
    let ticks = bench.meters[0].began.len() as u64;
    assert!((1100..1110).contains(&ticks), "{ticks} ticks in 1100 ms with an erase in them");
    let first = bench.flash(1, STORE.start..STORE.start + 2 * SLOT);

    // The second stands behind it. Power goes after every word.
    set(&mut bench, "0.625");
    bench.send(1, "save");
    let mut cuts = vec![first.clone()];
    for _ in 0..400 {
        bench.run_for_us(49);
        let now = bench.flash(1, STORE.start..STORE.start + 2 * SLOT);
        if cuts.last() != Some(&now) {
            cuts.push(now);
        }
    }
    assert!(bench.ask(1, "status").contains("settings defaults 2;"));
    assert!(cuts.len() > 40, "{} states of the flash", cuts.len());
    for (at, cut) in cuts.iter().enumerate() {
        // Each word is one step: eight words of 32 bits.
        let expected = if at + 1 == cuts.len() { 2 } else { 1 };
        assert_eq!(generation(&firmware, cut), expected, "power went after word {at} of {}", cuts.len() - 1);
    }
    println!("power cut after each of {} words: old or new", cuts.len() - 1);
    for (at, expected) in [(0, "0.5"), (cuts.len() / 2, "0.5"), (cuts.len() - 2, "0.5"), (cuts.len() - 1, "0.625")] {
        let mut again = board(&firmware, &cuts[at]);
        assert_eq!(mass(&mut again), format!("ok object.mass_kg = {expected}"), "power went after word {at}");
        assert!(again.ask(1, "status").contains("settings stored "), "power went after word {at}");
        // And it saves on, past what the cut left.
        set(&mut again, "0.75");
        assert_eq!(again.ask(1, "save"), "ok saved");
        let flash = again.flash(1, STORE.start..STORE.start + 3 * SLOT);
        assert_eq!(again.peek(1, [STATUS])[0] & ERRORS, 0, "the flash controller has something against it");
        again.finish().iter().for_each(reviewed::check);
        assert_eq!(generation(&firmware, &flash), if at + 1 == cuts.len() { 3 } else { 2 });
    }

    // A record that an image cannot read for what it says is not half taken.
    let mut spoilt = first.clone();
    spoilt[20].1 ^= 1;
    assert_eq!(generation(&firmware, &spoilt), 0);
    for report in bench.finish() {
        assert_eq!(report.resets, Vec::<String>::new());
        reviewed::check(&report);
    }
}

#[test]
fn nothing_is_written_while_armed() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = board(&firmware, &[]);
    assert_eq!(bench.check(1), Ok(()));
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    assert_eq!(bench.ask(1, "save"), "error disarm first");
    assert_eq!(bench.ask(1, "apply"), "error disarm first");
    bench.run_for_ms(20);
    assert_eq!(bench.flash(1, STORE), []);
    bench.finish();
}

/// What a board says in its first 2 s with settings like these, an ARP request for `asked` among what it hears.
fn first_words(firmware: &Arc<Firmware>, settings: &[&str], asked: [u8; 4]) -> Vec<Vec<u8>> {
    let mut bench = board(firmware, &[]);
    for line in settings {
        assert!(bench.ask(1, &format!("set {line}")).starts_with("ok"));
    }
    assert_eq!(bench.ask(1, "apply"), "ok applied");
    assert!(bench.ask(1, "save").starts_with("ok"));
    bench.run_for_ms(1100);
    let mut flash = bench.flash(1, STORE);
    bench.finish();
    flash.extend(key_in_flash(&key()));

    let node = Node::new(firmware.clone(), 1);
    let mut inputs = Inputs { poke: flash, ..Inputs::default() };
    let mut words = Vec::new();
    for ms in 1..2000_u64 {
        node.run(1_000_000 * ms, std::mem::take(&mut inputs));
        words.extend(node.wait().frames.into_iter().map(|(_, frame)| frame));
        if ms % 100 == 0 {
            inputs.frames.push(Pc::ask_for(asked));
        }
    }
    reviewed::check(&node.finish());
    words
}

/// Whether somebody says that he has an address.
fn has(words: &[Vec<u8>], ip: [u8; 4]) -> bool {
    words.iter().any(|frame| frame[12..14] == [8, 6] && frame[20..22] == [0, 2] && frame[28..32] == ip)
}

#[test]
fn addresses_are_taken_at_the_next_start() {
    let firmware = Arc::new(Firmware::release());
    let own = [192, 168, 77, 50];
    let words = first_words(&firmware, &["network.address 192.168.77.50", "network.peer 192.168.77.60"], own);
    assert!(has(&words, own));
    let asks_for = |ip: [u8; 4]| words.iter().any(|frame| frame[12..14] == [8, 6] && frame[38..42] == ip);
    assert!(asks_for([192, 168, 77, 60]) && !asks_for([192, 168, 77, 2]), "it looks for the peer that it was told");
    assert!(!has(&first_words(&firmware, &["network.address 192.168.77.50"], [192, 168, 77, 1]), [192, 168, 77, 1]));

    // Asking the network: a broadcast from UDP 68 to 67 that begins as BOOTP's requests do.
    let words = first_words(&firmware, &["network.dhcp true"], [192, 168, 77, 1]);
    let asks =
        |frame: &Vec<u8>| frame[..6] == [0xFF; 6] && frame.get(34..38) == Some(&[0, 68, 0, 67]) && frame[42] == 1;
    assert!(words.iter().any(asks) && !has(&words, [192, 168, 77, 1]));
}
