//! The laws of other papers ([`cohold_laws`]) beside those of core: [`laws`] are what scenes may name, and [`prove`] proves that forces stay
//! within their limits.
#![forbid(unsafe_code)]

use std::sync::LazyLock;

use cohold_core::law::Law;
use cohold_core::num::Scalar;
use cohold_core::peer::Peer;
use cohold_laws::OtherLaw;
use cohold_proof::{Number, Proved};
use cohold_sim::{Family, Laws};

struct Others;

impl Family for Others {
    type Of<S: Scalar> = OtherLaw<S>;
}

/// Adds these laws to others, as the program's own.
pub fn add(laws: Laws) -> Laws {
    laws.with::<Others>().as_own()
}

/// The laws of core and those of other papers.
pub fn laws() -> Laws {
    static LAWS: LazyLock<Laws> = LazyLock::new(|| add(Laws::built_in()));
    *LAWS
}

/// Proves the claims of [`cohold_proof`] for a law of another paper, by its name. It is not generic, so that the proofs are compiled here.
pub fn prove(name: &str) -> Option<(&'static str, Proved)> {
    let law = OtherLaw::<Number>::LAWS.iter().find(|law| law.name == name)?;
    Some((law.name, cohold_proof::prove::<OtherLaw<Number>>(law, Peer::tick)))
}
