//! Settings in flash: saved only while disarmed, there at the next start. What a power cut leaves, faults.rs tries.

use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::node::{Inputs, Node};
use board_bench::pc::{Pc, keys_in_flash, operator_key, peers_key};
use board_bench::power::{STORE, board};
use board_bench::reviewed;

#[test]
fn nothing_is_written_while_armed() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = board(&firmware, &[]);
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
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
    flash.extend(keys_in_flash(&peers_key(), &operator_key()));

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
