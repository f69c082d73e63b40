//! Addresses of boards: valid, their own, and always the same.

use std::collections::BTreeSet;

use firmware_parts::mac::address;

/// Chips of a few wafers and lots, as ST counts them: coordinates, wafer, and letters of the lot.
fn chips() -> impl Iterator<Item = [u32; 3]> {
    let lots = [*b"Q123456", *b"Q123457", *b"P123456"];
    lots.into_iter().flat_map(|lot| {
        let [a, b, c, rest @ ..] = lot;
        (0..25_u8).flat_map(move |wafer| {
            (0..40_u32 * 40).map(move |at| {
                [at % 40 + ((at / 40) << 16), u32::from_le_bytes([wafer, a, b, c]), u32::from_le_bytes(rest)]
            })
        })
    })
}

#[test]
fn every_chip_has_an_address_of_its_own_that_a_network_takes() {
    let all: Vec<_> = chips().map(|unique| address(unique, 1)).collect();
    assert!(all.iter().all(|address| address[0] & 0b11 == 0b10), "locally administered, and one station's");
    assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
    assert!(
        all.len() == 120_000 && chips().zip(&all).all(|(unique, one)| address(unique, 2) == *one),
        "the strap has no part"
    );
    // Every other bit is set in half of them: 120 000 throws of a coin, five deviations.
    for bit in (0..48).filter(|bit| ![40, 41].contains(bit)) {
        let set = all.iter().filter(|address| address[5 - bit / 8] >> (bit % 8) & 1 == 1).count();
        assert!(set.abs_diff(60_000) < 5 * 174, "bit {bit}: {set}");
    }
}

#[test]
fn a_chip_without_a_number_is_called_after_its_strap() {
    assert_eq!(address([0; 3], 2), [0x02, 0x48, 0x61, 0x70, 0x74, 2]);
}

/// By a program in another language: networks remember boards by it.
#[test]
fn an_address_stays_what_it_was() {
    assert_eq!(address([0x0012_0034, 0x3151_0E05, 0x3635_3433], 1), [0x26, 0xD8, 0x91, 0x29, 0x90, 0x28]);
}
