//! Sine and cosine of an `f32`: the same bits as `libm` has them, but for angles that no encoder counts to.
//!
//! As in `libm`, whose polynomials these are (FreeBSD's msun, by Sun Microsystems, 1993): the angle less whole quarters of a turn in `f64`,
//! in which two polynomials give the rest. π/2 in 25 and 53 bits is enough within [`LARGEST`]. Beyond that `libm` reduces by a table of 2/π,
//! in 3 kB of code of which the board's fastest memory has none to spare, and for angles that are 32 rad from their neighbours: here they
//! have no sine.

/// 2²⁸·π/2, rad.
pub(super) const LARGEST: f32 = 421_657_440.0;

/// 2/π.
const PER_QUARTER: f64 = core::f64::consts::FRAC_2_PI;
/// π/2 to 25 bits, and the rest of it.
const QUARTER: f64 = 1.570_796_310_901_641_8;
const REST: f64 = 1.589_325_477_352_819_7e-8;
/// What is added to it loses its fraction: 1.5·2⁵².
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// Sine and cosine of an angle, rad: error < 1 ulp within ± [`LARGEST`], no number beyond.
#[inline(never)]
pub(super) fn sin_cos(angle: f32) -> (f32, f32) {
    if angle == 0.0 {
        // With its sign.
        return (angle, 1.0);
    }
    let within = if angle.abs() < LARGEST { f64::from(angle) } else { f64::NAN };
    let quarters = (within * PER_QUARTER + WHOLE) - WHOLE;
    let rest = within - quarters * QUARTER - quarters * REST;
    let (sine, cosine) = (sine(rest), cosine(rest));
    // The cast saturates, and takes no number to 0.
    match quarters as i32 & 3 {
        0 => (sine, cosine),
        1 => (cosine, -sine),
        2 => (-sine, -cosine),
        _ => (-cosine, sine),
    }
}

/// Of an angle within ±π/4: |sin(x)/x − s(x)| < 2⁻³⁷.
#[inline]
fn sine(angle: f64) -> f32 {
    let square = angle * angle;
    let fourth = square * square;
    let high = -1.983_933_483_609_663_2e-4 + square * 2.718_311_493_989_822e-6;
    let cube = square * angle;
    let low = -0.166_666_666_416_265_24 + square * 8.333_329_385_889_463e-3;
    ((angle + cube * low) + cube * fourth * high) as f32
}

/// Of an angle within ±π/4: |cos(x) − c(x)| < 2⁻³⁴.
#[inline]
fn cosine(angle: f64) -> f32 {
    let square = angle * angle;
    let fourth = square * square;
    let high = -1.388_676_377_460_993e-3 + square * 2.439_044_879_627_741e-5;
    (((1.0 + square * -0.499_999_997_251_031) + fourth * 0.041_666_623_323_739_06) + (fourth * square) * high) as f32
}
