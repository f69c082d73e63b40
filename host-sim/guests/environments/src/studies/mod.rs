//! What the architectures paper claims, and its choice of an architecture, computed: [`PAPER`] is what `paper reproduce` adds.

pub mod architectures;
mod claims;
mod systems;

use cohold_core::names::Choice as _;
use cohold_studies::Error;
use cohold_studies::reproduce::{Paper, Reproduced};

use self::architectures::{Architecture, DELAYS_MS, columns, picture, rows};

/// The architectures paper, for `paper reproduce`.
pub const PAPER: Paper = Paper { steps: Architecture::ALL.len() * DELAYS_MS.len(), reproduce: reproduced };

fn reproduced(step: &(dyn Fn() + Sync)) -> Result<Reproduced, Error> {
    let rows = rows(&step)?;
    Ok(Reproduced {
        claims: claims::claims(&rows)?,
        tables: vec![("reproduce-architectures", columns(&rows))],
        figures: vec![("architectures", picture::figure(&rows))],
    })
}

impl From<crate::Error> for Error {
    fn from(error: crate::Error) -> Self {
        Self::Refused(error.to_string())
    }
}
