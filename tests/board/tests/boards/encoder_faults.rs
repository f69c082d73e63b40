//! Encoders that fail while the device moves, at the force limits of a board with its default settings: their edges and index tell, and what
//! motors in current loops show of their speed. The rows become the table in docs/reference/faults.md; `COHOLD_BLESS=1` writes it, otherwise it must be there.

use std::sync::Arc;

use board_bench::bench::{CURRENT_LOOP, for_boards};
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::wire::Line;
use cohold_sim::Laws;
use cohold_sim::scene::{PlantFault, Scene};

use crate::breaks;

/// A device whose user pushes it with 3 N at 3 Hz, with motors in current loops and the limits of a board with its default settings.
const DEVICE: [&str; 5] = [
    "axis.velocity=adaptive",
    "user.1.sine_n=3",
    "user.1.sine_rad_per_s=19",
    "safety.max_force_n=3",
    "safety.max_slew_n_per_s=60",
];

/// Faster than this a failing encoder is to be noticed, m/s.
const SPEED: f64 = 0.15;

/// An index that the device passes again and again.
const INDEX: [&str; 3] = ["encoder.index=true", "encoder.index_at_m_or_rad=0.002", "user.1.arm_stiffness_n_per_m=100"];

/// What failed, how, within how many ms the outputs go off, and by which fault.
const FAULTS: [(&str, PlantFault, u64, u8); 7] = [
    ("stuck", PlantFault::EncoderStuck, 20, 21),
    ("wire of channel A cut", PlantFault::EncoderWithoutA, 20, 22),
    ("wire of channel B cut", PlantFault::EncoderWithoutB, 20, 22),
    ("goes to and fro by one count", PlantFault::EncoderDithers, 20, 22),
    ("counts the wrong way", PlantFault::EncoderReversed, 20, 21),
    // Half of what it is at its fastest is just beyond what is tolerated.
    ("counts half", PlantFault::EncoderHalved, 400, 21),
    ("lost 40 counts (`encoder.index`)", PlantFault::EncoderLoses, 400, 20),
];

#[test]
fn encoders_that_fail_are_told() {
    let firmware = Arc::new(Firmware::release());
    let mut rows = Vec::new();
    for (what, fault, within_ms, number) in FAULTS {
        let index = &INDEX[if fault == PlantFault::EncoderLoses { 0 } else { INDEX.len() }..];
        let keys: Vec<String> = [&CURRENT_LOOP[..], &DEVICE, index].concat().into_iter().map(str::to_owned).collect();
        let scene = for_boards(&Scene::load(Laws::built_in(), None, &keys).expect("a good scene"));
        let mut bench = breaks::just_armed(&firmware, 1, Line::default(), &scene);
        let waited = (0..500).find(|_| {
            bench.step();
            bench.ticks > 200 && bench.speed(1).abs() > SPEED
        });
        assert!(waited.is_some() && bench.stopped[0].bridges.on(), "{what}: it moves, with the motors on");
        bench.fail(1, fault);
        let off = (1..=within_ms).find(|_| {
            bench.step();
            !bench.stopped[0].bridges.on()
        });
        bench.run_for_ms(2);
        let status = bench.ask(1, "status");
        println!("{what}: {off:?}, {status}");
        let Some(ms) = off.filter(|_| status.contains(&format!(" faulted fault {number} "))) else {
            panic!("{what}: {off:?}, {status}")
        };
        rows.push(format!("| {what} | {ms} ms | fault {number} |"));
        bench.finish();
    }
    docs::table(
        "reference/faults.md",
        "encoder_faults",
        "| encoder of a device that moves at 0.15 m/s or more | outputs off after | status says |",
        &rows,
    );
}
