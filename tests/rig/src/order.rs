//! What the PC tells the rig over its serial port (115200 baud, 8N1), a line each, and how the rig answers: a line that begins with `ok` or
//! `error`.
//!
//! | line | does |
//! |---|---|
//! | `who` | says who is there |
//! | `gate N` | PD15 is the bit 2·PF3 + PE14 of N: 8 is the amplifiers' gate as it should be; 12 follows PF3 alone, 10 PE14 alone, 0 never opens, 15 always |
//! | `device held\|free\|sweep COUNTS N SPAN` | the encoder stands; follows the device that the board's pulses push; goes to and fro over SPAN, by COUNTS every N periods |
//! | `pulses N TICK` | looks at N periods of PE9: how many changed, how many of these came elsewhere than TICK periods after the last |
//! | `pull stop\|fault` | opens the emergency stop's contact, or pulls the bridges' fault line, until PE14 is low; how long that took |
//! | `watch N` | says that it begins, and waits N ms for PE14 to fall; then how long after the last pulse of PE9 that was, and after the last that changed |
//! | `lines` | levels of PE14 and PF3 |
//! | `turn JOINT N up\|down` | so many edges of an encoder, as fast as the program makes them |
//! | `push N up\|down` | a hand pushes the free device with so many mN |
//! | `mark` | encoder 1 shows its index, where it is |
//! | `asked` | the largest command since this was asked last, while PD15 and PF3 were high: counts of 6000 either way |
//! | `cut JOINT A\|B`, `mend` | a wire of an encoder is off, or all are on again |
//! | `volts N` | the analogue output, of 4095 |
//! | `fall N MS` | the analogue output falls from N toward nothing as a capacitor does that has so many ms; it answers at once, and `volts` ends it |
//! | `winding` | the analogue output is the sensor of the current that PE9's pulses make in a winding while PF3 is high; `volts` or `fall` ends it. For 8 µs after each edge of PE9 it is at its upper end, as a sensor is that rides on that leg |
//! | `stop open\|closed` | the emergency stop's first contact |
//! | `button down\|up` | the board's blue button |
//!
//! Times are counts of 240 MHz. Nothing here panics, whatever comes in: the image is linked without a panic.

/// A line that takes the motors off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// PE15: the emergency stop's first contact.
    Stop,
    /// PE6: the bridges' fault line.
    Fault,
}

/// What moves the first encoder.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Moves {
    /// Nothing.
    #[default]
    Held,
    /// The board's force.
    Free,
    /// So many counts every so many periods of 50 µs, to and fro over so many.
    Sweep(u32, u32, i32),
}

/// A line to the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Who is there?
    Who,
    /// The gate's outputs, a bit for each of its inputs.
    Gate(u32),
    /// This moves the encoder.
    Device(Moves),
    /// Look at so many periods, with ticks of so many.
    Pulses(u32, u32),
    /// Pull this line.
    Pull(Line),
    /// Wait so many ms for PE14 to fall.
    Watch(u32),
    /// Levels of PE14 and PF3.
    Lines,
    /// So many edges of an encoder (0 or 1), upward or not.
    Turn(usize, u32, bool),
    /// A hand pushes with so many mN, upward or not.
    Push(u32, bool),
    /// The first encoder shows its index.
    Mark,
    /// The largest command that an amplifier was given.
    Asked,
    /// A wire of an encoder (0 or 1) is off: A or B.
    Cut(usize, bool),
    /// All wires are on.
    Mend,
    /// The analogue output, of 4095.
    Volts(u16),
    /// It falls from there toward nothing, with a time constant of so many ms.
    Fall(u16, u32),
    /// It is the sensor of a winding's current.
    Winding,
    /// The emergency stop's first contact is open.
    Stop(bool),
    /// The board's blue button is down.
    Button(bool),
}

/// A number in decimal, of nine digits at the most.
fn number(word: &[u8]) -> Option<u32> {
    if word.is_empty() || word.len() > 9 || !word.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(word.iter().fold(0_u32, |sum, digit| sum.wrapping_mul(10).wrapping_add(u32::from(*digit & 15))))
}

/// Ways of an encoder.
const DOWN_UP: [&[u8]; 2] = [b"down", b"up"];

/// Which of two words it is.
fn second(word: &[u8], words: [&[u8]; 2]) -> Option<bool> {
    words.iter().position(|known| *known == word).map(|place| place == 1)
}

impl Order {
    /// What a line says, without its end; `None` if it is no order.
    pub fn read(line: &[u8]) -> Option<Self> {
        let mut words = line.split(|byte| *byte == b' ').filter(|word| !word.is_empty());
        let mut word = || words.next().unwrap_or_default();
        let order = match (word(), word()) {
            (b"who", b"") => Self::Who,
            (b"gate", outputs) => Self::Gate(number(outputs)?),
            (b"device", b"held") => Self::Device(Moves::Held),
            (b"device", b"free") => Self::Device(Moves::Free),
            (b"device", b"sweep") => {
                Self::Device(Moves::Sweep(number(word())?, number(word())?, number(word())?.cast_signed()))
            }
            (b"pulses", periods) => Self::Pulses(number(periods)?, number(word())?),
            (b"pull", b"stop") => Self::Pull(Line::Stop),
            (b"pull", b"fault") => Self::Pull(Line::Fault),
            (b"watch", ms) => Self::Watch(number(ms)?),
            (b"lines", b"") => Self::Lines,
            (b"turn", which) => Self::Turn(joint(which)?, number(word())?, second(word(), DOWN_UP)?),
            (b"push", force) => Self::Push(number(force)?, second(word(), DOWN_UP)?),
            (b"mark", b"") => Self::Mark,
            (b"asked", b"") => Self::Asked,
            (b"cut", which) => Self::Cut(joint(which)?, second(word(), [b"A", b"B"])?),
            (b"mend", b"") => Self::Mend,
            (b"volts", share) => Self::Volts(volts(share)?),
            (b"fall", from) => Self::Fall(volts(from)?, number(word())?),
            (b"winding", b"") => Self::Winding,
            (b"stop", word) => Self::Stop(second(word, [b"closed", b"open"])?),
            (b"button", word) => Self::Button(second(word, [b"up", b"down"])?),
            _ => return None,
        };
        word().is_empty().then_some(order)
    }
}

/// What the analogue output can be.
fn volts(word: &[u8]) -> Option<u16> {
    u16::try_from(number(word)?).ok().filter(|share| *share < 4096)
}

/// An encoder, 1 or 2, from 0 on.
fn joint(word: &[u8]) -> Option<usize> {
    second(word, [b"1", b"2"]).map(usize::from)
}

/// The longest line, either way.
pub const LONGEST: usize = 96;

/// A line that is made byte by byte; what is beyond [`LONGEST`] is left out.
#[derive(Clone, Copy, Debug)]
pub struct Text {
    bytes: [u8; LONGEST],
    length: usize,
}

impl Default for Text {
    fn default() -> Self {
        Self { bytes: [0; LONGEST], length: 0 }
    }
}

impl Text {
    /// A line that begins like this.
    pub fn of(word: &str) -> Self {
        Self::default().and(word)
    }

    /// One byte more.
    pub fn push(&mut self, byte: u8) {
        if let Some(place) = self.bytes.get_mut(self.length) {
            *place = byte;
            self.length += 1;
        }
    }

    /// A word more.
    #[must_use]
    pub fn and(mut self, word: &str) -> Self {
        word.bytes().for_each(|byte| self.push(byte));
        self
    }

    /// A space and a number more.
    #[must_use]
    pub fn number(mut self, number: u32) -> Self {
        self.push(b' ');
        let mut unit = 1_000_000_000;
        let mut begun = false;
        while unit > 0 {
            let digit = (number / unit % 10) as u8;
            begun |= digit > 0 || unit == 1;
            if begun {
                self.push(b'0' + digit);
            }
            unit /= 10;
        }
        self
    }

    /// What is in it.
    pub fn bytes(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

#[cfg(test)]
#[path = "../tests/inside/order.rs"]
mod tests;
