//! Any event from anybody at any time, to every role's machines: no panic, one encoding only, and no force that is no number.

use cohold_environments::roles::collaborative::{Lease, lock, ring};
use cohold_environments::roles::squash::{Ball, Court, Player, PlayerConfig, Racket, ServerConfig};
use cohold_environments::roles::{Carried as _, Outbox, Role, cooperative, squash};
use cohold_protocol::wire::{Event, PeerId};

use super::script::Script;

const QUEUE: usize = 8;

/// A script, and what time it is.
struct Anything<'a> {
    script: Script<'a>,
    now: u64,
}

impl Anything<'_> {
    /// The next event, from whom, and what the user does then; time may leap, and stand still.
    fn next(&mut self, code: u16) -> (PeerId, Event, u8) {
        let (who, how) = (self.script.byte(), self.script.byte());
        self.now = match how % 16 {
            15 => self.now.saturating_add(u64::from(self.script.half()) << (how / 16 * 3)),
            0 => self.now,
            _ => self.now.saturating_add(self.script.time_us()),
        };
        let payload = self.script.bytes(usize::from(who / 4).min(Event::MAX_PAYLOAD));
        (PeerId(who % 4), Event::new(code, payload).expect("a short payload"), how / 16)
    }
}

/// One input: the first byte says for which role.
pub(super) fn run(bytes: &[u8]) {
    let mut script = Script(bytes);
    let role = script.byte() % 4;
    let any = Anything { script, now: 0 };
    match role {
        0 => locks(any),
        1 => rings(any),
        2 => engines(any),
        _ => games(any),
    }
}

fn lease() -> Lease {
    Lease::new(100_000).expect("an allowed lease")
}

fn locks(mut any: Anything) {
    let mut out = Outbox::<_, QUEUE>::new();
    let mut server = lock::Server::<3>::new(lease(), [0; 24]);
    let mut client = lock::Client::new(PeerId(0), lease(), 1, [0; 24]);
    while any.script.goes_on() {
        let (from, event, act) = any.next(lock::Message::CODE);
        if let Ok((object, message)) = lock::Message::parse(&event) {
            assert_eq!(message.event(object), Ok(event));
            server.receive(any.now, from, &message, &mut out);
            client.receive(any.now, from, &message, &mut out);
        }
        match act {
            0 => client.ask(any.now),
            1 => client.withdraw(&mut out),
            2 => drop(client.release(any.now, Some([1; 24]), &mut out)),
            3 => server = lock::Server::restore(lease(), any.now, server.record().clone()),
            _ => client.poll(any.now, &mut out),
        }
        server.poll(any.now, &mut out);
        assert!(server.waiting() <= 3);
        while out.pop_front().is_some() {}
    }
}

fn rings(mut any: Anything) {
    let founders = ring::Roster::of(0..3);
    let config = ring::Config { seat: 1, contacts: founders, lease: lease(), turn_us: 1, seed: u64::MAX };
    let mut out = Outbox::<_, QUEUE>::new();
    let mut ring = ring::Ring::new(config, 0, ring::Record::founder(founders, [0; 24]));
    while any.script.goes_on() {
        let (from, event, act) = any.next(ring::Message::CODE);
        if let Ok((object, message)) = ring::Message::parse(&event) {
            assert_eq!(message.event(object), Ok(event));
            ring.receive(any.now, from, &message, &mut out);
        }
        match act {
            0 => ring.ask(),
            1 => drop(ring.publish(any.now, [1; 24], &mut out)),
            2 => ring.give_up(any.now, &mut out),
            3 => ring = ring::Ring::new(config, any.now, *ring.record()),
            _ => ring.poll(any.now, &mut out),
        }
        while out.pop_front().is_some() {}
    }
    ring.leave();
    ring.poll(any.now, &mut out);
}

fn engines(mut any: Anything) {
    let mut server = cooperative::Server::new(lease());
    let mut client = cooperative::Client::new(PeerId(0), lease());
    let (mut body, mut out) = (cooperative::Body::default(), Outbox::<_, QUEUE>::new());
    while any.script.goes_on() {
        let (from, event, act) = any.next(cooperative::Message::CODE);
        if let Ok((object, message)) = cooperative::Message::parse(&event) {
            assert_eq!(message.event(object), Ok(event));
            server.moves(body);
            server.receive(any.now, from, &message, &mut out);
            body = server.take_notice().unwrap_or(body);
            client.receive(any.now, PeerId(0), &message, &mut out);
        }
        match act {
            0 => client.ask(any.now),
            1 => client.give_back(any.now, body),
            2 => server.recall(any.now),
            3 => server.take_state(from, server.version(), cooperative::Body { axes: [[f64::NAN; 2]; 2] }),
            _ => client.poll(any.now, &mut out),
        }
        server.poll(any.now, &mut out);
        body = server.take_notice().unwrap_or(body);
        while out.pop_front().is_some() {}
        assert!(body.axes.iter().flatten().all(|number| number.is_finite()), "{body:?}");
        assert!(server.has_engine() == server.lent_to().is_none());
    }
}

fn games(mut any: Anything) {
    let mut out = Outbox::<_, QUEUE>::new();
    let mut server = squash::Server::new(ServerConfig { players: 2, rallies: 3, bounder: true });
    let mut player = Player::new(PlayerConfig { number: PeerId(1), court: Court::SINGLES, ball_kg: 0.024, life: 1 });
    // The clock of the server is known; it would take a script long to find out how.
    let said = squash::Message::Pong { number: 1, sent_us: 0, received_us: 7, answered_us: 7 };
    player.poll(any.now, &mut out);
    player.receive(any.now, PeerId(0), &said, &mut out);
    while any.script.goes_on() {
        let (from, event, act) = any.next(squash::Message::CODE);
        if let Ok((_, message)) = squash::Message::parse(&event) {
            assert_eq!(message.event(0), Ok(event));
            server.receive(any.now, from, &message, &mut out);
            player.receive(any.now, from, &message, &mut out);
        }
        if act > 8 {
            player.place(Ball { position: [f32::NAN, -1e30], velocity: [f32::INFINITY, 0.0] });
            let velocity = [f32::from(act) * 10.0, 1.0];
            let racket = Racket { mass_kg: 0.1, velocity, normal: [1.0, f32::from(act) - 12.0] };
            if let Some(strike) = player.hit(any.now, &racket, &mut out) {
                let felt = strike.impact.velocity.iter().chain(&strike.impact.recoil_n_s);
                assert!(felt.clone().all(|part| part.is_finite()), "{strike:?}");
            }
        }
        server.poll(any.now, &mut out);
        player.poll(any.now, &mut out);
        if let Some(Ball { position: [x, y], .. }) = player.ball(any.now) {
            assert!((0.0..=9.75).contains(&x) && (0.0..=6.4).contains(&y), "{x} {y}");
        }
        while out.pop_front().is_some() {}
    }
}
