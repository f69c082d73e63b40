//! Every row of `tests/oracle/spectral.csv`: the spectral radius to 1e-8, the verdict, and that no row is skipped.

use cohold_analysis::verdict;
use cohold_sim::scene::Scene;

#[test]
fn every_row_of_the_oracle() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/oracle/spectral.csv");
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).unwrap();
    let header = reader.headers().unwrap().clone();
    let mut rows = 0;
    for record in reader.records() {
        let record = record.unwrap();
        let field = |name: &str| record.get(header.iter().position(|known| known == name).unwrap()).unwrap();
        let keys = header.iter().zip(&record).filter(|(name, _)| name.contains('.'));
        let mut overrides: Vec<String> = keys.map(|(name, value)| format!("{name}={value}")).collect();
        if overrides.iter().any(|set| set == "coordination.comm=self-timed") {
            // The oracle's line stands.
            overrides.push("coordination.carry_damping_n_s_per_m=0".into());
        }
        let ours = verdict(&Scene::load(cohold_guest_laws::laws(), None, &overrides).unwrap()).unwrap();
        let wanted: f64 = field("spectral_radius").parse().unwrap();
        assert!((ours.spectral_radius / wanted - 1.0).abs() < 1e-8, "row {rows}: {} {wanted}", ours.spectral_radius);
        assert_eq!(ours.stable.to_string(), field("stable"), "row {rows}");
        rows += 1;
    }
    assert_eq!(rows, 378);
}
