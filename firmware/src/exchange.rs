//! Latest-value cells: the only memory that the 1 kHz interrupt and the tasks share.
//!
//! Design: three slots. The writer owns one, the reader owns one, the third changes hands by one atomic swap, so neither
//! side ever waits, retries or sees half a value; a value nobody fetched is replaced by the next. The interrupt is one
//! side of every cell and can preempt the other anywhere.
//!
//! Invariants: the three owned indices are always a permutation of 0, 1, 2; what [`Reader::get`] shows changes only in
//! [`Reader::fetch`]. Checked under every interleaving by loom: `RUSTFLAGS="--cfg loom" cargo test -p firmware --lib`.
//!
//! Limits: one writer, one reader. A stream in which every value counts needs a queue (`heapless::spsc`) instead.

#[cfg(not(loom))]
use core::{cell::UnsafeCell, sync::atomic::AtomicU8};
#[cfg(loom)]
use loom::{cell::UnsafeCell, sync::atomic::AtomicU8};

use core::sync::atomic::Ordering;

/// Set beside the index of the free slot when it holds a value that the reader has not fetched.
const FRESH: u8 = 4;
const INDEX: u8 = 3;

/// Three slots, of which one is always free to change hands.
#[derive(Debug)]
pub struct Latest<T> {
    slots: (UnsafeCell<T>, UnsafeCell<T>, UnsafeCell<T>),
    free: AtomicU8,
}

// SAFETY: a slot is touched only by the side that owns its index, and indices change hands by acquire-release swaps.
unsafe impl<T: Send> Sync for Latest<T> {}

impl<T: Copy> Latest<T> {
    /// A cell that shows `value` until something is written.
    pub fn new(value: T) -> Self {
        let slot = || UnsafeCell::new(value);
        Self { slots: (slot(), slot(), slot()), free: AtomicU8::new(2) }
    }
}

impl<T> Latest<T> {
    /// The two sides.
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
}

/// The side that publishes.
#[derive(Debug)]
pub struct Writer<'a, T> {
    cell: &'a Latest<T>,
    own: u8,
}

impl<T> Writer<'_, T> {
    /// Publishes a value in place of the last one.
    #[inline]
    pub fn write(&mut self, value: T) {
        let slot = self.cell.slot(self.own);
        #[cfg(not(loom))]
        // SAFETY: the index `own` is this side's alone.
        unsafe {
            *slot.get() = value;
        }
        #[cfg(loom)]
        slot.with_mut(|slot| unsafe { *slot = value });
        self.own = self.cell.free.swap(self.own | FRESH, Ordering::AcqRel) & INDEX;
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
        self.front = self.cell.free.swap(self.front, Ordering::AcqRel) & INDEX;
        true
    }

    /// The value taken over last.
    #[inline]
    #[cfg(not(loom))]
    pub fn get(&self) -> &T {
        // SAFETY: the index `front` is this side's alone, and changes only through `&mut self`.
        unsafe { &*self.cell.slot(self.front).get() }
    }

    /// The value taken over last.
    #[cfg(loom)]
    pub fn copy(&self) -> T
    where
        T: Copy,
    {
        self.cell.slot(self.front).with(|slot| unsafe { *slot })
    }

    /// The newest value, if it was not taken before.
    #[inline]
    #[cfg(not(loom))]
    pub fn take(&mut self) -> Option<T>
    where
        T: Copy,
    {
        if self.fetch() { Some(*self.get()) } else { None }
    }
}

#[cfg(all(test, not(loom)))]
mod tests {
    use super::*;

    #[test]
    fn the_newest_value_is_taken_once() {
        let mut cell = Latest::new(0);
        let (mut writer, mut reader) = cell.split();
        assert_eq!((reader.take(), *reader.get()), (None, 0));
        writer.write(1);
        writer.write(2);
        assert_eq!(reader.take(), Some(2));
        assert_eq!((reader.take(), *reader.get()), (None, 2));
        writer.write(3);
        assert_eq!(reader.take(), Some(3));
    }

    #[test]
    fn what_the_reader_holds_stands_while_the_writer_goes_on() {
        let mut cell = Latest::new([0; 2]);
        let (mut writer, mut reader) = cell.split();
        writer.write([1; 2]);
        reader.fetch();
        let held = *reader.get();
        for value in 2..9 {
            writer.write([value; 2]);
            assert_eq!(*reader.get(), held);
        }
    }
}

#[cfg(all(test, loom))]
mod tests {
    extern crate std;
    use super::*;
    use loom::thread;

    /// Every interleaving of two writes with two looks: whole values only, never an older one, never the same one twice.
    #[test]
    fn no_interleaving_tears_or_goes_back() {
        loom::model(|| {
            let cell = std::boxed::Box::leak(std::boxed::Box::new(Latest::new((0_u32, 0_u32))));
            let (mut writer, mut reader) = cell.split();
            let writing = thread::spawn(move || {
                for value in 1..=2 {
                    writer.write((value, 10 * value));
                }
            });
            let mut last = 0;
            for _ in 0..2 {
                let fresh = reader.fetch();
                let (value, tenfold) = reader.copy();
                assert_eq!(tenfold, 10 * value);
                assert_eq!(fresh, value > last, "{value} after {last}");
                last = value;
            }
            writing.join().unwrap();
            reader.fetch();
            assert_eq!(reader.copy(), (2, 20), "what was written last is what is there in the end");
        });
    }
}
