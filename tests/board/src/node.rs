//! One board in a process of its own, stepped from outside: run to an instant, say what happened, take what comes in.
//!
//! The emulator calls back at the instant it was asked to reach; the process then hands out what the board did and waits.
//! So several boards run at the same time, and everything between them is decided in one place, in order: runs are
//! reproducible to the bit, and a board that is told what another was need not run at all (`memo`).

use std::cell::{Cell, RefCell};
use std::path::Path;
use std::sync::{Arc, Mutex};

use rigless::emulator::{AccessKind, Driver, Host, Settled, Start, Stop, Watch, run};
use rigless::image::Image;
use rigless::mcu::Operate;
use rigless::session::Session;
use rigless::soc::Width;
use rigless::time::VirtualNanos;
use serde::{Deserialize, Serialize};

use crate::image::Firmware;
use crate::memo::{Board, Told};
use crate::part::as5047p::{self, As5047p, ENCODERS};
use crate::part::fdcan::BusFault;
use crate::part::moteus::{Controller, Planted};
use crate::part::motors::{Act, Felt, Made, Motors};
use crate::part::pins::{self, Edge};
use crate::part::rom;
use crate::part::usb::host::{Found, Reader};
use crate::part::{Bridges, Gate, MOTORS, Nucleo, Part};
use crate::process::{answer, leave, order};

/// What comes in at a stop, before the board goes on.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Inputs {
    /// Frames from the wire.
    pub frames: Vec<Vec<u8>>,
    /// What hangs at the bridges from now on and moves by itself: there is another in the board's process.
    #[serde(skip)]
    pub motors: Option<Option<Arc<Mutex<Motors>>>>,
    /// Where the device has moved the encoders.
    pub counts: Option<[i64; MOTORS]>,
    /// The emergency stop is pressed (or released).
    pub press: Option<bool>,
    /// A bridge reports a fault (or none any more).
    pub bridge_fails: Option<bool>,
    /// The amplifiers' enable is wired another way.
    pub gate: Option<Gate>,
    /// What is wrong with the CAN bus from now on, and errors that its sender has counted already.
    pub bus: Option<(BusFault, u32)>,
    /// What the motor's controller there does wrong from now on.
    pub controller: Option<Planted>,
    /// Counts of the joint for a revolution of that controller's output.
    pub counts_per_rev: Option<f64>,
    /// What is wrong with the encoder of a joint (from 0) on SPI from now on.
    pub encoder: Option<(usize, as5047p::Planted)>,
    /// So many triggers do not reach the first converter.
    pub misses: Option<u32>,
    /// What the divider of a motor's thermistor reads (PA6), of 65536; nothing after a reset, as shorted.
    pub thermistor: Option<u16>,
    /// The chip's supply dips below what its voltage detector is set to.
    pub supply_dips: bool,
    /// The external clock stops for a moment.
    pub clock_stops: bool,
    /// The external clock does not come at this start.
    pub clock_missing: bool,
    /// The blue button is pressed (or released).
    pub button: Option<bool>,
    /// The cable is in (or out).
    pub cable: Option<bool>,
    /// The noise source of the random number generator works (or fails).
    pub noise: Option<bool>,
    /// Words of memory to look at, at the stop itself: their values are in the next [`Stopped::peeked`].
    pub peek: Vec<u64>,
    /// Words put into memory or flash, as a fault would: address and value.
    pub poke: Vec<(u64, u32)>,
    /// Levels that pins take while it goes on, in order.
    pub edges: Vec<Edge>,
    /// Who is at the board's serial port by USB from now on.
    pub reader: Option<Reader>,
    /// What the PC says at USART3.
    pub said: Vec<u8>,
    /// What the converter's inputs (PA3, PC0, PB1) read at the trigger that has just come, if one has.
    pub reads: Option<[u16; 3]>,
    /// Instructions to watch from now on.
    pub watch: Vec<u64>,
    /// Instructions to watch no more.
    pub unwatch: Vec<u64>,
}

/// What a board did up to a stop.
#[derive(Debug, Default, Serialize, Deserialize)]
pub struct Stopped {
    /// Virtual time of the stop, ns.
    pub at: u64,
    /// Frames that left, each with its instant.
    pub frames: Vec<(u64, Vec<u8>)>,
    /// What the bridges are commanded.
    pub bridges: Bridges,
    /// The motor's controller at the CAN bus, whether the image knows of one or not.
    pub controller: Controller,
    /// The encoders on SPI, whether the image knows of them or not.
    pub encoders: [As5047p; ENCODERS],
    /// Watched instructions that were reached.
    pub hits: Vec<Hit>,
    /// Number of resets so far.
    pub resets: usize,
    /// What the words asked for held when the board went on.
    pub peeked: Vec<u32>,
    /// Of what hangs at the bridges and moves by itself.
    pub felt: Option<Felt>,
    /// When the bridges' timer updates next, ns.
    pub update: Option<u64>,
    /// What the PC read at the board's serial port by USB.
    pub serial: Vec<u8>,
    /// What the PC found at its end of the USB cable.
    pub found: Option<Found>,
    /// Of a rig: levels that its program gave to pins, what it said at USART3, and its analogue output, of 4095.
    pub edges: Vec<Edge>,
    /// See [`Stopped::edges`].
    pub heard: Vec<u8>,
    /// See [`Stopped::edges`].
    pub analogue: u16,
}

/// A watched instruction was reached.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Hit {
    /// Its address.
    pub address: u64,
    /// When.
    pub at: VirtualNanos,
    /// Instructions that the board had run.
    pub instruction_count: u64,
}

/// What the emulator could not do, or did although nobody modelled it: a test must not pass because of it.
#[derive(Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Report {
    /// `kind what`, sorted, each once.
    pub lines: Vec<String>,
    /// Causes of the resets.
    pub resets: Vec<String>,
    /// Frames the filter left out, lost for want of buffers, and sent or received without a link.
    pub frames: [u64; 3],
}

#[derive(Serialize, Deserialize)]
enum Order {
    /// Power comes on with these bytes in flash for board 1 or 2, or for a rig.
    Begin {
        segments: Vec<(u64, Vec<u8>)>,
        number: usize,
        rig: bool,
    },
    /// Until an instant, after this has come in.
    Run {
        until: u64,
        hangs: Hangs,
        inputs: Box<Inputs>,
    },
    Finish,
}

#[derive(Serialize, Deserialize)]
enum Answer {
    Stopped(Box<Stopped>),
    Finished(Report),
    Failed(String),
}

/// What hangs at the bridges and moves by itself, of all that did so far; the last of these may be new. And what was done to it.
#[derive(Default, Serialize, Deserialize)]
struct Hangs {
    which: Option<usize>,
    made: Option<Made>,
    acts: Vec<Act>,
}

/// A board's handle.
#[derive(Debug)]
pub struct Node {
    board: RefCell<Board>,
    /// What has hung at its bridges and moves by itself, and what does.
    motors: RefCell<Vec<Arc<Mutex<Motors>>>>,
    hangs: Cell<Option<usize>>,
}

#[derive(Default)]
struct Stepper {
    hits: Vec<Hit>,
    peeked: Vec<u32>,
    /// What has hung at the bridges and moves by itself; what does, and when its next PWM period begins, ns.
    motors: Vec<Motors>,
    hangs: Option<usize>,
    next: Option<u64>,
    /// When the bench wants to hear of the board, ns.
    until: u64,
    /// When a break has taken the outputs, and with them the gate of amplifiers, ns.
    broken: Option<u64>,
    /// Resets that the timer's phase is known for.
    resets: usize,
    /// What a rig's program gave to pins since the last stop; none of any other board.
    edges: Option<Vec<Edge>>,
}

/// A PWM period, ns.
const PWM_NS: u64 = 50_000;
/// What the filter of a break takes, ns: 8 samples at an eighth of 240 MHz, and the one before them.
const BREAK_NS: u64 = 275;

impl Stepper {
    /// The PWM period that begins now, if one does; the next stop.
    fn periods(&mut self, part: &mut Part, at: VirtualNanos) {
        if let (Some(hangs), Some(next)) = (self.hangs, &mut self.next)
            && *next <= at.0
        {
            part.period(at, &mut self.motors[hangs]);
            *next += PWM_NS;
        }
    }

    fn next_stop(&self) -> VirtualNanos {
        VirtualNanos([self.next, self.broken].into_iter().flatten().fold(self.until, u64::min))
    }
}

/// Does it with what is given, if it is.
fn given<T>(input: Option<T>, does: impl FnOnce(T)) {
    if let Some(input) = input {
        does(input);
    }
}

impl Driver<Nucleo> for Stepper {
    fn on_settled(&mut self, _: &mut Session<Nucleo>, _: &mut dyn Host, settled: Settled) {
        match (settled, &mut self.edges) {
            (Settled::Hit(rigless::emulator::Hit { address, at, instruction_count, .. }), _) => {
                self.hits.push(Hit { address, at, instruction_count });
            }
            (Settled::Access { access, value }, Some(edges)) if access.kind == AccessKind::Write => {
                edges.extend(pins::written(access.virtual_time.0, access.address, value));
            }
            _ => {}
        }
    }

    fn on_stop(&mut self, session: &mut Session<Nucleo>, stop: Stop, host: &mut dyn Host) -> Option<VirtualNanos> {
        let resets = session.resets().len();
        let part = &mut session.board_mut().part;
        self.periods(part, stop.at);
        let broken = self.broken.take_if(|broken| *broken <= stop.at.0).is_some();
        if broken || stop.at.0 >= self.until {
            part.show_gate(stop.at);
        }
        if stop.at.0 < self.until {
            return Some(self.next_stop());
        }
        let (frames, serial) = part.usb.heard();
        let stopped = Stopped {
            at: stop.at.0,
            frames: std::mem::take(&mut part.dma.sent).into_iter().chain(frames).collect(),
            serial,
            found: part.usb.found(),
            bridges: part.bridges(stop.at),
            controller: part.can.controller,
            encoders: part.on_spi().map(|encoder| *encoder),
            hits: std::mem::take(&mut self.hits),
            peeked: std::mem::take(&mut self.peeked),
            resets,
            felt: self.hangs.map(|hangs| self.motors[hangs].felt()),
            update: part.next_update(stop.at),
            edges: self.edges.as_mut().map_or_else(Vec::new, std::mem::take),
            heard: part.console(&[]),
            analogue: part.analogue(stop.at),
        };
        let Order::Run { until, hangs, inputs } = told(&Answer::Stopped(Box::new(stopped))) else {
            say(&Answer::Finished(report(session)));
            leave();
        };
        let (inputs, part) = (*inputs, &mut session.board_mut().part);
        let at = stop.at;
        given(inputs.cable, |cable| part.plug(at, cable));
        given(inputs.reader, |reader| part.read_serial(at, reader));
        given(inputs.press, |pressed| part.stop_released = !pressed);
        given(inputs.bridge_fails, |fails| part.bridge_fails = fails);
        given(inputs.button, |pressed| part.button_pressed = pressed);
        if [inputs.press, inputs.bridge_fails, inputs.button].iter().any(Option::is_some) {
            part.wire(at);
        }
        if inputs.supply_dips {
            part.dip_supply(at);
        }
        if inputs.press.is_some() || inputs.bridge_fails.is_some() || inputs.supply_dips {
            self.broken = Some(at.0 + BREAK_NS);
        }
        given(inputs.gate, |gate| part.wire_gate(at, gate));
        given(inputs.bus, |(fault, errors)| (part.can.fault, part.can.errors) = (fault, errors));
        given(inputs.controller, |planted| part.can.controller.planted = planted);
        given(inputs.counts_per_rev, |counts| part.can.controller.counts_per_rev = counts);
        given(inputs.encoder, |(joint, planted)| part.on_spi()[joint].planted = planted);
        given(inputs.thermistor, |to| part.converters[1].thermistor = to);
        given(inputs.misses, |misses| part.converters[0].misses = misses);
        if inputs.clock_stops {
            part.stop_clock(at);
        }
        part.missing.wanted |= inputs.clock_missing;
        given(inputs.noise, |works| part.noise(at, works));
        self.motors.extend(hangs.made.as_ref().map(Motors::again));
        self.hangs = hangs.which;
        if let Some(which) = self.hangs {
            hangs.acts.into_iter().for_each(|act| self.motors[which].act(act));
        }
        if self.hangs.is_none() || self.next.is_none() || core::mem::replace(&mut self.resets, resets) != resets {
            self.next = self.hangs.and_then(|_| part.next_update(stop.at));
        }
        self.until = until;
        given(inputs.counts, |counts| part.turn(at, counts));
        part.play(stop.at, inputs.edges);
        part.console(&inputs.said);
        given(inputs.reads, |reads| part.convert(at, reads, reads));
        if !inputs.frames.is_empty() {
            part.deliver(stop.at, inputs.frames);
        }
        let mut word = |address| {
            let register = address >= 0x4000_0000;
            let word = if register {
                part.peek(stop.at, address, Width::W32).ok()
            } else {
                host.read(address, Width::W32).ok()
            };
            word.expect("memory is there") as u32
        };
        self.peeked = inputs.peek.into_iter().map(&mut word).collect();
        for (address, value) in inputs.poke {
            let flash = (0x0800_0000..0x0820_0000).contains(&address);
            if address >= 0x4000_0000 {
                part.write(stop.at, address, Width::W32, value.into()).expect("the register is there");
                continue;
            }
            let outcome = if flash {
                host.program(address, Width::W32, value.into())
            } else {
                host.write(address, Width::W32, value.into())
            };
            outcome.expect("memory is there");
        }
        for address in inputs.watch {
            host.watch(Watch::Instruction(address));
        }
        for address in inputs.unwatch {
            host.unwatch(Watch::Instruction(address));
        }
        Some(self.next_stop())
    }
}

impl Node {
    /// Board `number` (1 or 2) with the image, at the instant power came on.
    pub fn new(firmware: Arc<Firmware>, number: usize) -> Self {
        Self::start(firmware, number, false)
    }

    /// A rig with its image, and the PC at its serial port, at the instant power came on.
    pub fn rig(image: Arc<Firmware>) -> Self {
        Self::start(image, 1, true)
    }

    fn start(firmware: Arc<Firmware>, number: usize, rig: bool) -> Self {
        let node =
            Self { board: Board::new(serve, firmware.alone).into(), motors: Vec::new().into(), hangs: None.into() };
        let segments = firmware.image.segments().map(|(at, bytes)| (at, bytes.to_vec())).collect();
        node.tell(&Order::Begin { segments, number, rig });
        // The first stop, 1 µs in, has nothing to tell.
        node.wait();
        node
    }

    fn tell(&self, order: &Order) {
        self.board.borrow_mut().tell(bytes(order));
    }

    fn hear(&self) -> Answer {
        match of(&self.board.borrow_mut().hear()) {
            Answer::Failed(why) => panic!("{why}"),
            answer => answer,
        }
    }

    /// Lets the board run until `until_ns`; [`Node::wait`] says when it is there.
    pub fn run(&self, until: u64, mut inputs: Inputs) {
        let mut hangs = Hangs::default();
        let mut all = self.motors.borrow_mut();
        if let Some(motors) = inputs.motors.take() {
            self.hangs.set(motors.map(|motors| {
                let known = all.iter().position(|known| Arc::ptr_eq(known, &motors));
                known.unwrap_or_else(|| {
                    let made = motors.lock().expect("nobody panics with it").made.clone();
                    assert_eq!(Motors::again(&made).made, made, "its keys say all of a scene");
                    hangs.made = Some(made);
                    all.push(motors);
                    all.len() - 1
                })
            }));
        }
        hangs.which = self.hangs.get();
        if let Some(which) = hangs.which {
            hangs.acts = std::mem::take(&mut all[which].lock().expect("nobody panics with it").acts);
        }
        self.tell(&Order::Run { until, hangs, inputs: Box::new(inputs) });
    }

    /// Waits for the stop.
    pub fn wait(&self) -> Stopped {
        let Answer::Stopped(stopped) = self.hear() else { panic!("it was told to run") };
        if let Some((which, felt)) = self.hangs.get().zip(stopped.felt) {
            self.motors.borrow()[which].lock().expect("nobody panics with it").feel(felt);
        }
        *stopped
    }

    /// All that it was told and answered, in bytes, the last first; and how many of the first orders other boards were told before.
    pub fn told(&self) -> Told {
        self.board.borrow().told()
    }

    /// Boards that are told what this one was so far go on from here.
    pub fn checkpoint(&self) {
        self.board.borrow().checkpoint();
    }

    /// Ends the board's run and gives its report.
    pub fn finish(self) -> Report {
        self.tell(&Order::Finish);
        let Answer::Finished(report) = self.hear() else { panic!("it was told to finish") };
        report
    }
}

fn bytes(message: &impl Serialize) -> Vec<u8> {
    postcard::to_stdvec(message).expect("it has a form")
}

fn of<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> T {
    postcard::from_bytes(bytes).expect("both ends are one program")
}

fn say(message: &Answer) {
    answer(&bytes(message));
}

fn told(message: &Answer) -> Order {
    say(message);
    of(&order())
}

/// Runs a board in this process, as it is told.
fn serve() -> ! {
    std::panic::set_hook(Box::new(|panic| {
        say(&Answer::Failed(panic.to_string()));
        leave();
    }));
    let Order::Begin { segments, number, rig } = of(&order()) else { leave() };
    let mut board = Nucleo::new(number).expect("the emulator knows this part");
    if rig {
        board.part.attach_console();
    }
    let session = Session::new(Box::new(board), 0, VirtualNanos(1000)).expect("a session");
    let image = |(at, bytes)| Image::new(Path::new("flash"), bytes, Some(at)).expect("bytes at an address");
    let images: Vec<Image> = segments.into_iter().map(image).chain([rom::image()]).collect();
    let stepper = Stepper { edges: rig.then(Vec::new), ..Stepper::default() };
    let ended = run(session, &Start::new(&images), stepper);
    panic!("the emulator ended: {:?}", ended.err());
}

fn report(session: &mut Session<Nucleo>) -> Report {
    let mut lines: Vec<String> = session.unmapped().iter().map(|u| format!("unmapped {:#010x}", u.address)).collect();
    lines.extend(session.refused().keys().map(|address| format!("refused {address:#010x}")));
    lines.extend(
        session.unimplemented().values().map(|u| {
            format!("unimplemented {}.{}{}", u.instance, u.register, if u.writes > 0 { " written" } else { "" })
        }),
    );
    lines.extend(session.undefined().values().map(|u| format!("undefined in {}", u.instance)));
    lines.extend(session.unrouted().iter().map(|(instance, number)| format!("unrouted {instance} {number}")));
    lines.extend(session.told().map(|told| format!("told {}.{}: {}", told.instance, told.register, told.reason)));
    lines.sort();
    lines.dedup();
    let resets = session.resets().iter().map(|reset| format!("{:?}", reset.cause)).collect();
    let part = &session.board().part;
    let (dma, usb) = (&part.dma, &part.usb);
    Report { lines, resets, frames: [dma.filtered, dma.overflowed, dma.unlinked + usb.unlinked()] }
}
