//! Critical sections that the tick preempts.
//!
//! BASEPRI masks priority 2 and everything less urgent; the tick has priority 1 and the current loop 0. So a critical section of
//! whatever task delays neither, and in turn neither must ever take one.

use critical_section::RawRestoreState;

/// Priority 2 in the four bits that this chip has.
const MASK: u8 = 2 << 4;

struct BelowTheTick;
critical_section::set_impl!(BelowTheTick);

// SAFETY: everything that takes a critical section runs at priority 2 or less urgently, and is masked until `release`
// puts back what was there.
unsafe impl critical_section::Impl for BelowTheTick {
    unsafe fn acquire() -> RawRestoreState {
        let before = cortex_m::register::basepri::read();
        // BASEPRI_MAX only ever raises the mask: sections nest.
        cortex_m::register::basepri_max::write(MASK);
        u32::from(before)
    }

    unsafe fn release(before: RawRestoreState) {
        // SAFETY: puts back what `acquire` found; the order of releases is the caller's promise.
        unsafe { cortex_m::register::basepri::write(before as u8) };
    }
}
