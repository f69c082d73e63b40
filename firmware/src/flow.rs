//! The flow to and from the other peer: the 8 ms exchange, sealed ([`Link`]). Never waits for the network.
//!
//! From port 7701 to port 7701, one datagram each packet period, the moment the tick has made it. A datagram that cannot be
//! handed to the driver now (neighbour unresolved, link down, queue full) is dropped: the next one is newer. Of what comes in
//! the link takes what is authentic and newer than the last; only flow of a peer whose motors are on reaches the tick. When
//! the link lets go of the other peer, the tick does too ([`Signals::life`]).

use cohold_core::law::{Law as _, bounds::Bounds};
use cohold_core::settings::Settings;
use cohold_protocol::end::End;
use cohold_protocol::link::{ConfigError, Error as Refusal, Link, Notice};
use cohold_protocol::peer::{Lives, flow_of, open, packets_of};
use cohold_protocol::wire::{Datagram, Flows, MAX_DATAGRAM};
use cohold_protocol::{ends::Ends, key::Key};
use embassy_futures::select::{Either3, select3};
use embassy_net::{IpEndpoint, Stack};
use embassy_sync::{blocking_mutex::raw::CriticalSectionRawMutex, signal::Signal};
use embassy_time::Instant;
use firmware_parts::exchange::{Reader, Writer};
use firmware_parts::image::{Law, SHARED};
use firmware_parts::signals::Signals;

use crate::board::{Number, pace, random};
use crate::log::log;
use crate::sockets::{self, send_now};
use crate::tick::{Outgoing, Received};

/// Port of the flow, at both ends.
pub(crate) const PORT: u16 = 7701;

/// Settings that the tick has taken: the link has to agree with the other peer about them anew.
static TOLD: Signal<CriticalSectionRawMutex, Settings> = Signal::new();

/// Hands the link the settings that the tick has taken.
pub(crate) fn tell(settings: Settings) {
    TOLD.signal(settings);
}

/// A link to the other peer that begins to call.
///
/// # Errors
/// [`Link::new`]'s: without randomness, that there is none.
pub(crate) fn connect(key: &Key, seed: &Key, number: Number, settings: &Settings) -> Result<Link, ConfigError> {
    let ends = Ends { local: number.peer(), remote: number.other().peer() };
    open(settings, key.clone(), ends, random::draw(seed, number).ok_or(ConfigError::ZeroEntropy)?)
}

/// What the other peer, or a hub, may say with these settings.
pub(crate) fn bounds(settings: &Settings) -> Bounds {
    Law::bounds(settings).beyond_a_junction()
}

pub(crate) struct Flow {
    /// The peers', and what random bytes are mixed with.
    pub(crate) key: Key,
    pub(crate) seed: Key,
    pub(crate) number: Number,
    pub(crate) link: &'static mut Link,
    pub(crate) peer: IpEndpoint,
    pub(crate) outgoing: Reader<'static, Outgoing>,
    pub(crate) incoming: Writer<'static, Received>,
    pub(crate) signals: &'static Signals,
    /// Which life of the other peer what comes is of; the tick knows it by [`Signals::life`].
    pub(crate) lives: Lives<SHARED>,
    /// The link still has the old settings.
    pub(crate) outdated: bool,
}

impl End<SHARED> for Flow {
    fn link(&mut self) -> &mut Link {
        self.link
    }

    fn notice(&mut self, _now_us: u64, notice: Notice) {
        match notice {
            Notice::Joined => log!(info, "peer: joined"),
            Notice::NewPeer(_) => log!(info, "peer: has started anew"),
            Notice::Engaged => log!(info, "peer: engaged, flow comes"),
            Notice::Fading => log!(warn, "peer: fading, no flow comes"),
            Notice::Resumed => log!(info, "peer: resumed, flow again"),
            Notice::Disengaged => {
                log!(warn, "peer: disengaged, no flow for too long or another session");
                self.part();
            }
            Notice::Lost => log!(warn, "peer: lost, silent for too long or another session"),
            Notice::Old(delay_us) => log!(warn, "peer: flow takes {} us, too old to be taken", delay_us),
            Notice::Refused(table) => {
                log!(error, "peer: refused, it was told other settings: table {}", table);
            }
        }
    }

    fn keep(&mut self, _tick: u32, _sealed_us: u64, flow: Flows<SHARED>) -> Result<(), Refusal> {
        self.signals.received.count();
        if self.outdated {
            return Ok(());
        }
        let life = self.lives.of(&flow).inspect_err(|_| {
            log!(warn, "peer: let go of, it says more than the limits in [safety] allow");
            self.part();
        });
        if let Some(life) = life? {
            // First that what came before is not to be taken.
            self.signals.life.release(life);
            self.incoming.write(Received { life, packets: packets_of(&flow) });
        }
        Ok(())
    }
}

impl Flow {
    /// Shows the tick and the log how the link is.
    fn show(&mut self) {
        self.heed(now());
        self.signals.stage.set(self.link.stage());
        self.signals.old.set(self.link.is_old());
    }

    /// The tick lets go of the other peer.
    fn part(&mut self) {
        self.signals.life.release(self.lives.end());
    }

    /// Other settings: the other peer needs them too before the two meet again.
    #[inline(never)]
    fn configure(&mut self, settings: &Settings) {
        self.part();
        self.lives.bound(bounds(settings));
        if let Ok(link) = connect(&self.key, &self.seed, self.number, settings) {
            *self.link = link;
            self.outdated = false;
        } else {
            self.outdated = true;
            log!(error, "peer: no randomness for a new session, so no peer: the old session has the old settings");
        }
    }
}

fn now() -> u64 {
    Instant::now().as_micros()
}

/// Sends what the tick made, the moment it made it, and takes in what the other peer sent.
#[embassy_executor::task]
pub(crate) async fn run(stack: Stack<'static>, mut flow: Flow) -> ! {
    let socket = sockets::socket(stack, PORT);
    let signals = flow.signals;
    let (mut bytes, mut out): (Datagram, Datagram) = ([0; MAX_DATAGRAM], [0; MAX_DATAGRAM]);
    loop {
        match select3(pace::rung(), socket.recv_from(&mut bytes), TOLD.wait()).await {
            Either3::First(()) => {
                if let Some(Outgoing { tick, armed, packets }) = flow.outgoing.take()
                    && !flow.outdated
                    && let Some(length) = flow.link.send(now(), flow_of(packets, armed, tick), &mut out)
                {
                    let sent = send_now(&socket, out.get(..length).unwrap_or_default(), flow.peer).await;
                    (if sent { &signals.sent } else { &signals.dropped }).count();
                }
            }
            Either3::Second(Ok((length, _))) => {
                let datagram = bytes.get_mut(..length).unwrap_or_default();
                if flow.receive(now(), 0, datagram).is_err() {
                    signals.refused.count();
                }
            }
            Either3::Second(Err(_)) => signals.refused.count(),
            Either3::Third(settings) => flow.configure(&settings),
        }
        while let Some(length) = flow.link.poll(now(), &mut out) {
            // What the link repeats by itself needs no count.
            send_now(&socket, out.get(..length).unwrap_or_default(), flow.peer).await;
        }
        flow.show();
    }
}
