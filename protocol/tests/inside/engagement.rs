//! The rungs of silence, without a link.

use crate::engagement::{Engagement, Rung};

/// 12 packet periods, 96 ms, or what is asked for, whichever is longest; a quarter of it is borne.
#[test]
fn how_long_a_silence_may_be() {
    for (period_us, asked_us, disengaged_us) in [
        (8_000, 0, 96_000),
        (1_000, 0, 96_000),
        (20_000, 96_000, 240_000),
        (1_000, 8_000_000, 8_000_004),
        (8_000, 96_000, 96_000),
    ] {
        let mut engagement = Engagement::new(period_us, asked_us);
        assert_eq!((engagement.disengage_after_us(), engagement.rung()), (disengaged_us, Rung::Disengaged));
        engagement.hear(1_000);
        let last_engaged = disengaged_us / 4;
        let rungs =
            [(last_engaged, Rung::Engaged), (last_engaged + 1, Rung::Fading), (disengaged_us - 1, Rung::Fading)];
        for (silent_us, rung) in rungs {
            engagement.update(1_000 + silent_us);
            assert_eq!(engagement.rung(), rung, "{silent_us} of {disengaged_us} us");
        }
        let mut resumed = engagement;
        resumed.hear(1_000 + disengaged_us - 1);
        assert_eq!(resumed.rung(), Rung::Engaged);
        engagement.update(1_000 + disengaged_us);
        assert_eq!(engagement.rung(), Rung::Disengaged);
    }
}

#[test]
fn time_that_goes_backwards_stands_still() {
    let mut engagement = Engagement::new(8_000, 0);
    engagement.update(1_000_000);
    engagement.hear(1_000_000);
    for now in [0, 999_999, 1_024_000] {
        engagement.update(now);
        assert_eq!(engagement.rung(), Rung::Engaged);
    }
    engagement.update(u64::MAX);
    assert_eq!(engagement.rung(), Rung::Disengaged);
}
