//! MAC address of a board, from the number that every chip has: as many boards in a network as it has addresses.
//!
//! 96 bits become 46: locally administered (bit 1 of the first byte), unicast (bit 0). Two of a thousand boards share an address once
//! in a hundred million networks. An address never changes from one image to the next.

/// The chip's number, as its three words.
pub type Unique = [u32; 3];

/// The address of the chip with this number; a chip that has none (0) is called after `board`, 1 or 2.
pub fn address(unique: Unique, board: u8) -> [u8; 6] {
    if unique == [0; 3] {
        return [0x02, 0x48, 0x61, 0x70, 0x74, board];
    }
    let hash = unique.iter().fold(0, |hash, word| mixed(hash ^ u64::from(*word)));
    let [_, _, mut address @ ..] = hash.to_be_bytes();
    address[0] = address[0] & !0b11 | 0b10;
    address
}

/// A bijection of which every bit of the result depends on every bit of the number: the output step of SplitMix64 (Steele, Lea and
/// Flood 2014).
fn mixed(number: u64) -> u64 {
    let number = number.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let number = (number ^ (number >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let number = (number ^ (number >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    number ^ (number >> 31)
}
