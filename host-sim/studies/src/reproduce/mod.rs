//! What papers print, beside what comes out here and now, in two views:
//!
//! | view | shows |
//! |---|---|
//! | this module | every claim of both papers, with a verdict |
//! | [`paper`] | the experiments and the largest stable gains of the cooperation paper, as its tables have them |
//!
//! A claim of both papers has one of these verdicts:
//!
//! | verdict | when |
//! |---|---|
//! | matched | what comes out is the paper's number within a stated part of it, or does what its sentence says, wherever it was looked at |
//! | holds in part | it does in some of the places that were looked at (`found` says in how many), or for the device that is assumed here alone |
//! | not matched | it does not; where another reading of what the paper leaves open would, that reading is named, computed like the rest |
//! | circular | it comes out because what is assumed was found from the paper's own numbers |
//! | not testable | the paper gives no number, or leaves open as many values as it states |
//!
//! **An order of magnitude** is ten times or more, two are a hundred: nothing is rounded. **Readings** are the choices that
//! the cooperation paper leaves open: how the copy of the object is integrated, how late its forces are, how late the device's (`readings.rs`).

mod channel;
mod claim;
mod cooperation;
pub mod paper;
mod readings;

use cohold_core::names::Choice;
use cohold_plot::Figure;
use cohold_report::{Columns, significant};

use crate::Error;

pub use self::claim::{Claim, Verdict, of};

pub use self::cooperation::{Computed, claims as cooperation};

/// A paper that is another package's.
#[derive(Clone, Copy, Debug)]
pub struct Paper {
    /// How many steps its work has.
    pub steps: usize,
    /// Computes it; calls what it is given after each step.
    pub reproduce: fn(&(dyn Fn() + Sync)) -> Result<Reproduced, Error>,
}

/// What there is to show of a paper: tables and figures by the names of their files.
#[derive(Debug)]
pub struct Reproduced {
    /// Its claims.
    pub claims: Vec<Claim>,
    /// Its tables.
    pub tables: Vec<(&'static str, Columns)>,
    /// Its figures.
    pub figures: Vec<(&'static str, Figure)>,
}

/// The claims as a table.
pub fn columns(claims: &[Claim]) -> Columns {
    Columns::of(claims)
        .value("paper", |claim| claim.paper)
        .means("cooperation or architectures")
        .value("place", |claim| claim.place)
        .means("section, figure or equation")
        .value("claim", |claim| claim.claim.as_str())
        .means("what the paper says")
        .value("verdict", |claim| claim.verdict.name())
        .means("matched, holds in part, not matched, circular, not testable")
        .value("found", |claim| claim.found.as_str())
        .means("what was computed, in words")
        .number("off_percent", 1, |claim| claim.off.map(|off| 100.0 * off))
        .means("what was computed less the paper's number, of the paper's")
        .head("off")
        .shown_in("%", 1.0)
        .value("why", |claim| Some(claim.why.as_str()).filter(|why| !why.is_empty()))
        .means("why it is not matched or not testable; the reading that would match")
        .done()
}

/// Numbers to three digits, one after the other.
pub fn list(values: &[f64]) -> String {
    values.iter().map(|value| significant(*value, 3)).collect::<Vec<_>>().join(", ")
}

/// The smallest and the largest of these numbers.
pub fn span(values: impl Iterator<Item = f64> + Clone) -> [f64; 2] {
    [f64::min, f64::max].map(|pick| values.clone().reduce(pick).unwrap_or(f64::NAN))
}

/// How many there are of each verdict.
pub fn counts(claims: &[Claim]) -> impl Iterator<Item = (&'static str, usize)> {
    Verdict::ALL.iter().map(|verdict| (verdict.name(), claims.iter().filter(|claim| claim.verdict == *verdict).count()))
}

/// The same as a sentence.
pub fn counted(claims: &[Claim]) -> String {
    counts(claims).map(|(name, count)| format!("{count} {name}")).collect::<Vec<_>>().join(", ")
}

/// One page: the claims of each paper as a table, and the figures behind it.
pub fn page(claims: &[Claim], pictures: &[(&str, String)], experiments: &Columns) -> String {
    let mut page =
        format!("# Both papers, claim by claim\n\nComputed by `cohold paper reproduce`: {}.\n", counted(claims));
    let mut papers: Vec<&str> = claims.iter().map(|claim| claim.paper).collect();
    papers.dedup();
    for paper in papers {
        page +=
            &format!("\n## The {paper} paper\n\n| place | claim | verdict | found | why |\n|---|---|---|---|---|\n");
        for claim in claims.iter().filter(|claim| claim.paper == paper) {
            let off = claim.off.map_or_else(String::new, |off| format!(" ({:+.1} %)", 100.0 * off));
            let cell = |text: &str| text.replace('|', "\\|");
            let [place, said, found, why] = [claim.place, &claim.claim, &claim.found, &claim.why].map(cell);
            page += &format!("| {place} | {said} | **{}**{off} | {found} | {why} |\n", claim.verdict.name());
        }
    }
    page += &format!("\n## Experiments of the cooperation paper\n\n```\n{experiments}```\n\n## Figures\n");
    for (name, title) in pictures {
        page += &format!("\n![{title}]({name}.svg)\n");
    }
    page
}
