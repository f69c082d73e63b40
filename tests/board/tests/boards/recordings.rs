//! Recordings of two boards by their operators, merged: the simulator's true discrepancy, to the bit.

use std::path::PathBuf;
use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::wire::Line;
use cohold_live::recording::file::read;
use cohold_live::recording::merge::merge;
use cohold_sim::pair::Pair;

use crate::breaks;

#[test]
fn two_recorded_boards_merge_to_the_simulators_true_discrepancy() {
    let scene = breaks::scene(&[]);
    let files = [1, 2].map(|number| -> PathBuf {
        let file = std::env::temp_dir().join(format!("board-{number}-{}.mcap", std::process::id()));
        let _ = std::fs::remove_file(&file);
        file
    });
    let mut bench = Bench::start(&Arc::new(Firmware::release()), 2, Line::default());
    // Until the PC knows their clocks.
    bench.run_for_ms(1000);
    bench.set_up(&scene).expect("the boards take the scene");
    (1..).zip(&files).for_each(|(number, file)| bench.pc.record(number, 1, file));
    bench.arm();
    bench.run_for_ms(4000);
    bench.pc.end_recordings();
    let [one, two] = files.each_ref().map(|file| read(file).expect("a recording"));
    files.iter().for_each(|file| std::fs::remove_file(file).expect("it is there"));
    let merged = merge(&one, &two, None).expect("one PC recorded both");
    println!(
        "{} instants, clocks ±{:.0} µs, {:.4} mm",
        merged.instants, merged.clock_error_us, merged.true_discrepancy_mm
    );

    // From the tick at which the devices begin to move, both copies are cohold's.
    let column = |name: &str| merged.table.column(name).expect("it is named");
    let (places, apart) = (column("object_1_m"), column("true_discrepancy_m"));
    let mut pair = Pair::<f32>::new(&scene).expect("the boards took it");
    let moving = bench.armed_ticks(1);
    let standing = bench.since_armed(1).standing;
    // Both boards were armed in the same millisecond or some later: what is before that is not merged.
    let all: Vec<f64> =
        bench.since_armed(1).records.iter().map(|record| record.observed().object.position.into()).collect();
    let skipped = (0..=standing)
        .find(|skipped| places.iter().zip(&all[*skipped..]).all(|(merged, told)| merged.to_bits() == told.to_bits()))
        .expect("the first board's copy as it told it");
    let mut compared = 0;
    for at in 0..moving.len() {
        pair.step();
        let [first, second] = pair.sides().map(|side| f64::from(side.peer.observed()[0].object.position));
        let Some(merged) = apart.get(standing + at - skipped) else { break };
        assert_eq!(merged.to_bits(), (first - second).abs().to_bits(), "tick {at}");
        compared += 1;
    }
    assert!(compared > 3_900 && merged.largest_true_discrepancy_mm > 0.1, "{compared} ticks, {merged:?}");
}
