//! From a link to a key: the agreement of an invite over a socket of its own, before any flow.
//!
//! The seat that it takes at the meeting place is that of the invite's room, which nobody needs once the key is agreed on: the session's room is made of the key. Who
//! invites goes on answering there until the invite's ten minutes are over or the program ends, so that an answer that was lost is given
//! again, and so that whoever else comes with the link is refused and told of.

use std::io::{ErrorKind, IsTerminal, stdin};
use std::net::{SocketAddr, UdpSocket};
use std::time::{Duration, Instant};

use crate::agreement::{Accepter, Heard, Inviter, LIFE, code};
use crate::frame::Frame;
use crate::invite::Invite;
use crate::seat::Seat;
use cohold_protocol::key::Key;

use crate::carried::resolve;
use cohold_live::addresses::any_towards;
use cohold_live::endpoint::Stop;
use cohold_live::refused::Refused;
use cohold_live::{Error, key_file::entropy};

/// Longest wait for a datagram, before the clock is looked at.
const LOOK: Duration = Duration::from_millis(10);
/// Between two offers.
const AGAIN: Duration = Duration::from_millis(100);
/// Who accepts waits so long for who invites.
const PATIENCE: Duration = Duration::from_secs(30);
/// Reported of an offer that comes after another one was taken.
const SECOND: &str = "somebody else came with the link and was refused: it had been used";

fn random() -> Result<Key, Error> {
    Ok(Key::new(entropy()?))
}

/// A seat in an invite's room, with its socket.
struct Room {
    socket: UdpSocket,
    place: SocketAddr,
    seat: Seat,
    began: Instant,
    told: Refused<(), &'static str>,
}

impl Room {
    fn enter(invite: &Invite, side: u8) -> Result<Self, Error> {
        let place = resolve(&invite.meet)?;
        let cannot = cohold_sim::Error::cannot::<std::io::Error>("reach the meeting place", &invite.meet);
        let socket = UdpSocket::bind(any_towards(place)).map_err(&cannot)?;
        // A connected socket takes from there alone.
        socket.connect(place).and_then(|()| socket.set_read_timeout(Some(LOOK))).map_err(&cannot)?;
        Ok(Self { socket, place, seat: invite.seat(side, &random()?), began: Instant::now(), told: Refused::default() })
    }

    /// Keeps the seat, and waits a moment for what comes of the agreement.
    fn hear(&mut self, room: &mut [u8; 256]) -> Result<Option<usize>, Error> {
        let now = Instant::now();
        if let Some(join) = self.seat.poll(now, false) {
            let _ = self.socket.send(&join);
        }
        match self.socket.recv(room) {
            Ok(length) if Frame::of(&room[..length]) == Frame::Agreement => Ok(Some(length)),
            Ok(length) if self.seat.hear(now, &room[..length]) == Some(true) => self.hear(room),
            Ok(_) => Ok(None),
            Err(cause) if matches!(cause.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => Ok(None),
            // A meeting place that is down may come up.
            Err(_) => {
                std::thread::sleep(LOOK);
                Ok(None)
            }
        }
    }

    /// Fails where it is known after a moment that nobody can be met.
    fn check(&self) -> Result<(), Error> {
        let place = self.place;
        cohold_sim::refuse_if!(
            self.began.elapsed() > Duration::from_secs(3) && self.seat.refused,
            "the meeting place {place} has no seat: it is full, or too many have come from here"
        );
        Ok(())
    }
}

/// Waits for who has the link, up to its ten minutes; `say` is told what else comes with it, now and later.
///
/// # Errors
/// Nobody came, the meeting place has no seat, or the program was asked to stop.
pub fn invite(mut inviter: Inviter, stop: &Stop, say: impl Fn(&str) + Send + 'static) -> Result<Key, Error> {
    let mut room = Room::enter(&inviter.invite, 0)?;
    let key = loop {
        cohold_sim::refuse_if!(stop.is_asked(), "nobody has come with the link yet");
        if inviter.is_over(Instant::now()) {
            return Err(crate::Error::Over.into());
        }
        room.check()?;
        if let Some(Heard::Agreed(key)) = answer(&mut room, &mut inviter, &say)? {
            break key;
        }
    };
    let life = Instant::now() + LIFE;
    let goes_on = move || {
        while Instant::now() < life && answer(&mut room, &mut inviter, &say).is_ok() {}
    };
    // Without the thread an answer that is lost is not given again.
    let _ = std::thread::Builder::new().name("invitation".to_owned()).spawn(goes_on);
    Ok(key)
}

/// Answers what comes, and says what is to be known of it.
fn answer(room: &mut Room, inviter: &mut Inviter, say: &impl Fn(&str)) -> Result<Option<Heard>, Error> {
    let mut bytes = [0; 256];
    let Some(length) = room.hear(&mut bytes)? else { return Ok(None) };
    let (answer, heard) = inviter.hear(Instant::now(), &bytes[..length]);
    if let Some(answer) = answer {
        let _ = room.socket.send(&answer);
    }
    if heard == Heard::Second {
        room.told.note((), SECOND);
    }
    if let Some(((), words)) = room.told.take(room.began.elapsed().as_micros() as u64) {
        say(words);
    }
    Ok(Some(heard))
}

/// Uses a link.
///
/// # Errors
/// It has been used, nobody is there, the meeting place has no seat, or the program was asked to stop.
pub fn accept(invite: &Invite, stop: &Stop) -> Result<Key, Error> {
    let mut room = Room::enter(invite, 1)?;
    let accepter = Accepter::new(invite, &random()?);
    let (mut offered, mut bytes) = (None::<Instant>, [0; 256]);
    while room.began.elapsed() < PATIENCE && !stop.is_asked() {
        room.check()?;
        let due = offered.is_none_or(|at| at.elapsed() >= AGAIN);
        if due && room.seat.other_is_there(Instant::now()) {
            offered = Some(Instant::now());
            let _ = room.socket.send(&accepter.offer());
        }
        if let Some(length) = room.hear(&mut bytes)?
            && let Some(key) = accepter.hear(&bytes[..length])?
        {
            return Ok(key);
        }
    }
    let place = room.place;
    Err(match (room.seat.is_seated(Instant::now()), offered) {
        (false, _) => format!("the meeting place {place} does not answer"),
        (true, None) => "nobody who invites is there: is the link still open on the other side?".to_owned(),
        (true, Some(_)) => "who invites does not answer this link: it is over, or somebody else used it".to_owned(),
    }
    .into())
}

/// Shows the code of a new key. If a person is at the terminal, waits until that person has compared it. Gives the code.
///
/// # Errors
/// The person says that the other end shows another code.
pub fn compare(key: &Key) -> Result<String, Error> {
    let code = code(key);
    cohold_io::say(format_args!("code of this meeting: {code}"));
    cohold_io::say(
        "compare it aloud with the other person before anybody holds a device: both ends must show these digits",
    );
    if stdin().is_terminal() {
        cohold_io::say("press Enter if they are the same; if not, type no");
        let said = stdin().lines().next().and_then(Result::ok);
        cohold_sim::refuse_if!(
            said.is_none_or(|said| !said.trim().is_empty()),
            "the codes differ, so somebody may be between you: make a new link and send it another way"
        );
    }
    Ok(code)
}
