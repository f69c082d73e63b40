//! Lines of text over links that lose.

use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::lease::Word;
use cohold_protocol::lines::{LONGEST, Lines};
use cohold_protocol::link::{Config, Link};
use cohold_protocol::parameters::Parameters;
use cohold_protocol::wire::{MAX_DATAGRAM, PeerId};

fn link(local: u8, remote: u8) -> Link {
    Link::new(Config {
        key: Key::new([7; 32]),
        ends: Ends { local: PeerId(local), remote: PeerId(remote) },
        packet_period_us: 20_000,
        parameters: Parameters::new(),
        entropy: [local; 32],
    })
    .unwrap()
}

/// What either end hears in 20 s, every `lose`-th datagram lost.
fn talk(texts: [&[&str]; 2], lose: usize) -> [Vec<String>; 2] {
    let mut links = [link(1, 2), link(2, 1)];
    let mut lines = [Lines::default(), Lines::default()];
    let (mut heard, mut left) = ([Vec::new(), Vec::new()], texts.map(|texts| texts.iter()));
    let mut count = 0;
    for now in (0..20_000_000).step_by(5_000) {
        for end in 0..2 {
            if !lines[end].is_saying()
                && let Some(text) = left[end].next()
            {
                assert!(lines[end].say(text, Word::default()) && !lines[end].say("one at a time", Word::default()));
            }
            lines[end].push(&mut links[end]);
            let mut out = [0; MAX_DATAGRAM];
            while let Some(len) = links[end].poll(now, &mut out) {
                count += 1;
                if count % lose != 0 {
                    let _ = links[1 - end].receive(now, &mut out[..len]);
                }
            }
            while let Some(line) = lines[end].hear(now, &mut links[end]) {
                heard[end].push(line.line.to_string());
            }
        }
    }
    heard
}

#[test]
fn lines_arrive_whole_once_and_in_order_whatever_is_lost() {
    let long = "set every key there is to its default, please: ".repeat(8);
    let (questions, answers) =
        ([&*long, "", "three µ of 48 bytes and more, so that one is split: µµµµµµ"], ["ok", &*long]);
    for lose in [usize::MAX, 5, 3] {
        let [answered, asked] = talk([&questions, &answers], lose);
        assert_eq!(asked, questions);
        assert_eq!(answered, answers);
    }
}

#[test]
fn what_is_too_long_is_cut_at_a_whole_character() {
    let text = "µ".repeat(LONGEST);
    let [_, asked] = talk([&[&text], &[]], usize::MAX);
    assert_eq!(asked, ["µ".repeat(LONGEST / 2)]);
}
