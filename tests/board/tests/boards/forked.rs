//! Boards are booted once and forked: one that was forked answers, order by order and byte by byte, what one that is emulated from power-on on
//! does, through a stop and a reset by its watchdog.
//!
//! Of each other image a board is `alone` in [`one_board`](crate::one_board) (three axes), [`second_board`](crate::second_board),
//! [`moteus`](crate::moteus), [`spi_encoders`](crate::spi_encoders) and [`usb`](crate::usb).

use std::sync::Arc;

use board_bench::bench::{Bench, CURRENT_LOOP};
use board_bench::image::Firmware;
use board_bench::node::{Inputs, Node};

use crate::breaks;

/// A board that is armed, stopped, and reset by its watchdog.
fn life(firmware: Firmware) -> Bench {
    const FOR_EVER: u32 = 0xE7FE_E7FE;
    let firmware = Arc::new(firmware);
    let mut bench = breaks::armed(&firmware, &breaks::scene(&CURRENT_LOOP));
    bench.press_stop(1, true);
    bench.run_for_ms(5);
    bench.input(1).poke.push((firmware.address("UART4"), FOR_EVER));
    bench.run_for_ms(100);
    assert_eq!(bench.stopped[0].resets, 1);
    bench
}

#[test]
fn a_forked_board_answers_what_one_alone_does() {
    drop(breaks::armed(&Arc::new(Firmware::release()), &breaks::scene(&CURRENT_LOOP)));
    let lives = [Firmware::release(), Firmware::release().alone()].map(life);
    let [(forked, others), (alone, none)] = lives.each_ref().map(|bench| bench.nodes[0].told());
    println!("{} orders, of which {others} were another's", forked.len());
    assert!(others > 150 && others < forked.len() && none == 0);
    assert_eq!(forked.len(), alone.len());
    assert_eq!(forked.iter().zip(&alone).rposition(|(forked, alone)| forked != alone), None);
    let [forked, alone] = lives.map(|bench| bench.finish().remove(0));
    assert_eq!((forked.resets.len(), forked), (1, alone));
}

/// Where no memory is.
#[test]
#[should_panic(expected = "memory is there")]
fn what_fails_in_a_boards_process_fails_the_test_and_is_told() {
    let node = Node::new(Arc::new(Firmware::release()), 1);
    node.run(1_000_000, Inputs { poke: vec![(0x3F00_0000, 0)], ..Inputs::default() });
    node.wait();
}
