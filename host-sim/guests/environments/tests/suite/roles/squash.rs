//! A game of squash as long as one can be, and what it is made of: flight, impact, bounds.

use cohold_environments::roles::squash::{
    Ball, BallBounds, Court, Ending, Impact, Message, MotionBounder, Notice, Phase, Player, PlayerConfig, RALLIES,
    Racket, RoundTrips, Server, ServerConfig, Turn,
};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;

/// Two who never hit the ball: a rally is over as soon as it has begun. Each end and each beginning is heard to the last.
#[test]
fn the_longest_game_is_over_after_its_last_rally() {
    let mut server = Server::new(ServerConfig { players: 2, rallies: u16::MAX, bounder: false });
    let player = PlayerConfig { number: PeerId(1), court: Court::SINGLES, ball_kg: 0.024, life: 1 };
    let (mut player, mut out) = (Player::new(player), Outbox::<_, 64>::new());
    let (mut number, mut ended, mut begun) = (0, 0, 0);
    while server.game().phase != Phase::Over {
        assert!(ended < u16::MAX, "it never ends");
        number += 1;
        let (revision, turn) = (server.game().revision, Turn { rally: server.game().rally, stroke: 0 });
        for from in [1, 2].map(PeerId) {
            let racket = Default::default();
            let place = Message::Place { turn, revision, life: 1, number, round_trip_us: 1_000, racket };
            server.receive(0, from, &Message::Join, &mut out);
            server.receive(0, from, &place, &mut out);
        }
        if let Some(active) = server.game().active(0) {
            let turn = Turn { rally: server.game().rally, stroke: 0 };
            server.receive(0, active, &Message::Miss { turn, ending: Ending::Missed }, &mut out);
        }
        while let Some((_, message)) = out.pop_front() {
            player.receive(0, PeerId(0), &message, &mut Outbox::<_, 64>::new());
        }
        while let Some(notice) = player.take_notice() {
            match notice {
                Notice::Begins(rally) => {
                    begun += 1;
                    assert_eq!(rally, begun);
                }
                Notice::Ends { verdict, .. } => {
                    ended += 1;
                    assert_eq!((verdict.rally, verdict.ending), (ended, Ending::Missed));
                }
                Notice::Hit { .. } => panic!("nobody hits"),
            }
        }
    }
    assert_eq!((begun, ended), (RALLIES, RALLIES));
    assert_eq!(player.game(), server.game());
}

#[test]
fn the_flight_is_what_small_steps_make() {
    let court = Court::SINGLES;
    for (vx, vy) in [(20.0, 3.0), (30.0, -25.0), (8.0, 40.0), (-4.0, 11.0)] {
        let start = Ball { position: [4.0, 2.0], velocity: [vx, vy] };
        // Second method: step by step in f64, turning at the walls.
        let ([mut x, mut y], [mut u, mut w]) = ([4.0_f64, 2.0], [f64::from(vx), f64::from(vy)]);
        let step = 1e-5;
        for n in 1..200_000 {
            x += u * step;
            y += w * step;
            if x < 0.0 {
                let left = f64::from(court.leaves_s(&start));
                assert!((left - f64::from(n) * step).abs() < 2e-5, "{left}");
                break;
            }
            for (at, speed, wall) in [(&mut x, &mut u, court.length_m), (&mut y, &mut w, court.width_m)] {
                let wall = f64::from(wall);
                if *at > wall || (*at < 0.0 && wall < 7.0) {
                    *at = if *at > wall { 2.0 * wall - *at } else { -*at };
                    *speed = -*speed;
                }
            }
            if n % 997 == 0 {
                let ball = court.flight(&start, (f64::from(n) * step) as f32);
                let error = (f64::from(ball.position[0]) - x).abs() + (f64::from(ball.position[1]) - y).abs();
                assert!(error < 1e-4, "{error}");
            }
        }
    }
}

#[test]
fn the_ball_is_always_inside() {
    let court = Court::SINGLES;
    let numbers = [f32::NAN, f32::INFINITY, -1e30, -3.0, -0.0, 1e-30, 5.0, 1e30];
    for x in numbers {
        for v in numbers {
            for t in numbers {
                let Ball { position: [x, y], .. } = court.flight(&Ball { position: [x, v], velocity: [v, x] }, t);
                assert!((0.0..=9.75).contains(&x) && (0.0..=6.4).contains(&y), "{x} {y}");
            }
        }
    }
}

#[test]
fn momentum_and_energy_stay() {
    for n in 0..10_000 {
        let wave = |k: f64| (f64::from(n) * k).sin() as f32;
        let racket = Racket {
            mass_kg: 0.2 + 0.1 * wave(0.9),
            velocity: [30.0 * wave(1.3), 9.0 * wave(2.1)],
            normal: [wave(0.4), wave(1.7)],
        };
        let (ball_kg, before) = (0.024, [40.0 * wave(3.1), 30.0 * wave(0.2)]);
        let Some(after) = racket.hit(ball_kg, before) else { continue };
        let impact = Impact::between(ball_kg, before, after);
        let [ball, mass] = [ball_kg, racket.mass_kg].map(f64::from);
        let square = |v: [f64; 2]| v[0] * v[0] + v[1] * v[1];
        let moved = [0, 1].map(|axis| f64::from(racket.velocity[axis]) + f64::from(impact.recoil_n_s[axis]) / mass);
        let energy =
            |ball_v: [f32; 2], racket_v: [f64; 2]| ball * square(ball_v.map(f64::from)) + mass * square(racket_v);
        let (first, last) = (energy(before, racket.velocity.map(f64::from)), energy(after, moved));
        assert!((last - first).abs() < 2e-5 * first, "{first} {last}");
        assert_eq!(impact.pulse_n(0.5), impact.recoil_n_s.map(|momentum| 2.0 * momentum));
    }
}

#[test]
fn what_moves_apart_or_looks_nowhere_does_not_hit() {
    let racket = Racket { mass_kg: 1.0, velocity: [1.0, 0.0], normal: [1.0, 0.0] };
    assert_eq!(racket.hit(1.0, [2.0, 0.0]), None);
    assert_eq!(racket.hit(1.0, [0.0, 3.0]), Some([1.0, 3.0]));
    assert_eq!(Racket { normal: [0.0; 2], ..racket }.hit(1.0, [0.0; 2]), None);
    assert_eq!(Racket { velocity: [f32::NAN, 0.0], ..racket }.hit(1.0, [0.0; 2]), None);
}

#[test]
fn a_limited_velocity_is_within_both_bounds() {
    let bounds = BallBounds::new(9.75, 400_000);
    assert!((bounds.speed_m_per_s - 24.375).abs() < 1e-4);
    for n in 0..10_000 {
        let turn = |k: f64| ((f64::from(n) * k).sin() * 24.0 / 1.5) as f32;
        let (before, wish) = ([turn(1.1), turn(0.7)], [turn(0.3) * 5.0, turn(1.9) * 5.0]);
        let [x, y] = bounds.limit(before, wish).map(f64::from);
        let (dx, dy) = (x - f64::from(before[0]), y - f64::from(before[1]));
        assert!(x.hypot(y) <= 24.375 && dx.hypot(dy) <= 48.75 + 1e-3);
    }
    assert_eq!(BallBounds::new(9.75, 0).limit([1.0, 2.0], [500.0, 3.0]), [500.0, 3.0]);
    assert_eq!(bounds.limit([-10.0, 0.0], [10.0, 5.0]), [10.0, 5.0]);
    for huge in [1e30, -1e30, f32::MAX, f32::INFINITY] {
        let [x, y] = bounds.limit([1.0, -huge], [huge, 2.0]).map(f64::from);
        assert!(x.hypot(y) <= 24.375 && x.hypot(y) > 24.374, "{x} {y}");
    }
}

#[test]
fn a_hand_moves_no_farther_than_its_reach_in_a_round_trip() {
    let bounder = MotionBounder { force_n: 60.0, reach_m: 2.0 };
    for (round_trip_us, mass_kg) in [(10_000, 0.1), (100_000, 1.0), (400_000, 3.0)] {
        let damping = f64::from(bounder.damping_n_s_per_m(round_trip_us));
        // Pushed for 20 s as hard as it goes: x = F/b·(t − τ·(1 − e^(−t/τ))), τ = m/b; the last round trip counts.
        let (force, tau) = (60.0, mass_kg / damping);
        let place = |t: f64| force / damping * (t - tau * (1.0 - (-t / tau).exp()));
        let moved = place(20.0) - place(20.0 - f64::from(round_trip_us) * 1e-6);
        assert!(moved <= 2.0 * (1.0 + 1e-6) && moved > 1.9, "{moved}");
    }
    assert_eq!(bounder.damping_n_s_per_m(0), 0.0);
}

#[test]
fn the_longest_round_trip_is_forgotten_after_10_seconds() {
    let mut trips = RoundTrips::default();
    assert_eq!(trips.longest_us(), 0);
    trips.add(0, 300_000);
    for second in 1..20 {
        trips.add(second * 1_000_000, 50_000);
        assert_eq!(trips.longest_us(), if second < 10 { 300_000 } else { 50_000 }, "{second}");
    }
    trips.add(0, 70_000);
    trips.add(u64::MAX, 20_000);
    assert_eq!(trips.longest_us(), 20_000);
}
