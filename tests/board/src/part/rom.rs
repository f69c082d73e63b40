//! The bootloader in the chip's ROM, as far as an image that goes there can see: a main stack and an entry at its beginning, and a reset when it
//! is done, for which the bench changes the word at the top of that stack.
//!
//! Not modelled: USB, and that it writes flash.

use std::path::Path;

use rigless::image::Image;

/// Where it is (AN2606).
const START: u32 = 0x1FF0_9800;
/// Its main stack.
pub const STACK: u32 = 0x2000_4000;
/// The first instruction that it executes.
pub const ENTRY: u32 = START + 8;

/// mov r0, sp; push {r0}; ldr r1, [sp]; cmp r1, r0; beq to the third; then 0x05FA0004 to 0xE000ED0C, which resets, and a loop.
const CODE: [u16; 15] = [
    0x4668, 0xB401, 0x9900, 0x4281, 0xD0FC, 0xF64E, 0x520C, 0xF2CE, 0x0200, 0xF240, 0x0304, 0xF2C0, 0x53FA, 0x6013,
    0xE7FE,
];

/// What stands there.
pub(crate) fn image() -> Image {
    let words = [STACK, ENTRY | 1].map(u32::to_le_bytes).concat();
    let code = CODE.iter().flat_map(|half| half.to_le_bytes());
    Image::new(Path::new("ROM"), words.into_iter().chain(code).collect(), Some(START.into()))
        .expect("bytes at an address")
}
