//! Any message from anybody at any time: no role panics, and each is one value of fixed size.

use cohold_environments::roles::collaborative::ring::{Config, Record, Ring, Roster};
use cohold_environments::roles::collaborative::{Lease, lock};
use cohold_environments::roles::squash::{Ball, Court, Player, PlayerConfig, Racket, Server, ServerConfig};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;
use proptest::prelude::*;

use crate::roles::messages::{locks, rings, squashes};

/// Times that are close together, far apart, and backwards.
fn times() -> impl Strategy<Value = u64> {
    prop_oneof![0..10_000_000_u64, any::<u64>(), Just(u64::MAX)]
}

fn steps<M: std::fmt::Debug>(messages: impl Strategy<Value = M>) -> impl Strategy<Value = Vec<(u64, u8, M, u8)>> {
    prop::collection::vec((times(), 0..20_u8, messages, 0..5_u8), 1..60)
}

proptest! {
    #[test]
    fn a_lock_takes_anything(steps in steps(locks())) {
        let lease = Lease::new(300_000).unwrap();
        let mut out = Outbox::<_, 8>::new();
        let mut server = lock::Server::<3>::new(lease, [0; 24]);
        let mut client = lock::Client::new(PeerId(0), lease, 1, [0; 24]);
        for (now, from, message, act) in steps {
            server.receive(now, PeerId(from), &message, &mut out);
            server.poll(now, &mut out);
            client.receive(now, PeerId(from % 2), &message, &mut out);
            match act {
                0 => client.ask(now),
                1 => client.withdraw(&mut out),
                2 => drop(client.release(now, Some([1; 24]), &mut out)),
                3 => server = lock::Server::restore(lease, now, server.record().clone()),
                _ => client.poll(now, &mut out),
            }
            prop_assert!(server.waiting() <= 3);
            while out.pop_front().is_some() {}
        }
    }

    #[test]
    fn a_ring_takes_anything(seat in 0..16_u8, members: u16, steps in steps(rings())) {
        let roster = Roster::of((0..16).filter(|seat| members >> seat & 1 == 1));
        let config =
            Config { seat, contacts: roster, lease: Lease::new(300_000).unwrap(), turn_us: 1, seed: u64::MAX };
        let mut out = Outbox::<_, 8>::new();
        let mut ring = Ring::new(config, 0, Record::founder(roster, [0; 24]));
        for (now, from, message, act) in steps {
            ring.receive(now, PeerId(from), &message, &mut out);
            match act {
                0 => ring.ask(),
                1 => drop(ring.publish(now, [1; 24], &mut out)),
                2 => ring.give_up(now, &mut out),
                3 => ring = Ring::new(config, now, *ring.record()),
                _ => ring.poll(now, &mut out),
            }
            while out.pop_front().is_some() {}
        }
        ring.leave();
        let _ = ring.has_left();
    }

    #[test]
    fn a_game_takes_anything(number in 0..20_u8, steps in steps(squashes())) {
        let mut out = Outbox::<_, 8>::new();
        let mut server = Server::new(ServerConfig { players: 2, rallies: 3, bounder: true });
        let config = PlayerConfig { number: PeerId(number), court: Court::SINGLES, ball_kg: 0.024, life: 1 };
        let mut player = Player::new(config);
        for (now, from, message, act) in steps {
            server.receive(now, PeerId(from), &message, &mut out);
            server.poll(now, &mut out);
            player.receive(now, PeerId(from % 3), &message, &mut out);
            player.place(Ball { position: [f32::NAN, -1e30], velocity: [f32::INFINITY, 0.0] });
            let racket = Racket { mass_kg: 0.1, velocity: [f32::from(act) * 10.0, 1.0], normal: [1.0, f32::from(act)] };
            if let Some(strike) = player.hit(now, &racket, &mut out) {
                prop_assert!(strike.impact.velocity.iter().all(|part| part.is_finite()));
            }
            player.poll(now, &mut out);
            if let Some(ball) = player.ball(now) {
                prop_assert!((0.0..=9.75).contains(&ball.position[0]) && (0.0..=6.4).contains(&ball.position[1]));
            }
            while out.pop_front().is_some() {}
        }
    }
}

#[test]
fn roles_fit_on_a_microcontroller() {
    println!(
        "lock client {} B, ring {} B, squash player {} B",
        size_of::<lock::Client>(),
        size_of::<Ring>(),
        size_of::<Player>()
    );
    assert!(size_of::<lock::Client>() <= 512 && size_of::<Ring>() <= 2048 && size_of::<Player>() <= 3072);
}
