use cohold_io::escaped;

#[test]
fn what_a_terminal_would_obey_is_spelled_out() {
    assert_eq!(escaped("ok armed \u{1b}[2J\u{1b}]0;x\u{7}"), "ok armed \\u001b[2J\\u001b]0;x\\u0007");
    assert_eq!(escaped("\u{9b}31m \u{202e}desrever\u{2069}\u{7f}"), "\\u009b31m \\u202edesrever\\u2069\\u007f");
    assert_eq!(escaped("ok\nwarning: none"), "ok\\u000awarning: none");
}

/// Every character that Unicode calls a control, and every one that it says changes the direction, but for the tab.
#[test]
fn nothing_is_left_that_is_no_letter_sign_or_space() {
    let direction = "\u{61c}\u{200e}\u{200f}\u{202a}\u{202b}\u{202c}\u{202d}\u{202e}\u{2066}\u{2067}\u{2068}\u{2069}";
    for character in ('\0'..='\u{9f}').chain(direction.chars()) {
        let control = matches!(u32::from(character), 0..=0x1f | 0x7f..=0x9f) || direction.contains(character);
        let kept = escaped(&character.to_string()).contains(character);
        assert_eq!(kept, !control || character == '\t', "{character:?}");
    }
    assert_eq!(escaped("Kopplung: 3 N/m, µs, 力, \t\"é\" \\u"), "Kopplung: 3 N/m, µs, 力, \t\"é\" \\u");
}
