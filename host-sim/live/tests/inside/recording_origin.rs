use std::cell::Cell;
use std::time::Duration;

use super::*;

#[test]
fn clocks_between_which_a_machine_halts_are_read_again() {
    let (start, tries) = (Instant::now(), Cell::new(0));
    let (since, shown) = at_once(start, || {
        tries.set(tries.get() + 1);
        let shown = start.elapsed().as_nanos() as u64;
        if tries.get() < 5 {
            std::thread::sleep(Duration::from_millis(20));
        }
        shown
    });
    assert!(since.abs_diff(shown) < 5_000_000, "{since} ns after the start was called {shown} ns");
}
