//! One board alone: it starts, its outputs are off, it answers, it arms and it stops.

use std::sync::Arc;

use board_bench::image::Firmware;
use board_bench::pair::Bench;
use board_bench::wire::Line;

#[test]
fn it_starts_disarmed_and_answers() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    assert!(!bench.stopped[0].bridges.on());
    let answer = bench.ask(1, "status");
    println!("{answer}");
    assert!(answer.starts_with("ok board 1 disarmed fault 0 "), "{answer}");
    println!("{}", bench.ask(1, "arm"));
    bench.run_for_ms(10);
    assert!(bench.stopped[0].bridges.on());
    println!("{}", bench.ask(1, "disarm"));
    bench.run_for_ms(2);
    assert!(!bench.stopped[0].bridges.on());
    for report in bench.finish() {
        println!("{report:#?}");
    }
}
