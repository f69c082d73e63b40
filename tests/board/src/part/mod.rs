//! The chip and the board around it: rigless' STM32H743 with our models in front of some of its slots.
//!
//! | module | models |
//! |---|---|
//! | [`ethernet`] | MAC with address filter, DMA rings, MDIO and the PHY behind it |
//! | [`encoder`] | a timer with a quadrature encoder on its pins, edges spread over time |
//! | [`oscillator`] | the clock controller while the external clock does not come |
//! | [`iwdg`] | the independent watchdog |
//! | [`wwdg`] | the window watchdog |
//! | [`converter`] | the injected groups of ADC1 and ADC2 |
//! | [`as5047p`] | an absolute encoder on each of two SPI |
//! | [`usb`] | the second USB core, and the PC at its cable |
//! | [`fdcan`] | FDCAN1, its message memory and the bus behind it |
//! | [`moteus`] | the motor controller at that bus |
//! | `bridges` | what stands at the inputs of bridges and amplifiers |
//! | [`motors`] | what hangs at the bridges: cohold's plant and windings |
//! | `nucleo` | the board around the chip |
//! | [`rom`] | the bootloader, for an image that goes there |
//! | [`pins`] | pins by name, and which timer's input each leads to |
//! | `serial` | the PC behind the ST-LINK, at USART3 |
//!
//! On the board: 8 MHz from the ST-LINK, the strap, the emergency stop's contact, the bridges' fault line, the blue button.

pub mod as5047p;
mod bridges;
pub mod converter;
pub mod encoder;
pub mod ethernet;
pub mod fdcan;
pub mod iwdg;
pub mod moteus;
pub mod motors;
mod nucleo;
pub mod oscillator;
pub mod pins;
pub mod rom;
mod serial;
pub mod usb;
pub mod wwdg;

use rigless::device::{Device, ErasedDevice, Level, ResetCause};
use rigless::mcu::{Mcu, Operate};
use rigless::soc::stm32h743::Stm32h743;
use rigless::soc::stm32h743::peripherals::gpio::Gpio;
use rigless::soc::stm32h743::peripherals::rcc::{CLOCK_FAILURE, Rcc};
use rigless::soc::stm32h743::peripherals::rng::{self, Rng};
use rigless::soc::stm32h743::peripherals::tim::{ADVANCED_TIMERS, BreakInput, BreakSource, Tim};
use rigless::soc::stm32h743::peripherals::usart;
use rigless::soc::{Bus, Error, Gate as ClockGate, Width, Window};
use rigless::time::VirtualNanos;

pub use bridges::{Bridges, Gate};
pub use nucleo::Nucleo;

use as5047p::{As5047p, ENCODERS};
use converter::Converter;
use encoder::EncoderTimer;
use ethernet::{Dma, Mac};
use fdcan::{Fdcan, MessageMemory};
use iwdg::Iwdg;
use motors::Motors;
use oscillator::Missing;
use pins::{Edge, Place};
use serial::Console;
use usb::{Usb, host::Reader};
use wwdg::Wwdg;

/// Core clock, Hz; one instruction a cycle is assumed.
pub const CORE_HZ: u64 = 480_000_000;

/// Request of the power controller by which we say that its voltage detector breaks; the emulator's has no such wire, and uses 0 to 2.
const SUPPLY_LOW: usize = 3;

/// Time over which the edges of a PWM period are spread, ns.
const PERIOD_SPREAD_NS: u64 = 45_000;

/// Most motors that a board has.
pub const MOTORS: usize = 3;

/// The chip with our models in it.
#[derive(Debug)]
pub struct Part {
    /// Everything we do not model ourselves.
    pub chip: Stm32h743,
    /// Station management and filter.
    pub mac: Mac,
    /// DMA with its descriptor rings.
    pub dma: Dma,
    /// Watchdog on its own clock.
    pub iwdg: Iwdg,
    /// Watchdog on the bus's.
    pub wwdg: Wwdg,
    /// Converters ADC1 and ADC2 with the motors' currents.
    pub converters: [Converter; 2],
    /// FDCAN1 with a motor's controller behind it.
    pub can: Fdcan,
    message_memory: MessageMemory,
    /// USB in place of Ethernet.
    pub usb: Usb,
    /// TIM3, TIM4 and TIM2 with an encoder each.
    pub encoders: [EncoderTimer; MOTORS],
    /// What the converters' inputs read in the middle of the PWM period.
    middle: [u16; 3],
    slots: Slots,
    /// Whether the external clock comes when it is asked for.
    pub missing: Missing,
    /// The emergency stop's first contact is closed. Of this and the next two [`Part::wire`] tells the pins.
    pub stop_released: bool,
    /// A bridge reports a fault.
    pub bridge_fails: bool,
    /// The blue button is pressed.
    pub button_pressed: bool,
    gate: Gate,
    /// PD15 is high.
    gate_passes: bool,
    strap_to_ground: bool,
    noise_works: bool,
    /// A PC is at USART3.
    console: bool,
}

#[derive(Clone, Copy, Debug)]
struct Slots {
    mac: usize,
    dma: usize,
    rcc: usize,
    pwr: usize,
    iwdg: usize,
    wwdg: usize,
    adc: [usize; 2],
    can: usize,
    message_memory: usize,
    encoders: [usize; MOTORS],
    /// Ports A to G.
    gpio: [usize; 7],
    tim1: usize,
    rng: usize,
    usart3: usize,
}

/// USART3 among the emulator's ports.
const USART3: usize = 2;

impl Part {
    fn new(strap_to_ground: bool) -> Result<Self, Error> {
        let mut chip = Stm32h743::new()?;
        let memory = Window::new("FDCAN message memory", fdcan::MEMORY_AT, fdcan::MEMORY);
        // One clock is on for both (RM0433 §8.7.46).
        let message_memory = chip.bus_mut().add_window(memory.gated(ClockGate::by("RCC", "APB1HENR", "FDCANEN")))?;
        let slot = |name| chip.bus().slot(name);
        let ports = "GPIOA GPIOB GPIOC GPIOD GPIOE GPIOF GPIOG".split(' ').map(slot);
        let ports = ports.collect::<Result<Vec<usize>, _>>()?;
        let slots = Slots {
            mac: slot("Ethernet_MAC")?,
            dma: slot("Ethernet_DMA")?,
            rcc: slot("RCC")?,
            pwr: slot("PWR")?,
            iwdg: slot("IWDG")?,
            wwdg: slot("WWDG")?,
            adc: [slot("ADC1")?, slot("ADC2")?],
            can: slot("FDCAN1")?,
            message_memory,
            encoders: [slot("TIM3")?, slot("TIM4")?, slot("TIM2")?],
            gpio: ports.try_into().expect("seven ports"),
            tim1: slot("TIM1")?,
            rng: slot("RNG")?,
            usart3: slot(usart::INSTANCES[USART3])?,
        };
        let (mac, dma) = ethernet::pair();
        let (can, mut memory) = fdcan::pair();
        memory.layout = chip.bus().slots()[message_memory].peripheral().registers;
        let encoders = [1, 2, 0].map(EncoderTimer::new);
        let usb = Usb::new(&mut chip)?;
        let mut part = Self {
            chip,
            mac,
            dma,
            iwdg: Iwdg::default(),
            wwdg: Wwdg::default(),
            converters: Default::default(),
            can,
            message_memory: memory,
            usb,
            encoders,
            middle: [0; 3],
            slots,
            missing: Missing::default(),
            stop_released: true,
            bridge_fails: false,
            gate: Gate::default(),
            gate_passes: false,
            button_pressed: false,
            strap_to_ground,
            noise_works: true,
            console: false,
        };
        // The emulator leaves to the part what breaks a timer.
        part.chip.advanced[0] =
            Tim::new(ADVANCED_TIMERS[0]).breaks_on("RCC", CLOCK_FAILURE).breaks_on("PWR", SUPPLY_LOW);
        // Two chips, two noises: theirs would be the same at every power-on.
        part.chip.rng = Rng::seeded(rng::RESET_AHB_HZ, rng::KERNEL_HZ, 1 + u64::from(strap_to_ground));
        for (spi, pin, begins) in as5047p::ON {
            part.chip.spi[spi].attach_selected(As5047p::new(begins), as5047p::select(pin));
        }
        part.check()?;
        part.wire(VirtualNanos(0));
        Ok(part)
    }

    /// Puts on the pins what the wiring holds there.
    pub fn wire(&mut self, at: VirtualNanos) {
        // An open strap is pulled up by the chip; ground is ground.
        self.drive(at, Place::of("PG12"), self.strap_to_ground.then_some(false));
        // The blue button connects to 3.3 V while it is pressed, and is pulled down while it is not.
        self.drive(at, Place::of("PC13"), Some(self.button_pressed));
        // The output of the amplifiers' gate.
        self.drive(at, Place::of("PD15"), Some(self.gate_passes));
        // The contact of the emergency stop connects to 3.3 V while it is not pressed.
        self.drive(at, Place::of("PE15"), Some(self.stop_released));
        let stop = pins::level(self.stop_released);
        // There is no wiring from a pin to a timer's break inputs in the emulator: this is it.
        let mut timer = core::mem::replace(&mut self.chip.advanced[0], Tim::new(ADVANCED_TIMERS[0]));
        let (registers, mut context) = self.chip.bus_mut().drive(at, self.slots.tim1);
        timer.drive_break_source(BreakInput::First, BreakSource::Pin, stop, registers, &mut context);
        // Pulled up by the chip, pulled down by a bridge that reports a fault.
        let fault = if self.bridge_fails { Level::Low } else { Level::High };
        timer.drive_break_source(BreakInput::Second, BreakSource::Pin, fault, registers, &mut context);
        self.chip.advanced[0] = timer;
    }

    /// What the outside drives on a pin; `None`: nothing.
    fn drive(&mut self, at: VirtualNanos, place: Place, high: Option<bool>) {
        let port = usize::from(place.port);
        let mut pins = core::mem::take(&mut self.chip.gpio[port]);
        let (registers, mut context) = self.chip.bus_mut().drive(at, self.slots.gpio[port]);
        pins.drive(place.pin(), high.map(pins::level), registers, &mut context);
        self.chip.gpio[port] = pins;
    }

    /// Pins take levels, from `at` on: those that lead to a timer's input where the image has them do so at their instants.
    pub fn play(&mut self, at: VirtualNanos, edges: impl IntoIterator<Item = Edge>) {
        for Edge { at: then, place, high } in edges {
            self.drive(at, place, Some(high));
            let Some((timer, channel, function)) = pins::input(place) else { continue };
            let port = self.slots.gpio[usize::from(place.port)];
            let (registers, _) = self.chip.bus_mut().drive(at, port);
            if Gpio::function(place.pin(), registers) == Some(function) {
                let (_, mut context) = self.chip.bus_mut().drive(at, self.slots.encoders[timer]);
                self.encoders[timer].play(then, channel, pins::level(high), &mut context);
            }
        }
    }

    /// A PC is at USART3 from now on.
    pub fn attach_console(&mut self) {
        self.chip.usart[USART3].attach(Console::default());
        self.console = true;
    }

    /// The PC at USART3 says this, and gives what it has heard.
    pub fn console(&mut self, says: &[u8]) -> Vec<u8> {
        let console = self.chip.usart[USART3].chip_mut::<Console>();
        console.map_or_else(Vec::new, |console| {
            console.said.extend(says);
            core::mem::take(&mut console.heard)
        })
    }

    /// The encoders on SPI.
    pub fn on_spi(&mut self) -> [&mut As5047p; ENCODERS] {
        let on = self.chip.spi.get_disjoint_mut(as5047p::ON.map(|(spi, ..)| spi)).expect("each has one of its own");
        on.map(|spi| spi.chip_mut(0).expect("it was hung there"))
    }

    /// The first analogue output, of 4095.
    pub fn analogue(&mut self, at: VirtualNanos) -> u16 {
        self.peek(at, 0x4000_7408, Width::W32).unwrap_or(0) as u16
    }

    /// The amplifiers' enable is wired another way from now on.
    pub fn wire_gate(&mut self, at: VirtualNanos, gate: Gate) {
        self.gate = gate;
        self.show_gate(at);
    }

    /// The gate's output follows its inputs. To be called after these may have changed, and before the next tick.
    pub fn show_gate(&mut self, at: VirtualNanos) {
        let passes = self.bridges(at).gate_passes();
        if passes != core::mem::replace(&mut self.gate_passes, passes) {
            self.wire(at);
        }
    }

    /// The external clock stops, and is back by the time that the chip asks for it again.
    pub fn stop_clock(&mut self, at: VirtualNanos) {
        let mut rcc = core::mem::replace(&mut self.chip.rcc, Rcc::new());
        let (registers, mut context) = self.chip.bus_mut().drive(at, self.slots.rcc);
        rcc.fail_hse(registers, &mut context);
        self.chip.rcc = rcc;
    }

    /// The chip's supply dips, as its voltage detector would see it.
    pub fn dip_supply(&mut self, at: VirtualNanos) {
        let (_, mut context) = self.chip.bus_mut().drive(at, self.slots.pwr);
        context.request(SUPPLY_LOW, Level::High);
        context.request(SUPPLY_LOW, Level::Low);
    }

    /// Lets the noise source fail, or work again.
    pub fn noise(&mut self, at: VirtualNanos, works: bool) {
        self.noise_works = works;
        let mut rng = core::mem::replace(&mut self.chip.rng, Rng::new(rng::RESET_AHB_HZ, rng::KERNEL_HZ));
        let (registers, mut context) = self.chip.bus_mut().drive(at, self.slots.rng);
        if works {
            rng.seed_recovered(registers, &mut context);
        } else {
            rng.seed_error(registers, &mut context);
        }
        self.chip.rng = rng;
    }

    /// The next instant at which the bridges' timer updates, ns: it counts to the top of its period, and back to 0. `None` while it stands.
    pub fn next_update(&mut self, at: VirtualNanos) -> Option<u64> {
        const COUNTS_PER_S: u64 = 240_000_000;
        let mut peek = |register: u64| self.peek(at, 0x4001_0000 + register, Width::W32).unwrap_or(0);
        let (control, count, top) = (peek(0x00), peek(0x24) & 0xFFFF, peek(0x2C));
        let left = if control & 1 << 4 == 0 { 2 * top - count } else { count };
        (control & 1 != 0).then(|| at.0 + (left * 1_000_000_000).div_ceil(COUNTS_PER_S) + 1)
    }

    /// What hangs at the bridges goes on by a PWM period, which begins now.
    pub fn period(&mut self, at: VirtualNanos, motors: &mut Motors) {
        let bridges = self.bridges(at);
        let ([start, middle], counts, indexes) = motors.period(at.0, &bridges);
        self.convert(at, start, middle);
        // As the counters', whose edges of this period are still to come.
        let begins = self.encoders.each_ref().map(EncoderTimer::target);
        self.on_spi().into_iter().zip(begins).for_each(|(encoder, counts)| encoder.counts = counts);
        let moves = counts.into_iter().zip(indexes);
        for ((encoder, slot), (counts, index)) in self.encoders.iter_mut().zip(self.slots.encoders).zip(moves) {
            let (_, mut context) = self.chip.bus_mut().drive(at, slot);
            encoder.turn_within(counts, PERIOD_SPREAD_NS, &mut context);
            encoder.pass(index);
        }
    }

    /// The converters' inputs (PA3, PC0, PB1) read this at the beginning of the PWM period, which is now, and in its middle, for those
    /// converters that the bridges' timer has triggered since this was called last.
    pub fn convert(&mut self, at: VirtualNanos, start: [u16; 3], middle: [u16; 3]) {
        let timer = &self.chip.advanced[0];
        let triggers = [timer.trigger_output().1, timer.trigger2_output().1];
        for (which, reads) in [start, core::mem::replace(&mut self.middle, middle)].into_iter().enumerate() {
            let (_, mut context) = self.chip.bus_mut().drive(at, self.slots.adc[which]);
            self.converters[which].sample(triggers[which], reads, &mut context);
        }
    }

    /// Moves the encoders to these counts, edge by edge, from `at` on.
    pub fn turn(&mut self, at: VirtualNanos, counts: [i64; MOTORS]) {
        self.can.controller.counts = counts[0];
        self.on_spi().into_iter().zip(counts).for_each(|(encoder, counts)| encoder.counts = counts);
        for ((encoder, slot), counts) in self.encoders.iter_mut().zip(self.slots.encoders).zip(counts) {
            let (_, mut context) = self.chip.bus_mut().drive(at, slot);
            encoder.turn(counts, &mut context);
        }
    }

    /// Pulls the cable, or puts it back in; and that of USB with it.
    pub fn plug(&mut self, at: VirtualNanos, cable: bool) {
        self.mac.plug(at, cable);
        let (_, mut context) = self.chip.bus_mut().drive(at, self.usb.slots[0]);
        self.usb.plug(cable, &mut context);
    }

    /// A program at the PC's end of the board's serial port does this from now on.
    pub fn read_serial(&mut self, at: VirtualNanos, reader: Reader) {
        let (_, mut context) = self.chip.bus_mut().drive(at, self.usb.slots[0]);
        self.usb.read_serial(reader, &mut context);
    }

    /// Frames from the wire, by USB where the image uses that.
    pub fn deliver(&mut self, at: VirtualNanos, frames: impl IntoIterator<Item = Vec<u8>>) {
        if self.usb.is_there() {
            let (_, mut context) = self.chip.bus_mut().drive(at, self.usb.slots[0]);
            self.usb.deliver(frames, &mut context);
            return;
        }
        self.dma.inbox.extend(frames);
        let (registers, mut context) = self.chip.bus_mut().drive(at, self.slots.dma);
        Device::poll(&mut self.dma, registers, &mut context);
    }
}

impl Mcu for Part {
    fn bus(&self) -> &Bus {
        self.chip.bus()
    }
    fn bus_mut(&mut self) -> &mut Bus {
        self.chip.bus_mut()
    }
    fn reset(&mut self, at: VirtualNanos, cause: ResetCause) {
        self.usb.exchange(&mut self.chip);
        self.chip.reset(at, cause);
        self.usb.exchange(&mut self.chip);
        self.usb.reset();
        Device::reset(&mut self.mac);
        Device::reset(&mut self.dma);
        Device::reset(&mut self.iwdg);
        Device::reset(&mut self.wwdg);
        self.converters.iter_mut().for_each(Device::reset);
        Device::reset(&mut self.can);
        for encoder in &mut self.encoders {
            Device::reset(encoder);
        }
        self.wire(at);
    }
    fn poll(&mut self, now: VirtualNanos) {
        // The model forgets its fault when the generator is reset; a broken source does not.
        if !self.noise_works {
            self.noise(now, false);
        }
        // Of the models only the wire's has something outside of its own accesses and events.
        let (registers, mut context) = self.chip.bus_mut().drive(now, self.slots.dma);
        Device::poll(&mut self.dma, registers, &mut context);
        if self.console {
            let mut port = core::mem::take(&mut self.chip.usart[USART3]);
            let (registers, mut context) = self.chip.bus_mut().drive(now, self.slots.usart3);
            Device::poll(&mut port, registers, &mut context);
            self.chip.usart[USART3] = port;
        }
    }
    fn split(&mut self, slot: usize) -> (&mut Bus, Option<&mut dyn ErasedDevice>) {
        if slot == self.slots.rcc && self.missing.wanted {
            return (self.chip.bus_mut(), Some(&mut self.missing));
        }
        let model: &mut dyn ErasedDevice = match slot {
            s if s == self.slots.mac => &mut self.mac,
            s if s == self.slots.dma => &mut self.dma,
            s if s == self.slots.iwdg => &mut self.iwdg,
            s if s == self.slots.wwdg => &mut self.wwdg,
            s if s == self.slots.adc[0] => &mut self.converters[0],
            s if s == self.slots.adc[1] => &mut self.converters[1],
            s if s == self.slots.can => &mut self.can,
            s if s == self.usb.slots[0] => &mut self.usb.blocks[0],
            s if s == self.usb.slots[1] => &mut self.usb.blocks[1],
            s if s == self.usb.slots[2] => &mut self.usb.blocks[2],
            s if s == self.slots.message_memory => &mut self.message_memory,
            s if s == self.slots.encoders[0] => &mut self.encoders[0],
            s if s == self.slots.encoders[1] => &mut self.encoders[1],
            s if s == self.slots.encoders[2] => &mut self.encoders[2],
            _ => return self.chip.split(slot),
        };
        (self.chip.bus_mut(), Some(model))
    }
}
