//! Power that goes while settings are saved.
//!
//! The flash controller is the emulator's: it programs 256-bit words after an unlock, takes the data sheet's time, and
//! flags what is done out of order.

use std::ops::Range;
use std::sync::Arc;

use crate::bench::{Bench, PERIOD_NS};
use crate::image::Firmware;
use crate::node::{Inputs, Node};
use crate::reviewed;
use crate::wire::Line;

/// The two sectors of the settings, and one slot (firmware/src/store.rs).
pub const STORE: Range<u64> = 0x081C_0000..0x0820_0000;
const SLOT: u64 = 8192;
/// Flash's status of bank 2, and the errors in it.
const STATUS: u64 = 0x5200_2110;
const ERRORS: u32 = 0x07EE_0000;

/// Board 1 at power-on with this in its flash.
pub fn board(firmware: &Arc<Firmware>, flash: &[(u64, u32)]) -> Bench {
    Bench::start_with(firmware, 1, Line::default(), flash)
}

fn set(bench: &mut Bench, mass: &str) {
    assert!(bench.ask(1, &format!("set object.mass_kg {mass}")).starts_with("ok"));
    assert_eq!(bench.ask(1, "apply"), "ok applied");
}

fn mass(bench: &mut Bench) -> String {
    bench.ask(1, "get object.mass_kg")
}

/// What a board that starts with this flash says it holds, at its first tick: how often it was saved.
fn generation(firmware: &Arc<Firmware>, flash: &[(u64, u32)]) -> u32 {
    let node = Node::new(firmware.clone(), 1);
    let tick = firmware.address("TIM6_DAC");
    let mut inputs = Inputs { poke: flash.to_vec(), watch: vec![tick], ..Inputs::default() };
    let mut ticks = (1..=60).map(|ms| {
        node.run(ms * PERIOD_NS, std::mem::take(&mut inputs));
        let stopped = node.wait();
        assert_eq!(stopped.resets, 0);
        (ms, !stopped.hits.is_empty())
    });
    let (ms, _) = ticks.find(|(_, ticks)| *ticks).expect("the tick runs");
    let at = firmware.address("SIGNALS");
    node.run(ms * PERIOD_NS + 1000, Inputs { peek: vec![at], ..Inputs::default() });
    let [generation] = node.wait().peeked[..] else { panic!("one word") };
    node.finish();
    generation
}

/// Saves twice and cuts the power after every word of the second: the board must start with the old settings or the new,
/// and save on. Gives how many cuts it made.
///
/// # Panics
/// It does not.
pub fn cuts(firmware: &Arc<Firmware>) -> usize {
    let mut bench = board(firmware, &[]);
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
        assert_eq!(generation(firmware, cut), expected, "power went after word {at} of {}", cuts.len() - 1);
    }
    for (at, expected) in [(0, "0.5"), (cuts.len() / 2, "0.5"), (cuts.len() - 2, "0.5"), (cuts.len() - 1, "0.625")] {
        let mut again = board(firmware, &cuts[at]);
        assert_eq!(mass(&mut again), format!("ok object.mass_kg = {expected}"), "power went after word {at}");
        assert!(again.ask(1, "status").contains("settings stored "), "power went after word {at}");
        // And it saves on, past what the cut left.
        set(&mut again, "0.75");
        assert_eq!(again.ask(1, "save"), "ok saved");
        let flash = again.flash(1, STORE.start..STORE.start + 3 * SLOT);
        assert_eq!(again.peek(1, [STATUS])[0] & ERRORS, 0, "the flash controller has something against it");
        again.finish().iter().for_each(reviewed::check);
        assert_eq!(generation(firmware, &flash), if at + 1 == cuts.len() { 3 } else { 2 });
    }

    // A record that an image cannot read for what it says is not half taken.
    let mut spoilt = first.clone();
    spoilt[20].1 ^= 1;
    assert_eq!(generation(firmware, &spoilt), 0);
    reviewed::check_all(&bench.finish());
    cuts.len() - 1
}
