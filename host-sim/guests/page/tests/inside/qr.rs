use super::*;

/// Reads a code as ISO/IEC 18004 lays it down, up to version 5 with the lowest error correction, whose codewords are in one block; none where a
/// module is wrong in what is read. It knows nothing of what made it.
fn read(dark: &dyn Fn(usize, usize) -> bool, side: usize) -> String {
    let wide = side - 8;
    let version = (wide - 17) / 4;
    assert!((1..=5).contains(&version), "version {version}");
    let at = |x: usize, y: usize| dark(x + 4, y + 4);
    // The margin, the three finders, and timing.
    for margin in [0, 1, 2, 3, side - 4, side - 3, side - 2, side - 1] {
        assert!((0..side).all(|along| !dark(along, margin) && !dark(margin, along)), "margin {margin}");
    }
    let near = |x: usize, y: usize, cx: usize, cy: usize| x.abs_diff(cx).max(y.abs_diff(cy));
    for (cx, cy) in [(3, 3), (wide - 4, 3), (3, wide - 4)] {
        for (x, y) in (cx - 3..=cx + 3).flat_map(|x| (cy - 3..=cy + 3).map(move |y| (x, y))) {
            assert_eq!(at(x, y), near(x, y, cx, cy) != 2, "finder at {x} {y}");
        }
    }
    assert!((8..wide - 8).all(|along| at(along, 6) == (along % 2 == 0) && at(6, along) == (along % 2 == 0)));
    // Format: level 01 (L), then which mask, masked itself by 10101…
    let format = (0..5).fold(0, |bits, x| bits << 1 | u32::from(at(x, 8))) ^ 0b10101;
    assert_eq!(format >> 3, 0b01, "error correction of level L");
    let mask = |x: usize, y: usize| match format & 7 {
        0 => (x + y).is_multiple_of(2),
        1 => y.is_multiple_of(2),
        2 => x.is_multiple_of(3),
        3 => (x + y).is_multiple_of(3),
        4 => (y / 2 + x / 3).is_multiple_of(2),
        5 => (x * y) % 2 + (x * y) % 3 == 0,
        6 => ((x * y) % 2 + (x * y) % 3).is_multiple_of(2),
        _ => ((x + y) % 2 + (x * y) % 3).is_multiple_of(2),
    };
    let alignment = (version > 1).then_some(wide - 7);
    let is_function = |x: usize, y: usize| {
        let finders = [(4, 4), (wide - 4, 4), (4, wide - 4)].into_iter().any(|(cx, cy)| near(x, y, cx, cy) <= 4);
        finders || x == 6 || y == 6 || alignment.is_some_and(|middle| near(x, y, middle, middle) <= 2)
    };
    // Two columns at a time from the right, up and down in turn; the column of the timing counts for none.
    let columns = (0..wide).rev().filter(|x| *x != 6).step_by(2);
    let mut bits = Vec::new();
    for (turn, right) in columns.enumerate() {
        for step in 0..wide {
            let y = if turn % 2 == 0 { wide - 1 - step } else { step };
            let left = if right == 7 { 5 } else { right - 1 };
            for x in [right, left] {
                if !is_function(x, y) {
                    bits.push(at(x, y) != mask(x, y));
                }
            }
        }
    }
    let number =
        |from: usize, count: usize| bits[from..from + count].iter().fold(0, |sum, bit| sum << 1 | usize::from(*bit));
    // Segments of digits, of letters and signs, and of bytes; then the end.
    const LETTERS: &[u8] = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ $%*+-./:";
    let (mut text, mut from) = (String::new(), 0);
    let mut next = |count: usize| {
        from += count;
        number(from - count, count)
    };
    loop {
        match next(4) {
            0b0001 => {
                let mut left = next(10);
                while left > 0 {
                    let digits = left.min(3);
                    text += &format!("{:0digits$}", next([0, 4, 7, 10][digits]));
                    left -= digits;
                }
            }
            0b0010 => {
                let mut left = next(9);
                while left > 1 {
                    let two = next(11);
                    text.extend([two / 45, two % 45].map(|at| char::from(LETTERS[at])));
                    left -= 2;
                }
                text.extend((0..left).map(|_| char::from(LETTERS[next(6)])));
            }
            0b0100 => text.extend((0..next(8)).map(|_| char::from(next(8) as u8))),
            0 => return text,
            mode => panic!("mode {mode}"),
        }
    }
}

const ADDRESSES: [&str; 3] = [
    "http://10.0.0.1:80/#hand2-00000000000000000000000000000000",
    "http://192.168.1.5:45123/#hand2-0f1e2d3c4b5a69788796a5b4c3d2e1f0",
    "http://192.168.100.200:65535/#hand1-ffffffffffffffffffffffffffffffff",
];

#[test]
fn the_terminals_blocks_are_the_address() {
    for address in ADDRESSES {
        let code = Code::of(address).expect("a code");
        let lines: Vec<Vec<char>> = code.lines().iter().map(|line| line.chars().collect()).collect();
        assert!(lines.len() <= 23 && lines.iter().all(|line| line.len() == code.side), "it fits 80 by 24");
        let dark = |x: usize, y: usize| match lines[y / 2][x] {
            '█' => true,
            '▀' => y.is_multiple_of(2),
            '▄' => y % 2 == 1,
            _ => false,
        };
        assert_eq!(read(&dark, code.side), address);
    }
}

#[test]
fn the_pages_path_is_the_address() {
    for address in ADDRESSES {
        let code = Code::of(address).expect("a code");
        let path = code.path();
        let mut drawn = vec![false; code.side * code.side];
        for run in path.split_terminator('z') {
            let numbers: Vec<usize> = run
                .split(|c: char| !c.is_ascii_digit())
                .filter(|part| !part.is_empty())
                .map(|part| part.parse().expect("a number"))
                .collect();
            let [x, y, wide, 1, back] = numbers[..] else { panic!("{run}") };
            assert_eq!(wide, back);
            drawn[y * code.side + x..][..wide].fill(true);
        }
        assert_eq!(read(&|x, y| drawn[y * code.side + x], code.side), address);
    }
}

#[test]
fn what_fits_no_code_is_an_error() {
    assert!(Code::of(&"x".repeat(3000)).is_err());
}
