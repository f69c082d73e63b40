//! What a session counts.

use super::*;
use crate::wire::PeerId;

#[test]
fn what_is_missing_is_known_after_years() {
    let ends = Ends { local: PeerId(1), remote: PeerId(2) };
    let offer = Offer { ephemeral: [3; 32], incarnation: 4 };
    let mut session = Session::new(
        &Key::new([7; Key::LEN]),
        ends,
        [offer; 2],
        &Key::new([5; Key::LEN]),
        &(0, [TableHash::default(); TABLES]),
        0,
    );
    // 198 days at 250 a second.
    session.window.take((1 << 32) + 9).unwrap();
    session.taken = (1 << 32) + 7;
    assert_eq!((session.taken(), session.missing()), (u32::MAX, 3));
}

impl Session {
    /// A mistake, for the search ([`crate::link`]): which sequence numbers have been taken is forgotten.
    pub(crate) fn forget_what_was_taken(&mut self) {
        self.window = Window::default();
    }
}
