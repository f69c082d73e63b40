//! An image as a board's flash takes it: what its ELF file has at physical addresses, from the beginning of flash on, blank in between.
//!
//! A bootloader takes bytes and an address. It erases the sectors that it writes, so an image stays within the first bank ([`BANK_1`]): keys and
//! settings are in the second (memory.x), and an image that would reach it is refused.

use std::ops::Range;

use crate::Error;

/// Bank 1 of flash: program and constants, and the tick's code that is copied at a start.
pub const BANK_1: Range<usize> = 0x0800_0000..0x0810_0000;
/// Bytes that flash is programmed by at once.
const WORD: usize = 32;
/// What is blank.
const BLANK: u8 = 0xFF;
/// ELF of 32 bits, little-endian, version 1; its processor is ARM.
const ELF: [u8; 7] = [0x7F, b'E', b'L', b'F', 1, 1, 1];
const ARM: u16 = 40;
/// A segment that is loaded.
const LOAD: u32 = 1;

/// The bytes from the beginning of [`BANK_1`] on.
///
/// # Errors
/// It is no image for a board, or leaves the first bank; one sentence.
pub fn flash(elf: &[u8]) -> Result<Vec<u8>, Error> {
    let none = |why: &str| Error::Refused(format!("it is no image for a board: {why}"));
    if !elf.starts_with(&ELF) || half(elf, 18) != Some(ARM) {
        return Err(none("it must be an ELF file for ARM, as cargo builds it or a release has it"));
    }
    let cut = || none("the file ends before its segments do");
    let (table, size, count) = (word(elf, 28).ok_or_else(cut)?, half(elf, 42), half(elf, 44).ok_or_else(cut)?);
    if size != Some(32) {
        return Err(none("its table of segments is none of 32 bits"));
    }
    let mut flash = Vec::new();
    for at in (0..usize::from(count)).map(|nth| table.saturating_add(32 * nth)) {
        let field = |nth: usize| word(elf, at.saturating_add(4 * nth)).ok_or_else(cut);
        let (kind, offset, address, length) = (field(0)?, field(1)?, field(3)?, field(4)?);
        if kind != LOAD as usize || length == 0 {
            continue;
        }
        let bytes = elf.get(offset..offset.saturating_add(length)).ok_or_else(cut)?;
        let end = address.saturating_add(length);
        if address < BANK_1.start || end > BANK_1.end {
            let Range { start, end: last } = BANK_1;
            return Err(none(&format!(
                "it has bytes at {address:#x} to {end:#x}; an update is within {start:#x} to {last:#x}, for the board's keys and settings \
                 are behind that"
            )));
        }
        let place = address - BANK_1.start..end - BANK_1.start;
        flash.resize(flash.len().max(place.end.next_multiple_of(WORD)), BLANK);
        flash[place].copy_from_slice(bytes);
    }
    // The first two words: the stack's top, in DTCM, and where the program begins, in flash.
    let [stack, entry] = [0, 4].map(|at| word(&flash, at).unwrap_or(0));
    if !(0x2000_0000..=0x2002_0000).contains(&stack) || !BANK_1.contains(&entry) || entry % 2 == 0 {
        return Err(none("it does not begin with a stack and an entry"));
    }
    Ok(flash)
}

fn half(bytes: &[u8], at: usize) -> Option<u16> {
    bytes.get(at..)?.first_chunk().map(|bytes| u16::from_le_bytes(*bytes))
}

fn word(bytes: &[u8], at: usize) -> Option<usize> {
    bytes.get(at..)?.first_chunk().map(|bytes| u32::from_le_bytes(*bytes) as usize)
}
