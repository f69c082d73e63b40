//! The tick: the interrupt that reads the joints, runs the peer and commands the drive, 1000 to 5000 times a second as the scene asks.
//!
//! **Deadline**: a control period from entry to exit; it needs a few microseconds. A tick that has not ended when the next is due is
//! seen at its end and handed to the next, which latches [`cohold_core::safety::Fault::TickOverrun`]: motors off. One that
//! lasts for 2 ms is ended by a reset ([`crate::board::deadman`]).
//!
//! **Rules**: above every critical section, and below nothing but the current loop; code in ITCM (but for what only a probe needs), data in DTCM. No lock, no log, no
//! allocation, no executor, no await; what it shares with tasks is in [`Side`]. It cannot panic.
//!
//! Order, as in cohold's harness: joints; operator's orders, probes and a new scene at packet boundaries, stopping at once;
//! what has come; exchange; tick; drive; record.

use core::mem::MaybeUninit;

use cohold_core::device::Reading;
use cohold_core::device::encoder::Shown;
use cohold_core::device::probe::{Outcome, Probe};
use cohold_core::law::Packet;
use cohold_core::peer::Arrived;
use cohold_core::safety::{Command, Fault, Mode};
use cohold_core::sample::OfAxis;
use firmware_parts::exchange::{Producer, Reader, Writer, put};
use firmware_parts::image::{JOINTS, Peer, Real, SHARED};
use firmware_parts::rate::Rate;
use firmware_parts::record::{self, Record, digest, joints};
use firmware_parts::signals::Signals;

use crate::board::drive::{self, Drive, Fitted, Sensed};
use crate::board::{current, deadman, pace};

/// What to run: built and checked by a task, swapped in by the tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    pub(crate) peer: Peer,
    pub(crate) rate: Rate,
    /// What the drive is to know of the settings.
    pub(crate) drive: drive::Plan,
    /// Changes whenever the settings of encoders, mechanism or motors do: signs are then to be checked again.
    pub(crate) device: u32,
}

/// What the tick has for the network.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outgoing {
    pub(crate) tick: u32,
    pub(crate) armed: bool,
    /// Of every shared axis.
    pub(crate) packets: [Packet<Real>; SHARED],
}

/// What the network has for the tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Received {
    /// The life of the link by which it came ([`Signals::life`]).
    pub(crate) life: u32,
    /// The packets of every shared axis.
    pub(crate) packets: [Packet<Real>; SHARED],
}

/// Records that may wait for the recorder, which takes them after every tick.
pub(crate) const RECORDS: usize = 4 * SHARED.next_power_of_two();

/// The tick's side of what it shares with the tasks.
pub(crate) struct Side {
    pub(crate) drive: Fitted,
    /// New scenes, taken while disarmed.
    pub(crate) plans: Reader<'static, Plan>,
    pub(crate) incoming: Reader<'static, Received>,
    pub(crate) outgoing: Writer<'static, Outgoing>,
    pub(crate) records: Producer<'static, Record, RECORDS>,
    /// Numbered probes, begun while disarmed.
    pub(crate) probes: Reader<'static, (u32, Probe<Real>)>,
    pub(crate) probed: Writer<'static, Outcome>,
    pub(crate) signals: &'static Signals,
}

struct Loop {
    side: Side,
    /// The check before arming: passed by these joints, of this device.
    passed: [bool; JOINTS],
    device: u32,
    /// A probe was begun, and its outcome is not reported yet.
    probing: bool,
    peer: Peer,
    plan: drive::Plan,
    tick: u32,
    life: u32,
    overrun: bool,
}

static mut LOOP: MaybeUninit<Loop> = MaybeUninit::uninit();

/// Hands the tick its side; call once, before [`pace::start`].
pub(crate) fn prepare(side: Side) {
    let plan = side.plans.get();
    let this = Loop {
        passed: [false; JOINTS],
        device: plan.device,
        probing: false,
        peer: plan.peer,
        plan: plan.drive,
        tick: 0,
        life: 0,
        overrun: false,
        side,
    };
    // SAFETY: the interrupt that uses LOOP is not enabled yet, and no other task prepares the tick.
    unsafe {
        let place = &raw mut LOOP;
        (*place).write(this)
    };
}

#[unsafe(no_mangle)]
#[unsafe(link_section = ".itcm.tick")]
extern "C" fn TIM6_DAC() {
    // SAFETY: `prepare` ran before the interrupt was enabled, and nothing but this handler touches LOOP.
    let this = unsafe {
        let place = &raw mut LOOP;
        (*place).assume_init_mut()
    };
    this.period();
}

impl Loop {
    #[inline(always)]
    fn period(&mut self) {
        let began = pace::begin();
        deadman::wind();
        let mut stage = None;
        let Sensed { counts, fault } = self.side.drive.sense(&self.plan, &mut stage);
        self.tick = self.tick.wrapping_add(1);
        let mut flags = if self.overrun { record::OVERRUN } else { 0 };

        if self.side.drive.went_off() {
            self.broken();
        }
        let halted = began.stood && matches!(self.peer.mode(), Mode::Armed | Mode::Probing);
        if let Some(fault) = halted.then_some(Fault::Halted).or(fault) {
            self.peer.trip(fault);
        }
        if self.side.signals.disarm.get() {
            self.stop();
            self.side.signals.disarm.release(false);
        }
        let due = self.peer.packet_due();
        if due {
            self.boundary();
        }
        let life = self.side.signals.life.acquire();
        let parted = life != self.life;
        if parted {
            self.life = life;
            flags |= record::PARTED;
        }
        let incoming = &mut self.side.incoming;
        let received =
            if incoming.fetch() { Some(incoming.get()) } else { None }.filter(|received| received.life == life);
        // Two calls, of which each is compiled for what is known here.
        if let Some(Received { packets, .. }) = received {
            flags |= record::RECEIVED;
            self.peer.arrive(Arrived { parted, packets: Some(packets), late: false });
        } else {
            self.peer.arrive(Arrived { parted, packets: None, late: self.side.signals.old.get() });
        }
        if due {
            flags |= record::SENT;
            let (peer, tick) = (&mut self.peer, self.tick);
            self.side.outgoing.fill(|out| {
                let speaks = peer.exchange_into(&mut out.packets);
                (out.tick, out.armed) = (tick, peer.mode() == Mode::Armed);
                speaks
            });
        }

        // Not in the longest tick: what encoders show is kept for the next one.
        let marks;
        let shown = if self.peer.is_busy() {
            Shown::Unknown
        } else if let Some(seen) = self.side.drive.marks() {
            marks = seen;
            Shown::Marks(&marks)
        } else {
            Shown::Nothing
        };
        let actuators = self.peer.tick_in_place(Reading::Counts(counts), self.overrun, &stage, shown);
        if actuators.enable || actuators.open {
            if let Err(fault) = self.side.drive.act(&self.plan, &actuators, counts) {
                self.peer.trip(fault);
            }
            if actuators.enable {
                flags |= record::ENABLED;
                if self.peer.is_engaged() {
                    flags |= record::ENGAGED;
                }
            }
        } else {
            self.side.drive.rest(&self.plan, counts);
            self.judge();
        }

        let mode = record::mode_code(self.peer.mode());
        self.side.signals.mode.set_code(mode);
        self.side.signals.ticks.set(self.tick);
        // For whoever runs the tick again, which is nobody unless he asked for it.
        let asked = self.side.signals.record_every.get() > 0;
        let (tick, digest) = (self.tick, if asked { digest(&mut self.peer) } else { 0 });
        let (seen, ledgers) = (self.peer.observed(), self.peer.ledger());
        let heard = flags & record::RECEIVED != 0;
        let incoming = heard.then(|| &self.side.incoming.get().packets);
        #[allow(clippy::needless_range_loop, reason = "iterators over arrays of one stay in memory")]
        for axis in 0..SHARED {
            // Without room it is lost: whoever misses it sees it by the numbers.
            let _ = self.side.records.put(|record| {
                let (counts, duties) = (joints(counts, axis), joints(actuators.duties, axis));
                let (stage, number) = (current::reported(stage.as_ref()), axis as u8);
                let of = record::Tick { tick, axis: number, counts, duties, stage, mode, flags, digest };
                let did = OfAxis::new(seen[axis], ledgers[axis]);
                record.fill(&of, incoming.map(|packets| &packets[axis]), &did);
            });
        }
        self.overrun = pace::due();
        if self.overrun {
            self.side.signals.overruns.count();
        }
        pace::end(began, self.tick, flags);
    }

    /// The drive went off by itself: motors off, and the cause kept.
    #[cold]
    #[unsafe(link_section = ".itcm.broken")]
    fn broken(&mut self) {
        self.stop();
        let cut = self.side.drive.cut(&self.plan);
        if cut.by_stop {
            self.side.signals.emergency.set(true);
        }
        if let Some(fault) = cut.fault {
            self.peer.trip(fault);
        }
    }

    /// Motors off, and whatever was asked for before is withdrawn: an order that still waits must not undo a stop.
    #[inline(always)]
    fn stop(&mut self) {
        self.command(Command::Disarm);
        self.side.signals.done.release(self.side.signals.order.acquire());
        if self.side.probes.fetch() {
            self.side.signals.begun.release(self.side.probes.get().0);
        }
    }

    /// What may happen only between packets: a new scene or a probe while disarmed, and the operator's order.
    #[inline(always)]
    fn boundary(&mut self) {
        let new = self.peer.mode() == Mode::Disarmed && self.side.plans.fetch();
        if new {
            let plan = self.side.plans.get();
            put(&mut self.peer, &plan.peer);
            put(&mut self.plan, &plan.drive);
            pace::set(plan.rate);
            if plan.device != self.device {
                self.device = plan.device;
                self.passed = [false; JOINTS];
            }
        }
        // What the power stage says in this tick is still of the plan before, and a check goes by what there is in its first tick.
        if !new && self.side.probes.fetch() {
            let (number, probe) = *self.side.probes.get();
            self.peer.probe(probe);
            self.probing = self.peer.mode() == Mode::Probing;
            self.side.probed.write(self.peer.probed());
            self.side.signals.begun.release(number);
        }
        if self.side.signals.order.differs(&self.side.signals.done) {
            let order = self.side.signals.order.acquire();
            // Unchecked, the motors stay off.
            if order.command != Command::Arm || self.checked() {
                self.command(order.command);
            }
            self.side.signals.done.release(order);
        }
    }

    /// Every joint in use has passed the check before arming.
    fn checked(&self) -> bool {
        self.passed.iter().take(self.peer.axes()).all(|passed| *passed)
    }

    /// After the tick that ended a probe.
    #[cold]
    #[unsafe(link_section = ".slow.probe")]
    fn after_probe(&mut self) {
        self.probing = false;
        let outcome = self.peer.probed();
        if outcome.check {
            for (passed, joint) in self.passed.iter_mut().zip(1..) {
                if joint == outcome.joint {
                    *passed = outcome.passed();
                }
            }
        }
        self.side.probed.write(outcome);
    }

    /// With the motors off: what came of a probe, and whether the last check still stands.
    #[inline(always)]
    fn judge(&mut self) {
        if self.probing {
            self.after_probe();
        }
        if let Mode::Faulted(fault) = self.peer.mode()
            && fault.doubts_encoders()
        {
            self.passed = [false; JOINTS];
        }
        self.side.signals.checked.set(self.checked());
    }

    #[inline(always)]
    fn command(&mut self, command: Command) {
        let before = self.peer.mode();
        self.peer.command(command);
        if before != Mode::Armed && self.peer.mode() == Mode::Armed {
            // Nobody is there until he is heard.
            self.peer.part();
        }
    }
}
