//! An address as a QR code, to be scanned by a phone: in the terminal as half blocks, on the operator's page as one path.
//!
//! Around it is a margin of four modules, as the standard asks for. Its error correction is the lowest level, so that its modules are
//! the largest: it is scanned from a screen, which has no dirt.

use cohold_cli::Failure;
use qrcode::render::unicode::Dense1x2;
use qrcode::{Color, EcLevel, QrCode};

/// Light modules around it.
const MARGIN: usize = 4;

/// A QR code with its margin.
#[derive(Clone)]
pub(crate) struct Code {
    code: QrCode,
    /// Modules along a side.
    pub(crate) side: usize,
}

impl Code {
    /// The code of a text.
    pub(crate) fn of(text: &str) -> Result<Self, Failure> {
        let code = QrCode::with_error_correction_level(text, EcLevel::L)
            .map_err(|cause| format!("{text} is no QR code: {cause}"))?;
        Ok(Self { side: code.width() + 2 * MARGIN, code })
    }

    /// Whether a module is dark; around the code all are light.
    fn is_dark(&self, x: usize, y: usize) -> bool {
        let inside = MARGIN..self.side - MARGIN;
        inside.contains(&x) && inside.contains(&y) && self.code[(x - MARGIN, y - MARGIN)] == Color::Dark
    }

    /// Lines of block characters, of which each is two rows of modules; dark modules are ink.
    pub(crate) fn lines(&self) -> Vec<String> {
        self.code.render::<Dense1x2>().build().lines().map(str::to_owned).collect()
    }

    /// The dark modules as an SVG path, in modules: every run of a row is a rectangle.
    pub(crate) fn path(&self) -> String {
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
