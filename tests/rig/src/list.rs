//! The tests. Names of pins are the chip's; firmware/wiring/netlist.toml says where each is on the connectors.
//!
//! Most wires join pins of one name. What the rig captures is at the inputs of its one timer of 32 bits, TIM2; its analogue output is one
//! that leaves them alone.

/// One thing that is asked of silicon.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// Its name, and the anchor of its line on the page.
    pub name: &'static str,
    /// Its wires, in bundles.
    pub wires: &'static [&'static [Wire]],
    /// What the rig, or the PC, does.
    pub drives: &'static str,
    /// What is measured, and by whom.
    pub measures: &'static str,
    /// What it answers about the board.
    pub question: &'static str,
    /// Result with which it passes, with units.
    pub bound: &'static str,
    /// How long it takes, s.
    pub seconds: u32,
    /// What the rig's own image does of it on virtual boards.
    pub virtual_rig: Virtual,
}

impl Test {
    /// Whether its wires at PA3 and PB1 differ from those of the other tests.
    pub fn is_direct(&self) -> bool {
        self.wires.concat().iter().any(|wire| matches!(wire, Direct(_)))
    }
}

/// What two virtual boards do of a test: `cargo xtask rig --virtual`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Virtual {
    /// It runs there, in this extent.
    Runs(&'static str),
    /// It does not, for this reason.
    Not(&'static str),
}

/// A wire between the two boards.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wire {
    /// The rig drives this pin of the board, by the pin of the same name.
    Drives(&'static str),
    /// The rig looks at this pin of the board, by that pin of its own.
    Sees(&'static str, &'static str),
    /// The rig captures what it drives by this pin itself, by that one.
    Back(&'static str, &'static str),
    /// The rig's analogue output PA4 to this pin of the board, through 10 kΩ, with 10 µF there.
    Analogue(&'static str),
    /// The same without resistor and capacitor, so that a step of the output is a step there.
    Direct(&'static str),
    /// The rig's PD14 to the board's blue button, PC13: its settings are taken only while that is down.
    Button,
}

use Virtual::{Not, Runs};
use Wire::{Analogue, Back, Button, Direct, Drives, Sees};

/// PF3, where the rig sees it.
const ENABLE: Wire = Sees("PF3", "PF3");

/// What an armed board needs, and shows: an encoder, the gate's output, a closed stop; pulses, outputs and enable.
const ARMED: &[Wire] = &[
    Drives("PC6"),
    Drives("PC7"),
    Drives("PD15"),
    Drives("PE15"),
    Sees("PE9", "PA5"),
    Sees("PE14", "PB10"),
    ENABLE,
    Button,
];

/// Wires of the converter's inputs, and the button for its settings.
const INPUTS: &[Wire] = &[Analogue("PA3"), Analogue("PC0"), Analogue("PB1"), Button];

/// The test of ticks at one rate, in kHz, with so many PWM periods each.
macro_rules! ticks {
    ($khz:literal, $periods:literal) => {
        Test {
            name: concat!("tick-", $khz, "-khz"),
            wires: &[ARMED],
            drives: "`timing.control_period_s`; the encoder, so that every tick changes the pulses; then a device: a mass under the board's \
                     force, from PE9's pulses, and a hand that pushes",
            measures: "periods of PE9 from one change of its pulses to the next; the board's `time spacing` and `time duration`, and its records: \
                       each computed again by the simulator from what the board read",
            question: concat!("Does the tick come at ", $khz, " kHz, on time and with the right result?"),
            bound: concat!(
                "every ",
                $periods,
                " periods of 50 µs within 100 cycles of 480 MHz, none missed, each below 24,000 cycles, 60,000 ticks with the simulator's bits"
            ),
            seconds: 300,
            virtual_rig: Runs("1,000 ticks, and the bits of 1,000"),
        }
    };
}

/// All of them, from the harmless on.
pub const TESTS: [Test; 21] = [
    ticks!(1, 20),
    ticks!(2, 10),
    ticks!(4, 5),
    ticks!(5, 4),
    Test {
        name: "dead-man",
        wires: &[ARMED],
        drives: "the encoder; the probe stops the tick's timer, 100 times, armed anew each time",
        measures: "from the last change of PE9's pulses, less the 46 µs that it comes after its tick, to PE14 low",
        question: "If the tick stops, how soon are the outputs off?",
        bound: "below 2.0 ms after the last tick, 100 times",
        seconds: 600,
        virtual_rig: Runs("twice, measured to 5 µs"),
    },
    Test {
        name: "break-by-fault",
        wires: &[ARMED, &[Drives("PE6"), Back("PE6", "PB3")]],
        drives: "the bridges' fault line low, 1,000 times, armed anew each time",
        measures: "from the line low to PE14 low, both captured at 240 MHz",
        question: "If a bridge reports a fault, how soon are the outputs off?",
        bound: "below 1.27 µs, 1,000 times: the filter's 0.27 µs and 1 µs",
        seconds: 3600,
        virtual_rig: Runs("5 times, measured to 50 ns"),
    },
    Test {
        name: "break-by-stop",
        wires: &[ARMED, &[Back("PE15", "PB11")]],
        drives: "the emergency stop's first contact open, 1,000 times, armed anew each time",
        measures: "from the line low to PE14 low, both captured at 240 MHz",
        question: "If the stop's first contact opens, how soon are the outputs off?",
        bound: "below 1.27 µs, 1,000 times: the filter's 0.27 µs and 1 µs",
        seconds: 3600,
        virtual_rig: Runs("5 times, measured to 50 ns"),
    },
    Test {
        name: "amplifiers-gate",
        wires: &[ARMED],
        drives: "PD15 as a gate would that is wired to PF3 alone, to PE14 alone, that never opens, that is always open",
        measures: "what the board says, and the pulses of PE9 while PD15 is high",
        question: "Does the board notice a broken gate of the amplifiers?",
        bound: "fault 31, and no current requested unless the gate works",
        seconds: 60,
        virtual_rig: Runs("the same four broken gates"),
    },
    Test {
        name: "encoder-counts",
        wires: &[&[Drives("PC6"), Drives("PC7"), Drives("PD12"), Drives("PD13")]],
        drives: "both encoders, ten million edges each way, up to 3 MHz",
        measures: "counts that the board reports in its records",
        question: "Are all encoder edges counted, up to 3 MHz?",
        bound: "ten million edges in each direction, to one count",
        seconds: 300,
        virtual_rig: Runs("20,000 edges in each direction"),
    },
    Test {
        name: "encoder-faults",
        wires: &[ARMED, &[Drives("PC8")]],
        drives: "the encoder with a wire that is cut, an index at a wrong count, a jump",
        measures: "what the board says, and how soon PE14 is low",
        question: "Are a cut wire, a wrong index and a jump noticed?",
        bound: "faults 22, 20 and 2; or 3, if a tick comes during the jump",
        seconds: 60,
        virtual_rig: Runs("wire A, an index, a jump"),
    },
    Test {
        name: "converter-codes",
        wires: &[INPUTS],
        drives: "a slow ramp over the whole range, finer than its own 12 bits behind the resistor and the capacitor",
        measures: "codes of the board's converter that never come, in a row, in its records: those of PA3 and PC0, of PB1 there are means",
        question: "Does the converter miss codes?",
        bound: "no gap above 8 codes of 65,536",
        seconds: 900,
        virtual_rig: Runs("256 codes around a multiple of 4096"),
    },
    Test {
        name: "converter-start",
        wires: &[INPUTS, &[Drives("PE15")]],
        drives: "half of the range at the inputs; the probe stops the tick's timer, 100 times, and the board starts anew",
        measures: "the answer to `arm`, and the mean code of PA3 and PC0 in its records of 100 ms after each start",
        question: "Is the converter calibrated after each start?",
        bound: "100 starts: mean codes within 655 of the middle, and within 8 of each other",
        seconds: 900,
        virtual_rig: Runs("3 starts"),
    },
    Test {
        name: "current-sensor-ends",
        wires: &[ARMED, &[Direct("PA3")]],
        drives: "a winding and its current's sensor at PA3, 24 V over 11 at PB1 (10 kΩ to 3.3 V, 20 kΩ to ground); then the sensor goes to 3.09 V and \
                 to 0.21 V, as its amplifier does at 3.3 V, and to 3.05 V and 0.25 V",
        measures: "the fault that the armed board reports after each step",
        question: "Is a current sensor at the end of its range noticed?",
        bound: "fault 18 at 3.09 V and 0.21 V, fault 17 at 3.05 V and 0.25 V",
        seconds: 60,
        virtual_rig: Runs("as on a table"),
    },
    Test {
        name: "sample-after-edge",
        wires: &[ARMED, &[Direct("PA3")]],
        drives: "a winding and its current's sensor, as for current-sensor-ends; the sensor is at its end for 8 µs after each edge of PE9, while a probe \
                 asks for 2.27 A, 10.9 V, to and fro",
        measures: "the end of the probe, which stops at twice the current that it asks for",
        question: "Is a current ever sampled close to an edge?",
        bound: "no sample within 8 µs of an edge",
        seconds: 60,
        virtual_rig: Runs("measured to 2 µs"),
    },
    Test {
        name: "supply-behind-the-stop",
        wires: &[INPUTS, &[Drives("PE15")]],
        drives: "the supply's divider from 24 V down, as 1000 µF and 2.2 kΩ do once the second contact opens, and as without it",
        measures: "what `bringup` says of the emergency stop with either",
        question: "Does bring-up notice that the stop does not cut the supply?",
        bound: "a supply below 4.5 V within 10 s passes; a supply that does not fall is refused",
        seconds: 60,
        virtual_rig: Runs("1000 µF and 220 Ω"),
    },
    Test {
        name: "halt-while-armed",
        wires: &[ARMED],
        drives: "the probe halts the processor of an armed board, 100 times",
        measures: "from the last pulse of PE9 to PE14 low, and why the board does not arm again",
        question: "If a debugger halts an armed board, how soon are the outputs off?",
        bound: "below 50 µs, 100 times, and the board reports the halt",
        seconds: 600,
        virtual_rig: Runs("3 halts, with the debug unit modelled from the manual"),
    },
    Test {
        name: "can-frames",
        wires: &[],
        drives: "a transceiver at each board, the bus between them: the board with the image for a moteus asks, the rig answers as the controller does",
        measures: "bits of both rates and their sample points at the rig; answers that the board took, errors that either counted",
        question: "Are the CAN bits and frames right?",
        bound: "1 and 5 Mbit/s to 0.1 %, 60,000 answers, no error",
        seconds: 60,
        virtual_rig: Not("the rig's image has no CAN"),
    },
    Test {
        name: "bootloader",
        wires: &[&[ENABLE]],
        drives: "`update`, said while disarmed, with a cable at CN13; then another image by dfu-util, and the black button",
        measures: "how soon the PC finds 0483:df11, PF3 with 10 kΩ to ground meanwhile, what `status` says then",
        question: "Does `update` reach the bootloader, with the motors off?",
        bound: "found within 5 s, enable never high, the new image has the old keys and settings",
        seconds: 120,
        virtual_rig: Not("the emulated ROM has no USB"),
    },
    Test {
        name: "spi-encoders",
        wires: &[],
        drives: "an AS5047P at each SPI of the board with the image for encoders on SPI: turned by hand; its wires off one by one, its magnet away",
        measures: "chip select low until it is high again after a reading, by an oscilloscope; what `status` says, and the motors' enable",
        question: "Are encoders on SPI read, and their faults noticed?",
        bound: "5 µs per reading, faults 70 and 71, motors off within 4 ms",
        seconds: 600,
        virtual_rig: Not(
            "the rig plays no AS5047P: a slave on its SPI, with an answer ready 350 ns after chip select, is to do; 5.4 µs as calculated, and nine faults in spi_encoders.rs",
        ),
    },
    Test {
        name: "soak",
        wires: &[ARMED],
        drives: "the encoder, to and fro; the board is armed for a day (`--seconds`: for so long)",
        measures: "ticks missed or not armed, restarts, packets refused or dropped, and the longest tick",
        question: "Does the board run for a day?",
        bound: "24 h armed: no tick missed, no restart, each tick below 24,000 cycles",
        seconds: 86_400,
        virtual_rig: Runs("5 s"),
    },
    Test {
        name: "usb",
        wires: &[],
        drives: "the board with the image `usb` and a second cable from the PC at CN13, pulled and put back ten times while armed",
        measures: "what the PC finds, how soon the operator is answered, what the serial port says, ticks missed",
        question: "Do the network and the serial port by USB work?",
        bound: "both found within 5 s after each of ten plug-ins, no tick missed",
        seconds: 300,
        virtual_rig: Not("the rig plays no PC"),
    },
];
