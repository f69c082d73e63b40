//! A board that talks by USB in place of Ethernet: a PC finds a network card and a serial port; it holds one cube with a board on Ethernet, bit for
//! bit what cohold computes; its cable out is a cable out; and what reads its serial port, or has opened it and does not, holds nobody.

use std::sync::Arc;

use board_bench::bench::Bench;
use board_bench::cost::MedianAndMost;
use board_bench::image::Firmware;
use board_bench::node::{Inputs, Node};
use board_bench::part::usb::host::{Found, Reader};
use board_bench::pc::{board_ip, board_mac, udp};
use board_bench::twin::{self, Equal};
use board_bench::wire::Line;
use board_bench::{reviewed, trial};
use cohold_core::safety::Mode;

use crate::breaks;

/// The bit that a board's address and its PC's differ by, in the first byte.
const PC: u8 = 1 << 2;

#[test]
fn a_pc_finds_a_network_card_and_a_serial_port_which_says_why_it_is_not_armed() {
    let firmware = Arc::new(Firmware::with("usb"));
    let mut bench = Bench::start(&firmware, 1, Line::default());
    let mut mac = board_mac(1);
    mac[0] ^= PC;
    let found = Found { vendor_product: (0x1209, 1), mac, block: 2048, times: 1 };
    assert_eq!(bench.stopped[0].found, Some(found));
    assert!(bench.ask(1, "status").starts_with("ok board 1 disarmed fault 0 "));

    // Nobody has opened the port; somebody does, and reads.
    let read = |bench: &mut Bench, ms: usize| {
        let text: Vec<u8> = (0..ms)
            .flat_map(|_| {
                bench.step();
                std::mem::take(&mut bench.stopped[0].serial)
            })
            .collect();
        String::from_utf8(text).expect("text")
    };
    assert_eq!(read(&mut bench, 1500), "");
    bench.input(1).reader = Some(Reader::Reads);
    let said = read(&mut bench, 2500);
    let first = said.lines().next().unwrap_or_default();
    println!("{said}");
    assert!((2..=3).contains(&said.lines().count()), "once a second: {said}");
    assert!(first.starts_with("not to be armed: check first: ") && first.contains("ok board 1 disarmed"), "{first}");
    assert!(first.ends_with("started: power came on"), "{first}");

    // Who does not read holds nobody; when he reads again, he is told what is now.
    bench.input(1).reader = Some(Reader::Stuck);
    bench.input(1).press = Some(true);
    bench.run_for_ms(3000);
    assert!(bench.ask(1, "status").starts_with("ok board 1 disarmed"));
    bench.input(1).reader = Some(Reader::Reads);
    let said = read(&mut bench, 2500);
    assert!(said.contains("not to be armed: the emergency stop is pressed, or not connected; "), "{said}");
    reviewed::check_all(&bench.finish());
}

#[test]
fn a_board_without_keys_says_so_at_its_serial_port_and_nothing_to_the_network() {
    let node = Node::new(Arc::new(Firmware::with("usb")), 1);
    let (mut said, mut frames) = (Vec::new(), 0);
    let mut inputs = Inputs { reader: Some(Reader::Reads), ..Inputs::default() };
    for ms in 1..3000 {
        node.run(1_000_000 * ms, std::mem::take(&mut inputs));
        let stopped = node.wait();
        said.extend(stopped.serial);
        frames += stopped.frames.len();
    }
    let said = String::from_utf8(said).expect("text");
    assert!(said.starts_with("no peers' key: this board talks to nobody and cannot be armed\r\n"), "{said}");
    assert_eq!(frames, 0);
    reviewed::check(&node.finish());
}

/// The driver copies a frame, as long as the PC says that it is, to where it is taken from.
#[test]
fn a_pc_that_sends_longer_frames_than_ethernet_has_disturbs_nothing() {
    let mut bench = Bench::start(&Arc::new(Firmware::with("usb")), 1, Line::default());
    let block = bench.stopped[0].found.as_ref().expect("the PC has found it").block;
    bench.count_instructions();
    // The last one fills its block, with 28 bytes that say where it is.
    let lengths = [1515, 2000, block - 28];
    for length in lengths {
        let frame = udp(
            ([2, 0, 0, 0, 0, 0x66], [192, 168, 77, 66], 7701),
            (board_mac(1), board_ip(1), 9),
            &vec![0x55; length - 42],
        );
        assert_eq!(frame.len(), length);
        bench.input(1).frames.push(frame);
        bench.run_for_ms(10);
    }
    assert_eq!(bench.meters[0].began.len(), 10 * lengths.len(), "every tick came");
    assert!(bench.ask(1, "status").starts_with("ok board 1 disarmed fault 0 "));
    reviewed::check_all(&bench.finish());
}

#[test]
fn it_holds_one_cube_with_a_board_on_ethernet_and_its_cable_out_is_a_cable_out() {
    // The operator is on the same cable: his lease outlasts it.
    let scene = breaks::scene(&["safety.operator_lost_s=1.5"]);
    let images = [Firmware::release(), Firmware::with("usb").alone()].map(Arc::new);
    let mut bench = Bench::mixed(&images, trial::line(&scene).expect("a wire can do it"));
    bench.set_up(&scene).expect("the boards take the scene");
    bench.arm();
    bench.count_instructions();
    bench.run_for_ms(1500);
    let instructions = [0, 1].map(|board| MedianAndMost::of(bench.meters[board].ticks.iter().copied()));
    println!("by Ethernet {:?}, by USB {:?}", instructions[0], instructions[1]);
    assert_eq!((instructions[0].median, instructions[0].max), (instructions[1].median, instructions[1].max));

    bench.input(2).cable = Some(false);
    bench.run_for_ms(400);
    assert!(bench.ask(1, "status").contains("link calling"));
    assert!(bench.stopped.iter().all(|stopped| stopped.bridges.on()), "both render alone");
    assert_eq!(bench.stopped[1].found, None);
    bench.input(2).cable = Some(true);
    bench.run_for_ms(2500);
    bench.meet(2);
    assert_eq!(bench.stopped[1].found.as_ref().map(|found| found.times), Some(2));
    let status = bench.ask(2, "status");
    assert!(status.contains("ok board 2 armed") && status.contains("link running"), "{status}");
    let log = bench.log(&images[1], 2);
    let mut said = log.iter();
    for line in ["peer: fading, no flow", "peer: disengaged", "peer: lost", "peer: joined", "peer: engaged"] {
        assert!(said.any(|said| said.starts_with(line)), "{line:?} is not in its place: {log:#?}");
    }
    assert!(log.iter().any(|said| said.contains("link_up")), "the log tells of the link: {log:#?}");

    // Board 1 had its cable all along; of board 2 what came before is whole.
    for number in 1..=2 {
        let records = bench.armed_ticks(number);
        let whole = records.windows(2).take_while(|two| two[1].tick() == two[0].tick() + 1).count() + 1;
        assert!(whole >= if number == 1 { records.len() } else { 1400 }, "{whole} of {}", records.len());
        let records = &records[..whole];
        assert!(records.iter().all(|record| record.mode() == Mode::Armed), "it stayed armed");
        let equal = twin::replay(&scene.peers()[number - 1], records);
        assert_eq!(equal, Equal { ticks: whole as u64, first_difference: None });
        let forces =
            records.windows(2).map(|two| (two[1].observed().contact_force - two[0].observed().contact_force).abs());
        let allowed = (0.001 * scene.peer.safety.max_slew_n_per_s) as f32;
        assert!(forces.fold(0.0, f32::max) < 0.02 * allowed, "nothing jerks");
    }
    reviewed::check_all(&bench.finish());
}
