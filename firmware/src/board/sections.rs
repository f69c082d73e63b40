//! Critical sections that the tick preempts.
//!
//! BASEPRI masks priority 1 and everything less urgent; the tick has priority 0, which BASEPRI cannot mask. So a critical
//! section of whatever task delays the tick by nothing, and in turn the tick must never take one.

use critical_section::RawRestoreState;

/// Priority 1 in the four bits that this chip has.
const MASK: u8 = 1 << 4;

struct BelowTheTick;
critical_section::set_impl!(BelowTheTick);

// SAFETY: everything that takes a critical section runs at priority 1 or less urgently, and is masked until `release`
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
