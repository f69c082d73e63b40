//! The engine: actors, each with its own clock, and a network between every two of them, stepped together in simulated time.
//!
//! **One tick**, a control period of true time: packets that have arrived are delivered, every actor sends, packets without delay are
//! delivered, and then the actors compute one after the other, in the order of the seats, each after it has received what has arrived
//! by then. So a network without delay delivers within the tick, and the last seat has heard all others. An answer leaves when the
//! question arrived, not at the next tick. Nothing else advances time: an observer gives [`Engine::step`] a closure that sees every
//! actor after each of its turns; to disturb a run, seats are switched off and on, actors changed and routes cut between ticks.
//!
//! Time and randomness are arguments, so a run is a function of what it was given. Time is nanoseconds.

use std::borrow::BorrowMut;

use crate::network::link::{Counts, InFlight, Payload, Route};

/// The function by which an actor sends: called with the receiver's address and the packet.
pub type Out<'a, A, P> = dyn FnMut(A, &P) + 'a;

/// A participant that receives and sends packets: a peer with its device, a node behind a sealed link, a hub, a client, a server.
///
/// `A` is how others are addressed: by the number of their seat in an [`Engine`], by a socket address on a real network. An
/// actor that is to run on both takes any `A: Copy` and `Packet = [u8]`. All times are of one clock, its own, which may start
/// anywhere and does not go back.
///
/// **How it is driven.** By the engine: [`Actor::hear`] at the instant that each packet arrives, and once each of its
/// control periods [`Actor::speak`] and [`Actor::act`], between which everybody else speaks. By a runner on sockets: once
/// each control period `hear` for every datagram that has come, up to a bound, then `speak` and `act` at once; a datagram
/// that the socket does not take is lost. So an actor must not count on anything between `speak` and `act`.
pub trait Actor<A> {
    /// The packets that actors exchange: `[u8]`, or a value that crosses as it is.
    type Packet: Payload + ?Sized;

    /// Takes a packet that has come; the actor may change it in place, as when a sealed datagram is opened.
    fn hear(&mut self, now_ns: u64, from: A, packet: &mut Self::Packet, out: &mut Out<'_, A, Self::Packet>);

    /// Sends the packets that are due, before any actor acts in this control period.
    fn speak(&mut self, _now_ns: u64, _out: &mut Out<'_, A, Self::Packet>) {}

    /// Computes one control period, and sends the packets that follow from it.
    fn act(&mut self, _now_ns: u64, _out: &mut Out<'_, A, Self::Packet>) {}
}

/// A clock that starts anywhere and runs fast or slow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Clock {
    /// Time that the clock shows at true time 0, ns.
    pub start_ns: u64,
    /// Rate of the clock over that of true time; 1 is exact.
    pub rate: f64,
}

impl Clock {
    /// A clock that shows true time.
    pub const TRUE: Self = Self { start_ns: 0, rate: 1.0 };

    /// Time that the clock shows at this true time, ns.
    #[inline]
    pub fn at(self, true_ns: u64) -> u64 {
        self.start_ns + if self.rate == 1.0 { true_ns } else { (true_ns as f64 * self.rate) as u64 }
    }
}

/// An actor, its clock, and whether it takes part.
pub struct Seat<A> {
    /// The actor that sits there.
    pub actor: A,
    /// The clock whose time the actor gets.
    pub clock: Clock,
    /// Its control period divided by the engine's; unless 1, the actor now and then has no tick, or two, in one of the engine's.
    pub period: f64,
    /// Whether the actor has crashed or is gone: then it hears nothing and does nothing.
    pub off: bool,
}

impl<A> Seat<A> {
    /// A seat whose clock shows true time.
    pub fn new(actor: A) -> Self {
        Self { actor, clock: Clock::TRUE, period: 1.0, off: false }
    }

    /// Ticks in the true tick `tick`.
    fn turns(&self, tick: u64) -> u64 {
        let done = |tick: u64| (tick as f64 / self.period).floor() as u64;
        if self.off { 0 } else { done(tick + 1) - done(tick) }
    }
}

/// What an actor has done when the observer is called.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// It has heard one packet ([`Actor::hear`]).
    Heard,
    /// It has sent the packets that were due ([`Actor::speak`]).
    Spoke,
    /// It has computed its control period ([`Actor::act`]).
    Acted,
}

/// What an observer sees after each turn of an actor.
pub struct EngineView<'a, A> {
    /// Simulated true time, ns.
    pub now_ns: u64,
    /// Index of the seat whose actor has had a turn.
    pub seat: usize,
    /// What that actor has done.
    pub turn: Turn,
    /// Every seat of the engine.
    pub seats: &'a mut [Seat<A>],
}

struct Envelope<P: Payload + ?Sized> {
    from: usize,
    to: usize,
    packet: P::Owned,
}

/// Actors and the network between them.
pub struct Engine<A: Actor<usize>> {
    /// The actors that take part.
    pub seats: Vec<Seat<A>>,
    /// From each to each other.
    routes: Vec<Route>,
    in_flight: InFlight<Envelope<A::Packet>>,
    period_ns: u64,
    tick: u64,
    missed: u64,
}

impl<A: Actor<usize>> Engine<A> {
    /// An engine at time 0 with these actors and `route(from, to)` from each seat to each; a tick is `period_ns` long, ns.
    pub fn new(period_ns: u64, seats: Vec<Seat<A>>, mut route: impl FnMut(usize, usize) -> Route) -> Self {
        let count = seats.len();
        let routes = (0..count * count).map(|direction| route(direction / count, direction % count)).collect();
        Self { seats, routes, in_flight: InFlight::default(), period_ns, tick: 0, missed: 0 }
    }

    /// Ticks done so far.
    #[inline]
    pub fn tick(&self) -> u64 {
        self.tick
    }

    /// True time of the next tick, ns.
    #[inline]
    pub fn now_ns(&self) -> u64 {
        self.tick * self.period_ns
    }

    /// The route from one seat to another, to be cut or put under another rule.
    pub fn route(&mut self, from: usize, to: usize) -> &mut Route {
        &mut self.routes[from * self.seats.len() + to]
    }

    /// What became of all packets that were sent; those that came to a seat that was off count as lost, too.
    pub fn counts(&self) -> Counts {
        let none = Counts { lost: self.missed, ..Counts::default() };
        self.routes.iter().map(Route::counts).fold(none, |sum, direction| Counts {
            taken: sum.taken + direction.taken,
            sent: sum.sent + direction.sent,
            lost: sum.lost + direction.lost,
            corrupt: sum.corrupt + direction.corrupt,
        })
    }

    /// Advances all actors by one tick; `watch` is called after every turn of an actor.
    #[inline]
    pub fn step(&mut self, watch: &mut impl FnMut(EngineView<'_, A>)) {
        let most = self.seats.iter().map(|seat| if seat.period == 1.0 { 1 } else { seat.turns(self.tick) }).max();
        for round in 0..most.unwrap_or(0).max(1) {
            self.round(round, watch);
        }
        self.tick += 1;
    }

    /// One turn of those who have more than `round` in this tick.
    #[inline]
    fn round(&mut self, round: u64, watch: &mut impl FnMut(EngineView<'_, A>)) {
        let (now_ns, tick) = (self.now_ns(), self.tick);
        let has_turn = |seat: &Seat<A>| match seat.period == 1.0 {
            true => !seat.off && round == 0,
            false => seat.turns(tick) > round,
        };
        self.deliver(now_ns, watch);
        for at in 0..self.seats.len() {
            if has_turn(&self.seats[at]) {
                self.turn(at, now_ns, Turn::Spoke, watch, |actor, local_ns, out| actor.speak(local_ns, out));
            }
        }
        for at in 0..self.seats.len() {
            self.deliver(now_ns, watch);
            if has_turn(&self.seats[at]) {
                self.turn(at, now_ns, Turn::Acted, watch, |actor, local_ns, out| actor.act(local_ns, out));
            }
        }
    }

    /// What has arrived by `now_ns` is heard, in the order of arrival.
    #[inline]
    fn deliver(&mut self, now_ns: u64, watch: &mut impl FnMut(EngineView<'_, A>)) {
        while let Some((due_ns, Envelope { from, to, mut packet })) = self.in_flight.take(now_ns) {
            if self.seats[to].off {
                self.missed += 1;
                continue;
            }
            self.turn(to, due_ns, Turn::Heard, watch, |actor, local_ns, out| {
                actor.hear(local_ns, from, packet.borrow_mut(), out);
            });
        }
    }

    #[inline]
    fn turn(
        &mut self,
        at: usize,
        now_ns: u64,
        turn: Turn,
        watch: &mut impl FnMut(EngineView<'_, A>),
        take: impl FnOnce(&mut A, u64, &mut Out<'_, usize, A::Packet>),
    ) {
        let (count, routes, in_flight) = (self.seats.len(), &mut self.routes, &mut self.in_flight);
        let seat = &mut self.seats[at];
        take(&mut seat.actor, seat.clock.at(now_ns), &mut |to, packet| {
            // What is for nobody is lost.
            if to < count {
                routes[at * count + to].send(now_ns, packet, |due_ns, packet| {
                    in_flight.put(due_ns, Envelope { from: at, to, packet });
                });
            }
        });
        watch(EngineView { now_ns, seat: at, turn, seats: &mut self.seats });
    }
}
