//! Links: read as they were written, and every slip found.

use cohold_homes::Error;
use cohold_homes::invite::Invite;

#[test]
fn a_link_is_read_as_it_was_written() {
    for (seed, meet) in [(1, "203.0.113.1:4000"), (2, "[2001:db8::1]:4000"), (3, "meet.example.org:7710")] {
        let link = Invite::of(meet, &[seed; 32]).link();
        let read = Invite::parse(&format!(" {link}\n")).expect("a link");
        assert_eq!((read.link(), read.meet.as_str()), (link.clone(), meet));
        assert_eq!(Invite::parse(&link.replace("haptic://", "https://")).unwrap_err(), Error::NoLink);
        assert!(!format!("{read:?}").contains(link.rsplit('/').next().unwrap()), "no secret is printed");
    }
}

#[test]
fn every_wrong_letter_and_every_other_place_is_found() {
    let link = Invite::of("203.0.113.1:4000", &[1; 32]).link();
    let start = link.rfind('/').unwrap() + 1;
    let mut missed = 0;
    for at in start..link.len() {
        for letter in "abcdefghijklmnopqrstuvwxyz234567".chars().filter(|letter| !link[at..].starts_with(*letter)) {
            let wrong = format!("{}{letter}{}", &link[..at], &link[at + 1..]);
            missed += u32::from(Invite::parse(&wrong).is_ok());
        }
    }
    // 16 bits of 899 tries: one in 73 links has a letter that is not found.
    assert_eq!(missed, 0);
    assert_eq!(Invite::parse(&link.replace("113.1", "113.2")).unwrap_err(), Error::Mistyped);
    assert_eq!(Invite::parse(&link[..link.len() - 1]).unwrap_err(), Error::NoLink);
    assert_eq!(Invite::parse("haptic://nowhere/aaaa").unwrap_err(), Error::NoLink);
}
