//! Two boards, their devices and a PC on one wire, running a scene.
//!
//! Time goes in steps of a control period that end in the middle between two ticks. At every stop, in this order: frames that left go
//! onto the wire and those that arrived come off it; each device (cohold's plant) moves by one period under what its
//! board's bridges are commanded; its encoder begins to turn there. So a device does on the bench exactly what it does
//! in cohold's harness, and what is compared is the board.
//!
//! What a person does there stands in `person.rs`, what a device is on a board in `device.rs`.

mod device;
mod person;

use std::ops::Range;
use std::sync::Arc;

use cohold_core::safety::Mode;
use cohold_sim::scene::Scene;
use device::Device;
use firmware_parts::record::Record;

use crate::cost::{LOOP, Meter, TICK};
use crate::image::Firmware;
use crate::node::{Inputs, Node, Report, Stopped};
use crate::part::motors::has_loop;
use crate::partner::Partner;
use crate::pc::{Pc, keys_in_flash, operator_key, peers_key};
use crate::twin::Armed;
use crate::wire::{Line, PC, Wire};

pub use device::{AMPLIFIER_STEPS, CURRENT_LOOP, PWM_STEPS, duties, for_boards};

/// A control period of boards that have no scene yet, and a millisecond, ns.
pub const PERIOD_NS: u64 = 1_000_000;

/// The stack (memory.x), without the guard at its bottom and what start-up may be using of its top.
pub const STACK: Range<u64> = 0x2000_0100..0x2000_BF00;
/// What the stack holds at power-on, to see later how far down it was used.
const PAINT: u32 = 0x5EA1_AB1E;

/// Boards, wire and PC on one clock.
pub struct Bench {
    /// The boards.
    pub nodes: Vec<Node>,
    /// The wire between boards and PC.
    pub wire: Wire,
    /// The PC that operates the boards.
    pub pc: Pc,
    /// Who stands in for board 2, if anyone.
    pub partner: Option<Partner>,
    /// What each board runs, and the device that it is on: the same but for what boards of two images differ in.
    scenes: Vec<Scene>,
    devices: Vec<Option<Device>>,
    /// The devices while nobody holds them; empty while somebody does.
    loose: Vec<Device>,
    inputs: Vec<Inputs>,
    /// What each board did at the last stop.
    pub stopped: Vec<Stopped>,
    /// Instructions of each board's ticks, once [`Bench::count_instructions`] was asked for.
    pub meters: Vec<Meter>,
    /// Instructions of each board's current loop, once [`Bench::count_instructions`] was asked for.
    pub loops: Vec<Meter>,
    now_ns: u64,
    /// How much later power came on at each board, ns: its own clock is so far behind the bench's.
    late_ns: Vec<u64>,
    /// The control period of the boards' scenes, s, and of their ticks, ns.
    period_s: f64,
    period_ns: u64,
    /// Stops since power-on.
    stops: u64,
    /// Of the emergency stops' two contacts, those that are bridged, on every board.
    pub bridged: [bool; 2],
    /// Periods that armed boards are given to engage: a whole number of packets.
    engaging: u64,
    /// At which stop the motors of each board were first seen on.
    on: Vec<Option<u64>>,
    /// At which stop the devices began to move.
    begun: Option<u64>,
    /// Ticks that the devices have moved since then.
    pub ticks: u64,
}

impl Bench {
    /// `boards` (1 or 2) boards at power-on, run until their network is up.
    ///
    /// # Panics
    /// The tick does not start.
    pub fn start(firmware: &Arc<Firmware>, boards: usize, line: Line) -> Self {
        Self::start_with(firmware, boards, line, &[])
    }

    /// [`Bench::start`] with words in every board's flash that were there before, beside the keys: address and value.
    ///
    /// # Panics
    /// As [`Bench::start`].
    pub fn start_with(firmware: &Arc<Firmware>, boards: usize, line: Line, flash: &[(u64, u32)]) -> Self {
        Self::power_on(firmware, boards, line, 58, |inputs| inputs.poke.extend(flash))
    }

    /// Boards whose ticks run after so many ms, with what comes in at power-on beside their keys.
    ///
    /// # Panics
    /// As [`Bench::start`].
    pub fn power_on(firmware: &Arc<Firmware>, boards: usize, line: Line, ms: u64, first: impl Fn(&mut Inputs)) -> Self {
        Self::of_images(&vec![firmware.clone(); boards], line, ms, first)
    }

    /// [`Bench::start`] of a board for each of these images.
    ///
    /// # Panics
    /// As [`Bench::start`].
    pub fn mixed(images: &[Arc<Firmware>], line: Line) -> Self {
        Self::of_images(images, line, 58, |_| {})
    }

    fn of_images(images: &[Arc<Firmware>], line: Line, ms: u64, first: impl Fn(&mut Inputs)) -> Self {
        let boards = images.len();
        let nodes: Vec<Node> = (1..).zip(images).map(|(number, image)| Node::new(image.clone(), number)).collect();
        let each = || (0..boards).map(|_| Inputs::default()).collect::<Vec<_>>();
        let mut bench = Self {
            scenes: vec![for_boards(&Scene::default()); boards],
            devices: nodes.iter().map(|_| None).collect(),
            loose: Vec::new(),
            stopped: nodes.iter().map(|_| Stopped::default()).collect(),
            inputs: each(),
            meters: images.iter().map(|image| Meter::new(image, TICK)).collect(),
            loops: images.iter().map(|image| Meter::new(image, LOOP)).collect(),
            nodes,
            wire: Wire::new(line),
            pc: Pc::default(),
            partner: None,
            now_ns: 1000,
            late_ns: vec![0; boards],
            period_s: 1e-3,
            period_ns: PERIOD_NS,
            stops: 0,
            engaging: 0,
            on: vec![None; boards],
            bridged: [false; 2],
            begun: None,
            ticks: 0,
        };
        let keys = keys_in_flash(&peers_key(), &operator_key());
        let paint = STACK.step_by(4).map(|address| (address, PAINT)).chain(keys);
        let entries: Vec<u64> = images.iter().map(|image| image.address(TICK)).collect();
        for (inputs, entry) in bench.inputs.iter_mut().zip(&entries) {
            inputs.poke.extend(paint.clone());
            inputs.watch.push(*entry);
            first(inputs);
        }
        bench.run_to(ms * PERIOD_NS);
        // Images take different times to start, and cohold's peers begin at the same time.
        let began = bench.stopped.iter().map(|stopped| stopped.hits.first().expect("the tick runs").at.0);
        let latest = began.clone().max().expect("a board");
        bench.late_ns = began.map(|began| latest - began).map(|late| if late < 100_000 { 0 } else { late }).collect();
        bench.align_to(&entries);
        // The PHY is asked for its link every 500 ms: it is there the second time.
        for number in 1..=boards {
            bench.meet(number);
        }
        bench.checkpoint();
        bench
    }

    /// Boards that are told what these were so far go on from here.
    pub(super) fn checkpoint(&self) {
        self.nodes.iter().for_each(Node::checkpoint);
    }

    /// From here on every stop is in the middle between two ticks of a board that is alone and was reset, which happens at any time.
    /// Its device stands still for some 3 ms.
    ///
    /// # Panics
    /// The board's tick does not run.
    pub fn align(&mut self, firmware: &Firmware) {
        let entry = firmware.address(TICK);
        self.input(1).watch.push(entry);
        self.align_to(&[entry]);
    }

    /// [`Bench::align`] to board 1's ticks. Each board's entry of its tick is watched until then.
    fn align_to(&mut self, entries: &[u64]) {
        self.run_to(self.now_ns + 2 * PERIOD_NS + self.late_ns.iter().max().expect("a board"));
        let tick = self.stopped[0].hits.last().expect("the tick runs").at.0 + self.late_ns[0];
        self.inputs.iter_mut().zip(entries).for_each(|(inputs, entry)| inputs.unwatch.push(*entry));
        let middle = (tick + PERIOD_NS / 2) % PERIOD_NS;
        self.run_to((self.now_ns / PERIOD_NS + 1) * PERIOD_NS + middle);
    }

    /// Makes sure that a board (1 or 2) knows the PC and the PC has a session with it.
    ///
    /// # Panics
    /// They do not meet within two seconds.
    pub fn meet(&mut self, number: usize) {
        for ms in 0..2000 {
            // As a PC does that has something to send: a board that is not up yet does not hear it.
            if ms % 100 == 0 {
                self.wire.send(PC, self.now_ns, &Pc::resolve(number));
            }
            self.step();
            if self.pc.reaches(number) {
                return;
            }
        }
        panic!("board {number} and the operator do not meet");
    }

    /// Virtual time of the bench, ns.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// What goes in to a board (1 or 2) at the next stop.
    pub fn input(&mut self, number: usize) -> &mut Inputs {
        &mut self.inputs[number - 1]
    }

    fn run_to(&mut self, until_ns: u64) {
        for ((node, inputs), late) in self.nodes.iter().zip(&mut self.inputs).zip(&self.late_ns) {
            node.run(until_ns - late, std::mem::take(inputs));
        }
        self.stopped = self.nodes.iter().map(Node::wait).collect();
        self.now_ns = until_ns;
        for meters in [&mut self.meters, &mut self.loops] {
            meters.iter_mut().zip(&self.stopped).for_each(|(meter, stopped)| meter.see(&stopped.hits));
        }
        for (port, (stopped, late)) in self.stopped.iter().zip(&self.late_ns).enumerate() {
            for (at, frame) in &stopped.frames {
                self.wire.send(port, at + late, frame);
            }
        }
        for frame in self.wire.receive(PC, until_ns) {
            if let Some(answer) = self.pc.hear(until_ns, &frame) {
                self.wire.send(PC, until_ns, &answer);
            }
        }
        self.talk();
    }

    /// What the PC has to say goes onto the wire, and what has arrived at the boards comes off it.
    fn talk(&mut self) {
        for frame in self.pc.talk(self.now_ns, self.nodes.len()) {
            self.wire.send(PC, self.now_ns, &frame);
        }
        for (port, inputs) in self.inputs.iter_mut().enumerate() {
            inputs.frames.extend(self.wire.receive(port, self.now_ns));
        }
    }

    /// One period in which devices stand still and a board's (1 or 2) emergency stop is pressed, so long after its beginning and for
    /// so long, ns. The tick comes in the middle of it.
    pub fn press_for(&mut self, number: usize, after_ns: u64, length_ns: u64) {
        let end_ns = self.now_ns + self.period_ns;
        self.run_to(self.now_ns + after_ns);
        self.input(number).press = Some(true);
        self.run_to(self.now_ns + length_ns);
        self.input(number).press = Some(false);
        self.run_to(end_ns);
    }

    /// One period of boards and devices.
    pub fn step(&mut self) {
        self.run_to(self.now_ns + self.period_ns);
        if let Some(partner) = &mut self.partner {
            for frame in self.wire.receive(1, self.now_ns) {
                partner.hear(self.now_ns, &frame);
            }
            for frame in partner.tick(self.now_ns) {
                self.wire.send(1, self.now_ns, &frame);
            }
        }
        // Half a PWM period before the next tick.
        let begins_ns = self.now_ns + self.period_ns / 2 - 25_000;
        if !self.loose.is_empty() {
            let time_s = self.ticks as f64 * self.period_s;
            let boards = self.stopped.iter().zip(&self.late_ns).zip(&mut self.inputs);
            for (device, ((stopped, late), inputs)) in self.loose.iter().zip(boards) {
                let counts = device.step(time_s, &stopped.bridges, begins_ns - late);
                inputs.counts = counts.or(inputs.counts);
            }
            return;
        }
        self.stops += 1;
        for (on, stopped) in self.on.iter_mut().zip(&self.stopped) {
            // From the tick that armed; outputs of bridges follow when these are awake, and amplifiers are enabled as much later.
            if on.is_none() && (stopped.bridges.enable || stopped.bridges.outputs) {
                *on = Some(self.stops);
            }
        }
        let all_on = self.on.iter().copied().try_fold(0, |last: u64, on| Some(last.max(on?)));
        // What moves by itself does so from the next tick on, and not from the one before: it is told a stop ahead.
        let ahead = u64::from(self.scenes.iter().any(has_loop));
        let begins = |since: u64| self.stops + ahead == since + self.engaging.max(ahead);
        if self.begun.is_none() && all_on.is_some_and(begins) {
            self.begun = Some(self.stops + ahead);
        }
        if self.begun.is_none() {
            return;
        }
        let mut moved = false;
        let boards = self.stopped.iter().zip(&self.late_ns).zip(&mut self.inputs);
        for (device, ((stopped, late), inputs)) in self.devices.iter().zip(boards) {
            let Some(device) = device else { continue };
            moved = true;
            let Some(period) = (self.ticks + u64::from(device.stage().is_some())).checked_sub(ahead) else { continue };
            let time_s = period as f64 * self.period_s;
            inputs.counts = device.step(time_s, &stopped.bridges, begins_ns - late).or(inputs.counts);
        }
        self.ticks += u64::from(moved);
    }

    /// Counts the instructions of every tick and of every run of a current loop from the next stop on.
    pub fn count_instructions(&mut self) {
        for meters in [&mut self.meters, &mut self.loops] {
            for (meter, inputs) in meters.iter_mut().zip(&mut self.inputs) {
                meter.clear();
                inputs.watch.extend(meter.watched());
            }
        }
    }

    /// What words of a board's memory or registers hold at the next stop.
    pub fn peek(&mut self, number: usize, addresses: impl IntoIterator<Item = u64>) -> Vec<u32> {
        self.input(number).peek.extend(addresses);
        self.step();
        std::mem::take(&mut self.stopped[number - 1].peeked)
    }

    /// What words of a board's memory, flash or registers hold now; a microsecond passes.
    pub fn peek_now(&mut self, number: usize, addresses: impl IntoIterator<Item = u64>) -> Vec<u32> {
        self.input(number).peek.extend(addresses);
        // Values are those of the stop that the board goes on from.
        self.run_to(self.now_ns + 1000);
        std::mem::take(&mut self.stopped[number - 1].peeked)
    }

    /// What a board's flash holds in a range of addresses, word by word, without what is blank.
    pub fn flash(&mut self, number: usize, range: Range<u64>) -> Vec<(u64, u32)> {
        let words = self.peek_now(number, range.clone().step_by(4));
        range.step_by(4).zip(words).filter(|(_, word)| *word != u32::MAX).collect()
    }

    /// Bytes of a board's stack that were ever in use.
    pub fn stack_used(&mut self, number: usize) -> u64 {
        let words = self.peek(number, STACK.step_by(4));
        let untouched = words.iter().take_while(|word| **word == PAINT).count() as u64;
        STACK.end + 0x100 - (STACK.start + 4 * untouched)
    }

    /// One period in which `per_ms` copies of a frame reach a board, evenly spread.
    pub fn flood(&mut self, number: usize, frame: &[u8], per_ms: usize) {
        const PARTS: usize = 20;
        let start = self.now_ns;
        for part in 1..=PARTS {
            let frames = per_ms * part / PARTS - per_ms * (part - 1) / PARTS;
            self.input(number).frames.extend(std::iter::repeat_n(frame.to_vec(), frames));
            self.run_to(start + PERIOD_NS * part as u64 / PARTS as u64);
        }
    }

    /// So many microseconds in which nothing comes in and no device moves.
    pub fn run_for_us(&mut self, us: u64) {
        self.run_to(self.now_ns + 1000 * us);
    }

    /// Runs the bench for so many ms.
    pub fn run_for_ms(&mut self, ms: u64) {
        (0..ms * PERIOD_NS / self.period_ns).for_each(|_| self.step());
    }

    /// The ticks of every board are to come with the scene's period, from one of those that they have on.
    fn pace(&mut self, scene: &Scene) {
        let (timing, tick_ns) = (&scene.peer.timing, self.now_ns - self.period_ns / 2);
        (self.period_s, self.period_ns) = (timing.control_period_s, timing.control_period_ns());
        // Again in the middle between two ticks.
        let periods = (self.now_ns - tick_ns) / self.period_ns + 1;
        self.run_to(tick_ns + periods * self.period_ns + self.period_ns / 2);
    }

    /// How fast a board's (1 or 2) device moves along its free axis, m/s.
    pub fn speed(&self, number: usize) -> f64 {
        self.devices[number - 1].as_ref().map_or(0.0, |device| device.motors().speed())
    }

    /// The ticks of a board (1 or 2) from the one at which the devices begin to move.
    pub fn armed_ticks(&self, number: usize) -> &[Record] {
        let Armed { records, standing } = self.since_armed(number);
        &records[standing..]
    }

    /// The ticks of a board (1 or 2) from the one that armed it.
    pub fn since_armed(&self, number: usize) -> Armed<'_> {
        let records = &self.pc.records[number - 1];
        let armed = records.iter().position(|record| record.mode() == Mode::Armed).unwrap_or(records.len());
        let records = &records[armed..];
        let held = self.begun.zip(self.on[number - 1]).map_or(0, |(begun, on)| (begun - on) as u32);
        let first = records.first().map_or(0, |record| record.tick() + held);
        Armed { records, standing: records.iter().take_while(|record| record.tick() < first).count() }
    }

    /// Has what is still in both boards come out: no tick is told after this.
    pub fn drain(&mut self) {
        self.send(1, "stream off");
        self.send(2, "stream off");
        self.run_for_ms(100);
    }

    /// Of each of two boards as many ticks from the one that armed it as both have with their devices moving, `least` or more, without a gap.
    pub fn both_since_armed(&self, least: u64) -> [Armed<'_>; 2] {
        let whole = [1, 2].map(|number| self.since_armed(number));
        let length = whole.iter().map(|board| board.records.len() - board.standing).min().unwrap_or(0);
        assert!(length as u64 >= least, "only {length} ticks were recorded");
        whole.map(|Armed { records, standing }| {
            let records = &records[..standing + length];
            assert!(records.windows(2).all(|two| two[1].tick() == two[0].tick() + 1), "telemetry lost ticks");
            Armed { records, standing }
        })
    }

    /// The ticks of a board (1 or 2) along its further shared axes, every one, as it reported them.
    pub fn further(&self, number: usize) -> &[Record] {
        &self.pc.further[number - 1]
    }

    /// Ends the run and gives a report of each board.
    pub fn finish(self) -> Vec<Report> {
        self.nodes.into_iter().map(Node::finish).collect()
    }
}
