//! Cells of the campaign: networks in milliseconds, seeds, means with their intervals, and what is not reported.

use cohold_sim::run::Reason;

use super::*;

fn base(overrides: &[&str]) -> Scene {
    let mut scene = scenes::load(cohold_guest_laws::laws(), "hub").expect("a built-in scene");
    overrides.iter().for_each(|text| scene.apply_override(text).expect("a good override"));
    scene.users = scenes::load(cohold_guest_laws::laws(), BASE).expect("a built-in scene").users;
    scene
}

fn cells(scene: &Scene, networks: &[Named]) -> Vec<Cell> {
    over_networks(vec![Entrant { name: "one".to_owned(), scene: scene.clone() }], networks, 0).expect("runs")
}

/// A burst of 40 ms is 5 packets of 8 ms, or 40 of 1 ms; so with every network there is.
#[test]
fn networks_are_the_same_for_every_packet_period() {
    for (ticks, packets) in [("8", [5.0, 3.0, 8.0]), ("1", [40.0, 24.0, 64.0])] {
        let scene = base(&[&format!("timing.ticks_per_packet={ticks}")]);
        let network = |name: &str| {
            let (_, settings) = networks::IMPAIRMENTS.iter().find(|(known, _)| *known == name).expect("a network");
            networks::over(&scene, settings).expect("a good network").world.network
        };
        let got = [
            network("bursts of 40 ms, 50 %").loss_burst_packets,
            f64::from(network("delay 24 ms").one_way_delay_packets),
            f64::from(network("blocks of 64 ms reversed").reverse_block_packets),
        ];
        assert_eq!(got, packets);
        for (name, settings) in networks::IMPAIRMENTS {
            assert!(networks::over(&scene, settings).is_ok(), "{name} with {ticks} ticks a packet");
        }
    }
}

/// One run where nothing is drawn, twenty others where something is; the same bits on one thread and on two.
#[test]
fn seeds_are_others_and_threads_change_nothing() {
    let networks: &[Named] = &[("none", ""), ("loss", "loss=0.3"), ("asymmetry", "asymmetry_s=0.01")];
    let scene = base(&[]);
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
        pool.install(|| cells(&scene, networks))
    };
    let (one, two) = (on(1), on(2));
    let hashes = |cells: &[Cell]| -> Vec<Vec<u64>> {
        cells.iter().map(|cell| cell.outcomes.iter().map(|outcome| outcome.hash).collect()).collect()
    };
    assert_eq!(hashes(&one), hashes(&two));
    assert_eq!(columns(&one), columns(&two));
    let counts = hashes(&one).into_iter().map(|mut hashes| {
        hashes.sort_unstable();
        hashes.dedup();
        hashes.len()
    });
    assert_eq!(counts.collect::<Vec<_>>(), [1, SEEDS as usize, 1]);
}

/// A single run of twenty that failed takes the figures of the cell; one that came apart does not hide how far.
#[test]
fn one_failure_is_not_averaged_away() {
    let mut cell = cells(&base(&[]), &[("loss", "loss=0.1")]).remove(0);
    assert_eq!((cell.verdict().as_str(), cell.is_stable(), cell.reason()), ("stable 20/20", true, None));
    let mean = cell.true_discrepancy_mm().expect("figures");
    cell.outcomes[7].reason = Some(Reason::Apart { true_discrepancy_mm: 500.0 });
    assert_eq!((cell.verdict().as_str(), cell.is_stable()), ("apart 1/20", false));
    assert_eq!(cell.true_discrepancy_mm(), Some(mean));
    cell.outcomes[3].reason = Some(Reason::ForceGrew);
    assert_eq!(cell.verdict(), "NO 1/20");
    assert_eq!(cell.reason(), Some(Reason::ForceGrew.to_string()));
    assert_eq!((cell.true_discrepancy_mm(), cell.worst(|o| o.whole.peak_coordination_force_n)), (None, None));
    assert!(columns(&[cell]).row(0)["true_discrepancy_mm"].is_null());
}

/// On the scene's own network the mobility is 1 by definition; a longer line is heavier, so that the same push moves it less far.
#[test]
fn the_way_is_that_of_the_scenes_own_network() {
    let scene = base(&["coordination.ledger=false", "coordination.drift_correction=false"]);
    let [own, late] =
        [("none", ""), ("late", "one_way_delay_packets=20")].map(|network| cells(&scene, &[network]).remove(0));
    let mobility = own.mobility().expect("a way");
    assert_eq!((mobility.mean, mobility.within_95), (1.0, None));
    // A line of 160 ms and 10 N s/m weighs 1.6 kg more than one of 8 ms.
    assert!(
        late.mobility().is_some_and(|mobility| mobility.mean > 0.3 && mobility.mean < 0.7),
        "{:?}",
        late.mobility()
    );
    assert!(own.push_peak_n().is_some_and(|peak| peak > 0.1 && peak < 1.0), "{:?}", own.push_peak_n());
}

/// The last row is the recommended scene: its peers are configured with the same.
#[test]
fn the_self_timed_row_is_any_network() {
    let laws = cohold_guest_laws::laws();
    let rows = scenes(laws, &COMMS).expect("good scenes");
    let row = &rows.iter().find(|row| row.name == "self-timed").expect("a row").scene;
    let scene = scenes::load(laws, "any-network").expect("a built-in scene");
    assert_eq!(row.peer, scene.peer);
    let delay = |scene: &Scene| scene.world.network.one_way_delay_packets;
    assert_eq!(delay(row), delay(&scene));
}

/// A narrow line carries a packet of nine samples and no packet a tick; four in a packet cost nothing on the scene's own network, and nine N − 8 ticks.
#[test]
fn few_packets_do_where_the_line_has_margin() {
    let network = |name: &str| *networks::IMPAIRMENTS.iter().find(|(known, _)| *known == name).expect("a network");
    let over = |network: Named, together: &[&str]| {
        let pushes = ["user.1.push_n=1", "user.2.push_n=1", "user.2.sine_n=0.25", "user.2.sine_rad_per_s=3"];
        let slack = ["coordination.tautness=0"];
        let set: Vec<String> = pushes.iter().chain(&slack).chain(together).map(|text| (*text).to_owned()).collect();
        let scene = scenes::find(cohold_guest_laws::laws(), Some("any-network".as_ref()), &set).expect("a good scene");
        cells(&scene, &[network]).remove(0)
    };
    let [narrow, own] = ["bandwidth 110 kbit/s", "none"].map(network);
    let (four, nine) = (["event.longest_s=0.05", "event.together_ticks=4"], ["event.longest_s=0.05"]);
    let stable = [&[][..], &four, &nine].map(|together| over(narrow, together).is_stable());
    assert_eq!(stable, [false, false, true], "a packet a tick fits no narrow line");
    let [each, four, nine] =
        [&[][..], &four, &nine].map(|together| over(own, together).true_discrepancy_mm().expect("stable").mean);
    // A tick is T_c·F/b: 1 ms·1 N/60 N·s/m.
    assert!((four - each).abs() < 1e-3 && (nine - each - 1.0 / 60.0).abs() < 1e-3, "{each} {four} {nine}");
}

/// Along axes that nothing couples a scene is judged as along one; a coupled one is judged, too.
#[test]
fn a_scene_of_several_axes_has_its_cells() {
    let network = *networks::IMPAIRMENTS.iter().find(|(known, _)| *known == "delay 24 ms").expect("a network");
    let of = |overrides: &[&str]| cells(&base(overrides), &[network]).remove(0);
    let one = of(&[]);
    let mean = |cell: &Cell| cell.mobility().expect("nobody stops").mean;
    for count in ["2", "3"] {
        let several = of(&[&format!("axis.count={count}"), &format!("axis.shared={count}")]);
        assert_eq!(several.verdict(), one.verdict(), "{count} axes");
        assert!(
            (mean(&several) / mean(&one) - 1.0).abs() < 1e-9,
            "{count} axes: {} for {}",
            mean(&several),
            mean(&one)
        );
        assert!((several.push_peak_n().expect("a peak") / one.push_peak_n().expect("a peak") - 1.0).abs() < 1e-9);
    }
    let plane = scenes::load(cohold_guest_laws::laws(), "plane").expect("a built-in scene");
    let [plane] = &cells(&plane, &[network])[..] else { panic!("one cell") };
    assert!(plane.is_stable() && plane.mobility().is_some(), "{plane:?}");
}
