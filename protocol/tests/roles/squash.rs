//! A game of squash, as long as one can be.

use haptic_protocol::roles::squash::{
    Court, Ending, Message, Notice, Phase, Player, PlayerConfig, RALLIES, Server, ServerConfig, Turn,
};
use haptic_protocol::roles::{Outbox, Role};
use haptic_protocol::wire::PeerId;

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
        while let Some((_, message)) = out.take() {
            player.receive(0, PeerId(0), &message, &mut Outbox::<_, 64>::new());
        }
        while let Some(notice) = player.take_notice() {
            match notice {
                Notice::Begins { rally } => {
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
