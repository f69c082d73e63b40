//! A stroke around an object that is pushed about: against statics, against the energy that it takes, against geometry.

use cohold_environments::records::{Block, Body, Shape, Strip, Wall};
use cohold_environments::world::stroke::{ARM, Options, Stroke, stroke};

/// A triangle with a corner that points inwards: 51°, 217°, 51°, 41°.
fn dart() -> Block {
    let dart = Block { a_x_m: -0.03, a_y_m: -0.03, b_x_m: 0.0, b_y_m: -0.02, c_x_m: 0.03, ..Block::default() };
    Block { c_y_m: -0.03, d_x_m: 0.0, d_y_m: 0.05, ..dart }
}

/// An object so heavy that it stands, and a hand that has time.
fn slow() -> Options {
    Options { mass_kg: 1e6, speed_m_per_s: 0.005, ..Options::default() }
}

fn done(shape: Shape, options: &Options) -> Stroke {
    stroke(&shape, options).expect("a stroke")
}

#[track_caller]
fn close(got: f64, want: f64, relative: f64, what: &str) {
    assert!((got / want - 1.0).abs() < relative, "{what}: {got} is not {want}");
}

/// Two springs in series: the arm's k gives way by b, so the force is b·K·k/(K + k).
fn static_force(stiffness: f64, below_m: f64) -> f64 {
    below_m * stiffness * ARM.0 / (stiffness + ARM.0)
}

/// On every side the force of two springs in series; around every corner the depth at which both sides are equally near.
#[test]
fn a_slow_stroke_is_statics() {
    let rectangle = Shape::Wall(Wall { to_x_m: 0.06, thickness_m: 0.04, ..Wall::default() });
    for (shape, angles) in [(Shape::Block(dart()), [51.0, 216.9, 51.0, 41.1]), (rectangle, [90.0; 4])] {
        let stroke = done(shape, &slow());
        assert_eq!(stroke.parts.len(), 4);
        for (at, (part, angle)) in stroke.parts.iter().zip(angles).enumerate() {
            close(part.corner_deg.expect("a corner"), angle, 2e-3, &part.side);
            // Behind a corner that points in by 2β the line under the surface is deeper than along the sides, by 1/cos β.
            let deeper =
                |angle: f64| if angle < 180.0 { 1.0 } else { 1.0 / (0.5 * (angle - 180.0)).to_radians().cos() };
            let deepest_m = 0.003 * deeper(angles[(at + 1) % 4]);
            close(part.last_force_n, static_force(1000.0, deepest_m), 5e-3, &part.side);
            let cosine = angle.to_radians().cos();
            let want = if angle < 180.0 { 0.003 / (1.0 - 0.5 * cosine) } else { 0.002 * deeper(angle) };
            close(part.largest_depth_m, want, 5e-3, &part.side);
            assert_eq!(part.leaves_at_m.is_some(), angle < 180.0);
            if let Some(depth_m) = part.leaves_at_m {
                close(depth_m, want, 2e-3, &part.side);
            }
        }
    }
}

/// K·cos 51° ≥ k: the arm is too soft to draw the hand out of the corner, and it stays under the side that it comes from.
#[test]
fn a_sharp_stiff_corner_keeps_a_hand_on_a_soft_arm() {
    let held = done(Shape::Block(Block { stiffness_n_per_m: 4000.0, ..dart() }), &slow());
    assert!(held.parts[0].leaves_at_m.is_none() && held.parts[0].largest_depth_m > 0.006, "{:?}", held.parts[0]);
    let let_go = done(Shape::Block(Block { stiffness_n_per_m: 500.0, ..dart() }), &slow());
    assert!(let_go.parts[0].largest_depth_m < 0.004, "{:?}", let_go.parts[0]);
}

#[test]
fn a_disc_feels_the_same_all_around() {
    let stroke = done(Shape::Body(Body { radius_m: 0.03, damping_n_s_per_m: 0.0, ..Body::default() }), &slow());
    let [rim] = &stroke.parts[..] else { panic!("{:?}", stroke.parts) };
    let force = static_force(1000.0, 0.003);
    close(rim.last_force_n, force, 1e-2, "at the end");
    close(rim.largest_force_n, force, 2e-2, "largest");
}

/// What the person does is what is stored, moves and was taken; what is left open halves with the period.
#[test]
fn the_energy_of_a_push_is_accounted_for() {
    let shape = Shape::Block(dart());
    let open = |period_s: f64| {
        let stroke = done(shape, &Options { period_s, drag_n_s_per_m: 5.0, ..Options::default() });
        let energy = stroke.energy;
        let way_m = ["object_x_m", "object_y_m"]
            .map(|name| stroke.table.column(name).and_then(<[f64]>::last).map_or(0.0, |at| at.abs()));
        let way_m: f64 = way_m.iter().sum();
        assert!(way_m > 0.01 && energy.drag_j > 0.1 * energy.work_j && energy.contact_j > 0.0, "{energy:?}");
        energy.remainder_j() / energy.work_j
    };
    let [coarse, middle, fine] = [1e-3, 0.5e-3, 0.25e-3].map(open);
    assert!(coarse.abs() < 2e-3, "{coarse} of the work");
    for ratio in [coarse / middle, middle / fine] {
        assert!((1.7..2.3).contains(&ratio), "{coarse} {middle} {fine}");
    }
}

#[test]
fn what_cannot_be_stroked_is_said() {
    let strip = stroke(&Shape::Strip(Strip::default()), &Options::default()).expect_err("a strip").to_string();
    assert!(strip.contains("a strip has no outline"), "{strip}");
    let deep = Options { below_m: 0.02, ..Options::default() };
    let deep = stroke(&Shape::Block(dart()), &deep).expect_err("no room").to_string();
    assert!(deep.starts_with("below_m = 0.02 is too much for this object"), "{deep}");
    // Three corners, the last of them twice.
    let triangle = Block { d_x_m: 0.1, ..Block::default() };
    let triangle = done(Shape::Block(triangle), &Options::default());
    let sides: Vec<&str> = triangle.parts.iter().map(|part| part.side.as_str()).collect();
    assert_eq!(sides, ["a-b", "b-c", "c-a"]);
}
