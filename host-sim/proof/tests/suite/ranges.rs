//! Ranges against numbers: what an operation gives of members of ranges is in what it gives of the ranges; and whole courses of a peer
//! against the same courses in f32, which end on one of the paths.

use cohold_core::device::{AXES, Reading};
use cohold_core::law::Packet;
use cohold_core::num::{Motion, Scalar};
use cohold_core::peer::{Peer, Sensors};
use cohold_core::safety::{Command, Mode};
use cohold_core::schema::Schema;
use cohold_core::settings::{Settings, Value};
use cohold_laws::EveryLaw;
use cohold_proof::range::Float;
use cohold_proof::{Number, Range, Unknown, begin, explore};
use proptest::prelude::*;
use proptest::strategy::ValueTree;

/// Numbers with everything that is special among them.
fn any_number() -> impl Strategy<Value = f64> {
    prop_oneof![
        4 => -10.0..10.0_f64,
        2 => any::<f32>().prop_map(f64::from),
        1 => prop::sample::select(vec![0.0, -0.0, 1.0, -1.0, f64::INFINITY, f64::NEG_INFINITY, 1e-45, 3.4e38, -3.4e38]),
    ]
}

/// A range and one of what is in it.
fn range_and_member() -> impl Strategy<Value = (Range, f64)> {
    let within = (any_number(), any_number(), any::<bool>(), 0.0..=1.0_f64, 0..8_u8);
    within.prop_map(|(a, b, nan, part, which)| {
        let [a, b] = [a, b].map(|end| if end.is_nan() { 0.0 } else { f64::from(end as f32) });
        let (lo, hi) = (a.min(b), a.max(b));
        let between = f64::from((lo + part * (hi - lo)) as f32);
        let member = match which {
            0 => lo,
            1 => hi,
            2 if nan => f64::NAN,
            3 if lo <= 0.0 && hi >= 0.0 => 0.0,
            _ if between >= lo && between <= hi => between,
            _ => hi,
        };
        (Range { lo, hi, nan }, member)
    })
}

fn check<F: Float>((a, x): (Range, f64), (b, y): (Range, f64), (c, z): (Range, f64)) -> Result<(), TestCaseError> {
    begin();
    let [of_a, of_b, of_c] = [a, b, c].map(Unknown::<F>::within);
    let [x, y, z] = [x, y, z].map(F::from_f64);
    let (sine, cosine) = of_a.sin_cos();
    let (of_sine, of_cosine) = x.sin_cos();
    let cases = [
        ("+", of_a + of_b, x + y),
        ("-", of_a - of_b, x - y),
        ("*", of_a * of_b, x * y),
        ("square", of_a * of_a, x * x),
        ("neg", -of_a, -x),
        ("abs", of_a.abs(), x.abs()),
        ("sqrt", of_a.sqrt(), x.sqrt()),
        ("ratio", of_a.ratio(of_b), x.ratio(y)),
        ("over", of_a.over(of_b), x.over(y)),
        ("limit", of_a.limit(of_b), x.limit(y)),
        ("limit by a constant", of_a.limit(Unknown::from_f64(2.5)), x.limit(F::from_f64(2.5))),
        ("max", of_a.max(of_b), x.max(y)),
        ("min", of_a.min(of_b), x.min(y)),
        ("if_between", of_a.if_between(of_b, of_c, of_b), x.if_between(y, z, y)),
        ("sine", sine, of_sine),
        ("cosine", cosine, of_cosine),
        ("regained", (of_a + of_b) - of_a, (x + y) - x),
        ("regained from a difference", (of_a - of_b) - of_a, (x - y) - x),
        ("a line", of_a * of_b + of_c, x * y + z),
        ("to a counter and back", Unknown::of_counter(of_a.to_counter()), F::of_counter(x.to_counter())),
    ];
    for (name, range, number) in cases {
        prop_assert!(range.range().has(number.to_f64()), "{}: {number:?} is not in {range:?}", name);
    }
    Ok(())
}

/// What a program of branches and sums gives, in any number type.
fn branches<S: Scalar>(x: S, y: S, z: S) -> S {
    let difference = x - y;
    let bound = z.abs();
    let held = if difference.abs() > bound { if difference > S::ZERO { y + bound } else { y - bound } } else { x };
    let sum = held + z;
    if !sum.is_finite() {
        return S::ONE;
    }
    if S::ZERO * sum + S::ZERO * x == S::ZERO && held >= y { sum * held } else { sum - x }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn operations(a in range_and_member(), b in range_and_member(), c in range_and_member()) {
        check::<f32>(a, b, c)?;
        check::<f64>(a, b, c)?;
    }

    #[test]
    fn one_of_the_paths((a, x) in range_and_member(), (b, y) in range_and_member(), (c, z) in range_and_member()) {
        begin();
        let [of_a, of_b, of_c] = [a, b, c].map(Number::within);
        let [x, y, z] = [x, y, z].map(|number| number as f32);
        let number = f64::from(branches(x, y, z));
        let mut there = false;
        let whole = explore(|| branches(of_a, of_b, of_c), |path| there |= path.gave.range().has(number));
        prop_assert!(whole && there, "{number} of {x} {y} {z}");
    }
}

/// Two ticks in narrow ranges around a course, every path of them; and 300 courses in those ranges in f32.
fn courses(settings: &Settings) {
    type Any<S> = EveryLaw<S>;
    const TICKS: usize = 2;
    let width = 0.004;
    let readings = |tick: usize| [0.01 * tick as f64, 0.5 - 0.2 * tick as f64, -0.02, 0.1];
    let packets = |tick: usize| [0.03 - 0.01 * tick as f64, 0.2, -0.3, 1e-3 * tick as f64, 0.0];
    // One program for both.
    fn run<S: Scalar>(
        settings: &Settings,
        readings: &[[S; 4]],
        packets: &[([S; 3], [S::Counter; 2])],
    ) -> (Mode, [S; AXES]) {
        let mut peer = Peer::<S, Any<S>>::new(settings, [Motion::REST; AXES]).expect("a scene");
        peer.command(Command::Arm);
        let mut forces = [S::ZERO; AXES];
        for (live_ticks, ([a, b, c, d], ([x, v, wave], [energy_j, wave_integral]))) in
            (1..).zip(readings.iter().zip(packets))
        {
            let motion = Motion { position: *x, velocity: *v };
            let (wave, energy_j, wave_integral) = (*wave, *energy_j, *wave_integral);
            peer.hear(&[Packet { motion, wave, energy_j, wave_integral, live_ticks }]);
            if peer.packet_due() {
                peer.exchange();
            }
            let axes = [Motion { position: *a, velocity: *b }, Motion { position: *c, velocity: *d }];
            forces = peer.tick(&Sensors::of(Reading::Exact(axes))).forces;
        }
        (peer.mode(), forces)
    }
    begin();
    let around = |middle: f64| Range::of(f64::from((middle - width) as f32), f64::from((middle + width) as f32));
    let of_readings: Vec<_> = (0..TICKS).map(|tick| readings(tick).map(|at| Number::within(around(at)))).collect();
    let of_packets: Vec<_> = (0..TICKS)
        .map(|tick| {
            let [x, v, wave, energy, integral] = packets(tick);
            (
                [x, v, wave].map(|at| Number::within(around(at))),
                [energy, integral].map(|at| Unknown::within(around(at))),
            )
        })
        .collect();
    let mut ends = Vec::new();
    let whole = explore(
        || run(settings, &of_readings, &of_packets),
        |path| ends.push((path.gave.0, path.gave.1.map(Unknown::range))),
    );
    assert!(whole && !ends.is_empty());
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let (mut widest, mut tightest) = (0.0_f64, f64::INFINITY);
    for _ in 0..300 {
        let draws = prop::collection::vec(-1.0..=1.0_f64, TICKS * 9).new_tree(&mut runner).expect("numbers").current();
        let mut draws = draws.into_iter();
        let mut near = |middle: f64| {
            let Range { lo, hi, .. } = around(middle);
            ((middle + width * draws.next().unwrap_or_default()) as f32).clamp(lo as f32, hi as f32)
        };
        let readings: Vec<_> = (0..TICKS).map(|tick| readings(tick).map(&mut near)).collect();
        let packets: Vec<_> = (0..TICKS)
            .map(|tick| {
                let [x, v, wave, energy, integral] = packets(tick).map(&mut near);
                ([x, v, wave], [f64::from(energy), f64::from(integral)])
            })
            .collect();
        let (mode, forces) = run(settings, &readings, &packets);
        let fits = |(of_mode, ranges): &&(Mode, [Range; AXES])| {
            *of_mode == mode && ranges.iter().zip(forces).all(|(range, force)| range.has(f64::from(force)))
        };
        let end = ends.iter().find(fits);
        let (_, [range, _]) = end.unwrap_or_else(|| panic!("{forces:?}, {mode:?}: not one of {ends:?}"));
        widest = widest.max(range.hi - range.lo);
        tightest = tightest.min(range.hi - range.lo);
    }
    println!("{}: {} paths, forces in ranges of {tightest} to {widest} N", settings.coordination.comm, ends.len());
}

#[test]
fn courses_in_f32_end_on_a_path() {
    for law in cohold_laws::LAWS {
        for ports in [false, true] {
            let mut settings = Settings::default();
            settings.coordination.comm = law.name;
            settings.axis.count = 2;
            settings.timing.ticks_per_packet = 1;
            for gain in law.gains {
                let (key, value) = gain.split_once('=').expect("key=value");
                Schema::new(cohold_laws::LAWS).set(&mut settings, key, Value::of_text(value)).expect("a gain");
            }
            if ports {
                settings.set("object.integrator", Value::Text("midpoint")).expect("a name");
            }
            if settings.object.integrator.solves() {
                settings.set("coordination.decode", Value::Text("implicit")).expect("a name");
                settings.object.force_delay_ticks = 0.0;
            }
            if settings.check_with::<EveryLaw<f64>>().is_ok() {
                courses(&settings);
            }
        }
    }
}
