//! A source of noise that gives the same at every start repeats no key and no nonce.

use std::collections::HashSet;

use cohold_protocol::ends::Ends;
use cohold_protocol::key::Key;
use cohold_protocol::link::{Config, Link};
use cohold_protocol::parameters::Parameters;
use cohold_protocol::wire::{Flow, Header, MAX_DATAGRAM, PeerId};
use firmware_parts::hedge::Sources;
use firmware_parts::history::{FIRST, History, MOST};
use firmware_parts::keys::Keys;
use firmware_parts::status::Stop;
use firmware_parts::store::{SECTOR, Word};

/// The keys' sector: their images, and behind them nothing.
fn sector() -> Vec<Option<Word>> {
    (0..SECTOR).map(|at| Some(if at < FIRST { [0x11; 32] } else { [0xFF; 32] })).collect()
}

/// One start; flash that takes what it is given, if it does.
fn start(flash: &mut [Option<Word>], takes: bool) -> u32 {
    let mut history = History::open(|at| flash[at as usize]);
    if let Some((at, word)) = history.start(Stop::PowerOn) {
        assert_eq!(flash[at as usize], Some([0xFF; 32]), "word {at} is not blank");
        flash[at as usize] = if takes { Some(word) } else { Some([0xFF; 32]) };
    }
    history.used
}

#[test]
fn every_start_has_a_number_of_its_own_while_there_is_room() {
    let mut flash = sector();
    for number in 1..=MOST {
        assert_eq!(start(&mut flash, true), number);
    }
    assert_eq!((start(&mut flash, true), start(&mut flash, true)), (MOST, MOST));
    assert_eq!(flash[..FIRST as usize], sector()[..FIRST as usize], "the keys are as they were");
}

#[test]
fn a_word_that_is_lost_counts_and_one_that_was_not_taken_does_not() {
    let mut flash = sector();
    assert_eq!(start(&mut flash, true), 1);
    flash[FIRST as usize] = None;
    assert_eq!(start(&mut flash, true), 2);
    assert_eq!((start(&mut flash, false), start(&mut flash, true)), (3, 3));
}

fn link(keys: &Keys, board: u8, boot: u32) -> Link {
    // All that a draw right after the start would find, but for the number of the start.
    let sources = Sources { noise: [0xA5; 32], board, boot, draw: 0, uptime_us: 12_345 };
    Link::new(Config {
        key: keys.peers.clone(),
        ends: Ends { local: PeerId(board), remote: PeerId(3 - board) },
        packet_period_us: 8_000,
        parameters: Parameters::new(),
        entropy: sources.mixed(&keys.seed()),
    })
    .expect("a sound configuration")
}

#[test]
fn constant_noise_repeats_no_key_and_no_nonce_from_start_to_start() {
    let keys = Keys { peers: Key::new([7; 32]), operator: Key::new([8; 32]) };
    let mut flashes = [sector(), sector()];
    let (mut greetings, mut nonces, mut sessions) = (HashSet::new(), HashSet::new(), HashSet::new());
    for _ in 0..50 {
        let boots = flashes.each_mut().map(|flash| start(flash, true));
        let mut links = [link(&keys, 1, boots[0]), link(&keys, 2, boots[1])];
        let mut out = [0; MAX_DATAGRAM];
        let mut ephemerals = HashSet::new();
        for now in (0..400_000).step_by(4_000) {
            for from in 0..2 {
                let mut len = links[from].send(now, Flow::default(), &mut out);
                while let Some(sent) = len.or_else(|| links[from].poll(now, &mut out)) {
                    len = None;
                    if out[1] == Header::KIND {
                        assert!(nonces.insert(out[2..16].to_vec()), "session and number once more: {:?}", &out[..16]);
                    } else {
                        ephemerals.insert(out[48..80].to_vec());
                    }
                    let _ = links[1 - from].receive(now, &mut out[..sent]);
                }
            }
        }
        let number = links[0].session_number().expect("they have met");
        assert_eq!(links[1].session_number(), Some(number));
        assert!(sessions.insert(number));
        for ephemeral in ephemerals {
            assert!(greetings.insert(ephemeral), "an ephemeral of an earlier start, or of the other board");
        }
    }
    assert!(nonces.len() > 5_000);
}

#[test]
fn every_source_makes_a_difference() {
    let keys = |peers, operator| Keys { peers: Key::new([peers; 32]), operator: Key::new([operator; 32]) }.seed();
    let (seed, same) = (keys(7, 8), Sources { noise: [1; 32], board: 0, boot: 1, draw: 0, uptime_us: 5 });
    let all = [
        same,
        Sources { noise: [2; 32], ..same },
        Sources { board: 1, ..same },
        Sources { boot: 2, ..same },
        Sources { draw: 1, ..same },
        Sources { uptime_us: 6, ..same },
    ];
    // A board that is given keys anew begins its count anew: either key makes a difference, too.
    let anew = [keys(9, 8), keys(7, 9), keys(8, 7), Key::new([7; 32]), Key::new([8; 32])];
    let drawn: HashSet<_> =
        all.iter().map(|sources| sources.mixed(&seed)).chain(anew.iter().map(|seed| same.mixed(seed))).collect();
    assert_eq!(drawn.len(), all.len() + anew.len());
}
