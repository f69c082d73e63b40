//! Verdicts follow from numbers.

use cohold_core::names::Choice;

use super::*;

#[test]
fn a_number_is_matched_within_what_is_said() {
    let verdict = |computed| Claim::number("§1", "ten", (10.0, computed, "N"), 0.05).verdict;
    assert_eq!(
        [9.4, 9.6, 10.4, 10.6, f64::NAN].map(verdict).map(Verdict::name),
        ["not matched", "matched", "matched", "not matched", "not matched"]
    );
    let claim = Claim::number("§1", "ten", (10.0, 10.4, "N"), 0.05);
    assert!((claim.off.expect("a part") - 0.04).abs() < 1e-12);
    assert_eq!(claim.found, "10.40 N, the paper's 10 ± 5 %");
}

/// Everywhere, somewhere, nowhere; and a match that shows nothing, or rests on what is assumed.
#[test]
fn a_match_is_as_wide_as_what_was_looked_at() {
    let verdict = |holding| Claim::in_places("§1", "it does", holding, 3, String::new()).verdict.name();
    assert_eq!([3, 2, 0].map(verdict), ["matched", "holds in part", "not matched"]);
    let [yes, no] = [true, false].map(|holds| Claim::holds("§1", "it does", holds, String::new()));
    let verdicts = |claim: &Claim| {
        [claim.clone().circular("so"), claim.clone().assumed("so".to_owned())].map(|it| it.verdict.name())
    };
    assert_eq!(verdicts(&yes), ["circular", "holds in part"]);
    assert_eq!(verdicts(&no), ["not matched", "not matched"]);
}

/// Only what is not matched is asked why, and only what is matched has a remark.
#[test]
fn reasons_stand_where_they_belong() {
    let [yes, no] = [true, false].map(|holds| Claim::holds("§1", "it does", holds, String::new()));
    assert_eq!(yes.clone().unless(|| unreachable!()).expect("no question").why, "");
    assert_eq!(no.clone().unless(|| Ok("because".to_owned())).expect("a reason").why, "because");
    assert_eq!((yes.but("so far".to_owned()).why.as_str(), no.but("so far".to_owned()).why.as_str()), ("so far", ""));
}
