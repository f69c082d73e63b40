//! In which order the interrupt and the tasks see each other's stores.
//!
//! The board has one core: an interrupt sees what the code that it interrupts has stored, and that code what the interrupt has, in the order of
//! the program. So only the compiler has to keep to that order, and no barrier instruction is needed, of which each is as long as all that
//! the processor has under way. Anywhere else (tests on a PC, loom) sides are threads, and the orders are those of the memory model.

use core::sync::atomic::{Ordering, compiler_fence};

const ONE_CORE: bool = cfg!(target_os = "none");

/// Of a load, with [`kept`] behind it: what follows is done after it.
pub(crate) const ACQUIRE: Ordering = if ONE_CORE { Ordering::Relaxed } else { Ordering::Acquire };
/// Of a store, with [`kept`] before it: it is done after all that came before.
pub(crate) const RELEASE: Ordering = if ONE_CORE { Ordering::Relaxed } else { Ordering::Release };
/// Of a swap, with [`kept`] on both sides: both.
pub(crate) const BOTH: Ordering = if ONE_CORE { Ordering::Relaxed } else { Ordering::AcqRel };

/// The compiler moves nothing past this; it is no instruction.
#[inline(always)]
pub(crate) fn kept() {
    compiler_fence(Ordering::SeqCst);
}
