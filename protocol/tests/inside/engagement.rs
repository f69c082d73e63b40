//! The level of the degradation by silence, without a link.

use crate::engagement::{Engagement, Rung};

const PERIOD: u64 = 8_000;

fn heard_for(periods: u64) -> Engagement {
    let mut engagement = Engagement::new(PERIOD as u32, 0);
    for n in 0..=periods {
        engagement.update(n * PERIOD);
        engagement.hear(n * PERIOD);
    }
    engagement
}

#[test]
fn rises_from_zero_over_12_periods() {
    assert_eq!(heard_for(0).level(), 0.0);
    assert!((heard_for(6).level() - 0.5).abs() < 1e-6);
    assert!((heard_for(12).level() - 1.0).abs() < 1e-6);
    assert_eq!(heard_for(100).level(), 1.0);
}

#[test]
fn holds_3_fades_9_then_apart() {
    for step in [1, 500, 1000, 8000, 12345] {
        let mut engagement = heard_for(100);
        let heard = 100 * PERIOD;
        let mut last = 1.0;
        for now in (heard..heard + 13 * PERIOD).step_by(step) {
            engagement.update(now);
            let silent = (now - heard) as f32 / PERIOD as f32;
            let wanted = (1.0 - (silent - 3.0) / 9.0).clamp(0.0, 1.0);
            assert!((engagement.level() - wanted).abs() < 1e-6, "{silent}: {} not {wanted}", engagement.level());
            assert!(engagement.level() <= last);
            last = engagement.level();
            let rung = match silent {
                s if s <= 3.0 => Rung::Engaged,
                s if s < 12.0 => Rung::Fading,
                _ => Rung::Disengaged,
            };
            assert_eq!(engagement.rung(), rung, "{silent}");
        }
    }
}

#[test]
fn resumes_from_where_the_fade_was() {
    let mut engagement = heard_for(100);
    let back = 100 * PERIOD + 7 * PERIOD + PERIOD / 2;
    engagement.update(back);
    engagement.hear(back);
    assert!((engagement.level() - 0.5).abs() < 1e-6);
    engagement.update(back + PERIOD);
    assert!((engagement.level() - 0.5 - 1.0 / 12.0).abs() < 1e-6);
    assert_eq!(engagement.rung(), Rung::Engaged);
}

#[test]
fn time_that_goes_backwards_or_jumps_stays_within_0_and_1() {
    let mut engagement = heard_for(100);
    for now in [0, u64::MAX, 3, u64::MAX / 2] {
        engagement.update(now);
        assert!((0.0..=1.0).contains(&engagement.level()));
        engagement.hear(now);
    }
}

/// 12 packet periods, 96 ms, or what is asked for, whichever is longest.
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
        assert_eq!(engagement.disengage_after_us(), disengaged_us);
        engagement.hear(1_000);
        engagement.update(1_000 + disengaged_us - 1);
        assert_eq!(engagement.rung(), Rung::Fading);
        engagement.update(1_000 + disengaged_us);
        assert_eq!(engagement.rung(), Rung::Disengaged);
    }
}
