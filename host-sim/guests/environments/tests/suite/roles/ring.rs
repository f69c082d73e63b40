//! A token ring on a network that delivers everything at once, and what happens when one end is cut off.

use cohold_environments::roles::collaborative::ring::{Config, Message, Notice, Record, Ring, Roster};
use cohold_environments::roles::collaborative::{Lease, NotOwner};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;

const LEASE_US: u32 = 300_000;

struct Circle {
    rings: Vec<Ring>,
    /// Who is on the other side.
    cut: Roster,
    /// Two who do not hear each other.
    deaf: Roster,
    now: u64,
    flying: Vec<(u8, PeerId, Message)>,
}

impl Circle {
    fn new(founders: u8, outsiders: u8) -> Self {
        let (founded, all) = (Roster::of(0..founders), Roster::of(0..founders + outsiders));
        let rings = all.seats().map(|seat| {
            let record = if founded.contains(seat) { Record::founder(founded, [0; 24]) } else { Record::outsider() };
            let lease = Lease::new(LEASE_US).unwrap();
            Ring::new(Config { seat, contacts: all, lease, turn_us: 100_000, seed: u64::from(seat) }, 0, record)
        });
        Self { rings: rings.collect(), cut: Roster::EMPTY, deaf: Roster::EMPTY, now: 0, flying: vec![] }
    }

    /// Time passes; what is said is heard 1 ms later.
    fn run(&mut self, us: u64, mut each: impl FnMut(&mut Self)) {
        for _ in 0..us / 1_000 {
            self.now += 1_000;
            let mut out = Outbox::<_, 64>::new();
            for (from, to, message) in std::mem::take(&mut self.flying) {
                let deaf = self.deaf.contains(from) && self.deaf.contains(to.0);
                if self.cut.contains(from) == self.cut.contains(to.0) && !deaf {
                    self.rings[usize::from(to.0)].receive(self.now, PeerId(from), &message, &mut out);
                    self.flying
                        .extend(std::iter::from_fn(|| out.pop_front()).map(|(next, message)| (to.0, next, message)));
                }
            }
            for (seat, ring) in (0..).zip(&mut self.rings) {
                ring.poll(self.now, &mut out);
                self.flying.extend(std::iter::from_fn(|| out.pop_front()).map(|(to, message)| (seat, to, message)));
            }
            assert!(self.owners().len() <= 1);
            each(self);
        }
    }

    fn owners(&self) -> Vec<usize> {
        (0..self.rings.len()).filter(|seat| self.rings[*seat].owns(self.now)).collect()
    }

    /// Whoever may edit publishes its number.
    fn publish(&mut self) {
        for seat in self.owners() {
            let mut out = Outbox::<_, 64>::new();
            self.rings[seat].publish(self.now, [seat as u8 + 1; 24], &mut out).unwrap();
            assert_eq!(self.rings[seat].publish(self.now, [9; 24], &mut out), Err(NotOwner));
            self.flying.extend(std::iter::from_fn(|| out.pop_front()).map(|(to, message)| (seat as u8, to, message)));
        }
    }
}

fn granted(ring: &mut Ring) -> usize {
    std::iter::from_fn(|| ring.take_notice()).filter(|notice| *notice == Notice::Granted).count()
}

#[test]
fn the_right_to_edit_goes_round() {
    let mut circle = Circle::new(4, 0);
    let mut order = vec![];
    circle.run(5_000_000, |circle| {
        for ring in &mut circle.rings {
            ring.ask();
        }
        order.extend(circle.owners());
        circle.publish();
    });
    order.dedup();
    assert!(order.len() > 100, "{}", order.len());
    assert!(order.windows(2).all(|pair| pair[1] == (pair[0] + 1) % 4), "{order:?}");
}

#[test]
fn the_token_rests_while_nobody_wants_it() {
    let mut circle = Circle::new(3, 0);
    circle.run(2_000_000, |_| ());
    let ballots = |circle: &Circle| circle.rings.iter().map(|ring| ring.record().kept.ballot).collect::<Vec<_>>();
    let before = ballots(&circle);
    circle.run(2_000_000, |_| ());
    assert_eq!(ballots(&circle), before);
}

#[test]
fn a_new_token_is_made_where_the_majority_is_after_the_old_owner_has_stopped() {
    let mut circle = Circle::new(3, 0);
    circle.rings[1].ask();
    circle.run(2_000_000, |_| ());
    assert_eq!(circle.owners(), [1]);
    circle.cut = Roster::of([1]);
    for seat in [0, 2] {
        circle.rings[seat].ask();
    }
    circle.run(2_000_000, Circle::publish);
    assert!(granted(&mut circle.rings[0]) > 0 && granted(&mut circle.rings[2]) > 0);
    // Back again, it follows.
    circle.cut = Roster::EMPTY;
    circle.run(1_000_000, |_| ());
    assert_eq!(circle.rings[1].state(), circle.rings[0].state());
    assert!(std::iter::from_fn(|| circle.rings[1].take_notice()).any(|notice| notice == Notice::Lost));
}

#[test]
fn without_a_majority_nobody_edits() {
    let mut circle = Circle::new(4, 0);
    circle.run(1_000_000, |_| ());
    circle.cut = Roster::of([0, 1]);
    circle.run(400_000, |_| ());
    for ring in &mut circle.rings {
        ring.ask();
    }
    circle.run(5_000_000, |circle| assert!(circle.owners().is_empty()));
}

#[test]
fn members_come_and_go() {
    let mut circle = Circle::new(2, 2);
    circle.run(3_000_000, |_| ());
    assert!(circle.rings.iter().all(|ring| ring.state().roster == Roster::of(0..4)));
    for seat in [0, 3] {
        circle.rings[seat].leave();
    }
    circle.run(3_000_000, |_| ());
    assert!(circle.rings[0].has_left() && circle.rings[3].has_left() && !circle.rings[1].has_left());
    assert_eq!(circle.rings[1].state().roster, Roster::of([1, 2]));
    // Two are left, and need nobody else.
    circle.cut = Roster::of([0, 3]);
    for seat in [1, 2] {
        let _ = granted(&mut circle.rings[seat]);
        circle.rings[seat].ask();
    }
    circle.run(2_000_000, Circle::publish);
    assert!(granted(&mut circle.rings[1]) > 0 && granted(&mut circle.rings[2]) > 0);
}

#[test]
fn who_is_silent_for_long_is_left_out_and_joins_anew() {
    let mut circle = Circle::new(5, 0);
    circle.cut = Roster::of([4]);
    let go_on = |circle: &mut Circle| {
        for ring in &mut circle.rings {
            ring.ask();
        }
        circle.publish();
    };
    circle.run(6_000_000, go_on);
    assert_eq!(circle.rings[0].state().roster, Roster::of(0..4));
    circle.cut = Roster::EMPTY;
    let _ = granted(&mut circle.rings[4]);
    circle.run(3_000_000, go_on);
    assert_eq!(circle.rings[0].state().roster, Roster::of(0..5));
    assert!(granted(&mut circle.rings[4]) > 0);
}

#[test]
fn who_comes_back_from_a_crash_keeps_the_word_that_it_has_forgotten() {
    let mut circle = Circle::new(3, 0);
    circle.rings[1].ask();
    circle.run(2_000_000, |_| ());
    assert_eq!(circle.owners(), [1]);
    // 2 hears nothing of 1 and wants a new token; 0, on whose word 1 edits, crashes again and again.
    circle.deaf = Roster::of([1, 2]);
    circle.rings[2].ask();
    let mut crashes = 0;
    circle.run(3_000_000, |circle| {
        if circle.now % 170_000 == 0 {
            let lease = Lease::new(LEASE_US).unwrap();
            let config = Config { seat: 0, contacts: Roster::of(0..3), lease, turn_us: 100_000, seed: circle.now };
            circle.rings[0] = Ring::new(config, circle.now, *circle.rings[0].record());
            crashes += 1;
        }
    });
    assert!(crashes > 15 && circle.owners() == [1]);
}

#[test]
fn new_members_alone_decide_nothing() {
    let mut circle = Circle::new(3, 2);
    // The two outsiders are not there yet.
    circle.cut = Roster::of([3, 4]);
    circle.rings[0].ask();
    circle.run(2_000_000, |_| ());
    assert_eq!(circle.owners(), [0]);
    // 0 edits, and hears that 2 would like to leave and 3 and 4 to join; then 1 and 2 are cut off.
    circle.rings[2].leave();
    circle.cut = Roster::EMPTY;
    circle.run(200_000, |_| ());
    assert_eq!((circle.owners(), circle.rings[0].state().roster), (vec![0], Roster::of(0..3)));
    circle.cut = Roster::of([1, 2]);
    circle.publish();
    circle.rings[1].ask();
    for seat in [0, 3, 4] {
        circle.rings[seat].ask();
    }
    // Of the members before, 1 and 2 are the majority: what 0 proposes with 3 and 4 is never published.
    circle.run(3_000_000, |circle| assert!(circle.owners().iter().all(|seat| *seat == 1)));
    assert_eq!(circle.owners(), [1]);
    assert!(!std::iter::from_fn(|| circle.rings[0].take_notice()).any(|notice| matches!(notice, Notice::Published(_))));
}

#[test]
fn any_two_majorities_meet() {
    let of = |bits: u8| Roster::of((0..6).filter(move |seat| bits >> seat & 1 == 1));
    for roster in 0..1 << 6 {
        for (one, two) in (0..1 << 6).flat_map(|one| (0..1 << 6).map(move |two| (one & roster, two & roster))) {
            let both = [one, two].iter().all(|votes| of(*votes).len() >= of(roster).majority());
            assert!(!both || one & two != 0);
        }
    }
}

#[test]
fn the_ring_goes_round() {
    let roster = Roster::of([1, 4, 15, 16, 200]);
    assert_eq!(roster.len(), 3);
    assert!(roster.after(4).eq([15, 1, 4]) && roster.after(15).eq([1, 4, 15]) && roster.seats().eq([1, 4, 15]));
    assert!(Roster::EMPTY.after(3).next().is_none() && roster.without(1).with(2).union(Roster::of([9])).len() == 4);
}
