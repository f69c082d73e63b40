//! The link is searched, not only tested: real [`Link`](super::Link)s of two ends, and everything that somebody between them who has
//! no key can do in so many steps: hold, drop, repeat and reorder what they say, carry it over from earlier sessions, let time pass,
//! have either start anew. After each step everything is held against what is promised ([`world::Promise`]).
//!
//! That the search sees what it should is shown by links that make a mistake ([`mistakes`]): each is found, and each promise is
//! broken by one of them. What is printed is the shortest sequence that does.
//!
//! **Limits**: one step of time is one of three lengths, and both ends are called after it and after every datagram. Each end
//! starts anew once, the operator says one line. States that print alike are taken for the same, by a hash of 64 bits.
//!
//! One step deeper, a minute or two of processor time:
//! `cargo test --release -p cohold-protocol --lib search -- --ignored --nocapture`.

mod explore;
mod mistakes;
mod world;

use explore::{all, shortest};
use mistakes::Mistake;
use world::Action::{self, Exchange, Pass, Say};
use world::{Promise, Use, World};

/// What a search begins with: nothing but two ends that have started; or that they have a session.
const STARTS: [&[Action]; 2] = [&[], &[Exchange]];

/// Searches everything to this depth, from every start.
fn nothing_is_broken(depth: u32) {
    for usage in [Use::Flow, Use::Line] {
        for start in STARTS {
            let seen = all(&World::new(usage, Mistake::None, None).after(start), depth);
            let (states, actions) = (seen.states, seen.actions);
            println!("{usage:?}, {depth} actions after {start:?}: {states} states, {actions} actions tried");
            if seen.broken.is_some() {
                let shortest = shortest(&World::new(usage, Mistake::None, None).after(start), depth);
                panic!("{usage:?} after {start:?}: {:?}", shortest.broken);
            }
        }
    }
}

#[test]
fn nothing_that_five_actions_can_do_breaks_a_promise() {
    nothing_is_broken(5);
}

#[test]
#[ignore = "takes a minute: see the top of this file"]
fn nothing_that_six_actions_can_do_breaks_a_promise() {
    nothing_is_broken(6);
}

/// A mistake, where it is made, what it breaks, after which start, and in how few actions.
const MISTAKES: [(Mistake, Use, Promise, &[Action], usize); 16] = [
    (Mistake::SessionWithoutLife, Use::Flow, Promise::UnconfirmedEnds, &[], 3),
    (Mistake::ChallengeWithoutLife, Use::Flow, Promise::GreetingInTime, &[], 3),
    (Mistake::CommandWithoutLife, Use::Line, Promise::LineInTime, &[], 4),
    (Mistake::NoLives, Use::Line, Promise::LineOfNow, &[], 4),
    (Mistake::MessageWithoutLife, Use::Flow, Promise::ConfirmedByAnAnswer, &[Pass(0), Pass(1)], 3),
    (Mistake::MessageWithoutLife, Use::Line, Promise::MessageInTime, &[Exchange], 5),
    (Mistake::Unconfirmed, Use::Flow, Promise::NothingBeforeAnAnswer, &[], 3),
    (Mistake::ConstantRandomness, Use::Flow, Promise::NonceOnce, &[], 4),
    (Mistake::SequenceAgain, Use::Flow, Promise::NonceOnce, &[], 1),
    (Mistake::EphemeralKept, Use::Line, Promise::SessionOnce, &[], 3),
    (Mistake::WindowForgets, Use::Flow, Promise::TakenOnce, &[], 4),
    (Mistake::FlowOfAnyAge, Use::Flow, Promise::FlowInTime, &[], 4),
    (Mistake::FlowInAnyOrder, Use::Flow, Promise::FlowInOrder, &[Exchange], 4),
    (Mistake::EventsAgain, Use::Line, Promise::DoneOnce, &[Exchange, Say], 4),
    (Mistake::SilenceUnheard, Use::Line, Promise::PeerIsThere, &[], 3),
    (Mistake::SilenceUnheard, Use::Flow, Promise::EngagedWithFlow, &[Exchange], 4),
];

#[test]
fn every_mistake_is_found() {
    for (mistake, usage, promise, start, length) in MISTAKES {
        let seen = shortest(&World::new(usage, mistake, Some(promise)).after(start), length as u32 + 1);
        let (actions, broken) = seen.broken.unwrap_or_else(|| panic!("{mistake:?} is not found"));
        println!(
            "{mistake:?} breaks {broken:?}, {} states, {} actions tried: {start:?}, {actions:?}",
            seen.states, seen.actions
        );
        assert_eq!((broken, actions.len()), (promise, length));
    }
}

#[test]
fn every_promise_can_be_broken() {
    for promise in Promise::ALL {
        assert!(MISTAKES.iter().any(|(_, _, broken, ..)| *broken == promise), "{promise:?}");
    }
}
