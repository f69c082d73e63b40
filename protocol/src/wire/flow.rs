//! The coordination flow: one message each packet period with all shared axes in it, so that what belongs together arrives together or
//! not at all. Every number is finite.

use crate::bytes::{Field, Reader, Writer, byte_of, emit, layout};
use crate::{error::Error, wire::Message};

layout! {
    /// What the flow says along one shared axis.
    ///
    /// The two sums run from the tick at which the sender engaged and cover every tick up to and including the flow's; they are f64 so
    /// that an f32 peer's values arrive exactly and hours of summing lose nothing. Power-domain uses position and velocity,
    /// wave-domain the rest (THEORY §2, §5); what a law does not use is 0.
    pub struct AxisFlow(32 bytes) {
        0 => position: f32, "Position of the sender's copy of the object, m.";
        4 => velocity: f32, "Velocity of the sender's copy of the object, m/s.";
        8 => wave: f32, "Wave sample u_out, √W.";
        12 => wave_integral: f64, "T_c·Σu_out since the sender engaged, √W·s.";
        20 => energy_sent: f64, "½·T_c·Σu_out² since the sender engaged, J; never falls.";
        28 => live_ticks: u32, "Ticks that the wave integral is over, of a line with a time of its own; wraps.";
    }
}

/// What holds the two copies of the shared object together along `AXES` axes (1 to 3), once each packet period, newest wins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flows<const AXES: usize> {
    /// The sender's coordination acts: its motors are armed and it is engaged with this end.
    pub engaged: bool,
    /// The sender has not heard from this end for a while and is letting go.
    pub fading: bool,
    /// The sender's newest tick, in control periods since it started; wraps after 49 days at 1 kHz.
    pub tick: u32,
    /// The packet of each shared axis.
    pub axes: [AxisFlow; AXES],
}

/// Flow of one shared axis.
pub type Flow = Flows<1>;
/// Flow of two shared axes.
pub type Flow2 = Flows<2>;
/// Flow of three shared axes.
pub type Flow3 = Flows<3>;

impl<const AXES: usize> Default for Flows<AXES> {
    fn default() -> Self {
        Self { engaged: false, fading: false, tick: 0, axes: [AxisFlow::default(); AXES] }
    }
}

impl<const AXES: usize> Flows<AXES> {
    /// Byte that names it, and what it is called.
    const NAMES: (u8, &'static str) = match AXES {
        1 => (1, "flow"),
        2 => (10, "flow of two axes"),
        _ => {
            assert!(AXES == 3, "flow is of one to three axes");
            (11, "flow of three axes")
        }
    };
    /// The byte that names the message.
    pub const KIND: u8 = Self::NAMES.0;
    /// Length of the message, bytes.
    pub const LEN: usize = 8 + AXES * AxisFlow::LEN;

    /// What it says along its first axes; nothing along those that it lacks.
    pub(crate) fn along<const FIRST: usize>(&self) -> Flows<FIRST> {
        let (axes, Self { engaged, fading, tick, .. }) = (self.axes.iter().copied(), *self);
        let mut axes = axes.chain(core::iter::repeat(AxisFlow::default()));
        Flows { engaged, fading, tick, axes: [(); FIRST].map(|()| axes.next().unwrap_or_default()) }
    }

    /// Reads the message, which must fill `bytes` exactly.
    ///
    /// # Errors
    /// A wrong length, a reserved byte that is not 0, or a number that is not finite.
    pub fn parse(bytes: &[u8]) -> Result<Self, Error> {
        Reader::exact(bytes, Self::NAMES.1, Self::LEN)?.get()
    }

    /// Writes the message to the front of `out` and gives its length, bytes.
    ///
    /// # Errors
    /// Too little room in `out`, or a number that is not finite.
    pub fn emit(&self, out: &mut [u8]) -> Result<usize, Error> {
        emit(self, Self::NAMES.1, out)
    }
}

impl<const AXES: usize> From<Flows<AXES>> for Message {
    fn from(flow: Flows<AXES>) -> Self {
        match const { Flows::<AXES>::KIND } {
            Flow::KIND => Self::Flow(flow.along()),
            Flow2::KIND => Self::Flow2(flow.along()),
            _ => Self::Flow3(flow.along()),
        }
    }
}

impl<const AXES: usize> Field for Flows<AXES> {
    const LEN: usize = Self::LEN;

    #[inline]
    fn read(reader: &mut Reader<'_>) -> Result<Self, Error> {
        reader.kind(Self::KIND)?;
        let flags: u8 = reader.get()?;
        if flags > byte_of(&[true; 2]) {
            return Err(reader.reserved());
        }
        reader.zeros(2)?;
        Ok(Self { engaged: flags & 1 != 0, fading: flags & 2 != 0, tick: reader.get()?, axes: reader.get()? })
    }

    #[inline]
    fn write(&self, writer: &mut Writer<'_>) {
        let start = writer.at();
        writer.bytes(&[Self::KIND, byte_of(&[self.engaged, self.fading])]);
        writer.zeros_to(start + 4);
        writer.put(&self.tick);
        writer.put(&self.axes);
    }
}
