//! Number types along several shared axes: where nothing couples them, each strays as it does alone, and the worst is named.

use cohold_sim::run::AXIS_NAMES;
use cohold_sim::{scene::Scene, scenes};
use cohold_studies::precision::{Precision, Verdict, measure};

const SECONDS: f64 = 3.0;

fn scene(keys: &[&str]) -> Scene {
    let keys: Vec<String> = keys.iter().map(|key| key.to_string()).collect();
    Scene::load(cohold_guest_laws::laws(), None, &keys).expect("a good scene")
}

fn of(scene: &Scene) -> Precision {
    let mut rows = measure("scene", scene, SECONDS).expect("a good scene");
    assert_eq!(rows.len(), 1);
    rows.remove(0)
}

/// The one axis of which the shares of both users' forces are these.
fn alone(of_several: &Scene, axis: usize) -> Precision {
    let mut scene = of_several.clone();
    (scene.peer.axis.count, scene.peer.axis.shared) = (1, 1);
    for user in &mut scene.users {
        let share = user.direction()[axis];
        let profile = &mut user.settings.user;
        (profile.push_n, profile.sine_n) = (profile.push_n * share, profile.sine_n * share);
        (profile.direction_rad, profile.elevation_rad) = (0.0, 0.0);
    }
    of(&scene)
}

/// Error before chaos before rounding, then rounding steps, of the number type that strays worse.
fn badness(row: &Precision) -> (u32, f64) {
    let of = |verdict| [Verdict::Rounding, Verdict::Chaos, Verdict::Error].iter().position(|one| *one == verdict);
    let ranks = [&row.f32, &row.i32f32].map(|one| {
        let steps = one.from_f64.position_m / one.position_step_m;
        (of(one.verdict).expect("a verdict") as u32, if steps.is_finite() { steps } else { 0.0 })
    });
    if ranks[1] > ranks[0] { ranks[1] } else { ranks[0] }
}

#[test]
fn the_worst_of_axes_that_nothing_couples_has_the_figures_that_it_has_alone() {
    let mut named = Vec::new();
    for (axes, angles) in [(2, [0.7, 0.0, -1.9]), (2, [1.5, 0.0, -1.4]), (3, [0.3, 0.9, -0.2]), (3, [0.2, 0.2, 1.1])] {
        for law in ["power", "passive-wave"] {
            let set = [
                format!("axis.count={axes}"),
                format!("axis.shared={axes}"),
                format!("coordination.comm={law}"),
                format!("user.1.direction_rad={}", angles[0]),
                format!("user.1.elevation_rad={}", angles[1]),
                format!("user.2.direction_rad={}", angles[2]),
            ];
            let own = ["coordination.stiffness_n_per_m=300", "user.1.push_n=1", "user.2.sine_n=0.5"];
            let keys: Vec<&str> = own.into_iter().chain(set.iter().map(String::as_str)).collect();
            let scene = scene(&keys);
            let each: Vec<Precision> = (0..axes).map(|axis| alone(&scene, axis)).collect();
            let worst =
                (1..axes).fold(0, |worst, at| if badness(&each[at]) > badness(&each[worst]) { at } else { worst });
            let found = of(&scene);
            assert_eq!(found.axis, Some(AXIS_NAMES[worst]), "{law}: {each:#?}");
            let found = Precision { axis: None, ..found };
            assert_eq!(format!("{found:?}"), format!("{:?}", each[worst]), "{law}, {axes} axes");
            named.push(worst);
        }
    }
    assert!(named.contains(&0) && named.iter().any(|axis| *axis > 0), "{named:?}");
}

/// Axes that are pushed alike are as bad as each other, and as one alone is; the first one is named.
#[test]
fn axes_that_are_pushed_alike_stray_as_one_does() {
    let pushed = ["user.1.push_n=1", "user.1.side_push_n=1", "user.2.push_n=0.5", "user.2.side_push_n=-0.5"];
    let one = of(&scene(&pushed));
    assert!(one.axis.is_none() && one.f32.from_f64.position_m > 0.0);
    for axes in [2, 3] {
        let count = [format!("axis.count={axes}"), format!("axis.shared={axes}")];
        let keys: Vec<&str> = pushed.into_iter().chain(count.iter().map(String::as_str)).collect();
        let several = of(&scene(&keys));
        assert_eq!(several.axis, Some("x"));
        assert_eq!(format!("{:?}", Precision { axis: None, ..several }), format!("{one:?}"));
    }
}

#[test]
fn axes_that_joints_couple_have_a_worst_one() {
    for name in ["plane", "space"] {
        let mut scene = scenes::load(cohold_guest_laws::laws(), name).expect("built in");
        // Read and driven exactly: counts of an encoder hide what is rounded.
        for key in ["plant.encoder=false", "plant.motor=false", "plant.winding=false", "axis.velocity=measured"] {
            scene.apply_override(key).expect("a good key");
        }
        let row = of(&scene);
        assert!(row.axis.is_some() && row.faulted_after_s.is_none(), "{row:?}");
        assert!(row.f32.from_f64.position_m > 0.0 && row.f32.from_f64.position_m < 1e-4, "{row:?}");
        assert!(row.shadow.position_m > 0.0 && row.largest_position_m > 1e-3, "{row:?}");
    }
}
