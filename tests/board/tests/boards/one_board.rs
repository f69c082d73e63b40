//! One board alone: it starts, its outputs are off, it answers, it arms and it stops.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::reviewed;
use board_bench::wire::Line;

/// SYSCFG_PWRCR: bit 0 lets the regulator give voltage scale 0, which 480 MHz need and the emulator does not check.
const OVERDRIVE: u64 = 0x5800_042C;
/// Pulls of ports C and D: two bits a pin. Pins 6 to 8 and 12 to 14 are the encoders', which may be at 5 V.
const PULLS: [u64; 2] = [0x5802_080C, 0x5802_0C0C];

#[test]
fn it_starts_disarmed_and_answers() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    assert!(!bench.stopped[0].bridges.on());
    assert_eq!(bench.peek(1, [OVERDRIVE])[0] & 1, 1);
    let pulls = bench.peek(1, PULLS);
    assert_eq!((pulls[0] >> 12 & 0x3F, pulls[1] >> 24 & 0x3F), (0, 0), "encoders' pins have no pull");
    let answer = bench.ask(1, "status");
    assert!(answer.starts_with("ok board 1 disarmed fault 0 "), "{answer}");
    let refusal = bench.ask(1, "arm");
    assert!(refusal.starts_with("error check first: "), "{refusal}");
    bench.tell_of_amplifiers(1);
    assert_eq!(bench.check(1).map_err(|why| why.to_string()), Ok(()));
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.run_for_ms(10);
    assert!(bench.stopped[0].bridges.on());
    assert_eq!(bench.ask(1, "disarm"), "ok disarmed");
    bench.run_for_ms(2);
    assert!(!bench.stopped[0].bridges.on());
    for report in bench.finish() {
        assert_eq!(report.resets, Vec::<String>::new());
        reviewed::check(&report);
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
    assert_eq!(bench.check(1).map_err(|why| why.to_string()), Ok(()));
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
    assert_eq!(bench.check(1).map_err(|why| why.to_string()), Ok(()));
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.finish();
}
