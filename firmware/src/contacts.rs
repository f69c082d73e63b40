//! The emergency stop's two contacts, compared. The first is read at its pin. The second cuts the bridges' supply, so the supply shows it.
//!
//! If the supply is still on when the first contact has been open for [`FALLS_US`], the second is bridged. If the supply falls while the first
//! contact is closed, that contact is bridged or somebody switched the supply off: only a press tells them apart. A finding stays until a
//! press shows that the contact works.
//!
//! **Limits**: a press that ends before the supply has fallen shows nothing of the second contact. A supply that is switched off while the
//! stop is pressed, or just before, falls as if the second contact had cut it. A restart forgets.

/// A supply below this drives no bridge, mV.
pub const OFF_MV: u32 = 4_500;
/// Longest that a supply takes to fall below it, µs (docs/guides/board/assembly.md, gate 2).
pub const FALLS_US: u32 = 10_000_000;

/// What looks at them showed so far; one task looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct Contacts {
    /// The first contact is open.
    open: bool,
    /// Since the first contact last closed the supply has reached what motors need, and was not off after that.
    fed: bool,
    /// When the first contact last moved, or the supply was last off. The clock wraps after 71 minutes: a bridged contact was found by then.
    since_us: u32,
    /// What was found of the second contact, or else of the first.
    found: (bool, bool),
}

impl Contacts {
    /// Takes in a look: whether the first contact is open, the supply, mV, if it is measured, and the minimum that motors need, which is
    /// above [`OFF_MV`]. True if there is a new finding.
    pub fn look(&mut self, now_us: u32, open: bool, supply_mv: Option<u32>, least_mv: u32) -> bool {
        let off = supply_mv.is_none_or(|mv| mv < OFF_MV);
        if open != self.open || supply_mv.is_none() {
            // A release may close the first contact before the second.
            self.fed &= open && supply_mv.is_some();
            (self.open, self.since_us) = (open, now_us);
        }
        let fell = self.fed && off;
        self.fed = !off && (self.fed || supply_mv >= Some(least_mv));
        if off {
            self.since_us = now_us;
        }
        let (before, long) = (self.found, now_us.wrapping_sub(self.since_us) >= FALLS_US);
        self.found = match before {
            (true, _) => (!(open && fell), false),
            (false, first) => (open && long, !open && (first || fell)),
        };
        self.found > before
    }

    /// What stands against turning motors on, one sentence for a person.
    pub fn says(&self) -> Option<&'static str> {
        match self.found {
            (true, _) => Some(
                "the supply was above 4.5 V 10 s after the emergency stop was pressed: its second contact is bridged. Repair it, then \
                 press the stop until the supply is off",
            ),
            (_, true) => Some(
                "the supply fell without the emergency stop's first contact. If it was switched off, press the stop once and release it. \
                 If that does not help, the first contact is bridged",
            ),
            _ => None,
        }
    }
}
