//! Intervals against the tables and by hand.

use super::*;

/// Two-sided 95 %, from the tables of the distribution.
#[test]
fn students_t_is_that_of_the_tables() {
    let table = [
        (1, 12.706_205),
        (2, 4.302_653),
        (3, 3.182_446),
        (4, 2.776_445),
        (5, 2.570_582),
        (9, 2.262_157),
        (10, 2.228_139),
        (19, 2.093_024),
        (30, 2.042_272),
        (99, 1.984_217),
        (100, 1.983_972),
    ];
    for (freedom, t) in table {
        let got = student_95(freedom);
        assert!((got - t).abs() < 1e-6, "{got} for {freedom} degrees of freedom, not {t}");
    }
    // In the end it is the normal distribution's.
    assert!((student_95(1_000_000) - 1.959_966).abs() < 1e-5);
}

/// 1 to 20: mean 10.5, standard deviation √35, t = 2.093 024 054 with 19 degrees of freedom.
#[test]
fn an_interval_is_students() {
    let values: Vec<f64> = (1..=20).map(f64::from).collect();
    let Estimate { mean, within_95 } = Estimate::of(&values);
    assert_eq!(mean, 10.5);
    let want = 2.093_024_054_408 * (35.0_f64 / 20.0).sqrt();
    assert!(within_95.is_some_and(|within| (within - want).abs() < 1e-9), "{within_95:?} is not {want}");
    assert_eq!(Estimate::of(&[3.0]), Estimate { mean: 3.0, within_95: None });
}

/// 1, 2, 3: mean 2, standard error 1/√3.
#[test]
fn an_interval_by_hand() {
    let three = Estimate::of(&[1.0, 2.0, 3.0]);
    assert_eq!(three.mean, 2.0);
    assert!((three.within_95.expect("an interval") - 4.302_653 / 3.0_f64.sqrt()).abs() < 1e-6);
    assert_eq!(Estimate::of(&[7.0]), Estimate { mean: 7.0, within_95: None });
}
