//! The current loop in the image, against windings: the same bits as host-sim's, every period, and the tick and the loop in time whatever
//! else goes on.

use std::sync::Arc;

use board_bench::bench::{Bench, for_boards};
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use haptic_sim::scene::Scene;
use haptic_sim::scenes;

/// The paper's cube, both devices with windings. Without noise: the converter's steps are in both, and a board measures its sensors' zeros.
fn scene(set: &[&str]) -> Scene {
    let mut scene = scenes::load(haptic_sim::Laws::built_in(), "paper-5.2-passive-wave-16ms").expect("built in");
    for set in [
        "plant.encoder=true",
        "plant.motor=true",
        "plant.winding=true",
        "plant.drive=current",
        "plant.current_noise_a=0",
    ]
    .iter()
    .chain(set)
    {
        scene.apply_override(set).expect("a good override");
    }
    for_boards(&scene)
}

#[test]
fn two_boards_with_windings_equal_host_sim() {
    let seconds = 2;
    let (firmware, scene) = (Arc::new(Firmware::release()), scene(&[]));
    let wall = std::time::Instant::now();
    let mut bench = Bench::start(&firmware, 2, Line::default());
    bench.set_up(&scene).expect("the boards take the scene");
    bench.arm();
    bench.run_for_ms(1000 * seconds);
    println!("{seconds} s of two boards with windings in {:.1} s", wall.elapsed().as_secs_f64());
    let boards = [bench.armed_ticks(1), bench.armed_ticks(2)];
    let ticks = boards[0].len().min(boards[1].len()) as u64;
    assert!(ticks >= 1000 * seconds, "only {ticks} ticks were recorded");
    let duties = boards[0].iter().map(|record| record.duties()[0].0.unsigned_abs()).max();
    println!("{ticks} ticks, largest duty {duties:?}");
    assert_eq!(twin::closed_loop(&scene, boards), Equal { ticks, first_difference: None });
    bench.finish().iter().for_each(reviewed::check);
}
