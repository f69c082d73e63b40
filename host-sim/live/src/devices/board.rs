//! A board as the device of this peer: the object, the law and the other person are here; the board closes nothing but its own motors' loop.
//!
//! No protocol of its own. The board is a peer as ever, whose law is four channels without a spring, at its device (`board-device`,
//! [`cohold_core::law::four_channel`]): what it hears is a force to give, what it says is where its hand is and what force acts. This end is the
//! other peer of its sealed line. It reads what has come and says the newest force in the tick itself; sockets do not block.
//!
//! **Age.** A place is of the tick before it was sealed, by the shared clock; half of the round trip may be wrong in that, and counts as age.
//!
//! **Letting go.** Who lets go says a force of zero; so it is where the peer has said nothing for as long as readings may be silent, and
//! then, and between two ticks that are late, a thread speaks. From a process that is stopped, or killed, nothing comes: the board's own ladder
//! (`safety.fade_s`, `disengage_s`) then ends the force. **Nothing here arms a board**, or may: its operator does, under another key, and holds its lease.

use std::io::ErrorKind;
use std::net::{SocketAddr, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, TryLockError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use cohold_core::law::degradation::STEP_N;
use cohold_core::law::{AnyLaw, Law, Packet};
use cohold_core::num::Motion;
use cohold_core::safety::Fault;
use cohold_protocol::aged::Aged;
use cohold_protocol::end::End as _;
use cohold_protocol::key::Key;
use cohold_protocol::link::Error as Refusal;
use cohold_protocol::peer::flow_of;
use cohold_protocol::wire::{Flows, Goodbye, MAX_DATAGRAM, Message, Telemetry};
use cohold_sim::device::{DeviceFault, Gone};
use cohold_sim::{of_axes, scene::Scene};

use super::threaded::stopped;
use super::{AXES, Abilities, Port, Sensed};
use crate::endpoint::realtime_beneath;
use crate::{Error, key_file::entropy, node::Line};

/// The scene of a board that is a device, where no other is named.
pub const SCENE: &str = "board-device";
/// The port of a board's flow.
pub const PORT: u16 = 7701;
/// How long a board may take to answer.
const PATIENCE: Duration = Duration::from_secs(3);
/// After so long without a tick of the peer the board is spoken to nevertheless.
const BEAT: Duration = Duration::from_millis(5);
/// Between two looks at what has come, at first.
const LOOK: Duration = Duration::from_millis(1);
/// How long a board whose motors went off may take to say why, if it does.
const TELLS: Duration = Duration::from_millis(40);
/// What is taken of a socket at once: all that comes in a second, from a board that is not spoken to either.
const MOST: usize = 2_000;

/// What is told of a board.
#[derive(Clone, Debug)]
pub struct Told {
    /// Where it is.
    pub at: SocketAddr,
    /// Where this end listens: where the board's flow goes.
    pub listen: SocketAddr,
    /// The key that both hold.
    pub key: Key,
    /// The scene that it was given.
    pub scene: Box<Scene>,
}

/// What is under way between tick, thread and board.
struct Talk<const SHARED: usize> {
    socket: UdpSocket,
    board: SocketAddr,
    line: Line<SHARED>,
    begun: Instant,
    period: Duration,
    ticks: u32,
    /// The force that is wanted, N, and when that was.
    order: Option<Aged<[f64; AXES], Instant>>,
    /// An order may be this old.
    silent: Duration,
    /// When something was said last.
    said: Instant,
    /// Nothing is said until then.
    mute: Option<Instant>,
    newest: Option<Sensed>,
    /// Largest force that acts, by the board's word, N.
    acts_n: f64,
    /// Since when its motors are off.
    off: Option<Instant>,
    gone: Option<Gone>,
}

impl<const SHARED: usize> Talk<SHARED> {
    fn now_us(&self) -> u64 {
        self.begun.elapsed().as_micros() as u64
    }

    /// Takes what has come.
    fn hear(&mut self) {
        let mut datagram = [0; MAX_DATAGRAM];
        for _ in 0..MOST {
            match self.socket.recv_from(&mut datagram) {
                Ok((length, from)) if from == self.board => self.take(&mut datagram[..length]),
                Err(cause) if cause.kind() == ErrorKind::WouldBlock => return,
                // What somebody else says is nothing, and what a socket says of one datagram may be good of the next.
                _ => {}
            }
        }
    }

    /// Takes a datagram of the board's.
    fn take(&mut self, datagram: &mut [u8]) {
        let now_us = self.now_us();
        match self.line.receive(now_us, self.ticks, datagram) {
            Ok(Some(flow)) if flow.engaged => self.place(now_us, &flow),
            Ok(Some(_)) if self.newest.is_some() && self.off.is_none() => {
                self.off = Some(Instant::now());
                self.line.heard = None;
            }
            Err(Refusal::Impossible(what)) => {
                let cause = format!("the board told a {what} that cannot be");
                self.gone = self.gone.take().or(Some(Gone::new(DeviceFault::Implausible, cause)));
            }
            _ => {}
        }
    }

    /// Takes where the hand was, and what acts on it.
    fn place(&mut self, now_us: u64, flow: &Flows<SHARED>) {
        let round_us = u64::from(self.line.link.clock().round_trip_us().unwrap_or_default());
        let ago_us = now_us.saturating_sub(self.line.sealed_us(now_us)) + round_us / 2;
        let heard = Instant::now();
        let asked = heard.checked_sub(self.period + Duration::from_micros(ago_us)).unwrap_or(self.begun);
        let along = |of: fn(&cohold_protocol::wire::AxisFlow) -> f32| {
            std::array::from_fn(|axis| flow.axes.get(axis).map_or(0.0, |along| f64::from(of(along))))
        };
        self.newest = Some(Sensed {
            position_m: along(|along| along.position),
            velocity_m_per_s: along(|along| along.velocity),
            between: [asked, heard],
            buttons: 0,
        });
        self.acts_n = flow.axes.iter().map(|along| along.wave_integral.abs()).fold(0.0, f64::max);
    }

    /// Says the force of now, unless nothing is to be said.
    fn speak(&mut self) {
        let now = Instant::now();
        if self.mute.is_some_and(|until| now < until) {
            return;
        }
        let wanted = self.order.as_ref().and_then(|order| order.within(now, self.silent)).copied();
        let mut forces = wanted.unwrap_or_default().into_iter();
        let packets = std::array::from_fn(|_| Packet::<f64> {
            motion: Motion::at(0.0),
            wave: forces.next().unwrap_or_default(),
            ..Packet::default()
        });
        self.say(flow_of::<f64, SHARED>(packets, true, self.ticks));
        self.ticks = self.ticks.wrapping_add(1);
        self.said = now;
    }

    /// Says something, and what the link has to say; a datagram that the system does not take is late.
    fn say(&mut self, message: impl Into<Message>) {
        let (now_us, socket, board) = (self.now_us(), &self.socket, self.board);
        let mut send = |bytes: &[u8]| drop(socket.send_to(bytes, board));
        self.line.link.say_due(now_us, &mut send);
        self.line.heed(now_us);
        self.line.link.say(now_us, message, send);
    }

    /// Where the hand was.
    fn told(&mut self) -> Result<Option<Sensed>, Gone> {
        if let (None, Some(off)) = (&self.gone, self.off) {
            let said = self.line.heard.as_ref().map(why);
            if said.is_some() || off.elapsed() > TELLS {
                self.gone = said.or_else(|| Some(stopped("its motors went off: its operator's port says why")));
            }
        }
        self.gone.clone().map_or(Ok(self.newest), Err)
    }
}

/// Why a board's motors are off, by what it tells of itself.
fn why(said: &Telemetry) -> Gone {
    let Some(fault) = Fault::from_number(said.fault).filter(|_| said.mode == 2) else {
        return stopped("its motors were turned off at the board, or by its operator");
    };
    let kind = match fault {
        Fault::MotorTooWarm => DeviceFault::TooWarm,
        Fault::SupplyOutOfRange => DeviceFault::Supply,
        Fault::PeerLost | Fault::PeerDelayed => DeviceFault::LetGo,
        Fault::NonFiniteInput | Fault::EncoderJump | Fault::LostCounts | Fault::EncoderImplausible => {
            DeviceFault::Implausible
        }
        _ => DeviceFault::Motor,
    };
    Gone::new(kind, format!("the board's fault {}: {}", fault.number(), fault.explain()))
}

/// A board that is spoken to.
struct Board<const SHARED: usize> {
    abilities: Abilities,
    talk: Arc<Mutex<Talk<SHARED>>>,
    newest: Result<Option<Sensed>, Gone>,
    ends: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// The board of this key, whichever of the two it is, once its motors are on. A force that is not renewed for `silent` is no longer said.
///
/// # Errors
/// It does not answer, was told other parameters, or its motors are off; or its scene is not that of a device.
pub(super) fn open(told: &Told, silent: Duration) -> Result<Box<dyn Port>, Error> {
    let scene = &*told.scene;
    let law = AnyLaw::<f64>::build(&scene.peer).map_err(|refused| refused.to_string())?;
    cohold_sim::refuse_if!(
        !law.acts_on_device(),
        "the board's scene is not that of a device: its law is to be as in {SCENE}"
    );
    of_axes!(scene, talk(told, silent))
}

/// [`open`], of a board that shares `SHARED` axes.
fn talk<const SHARED: usize, const N: usize>(told: &Told, silent: Duration) -> Result<Box<dyn Port>, Error> {
    let (listen, scene) = (&told.listen, &told.scene);
    let cannot = cohold_sim::Error::cannot::<std::io::Error>("listen on", listen);
    let socket = UdpSocket::bind(listen).map_err(&cannot)?;
    socket.set_nonblocking(true).map_err(&cannot)?;
    let begin = |number: u8| -> Result<Talk<SHARED>, Error> {
        Ok(Talk {
            socket: socket.try_clone().map_err(&cannot)?,
            board: told.at,
            line: Line::open(scene, 3 - number, told.key.clone(), entropy()?)?,
            begun: Instant::now(),
            period: Duration::from_secs_f64(scene.peer.timing.control_period_s),
            ticks: 0,
            order: None,
            silent,
            said: Instant::now(),
            mute: None,
            newest: None,
            acts_n: 0.0,
            off: None,
            gone: None,
        })
    };
    // Either board may be there: both are called, and the one that is there answers.
    let mut both = [begin(1)?, begin(2)?];
    let by = Instant::now() + PATIENCE;
    let mut datagram = [0; MAX_DATAGRAM];
    let found = loop {
        both.iter_mut().for_each(Talk::speak);
        std::thread::sleep(LOOK);
        while let Ok((length, from)) = socket.recv_from(&mut datagram) {
            for talk in both.iter_mut().filter(|_| from == told.at) {
                let mut copy = datagram;
                talk.take(&mut copy[..length]);
            }
        }
        if let Some(found) = both.iter().position(|talk| talk.newest.is_some()) {
            break found;
        }
        if Instant::now() < by {
            continue;
        }
        let why = match both.iter().find_map(|talk| talk.line.link.refused()) {
            Some(table) => {
                format!("was told other parameters: table [{table}] differs. Send it the scene that is named here")
            }
            None if both.iter().any(|talk| talk.line.link.is_up()) => {
                "has its motors off: arm it at its operator's port".to_owned()
            }
            None => "does not answer, or holds another key, or sends elsewhere (network.peer)".to_owned(),
        };
        return Err(format!("the board at {} {why}", told.at).into());
    };
    let number = found as u8 + 1;
    let [one, two] = both;
    let talk = if number == 1 { one } else { two };
    let peers = scene.peers();
    let (safety, timing) = (&peers[found].safety, &scene.peer.timing);
    let falls_s = safety.max_force_n / STEP_N * timing.control_period_s;
    let abilities = Abilities {
        name: format!("board {number} at {}", told.at),
        axes: SHARED,
        workspace_m: Some([2.0 * safety.workspace_m; AXES]),
        max_force_n: Some(safety.max_force_n),
        // It is armed, and so has found its signs and its zero.
        is_homed: true,
        buttons: 0,
        lets_go_s: Some(safety.disengage_s + falls_s + 2.0 * timing.packet_period_s()),
    };
    Ok(Box::new(Board::start(abilities, talk)?))
}

impl<const SHARED: usize> Board<SHARED> {
    fn start(abilities: Abilities, talk: Talk<SHARED>) -> Result<Self, Error> {
        let (talk, ends) = (Arc::new(Mutex::new(talk)), Arc::new(AtomicBool::new(false)));
        let (of_thread, until) = (talk.clone(), ends.clone());
        let run = move || {
            realtime_beneath();
            while !until.load(Ordering::Relaxed) {
                std::thread::sleep(BEAT);
                let Ok(mut talk) = of_thread.lock() else { return };
                if talk.said.elapsed() >= BEAT {
                    talk.hear();
                    talk.speak();
                }
            }
        };
        let thread = std::thread::Builder::new().name("device".to_owned()).spawn(run);
        let thread = thread.map_err(|cause| format!("{}: no thread: {cause}", abilities.name))?;
        Ok(Self { abilities, talk, newest: Ok(None), ends, thread: Some(thread) })
    }
}

impl<const SHARED: usize> Port for Board<SHARED> {
    fn abilities(&self) -> &Abilities {
        &self.abilities
    }

    fn read(&mut self) -> Result<Option<Sensed>, Gone> {
        match self.talk.try_lock() {
            Ok(mut talk) => {
                talk.hear();
                self.newest = talk.told();
            }
            // The thread is at it.
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Poisoned(_)) => self.newest = Err(stopped("its thread has failed")),
        }
        self.newest.clone()
    }

    fn write(&mut self, force_n: Option<[f64; AXES]>) {
        // Where the thread is just speaking, the next tick's force is the next that is said.
        if let Ok(mut talk) = self.talk.try_lock() {
            talk.order = force_n.map(|force_n| Aged::new(force_n, Instant::now()));
            talk.speak();
        }
    }

    fn stay_silent(&mut self, time: Duration) -> Result<Option<f64>, Gone> {
        let until = Instant::now() + time;
        let failed = || stopped("its thread has failed");
        self.talk.lock().map_err(|_| failed())?.mute = Some(until);
        std::thread::sleep(time);
        let mut talk = self.talk.lock().map_err(|_| failed())?;
        talk.hear();
        let told = talk.told()?;
        // What was wanted before a silence is not wanted after it.
        (talk.mute, talk.order) = (None, talk.order.filter(|order| order.at > until));
        Ok(told.map(|_| talk.acts_n))
    }
}

impl<const SHARED: usize> Drop for Board<SHARED> {
    fn drop(&mut self) {
        self.ends.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

impl<const SHARED: usize> Drop for Talk<SHARED> {
    /// No force, and then nobody: the board disengages at once.
    fn drop(&mut self) {
        let now_us = self.begun.elapsed().as_micros() as u64;
        let (socket, board) = (&self.socket, self.board);
        self.line.link.say(now_us, Goodbye {}, |bytes| drop(socket.send_to(bytes, board)));
    }
}
