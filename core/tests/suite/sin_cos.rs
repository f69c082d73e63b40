//! Sine and cosine of `f32` against those of `f64`, which have 29 bits more, and against `libm`'s own.

use cohold_core::num::Scalar;

/// Beyond it an angle has no sine, rad.
const LARGEST: f32 = 421_657_440.0;

/// Angles of every size, both signs, and the neighbours of every quarter of a turn that is within 10⁵ of them.
fn angles() -> impl Iterator<Item = f32> {
    let sizes = (0..LARGEST.to_bits()).step_by(997).map(f32::from_bits);
    let quarters = (0..100_000).flat_map(|quarters| {
        let nearest = (f64::from(quarters) * std::f64::consts::FRAC_PI_4) as f32;
        [nearest.next_down(), nearest, nearest.next_up()]
    });
    sizes.chain(quarters).flat_map(|angle| [angle, -angle])
}

/// By how many steps of an `f32` of this size a value is off.
fn ulps(value: f32, exact: f64) -> f64 {
    let step = f64::from((exact as f32).abs().next_up()) - f64::from((exact as f32).abs());
    (f64::from(value) - exact).abs() / step
}

#[test]
fn sine_and_cosine_are_as_near_as_an_f32_is() {
    let most = angles().fold(0.0_f64, |most, angle| {
        let (sine, cosine) = Scalar::sin_cos(angle);
        let (exact_sine, exact_cosine) = f64::from(angle).sin_cos();
        most.max(ulps(sine, exact_sine)).max(ulps(cosine, exact_cosine))
    });
    assert!(most < 0.56, "{most} steps of an f32");
}

#[test]
fn sine_and_cosine_have_the_bits_that_libm_gives_them() {
    let differ = angles().find(|angle| {
        let (ours, theirs) = (Scalar::sin_cos(*angle), libm::sincosf(*angle));
        (ours.0.to_bits(), ours.1.to_bits()) != (theirs.0.to_bits(), theirs.1.to_bits())
    });
    assert_eq!(differ, None);
}

#[test]
fn an_angle_beyond_any_encoder_has_no_sine() {
    for angle in [LARGEST, -LARGEST, f32::MAX, f32::INFINITY, f32::NEG_INFINITY, f32::NAN] {
        let (sine, cosine) = Scalar::sin_cos(angle);
        assert!(sine.is_nan() && cosine.is_nan(), "{angle}: {sine}, {cosine}");
    }
    let (sine, cosine) = Scalar::sin_cos(LARGEST.next_down());
    assert!(sine.is_finite() && cosine.is_finite());
}
