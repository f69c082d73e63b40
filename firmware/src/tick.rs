//! The tick: the 1 kHz interrupt that reads the encoders, runs the peer and commands the bridges.
//!
//! **Deadline**: 1 ms from entry to exit; it needs a few microseconds. A tick that has not ended when the next is due is
//! seen at its end and handed to the next, which latches [`haptic_core::safety::Fault::TickOverrun`]: motors off. One that
//! never ends is the watchdog's.
//!
//! **Rules**: the highest priority there is, above every critical section; code in ITCM, data in DTCM. No lock, no log, no
//! allocation, no executor, no await; what it shares with tasks is in [`Shared`] and in single words. It cannot panic.
//!
//! Order, as in host-sim's harness: encoders; operator's orders, probes and a new scene at packet boundaries, stopping at once;
//! exchange; tick; bridges; record.

use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use firmware_parts::exchange::{Consumer, Latest, Producer, Queue, Reader, Writer};
use firmware_parts::record::{self, Record};
use firmware_parts::status;
use haptic_core::device::probe::{Outcome, Probe};
use haptic_core::device::{AXES, Reading};
use haptic_core::law::Packet;
use haptic_core::num::Motion;
use haptic_core::peer::{self, Sensors, State};
use haptic_core::safety::{Command, Mode};
use haptic_core::scene::{Any, Scene};

use crate::board::{bridges, encoders, pace};

/// The models that this image holds: all of them, chosen by the settings.
pub(crate) type Models = Any<f32>;

/// What to run: built and checked by a task, swapped in by the tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Plan {
    /// The scene.
    pub(crate) scene: Scene<Models>,
    /// Where the axes are taken to be when the scene begins.
    pub(crate) home: [Motion<f32>; AXES],
    /// Changes whenever the settings of encoders, mechanism or motors do: signs are then to be checked again.
    pub(crate) device: u32,
}

/// What the tick has for the network.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Outgoing {
    /// The tick that made it.
    pub(crate) tick: u32,
    /// The motors are on.
    pub(crate) armed: bool,
    /// For the other peer.
    pub(crate) packet: Packet<f32>,
}

/// What the network has for the tick.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Received {
    /// Which life of the link it came by ([`LIFE`]).
    pub(crate) life: u32,
    /// From the other peer.
    pub(crate) packet: Packet<f32>,
}

/// Records that may wait for telemetry: 64 ms at full rate.
pub(crate) const RECORDS: usize = 64;

/// The memory that the tick and the tasks share.
pub(crate) struct Shared {
    plans: Latest<Plan>,
    incoming: Latest<Received>,
    outgoing: Latest<Outgoing>,
    records: Queue<Record, RECORDS>,
    probes: Latest<(u32, Probe<f32>)>,
    probed: Latest<Outcome>,
}

/// The tasks' side of it.
pub(crate) struct Tasks {
    /// New scenes, taken while disarmed.
    pub(crate) plans: Writer<'static, Plan>,
    /// Packets from the other peer.
    pub(crate) incoming: Writer<'static, Received>,
    /// Packets for the other peer.
    pub(crate) outgoing: Reader<'static, Outgoing>,
    /// What the ticks did.
    pub(crate) records: Consumer<'static, Record, RECORDS>,
    /// Numbered probes, begun while disarmed.
    pub(crate) probes: Writer<'static, (u32, Probe<f32>)>,
    /// What came of them.
    pub(crate) probed: Reader<'static, Outcome>,
}

impl Shared {
    /// Nothing exchanged yet.
    pub(crate) fn new(plan: Plan) -> Self {
        Self {
            plans: Latest::new(plan),
            incoming: Latest::new(Received::default()),
            outgoing: Latest::new(Outgoing::default()),
            records: Queue::default(),
            probes: Latest::new((0, Probe::default())),
            probed: Latest::new(Outcome::default()),
        }
    }
}

/// Motors off at the next tick, whatever else is going on. Set by tasks, cleared by the tick.
pub(crate) static DISARM: AtomicBool = AtomicBool::new(false);
/// An order for the next packet boundary ([`status::order`]). Set by tasks.
pub(crate) static ORDER: AtomicU32 = AtomicU32::new(0);
/// The last [`ORDER`] carried out. Set by the tick.
pub(crate) static DONE: AtomicU32 = AtomicU32::new(0);
/// Number of the last probe begun. Set by the tick.
pub(crate) static BEGUN: AtomicU32 = AtomicU32::new(0);
/// The signs of every joint in use were checked and agree. Set by the tick.
pub(crate) static CHECKED: AtomicBool = AtomicBool::new(false);
/// How often the link has let go of the other peer: the tick lets go too, and takes nothing that came before. Set by tasks.
pub(crate) static LIFE: AtomicU32 = AtomicU32::new(0);
/// Mode and fault ([`status::pack`]). Set by the tick.
pub(crate) static STATUS: AtomicU32 = AtomicU32::new(0);
/// Ticks since boot. Set by the tick.
pub(crate) static TICKS: AtomicU32 = AtomicU32::new(0);
/// Ticks that were due before the one before them had ended. Set by the tick.
pub(crate) static OVERRUNS: AtomicU32 = AtomicU32::new(0);
/// The bridges went off by the emergency stop. Set by the tick, cleared by tasks.
pub(crate) static EMERGENCY: AtomicBool = AtomicBool::new(false);
/// Every how-many-th tick leaves a record; 0: none. Set by tasks.
pub(crate) static RECORD_EVERY: AtomicU32 = AtomicU32::new(0);
/// Records that found no room. Set by the tick.
pub(crate) static RECORDS_LOST: AtomicU32 = AtomicU32::new(0);

/// What the tick owns.
struct Loop {
    plans: Reader<'static, Plan>,
    incoming: Reader<'static, Received>,
    outgoing: Writer<'static, Outgoing>,
    records: Producer<'static, Record, RECORDS>,
    probes: Reader<'static, (u32, Probe<f32>)>,
    probed: Writer<'static, Outcome>,
    /// The check before arming: passed by these joints, of this device.
    passed: [bool; AXES],
    device: u32,
    /// A probe was begun, and what came of it is not told yet.
    probing: bool,
    state: State<Models>,
    tick: u32,
    life: u32,
    until_record: u32,
    driving: bool,
    overrun: bool,
}

static mut LOOP: MaybeUninit<Loop> = MaybeUninit::uninit();

/// Hands the tick its side of `shared`; call once, before [`pace::start`].
pub(crate) fn prepare(shared: &'static mut Shared) -> Tasks {
    let (plans_in, plans) = shared.plans.split();
    let (incoming_in, incoming) = shared.incoming.split();
    let (outgoing, outgoing_out) = shared.outgoing.split();
    let (records, records_out) = shared.records.split();
    let (probes_in, probes) = shared.probes.split();
    let (probed, probed_out) = shared.probed.split();
    let plan = plans.get();
    let state = State::new(&plan.scene, plan.home);
    let device = plan.device;
    let this = Loop {
        plans,
        incoming,
        outgoing,
        records,
        probes,
        probed,
        passed: [false; AXES],
        device,
        probing: false,
        state,
        tick: 0,
        life: 0,
        until_record: 0,
        driving: false,
        overrun: false,
    };
    // SAFETY: the interrupt that uses LOOP is not enabled yet, and `shared` exists once, so this runs once.
    unsafe {
        let place = &raw mut LOOP;
        (*place).write(this)
    };
    Tasks {
        plans: plans_in,
        incoming: incoming_in,
        outgoing: outgoing_out,
        records: records_out,
        probes: probes_in,
        probed: probed_out,
    }
}

/// The interrupt.
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
    /// One control period.
    #[inline(always)]
    fn period(&mut self) {
        pace::acknowledge();
        let counts = encoders::read();
        self.tick = self.tick.wrapping_add(1);
        let mut flags = if self.overrun { record::OVERRUN } else { 0 };

        if self.driving && !bridges::live() {
            EMERGENCY.store(true, Ordering::Relaxed);
            self.stop();
        }
        if DISARM.load(Ordering::Relaxed) {
            self.stop();
            DISARM.store(false, Ordering::Release);
        }
        let mut incoming = None;
        if self.state.packet_due() {
            self.boundary();
            let life = LIFE.load(Ordering::Acquire);
            if life != self.life {
                self.life = life;
                self.state.part();
                flags |= record::PARTED;
            }
            incoming = self.incoming.take().filter(|received| received.life == life).map(|received| received.packet);
            flags |= record::SENT | if incoming.is_some() { record::RECEIVED } else { 0 };
            let packet = peer::exchange(&self.plans.get().scene, &mut self.state, incoming);
            let armed = self.state.mode() == Mode::Armed;
            self.outgoing.write(Outgoing { tick: self.tick, armed, packet });
        }

        let sensors = Sensors { reading: Reading::Counts(counts), overrun: self.overrun };
        let actuators = peer::tick(&self.plans.get().scene, &mut self.state, &sensors);
        self.driving = actuators.enable;
        if actuators.enable {
            bridges::drive(actuators.duties);
            flags |= record::ENABLED;
            if self.state.is_engaged() {
                flags |= record::ENGAGED;
            }
        } else {
            bridges::off();
            self.judge();
        }

        STATUS.store(status::pack(self.state.mode()), Ordering::Relaxed);
        TICKS.store(self.tick, Ordering::Relaxed);
        if self.record_due() {
            let record = Record::new(self.tick, counts, incoming, flags, &mut self.state, &actuators);
            if !self.records.put(record) {
                RECORDS_LOST.store(RECORDS_LOST.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
            }
        }
        if flags & record::SENT != 0 {
            pace::ring();
        }
        self.overrun = pace::due();
        if self.overrun {
            OVERRUNS.store(OVERRUNS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
        }
    }

    /// Motors off, and whatever was asked for before is withdrawn: an order that still waits must not undo a stop.
    #[inline(always)]
    fn stop(&mut self) {
        self.command(Command::Disarm);
        DONE.store(ORDER.load(Ordering::Acquire), Ordering::Release);
        if self.probes.fetch() {
            BEGUN.store(self.probes.get().0, Ordering::Release);
        }
    }

    /// What may happen only between packets: a new scene or a probe while disarmed, and the operator's order.
    #[inline(always)]
    fn boundary(&mut self) {
        if self.state.mode() == Mode::Disarmed && self.plans.fetch() {
            let plan = self.plans.get();
            self.state = State::new(&plan.scene, plan.home);
            if plan.device != self.device {
                self.device = plan.device;
                self.passed = [false; AXES];
            }
        }
        if self.probes.fetch() {
            let (number, probe) = *self.probes.get();
            self.state.probe(probe);
            self.probing = self.state.mode() == Mode::Probing;
            self.probed.write(self.state.probed());
            BEGUN.store(number, Ordering::Release);
        }
        let order = ORDER.load(Ordering::Acquire);
        if order != DONE.load(Ordering::Relaxed) {
            match status::ordered(order) {
                Some(Command::Arm) if !self.checked() => {}
                Some(command) => self.command(command),
                None => {}
            }
            DONE.store(order, Ordering::Release);
        }
    }

    /// Every joint in use has passed the check before arming.
    fn checked(&self) -> bool {
        self.passed.iter().take(self.plans.get().scene.axes()).all(|passed| *passed)
    }

    /// After the tick that ended a probe.
    #[cold]
    #[unsafe(link_section = ".itcm.probe")]
    fn after_probe(&mut self) {
        self.probing = false;
        let outcome = self.state.probed();
        if outcome.check {
            for (passed, joint) in self.passed.iter_mut().zip(1..) {
                if joint == outcome.joint {
                    *passed = outcome.passed();
                }
            }
        }
        self.probed.write(outcome);
    }

    /// With the motors off: what came of a probe, and whether the last check still stands.
    #[inline(always)]
    fn judge(&mut self) {
        if self.probing {
            self.after_probe();
        }
        if let Mode::Faulted(fault) = self.state.mode()
            && fault.doubts_encoders()
        {
            self.passed = [false; AXES];
        }
        CHECKED.store(self.checked(), Ordering::Relaxed);
    }

    #[inline(always)]
    fn command(&mut self, command: Command) {
        let before = self.state.mode();
        self.state.command(&self.plans.get().scene, command);
        if before != Mode::Armed && self.state.mode() == Mode::Armed {
            // Nobody is there until he is heard.
            self.state.part();
        }
    }

    #[inline(always)]
    fn record_due(&mut self) -> bool {
        let every = RECORD_EVERY.load(Ordering::Relaxed);
        if every == 0 {
            self.until_record = 0;
            return false;
        }
        let due = self.until_record == 0;
        self.until_record = if due { every - 1 } else { self.until_record - 1 };
        due
    }
}
