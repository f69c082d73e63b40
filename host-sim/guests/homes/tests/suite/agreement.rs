//! The agreement: one key, once, for ten minutes, and for nobody who guesses, repeats, comes second or stands between.

use std::time::{Duration, Instant};

use cohold_homes::Error;
use cohold_homes::agreement::{Accepter, Heard, Inviter, LEN, LIFE, code};
use cohold_homes::invite::Invite;
use cohold_protocol::cipher::Cipher;
use cohold_protocol::key::{Key, NONCE_LEN};

const MEET: &str = "203.0.113.1:4000";

fn ends(seed: u8) -> (Invite, Inviter, Accepter, Instant) {
    let now = Instant::now();
    let inviter = Inviter::new(MEET, &Key::new([seed; 32]), now);
    let invite = Invite::parse(&inviter.invite.link()).expect("a link");
    let accepter = Accepter::new(&invite, &Key::new([seed + 2; 32]));
    (invite, inviter, accepter, now)
}

/// The key that both come to.
fn agreed(inviter: &mut Inviter, accepter: &Accepter, now: Instant) -> Key {
    let (answer, heard) = inviter.hear(now, &accepter.offer());
    let key = accepter.hear(&answer.expect("an answer")).expect("it is not used").expect("a key");
    assert_eq!(heard, Heard::Agreed(key.clone()));
    key
}

#[test]
fn both_ends_come_to_one_key_and_another_each_time() {
    let mut keys = Vec::new();
    for (invites, accepts) in [(1, 1), (1, 2), (2, 1), (2, 2)] {
        let (invite, mut inviter, _, now) = ends(invites);
        let key = agreed(&mut inviter, &Accepter::new(&invite, &Key::new([100 + accepts; 32])), now);
        assert!(!keys.contains(&key), "a key of its own");
        keys.push(key);
    }
    let codes: std::collections::HashSet<_> = keys.iter().map(code).collect();
    assert_eq!(codes.len(), keys.len(), "another code for each: {codes:?}");
    let is_digits = |code: &String| code.len() == 7 && code.replace(' ', "").parse::<u32>().is_ok();
    assert!(codes.iter().all(is_digits), "{codes:?}");
}

/// A thief who has only read the link takes the place of the accepter, but the accepter takes no answer of his, even one under the link's secret.
#[test]
fn who_has_read_the_link_cannot_answer_for_the_inviter() {
    let (invite, mut inviter, accepter, now) = ends(1);
    let thief = Accepter::new(&invite, &Key::new([66; 32]));
    let theirs = agreed(&mut inviter, &thief, now);
    // The inviter has answered the thief, so he knows Y by now; he still cannot make the key of the accepter without y.
    let (answer, _) = inviter.hear(now, &thief.offer());
    assert_eq!(accepter.hear(&answer.expect("it is given again")), Ok(None));
    let mut own = Inviter::new(MEET, &Key::new([67; 32]), now);
    own.invite = invite;
    let (answer, heard) = own.hear(now, &accepter.offer());
    assert!(matches!(heard, Heard::Agreed(key) if key != theirs), "the offer itself is under the link's secret");
    assert_eq!(accepter.hear(&answer.expect("an answer")), Ok(None), "its public key is not that of the link");
}

/// A thief who replaces the link on its way reads and passes on everything; the two ends see different codes.
#[test]
fn who_replaces_the_link_stands_between_and_the_codes_differ() {
    let (stolen, mut inviter, _, now) = ends(1);
    let mut invites = Inviter::new(MEET, &Key::new([66; 32]), now);
    let accepter = Accepter::new(&invites.invite, &Key::new([3; 32]));
    let far = agreed(&mut invites, &accepter, now);
    let near = agreed(&mut inviter, &Accepter::new(&stolen, &Key::new([67; 32])), now);
    let (nonce, mut flow) = ([1; NONCE_LEN], *b"what a hand does");
    for (seals, opens) in [(&near, &near), (&far, &far)] {
        let tag = Cipher::new(seals).seal(nonce, &[], &mut flow).expect("it is short");
        assert_ne!(&flow, b"what a hand does");
        Cipher::new(opens).open(nonce, &[], &mut flow, tag).expect("the thief has both keys");
    }
    assert_eq!(&flow, b"what a hand does", "it came through");
    assert_ne!(code(&near), code(&far));
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
fn wrong_offers_end_no_invite() {
    let (_, mut inviter, accepter, now) = ends(1);
    for tried in 0..200 {
        let guess = Accepter::new(&Invite::of(MEET, &[tried; 32]), &Key::new([9; 32]));
        assert_eq!(inviter.hear(now, &guess.offer()), (None, Heard::Nothing));
    }
    agreed(&mut inviter, &accepter, now);
}

#[test]
fn an_invite_lives_ten_minutes() {
    let (_, mut inviter, accepter, now) = ends(1);
    assert!(!inviter.is_over(now + LIFE - Duration::from_millis(1)) && inviter.is_over(now + LIFE));
    assert_eq!(inviter.hear(now + LIFE, &accepter.offer()), (None, Heard::Nothing));
}

#[test]
fn no_bit_of_offer_or_answer_can_be_changed() {
    let (_, mut inviter, accepter, now) = ends(1);
    let each_bit = |datagram: [u8; LEN], takes: &mut dyn FnMut(&[u8]) -> bool| {
        for bit in 0..8 * LEN {
            let mut forged = datagram;
            forged[bit / 8] ^= 1 << (bit % 8);
            assert!(!takes(&forged), "bit {bit}");
        }
    };
    each_bit(accepter.offer(), &mut |forged| inviter.hear(now, forged).0.is_some());
    let answer = inviter.hear(now, &accepter.offer()).0.expect("an answer");
    // X25519 does not read the highest bit of a public key; the link's hash does.
    each_bit(answer, &mut |forged| accepter.hear(forged) != Ok(None));
}

#[test]
fn a_public_key_that_leaves_no_choice_is_no_offer() {
    let letter = |letter: u8| "abcdefghijklmnopqrstuvwxyz234567".bytes().position(|known| known == letter).unwrap();
    for low in [0, 1] {
        let (invite, mut inviter, _, now) = ends(1);
        // A thief makes a right tag: the secret is in the link. At 0 and 1 every product is 0.
        let link = invite.link();
        let bits: String = link.rsplit('/').next().unwrap().bytes().map(|of| format!("{:05b}", letter(of))).collect();
        let mut secret = [0; 32];
        (0..16).for_each(|at| secret[at] = u8::from_str_radix(&bits[8 * at..8 * at + 8], 2).unwrap());
        let mut offer = [0; LEN];
        (offer[0], offer[1], offer[2]) = (0xF4, 1, low);
        let tag: [u8; 16] = Key::new(secret).derive("agreement").with(&[1]).with(&offer[2..34]).first();
        offer[34..].copy_from_slice(&tag);
        assert_eq!(inviter.hear(now, &offer), (None, Heard::Nothing));
        // Of any other point the same tag would be taken.
        offer[2] = 9;
        let tag: [u8; 16] = Key::new(secret).derive("agreement").with(&[1]).with(&offer[2..34]).first();
        offer[34..].copy_from_slice(&tag);
        assert!(matches!(inviter.hear(now, &offer).1, Heard::Agreed(_)));
    }
}
