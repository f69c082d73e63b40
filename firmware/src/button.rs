//! The blue button: held, or stuck since before the start.
//!
//! Whoever holds it says that he is at the board ([`crate::ceiling`]). A button that is down when the board starts says nothing until it
//! was seen released: it may be jammed, or shorted. One that jams later cannot be distinguished from one that is held.

use crate::signals::Button;

/// Looks at the button now and then.
#[derive(Clone, Copy, Debug, Default)]
pub struct Watch {
    released: bool,
}

impl Watch {
    /// What the button says, of which one look says whether it is down.
    pub fn look(&mut self, down: bool) -> Button {
        self.released |= !down;
        match (down, self.released) {
            (false, _) => Button::Up,
            (true, true) => Button::Held,
            (true, false) => Button::Stuck,
        }
    }
}
