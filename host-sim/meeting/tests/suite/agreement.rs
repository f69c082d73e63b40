//! The agreement: one key, once, for ten minutes, and for nobody who guesses, repeats or comes second.

use std::time::{Duration, Instant};

use haptic_meeting::Error;
use haptic_meeting::agreement::{Accepter, Heard, Inviter, LIFE};
use haptic_meeting::invite::Invite;
use haptic_protocol::key::Key;

fn ends(seed: u8) -> (Invite, Inviter, Accepter, Instant) {
    let (invite, now) = (Invite::new("203.0.113.1:4000", &Key::new([seed; 32])), Instant::now());
    let read = Invite::parse(&invite.link()).expect("a link");
    let inviter = Inviter::new(&invite, &Key::new([seed + 1; 32]), now);
    let accepter = Accepter::new(&read, &Key::new([seed + 2; 32]));
    (invite, inviter, accepter, now)
}

#[test]
fn both_ends_come_to_one_key_and_another_each_time() {
    let mut keys = Vec::new();
    for seed in [1, 1, 2] {
        let (invite, _, accepter, now) = ends(seed);
        // Another run of the inviter draws another ephemeral.
        let mut inviter = Inviter::new(&invite, &Key::new([100 + keys.len() as u8; 32]), now);
        let (answer, heard) = inviter.hear(now, &accepter.offer());
        let key = accepter.hear(&answer.expect("an answer")).expect("it is not used").expect("a key");
        assert_eq!(heard, Heard::Agreed(key.clone()));
        assert!(!keys.contains(&key), "a key of its own");
        keys.push(key);
    }
}

#[test]
fn an_answer_that_was_lost_is_given_again() {
    let (_, mut inviter, accepter, now) = ends(1);
    let first = inviter.hear(now, &accepter.offer()).0;
    let (again, heard) = inviter.hear(now + 2 * LIFE, &accepter.offer());
    assert_eq!((again, heard), (first, Heard::Nothing), "ten minutes are for who has not come");
}

#[test]
fn a_stolen_link_is_good_for_nothing_after_use() {
    let (invite, mut inviter, accepter, now) = ends(1);
    inviter.hear(now, &accepter.offer());
    let thief = Accepter::new(&invite, &Key::new([66; 32]));
    let (refusal, heard) = inviter.hear(now, &thief.offer());
    assert_eq!(heard, Heard::Second);
    assert_eq!(thief.hear(&refusal.expect("a refusal")), Err(Error::Used));
    // It tells the partner nothing, whose the refusal is not.
    assert_eq!(accepter.hear(&refusal.expect("a refusal")), Ok(None));
}

#[test]
fn who_was_quicker_with_a_stolen_link_is_known_to_both() {
    let (invite, mut inviter, accepter, now) = ends(1);
    let thief = Accepter::new(&invite, &Key::new([66; 32]));
    assert!(matches!(inviter.hear(now, &thief.offer()).1, Heard::Agreed(_)));
    let (refusal, heard) = inviter.hear(now, &accepter.offer());
    assert_eq!((accepter.hear(&refusal.expect("a refusal")), heard), (Err(Error::Used), Heard::Second));
}

#[test]
fn three_guesses_are_the_end_of_it() {
    let (_, mut inviter, accepter, now) = ends(1);
    for tried in 1..=3 {
        assert_eq!(inviter.over(now), None);
        let guess = Accepter::new(&Invite::new("203.0.113.1:4000", &Key::new([70 + tried; 32])), &Key::new([9; 32]));
        assert_eq!(inviter.hear(now, &guess.offer()), (None, Heard::Wrong(tried)));
    }
    assert_eq!(inviter.over(now), Some(Error::Guessed));
    assert_eq!(inviter.hear(now, &accepter.offer()), (None, Heard::Nothing), "not for the right one either");
}

#[test]
fn an_invite_lives_ten_minutes() {
    let (_, mut inviter, accepter, now) = ends(1);
    assert_eq!(inviter.over(now + LIFE - Duration::from_millis(1)), None);
    assert_eq!(inviter.over(now + LIFE), Some(Error::Over));
    assert_eq!(inviter.hear(now + LIFE, &accepter.offer()), (None, Heard::Nothing));
}

#[test]
fn no_bit_of_offer_or_answer_can_be_changed() {
    let (invite, _, accepter, now) = ends(1);
    let offer = accepter.offer();
    for bit in 0..8 * offer.len() {
        let mut forged = offer;
        forged[bit / 8] ^= 1 << (bit % 8);
        let mut inviter = Inviter::new(&invite, &Key::new([2; 32]), now);
        assert_eq!(inviter.hear(now, &forged).0, None, "bit {bit}");
    }
    let answer = Inviter::new(&invite, &Key::new([2; 32]), now).hear(now, &offer).0.expect("an answer");
    for bit in 0..8 * answer.len() {
        let mut forged = answer;
        forged[bit / 8] ^= 1 << (bit % 8);
        // X25519 does not read the highest bit of a public key; the tag does.
        assert_eq!(accepter.hear(&forged), Ok(None), "bit {bit}");
    }
}

#[test]
fn a_public_key_that_leaves_no_choice_is_no_answer() {
    let (_, mut inviter, accepter, now) = ends(1);
    let answer = inviter.hear(now, &accepter.offer()).0.expect("an answer");
    for point in [[0; 32], {
        let mut one = [0; 32];
        one[0] = 1;
        one
    }] {
        let mut forged = answer;
        forged[2..34].copy_from_slice(&point);
        assert_eq!(accepter.hear(&forged), Ok(None));
    }
}
