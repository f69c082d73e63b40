//! The netlist against the firmware's sources, electrical rules, and the drawings that are committed.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use cohold_wiring::netlist::{Image, Is, Netlist, Pull, Role, split};
use cohold_wiring::sheet::{self, Anchor, Drawing, Line, Text};
use cohold_wiring::{page, rules, svg};

mod paddle;

fn place(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn text(name: &str) -> String {
    std::fs::read_to_string(place(name)).unwrap_or_else(|cause| panic!("{name}: {cause}"))
}

fn netlist() -> Netlist {
    Netlist::parse(&text("netlist.toml")).unwrap()
}

/// The boards, by their folders: each is wired as the netlist says.
const BOARDS: [&str; 1] = ["nucleo_mb1364"];

/// Pins of the chip that a board's table takes for an image: `p.PE9`, unless what it stands in is of the other image.
fn taken(folder: &str, image: Image) -> BTreeSet<String> {
    let (three, moteus, spi) = (image == Image::Three, image == Image::Moteus, image == Image::Spi);
    let usb = image == Image::Usb;
    let mut pins = BTreeSet::new();
    // What is asked of the next statement, and how deep in brackets that has gone.
    let (mut left_out, mut depth) = (false, 0);
    for line in text(&format!("../src/boards/{folder}/mod.rs")).lines().map(str::trim) {
        if line.starts_with("#[cfg(") {
            let wanted = match line {
                "#[cfg(feature = \"three-axes\")]" => three,
                "#[cfg(feature = \"moteus\")]" => moteus,
                "#[cfg(not(feature = \"moteus\"))]" => !moteus,
                "#[cfg(feature = \"spi-encoders\")]" => spi,
                // Stands within what a moteus leaves out.
                "#[cfg(not(feature = \"spi-encoders\"))]" => !spi && !moteus,
                "#[cfg(feature = \"usb\")]" => usb,
                "#[cfg(not(feature = \"usb\"))]" => !usb,
                "#[cfg(not(any(feature = \"three-axes\", feature = \"moteus\")))]" => !three && !moteus,
                other => panic!("{folder} has a condition that this test does not know: {other}"),
            };
            (left_out, depth) = (!wanted, 0);
            continue;
        }
        if !left_out {
            for (at, _) in line.match_indices("p.P") {
                let pin: String = line[at + 2..].chars().take_while(char::is_ascii_alphanumeric).collect();
                let is_pin = pin.len() > 2 && pin[2..].chars().all(|sign| sign.is_ascii_digit());
                if is_pin {
                    pins.insert(pin);
                }
            }
        }
        let count = |signs: [char; 3]| line.matches(signs).count() as i32;
        depth += count(['(', '{', '[']) - count([')', '}', ']']);
        if depth <= 0 && (line.ends_with(';') || line.ends_with(',')) {
            left_out = false;
        }
    }
    pins
}

/// The numbers in brackets behind `name` in a source.
fn numbers(source: &str, name: &str) -> Vec<u32> {
    let (_, rest) = source.split_once(name).unwrap_or_else(|| panic!("no {name}"));
    let inside = rest.split_once("= [").unwrap().1.split(']').next().unwrap();
    inside.split(',').map(|number| number.trim().parse().unwrap()).collect()
}

/// Inputs that are converted: the currents', the supply's and the thermistor's.
fn converted(current: &str) -> Vec<u32> {
    assert!(current.contains("= [(pac::ADC1, 0, 5), (pac::ADC2, 8, 3)];"));
    [numbers(current, "const CURRENTS: [u8; AXES]"), vec![5, 3]].concat()
}

#[test]
fn each_pin_that_the_firmware_uses_is_in_the_netlist_and_no_other() {
    let netlist = netlist();
    let current = text("../src/board/current.rs");
    // Converted pins are out of reset what they must be: nothing takes them. Inputs of ADC1 as the chip's data sheet has them.
    let converted: BTreeSet<String> = converted(&current)
        .into_iter()
        .map(|input| match input {
            15 => "PA3",
            10 => "PC0",
            5 => "PB1",
            3 => "PA6",
            other => panic!("which pin is input {other}?"),
        })
        .map(str::to_owned)
        .collect();
    for image in [Image::Two, Image::Three, Image::Moteus, Image::Spi, Image::Usb] {
        let has: BTreeSet<String> =
            netlist.board.pins.iter().filter(|pin| pin.image.has(image)).map(|pin| pin.pin.clone()).collect();
        for folder in BOARDS {
            let mut uses = taken(folder, image);
            if matches!(image, Image::Two | Image::Spi | Image::Usb) {
                uses.extend(converted.clone());
            }
            assert_eq!(has, uses, "{folder}, {image:?}");
        }
    }
    assert_eq!(netlist.board.pins.len(), netlist.board.pins.iter().map(|pin| &pin.pin).collect::<BTreeSet<_>>().len());
}

#[test]
fn conversions_are_of_the_pins_that_carry_them() {
    let netlist = netlist();
    let order = converted(&text("../src/board/current.rs"));
    let nets = netlist.nets("bridges");
    let signals = [("current 1", 1), ("current 2", 1), ("supply over 11", 1), ("thermistor of motor 1", 2)];
    for ((signal, converter), input) in signals.into_iter().zip(order) {
        let net = nets.iter().find(|net| net.name == signal).unwrap();
        let pin = net.pins.iter().find_map(|pin| pin.strip_prefix("N1.")).unwrap();
        let does = &netlist.board.pins.iter().find(|chip| chip.pin == pin).unwrap().does;
        assert_eq!(*does, format!("ADC{converter} input {input}"), "{signal}");
    }
}

#[test]
fn pulls_are_those_that_the_firmware_switches_on() {
    let netlist = netlist();
    let (bridges, encoders, board) =
        (text("../src/board/bridges.rs"), text("../src/board/encoders.rs"), text("../src/board/mod.rs"));
    let pull = |pin: &str| netlist.board.pins.iter().find(|chip| chip.pin == pin).unwrap().pull;
    let said = |source: &str, what: &str| assert!(source.contains(what), "{what}");
    said(&bridges, "stop.set_as_af_unchecked(1, AfType::input(Pull::Down))");
    said(&bridges, "fault.set_as_af_unchecked(1, AfType::input(Pull::Up))");
    said(&bridges, "Input::new(pins.gate, Pull::Down)");
    said(&board, "Input::new(w.strap, Pull::Up)");
    said(&text("../src/board/switch.rs"), "Input::new(pin, Pull::Down)");
    let can = text("../src/board/drive/fdcan.rs");
    said(&can, "rx.set_as_af_unchecked(9, AfType::input(Pull::Up))");
    said(&text("../src/board/spi_encoders.rs"), "from.set_as_af_unchecked(function, AfType::input(Pull::Up))");
    let pulls = [Pull::Down, Pull::Up, Pull::Down, Pull::Up, Pull::Down, Pull::Up, Pull::Up, Pull::Up];
    assert_eq!(["PE15", "PE6", "PD15", "PG12", "PG14", "PD0", "PF8", "PC11"].map(pull), pulls.map(Some));
    // An input that bears 5 V has none.
    assert!(encoders.contains("Pull::None") && !encoders.contains("Pull::Up") && !encoders.contains("Pull::Down"));
    let five = netlist.board.pins.iter().filter(|pin| pin.is == Is::Input && pin.volts == Some(5.0));
    let five: Vec<&str> = five.map(|pin| pin.pin.as_str()).collect();
    assert_eq!(five, ["PC6", "PC7", "PC8", "PD12", "PD13", "PD14", "PB3", "PB10"]);
}

#[test]
fn the_wiring_breaks_no_rule() {
    assert_eq!(rules::wrong(&netlist()), Vec::<String>::new());
}

#[test]
fn each_rule_sees_what_breaks_it() {
    let good = text("netlist.toml");
    for (what, with, says) in [
        // 5 V at a pin that bears no more than 3.3.
        (
            r#"B3 = { kind = "encoder3""#,
            r#"B3 = { kind = "encoder5""#,
            "three: encoder 3, A is driven to 5 V, and N1.PA5 bears 3.3 V",
        ),
        (
            r#"does = "TIM3 channel 1", is = "input", volts = 5.0, pull = "none""#,
            r#"does = "TIM3 channel 1", is = "input", volts = 5.0, pull = "up""#,
            "PC6 has a pull inside the chip",
        ),
        (r#""N1.PE9", "U1.IN1""#, r#""N1.PE9""#, "bridge 1, first leg has 1 ends"),
        (r#""N1.PE9", "U1.IN1""#, r#""N1.PE9", "U1.OUT1", "U1.IN1""#, "N1.PE9 and U1.OUT1 drive each other"),
        (r#""N1.PE6", "U1.nFAULT""#, r#""N1.PE6", "N1.PE9", "U1.nFAULT""#, "drive each other"),
        (r#""N1.PC6", "R11.1", "B1.A""#, r#""N1.PC6", "R11.1""#, "B1.A has no wire"),
        (r#"open = ["PD15"]"#, r#"open = ["PD15", "PE9"]"#, "N1.PE9 is said to be open, and is in bridge 1, first leg"),
        (
            r#""N1.PF3", "R1.1", "U1.nSLEEP", "U2.nSLEEP""#,
            r#""N1.PF3", "U1.nSLEEP", "U2.nSLEEP""#,
            "enable of the bridges: no resistor holds it low",
        ),
        (r#""N1.PE14", "R6.1", "U5.B""#, r#""N1.PE14", "U5.B""#, "gate, second input: no resistor holds it low"),
        (
            r#""N1.PD15", "U5.Y", "A1.ENABLE", "A2.ENABLE"]"#,
            r#""N1.PD15", "U5.Y"]"#,
            "amplifiers: A1.ENABLE has no wire",
        ),
        (
            r#""N1.PF3", "R5.1", "U5.A""#,
            r#""N1.PF3", "R5.1", "A1.ENABLE""#,
            "no gate of PF3 and PE14, seen by PD15, enables the amplifiers",
        ),
        (r#""G1.-", "ST1.2""#, r#""ST1.2""#, "ST1 does not join the ground of the board and that of the supply"),
        (r#""R9.2", "U3.OUT""#, r#""R9.2", "U3.IN-""#, "U3.IN- is in"),
        (r#"for = ["U5"]"#, "for = []", "U5 is on 0 lines of the parts list"),
        (r#"for = ["U5"]"#, r#"for = ["U5", "U9"]"#, "the parts list has U9"),
        (r#""N1.RJ45", "SW1.port1""#, r#""N1.RJ45", "W1.1""#, "a socket meets a bare wire"),
        (r#"[["N1"], ["R31", "R32", "B3", "R33"]]"#, r#"[["N1"], ["R31", "R32", "R33"]]"#, "B3 is on no drawing"),
    ] {
        assert!(good.contains(what), "{what}");
        let wrong = rules::wrong(&Netlist::parse(&good.replacen(what, with, 1)).unwrap());
        assert!(wrong.iter().any(|sentence| sentence.contains(says)), "{with}: {wrong:?}");
    }
}

/// A value as `10 kΩ`, `1000 µF 50 V`, in ohms or farads.
fn value(netlist: &Netlist, part: &str) -> f64 {
    let value = netlist.part[part].value.as_ref().unwrap();
    let mut words = value.split(' ');
    let number: f64 = words.next().unwrap().parse().unwrap();
    number
        * match words.next().unwrap() {
            "mΩ" => 1e-3,
            "kΩ" => 1e3,
            "µF" => 1e-6,
            "nF" => 1e-9,
            unit => panic!("{unit}"),
        }
}

#[test]
fn values_give_what_firmware_and_guide_reckon_with() {
    let netlist = netlist();
    let of = |part| value(&netlist, part);
    // The supply over 11, and within the converter's 3.3 V up to 36 V.
    let share = of("R4") / (of("R3") + of("R4"));
    assert!((1.0 / share - 11.0).abs() < 1e-9);
    let current = text("../src/board/current.rs");
    assert!(current.contains("const SUPPLY_MV: u32 = 3_300 * 11;"));
    // Its filter: above the rail's ripple at 20 kHz, far below the 10 ms of a supply fault.
    let tau_s = of("C2") * of("R3") * share;
    assert!((50e-6..0.001).contains(&tau_s), "{tau_s} s");
    // A thermistor below as much as it has at 25 °C, and a filter faster than the 10 ms of its faults.
    let tau_s = of("C8") * of("R14") / 2.0;
    assert!(of("RT1") == of("R14") && (50e-6..0.002).contains(&tau_s), "{tau_s} s");
    // INA240A1 on its shunt: 0.24 V/A about 1.65 V is 6.875 A either way, as `motor.sense_a` is by default.
    assert!((1.65 / (20.0 * of("RS1")) - 6.875).abs() < 1e-9 && of("RS1") == of("RS2"));
    // With the stop pressed the motors' supply is below 4.5 V within 10 s from the highest that is allowed, 30 V, and 3.7 s from 24 V.
    let seconds = |volts: f64| {
        let parallel = 1.0 / (1.0 / of("R2") + 1.0 / (of("R3") + of("R4")));
        parallel * of("C1") * (volts / 4.5).ln()
    };
    assert!(seconds(30.0) < 10.0, "{}", seconds(30.0));
    assert!((seconds(24.0) - 3.7).abs() < 0.1, "{}", seconds(24.0));
    // What the resistor across them turns to heat at 30 V is less than half of what it bears.
    assert!(30.0_f64.powi(2) / of("R2") < 0.5);
}

/// Nets that a part other than these joins to the supply's plus: fuse, contact, diode or wire, however it is turned.
fn fed(netlist: &Netlist, without: &str) -> BTreeSet<String> {
    let nets = netlist.nets("bridges");
    let leads = |part: &str| matches!(netlist.part[part].kind.as_str(), "fuse" | "contact" | "diode" | "wire");
    let mut fed: BTreeSet<String> = BTreeSet::from(["supply".to_owned()]);
    loop {
        let parts: BTreeSet<&str> = nets
            .iter()
            .filter(|net| fed.contains(&net.name))
            .flat_map(|net| &net.pins)
            .map(|pin| split(pin).0)
            .collect();
        let on = |net: &&cohold_wiring::netlist::Net| {
            let joins = |part: &str| part != without && leads(part) && parts.contains(part);
            net.pins.iter().any(|pin| joins(split(pin).0))
        };
        let next: Vec<String> = nets.iter().filter(on).map(|net| net.name.clone()).collect();
        let before = fed.len();
        fed.extend(next);
        if fed.len() == before {
            return fed;
        }
    }
}

#[test]
fn the_supply_comes_to_the_motors_through_fuse_second_contact_and_diode_alone() {
    let netlist = netlist();
    assert!(fed(&netlist, "").contains("VM"));
    for part in ["F1", "S2", "D1"] {
        assert!(!fed(&netlist, part).contains("VM"), "without {part}");
    }
    // The first contact has no part in it: each does its work without the other.
    assert!(fed(&netlist, "S1").contains("VM") && !fed(&netlist, "").contains("3.3 V"));
}

#[test]
fn drawings_and_tables_are_what_the_netlist_says() {
    let netlist = netlist();
    let pages = page::PAGES.map(|page| text(&format!("../../docs/{page}")));
    assert_eq!(page::filled(pages.clone(), &netlist).unwrap(), pages, "`cargo xtask drawings` writes them");
    for sheet in &netlist.sheet {
        let name = format!("../../docs/{}.svg", sheet.file);
        let drawing = sheet::draw(&netlist, sheet).unwrap();
        assert!(text(&name) == svg::svg(&drawing, &sheet.title), "{name}: `cargo xtask drawings` writes it");
        assert!(pages.concat().contains(&format!("/{}.svg)", sheet.file)), "{} is shown nowhere", sheet.file);
    }
}

type Frame = [f64; 4];

fn frame(text: &Text) -> Frame {
    let left = match text.anchor {
        Anchor::Start => text.x,
        Anchor::Middle => text.x - text.width() / 2.0,
        Anchor::End => text.x - text.width(),
    };
    [left, text.y - 0.75 * text.size, left + text.width(), text.y + 0.2 * text.size]
}

fn meet(one: Frame, two: Frame) -> bool {
    one[0] < two[2] && two[0] < one[2] && one[1] < two[3] && two[1] < one[3]
}

fn around(line: &Line) -> Frame {
    let [(x1, y1), (x2, y2)] = line.ends;
    [x1.min(x2) - 0.7, y1.min(y2) - 0.7, x1.max(x2) + 0.7, y1.max(y2) + 0.7]
}

#[test]
fn a_drawing_is_legible_and_nothing_lies_on_anything() {
    let netlist = netlist();
    for sheet in &netlist.sheet {
        let drawing = sheet::draw(&netlist, sheet).unwrap();
        let (width, height) = drawing.size;
        assert!(width <= sheet::WIDEST, "{}: {width}", sheet.file);
        // On 180 mm of paper letters have 6 pt or more.
        let points = drawing.texts.iter().map(|text| text.size * (180.0 / 25.4 * 72.0) / width.max(1.0));
        assert!(points.fold(f64::MAX, f64::min) >= 6.0, "{}", sheet.file);
        for (number, text) in drawing.texts.iter().enumerate() {
            let here = frame(text);
            let [left, top, right, bottom] = here;
            assert!(left >= 0.0 && top >= 0.0 && right <= width && bottom <= height, "{}: {text:?}", sheet.file);
            for other in &drawing.texts[number + 1..] {
                assert!(!meet(here, frame(other)), "{}: {text:?} and {other:?}", sheet.file);
            }
            for line in &drawing.lines {
                assert!(!meet(here, around(line)), "{}: {text:?} and {line:?}", sheet.file);
            }
        }
    }
}

/// Pins that lines join: those whose ends meet, or whose end is on another one. Lines that cross do not.
fn joined(drawing: &Drawing) -> BTreeSet<BTreeSet<String>> {
    let on = |(x, y): (f64, f64), line: &Line| {
        let [left, top, right, bottom] = around(line);
        left < x && x < right && top < y && y < bottom
    };
    let mut group: Vec<usize> = (0..drawing.lines.len()).collect();
    let touch =
        |one: &Line, two: &Line| one.ends.iter().any(|end| on(*end, two)) || two.ends.iter().any(|end| on(*end, one));
    for one in 0..group.len() {
        for two in 0..one {
            if touch(&drawing.lines[one], &drawing.lines[two]) {
                let (from, to) = (group[one], group[two]);
                group.iter_mut().filter(|of| **of == from).for_each(|of| *of = to);
            }
        }
    }
    let pins = |number: usize| {
        let here = |at: (f64, f64)| (0..group.len()).any(|line| group[line] == number && on(at, &drawing.lines[line]));
        drawing.pins.iter().filter(|(_, at)| here(*at)).map(|(pin, _)| pin.clone()).collect::<BTreeSet<_>>()
    };
    let numbers: BTreeSet<usize> = group.iter().copied().collect();
    numbers.into_iter().map(pins).filter(|pins| pins.len() > 1).collect()
}

#[test]
fn the_lines_of_a_drawing_join_what_the_netlist_joins() {
    let netlist = netlist();
    let mut wires = 0;
    for sheet in &netlist.sheet {
        let here = |pin: &&String| sheet.columns.iter().flatten().any(|part| part == split(pin).0);
        let nets = netlist.nets(&sheet.build);
        let wired = nets.iter().filter(|net| !net.rail);
        let wanted: BTreeSet<BTreeSet<String>> = wired
            .map(|net| net.pins.iter().filter(here).cloned().collect())
            .filter(|pins: &BTreeSet<String>| pins.len() > 1)
            .collect();
        wires += wanted.len();
        assert_eq!(joined(&sheet::draw(&netlist, sheet).unwrap()), wanted, "{}", sheet.file);
    }
    assert!(wires > 40, "{wires}");
}

#[test]
fn every_wire_is_on_a_drawing() {
    let netlist = netlist();
    for build in ["bare", "bridges", "amplifiers", "three", "moteus", "spi"] {
        // Supply, stop and the first two encoders are wired alike in all builds with motors: drawn once.
        let drawn = |part: &str, other: &str| {
            netlist.sheet.iter().any(|sheet| {
                let alike = sheet.build == build || (build != "bare" && sheet.build == "bridges");
                let has = |part: &str| sheet.columns.iter().flatten().any(|of| of == part);
                alike && has(part) && has(other)
            })
        };
        for net in netlist.nets(build).iter().filter(|net| !net.rail) {
            let first = split(&net.pins[0]).0;
            for pin in &net.pins[1..] {
                assert!(
                    drawn(first, split(pin).0),
                    "{build}: {} and {pin} of {} are on no sheet together",
                    net.pins[0],
                    net.name
                );
            }
        }
    }
}

#[test]
fn a_pin_is_read_or_refused() {
    let netlist = netlist();
    let pins = netlist.pins("U1").unwrap();
    assert!(
        pins.contains(&("nSLEEP".to_owned(), Role::In(5.5))) && pins.contains(&("OUT1".to_owned(), Role::Out(37.0)))
    );
    let wrong = text("netlist.toml").replacen("nSLEEP in 5.5", "nSLEEP in", 1);
    assert!(Netlist::parse(&wrong).unwrap().pins("U1").unwrap_err().contains("is not `NAME role volts`"));
}
