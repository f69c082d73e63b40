//! Packets of cohold-core on the wire, and what two peers must be configured with alike.

use cohold_core::law::bounds::Bounds;
use cohold_core::law::{AnyLaw, Law, Packet};
use cohold_core::num::Motion;
use cohold_core::schema::Schema;
use cohold_core::settings::{Allowed, Settings, Value};
use cohold_protocol::link::Error;
use cohold_protocol::peer::{Inbox, flow_of, packets_of, parameters_of};
use cohold_protocol::wire::{AxisFlow, Flow, Flow3, Message};
use proptest::prelude::*;

#[test]
fn packets_survive_the_way() {
    let packet = |position| Packet::<f32> {
        motion: Motion { position, velocity: -1.5 },
        wave: 2.0,
        energy_j: 1.0 / 3.0,
        wave_integral: -1.0 / 7.0,
        live_ticks: u32::MAX,
    };
    let one: Flow = flow_of([packet(0.25)], true, 9);
    assert_eq!((packets_of(&one), one.engaged, one.tick), ([packet(0.25)], true, 9));
    let sent = [0.25, -1.0, 3.0].map(packet);
    let three: Flow3 = flow_of(sent, false, 7);
    let mut bytes = [0; Flow3::LEN];
    assert_eq!(Message::from(three).emit(&mut bytes), Ok(Flow3::LEN));
    let Ok(Message::Flow3(came)) = Message::parse(&bytes) else { panic!("{bytes:?}") };
    assert_eq!((packets_of(&came), came.engaged, came.tick), (sent, false, 7));
}

#[test]
fn what_is_each_devices_own_may_differ_and_nothing_else() {
    let settings = Settings::default();
    let schema = Schema::new(cohold_laws::LAWS);
    for key in schema.keys() {
        let now = schema.get(&settings, key.name).expect("a listed key has a value");
        let other = |values: &[Value<'static>]| values.iter().copied().find(|value| *value != now);
        let other = match key.allowed {
            Allowed::Number { min, max } => other(&[min, max].map(Value::Number)),
            Allowed::Whole { min, max } => other(&[min, max].map(|whole| Value::Number(whole.into()))),
            Allowed::Flag => other(&[false, true].map(Value::Flag)),
            Allowed::Names(names) => names.iter().map(|name| Value::Text(name)).find(|value| *value != now),
            Allowed::Laws(kinds) => kinds.iter().map(|kind| Value::Text(kind.name)).find(|value| *value != now),
            Allowed::Only(_) => None,
        };
        let other = other.expect("another value");
        let mut changed = settings;
        schema.set(&mut changed, key.name, other).expect("an allowed value");
        let own = schema.laws().iter().any(|law| law.keys.iter().any(|own| own.name == key.name));
        let tables = ["timing.", "object.", "coordination."];
        let shared = own || key.name == "axis.shared" || tables.iter().any(|table| key.name.starts_with(table));
        assert_eq!(parameters_of(&changed) != parameters_of(&settings), shared, "{}", key.name);
    }
}

/// Ticks from packet to packet.
const M: u32 = 8;

/// What may be said on a self-timed line with the default settings.
fn bounds() -> Bounds {
    let mut settings = Settings::default();
    settings.coordination.comm = "self-timed";
    AnyLaw::<f64>::bounds(&settings)
}

/// An inbox with play-out of so many packets.
fn inbox(depth: u32) -> Inbox {
    Inbox::new(bounds(), depth, M)
}

/// A flow that was sent at this tick, by an end whose motors are on or off.
fn sent(tick: u32, engaged: bool) -> Flow {
    Flow { engaged, tick, ..Flow::default() }
}

/// What an exchange takes: the tick at which it was sent, and whether the other end is to be let go of first.
fn taken(inbox: &mut Inbox, tick: u32) -> (Option<u32>, bool) {
    inbox.play(tick);
    let (flow, anew) = inbox.take();
    (flow.map(|flow| flow.tick), anew)
}

#[test]
fn an_end_that_has_armed_anew_is_seen_however_many_flows_come_at_once() {
    // Motors off and on again between two exchanges, in as many flows as there may be.
    for rearm in [&[false, true][..], &[false, false, true, true], &[true, false, true], &[false, true, false, true]] {
        let mut inbox = inbox(0);
        inbox.put(0, sent(0, true)).expect("it can be");
        assert_eq!(taken(&mut inbox, 0), (Some(0), false), "the first life");
        for (number, engaged) in (1..).zip(rearm) {
            inbox.put(M, sent(number * M, *engaged)).expect("it can be");
        }
        let newest = rearm.len() as u32 * M;
        assert_eq!(taken(&mut inbox, M), (Some(newest), true), "{rearm:?}");
        assert_eq!(taken(&mut inbox, 2 * M), (None, false), "nothing of what came before is left");
        inbox.put(3 * M, sent(newest + M, true)).expect("it can be");
        assert_eq!(taken(&mut inbox, 3 * M), (Some(newest + M), false), "it is let go of once");
    }
}

#[test]
fn motors_that_are_off_are_not_taken_and_those_that_stay_off_are_no_other_life() {
    let mut inbox = inbox(0);
    for (number, engaged) in (0..).zip([true, true, false, false]) {
        inbox.put(number, sent(number, engaged)).expect("it can be");
        assert_eq!(taken(&mut inbox, number), (engaged.then_some(number), false));
    }
    inbox.put(4, sent(4, true)).expect("it can be");
    assert_eq!(taken(&mut inbox, 4), (Some(4), true));
}

#[test]
fn what_waits_to_be_played_keeps_which_life_it_is_of() {
    // The fastest packet takes nothing, so everything is played two packet periods after it was sent.
    let mut inbox = inbox(2);
    for (number, engaged) in (0..).zip([true, true, false, true, true]) {
        inbox.put(number * M, sent(number * M, engaged)).expect("it can be");
        assert!(inbox.newest().is_none(), "not due yet");
        if let Some(due) = number.checked_sub(2) {
            assert_eq!(
                taken(&mut inbox, number * M),
                ((due < 2).then_some(due * M), false),
                "of the first life, or off"
            );
        }
    }
    assert_eq!(taken(&mut inbox, 5 * M), (Some(3 * M), true), "the other life begins where its first flow is played");
    assert_eq!(taken(&mut inbox, 6 * M), (Some(4 * M), false));
}

#[test]
fn an_end_that_has_armed_anew_is_seen_where_play_out_overtakes_the_flow_that_said_so() {
    // Several wait; when the next exchange comes at last, all but the newest are overtaken.
    let mut inbox = inbox(2);
    for (number, engaged) in (0..).zip([true, true, false, true]) {
        inbox.put(number * M, sent(number * M, engaged)).expect("it can be");
    }
    assert_eq!(taken(&mut inbox, 3 * M), (Some(M), false), "what is due is of the first life still");
    inbox.put(4 * M, sent(4 * M, true)).expect("it can be");
    assert_eq!(taken(&mut inbox, 6 * M), (Some(4 * M), true));
    for tick in 7 * M..20 * M {
        assert_eq!(taken(&mut inbox, tick), (None, false), "nothing of what came before is left");
    }
}

#[test]
fn nothing_is_left_of_an_end_that_has_gone_and_it_is_let_go_of_once() {
    for depth in [0, 2] {
        let mut inbox = inbox(depth);
        inbox.put(0, sent(0, true)).expect("it can be");
        inbox.put(M, sent(M, true)).expect("it can be");
        inbox.clear();
        assert!(inbox.newest().is_none());
        assert_eq!(taken(&mut inbox, 3 * M), (None, true), "at the next exchange, whether or not anything has come");
        assert_eq!(taken(&mut inbox, 4 * M), (None, false));
    }
}

/// With the default limits of 10 m/s, 40 N and 10 N·s/m a wave is at most (10·10 + 40)/√20 √W, and a tick of 1 ms adds that much to its sum.
#[test]
fn what_cannot_be_is_not_taken_and_ends_the_life_that_said_it() {
    // (b·V + F/ρ₀)/√(2b) of a line whose impedance falls to a step less than a quarter.
    let most = (100.0 + 40.0 / (0.25 - 1.0 / 1024.0)) / 20.0_f64.sqrt();
    let flow = |tick: u32, axis: AxisFlow| Flow { engaged: true, tick, axes: [axis], ..Flow::default() };
    let plain = AxisFlow { live_ticks: 100, ..AxisFlow::default() };
    let integral = |wave_integral: f64, live_ticks: u32| AxisFlow { wave_integral, live_ticks, ..plain };
    for depth in [0, 2] {
        for (second, what) in [
            (AxisFlow { position: 201.0, live_ticks: 108, ..plain }, "position"),
            (AxisFlow { velocity: -10.1, live_ticks: 108, ..plain }, "velocity"),
            (AxisFlow { wave: 1.001 * most as f32, live_ticks: 108, ..plain }, "wave"),
            (AxisFlow { energy_sent: 1.7e308, live_ticks: 108, ..plain }, "energy_sent"),
            (integral(1.7e308, 108), "wave_integral"),
            (integral(1.001 * 8e-3 * most, 108), "wave_integral"),
            (integral(-1.001 * 1e-3 * most, 101), "wave_integral"),
        ] {
            let mut inbox = inbox(depth);
            inbox.put(0, flow(0, plain)).expect("it can be");
            assert_eq!(taken(&mut inbox, 2 * M), (Some(0), false));
            assert_eq!(inbox.put(3 * M, flow(M, second)), Err(Error::Impossible(what)), "{second:?}");
            assert!(inbox.newest().is_none());
            assert_eq!(taken(&mut inbox, 6 * M), (None, true), "it is let go of at the next exchange");
            // What comes then begins anew, from sums that are its own.
            inbox.put(7 * M, flow(2 * M, integral(5.0, 7))).expect("it can be");
            assert_eq!(taken(&mut inbox, 10 * M), (Some(2 * M), false));
        }
        // As much as can be, forward and back, and what came before once more.
        let mut inbox = inbox(depth);
        for (tick, (sum, live)) in
            (1..).zip([(0.0, 0), (8.0, 8), (0.0, 16), (-100.0, 116), (7.0, 116), (-99.0, 1 << 20)])
        {
            let said = AxisFlow { wave: -0.999_999 * most as f32, ..integral(1e-3 * most * sum, live) };
            inbox.put(tick, flow(tick, said)).expect("it can be");
        }
    }
}

/// What may happen at one end of a line.
#[derive(Clone, Copy, Debug)]
enum Happens {
    /// A flow comes, of an end whose motors are on or off.
    Comes(bool),
    /// The link lets go of the other end.
    Gone,
    /// A packet period is over, and an exchange takes what there is.
    Exchange,
}

proptest! {
    /// Every flow that is taken is of the newest life by then, and its exchange has let go of the one before, if there was one.
    #[test]
    fn no_exchange_takes_one_life_for_another(
        depth in 0..4_u32,
        happens in prop::collection::vec(
            prop_oneof![any::<bool>().prop_map(Happens::Comes), Just(Happens::Gone), Just(Happens::Exchange)], 1..200),
    ) {
        let mut inbox = inbox(depth);
        // By tick of the sender: the life of each flow, counted from what came in which order.
        let (mut lives, mut life, mut off, mut now) = (Vec::new(), 0, false, 0);
        // The life that the exchanges are in, once they have taken something of it.
        let (mut current, mut newest) = (None, 0);
        for happens in happens {
            match happens {
                Happens::Comes(engaged) => {
                    life += u32::from(engaged && off);
                    off = !engaged;
                    inbox.put(now, sent(lives.len() as u32, engaged)).expect("it can be");
                    lives.push(life);
                }
                Happens::Gone => {
                    inbox.clear();
                    life += 1;
                }
                Happens::Exchange => {
                    let (flow, parted) = taken(&mut inbox, now);
                    now += M;
                    if parted {
                        current = None;
                    }
                    if let Some(tick) = flow {
                        let of = lives[tick as usize];
                        prop_assert!(current.is_none_or(|current| current == of) && of >= newest, "{tick}: {of} in {current:?}");
                        (current, newest) = (Some(of), of);
                    }
                }
            }
        }
    }
}
