//! Causes of a start, by number.

use firmware_parts::status::Stop;

#[test]
fn numbers_lead_back_to_causes_and_are_not_the_peers() {
    for number in 0..=255 {
        if let Some(stop) = Stop::from_number(number) {
            assert!(stop as u8 == number && number >= 32);
        }
    }
    assert_eq!([35, 38, 39].map(Stop::from_number), [Stop::Watchdog, Stop::TickMissed, Stop::ClockFailed].map(Some));
}
