//! Images for a board's bootloader, of files written here byte by byte.

use cohold_board_tools::image::flash;

/// A file with these segments: kind, physical address, bytes. As the format's specification has it (ELF-32, figures 1-3 and 2-1).
fn elf(segments: &[(u32, u32, &[u8])]) -> Vec<u8> {
    let mut file = vec![0x7F, b'E', b'L', b'F', 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0];
    let half = |file: &mut Vec<u8>, value: u16| file.extend(value.to_le_bytes());
    let words = |file: &mut Vec<u8>, values: &[u32]| values.iter().for_each(|value| file.extend(value.to_le_bytes()));
    [2, 40].iter().for_each(|value| half(&mut file, *value));
    words(&mut file, &[1, 0, 52, 0, 0]);
    [52, 32, segments.len() as u16, 0, 0, 0].iter().for_each(|value| half(&mut file, *value));
    let mut offset = 52 + 32 * segments.len() as u32;
    for (kind, address, bytes) in segments {
        let length = bytes.len() as u32;
        // The virtual address is another one: of what is copied at a start it always is.
        words(&mut file, &[*kind, offset, 0x2000_C000, *address, length, length, 5, 4]);
        offset += length;
    }
    segments.iter().for_each(|(_, _, bytes)| file.extend(*bytes));
    file
}

/// A stack at 0x2000_C000 and an entry at 0x0800_0299.
const BEGIN: [u8; 8] = [0x00, 0xC0, 0x00, 0x20, 0x99, 0x02, 0x00, 0x08];

fn refusal(file: &[u8]) -> String {
    flash(file).expect_err("refused").to_string()
}

#[test]
fn segments_stand_at_their_physical_addresses_and_the_rest_is_blank() {
    let file = elf(&[
        (1, 0x0800_0000, &BEGIN),
        (1, 0x0800_0030, &[1, 2, 3]),
        // Neither is loaded: a note, and a stack without bytes.
        (4, 0x0810_0000, &[9]),
        (1, 0x2000_0000, &[]),
    ]);
    let bytes = flash(&file).expect("an image");
    assert_eq!(bytes.len(), 64, "whole words of flash");
    assert_eq!(bytes[..8], BEGIN);
    assert_eq!(bytes[0x30..0x33], [1, 2, 3]);
    assert!(bytes[8..0x30].iter().chain(&bytes[0x33..]).all(|byte| *byte == 0xFF));
}

#[test]
fn what_would_reach_keys_and_settings_is_refused() {
    let last = elf(&[(1, 0x0800_0000, &BEGIN), (1, 0x080F_FFFE, &[7, 8])]);
    assert_eq!(flash(&last).expect("it ends with its bank").len(), 0x10_0000);
    for (address, bytes) in [(0x080F_FFFF, [7, 8]), (0x081C_0000, [7, 8]), (0x07FF_FFFF, [7, 8]), (u32::MAX, [7, 8])] {
        let says = refusal(&elf(&[(1, 0x0800_0000, &BEGIN), (1, address, &bytes)]));
        assert!(says.contains(&format!("at {address:#x} to ")) && says.contains("0x8000000 to 0x8100000"), "{says}");
    }
}

#[test]
fn what_is_no_image_is_refused_however_short() {
    let file = elf(&[(1, 0x0800_0000, &BEGIN), (1, 0x0800_0030, &[1, 2, 3])]);
    for length in 0..file.len() {
        let says = refusal(&file[..length]);
        assert!(says.starts_with("it is no image for a board: "), "{length}: {says}");
    }
    let mut other = file.clone();
    other[18] = 62;
    assert!(refusal(&other).contains("must be an ELF file for ARM"));
    for begin in [[0xFF; 8], [0; 8], [0x00, 0xC0, 0x00, 0x20, 0x98, 0x02, 0x00, 0x08]] {
        let says = refusal(&elf(&[(1, 0x0800_0000, &begin)]));
        assert!(says.ends_with("it does not begin with a stack and an entry"), "{says}");
    }
    assert!(refusal(&elf(&[(1, 0x0800_0030, &[1])])).ends_with("a stack and an entry"), "nothing at its beginning");
}
