//! A peer that parts lets go and begins again from no force, with whoever comes, counting from whatever they count.

use cohold_core::law::Packet;
use cohold_core::law::degradation::STEP_N;
use cohold_core::law::wave::Decode;
use cohold_core::num::Motion;
use cohold_core::safety::{Fault, Mode};
use cohold_core::settings::Settings;

type Bench = super::Bench<f64>;

impl Bench {
    /// Packet periods with packets until nothing is left of a force of at most 7 N, which falls by a step in each tick.
    fn let_go(&mut self) {
        let mut last = self.peer.observed()[0].coordination_force.abs();
        for _ in 0..400 {
            if last > 2.0 * STEP_N {
                self.peer.hear(&[at(1.0).expect("a packet")]);
            }
            if self.peer.packet_due() {
                self.peer.listen();
            }
            self.at(0.0, 0.0);
            let seen = *self.peer.observed()[0];
            let force = seen.coordination_force.abs();
            // The spring becomes shorter where the copy follows it.
            let shorter_n = 310.0 * 1e-3 * seen.object.velocity.abs();
            assert!(last - force <= STEP_N + shorter_n + 1e-9, "{last} N, then {force} N");
            last = force;
            if last == 0.0 {
                return;
            }
        }
        panic!("{last} N are left");
    }

    /// A packet period with or without a packet; the coordination force of its first tick.
    fn period(&mut self, incoming: Option<Packet<f64>>) -> f64 {
        incoming.into_iter().for_each(|packet| self.peer.hear(&[packet]));
        self.peer.exchange();
        self.at(0.0, 0.0);
        let force = self.peer.observed()[0].coordination_force;
        for _ in 1..self.peer.ticks_per_packet() {
            self.at(0.0, 0.0);
        }
        force
    }
}

fn power() -> Settings {
    let mut settings = Settings::default();
    settings.coordination.comm = "power";
    settings.coordination.stiffness_n_per_m = 310.0;
    settings.coordination.damping_n_s_per_m = 0.0;
    settings
}

fn at(position: f64) -> Option<Packet<f64>> {
    Some(Packet { motion: Motion::at(position), ..Packet::default() })
}

#[test]
fn the_force_falls_and_comes_back_step_by_step() {
    let mut bench = Bench::armed(&power());
    assert!(bench.period(at(0.01)) > 3.0, "armed and told nothing, a peer takes the first packet in full");
    assert!(bench.peer.is_engaged());

    bench.peer.part();
    assert!(!bench.peer.is_engaged());
    // It is deaf until nothing is left of the force, and what it sends is at rest.
    bench.let_go();
    let sent = bench.peer.outgoing()[0];
    assert_eq!((sent.motion.velocity, sent.wave), (0.0, 0.0));

    // (safety.disengage_s − safety.fade_s)/T_n
    let steps = 9_u32;
    for step in 1..=steps + 3 {
        let here = bench.peer.outgoing()[0].motion.position;
        let force = bench.period(at(here + 0.01));
        let share = f64::from(step.min(steps)) / f64::from(steps);
        // K_T times the distance, as far as the peer is engaged.
        assert!((force - share * 310.0 * 0.01).abs() < 1e-9, "step {step}: {force} N");
    }
}

#[test]
fn silence_goes_on_being_counted() {
    let mut settings = power();
    settings.safety.peer_lost_s = 0.16;
    let mut bench = Bench::armed(&settings);
    bench.period(at(0.0));
    for _ in 0..19 {
        bench.period(None);
        bench.peer.part();
    }
    assert_eq!(bench.peer.mode(), Mode::Armed);
    bench.period(None);
    assert_eq!(bench.peer.mode(), Mode::Faulted(Fault::PeerLost));
}

/// The reason for parting: counters that begin again would look like the past, and the ledger would pay for nothing.
#[test]
fn a_peer_that_counts_from_zero_again_is_paid_for_only_after_parting() {
    let mut settings = Settings::default();
    settings.coordination.comm = "passive-mean";
    settings.coordination.decode = Decode::Implicit;
    settings.coordination.ledger = true;
    let wave = |sent: f64| Some(Packet { wave: 0.1, energy_j: sent, ..Packet::default() });
    // T_n·½·u² for every packet sent.
    let price = 0.5 * 0.1 * 0.1 * 0.008;
    let emitted = |parts: bool| {
        let mut bench = Bench::armed(&settings);
        for packet in 1..=100 {
            bench.period(wave(f64::from(packet) * price));
        }
        if parts {
            bench.peer.part();
        }
        let before = bench.peer.ledger()[0].received_j();
        for packet in 1..=50 {
            bench.period(wave(f64::from(packet) * price));
        }
        bench.peer.ledger()[0].received_j() - before
    };
    let (held, parted) = (emitted(false), emitted(true));
    assert!(held <= price * (1.0 + 1e-9), "{held} J without parting");
    // Nine steps of the degradation, then everything.
    assert!(parted > 41.0 * price && parted <= 50.0 * price, "{parted} J after parting, {} J sent", 50.0 * price);
}

/// A packet waits for no packet period: it acts at the tick after it came, and of several in one period only the first is a
/// step back.
#[test]
fn what_comes_between_two_exchanges_acts_at_the_next_tick() {
    let mut bench = Bench::armed(&power());
    let pulled = |bench: &mut Bench, stretch: f64| {
        let here = bench.peer.outgoing()[0].motion.position;
        bench.peer.hear(&[at(here + stretch).expect("a packet")]);
        bench.at(0.0, 0.0);
        bench.peer.observed()[0].coordination_force
    };
    bench.period(at(0.0));
    bench.peer.exchange();
    bench.at(0.0, 0.0);
    assert!((pulled(&mut bench, 0.01) - 3.1).abs() < 1e-9);
    assert!((pulled(&mut bench, -0.02) + 6.2).abs() < 1e-9);
    bench.peer.part();
    bench.let_go();
    while !bench.peer.packet_due() {
        bench.at(0.0, 0.0);
    }
    bench.peer.listen();
    for step in [1.0, 1.0, 1.0] {
        let force = pulled(&mut bench, 0.01);
        assert!((force - step / 9.0 * 3.1).abs() < 1e-9, "{force} N");
    }
    bench.peer.exchange();
    assert!((pulled(&mut bench, 0.01) - 2.0 / 9.0 * 3.1).abs() < 1e-9);
}
