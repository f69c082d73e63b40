//! Memory of which only the piece given out last is taken back: 16 MB, of which the recording of one case at a time is the largest part.

use core::alloc::{GlobalAlloc, Layout};
use core::sync::atomic::{AtomicUsize, Ordering};

/// PSRAM of the mps2-an500.
const START: usize = 0x6000_0000;
const END: usize = START + 16 * 1024 * 1024;

/// Where the next piece starts.
pub(crate) struct Heap(AtomicUsize);

impl Heap {
    pub(crate) const fn new() -> Self {
        Self(AtomicUsize::new(START))
    }
}

// SAFETY: every piece lies inside a RAM that nothing else uses, and no two overlap, because the next one starts
// behind all that are still held; there is one thread.
unsafe impl GlobalAlloc for Heap {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let start = self.0.load(Ordering::Relaxed).next_multiple_of(layout.align());
        match start.checked_add(layout.size()) {
            Some(end) if end <= END => {
                self.0.store(end, Ordering::Relaxed);
                start as *mut u8
            }
            _ => core::ptr::null_mut(),
        }
    }

    unsafe fn dealloc(&self, piece: *mut u8, layout: Layout) {
        let start = piece as usize;
        if start + layout.size() == self.0.load(Ordering::Relaxed) {
            self.0.store(start, Ordering::Relaxed);
        }
    }
}
