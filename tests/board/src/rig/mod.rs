//! Two virtual boards wired pin to pin: the release image on one, the rig's image on the other, and the PC that talks to both.
//!
//! Time goes in steps: the board under test first, and then the rig, which so sees the board's edges at their own instants. What the rig does reaches
//! the board at the end of its step. A step is 50 µs, and ends where the board's timer updates; 50 ns while the rig's light says that it is
//! measuring, so that a break is measured late by a step at the most, and never early.

/// What the virtual boards and those on a table do alike with the records that they take.
macro_rules! by_records {
    () => {
        fn codes(&mut self) -> [Vec<i16>; 2] {
            told::codes(&self.take())
        }
        fn came(&mut self, came: &mut Came) {
            told::came(&self.take(), came);
        }
        fn stop_is_seen(&mut self, pressed: &[&str], released: &[&str]) -> Outcome {
            stop::seen(self, pressed, released)
        }
    };
}

mod legs;
pub mod openocd;
pub mod port;
mod stop;
pub mod table;
mod told;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use cohold_rig::list::Test;
use cohold_rig::run::{self, Boards, Came, Done, Outcome};
use firmware_parts::record::Record;
use legs::Legs;
use stop::Records;

use crate::bench::PERIOD_NS;
use crate::image::{self, Firmware};
use crate::node::{Inputs, Node, Report, Stopped};
use crate::part::Gate;
use crate::part::converter::IDLE;
use crate::part::pins::{Edge, Place};
use crate::pc::{Pc, keys_in_flash, operator_key, peers_key};
use crate::wire::{Line, PC, Wire};

/// A step, ns, while the rig measures and while it does not: a period of the board's pulses.
const FINE_NS: u64 = 50;
const STEP_NS: u64 = 50_000;
/// A step while the rig's analogue output rings, ns.
const RINGING_NS: u64 = 1000;
/// A step while the board's tick stands and its reset is waited for, ns.
const STOPPED_NS: u64 = 5000;
/// 10 kΩ and 10 µF, ns.
const SLOW_NS: f64 = 1e8;
/// DBGMCU_APB2FZ1, whose lowest bit stops TIM1 while a debugger halts the core, and so turns its outputs off (RM0433 §60.5.8); and TIM7's counter,
/// 10 counts a millisecond, which goes on.
const AT_HALT: [u64; 2] = [0x5C00_104C, 0x4000_1424];

/// Pins of the rig that go to pins of the same name.
const ENCODERS: [Place; 5] =
    [Place::of("PC6"), Place::of("PC7"), Place::of("PC8"), Place::of("PD12"), Place::of("PD13")];
const GATE: Place = Place::of("PD15");
const STOP: Place = Place::of("PE15");
const FAULT: Place = Place::of("PE6");
const ENABLE: Place = Place::of("PF3");
/// The rig's pin that goes to the board's blue button, and its light.
const BUTTON: Place = Place::of("PD14");
const LIGHT: Place = Place::of("PE1");
/// The rig's pins at which it captures the stop and the fault line.
const STOP_BACK: Place = Place::of("PB11");
const FAULT_BACK: Place = Place::of("PB3");

/// Both boards and the PC.
pub struct Rigged {
    board: Node,
    rig: Node,
    board_inputs: Inputs,
    rig_inputs: Inputs,
    wire: Wire,
    /// The PC, as operator of the board.
    pub pc: Pc,
    /// What the board did at the last stop.
    pub stopped: Stopped,
    legs: Legs,
    /// When the board's timer updates next, ns.
    update: Option<u64>,
    enabled: bool,
    measuring: bool,
    /// How long a step is while the rig does not measure, ns.
    step_ns: u64,
    /// What the rig has on the pins of encoders.
    levels: BTreeMap<Place, bool>,
    /// Bytes from the rig that nobody has taken yet.
    heard: Vec<u8>,
    /// The analogue output of the rig, of 4095.
    pub analogue: u16,
    /// What is behind 10 kΩ and 10 µF of it, of 4095, at the board's three analogue inputs; as long as it is 0 they read what they read without.
    volts: f64,
    /// It is at PA3 without those, and there alone.
    direct: bool,
    /// The board's processor is halted, and its timer's outputs with it, or not.
    halted: Option<bool>,
    /// How long it was halted so far, ns.
    lag_ns: u64,
    /// Records that have been taken.
    taken: usize,
    now_ns: u64,
    /// The PC has been served up to here, ms.
    served: u64,
}

impl Rigged {
    /// Both at power-on, run until the board knows the PC.
    pub fn start(firmware: &Arc<Firmware>, image: &Arc<Firmware>) -> Self {
        let mut rigged = Self {
            board: Node::new(firmware.clone(), 1),
            rig: Node::rig(image.clone()),
            board_inputs: Inputs { poke: keys_in_flash(&peers_key(), &operator_key()), ..Inputs::default() },
            rig_inputs: Inputs::default(),
            wire: Wire::new(Line::default()),
            pc: Pc::default(),
            stopped: Stopped::default(),
            legs: Legs::default(),
            update: None,
            enabled: false,
            measuring: false,
            step_ns: STEP_NS,
            levels: BTreeMap::new(),
            heard: Vec::new(),
            analogue: 0,
            volts: 0.0,
            direct: false,
            halted: None,
            lag_ns: 0,
            taken: 0,
            now_ns: 1000,
            served: 0,
        };
        rigged.run_ms(60);
        rigged.greet();
        rigged
    }

    /// Until the board, which has just started, and the PC know each other.
    ///
    /// # Panics
    /// They do not meet within two seconds.
    fn greet(&mut self) {
        for ms in 0..2000 {
            if ms % 100 == 0 {
                self.wire.send(PC, self.now_ns, &Pc::resolve(1));
            }
            self.run_ms(1);
            if self.pc.reaches(1) {
                return;
            }
        }
        panic!("the board and its operator do not meet");
    }

    /// Goes on for so long.
    pub fn run_ms(&mut self, ms: u64) {
        let until = self.now_ns + ms * PERIOD_NS;
        while self.now_ns < until {
            self.step();
        }
    }

    /// Virtual time, ns.
    pub fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Puts a word into a register of the board, as something that is wrong there would.
    pub fn spoil(&mut self, address: u64, value: u32) {
        self.board_inputs.poke.push((address, value));
    }

    fn step(&mut self) {
        let rings = self.direct && self.stopped.bridges.outputs;
        let length = if self.measuring { FINE_NS } else { self.step_ns.min(if rings { RINGING_NS } else { STEP_NS }) };
        let update = self.update.filter(|_| self.halted.is_none());
        let until = update.map_or(self.now_ns + length, |update| update.min(self.now_ns + length));
        self.volts += (f64::from(self.analogue) - self.volts) * (until - self.now_ns) as f64 / SLOW_NS;
        let updates = update == Some(until);
        match self.halted {
            Some(off) => {
                // Neither its processor nor what DBGMCU stops goes on.
                self.lag_ns += until - self.now_ns;
                self.stopped.bridges.outputs &= !off;
                self.stopped.frames.clear();
            }
            None => self.run_board(until, updates),
        }
        let mut edges = self.legs.see(until, &self.stopped.bridges, updates);
        let enable = self.stopped.bridges.enable;
        if enable != core::mem::replace(&mut self.enabled, enable) {
            edges.push(Edge { at: until, place: ENABLE, high: enable });
        }
        for (at, frame) in &self.stopped.frames {
            self.wire.send(0, *at, frame);
        }
        self.rig_inputs.edges.extend(edges);
        self.rig.run(until, std::mem::take(&mut self.rig_inputs));
        let rig = self.rig.wait();
        for edge in rig.edges {
            self.route(edge, until);
        }
        self.heard.extend(rig.heard);
        self.analogue = rig.analogue;
        self.now_ns = until;
        self.serve();
    }

    /// The board goes on; its own clock is behind by as long as it was halted.
    fn run_board(&mut self, until: u64, updates: bool) {
        let code = |volts: f64| (volts * 16.0).round().min(65_535.0) as u16;
        if self.direct {
            self.board_inputs.reads = Some([code(self.analogue.into()), IDLE[1], IDLE[2]]);
        } else if self.volts > 0.0 {
            self.board_inputs.reads = Some([code(self.volts); 3]);
        }
        for edge in &mut self.board_inputs.edges {
            edge.at -= self.lag_ns;
        }
        self.board.run(until - self.lag_ns, std::mem::take(&mut self.board_inputs));
        let before = self.stopped.resets;
        self.stopped = self.board.wait();
        for (at, _) in &mut self.stopped.frames {
            *at += self.lag_ns;
        }
        if before != self.stopped.resets {
            self.step_ns = STEP_NS;
        }
        // Once it runs, its periods are as long as a step; after a reset it begins anew.
        self.update = match self.update.filter(|_| before == self.stopped.resets) {
            Some(update) if updates => Some(update + STEP_NS),
            Some(update) => Some(update),
            None => self.stopped.update.map(|update| update + self.lag_ns),
        };
    }

    /// What the rig did in the step that ends now reaches the board, and the rig's own inputs.
    fn route(&mut self, edge: Edge, until: u64) {
        let Edge { at, place, high } = edge;
        let (board, back) = (&mut self.board_inputs, &mut self.rig_inputs.edges);
        match place {
            GATE => board.gate = Some(if high { Gate::AlwaysOpen } else { Gate::NeverOpens }),
            STOP => {
                board.press = Some(!high);
                back.push(Edge { at: until, place: STOP_BACK, high });
            }
            FAULT => {
                board.bridge_fails = Some(!high);
                back.push(Edge { at: until, place: FAULT_BACK, high });
            }
            BUTTON => board.button = Some(high),
            LIGHT => self.measuring = high,
            _ if ENCODERS.contains(&place) => {
                self.levels.insert(place, high);
                board.edges.push(Edge { at: until + (at - self.now_ns), ..edge });
            }
            _ => {}
        }
    }

    /// Bytes to the rig's serial port.
    pub fn say(&mut self, bytes: &[u8]) {
        self.rig_inputs.said.extend(bytes);
    }

    /// What has come from the rig's serial port since it was asked last.
    pub fn heard(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.heard)
    }

    /// The PC talks and listens once a millisecond.
    fn serve(&mut self) {
        let now = self.now_ns;
        if now / PERIOD_NS == self.served {
            return;
        }
        self.served = now / PERIOD_NS;
        for frame in self.wire.receive(PC, now) {
            if let Some(answer) = self.pc.hear(now, &frame) {
                self.wire.send(PC, now, &answer);
            }
        }
        for frame in self.pc.talk(now, 1) {
            self.wire.send(PC, now, &frame);
        }
        self.board_inputs.frames.extend(self.wire.receive(0, now));
    }

    /// Ends the run: what the emulator could not do, of the board and of the rig.
    pub fn finish(self) -> [Report; 2] {
        [self.board.finish(), self.rig.finish()]
    }
}

/// Where the rig's image is, beside the release image.
pub fn image() -> PathBuf {
    image::path().with_file_name("rig")
}

/// Both at power-on, the board with this image and told of amplifiers.
///
/// # Errors
/// What one of them did not take.
pub fn start(firmware: Firmware) -> Result<Rigged, String> {
    let mut rigged = Rigged::start(&Arc::new(firmware), &Arc::new(Firmware::read(&image())));
    run::set_up(&mut rigged)?;
    Ok(rigged)
}

impl Records for Rigged {
    fn take(&mut self) -> Vec<Record> {
        let records = &self.pc.records[0];
        let new = records[self.taken.min(records.len())..].to_vec();
        self.taken = records.len();
        new
    }
}

impl Boards for Rigged {
    fn wired(&mut self, test: &Test) {
        self.direct = test.is_direct();
    }

    fn ask(&mut self, line: &str) -> Outcome {
        let before = self.pc.answers[0].len();
        self.pc.say(1, line);
        for _ in 0..1000 {
            self.wait_ms(1)?;
            if let Some(answer) = self.pc.answers[0].get(before) {
                return Ok(answer.clone());
            }
        }
        Err(format!("the board does not answer {line:?}"))
    }

    fn order(&mut self, line: &str) -> Done {
        self.say(format!("{line}\n").as_bytes());
        Ok(())
    }

    fn answer(&mut self, within_ms: u64) -> Outcome {
        for _ in 0..within_ms {
            if let Some(line) = port::line(&mut self.heard) {
                return Ok(line);
            }
            self.wait_ms(1)?;
        }
        Err("the rig does not answer".to_owned())
    }

    fn probing_ms(&self) -> u64 {
        20
    }

    fn stop_ticks(&mut self) -> Done {
        let (address, standing) = openocd::TICK_STANDS;
        self.spoil(address, standing);
        self.step_ns = STOPPED_NS;
        Ok(())
    }

    fn halt(&mut self, ms: u64) -> Done {
        self.board_inputs.peek.extend(AT_HALT);
        self.step();
        self.halted = Some(self.stopped.peeked[0] & 1 != 0);
        self.step_ns = STOPPED_NS;
        self.step();
        self.step_ns = STEP_NS;
        let (begun, count) = (self.lag_ns, self.stopped.peeked[1]);
        self.wait_ms(ms)?;
        self.halted = None;
        self.spoil(AT_HALT[1], (count + 10 * ms as u32) & 0xFFFF);
        self.update = self.update.map(|update| update + STOPPED_NS + self.lag_ns - begun);
        Ok(())
    }

    by_records! {}

    fn meet(&mut self) -> Done {
        self.wait_ms(1300)?;
        // The board's timers see again what the rig has left on their pins.
        let levels = self.levels.iter().map(|(place, high)| Edge { at: self.now_ns, place: *place, high: *high });
        self.board_inputs.edges.extend(levels);
        self.greet();
        Ok(())
    }

    fn counts(&mut self) -> Result<[u16; 2], String> {
        // A board that started anew has to be told again.
        self.ask("stream 1")?;
        self.wait_ms(20)?;
        told::counts(&self.pc.records[0])
    }

    fn same(&mut self, per_ms: u32) -> Result<[u64; 2], String> {
        self.wait_ms(40)?;
        Ok(told::same(&self.pc.records[0], per_ms))
    }

    fn wait_ms(&mut self, ms: u64) -> Done {
        self.run_ms(ms);
        Ok(())
    }
}
