//! The simulator against the independent model in `tests/oracle` (Python, written from the equations alone).

use cohold_sim::run::{Options, run};
use cohold_sim::scene::Scene;

const TABLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/oracle/simulations.csv");

/// Every scene of the table: seeded random masses, gains, delays of force 0…1 tick, laws, decodes, integrators.
#[test]
fn random_scenes_give_the_oracles_answers() {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(TABLE).expect("the oracle's table");
    let header = reader.headers().expect("a header").clone();
    let mut scenes = 0;
    for record in reader.records() {
        let record = record.expect("a row");
        let mut scene = Scene::default();
        let mut expected = std::collections::HashMap::new();
        for (key, value) in header.iter().zip(&record) {
            if key.contains('.') {
                scene.apply_override(&format!("{key}={value}")).unwrap_or_else(|error| panic!("{error}"));
            } else {
                expected.insert(key, value.parse::<f64>().expect("a number"));
            }
        }
        if scene.law().name == "self-timed" {
            // The oracle's line stands.
            scene.apply_override("coordination.carry_damping_n_s_per_m=0").expect("it is allowed");
        }
        let outcome = run::<f64>(&scene, Options { duration_s: 20.0, record_every: 0 }, &|_| {}).expect("a good scene");
        let close = |name: &str, got: f64| {
            let want = expected[name];
            // 1 % is asked for; the two agree to rounding.
            assert!((got - want).abs() <= 1e-6 * want.abs() + 1e-9, "scene {scenes}: {name} is {got}, oracle {want}");
        };
        close("decoded_mm", outcome.whole.decoded_discrepancy_mm);
        close("true_mm", outcome.whole.true_discrepancy_mm);
        close("force_mean_n", outcome.whole.coordination_force_n.mean);
        close("force_sd_n", outcome.whole.coordination_force_n.sd);
        assert!(outcome.bounded, "scene {scenes} is stable, so says the oracle");
        scenes += 1;
    }
    assert!(scenes >= 84, "only {scenes} scenes in the table");
}
