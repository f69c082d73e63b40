//! What one function's instructions do to the stack and where they go: the Thumb-2 of an ARMv7E-M with FPU (ARM DDI 0403E).
//!
//! Only what matters here is decoded: whatever moves the stack pointer down by a constant, calls, and jumps. What moves it
//! to where nobody can say (`mov sp, r1`) is an error, so a frame is never too small: it is the sum of all that the function ever
//! takes, whichever way through it is taken.

use std::collections::BTreeSet;

/// What a function does.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Body {
    /// Bytes of registers that it puts on the stack.
    pub pushed: u64,
    /// Bytes that it takes beside them.
    pub reserved: u64,
    /// Addresses that it calls or jumps to, itself left out unless called.
    pub calls: BTreeSet<u64>,
    /// Calls and jumps to an address in a register.
    pub by_pointer: usize,
    /// Constants that it puts together in a register: addresses of functions may be among them.
    pub constants: BTreeSet<u64>,
    /// Where it moves the stack pointer in a way that cannot be followed.
    pub astray: Option<u64>,
}

impl Body {
    /// Decodes the instructions at `start`; `code` gives the halfword at an address, or `None` where data begin.
    pub fn decode(start: u64, end: u64, code: impl Fn(u64) -> Option<u16>) -> Self {
        let mut body = Self::default();
        let mut low = [None; 16];
        let mut at = start;
        while at < end {
            let Some(first) = code(at) else {
                at += 2;
                continue;
            };
            let target = if matches!(first >> 11, 0b11101..=0b11111) {
                let second = code(at + 2).unwrap_or(0);
                let target = body.wide(at, first, second, &mut low);
                at += 2;
                target
            } else {
                body.narrow(at, first)
            };
            at += 2;
            // A jump to another place of the same function is none of the graph's business; a call is.
            body.calls.extend(target.filter(|(to, call)| *call || !(start..end).contains(to)).map(|(to, _)| to));
        }
        body
    }

    /// Bytes of stack in all.
    pub fn frame(&self) -> u64 {
        self.pushed + self.reserved
    }

    /// An instruction of 16 bits; where it goes, and whether that is a call.
    fn narrow(&mut self, at: u64, op: u16) -> Option<(u64, bool)> {
        match op {
            0xB400..=0xB5FF => self.pushed += 4 * u64::from((op & 0x1FF).count_ones()),
            0xB080..=0xB0FF => self.reserved += 4 * u64::from(op & 0x7F),
            // add sp, r; mov sp, r.
            _ if op & 0xFF87 == 0x4485 || op & 0xFF87 == 0x4685 => self.astray = Some(at),
            // bx lr is the return. blx r; bx r; add pc, r; mov pc, r.
            0x4770 => {}
            _ if op & 0xFF00 == 0x4700 || op & 0xFF87 == 0x4487 || op & 0xFF87 == 0x4687 => self.by_pointer += 1,
            0xD000..=0xDDFF => return Some((relative(at, u32::from(op & 0xFF), 8), false)),
            0xE000..=0xE7FF => return Some((relative(at, u32::from(op & 0x7FF), 11), false)),
            _ => {}
        }
        None
    }

    /// An instruction of 32 bits.
    fn wide(&mut self, at: u64, first: u16, second: u16, low: &mut [Option<u64>; 16]) -> Option<(u64, bool)> {
        let (base, to) = (first & 0xF, usize::from(second >> 8 & 0xF));
        let word = u64::from(second & 0xFF);
        let immediate = u32::from(first >> 10 & 1) << 11 | u32::from(second >> 12 & 7) << 8 | u32::from(second & 0xFF);
        match (first, second) {
            // push; vpush; str and strd that take the stack pointer along, before or after.
            (0xE92D, _) => self.pushed += 4 * u64::from(second.count_ones()),
            (0xED2D | 0xED6D, _) if second & 0x0E00 == 0x0A00 => self.pushed += 4 * word,
            (0xF80D | 0xF82D | 0xF84D, _) if second & 0x0B00 == 0x0900 => self.pushed += word,
            (0xE96D | 0xE86D, _) => self.pushed += 4 * word,
            // sub.w and subw sp, sp, #.
            (0xF1AD | 0xF5AD, _) if second & 0x8F00 == 0x0D00 => self.reserved += expanded(immediate),
            (0xF2AD | 0xF6AD, _) if second & 0x8F00 == 0x0D00 => self.reserved += u64::from(immediate),
            // add.w and addw sp, sp, # give back.
            (0xF10D | 0xF50D | 0xF20D | 0xF60D, _) if second & 0x8F00 == 0x0D00 => {}
            // Branches: bl, b.w, b.w on a condition; msr of a stack pointer stands among them.
            (0xF000..=0xF7FF, 0x8000..) => {
                let sign = u32::from(first >> 10 & 1);
                let (one, two) = (u32::from(second >> 13 & 1), u32::from(second >> 11 & 1));
                let low = u32::from(second & 0x7FF);
                return match second & 0xD000 {
                    0x9000 | 0xD000 => {
                        let [one, two] = [one, two].map(|bit| 1 ^ bit ^ sign);
                        let offset = sign << 23 | one << 22 | two << 21 | u32::from(first & 0x3FF) << 11 | low;
                        Some((relative(at, offset, 24), second & 0xD000 == 0xD000))
                    }
                    0x8000 if first & 0x380 != 0x380 => {
                        let offset = sign << 19 | two << 18 | one << 17 | u32::from(first & 0x3F) << 11 | low;
                        Some((relative(at, offset, 20), false))
                    }
                    _ => {
                        if first & 0xFFF0 == 0xF380 && matches!(second & 0xFF, 8 | 9) {
                            self.astray = Some(at);
                        }
                        None
                    }
                };
            }
            // movw and movt.
            (0xF240..=0xF24F | 0xF640..=0xF64F, _) => low[to] = Some(u64::from(u32::from(base) << 12 | immediate)),
            (0xF2C0..=0xF2CF | 0xF6C0..=0xF6CF, _) => {
                let high = u64::from(u32::from(base) << 12 | immediate) << 16;
                self.constants.extend(low[to].map(|low| high | low));
            }
            // Anything else that computes into the stack pointer, or loads it.
            (0xEA00..=0xEBFF | 0xF000..=0xF7FF, _) if to == 13 && second & 0x8000 == 0 => self.astray = Some(at),
            (0xF850..=0xF85F | 0xF8D0..=0xF8DF, 0xD000..=0xDFFF) => self.astray = Some(at),
            // ldr pc and ldm that loads pc, unless from the stack: those return.
            (0xF850..=0xF85F | 0xF8D0..=0xF8DF, 0xF000..) if base != 13 => self.by_pointer += 1,
            (0xE890..=0xE8BF | 0xE910..=0xE93F, 0x8000..) if base != 13 && first & 0x10 != 0 => self.by_pointer += 1,
            _ => {}
        }
        None
    }
}

/// The address that an offset of so many bits, in halfwords, stands for.
fn relative(at: u64, offset: u32, bits: u32) -> u64 {
    let signed = (offset << (32 - bits)).cast_signed() >> (32 - bits);
    (at + 4).wrapping_add_signed(2 * i64::from(signed))
}

/// A constant of 32 bits from its 12 (ThumbExpandImm).
fn expanded(immediate: u32) -> u64 {
    let byte = immediate & 0xFF;
    let value = match immediate >> 8 {
        0 => byte,
        1 => byte << 16 | byte,
        2 => byte << 24 | byte << 8,
        3 => byte * 0x0101_0101,
        _ => (0x80 | immediate & 0x7F).rotate_right(immediate >> 7),
    };
    u64::from(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(code: &[u16]) -> Body {
        Body::decode(0x100, 0x100 + 2 * code.len() as u64, |at| Some(code[(at - 0x100) as usize / 2]))
    }

    /// Encodings by LLVM's assembler (`llvm-mc -triple=thumbv7em -mcpu=cortex-m7 -show-encoding`).
    #[test]
    fn every_way_down_is_counted() {
        for (code, pushed, reserved) in [
            (&[0xB5F0][..], 20, 0),                    // push {r4-r7, lr}
            (&[0xE92D, 0x0F00], 16, 0),                // push.w {r8-r11}
            (&[0xF84D, 0xBD04], 4, 0),                 // str r11, [sp, #-4]!
            (&[0xE96D, 0x4502], 8, 0),                 // strd r4, r5, [sp, #-8]!
            (&[0xED2D, 0x8B10], 64, 0),                // vpush {d8-d15}
            (&[0xED6D, 0x8A01], 4, 0),                 // vpush {s17}
            (&[0xB0FF], 0, 508),                       // sub sp, #508
            (&[0xF5AD, 0x5DC3], 0, 6240),              // sub.w sp, sp, #6240
            (&[0xF6AD, 0x4D68], 0, 3176),              // subw sp, sp, #3176
            (&[0xB07F, 0xE8BD, 0x8FF0, 0x4770], 0, 0), // add sp, #508; pop.w {r4-r11, pc}; bx lr
        ] {
            let expected = Body { pushed, reserved, ..Body::default() };
            assert_eq!(body(code), expected, "{code:04x?}");
        }
    }

    #[test]
    fn calls_jumps_and_what_cannot_be_followed() {
        let calls = |code: &[u16]| body(code).calls.into_iter().collect::<Vec<_>>();
        assert_eq!(calls(&[0xF000, 0xF801]), [0x106], "bl forward");
        assert_eq!(calls(&[0xF7FF, 0xFFFE]), [0x100], "bl to itself");
        assert_eq!(calls(&[0xF7FF, 0xBFF0]), [0xE4], "b.w backward");
        assert_eq!(calls(&[0xF43F, 0xAFF0]), [0xE4], "beq.w backward");
        assert_eq!(calls(&[0xE7F0]), [0xE4], "b backward");
        assert_eq!(calls(&[0xE7FE, 0xD0FD]), [] as [u64; 0], "within the function");
        for pointer in [&[0x4798][..], &[0x4718], &[0x469F], &[0xF8D0, 0xF004]] {
            assert_eq!(body(pointer).by_pointer, 1, "{pointer:04x?}");
        }
        for astray in [&[0x468D][..], &[0x448D], &[0xEBAD, 0x0D01], &[0xF381, 0x8808], &[0xF8D0, 0xD000]] {
            assert_eq!(body(astray).astray, Some(0x100), "{astray:04x?}");
        }
        assert_eq!(body(&[0xF640, 0x4C71, 0xF6C0, 0x0C00]).constants.into_iter().next(), Some(0x0800_0C71));
    }
}
