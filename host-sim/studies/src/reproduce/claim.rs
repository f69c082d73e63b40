//! A claim of a paper, and the verdict on it.

use cohold_report::significant;

use crate::Error;

cohold_sim::choices! {
    /// What is to be said of a claim.
    Verdict {
        "matched" => Matched, "What was computed is what the paper says.";
        "holds in part" => InPart, "It is so in some places, or under an assumption.";
        "not matched" => NotMatched, "It is not what the paper says.";
        "circular" => Circular, "It matches, but shows nothing.";
        "not testable" => NotTestable, "The paper does not say enough.";
    }
}

/// A claim of a paper and what came of it.
#[derive(Clone, Debug)]
pub struct Claim {
    pub(super) paper: &'static str,
    /// Section, figure or equation.
    pub(super) place: &'static str,
    pub(super) claim: String,
    /// What was computed, in words.
    pub(super) found: String,
    /// How far the paper's number is from it, relative to the paper's; of a claim with one number.
    pub(super) off: Option<f64>,
    pub(super) verdict: Verdict,
    /// Why it is not matched or not testable; the reading that would match.
    pub(super) why: String,
}

impl Claim {
    /// One number of the paper, matched if what is computed is within this part of it.
    pub fn number(place: &'static str, claim: &str, (papers, computed, unit): (f64, f64, &str), within: f64) -> Self {
        let off = computed / papers - 1.0;
        let found = format!("{} {unit}, the paper's {papers} ± {:.0} %", significant(computed, 4), 100.0 * within);
        Self { off: Some(off), ..Self::holds(place, claim, off.abs() <= within, found) }
    }

    /// A sentence that is true of what is computed, or is not.
    pub fn holds(place: &'static str, claim: &str, holds: bool, found: String) -> Self {
        let verdict = if holds { Verdict::Matched } else { Verdict::NotMatched };
        Self { paper: "", place, claim: claim.to_owned(), found, off: None, verdict, why: String::new() }
    }

    /// A sentence that is true in so many of the places that were looked at; `found` says of how many.
    pub fn in_places(place: &'static str, claim: &str, holding: usize, of: usize, found: String) -> Self {
        let whole = Self::holds(place, claim, holding == of, found);
        if holding > 0 && holding < of { Self { verdict: Verdict::InPart, ..whole } } else { whole }
    }

    /// What no computation can decide.
    pub fn not_testable(place: &'static str, claim: &str, found: String, why: &str) -> Self {
        let open = Self::holds(place, claim, false, found);
        Self { verdict: Verdict::NotTestable, why: why.to_owned(), ..open }
    }

    /// Matched by what was found from the same numbers, it shows nothing.
    pub fn circular(self, why: &str) -> Self {
        self.turned(Verdict::Matched, Verdict::Circular, why.to_owned())
    }

    /// Matched only for what was assumed where the paper says nothing.
    pub fn assumed(self, why: String) -> Self {
        self.turned(Verdict::Matched, Verdict::InPart, why)
    }

    /// Not matched for what was assumed where the paper says nothing, but for something else that may be assumed.
    pub fn reached(self, why: String) -> Self {
        let why = format!("{}; {why}", self.why);
        self.turned(Verdict::NotMatched, Verdict::InPart, why)
    }

    /// Another verdict, and why, where it is `from` now.
    fn turned(self, from: Verdict, to: Verdict, why: String) -> Self {
        if self.verdict == from { Self { verdict: to, why, ..self } } else { self }
    }

    /// Why, where it is not matched, or not everywhere; for what takes long to find.
    pub fn unless(self, why: impl FnOnce() -> Result<String, Error>) -> Result<Self, Error> {
        if self.lacks_why() { Ok(self.because(why()?)) } else { Ok(self) }
    }

    /// Why, where it is not matched, or not everywhere.
    pub fn because(mut self, why: impl Into<String>) -> Self {
        if self.lacks_why() {
            self.why = why.into();
        }
        self
    }

    fn lacks_why(&self) -> bool {
        matches!(self.verdict, Verdict::NotMatched | Verdict::InPart) && self.why.is_empty()
    }

    /// A remark on one that is matched.
    pub fn but(mut self, remark: impl Into<String>) -> Self {
        if self.verdict == Verdict::Matched {
            self.why = remark.into();
        }
        self
    }
}

/// The claims of one paper, section by section.
pub fn of(paper: &'static str, mut claims: Vec<Claim>) -> Vec<Claim> {
    claims.sort_by_key(|claim| claim.place.split(',').next());
    claims.into_iter().map(|claim| Claim { paper, ..claim }).collect()
}

#[cfg(test)]
#[path = "../../tests/inside/reproduce.rs"]
mod tests;
