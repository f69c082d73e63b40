//! The sampled map against a simulation that puts every delay where it is, against closed forms, against the paper.

use cohold_core::names::Choice;

use super::closed::{largest_stiffness, longest_object_delay_s};
use super::identify::{self, DELAY_S, PERIOD_S, identify, needs, wall};
use super::maps::{Sweep, at, first, stiffness_limit};
use super::{Body, Place, Renderer, Rendering};

/// Position and velocity of a damped mass after `time` under a constant force, in closed form.
fn coast(body: Body, (x, v): (f64, f64), force: f64, time: f64) -> (f64, f64) {
    let Body { mass_kg: m, damping_n_s_per_m: b } = body;
    if b == 0.0 {
        return (x + v * time + 0.5 * force / m * time * time, v + force / m * time);
    }
    let (end, gone) = (force / b, -(-b * time / m).exp_m1());
    (x + end * time + (v - end) * m / b * gone, v + (end - v) * gone)
}

/// A body in continuous time under forces that were switched at known instants.
struct Track {
    body: Body,
    /// From when, in which state, under which force.
    pieces: Vec<(f64, (f64, f64), f64)>,
}

impl Track {
    fn state(&self, time: f64) -> (f64, f64) {
        let (from, state, force) = self.pieces.iter().rev().find(|piece| piece.0 <= time).unwrap_or(&self.pieces[0]);
        coast(self.body, *state, *force, time - from)
    }

    fn switch(&mut self, time: f64, force: f64) {
        let state = self.state(time);
        self.pieces.push((time, state, force));
    }
}

/// How the relative velocity at the CDE grows from the third to the last quarter of `ticks` periods.
fn growth(rendering: &Rendering, stiffness: f64, ticks: usize) -> f64 {
    let [to_engine, to_device, to_dynamics, from_dynamics] = rendering.delays_s;
    let period = rendering.period_s;
    let mut device = Track { body: rendering.device, pieces: vec![(-1.0, (1e-3, 0.0), 0.0)] };
    let mut object = rendering.object.map(|body| Track { body, pieces: vec![(-1.0, (0.0, 0.0), 0.0)] });
    let mut quarters = [0.0_f64; 4];
    for tick in 0..ticks {
        let now = tick as f64 * period;
        let seen = device.state(now - to_engine);
        let against = object.as_ref().map_or((0.0, 0.0), |object| object.state(now - from_dynamics));
        let (depth, speed) = (seen.0 - against.0, seen.1 - against.1);
        let force = stiffness * depth + rendering.contact_damping_n_s_per_m * speed;
        let out = now + rendering.computing_ticks * period;
        device.switch(out + to_device, -force);
        if let Some(object) = &mut object {
            object.switch(out + to_dynamics, force);
        }
        let quarter = &mut quarters[4 * tick / ticks];
        *quarter = quarter.max(speed.abs());
    }
    quarters[3] / quarters[2]
}

const DEVICE: Body = Body { mass_kg: 0.1, damping_n_s_per_m: 5.0 };

fn scene(object: Option<Body>, contact_damping_n_s_per_m: f64, computing_ticks: f64, delays_s: [f64; 4]) -> Rendering {
    Rendering { device: DEVICE, object, contact_damping_n_s_per_m, period_s: 1e-3, computing_ticks, delays_s }
}

/// Every delay by itself and all together, none a whole number of periods, with and without damping: 3 % below the limit
/// the simulation settles, 3 % above it grows.
#[test]
fn a_simulation_with_every_delay_in_its_place_agrees() {
    let heavy = Some(Body { mass_kg: 1.0, damping_n_s_per_m: 0.0 });
    let light = Some(Body { mass_kg: 0.2, damping_n_s_per_m: 1.5 });
    let delayed = |place: &Place| scene(heavy, 1.0, 0.5, [0.0; 4]).delayed(*place, 3.37e-3);
    let mut scenes: Vec<Rendering> = Place::ALL.iter().map(delayed).collect();
    scenes.push(scene(light, 0.5, 0.31, [1.21e-3, 0.4e-3, 2.63e-3, 5.5e-3]));
    scenes.push(scene(light, 0.0, 0.0, [0.0, 0.0, 0.0, 0.77e-3]));
    scenes.push(scene(None, 0.0, 0.0, [0.0; 4]));
    scenes.push(scene(None, 2.0, 0.9, [2.0e-3, 3.99e-3, 0.0, 0.0]));
    for rendering in scenes {
        let limit = stiffness_limit(&rendering).unwrap();
        let edge = first(&limit).unwrap();
        assert!(limit.stable_at_start && edge > 10.0, "{limit:?}");
        for (factor, grows) in [(0.97, false), (1.03, true)] {
            let growth = growth(&rendering, factor * edge, 4000);
            assert_eq!(growth > 1.0, grows, "{growth} at {factor} of {edge}: {rendering:?}");
        }
    }
}

/// Where between two engines a delay sits makes no difference, whole periods or not.
#[test]
fn only_the_sum_around_each_loop_counts() {
    let object = Some(Body { mass_kg: 0.4, damping_n_s_per_m: 0.3 });
    let mut renderer = Renderer::default();
    let mut radius = |delays: [f64; 4]| renderer.radius(&scene(object, 1.0, 0.5, delays), 700.0).unwrap();
    let all = radius([4.4e-3, 0.0, 0.0, 2.2e-3]);
    for delays in [[0.0, 4.4e-3, 2.2e-3, 0.0], [1.7e-3, 2.7e-3, 0.9e-3, 1.3e-3]] {
        assert!((radius(delays) - all).abs() < 1e-12);
    }
}

/// b/delay and 2b/period (THEORY §6): within 4 % for masses of 4·b·θ and more.
#[test]
fn walls_follow_the_closed_forms() {
    for mass_kg in [0.1, 0.3, 1.0, 10.0] {
        for (delay_s, damping) in [(5e-3, 5.0), (20e-3, 1.0), (1e-3, 10.0)] {
            let delayed = at(&wall(mass_kg, damping, 0.0), Sweep::Delay(Place::CollisionToDevice), delay_s, None);
            let largest = first(&stiffness_limit(&delayed).unwrap()).unwrap();
            assert!((largest / (damping / delay_s) - 1.0).abs() < 0.04, "{largest}: {delayed:?}");
            let sampled = Rendering { period_s: delay_s, ..wall(mass_kg, damping, 0.0) };
            let largest = first(&stiffness_limit(&sampled).unwrap()).unwrap();
            assert!((largest / (2.0 * damping / delay_s) - 1.0).abs() < 0.05, "{largest}: {sampled:?}");
        }
    }
}

/// A device without mass: π/2·b/delay.
#[test]
fn a_massless_device_comes_to_half_pi() {
    let light = at(&wall(1e-5, 5.0, 0.0), Sweep::Delay(Place::DeviceToCollision), 5e-3, None);
    let largest = first(&stiffness_limit(&light).unwrap()).unwrap();
    assert!((largest / (core::f64::consts::FRAC_PI_2 * 1000.0) - 1.0).abs() < 0.02, "{largest}");
}

/// All four places against the closed form with its shares of the motion. What it leaves out is of second order, sin(θω)/θω
/// for 1: within 2 % and a quarter of (θω)².
#[test]
fn movable_objects_follow_the_closed_form() {
    let mut orders = Vec::new();
    for (mass_kg, object_damping) in [(0.2, 0.0), (1.0, 0.0), (1.0, 5.0), (5.0, 1.0)] {
        let object = Body { mass_kg, damping_n_s_per_m: object_damping };
        for (place, delay_s) in Place::ALL.iter().flat_map(|place| [(*place, 2e-4), (*place, 2e-3)]) {
            let rendering = at(&scene(Some(object), 1.0, 0.5, [0.0; 4]), Sweep::Delay(place), delay_s, None);
            let largest = first(&stiffness_limit(&rendering).unwrap()).unwrap();
            let swings = (largest * (1.0 / DEVICE.mass_kg + 1.0 / mass_kg)).sqrt();
            let order = (delay_s * swings).powi(2);
            let error = largest / largest_stiffness(&rendering) - 1.0;
            assert!(error.abs() < 0.02 + order / 4.0, "{error} at {order}: {rendering:?}");
            orders.push(order);
        }
    }
    assert!(orders.iter().filter(|order| **order < 0.2).count() >= 16, "{orders:?}");
}

/// Beyond m_o/b of delay to or from the dynamics engine even the softest contact with an undamped object is unstable.
#[test]
fn an_undamped_object_bears_only_so_much_delay() {
    let object = Body { mass_kg: 0.3, damping_n_s_per_m: 0.0 };
    let longest_s = longest_object_delay_s(DEVICE, object);
    for (factor, stable) in [(0.9, true), (1.1, false)] {
        let wanted = Sweep::Delay(Place::DynamicsToCollision);
        let rendering = at(&scene(Some(object), 0.0, 0.5, [0.0; 4]), wanted, factor * longest_s, None);
        let soft = Renderer::default().radius(&rendering, 0.05).unwrap();
        assert_eq!(soft < 1.0, stable, "{soft} at {factor}");
    }
}

/// The paper's two statements hold at once for about 5 N·s/m and half a period of computing, almost whatever the mass.
#[test]
fn the_papers_device() {
    for mass_kg in [0.05, 0.1, 0.3, 1.0] {
        let found = identify(mass_kg).unwrap();
        assert!((found.damping_n_s_per_m / 5.0 - 1.0).abs() < 0.06, "{found:?}");
        assert!((found.computing_ticks - 0.5).abs() < 0.06, "{found:?}");
        for largest in [found.at_200_hz_n_per_m, found.at_5_ms_n_per_m] {
            assert!((largest / identify::STIFFNESS_N_PER_M - 1.0).abs() < 3e-3, "{found:?}");
        }
        let needs = needs(&wall(mass_kg, found.damping_n_s_per_m, found.computing_ticks)).unwrap();
        assert!((needs.sampling_hz.unwrap() * PERIOD_S - 1.0).abs() < 5e-3, "{needs:?}");
        assert!((needs.delay_s.unwrap() / DELAY_S - 1.0).abs() < 5e-3, "{needs:?}");
    }
}

#[test]
fn what_cannot_be_is_named() {
    let says = |rendering: Rendering| stiffness_limit(&rendering).unwrap_err().to_string();
    let good = scene(None, 0.0, 0.5, [0.0; 4]);
    let device = |mass_kg, damping_n_s_per_m| Body { mass_kg, damping_n_s_per_m };
    assert!(says(Rendering { device: device(-1.0, 5.0), ..good }).starts_with("device_mass_kg = -1 is not allowed"));
    assert!(says(Rendering { device: device(f64::NAN, 5.0), ..good }).contains("NaN"));
    assert!(says(good.delayed(Place::CollisionToDevice, 1.0)).contains("from 0 to 0.2 s"));
    assert!(says(Rendering { device: device(1.0, 0.0), ..good }).contains("damping"));
}
