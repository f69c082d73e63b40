//! The blue button counts once it was released.

use firmware_parts::button::Watch;
use firmware_parts::signals::Button::{self, Held, Stuck, Up};

fn looks(down: &[bool]) -> Vec<Button> {
    let mut watch = Watch::default();
    down.iter().map(|down| watch.look(*down)).collect()
}

#[test]
fn a_button_that_is_down_at_the_start_is_stuck_until_it_was_released() {
    assert_eq!(looks(&[false, true, true, false, true]), [Up, Held, Held, Up, Held]);
    assert_eq!(looks(&[true, true, true]), [Stuck; 3]);
    assert_eq!(looks(&[true, false, true]), [Stuck, Up, Held]);
}
