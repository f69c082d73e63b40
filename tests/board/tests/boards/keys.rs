//! Who does not hold the key gets nothing: a board without its two, with a broken one, with one for both, without randomness; and
//! whoever holds the peers' key, or none, at the operator's port.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::image::Firmware;
use board_bench::node::{Inputs, Node};
use board_bench::pc::{Pc, board_ip, board_mac, in_key_sector, keys_in_flash, operator_key, peers_key, resolved, udp};
use board_bench::wire::{Line, PC, Wire};
use board_bench::{log, reviewed};
use cohold_board_tools::operator::{PORT, Session};
use cohold_protocol::key::Key;
use cohold_protocol::wire::MAX_DATAGRAM;

/// What a board that starts with this flash sends in 2 s while the PC asks for its address and calls; and whether the PC's
/// session is answered. `works`: its noise source.
fn start(firmware: &Arc<Firmware>, flash: Vec<(u64, u32)>, works: bool) -> (usize, bool, Vec<String>) {
    let node = Node::new(firmware.clone(), 1);
    let noise = (!works).then_some(false);
    let (mut wire, mut pc) = (Wire::new(Line::default()), Pc::default());
    let mut inputs = Inputs { poke: flash, noise, ..Inputs::default() };
    let mut frames = 0;
    for ms in 1..2000_u64 {
        let now = 1_000_000 * ms;
        node.run(now, std::mem::take(&mut inputs));
        let stopped = node.wait();
        assert!(!stopped.bridges.on() && stopped.resets == 0);
        frames += stopped.frames.len();
        for (at, frame) in &stopped.frames {
            wire.send(0, *at, frame);
        }
        for frame in wire.receive(PC, now) {
            pc.hear(now, &frame).into_iter().for_each(|answer| wire.send(PC, now, &answer));
        }
        if ms % 100 == 0 {
            wire.send(PC, now, &Pc::resolve(1));
        }
        pc.talk(now, 1).iter().for_each(|frame| wire.send(PC, now, frame));
        inputs.frames = wire.receive(0, now);
    }
    let mut now = 2_000_000_000;
    let log = log::read(firmware, |peek| {
        node.run(now, Inputs::default());
        node.wait();
        node.run(now + 1000, Inputs { peek, ..Inputs::default() });
        now += 2000;
        node.wait().peeked
    });
    reviewed::check(&node.finish());
    (frames, pc.reaches(1), log)
}

/// The sector as a version before wrote it for [`peers_key`]: its one image, and the first word of the count of starts.
fn single() -> Vec<(u64, u32)> {
    const TAG: [u8; 16] =
        [0xA8, 0xF5, 0x46, 0xFE, 0x31, 0xF3, 0x87, 0x3F, 0x3B, 0xED, 0x9A, 0x97, 0x31, 0x30, 0x78, 0xFF];
    in_key_sector(&[&b"haptkey1"[..], &[0; 8], &TAG, peers_key().bytes(), &[0; 32]].concat())
}

#[test]
fn without_key_or_randomness_a_board_says_nothing_at_all() {
    let firmware = Arc::new(Firmware::release());
    let both = || keys_in_flash(&peers_key(), &operator_key());
    let (frames, reached, _) = start(&firmware, both(), true);
    assert!(frames > 20 && reached, "with both it talks: {frames} frames");
    let broken = |word: usize| {
        let mut flash = both();
        flash[word].1 ^= 1 << 5;
        flash
    };
    /// Words of one key's image.
    const ONE: usize = Key::IMAGE / 4;
    let same = keys_in_flash(&operator_key(), &operator_key());
    for (what, flash, works, why) in [
        ("flash was never written", Vec::new(), true, "no peers' key: this board talks to nobody and cannot be armed"),
        ("one bit of the peers' key is wrong", broken(9), true, "no peers' key: this board talks to nobody"),
        (
            "one bit of the operator's key is wrong",
            broken(ONE + 9),
            true,
            "no operator's key: this board talks to nobody",
        ),
        (
            "it was given the peers' key alone",
            both()[..ONE].to_vec(),
            true,
            "no operator's key: this board talks to nobody",
        ),
        (
            "a version before gave it one key",
            single(),
            true,
            "one key for peers and operator, of a version before: this board talks to nobody",
        ),
        ("both are the same", same, true, "peers' key and operator's are the same: this board talks to nobody"),
        ("the noise source fails", both(), false, "no randomness: this board talks to nobody"),
    ] {
        let (frames, reached, log) = start(&firmware, flash, works);
        assert_eq!((frames, reached), (0, false), "{what}");
        assert!(log.iter().any(|said| said.starts_with(why)), "{what}: {log:#?}");
    }
}

/// Why: one key made both links, so that the other peer, or who owns the hub, could arm a board and raise its limits.
/// Somebody on the path sends a copy of all that the operator says, from his own address, before it arrives: he is sent nothing but what he paid
/// for, and the operator's records go on coming to the operator.
#[test]
fn a_copy_that_comes_first_takes_no_records_away() {
    const THERE: u16 = 5555;
    // What leaves the other port is there as soon as what leaves the PC's, and before it if it left before.
    let line = Line { delay_ns: 0, ..Line::default() };
    let mut bench = Bench::start(&Arc::new(Firmware::release()), 1, line);
    assert_eq!(bench.ask(1, "stream 1"), "ok every 1 ticks");
    bench.run_for_ms(200);
    let (mut paid, mut got, before) = (0, 0, bench.pc.records[0].len());
    for _ in 0..500 {
        let now_ns = bench.now_ns();
        bench.pc.away = false;
        for frame in bench.pc.talk(now_ns, 1) {
            let copy = udp((board_mac(2), board_ip(2), THERE), (board_mac(1), board_ip(1), PORT), &frame[42..]);
            paid += copy.len();
            bench.wire.send(1, now_ns, &copy);
            bench.wire.send(PC, now_ns, &frame);
        }
        bench.pc.away = true;
        bench.step();
        let now_ns = bench.now_ns();
        for frame in bench.wire.receive(1, now_ns) {
            if let Some(answer) = resolved(&frame, board_mac(2), board_ip(2)) {
                bench.wire.send(1, now_ns, &answer);
            } else if frame[30..34] == board_ip(2) && frame[36..38] == THERE.to_be_bytes() {
                got += frame.len();
            }
        }
    }
    let came = bench.pc.records[0].len() - before;
    assert!(paid > 1000 && got <= paid, "{got} bytes for {paid}");
    assert!(came > 400, "{came} records of 500");
}

#[test]
fn who_holds_the_peers_key_is_no_operator() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
    for line in ["arm", "set safety.max_force_n 200", "disarm", "status"] {
        let operator = std::mem::replace(&mut bench.pc, Pc::holding(&peers_key()));
        bench.pc.say(1, line);
        // Until the board knows that its operator has gone.
        bench.run_for_ms(1500);
        for _ in 0..1000 {
            bench.step();
            // It calls the operator that it had, and answers nobody: every datagram of the port's is a hello.
            let of_port = |frame: &[u8]| frame.get(34..36) == Some(&7702_u16.to_be_bytes());
            assert!(bench.stopped[0].frames.iter().all(|(_, frame)| !of_port(frame) || frame.get(43) == Some(&1)));
        }
        // It refuses by itself to start what it has not heard of.
        let answers: Vec<_> = bench.pc.answers[0].iter().filter(|_| line != "arm").collect();
        assert!(!bench.pc.reaches(1) && answers.is_empty(), "{line:?}: {answers:?}");
        assert!(!bench.stopped[0].bridges.on(), "{line:?}");
        bench.pc = operator;
        bench.meet(1);
        assert!(bench.ask(1, "status").starts_with("ok board 1 disarmed fault 0"), "{line:?}");
        assert_eq!(bench.ask(1, "get safety.max_force_n"), "ok safety.max_force_n = 3");
    }
    // Its operator can.
    assert_eq!(bench.ask(1, "set safety.max_force_n 2"), "ok safety.max_force_n = 2");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    bench.finish();
}

#[test]
fn a_stranger_gets_no_answer_and_changes_nothing() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 1, Line::default());
    bench.tell_of_amplifiers(1);
    bench.check(1).expect("it passes");
    assert_eq!(bench.ask(1, "arm"), "ok armed");
    let told = |bench: &mut Bench| {
        let status = bench.ask(1, "status");
        let words: Vec<&str> = status.split([' ', ';']).collect();
        let at = words.iter().position(|word| *word == "refused").expect("a status counts refusals");
        words[at + 1].parse::<u64>().expect("a count")
    };
    let before = told(&mut bench);
    // The operator of yesterday: everything right but the key. Then the text of the port as it once was, and noise.
    let mut stranger = Session::new(Key::new([0x5A; Key::LEN]), 1, [1; Key::LEN]).expect("a good key, to itself");
    stranger.say("disarm");
    let mut sent = 0;
    for ms in 0..500_u64 {
        let mut say = |payload: &[u8]| {
            let from = ([2, 0, 0, 0, 0, 0x66], [192, 168, 77, 66], 40_000);
            bench.input(1).frames.push(udp(from, (board_mac(1), board_ip(1), 7702), payload));
            sent += 1;
        };
        let mut out = [0; MAX_DATAGRAM];
        while let Some(length) = stranger.poll(1000 * ms, &mut out) {
            say(&out[..length]);
        }
        if ms % 50 == 0 {
            say(b"disarm");
            say(&[ms as u8; 124]);
        }
        bench.step();
        assert!(bench.stopped[0].bridges.on(), "a stranger disarmed it");
        // Nobody at the stranger's address is ever looked for.
        assert!(bench.stopped[0].frames.iter().all(|(_, frame)| frame.get(38..42) != Some(&[192, 168, 77, 66])));
    }
    assert!(sent > 30);
    assert_eq!(told(&mut bench) - before, sent, "every one was refused");
    bench.finish();
}

/// Two multiplications a side are 1.35 million instructions each: the tick goes on meanwhile, and they are done soon after the PHY's link
/// is seen, for which it is asked every 500 ms. The first time is after the converter was calibrated, which takes 5.2 ms.
#[test]
fn two_boards_have_met_when_a_second_has_passed() {
    let firmware = Arc::new(Firmware::release());
    let mut bench = Bench::start(&firmware, 2, Line::default());
    while bench.now_ns() < 1_076_000_000 {
        bench.step();
    }
    for number in 1..=2 {
        let status = bench.ask(number, "status");
        assert!(status.contains("link idle") || status.contains("link running"), "{status}");
    }
    // A second after the first tick, and the PC has met both and been answered.
    assert!(bench.now_ns() < 1_100_000_000, "asked at {} ns", bench.now_ns());
    reviewed::check_all(&bench.finish());
}
