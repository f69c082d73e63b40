//! A stop whose contact is bridged is found by its next long press, and one that is sound is not.

use firmware_parts::contacts::{Contacts, FALLS_US, OFF_MV};

/// Time between two looks, µs, and the least supply, mV.
const LOOK_US: u32 = 10_000;
const LEAST_MV: u32 = 18_000;
const FIRST: &str = "the supply fell without the emergency stop's first contact. ";
const SECOND: &str = "the supply was above 4.5 V 10 s after the emergency stop was pressed: ";

/// A stop, the supply behind it, and what looks at both.
#[derive(Default)]
struct Stop {
    contacts: Contacts,
    now_us: u32,
    bridged: [bool; 2],
    supply_mv: f64,
    found: usize,
}

impl Stop {
    /// Pressed or not, for so many seconds, with such a supply at its end.
    fn is(&mut self, pressed: bool, seconds: f64, full_mv: f64) -> &mut Self {
        for _ in 0..(seconds * 1e6) as u32 / LOOK_US {
            self.now_us = self.now_us.wrapping_add(LOOK_US);
            let cut = full_mv == 0.0 || pressed && !self.bridged[1];
            self.supply_mv = if cut { self.supply_mv * (-0.01_f64 / 2.2).exp() } else { full_mv };
            self.look(pressed && !self.bridged[0], Some(self.supply_mv as u32));
        }
        self
    }

    fn look(&mut self, open: bool, supply_mv: Option<u32>) {
        self.found += usize::from(self.contacts.look(self.now_us, open, supply_mv, LEAST_MV));
    }

    /// What it says begins so, and it was found so often.
    fn says(&mut self, why: Option<&str>, found: usize) -> &mut Self {
        let says = self.contacts.says();
        let same = says.zip(why).is_some_and(|(says, why)| says.starts_with(why)) || says.is_none() && why.is_none();
        assert!(same && self.found == found, "{says:?} {} times, should be {why:?} {found} times", self.found);
        self
    }
}

#[test]
fn a_sound_stop_is_not_suspected() {
    // From before the start on; short and long presses; a supply that is low from the start, and one that returns slowly.
    Stop::default().is(true, 20.0, 24e3).is(false, 1.0, 24e3).says(None, 0);
    Stop::default().is(false, 1.0, 0.0).is(false, 1.0, 24e3).is(true, 1.0, 24e3).is(false, 1.0, 24e3).says(None, 0);
    let mut stop = Stop::default();
    for seconds in [0.02, 1.0, 3.0, 3.6, 3.7, 9.9, 10.1, 60.0] {
        stop.is(false, 1.0, 24e3).is(true, seconds, 24e3).is(false, 0.1, 10e3).is(false, 1.0, 24e3).says(None, 0);
    }
    // Released in the moment in which it falls below what drives a bridge: the first contact closes, and the second does so later.
    stop.look(true, Some(OFF_MV));
    stop.look(false, Some(OFF_MV));
    stop.look(false, Some(OFF_MV - 1));
    stop.says(None, 0);
}

#[test]
fn a_second_contact_that_is_bridged_is_found_once_and_stays_until_a_press_cuts_the_supply() {
    let mut stop = Stop { bridged: [false, true], ..Stop::default() };
    stop.is(false, 1.0, 24e3).is(true, 9.99, 24e3).is(false, 1.0, 24e3).says(None, 0);
    stop.is(true, 9.99, 24e3).says(None, 0).is(true, 0.03, 24e3).says(Some(SECOND), 1);
    // Neither a release, nor a short press, nor a supply that is switched off meanwhile.
    stop.is(true, 5000.0, 24e3).is(false, 1.0, 24e3).is(true, 1.0, 24e3).is(false, 5.0, 0.0).says(Some(SECOND), 1);
    stop.is(true, 1.0, 0.0).is(false, 1.0, 24e3).says(Some(SECOND), 1);
    stop.bridged[1] = false;
    stop.is(true, 3.6, 24e3).says(Some(SECOND), 1).is(true, 0.2, 24e3).says(None, 1);
    stop.is(false, 1.0, 24e3).says(None, 1);
}

#[test]
fn a_supply_that_falls_without_the_first_contact_is_found_once_and_stays_until_that_opens() {
    for bridged in [true, false] {
        let mut stop = Stop { bridged: [bridged, false], ..Stop::default() };
        // With a contact that is sound somebody switches the supply off.
        stop.is(false, 1.0, 24e3).is(bridged, 3.6, if bridged { 24e3 } else { 0.0 }).says(None, 0);
        stop.is(bridged, 0.2, if bridged { 24e3 } else { 0.0 }).says(Some(FIRST), 1);
        stop.is(false, 60.0, 24e3).is(bridged, 60.0, 24e3).is(false, 1.0, 24e3).says(Some(FIRST), 1);
        stop.bridged[0] = false;
        stop.is(true, 0.02, 24e3).says(None, 1).is(false, 1.0, 24e3).says(None, 1);
    }
}

#[test]
fn what_is_not_measured_shows_nothing() {
    let mut stop = Stop { bridged: [false, true], ..Stop::default() };
    stop.is(false, 1.0, 24e3);
    stop.look(false, None);
    stop.is(false, 1.0, 4e3).says(None, 0);
    // The stop is pressed, and only after that its supply is measured.
    stop.look(true, None);
    stop.now_us += FALLS_US;
    stop.look(true, None);
    stop.is(true, 9.98, 24e3).says(None, 0).is(true, 0.03, 24e3).says(Some(SECOND), 1);
}
