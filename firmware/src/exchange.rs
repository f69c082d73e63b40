//! Latest-value cells and queues: the only memory that the 1 kHz interrupt and the tasks share.
//!
//! Design of [`Latest`]: three slots. The writer owns one, the reader owns one, the third changes hands by one atomic swap, so neither
//! side ever waits, retries or sees half a value; a value nobody fetched is replaced by the next. The interrupt is one
//! side of every cell and can preempt the other anywhere.
//!
//! Invariants: the three owned indices are always a permutation of 0, 1, 2; what [`Reader::get`] shows changes only in
//! [`Reader::fetch`]. Checked under every interleaving by loom: `cargo test -p firmware --features loom --test interleavings`.
//!
//! [`Queue`] is for streams in which every value counts: a ring with one index a side; when it is full the writer is notified,
//! and goes on. (`heapless::spsc` divides by its length at run time, and can panic there.)
//!
//! Limits: one writer, one reader.

#[cfg(not(feature = "loom"))]
use core::sync::atomic::{AtomicU8, AtomicU32};
#[cfg(feature = "loom")]
use loom::{
    cell::UnsafeCell,
    sync::atomic::{AtomicU8, AtomicU32},
};

use core::sync::atomic::Ordering;

use crate::order::{ACQUIRE, BOTH, RELEASE, kept};

/// Loom's interface, on memory.
#[cfg(not(feature = "loom"))]
#[derive(Debug)]
struct UnsafeCell<T>(core::cell::UnsafeCell<T>);

#[cfg(not(feature = "loom"))]
impl<T> UnsafeCell<T> {
    fn new(value: T) -> Self {
        Self(core::cell::UnsafeCell::new(value))
    }
    #[inline(always)]
    fn with<R>(&self, look: impl FnOnce(*const T) -> R) -> R {
        look(self.0.get())
    }
    #[inline(always)]
    fn with_mut<R>(&self, change: impl FnOnce(*mut T) -> R) -> R {
        change(self.0.get())
    }
}

/// Set beside the index of the free slot when it holds a value that the reader has not fetched.
const FRESH: u8 = 4;
const INDEX: u8 = 3;

/// Three slots, of which one is always free to change hands.
#[derive(Debug)]
pub struct Latest<T> {
    slots: (UnsafeCell<T>, UnsafeCell<T>, UnsafeCell<T>),
    free: AtomicU8,
}

// SAFETY: a slot is touched only by the side that owns its index, and indices change hands by swaps that keep the order of both sides.
unsafe impl<T: Send> Sync for Latest<T> {}

impl<T: Copy> Latest<T> {
    /// A cell that shows `value` until something is written.
    pub fn new(value: T) -> Self {
        Self::of([value; 3])
    }
}

impl<T> Latest<T> {
    /// A cell of three values: the first is written next, the second is shown until then.
    pub fn of([own, shown, free]: [T; 3]) -> Self {
        Self { slots: (UnsafeCell::new(own), UnsafeCell::new(shown), UnsafeCell::new(free)), free: AtomicU8::new(2) }
    }

    /// The writer's and the reader's side.
    pub fn split(&mut self) -> (Writer<'_, T>, Reader<'_, T>) {
        let free = self.free.load(Ordering::Relaxed) & INDEX;
        // Any two indices that differ from the free one and from each other.
        let (own, front) = match free {
            0 => (1, 2),
            1 => (0, 2),
            _ => (0, 1),
        };
        (Writer { cell: self, own }, Reader { cell: self, front })
    }

    #[inline]
    fn slot(&self, index: u8) -> &UnsafeCell<T> {
        match index {
            0 => &self.slots.0,
            1 => &self.slots.1,
            _ => &self.slots.2,
        }
    }

    /// Gives a slot away, and the index of the one that comes back.
    #[inline]
    fn swap(&self, own: u8) -> u8 {
        kept();
        let free = self.free.swap(own, BOTH);
        kept();
        free & INDEX
    }
}

/// The side that publishes.
#[derive(Debug)]
pub struct Writer<'a, T> {
    cell: &'a Latest<T>,
    own: u8,
}

/// Copies to where nothing overlaps. Inlined, LLVM does not know that, and calls `memmove`, of which ITCM would hold 1.6 kB for three copies.
#[inline(never)]
pub fn put<T: Copy>(to: &mut T, from: &T) {
    *to = *from;
}

impl<T: Copy> Writer<'_, T> {
    /// Publishes a value in place of the last one.
    #[inline]
    pub fn write(&mut self, value: T) {
        self.fill(|slot| {
            put(slot, &value);
            true
        });
    }
}

impl<T> Writer<'_, T> {
    /// Writes a value where it is to lie, over what lay there, and publishes it in place of the last one if `fill` says so.
    #[inline]
    pub fn fill(&mut self, fill: impl FnOnce(&mut T) -> bool) {
        // SAFETY: the index `own` is this side's alone.
        if self.cell.slot(self.own).with_mut(|slot| fill(unsafe { &mut *slot })) {
            self.own = self.cell.swap(self.own | FRESH);
        }
    }
}

/// The side that looks.
#[derive(Debug)]
pub struct Reader<'a, T> {
    cell: &'a Latest<T>,
    front: u8,
}

impl<T> Reader<'_, T> {
    /// Takes over the newest value; false if there is none since the last time.
    #[inline]
    pub fn fetch(&mut self) -> bool {
        if self.cell.free.load(Ordering::Relaxed) & FRESH == 0 {
            return false;
        }
        self.front = self.cell.swap(self.front);
        true
    }

    /// The value taken over last.
    #[inline]
    #[cfg(not(feature = "loom"))]
    pub fn get(&self) -> &T {
        // SAFETY: the index `front` is this side's alone, and changes only through `&mut self`.
        self.cell.slot(self.front).with(|slot| unsafe { &*slot })
    }

    /// The value taken over last, copied.
    #[inline]
    pub fn copy(&self) -> T
    where
        T: Copy,
    {
        // SAFETY: as above.
        self.cell.slot(self.front).with(|slot| unsafe { *slot })
    }

    /// The newest value, if it was not taken before.
    #[inline]
    pub fn take(&mut self) -> Option<T>
    where
        T: Copy,
    {
        if self.fetch() { Some(self.copy()) } else { None }
    }
}

/// A ring of `N` values, `N` a power of two.
#[derive(Debug)]
pub struct Queue<T, const N: usize> {
    slots: [UnsafeCell<T>; N],
    /// Values ever put in.
    head: AtomicU32,
    /// Values ever taken out.
    tail: AtomicU32,
}

// SAFETY: a slot belongs to the reader from the release of `head` to the release of `tail`, otherwise to the writer.
unsafe impl<T: Send, const N: usize> Sync for Queue<T, N> {}

impl<T: Copy + Default, const N: usize> Default for Queue<T, N> {
    fn default() -> Self {
        const { assert!(N.is_power_of_two()) };
        Self {
            slots: core::array::from_fn(|_| UnsafeCell::new(T::default())),
            head: AtomicU32::new(0),
            tail: AtomicU32::new(0),
        }
    }
}

impl<T: Copy, const N: usize> Queue<T, N> {
    /// The producer's and the consumer's side.
    pub fn split(&mut self) -> (Producer<'_, T, N>, Consumer<'_, T, N>) {
        (Producer { queue: self }, Consumer { queue: self })
    }

    #[inline]
    fn slot(&self, at: u32) -> &UnsafeCell<T> {
        // The mask keeps the index below N: no check is left in the program.
        &self.slots[at as usize & (N - 1)]
    }
}

/// The side that puts in.
#[derive(Debug)]
pub struct Producer<'a, T, const N: usize> {
    queue: &'a Queue<T, N>,
}

impl<T: Copy, const N: usize> Producer<'_, T, N> {
    /// Puts a value in that is made where it will lie; false, and none is made, if the queue is full.
    #[inline]
    pub fn put(&mut self, make: impl FnOnce(&mut T)) -> bool {
        let head = self.queue.head.load(Ordering::Relaxed);
        let tail = self.queue.tail.load(ACQUIRE);
        kept();
        if head.wrapping_sub(tail) >= N as u32 {
            return false;
        }
        // SAFETY: the reader gave this slot back, and sees it again only after the store below.
        self.queue.slot(head).with_mut(|slot| make(unsafe { &mut *slot }));
        kept();
        self.queue.head.store(head.wrapping_add(1), RELEASE);
        true
    }
}

/// The side that takes out.
#[derive(Debug)]
pub struct Consumer<'a, T, const N: usize> {
    queue: &'a Queue<T, N>,
}

impl<T: Copy, const N: usize> Consumer<'_, T, N> {
    /// Takes the oldest value, if there is one.
    pub fn take(&mut self) -> Option<T> {
        let tail = self.queue.tail.load(Ordering::Relaxed);
        let head = self.queue.head.load(ACQUIRE);
        kept();
        if tail == head {
            return None;
        }
        // SAFETY: the writer handed this slot over, and writes it again only after the store below.
        let value = self.queue.slot(tail).with(|slot| unsafe { *slot });
        kept();
        self.queue.tail.store(tail.wrapping_add(1), RELEASE);
        Some(value)
    }
}
