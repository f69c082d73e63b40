//! The engine: order of turns, clocks, and what becomes of packets.

use cohold_sim::engine::{Actor, Clock, Engine, EngineView, Out, Seat, Turn};
use cohold_sim::network::link::{Counts, Route};
use cohold_sim::network::rule::Fate;

/// Sends its tick to the next, and keeps what it hears: when, from whom.
#[derive(Default)]
struct Caller {
    next: usize,
    heard: Vec<(u64, usize, Vec<u8>)>,
    acted: u64,
}

impl Actor<usize> for Caller {
    type Packet = [u8];

    fn hear(&mut self, now_ns: u64, from: usize, packet: &mut [u8], _: &mut Out<'_, usize, [u8]>) {
        self.heard.push((now_ns, from, packet.to_vec()));
    }

    fn speak(&mut self, _: u64, out: &mut Out<'_, usize, [u8]>) {
        out(self.next, &[self.acted as u8]);
    }

    fn act(&mut self, _: u64, _: &mut Out<'_, usize, [u8]>) {
        self.acted += 1;
    }
}

fn engine(route: impl FnMut(usize, usize) -> Route) -> Engine<Caller> {
    let seats = [1, 0].map(|next| Seat::new(Caller { next, ..Caller::default() }));
    Engine::new(1_000, seats.into(), route)
}

#[test]
fn without_delay_what_is_said_is_heard_before_anybody_acts() {
    let mut engine = engine(|_, _| Route::default());
    let mut order = Vec::new();
    engine.step(&mut |seen: EngineView<'_, Caller>| order.push((seen.seat, seen.turn)));
    let wanted =
        [(0, Turn::Spoke), (1, Turn::Spoke), (1, Turn::Heard), (0, Turn::Heard), (0, Turn::Acted), (1, Turn::Acted)];
    assert_eq!(order, wanted);
    assert_eq!(engine.seats[0].actor.heard, [(0, 1, vec![0])]);
}

#[test]
fn packets_arrive_when_they_are_due_by_the_receivers_clock_and_closures_lose_them() {
    let mut engine = engine(|from, _| match from {
        0 => {
            Route::new(2_500).with_rule(|number: u64, _| if number.is_multiple_of(3) { Fate::Drop } else { Fate::Pass })
        }
        _ => Route::new(0).with_rule(|number, sent_ns| Fate::late(if number == 0 { 1_900 } else { sent_ns })),
    });
    engine.seats[1].clock = Clock { start_ns: 500, rate: 2.0 };
    (0..6).for_each(|_| engine.step(&mut |_| ()));
    let [first, second] = [0, 1].map(|at| std::mem::take(&mut engine.seats[at].actor.heard));
    assert_eq!(second, [(7_500, 0, vec![1]), (9_500, 0, vec![2])]);
    assert_eq!(first, [(1_900, 1, vec![0]), (2_000, 1, vec![1]), (4_000, 1, vec![2])]);
    assert_eq!(engine.counts(), Counts { taken: 12, sent: 10, lost: 2, corrupt: 0 });
}

#[test]
fn who_is_off_hears_nothing_and_a_slow_clock_misses_turns() {
    let mut engine = engine(|_, _| Route::new(500));
    engine.seats[1].period = 1.25;
    (0..10).for_each(|_| engine.step(&mut |_| ()));
    assert_eq!((engine.seats[0].actor.acted, engine.seats[1].actor.acted), (10, 8));
    engine.seats[0].off = true;
    engine.route(1, 0).cut = true;
    (0..10).for_each(|_| engine.step(&mut |_| ()));
    assert_eq!((engine.seats[0].actor.acted, engine.seats[1].actor.acted), (10, 16));
    assert_eq!(engine.counts().lost, 1 + 8);
}
