//! What the PC tells the rig over its serial port (115200 baud, 8N1), a line each, and how the rig answers: a line that begins with `ok` or
//! `error`.
//!
//! | line | does |
//! |---|---|
//! | `who` | says who is there |
//! | `gate both\|enable\|timer\|never\|always` | PD15 follows PF3 and PE14 as the amplifiers' gate should, or as one does that is wired wrong |
//! | `device held\|free\|sweep N\|shake N` | the encoder stands; follows the device that the board's pulses push; goes to and fro, a count every N periods; jumps by N counts every ms, to and fro |
//! | `pulses N` | looks at N periods of PE9: how many changed, how many of these came elsewhere than 20 periods after the last |
//! | `pull stop\|fault` | opens the emergency stop's contact, or pulls the bridges' fault line, until PE14 is low; how long that took |
//! | `watch N` | says that it begins, and waits N ms for PE14 to fall; then how long after the last pulse of PE9 that was, and after the last that changed |
//! | `lines` | levels of PE14 and PF3 |
//! | `turn JOINT N up\|down` | so many edges of an encoder, as fast as the program makes them |
//! | `push N up\|down` | a hand pushes the free device with so many mN |
//! | `mark` | encoder 1 shows its index, where it is |
//! | `asked` | the largest command since this was asked last, while PD15 and PF3 were high: counts of 6000 either way |
//! | `cut JOINT A\|B`, `mend` | a wire of an encoder is off, or all are on again |
//! | `volts N` | the analogue output, of 4095 |
//! | `ramp FROM TO MS` | the analogue output goes from one to the other, a step every so many ms; the answer comes at the end |
//! | `fall N MS` | the analogue output falls from N toward nothing as a capacitor does that has so many ms; it answers at once, and `volts` or `ramp` ends it |
//! | `stop open\|closed` | the emergency stop's first contact |
//! | `button down\|up` | the board's blue button |
//!
//! Times are counts of 240 MHz. Nothing here panics, whatever comes in: the image is linked without a panic.

/// How the gate between PF3, PE14 and the amplifiers is wired, as PD15 shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gate {
    /// An AND of both.
    Both,
    /// PF3 alone.
    Enable,
    /// PE14 alone.
    Timer,
    /// It never opens.
    Never,
    /// It is always open.
    Always,
}

impl Gate {
    /// The level of its output for these inputs.
    pub fn passes(self, enable: bool, timer: bool) -> bool {
        match self {
            Self::Both => enable && timer,
            Self::Enable => enable,
            Self::Timer => timer,
            Self::Never => false,
            Self::Always => true,
        }
    }
}

/// A line that takes the motors off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Line {
    /// PE15: the emergency stop's first contact.
    Stop,
    /// PE6: the bridges' fault line.
    Fault,
}

/// What moves the first encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moves {
    /// Nothing.
    Held,
    /// The board's force.
    Free,
    /// A count every so many periods of 50 µs, to and fro.
    Sweep(u32),
    /// So many counts up in one ms and down in the next.
    Shake(u32),
}

/// A line to the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Who is there?
    Who,
    /// The gate is wired like this.
    Gate(Gate),
    /// This moves the encoder.
    Device(Moves),
    /// Look at so many periods.
    Pulses(u32),
    /// Pull this line.
    Pull(Line),
    /// Wait so many ms for PE14 to fall.
    Watch(u32),
    /// Levels of PE14 and PF3.
    Lines,
    /// So many edges of an encoder (0 or 1), upward or not.
    Turn(u8, u32, bool),
    /// A hand pushes with so many mN, upward or not.
    Push(u32, bool),
    /// The first encoder shows its index.
    Mark,
    /// The largest command that an amplifier was given.
    Asked,
    /// A wire of an encoder (0 or 1) is off: A or B.
    Cut(u8, bool),
    /// All wires are on.
    Mend,
    /// The analogue output, of 4095.
    Volts(u16),
    /// The analogue output goes from one to the other, a step every so many ms.
    Ramp(u16, u16, u32),
    /// It falls from there toward nothing, with a time constant of so many ms.
    Fall(u16, u32),
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

/// The joint that is called 1 or 2.
fn joint(word: &[u8]) -> Option<u8> {
    match word {
        b"1" => Some(0),
        b"2" => Some(1),
        _ => None,
    }
}

impl Order {
    /// What a line says, without its end; `None` if it is no order.
    pub fn read(line: &[u8]) -> Option<Self> {
        let mut words = line.split(|byte| *byte == b' ').filter(|word| !word.is_empty());
        let mut word = || words.next().unwrap_or_default();
        let order = match (word(), word()) {
            (b"who", b"") => Self::Who,
            (b"gate", b"both") => Self::Gate(Gate::Both),
            (b"gate", b"enable") => Self::Gate(Gate::Enable),
            (b"gate", b"timer") => Self::Gate(Gate::Timer),
            (b"gate", b"never") => Self::Gate(Gate::Never),
            (b"gate", b"always") => Self::Gate(Gate::Always),
            (b"device", b"held") => Self::Device(Moves::Held),
            (b"device", b"free") => Self::Device(Moves::Free),
            (b"device", b"sweep") => Self::Device(Moves::Sweep(number(word())?)),
            (b"device", b"shake") => Self::Device(Moves::Shake(number(word())?)),
            (b"pulses", periods) => Self::Pulses(number(periods)?),
            (b"pull", b"stop") => Self::Pull(Line::Stop),
            (b"pull", b"fault") => Self::Pull(Line::Fault),
            (b"watch", ms) => Self::Watch(number(ms)?),
            (b"lines", b"") => Self::Lines,
            (b"turn", which) => {
                let (which, edges) = (joint(which)?, number(word())?);
                Self::Turn(which, edges, upward(word())?)
            }
            (b"push", force) => {
                let force = number(force)?;
                Self::Push(force, upward(word())?)
            }
            (b"mark", b"") => Self::Mark,
            (b"asked", b"") => Self::Asked,
            (b"cut", which) => Self::Cut(joint(which)?, second(word())?),
            (b"mend", b"") => Self::Mend,
            (b"volts", share) => Self::Volts(volts(share)?),
            (b"ramp", from) => {
                let (from, to) = (volts(from)?, volts(word())?);
                Self::Ramp(from, to, number(word())?)
            }
            (b"fall", from) => {
                let from = volts(from)?;
                Self::Fall(from, number(word())?)
            }
            (b"stop", b"open") => Self::Stop(true),
            (b"stop", b"closed") => Self::Stop(false),
            (b"button", b"down") => Self::Button(true),
            (b"button", b"up") => Self::Button(false),
            _ => return None,
        };
        word().is_empty().then_some(order)
    }
}

/// What the analogue output can be.
fn volts(word: &[u8]) -> Option<u16> {
    u16::try_from(number(word)?).ok().filter(|share| *share < 4096)
}

fn upward(word: &[u8]) -> Option<bool> {
    match word {
        b"up" => Some(true),
        b"down" => Some(false),
        _ => None,
    }
}

fn second(word: &[u8]) -> Option<bool> {
    match word {
        b"A" => Some(false),
        b"B" => Some(true),
        _ => None,
    }
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
