//! Walls with friction in the plane and in space, against closed forms.

use cohold_core::names::{Decode, FixtureName, IntegratorName};
use cohold_core::num::Motion;
use cohold_core::object::fixture::{Fixture, Pushes, solve_both};
use cohold_core::object::plane::{Gains, Oblique, Plane};
use cohold_core::object::port::Port;
use cohold_core::object::vector::{Body, Moving, VectorPort};
use cohold_core::settings::Settings;

const PERIOD_S: f64 = 1e-3;

fn moving<const N: usize>(position: [f64; N], velocity: [f64; N]) -> Moving<f64, N> {
    Moving::at(std::array::from_fn(|at| Motion { position: position[at], velocity: velocity[at] }))
}

fn pushed<const N: usize>(force: [f64; N]) -> VectorPort<f64, N> {
    VectorPort { force, ..VectorPort::default() }
}

/// Numbers in [-1, 1) from a linear congruential generator.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(self.0) / f64::from(1_u32 << 31) - 1.0
    }

    /// Between these two, evenly in the logarithm.
    fn between(&mut self, least: f64, most: f64) -> f64 {
        least * (most / least).powf(0.5 + 0.5 * self.next())
    }
}

/// A block of 0.3 kg pressed onto a wall with 3 N slides at 0.5 m/s: it loses μ·N/m·T_c a tick, and stops after v²·m/(2·μ·N).
#[test]
fn a_sliding_block_decelerates_by_the_friction_and_stays_where_it_stops() {
    let (mass, load, friction, stiffness, began) = (0.3, 3.0, 0.4, 2000.0, 0.5);
    let gains = Gains { stiffness_n_per_m: stiffness, friction, ..Gains::default() };
    let wall = Plane::<f64, 2>::new([0.0, -1.0], 0.0, &gains, PERIOD_S);
    let body = Body::new(mass, 0.0, PERIOD_S);
    // As deep as the load presses it.
    let mut block = moving([0.0, -load / stiffness], [began, 0.0]);
    let decelerates = friction * load / mass;
    let ticks = (began / (decelerates * PERIOD_S)).floor() as u32;
    let step = |block: &mut Moving<f64, 2>, side: f64| {
        let met = wall.meet(&body, block, &pushed([side, -load]));
        body.advance(block, met.mean_velocity);
        met
    };
    for tick in 1..=ticks {
        let met = step(&mut block, 0.0);
        let wanted = began - decelerates * PERIOD_S * f64::from(tick);
        assert!((block.axes[0].velocity - wanted).abs() < 1e-12, "{tick}: {}", block.axes[0].velocity);
        assert!((met.along[0] + friction * load).abs() < 1e-9 && (met.push - load).abs() < 1e-9, "{tick}: {met:?}");
    }
    step(&mut block, 0.0);
    let stopped = block.axes[0].position;
    assert!((stopped - began * began / (2.0 * decelerates)).abs() < began * PERIOD_S, "{stopped}");
    // Pushed by less than μ·N it stays; by more it goes with what is left.
    for side in [0.0, 0.5 * friction * load, -0.99 * friction * load] {
        for _ in 0..1000 {
            step(&mut block, side);
            assert!((block.axes[0].position - stopped).abs() < 1e-12 && block.axes[0].velocity.abs() < 1e-12);
        }
    }
    let excess = 0.5;
    for _ in 0..1000 {
        step(&mut block, friction * load + excess);
    }
    assert!((block.axes[0].velocity - excess / mass).abs() < 1e-9, "{:?}", block.axes[0]);
}

/// Drag alone: v falls by (1 − a)/(1 + a) a tick, a = ½·B_f·T_c/m.
#[test]
fn drag_slows_by_the_closed_form() {
    let (mass, load, drag) = (0.3, 3.0, 2.0);
    let gains = Gains { stiffness_n_per_m: 2000.0, drag_n_s_per_m: drag, ..Gains::default() };
    let wall = Plane::<f64, 2>::new([0.0, -1.0], 0.0, &gains, PERIOD_S);
    let (body, mut block) = (Body::new(mass, 0.0, PERIOD_S), moving([0.0, -load / 2000.0], [0.5, 0.0]));
    let half = 0.5 * drag * PERIOD_S / mass;
    for tick in 1..1000 {
        let met = wall.meet(&body, &block, &pushed([0.0, -load]));
        body.advance(&mut block, met.mean_velocity);
        let wanted = 0.5 * ((1.0 - half) / (1.0 + half)).powi(tick);
        assert!((block.axes[0].velocity - wanted).abs() < 1e-12, "{tick}");
    }
}

/// A rotation about an axis that is none of the three.
fn turned(vector: [f64; 3]) -> [f64; 3] {
    let ((s, c), (t, d)) = (std::f64::consts::FRAC_PI_4.sin_cos(), 0.7_f64.sin_cos());
    let [x, y, z] = [c * vector[0] - s * vector[1], s * vector[0] + c * vector[1], vector[2]];
    [x, d * y - t * z, t * y + d * z]
}

#[test]
fn a_wall_askew_is_one_along_an_axis_turned() {
    let gains = Gains { stiffness_n_per_m: 3000.0, damping_n_s_per_m: 1.0, drag_n_s_per_m: 0.3, friction: 0.35 };
    let straight = Plane::<f64, 3>::new([1.0, 0.0, 0.0], 0.002, &gains, PERIOD_S);
    let askew = Plane::<f64, 3>::new(turned([1.0, 0.0, 0.0]), 0.002, &gains, PERIOD_S);
    let body = Body::new(0.2, 0.1, PERIOD_S);
    let start = ([0.0; 3], [0.3, -0.2, 0.4]);
    let (mut one, mut other) = (moving(start.0, start.1), moving(turned(start.0), turned(start.1)));
    let mut touched = 0;
    for tick in 0..3000 {
        let time = f64::from(tick) * PERIOD_S;
        let force = [1.5 * (4.0 * time).sin() + 0.5, 0.8 * (5.0 * time).cos(), -0.6 * (3.0 * time).sin()];
        let met = straight.meet(&body, &one, &pushed(force));
        body.advance(&mut one, met.mean_velocity);
        touched += u32::from(met.push > 0.0);
        let met = askew.meet(&body, &other, &pushed(turned(force)));
        body.advance(&mut other, met.mean_velocity);
        let wanted = turned(one.axes.map(|axis| axis.position));
        let difference = (0..3).map(|at| (wanted[at] - other.axes[at].position).abs()).fold(0.0, f64::max);
        assert!(difference < 1e-9, "{tick}: {difference:e}");
    }
    assert!((200..2900).contains(&touched), "{touched}");
}

/// Without friction, and along one axis, it is the fixture of one axis.
#[test]
fn along_one_axis_it_is_the_forbidden_region() {
    let mut settings = Settings::default();
    (settings.object.integrator, settings.object.force_delay_ticks) = (IntegratorName::Midpoint, 0.0);
    settings.coordination.decode = Decode::Implicit;
    (settings.fixture.kind, settings.fixture.position_m) = (FixtureName::ForbiddenAbove, 0.001);
    let fixture = Fixture::<f64>::build(&settings).expect("good settings").expect("a wall");
    let gains = Gains {
        stiffness_n_per_m: settings.fixture.stiffness_n_per_m,
        damping_n_s_per_m: settings.fixture.damping_n_s_per_m,
        ..Gains::default()
    };
    let wall = Plane::<f64, 2>::new([1.0, 0.0], 0.001, &gains, PERIOD_S);
    let body = Body::new(0.3, 0.0, PERIOD_S);
    let mut free = moving([0.0, 0.0], [0.2, 0.1]);
    let mut alone = Motion { position: 0.0, velocity: 0.2 };
    let inertia = 2.0 * 0.3 / PERIOD_S;
    for tick in 0..2000 {
        let mut mean = 0.0;
        solve_both(Pushes { port: Port::of_force(0.5), toward: 0.0 }, fixture.pushes(alone), |port| {
            mean = (port.force + inertia * alone.velocity) / (inertia + port.impedance);
            mean
        });
        alone = Motion { position: alone.position + PERIOD_S * mean, velocity: 2.0 * mean - alone.velocity };
        let met = wall.meet(&body, &free, &pushed([0.5, 0.0]));
        body.advance(&mut free, met.mean_velocity);
        assert!((free.axes[0].position - alone.position).abs() < 1e-10, "{tick}");
        assert!((free.axes[1].velocity - 0.1).abs() < 1e-15);
    }
}

/// A copy that slides and bounces on an oblique wall with friction, moved by the midpoint rule and by backward Euler: what it and the wall hold never
/// grows, and friction brings it to rest along the wall.
#[test]
fn an_oblique_wall_makes_no_energy_under_either_solve() {
    for (integrator, part) in [(IntegratorName::Midpoint, 0.5), (IntegratorName::BackwardEuler, 1.0)] {
        for stiffness in [1e3, 1e5, 1e7] {
            let mut settings = Settings::default();
            (settings.object.integrator, settings.object.force_delay_ticks) = (integrator, 0.0);
            settings.coordination.decode = Decode::Implicit;
            settings.axis.shared = 2;
            let fixture = &mut settings.fixture;
            (fixture.kind, fixture.position_m, fixture.direction_rad) = (FixtureName::ForbiddenAbove, 0.0, 0.7);
            (fixture.stiffness_n_per_m, fixture.damping_n_s_per_m, fixture.friction) = (stiffness, 0.0, 0.5);
            let mass = settings.object.mass_kg;
            let (wall, normal) = (
                Oblique::<f64, 2>::build(&settings).expect("good settings").expect("a wall"),
                [0.7_f64.cos(), 0.7_f64.sin()],
            );
            let dot = |one: [f64; 2], other: [f64; 2]| one[0] * other[0] + one[1] * other[1];
            let mut copy = [Motion { position: -1e-3, velocity: 0.3 }, Motion { position: 0.0, velocity: -0.1 }];
            let (mut before, mut touched) = (f64::MAX, 0);
            for tick in 0..4000 {
                // 1 N into the wall.
                let mean = wall.mean_velocity(copy, &pushed(normal));
                for (axis, mean) in copy.iter_mut().zip(mean) {
                    axis.position += PERIOD_S * mean;
                    axis.velocity += (mean - axis.velocity) / part;
                }
                let (at, speed) = (copy.map(|axis| axis.position), copy.map(|axis| axis.velocity));
                let depth = dot(normal, at).max(0.0);
                let now = 0.5 * mass * dot(speed, speed) + 0.5 * stiffness * depth * depth - dot(normal, at);
                assert!(now <= before + 1e-12, "{integrator:?}, {stiffness} N/m, tick {tick}: {now} J after {before}");
                before = now;
                touched += u32::from(depth > 0.0);
            }
            let along = dot([-normal[1], normal[0]], copy.map(|axis| axis.velocity));
            assert!(touched > 500 && along.abs() < 1e-9, "{integrator:?}, {stiffness} N/m: {touched}, {along} m/s");
        }
    }
}

/// An oblique spring and damper draw the body against the wall: what they, the wall and the body hold never grows.
fn energy_is_never_made<const N: usize>(seed: u32) {
    let mut random = Random(seed);
    let unit = |random: &mut Random| -> [f64; N] {
        let vector: [f64; N] = std::array::from_fn(|_| random.next() + 1e-3);
        let norm = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
        vector.map(|part| part / norm)
    };
    let gains = Gains {
        stiffness_n_per_m: random.between(10.0, 1e6),
        damping_n_s_per_m: 5.0 * random.next().max(0.0),
        drag_n_s_per_m: 5.0 * random.next().max(0.0),
        friction: random.between(0.01, 3.0),
    };
    let wall = Plane::<f64, N>::new(unit(&mut random), 0.01 * random.next(), &gains, PERIOD_S);
    let body = Body::<f64, N>::new(random.between(1e-3, 10.0), 0.0, PERIOD_S);
    let springs: [([f64; N], f64, f64); 2] =
        std::array::from_fn(|_| (unit(&mut random), random.between(1.0, 1e5), random.next().max(0.0)));
    let mut state = moving([0.0; N], std::array::from_fn(|_| random.next()));
    let stretch = |state: &Moving<f64, N>, along: [f64; N]| -> f64 {
        state.axes.iter().zip(along).map(|(axis, part)| axis.position * part).sum()
    };
    let energy = |state: &Moving<f64, N>| {
        let springs = springs.iter().map(|(along, stiffness, _)| 0.5 * stiffness * stretch(state, *along).powi(2));
        body.energy_j(state) + wall.energy_j(state) + springs.sum::<f64>()
    };
    let began = energy(&state);
    let mut before = began;
    for tick in 0..3000 {
        let others = springs.iter().fold(VectorPort::default(), |sum, (along, stiffness, damping)| {
            let impedance = 0.5 * PERIOD_S * stiffness + damping;
            sum + VectorPort::along(*along, Port { force: -stiffness * stretch(&state, *along), impedance })
        });
        let met = wall.meet(&body, &state, &others);
        assert!(met.push >= 0.0, "seed {seed}, tick {tick}: {met:?}");
        let rubs: f64 = met.along.iter().zip(met.mean_velocity).map(|(force, velocity)| force * velocity).sum();
        assert!(rubs <= 1e-12 * began / PERIOD_S, "seed {seed}, tick {tick}: {rubs:e} W");
        body.advance(&mut state, met.mean_velocity);
        let now = energy(&state);
        assert!(now <= before + 1e-11 * began, "seed {seed}, tick {tick}: {now} after {before}, {began} at first");
        before = now;
    }
}

#[test]
fn energy_is_never_made_at_a_wall() {
    for seed in 0..300 {
        energy_is_never_made::<2>(seed);
        energy_is_never_made::<3>(1000 + seed);
    }
}
