//! The netlist as its file has it, and the nets of one build. The file's head says what each table is.

use std::collections::BTreeMap;

use serde::Deserialize;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Netlist {
    /// Pins of the Nucleo.
    pub board: Board,
    /// Sorts of parts, by name.
    pub kind: BTreeMap<String, Kind>,
    /// Parts, by their designation.
    pub part: BTreeMap<String, Part>,
    /// Ways to build it, by name.
    pub build: BTreeMap<String, Build>,
    /// Wires.
    pub net: Vec<Net>,
    /// Drawings.
    pub sheet: Vec<Sheet>,
    /// What to buy.
    pub buy: Vec<Buy>,
}

/// The Nucleo.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Board {
    /// Pins of the chip that the firmware uses.
    pub pins: Vec<ChipPin>,
    /// `NAME role volts`, and where it is.
    pub others: Vec<[String; 2]>,
}

/// A pin of the chip.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChipPin {
    /// `PE9`.
    pub pin: String,
    /// Connector and pin, then the name beside it.
    pub at: String,
    /// What of the chip is at this pin.
    pub does: String,
    /// Which way.
    pub is: Is,
    /// The most that it bears, or what it drives, V.
    pub volts: Option<f64>,
    /// Inside the chip.
    pub pull: Option<Pull>,
    /// Who uses it.
    pub image: Image,
}

/// Which way a pin of the chip is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Is {
    /// Read as a level or by a timer.
    Input,
    /// Driven, push-pull.
    Output,
    /// Converted.
    Analogue,
    /// Wired on the Nucleo itself.
    Board,
}

/// A pull inside the chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Pull {
    /// Off.
    None,
    /// To 3.3 V.
    Up,
    /// To ground.
    Down,
}

/// Whose pin it is: that of the image for one or two motors, for three, of both, for a moteus, for encoders on SPI, with USB or with Ethernet, or of all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Image {
    /// One or two motors, whatever reads them.
    Two,
    /// Three motors.
    Three,
    /// Either of these.
    Both,
    /// Either of these with quadrature encoders.
    Quadrature,
    /// One or two motors with encoders on SPI.
    Spi,
    /// A motor with a controller of its own.
    Moteus,
    /// One or two motors, by USB in place of Ethernet.
    Usb,
    /// Any with Ethernet.
    Ethernet,
    /// Any.
    All,
}

impl Image {
    /// Whether what is of `self` is of that image, too.
    pub fn has(self, image: Self) -> bool {
        match self {
            Self::All => true,
            Self::Both => image != Self::Moteus,
            Self::Ethernet => image != Self::Usb,
            Self::Two => matches!(image, Self::Two | Self::Spi | Self::Usb),
            Self::Quadrature => matches!(image, Self::Two | Self::Three | Self::Usb),
            _ => self == image,
        }
    }
}

/// A sort of part.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kind {
    /// How it is drawn.
    pub symbol: Symbol,
    /// `NAME role volts`.
    pub pins: Vec<String>,
}

/// How a part is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "what each is called is what it looks like")]
pub enum Symbol {
    Box,
    Wire,
    Resistor,
    Capacitor,
    Fuse,
    Diode,
    Clamp,
    Contact,
    Button,
    Star,
}

/// A part.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// One of the kinds, or `board`.
    pub kind: String,
    /// What a sheet says of it, if more than its designation.
    pub called: Option<String>,
    /// Ohms, farads and the like.
    pub value: Option<String>,
    /// Where it is; nothing: wherever there are motors.
    pub builds: Option<Vec<String>>,
    /// Pins without a wire.
    #[serde(default)]
    pub open: Vec<String>,
}

/// A way to build it.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Build {
    /// Which image drives it.
    pub image: Image,
    /// Pins of the chip without a wire.
    pub open: Vec<String>,
}

/// A wire.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Net {
    /// What it carries.
    pub name: String,
    /// Drawn as a name at each pin.
    #[serde(default)]
    pub rail: bool,
    /// Of the wire, then what else it must be.
    pub colour: String,
    /// `PART.PIN`.
    pub pins: Vec<String>,
    /// Where it is.
    pub builds: Vec<String>,
}

/// A drawing.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Its name in docs/, without the ending.
    pub file: String,
    /// What stands above it.
    pub title: String,
    /// Which build it shows.
    pub build: String,
    /// Parts from left to right, in each column from the top.
    pub columns: Vec<Vec<String>>,
}

/// A line of the parts list.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Buy {
    /// What it is and must be.
    pub what: String,
    /// Whose, and its number.
    pub number: String,
    /// Another one that fits.
    pub second: String,
    /// For one piece, rough.
    pub euros: String,
    /// What of this line was compared with a data sheet or a shop's page, and with which.
    pub checked: String,
    /// Which parts.
    #[serde(rename = "for")]
    pub parts: Vec<String>,
}

/// What a pin is to its net, and volts: the most that it bears, or what it drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Role {
    /// Takes a level.
    In(f64),
    /// Drives one.
    Out(f64),
    /// An open drain: pulls down or lets go, and bears so much.
    Drain(f64),
    /// Takes power.
    Supply(f64),
    /// Gives power.
    Source(f64),
    /// An end of a resistor, a contact, a winding.
    Passive,
    /// The 0 V of a part.
    Ground,
    /// A socket for a made-up cable.
    Plug,
}

impl Netlist {
    /// Reads a netlist.
    ///
    /// # Errors
    /// It is no TOML, or has other tables than these.
    pub fn parse(text: &str) -> Result<Self, String> {
        toml::from_str(text).map_err(|cause| format!("netlist.toml: {cause}"))
    }

    /// Whether a build has a part.
    pub fn has(&self, build: &str, part: &str) -> bool {
        self.part.get(part).is_some_and(|part| match &part.builds {
            Some(builds) => builds.iter().any(|of| of == build),
            None => build != "bare",
        })
    }

    /// All pins of a part: name and role.
    ///
    /// # Errors
    /// Its kind is none, or a pin of it is not `NAME role volts`.
    pub fn pins(&self, part: &str) -> Result<Vec<(String, Role)>, String> {
        let of = self.part.get(part).ok_or_else(|| format!("there is no part {part}"))?;
        if of.kind == "board" {
            let wired = self.board.pins.iter().filter(|pin| pin.is != Is::Board);
            let chip = wired.map(|pin| {
                let volts = pin.volts.ok_or_else(|| format!("{} has no volts", pin.pin))?;
                Ok((pin.pin.clone(), if pin.is == Is::Output { Role::Out(volts) } else { Role::In(volts) }))
            });
            return chip.chain(self.board.others.iter().map(|[pin, _]| read(pin))).collect();
        }
        let kind = self.kind.get(&of.kind).ok_or_else(|| format!("{part}: there is no kind {}", of.kind))?;
        kind.pins.iter().map(|pin| read(pin)).collect()
    }

    /// The nets of a build. Of a rail it has what joins its own parts.
    pub fn nets(&self, build: &str) -> Vec<Net> {
        let mut nets: Vec<Net> =
            self.net.iter().filter(|net| net.builds.iter().any(|of| of == build)).cloned().collect();
        for net in nets.iter_mut().filter(|net| net.rail) {
            net.pins.retain(|pin| self.has(build, split(pin).0));
        }
        nets
    }

    /// Where on the Nucleo a pin is.
    pub fn place(&self, pin: &str) -> Option<&str> {
        let chip = self.board.pins.iter().find(|of| of.pin == pin).map(|of| of.at.as_str());
        let other = || self.board.others.iter().find(|[of, _]| of.split(' ').next() == Some(pin));
        chip.or_else(|| other().map(|[_, at]| at.as_str()))
    }

    /// What a part is on a sheet: its kind's symbol, and its words.
    pub fn drawn(&self, part: &str) -> (Symbol, String) {
        let of = &self.part[part];
        let words = match (&of.called, &of.value) {
            (Some(called), _) => called.clone(),
            (None, Some(value)) => format!("{part}, {value}"),
            (None, None) => part.to_owned(),
        };
        (self.kind.get(&of.kind).map_or(Symbol::Box, |kind| kind.symbol), words)
    }
}

/// `PART.PIN` in two.
pub fn split(pin: &str) -> (&str, &str) {
    pin.split_once('.').unwrap_or((pin, ""))
}

fn read(pin: &str) -> Result<(String, Role), String> {
    let wrong = || format!("`{pin}` is not `NAME role volts`");
    let mut words = pin.split(' ');
    let (name, role) = (words.next().ok_or_else(wrong)?, words.next().ok_or_else(wrong)?);
    let volts = words.next().map(|volts| volts.parse().map_err(|_| wrong())).transpose()?;
    let role = match (role, volts) {
        ("in", Some(volts)) => Role::In(volts),
        ("out", Some(volts)) => Role::Out(volts),
        ("drain", Some(volts)) => Role::Drain(volts),
        ("supply", Some(volts)) => Role::Supply(volts),
        ("source", Some(volts)) => Role::Source(volts),
        ("passive", None) => Role::Passive,
        ("ground", None) => Role::Ground,
        ("plug", None) => Role::Plug,
        _ => return Err(wrong()),
    };
    Ok((name.to_owned(), role))
}
