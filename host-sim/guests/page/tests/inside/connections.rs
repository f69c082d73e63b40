use std::net::{Ipv4Addr, TcpListener};

use super::*;

/// Connections of which this is the end that is served, each said to be from an address of a local network.
struct Network {
    listener: TcpListener,
    connections: Arc<Connections>,
    /// The other ends, so that they stay.
    others: Vec<TcpStream>,
}

impl Network {
    fn new() -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
        Self { listener, connections: Arc::default(), others: Vec::new() }
    }

    fn connect(&mut self, way: Way, from: u8) -> Pass {
        let at = self.listener.local_addr().expect("an address");
        self.others.push(TcpStream::connect(at).expect("it listens"));
        let stream = self.listener.accept().expect("a connection").0;
        self.connections.admit_from(way, IpAddr::V4(Ipv4Addr::new(192, 168, 1, from)), stream).expect("it is there")
    }

    fn has(&self, pass: &Pass) -> bool {
        self.connections.lock().0.iter().any(|connection| connection.number == pass.number)
    }
}

const WATCHES: Rights = Rights { hand: None, operates: false };

/// However many one address opens, it closes its own, with a key and without one; nobody else's, and nobody's on this machine.
#[test]
fn many_connections_of_one_address_lock_out_no_other() {
    let mut network = Network::new();
    let operator = network.connect(Way::Here, 1);
    let others: Vec<_> = (10..20).map(|from| network.connect(Way::Lan, from)).collect();
    let watching: Vec<_> = (20..30).map(|from| network.connect(Way::Lan, from)).collect();
    watching.iter().for_each(|pass| pass.has(WATCHES));
    let greedy: Vec<_> = (0..3 * MOST_WITHOUT_KEY).map(|_| network.connect(Way::Lan, 99)).collect();
    for pass in greedy.iter().step_by(2) {
        pass.has(WATCHES);
        // It may speak as much as it likes.
        greedy.iter().for_each(Pass::speaks);
    }
    assert!(others.iter().chain(&watching).chain([&operator]).all(|pass| network.has(pass)));
    let kept = greedy.iter().filter(|pass| network.has(pass)).count();
    assert!(kept <= MOST_WITHOUT_KEY - others.len() + MOST_ALIKE - watching.len(), "{kept}");
    // And who comes now is let in.
    let newcomer = network.connect(Way::Lan, 50);
    newcomer.has(WATCHES);
    assert!(network.has(&newcomer));
}

/// As many addresses as one likes: the newest is let in, for the one that has said nothing for longest.
#[test]
fn where_all_have_as_many_the_one_that_was_silent_longest_goes() {
    let mut network = Network::new();
    let all: Vec<_> = (0..MOST_ALIKE as u8).map(|from| network.connect(Way::Lan, from)).collect();
    all.iter().for_each(|pass| pass.has(WATCHES));
    all[0].speaks();
    let newcomer = network.connect(Way::Lan, 200);
    newcomer.has(WATCHES);
    assert!(network.has(&newcomer) && network.has(&all[0]) && !network.has(&all[1]));
}
