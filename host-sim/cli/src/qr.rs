//! An address as a QR code, to be scanned by a phone: in the terminal as half blocks, on the operator's page as one path.
//!
//! Around it is a margin of four modules, as the standard asks for. Its error correction is the lowest level, so that its modules are
//! the largest: it is scanned from a screen, which has no dirt.

use qrcode::{Color, EcLevel, QrCode};

use crate::Failure;

/// Light modules around it.
const MARGIN: usize = 4;

/// A QR code with its margin.
#[derive(Clone, Debug)]
pub struct Code {
    /// Modules along a side.
    pub side: usize,
    dark: Vec<bool>,
}

impl Code {
    /// The code of a text.
    pub fn of(text: &str) -> Result<Self, Failure> {
        let code = QrCode::with_error_correction_level(text, EcLevel::L)
            .map_err(|cause| format!("{text} is no QR code: {cause}"))?;
        let (wide, colors) = (code.width(), code.to_colors());
        let side = wide + 2 * MARGIN;
        let mut dark = vec![false; side * side];
        for (at, _) in colors.iter().enumerate().filter(|(_, color)| **color == Color::Dark) {
            dark[(MARGIN + at / wide) * side + MARGIN + at % wide] = true;
        }
        Ok(Self { side, dark })
    }

    /// Whether a module is dark; beyond the code all are light.
    fn is_dark(&self, x: usize, y: usize) -> bool {
        self.dark.get(y * self.side + x).copied().unwrap_or(false)
    }

    /// Lines of block characters, of which each is two rows of modules; dark modules are ink.
    pub fn lines(&self) -> impl Iterator<Item = String> + '_ {
        let block = |x: usize, y: usize| match [self.is_dark(x, y), self.is_dark(x, y + 1)] {
            [true, true] => '█',
            [true, false] => '▀',
            [false, true] => '▄',
            [false, false] => ' ',
        };
        (0..self.side).step_by(2).map(move |y| (0..self.side).map(|x| block(x, y)).collect())
    }

    /// The dark modules as an SVG path, in modules: every run of a row is a rectangle.
    pub fn path(&self) -> String {
        let mut path = String::new();
        for y in 0..self.side {
            let mut x = 0;
            while x < self.side {
                let run = (x..self.side).take_while(|x| self.is_dark(*x, y)).count();
                if run > 0 {
                    path += &format!("M{x} {y}h{run}v1h-{run}z");
                }
                x += run + 1;
            }
        }
        path
    }
}

#[cfg(test)]
#[path = "../tests/inside/qr.rs"]
mod tests;
