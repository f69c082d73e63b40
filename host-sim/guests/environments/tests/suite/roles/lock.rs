//! A lock, message by message.

use cohold_environments::roles::collaborative::lock::{Client, Message, Notice, Phase, Server};
use cohold_environments::roles::collaborative::{Lease, NotOwner};
use cohold_environments::roles::{Outbox, Role};
use cohold_protocol::wire::PeerId;

const SERVER: PeerId = PeerId(0);
const LEASE_US: u32 = 300_000;

fn lease() -> Lease {
    Lease::new(LEASE_US).unwrap()
}

/// One server and two clients on a network that only the test moves.
struct Table {
    server: Server<4>,
    clients: [Client; 2],
    to_server: Vec<(PeerId, Message)>,
    to_clients: Vec<(PeerId, Message)>,
}

impl Table {
    fn new() -> Self {
        Self {
            server: Server::new(lease(), [0; 24]),
            clients: [11, 22].map(|incarnation| Client::new(SERVER, lease(), incarnation, [0; 24])),
            to_server: vec![],
            to_clients: vec![],
        }
    }

    /// Everybody looks at the time; nothing is delivered.
    fn poll(&mut self, now: u64) {
        let mut out = Outbox::<_, 32>::new();
        for (number, client) in (1..).zip(&mut self.clients) {
            client.poll(now, &mut out);
            self.to_server.extend(std::iter::from_fn(|| out.pop_front()).map(|(_, message)| (PeerId(number), message)));
        }
        self.server.poll(now, &mut out);
        self.to_clients.extend(std::iter::from_fn(|| out.pop_front()));
    }

    /// Everything that is on its way arrives, and what is said to it.
    fn deliver(&mut self, now: u64) {
        let mut out = Outbox::<_, 32>::new();
        while !self.to_server.is_empty() || !self.to_clients.is_empty() {
            for (from, message) in std::mem::take(&mut self.to_server) {
                self.server.receive(now, from, &message, &mut out);
                self.to_clients.extend(std::iter::from_fn(|| out.pop_front()));
            }
            for (to, message) in std::mem::take(&mut self.to_clients) {
                self.clients[usize::from(to.0) - 1].receive(now, SERVER, &message, &mut out);
                self.to_server.extend(std::iter::from_fn(|| out.pop_front()).map(|(_, message)| (to, message)));
            }
        }
    }

    fn release(&mut self, now: u64, client: usize, value: u8) -> Result<(), NotOwner> {
        let mut out = Outbox::<_, 32>::new();
        self.clients[client].release(now, Some([value; 24]), &mut out)?;
        let from = PeerId(client as u8 + 1);
        self.to_server.extend(std::iter::from_fn(|| out.pop_front()).map(|(_, message)| (from, message)));
        Ok(())
    }

    fn notices(&mut self, client: usize) -> Vec<Notice> {
        std::iter::from_fn(|| self.clients[client].take_notice()).collect()
    }
}

#[test]
fn first_come_first_served_and_everybody_hears_of_it() {
    let mut table = Table::new();
    table.clients[1].ask(0);
    table.poll(0);
    table.deliver(0);
    table.clients[0].ask(1_000);
    table.poll(1_000);
    table.deliver(1_000);
    assert!(!table.clients[0].owns(1_000) && table.clients[1].owns(1_000));
    assert_eq!((table.server.holder(), table.server.waiting()), (Some(PeerId(2)), 1));
    // Only the owner's edits are copied.
    assert_eq!(table.release(2_000, 0, 9), Err(NotOwner));
    table.release(2_000, 1, 7).unwrap();
    table.deliver(3_000);
    assert_eq!(table.server.copy().value, [7; 24]);
    assert_eq!(table.notices(1), [Notice::Granted, Notice::Published(1)]);
    assert_eq!(table.notices(0), [Notice::Changed(1), Notice::Granted]);
    assert!(table.clients[0].owns(3_000) && table.clients[0].copy().value == [7; 24]);
}

#[test]
fn the_lock_of_a_vanished_client_expires_and_it_has_stopped_before() {
    let mut table = Table::new();
    for client in [0, 1] {
        table.clients[client].ask(0);
    }
    table.poll(0);
    table.deliver(10_000);
    assert!(table.clients[0].owns(10_000));
    // Nothing of client 1 arrives from now on; client 2 goes on asking.
    let mut changed = None;
    for now in (12_000..1_000_000).step_by(2_000) {
        table.poll(now);
        table.to_server.retain(|(from, _)| *from == PeerId(2));
        table.to_clients.retain(|(to, _)| *to == PeerId(2));
        table.deliver(now);
        assert!(!(table.clients[0].owns(now) && table.clients[1].owns(now)));
        if changed.is_none() && table.clients[1].owns(now) {
            changed = Some(now);
        }
    }
    // From the reception of the last ask, and a poll at the most.
    assert_eq!(changed, Some(10_000 + u64::from(LEASE_US)));
    assert!(table.notices(0).contains(&Notice::Expired));
}

#[test]
fn a_late_release_cannot_overwrite_and_its_author_is_told() {
    let mut table = Table::new();
    for client in [0, 1] {
        table.clients[client].ask(0);
    }
    table.poll(0);
    table.deliver(0);
    table.release(1_000, 0, 1).unwrap();
    let late = std::mem::take(&mut table.to_server);
    for now in (2_000..400_000).step_by(2_000) {
        table.poll(now);
        table.to_server.retain(|(from, _)| *from == PeerId(2));
        table.deliver(now);
    }
    table.release(400_000, 1, 2).unwrap();
    table.deliver(400_000);
    table.to_server = late;
    table.deliver(401_000);
    assert_eq!((table.server.copy().version, table.server.copy().value), (2, [2; 24]));
    assert!(table.notices(0).contains(&Notice::TooLate(1)));
    assert_eq!(table.clients[0].copy().value, [2; 24]);
}

#[test]
fn a_late_release_that_meets_nobody_is_taken_and_a_second_time_changes_nothing() {
    let mut table = Table::new();
    table.clients[0].ask(0);
    table.poll(0);
    table.deliver(0);
    table.release(1_000, 0, 1).unwrap();
    let late = table.to_server.clone();
    table.server.poll(900_000, &mut Outbox::<_, 4>::new());
    assert_eq!(table.server.holder(), None);
    table.deliver(900_000);
    assert_eq!(table.notices(0), [Notice::Granted, Notice::Published(1)]);
    let record = table.server.record().clone();
    table.to_server = late;
    table.deliver(901_000);
    assert_eq!((table.server.record(), table.clients[0].phase()), (&record, Phase::Idle));
}

#[test]
fn a_grant_that_was_renounced_is_never_owned_even_if_the_renunciation_comes_late() {
    let mut table = Table::new();
    table.clients[0].ask(0);
    table.poll(0);
    // The user goes away before the grant arrives; what it says then stays on the way.
    let mut out = Outbox::<_, 8>::new();
    table.clients[0].withdraw(&mut out);
    let ask = std::mem::take(&mut table.to_server);
    let mut granted = Outbox::<_, 8>::new();
    table.server.receive(1_000, PeerId(1), &ask[0].1, &mut granted);
    let (_, grant) = granted.pop_front().unwrap();
    table.clients[0].receive(2_000, SERVER, &grant, &mut out);
    let renounced: Vec<_> = std::iter::from_fn(|| out.pop_front()).map(|(_, message)| (PeerId(1), message)).collect();
    assert!(renounced.contains(&(PeerId(1), Message::Release { fence: 1, value: None })));
    // It comes back, and the server still thinks that it holds the object.
    table.clients[0].ask(3_000);
    table.poll(3_000);
    let ask = std::mem::take(&mut table.to_server);
    table.server.receive(4_000, PeerId(1), &ask[0].1, &mut granted);
    let (_, grant) = granted.pop_front().unwrap();
    table.clients[0].receive(5_000, SERVER, &grant, &mut out);
    assert!(!table.clients[0].owns(5_000));
}

#[test]
fn a_server_that_restarts_grants_nothing_for_a_lease_and_has_forgotten_nothing() {
    let mut table = Table::new();
    table.clients[0].ask(0);
    table.poll(0);
    table.deliver(0);
    let record = table.server.record().clone();
    table.server = Server::restore(lease(), 1_000, record);
    table.clients[1].ask(1_000);
    for now in (1_000..300_000).step_by(2_000) {
        table.poll(now);
        table.deliver(now);
        assert!(!table.clients[1].owns(now), "{now}");
    }
    // The owner before the restart may still release.
    assert!(!table.clients[0].owns(299_000), "its asks are queued like any other");
    table.poll(301_000);
    table.deliver(301_000);
    assert!(table.clients[1].owns(301_000) || table.clients[0].owns(301_000));
    assert!(table.server.record().fence == 2);
}
