//! Three shared axes: two boards with the image for three motors, each behind a serial arm, compute what cohold computes.

use std::path::PathBuf;
use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::cost::MedianAndMost;
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::trial;
use board_bench::twin::{self, Equal};
use cohold_live::recording::file::read;
use cohold_sim::scene::Scene;
use firmware_parts::record::ENGAGED;

use crate::breaks;

/// The paper's passive wave on every axis of a serial arm, whose users push against each other in a direction of space.
pub(crate) fn scene() -> Scene {
    breaks::scene(&[
        "axis.count=3",
        "axis.shared=3",
        "kinematics.model=arm",
        "user.1.direction_rad=0.6",
        "user.1.elevation_rad=0.4",
        "user.2.direction_rad=0.6",
        "user.2.elevation_rad=0.4",
    ])
}

/// Runs it for so many seconds; gives the bits that are equal and the instructions of a tick, an exchange and three records in it.
pub(crate) fn run(seconds: u64) -> (Equal, MedianAndMost) {
    let (firmware, scene) = (Arc::new(Firmware::with("three-axes")), scene());
    let line = trial::line(&scene).expect("a wire can do it");
    let mut bench = breaks::just_armed(&firmware, 2, line, &scene);
    bench.count_instructions();
    bench.run_for_ms(1000 * seconds);
    let instructions = MedianAndMost::of(bench.meters.iter().flat_map(|meter| meter.ticks.iter().copied()));
    bench.drain();
    let boards = bench.both_since_armed(1000 * seconds);
    for board in boards {
        let last = board.records.last().expect("there are some");
        assert_ne!(last.flags() & ENGAGED, 0, "{:?}: the peers are engaged to the end", last.mode());
    }
    // All three axes move, and are coupled.
    for axis in [1, 2] {
        let way = |record: &&firmware_parts::record::Record| record.axis() == axis;
        let most = bench.further(1).iter().filter(way).map(|record| record.observed().coordination_force.abs());
        assert!(most.fold(0.0, f32::max) > 0.05, "axis {axis} is at rest");
    }
    let equal = twin::closed_loop_shared(&scene, boards, [bench.further(1), bench.further(2)]);
    bench.finish().iter().for_each(reviewed::check);
    (equal, instructions)
}

#[test]
fn two_boards_equal_cohold_along_three_axes() {
    let (equal, instructions) = run(5);
    println!("{equal:?}, {instructions:?}");
    assert_eq!(equal.first_difference, None);
    assert!(instructions.max <= 3000, "{instructions:?}");
}

/// What an operator records of such a board is, axis by axis, what the board reported.
#[test]
fn an_operator_records_every_shared_axis() {
    let file: PathBuf = std::env::temp_dir().join(format!("three-axes-{}.mcap", std::process::id()));
    let _ = std::fs::remove_file(&file);
    let scene = scene();
    let line = trial::line(&scene).expect("a wire can do it");
    let mut bench = Bench::start(&Arc::new(Firmware::with("three-axes")), 2, line);
    bench.set_up(&scene).expect("the boards take the scene");
    bench.pc.record(1, 3, &file);
    bench.arm();
    bench.run_for_ms(1000);
    bench.pc.end_recordings();
    let recording = read(&file).expect("a recording");
    std::fs::remove_file(&file).expect("it is there");
    for (axis, leaf) in [(0, "ticks"), (1, "ticks-y"), (2, "ticks-z")] {
        let topic = format!("/board_1/{leaf}");
        let rows = recording.channels.iter().find(|rows| rows.topic == topic).expect("a channel");
        let told: Vec<_> = match axis {
            0 => bench.since_armed(1).records.iter().collect(),
            _ => bench.further(1).iter().filter(|record| record.axis() == axis).collect(),
        };
        let column = |name: &str| rows.column(name).expect("a column");
        let (ticks, forces) = (column("tick"), column("coordination_n"));
        let mut compared = 0;
        for (tick, force) in ticks.iter().zip(forces) {
            let Some(record) = told.iter().find(|record| f64::from(record.tick()) == *tick) else { continue };
            assert_eq!(
                force.to_bits(),
                f64::from(record.observed().coordination_force).to_bits(),
                "{topic}, tick {tick}"
            );
            compared += 1;
        }
        assert!(compared > 900 && forces.iter().any(|force| force.abs() > 0.01), "{topic}: {compared} ticks");
    }
    bench.finish().iter().for_each(reviewed::check);
}
