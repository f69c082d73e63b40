//! One board alone: it starts, its outputs are off, it answers, it arms and it stops; and what a start leaves in registers that no run of the
//! virtual board shows. The rows become a table in docs/reference/board.md; `COHOLD_BLESS=1` writes it, otherwise it must be there.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::docs;
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::wire::Line;

/// SYSCFG_PWRCR: bit 0 lets the regulator give voltage scale 0, which 480 MHz need and the emulator does not check.
const OVERDRIVE: u64 = 0x5800_042C;

#[test]
fn it_starts_disarmed_and_answers() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    assert!(!bench.stopped[0].bridges.on());
    assert_eq!(bench.peek(1, [OVERDRIVE])[0] & 1, 1);
    let answer = bench.ask(1, "status");
    assert!(answer.starts_with("ok board 1 disarmed fault 0 "), "{answer}");
    let refusal = bench.ask(1, "arm");
    assert!(refusal.starts_with("error check first: "), "{refusal}");
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.run_for_ms(10);
    assert!(bench.stopped[0].bridges.on());
    assert_eq!(bench.ask(1, "disarm"), "ok disarmed");
    bench.run_for_ms(2);
    assert!(!bench.stopped[0].bridges.on());
    reviewed::check_all(&bench.finish());
}

/// Pulls of a port (PUPDR), two bits a pin.
fn pulls(port: char) -> u64 {
    0x5802_000C + 0x400 * (port as u64 - 'A' as u64)
}

/// The pull of each pin of a table, as ST numbers them: 0 none, 1 up, 2 down.
fn pulled(bench: &mut Bench, pins: &[(char, u64)]) -> Vec<u32> {
    let words = bench.peek(1, pins.iter().map(|(port, _)| pulls(*port)));
    words.iter().zip(pins).map(|(word, (_, pin))| word >> (2 * pin) & 3).collect()
}

/// A pin that bears 5 V does so without a pull alone, and PA5 does not bear them at all: encoders' pins have none, in either image. What is
/// off while its wire is cut is pulled that way.
#[test]
fn what_a_start_leaves_in_the_chip() {
    const ENCODERS: [(char, u64); 6] = [('C', 6), ('C', 7), ('C', 8), ('D', 12), ('D', 13), ('D', 14)];
    const THIRD: [(char, u64); 3] = [('A', 5), ('B', 3), ('B', 10)];
    // The stop, the bridges' fault, the amplifiers' gate.
    const WIRES: [(char, u64); 3] = [('E', 15), ('E', 6), ('D', 15)];
    // DBGMCU_APB2FZ1: TIM1; APB3FZ1: WWDG1; APB4FZ1: IWDG1; APB1LFZ1: TIM6; ADC1_JDR1: what a sensor in the middle of its range reads, at a multiple of 2¹².
    const REGISTERS: [u64; 5] = [0x5C00_104C, 0x5C00_1034, 0x5C00_1054, 0x5C00_103C, 0x4002_2080];
    let mut rows = Vec::new();
    for (image, firmware) in
        [("one or two motors", Firmware::release()), ("three", Firmware::with("three-axes").alone())]
    {
        let three = image == "three";
        let mut bench = Bench::start(&Arc::new(firmware), 1, Line::default());
        let encoders = [&ENCODERS[..], if three { &THIRD } else { &[] }].concat();
        assert!(pulled(&mut bench, &encoders).iter().all(|pull| *pull == 0), "{image}: encoders' pins have no pull");
        assert_eq!(pulled(&mut bench, &WIRES), [2, 1, 2], "{image}");
        let words = bench.peek(1, REGISTERS);
        let halt = [words[0] & 1, words[1] >> 6 & 1, words[2] >> 18 & 1, words[3] >> 4];
        assert_eq!(halt, [1; 4], "{image}: TIM1, both watchdogs and TIM6 alone halt with the core");
        rows.push(format!("| {image} | {} pins of encoders | no pull |", encoders.len()));
        rows.push(format!("| {image} | PE15 (stop), PE6 (fault), PD15 (gate) | down, up, down |"));
        rows.push(format!(
            "| {image} | DBGMCU: TIM1, TIM6, WWDG1, IWDG1 | stand still while a debugger halts the core, TIM1 with its outputs off |"
        ));
        if !three {
            // 0x8008 where it was calibrated without linearity, or before its regulator was ready.
            assert_eq!(words[4], 0x8000, "{image}: no code is missing");
            rows.push(format!(
                "| {image} | ADC1 at no current | 0x8000: calibrated with linearity, its regulator ready |"
            ));
        }
        bench.finish();
    }
    docs::table("reference/board.md", "one_board", "| image for motors | of the chip | is |", &rows);
}

/// What lies beside the settings or in data is never executed, and the program is never written over; the fault says that it was refused and
/// not that it was no instruction.
#[test]
fn what_is_no_program_is_not_executed_and_what_is_stays_as_it_is() {
    const BANK_2: u64 = 0x0810_0000;
    // The last words of DTCM, which nothing of the image lies in.
    const DATA: u64 = 0x2001_FFF0;
    // b .
    let ahead = [(BANK_2, 0xE7FE_E7FE), (DATA, 0xE7FE_E7FE)];
    let firmware = Arc::new(Firmware::release());
    // ldr.w pc, [pc] to it; ldr r0, [pc] and str r0, [r0].
    let goes = |to: u64| [0xF000_F8DF, to as u32 | 1];
    // IACCVIOL alone; DACCVIOL, and its address is known.
    for (what, words, cfsr) in [
        ("the bank of settings", goes(BANK_2), "0x1"),
        ("data", goes(DATA), "0x1"),
        ("writing to the program", [0x6000_4800, 0x0800_0000], "0x82"),
    ] {
        let mut bench = Bench::start_with(&firmware, 1, Line::default(), &ahead);
        let supervisor = firmware.address("UART4");
        bench.input(1).poke.extend((supervisor..).step_by(4).zip(words));
        bench.run_for_ms(10);
        assert!(bench.stopped[0].resets > 0, "{what}: at once, and not by a watchdog");
        let sound = [0, 4].map(|offset| (supervisor + offset, firmware.word(supervisor + offset)));
        bench.input(1).poke.extend(sound);
        bench.run_for_ms(1300);
        bench.align(&firmware);
        bench.meet(1);
        let status = bench.ask(1, "status");
        let refused = status.contains("refused an instruction") && status.contains(&format!(", cfsr {cfsr},"));
        assert!(refused, "{what}: {status}");
        bench.finish();
    }
}

/// Why: the time driver began half a round ahead, so that time went back by 65 ms wherever somebody looked at it between the start of a
/// half round and the driver's interrupt. When a tick held that interrupt up and the supervisor looked next, its alarm was that
/// much too late, and both boards were reset by their watchdogs, 7.4 s after they had been armed.
#[test]
fn time_never_goes_back() {
    const HALF_ROUND_US: u64 = 1 << 15;
    const COUNTER: u64 = 0x4000_0C24;
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    let driver = firmware.symbols.iter().find(|(name, _)| name.contains("time_driver") && name.contains("6DRIVER"));
    let (_, (address, size)) = driver.expect("the image has a time driver");
    let words = (*address..address + size).step_by(4);
    // In the middle between two ends of a half round.
    let counter = u64::from(bench.peek_now(1, [COUNTER])[0]);
    bench.run_for_us(2 * HALF_ROUND_US + HALF_ROUND_US / 2 - counter % HALF_ROUND_US);
    let looks: Vec<Vec<u32>> = (0..6)
        .map(|_| {
            bench.run_for_us(HALF_ROUND_US - 1);
            bench.peek_now(1, words.clone().chain([COUNTER]))
        })
        .collect();
    // The one word of it that counts.
    let counts = |word: &usize| looks.windows(2).all(|pair| pair[1][*word] == pair[0][*word] + 1);
    let [halves] = (0..words.count()).filter(counts).collect::<Vec<_>>()[..] else { panic!("{looks:?}") };
    for look in looks {
        let counter = look.last().expect("the counter is the last word");
        assert_eq!(look[halves] % 2, counter >> 15, "{} half rounds, counter {counter:#x}", look[halves]);
    }
}

/// Why: after a reset in mid-run the emulated encoder timers never counted again, and no test had looked.
#[test]
fn a_board_that_started_anew_still_counts() {
    const FOR_EVER: u32 = 0xE7FE_E7FE;
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
    let supervisor = firmware.address("UART4");
    bench.input(1).poke.push((supervisor, FOR_EVER));
    bench.run_for_ms(40);
    bench.input(1).poke.push((supervisor, firmware.word(supervisor)));
    bench.run_for_ms(1300);
    assert_eq!(bench.stopped[0].resets, 1);
    bench.align(&firmware);
    bench.meet(1);
    assert_eq!(bench.ask(1, "clear"), "ok disarmed");
    assert!(bench.ask(1, "arm").starts_with("error check first: "), "a check does not outlive a reset");
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.finish();
}
