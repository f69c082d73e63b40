//! What the papers of the laws say, beside what the laws do here: [`NUMBERS`], the only place that is written by hand, a row a number.
//!
//! | module | what |
//! |---|---|
//! | [`measure`] | the measurement behind each number |
//!
//! A number is **printed** in the paper, at the place that the row names, or it is **algebra of ours**: what the law's equation gives at the values of the scene. The first says
//! that the paper's result comes out; the second only that what is built does what its equation says, and no author ever measured it. Most of these papers are
//! not to be had in public text, so that most rows are of the second kind. Further than 5 % off needs a reason, in the row.

mod command;
pub(crate) mod measure;

use cohold_cli::columns::TableKind;
use cohold_core::names::Choice;
use cohold_report::Columns;
use rayon::prelude::*;

pub(crate) use self::command::Papers;
use self::measure as of;
use cohold_studies::Error;

cohold_sim::choices! {
    /// Where the number beside which ours is put comes from.
    ClaimSource {
        "printed" => Printed, "It is in the paper's text or figure.";
        "algebra of ours" => Algebra, "We worked it out from the law's equation, at the values of the scene.";
    }
}

/// A number of a paper, and how it is measured here.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Number {
    /// The law whose paper it is.
    pub(crate) law: &'static str,
    /// The paper that says it.
    pub(crate) paper: &'static str,
    /// Section, figure or equation.
    pub(crate) place: &'static str,
    /// The quantity that the number measures.
    pub(crate) what: &'static str,
    /// Its unit; nothing for a share.
    pub(crate) unit: &'static str,
    /// Whether the paper prints the number, or it is algebra of ours.
    pub(crate) says: ClaimSource,
    theirs: fn() -> f64,
    ours: fn() -> Result<f64, Error>,
    /// Why it is further off than 5 %; nothing where it is not.
    pub(crate) why: &'static str,
}

/// A number and what came of it.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// The number that was compared.
    pub(crate) number: Number,
    /// What the paper says.
    pub(crate) theirs: f64,
    /// The value measured here, in the number's unit.
    pub(crate) ours: f64,
}

impl Row {
    /// How far off, relative to the paper.
    pub(crate) fn off(&self) -> f64 {
        self.ours / self.theirs - 1.0
    }
}

const COOPERATION: &str = "Rakhsha & Constantinescu 2012";

use ClaimSource::{Algebra, Printed};

/// Every number of the papers that is compared.
#[rustfmt::skip]
pub(crate) const NUMBERS: &[Number] = &[
    Number { law: "power", paper: COOPERATION, place: "§5.2, Fig. 9", what: "mean position discrepancy at 310 N/m", unit: "mm", says: Printed,
        theirs: || 3.5, ours: || of::discrepancy_mm("power"),
        why: "it is F_T/K_T in any model, and 1 N over 310 N/m is 3.23 mm; 3.5 mm are a mean push of 1.09 N" },
    Number { law: "power", paper: COOPERATION, place: "§5.1, Fig. 6", what: "largest gain, 16 ms round trip", unit: "N/m", says: Printed,
        theirs: || 310.0, ours: || of::boundary_n_per_m("power", 310.0),
        why: "an experiment's largest stable gain lies inside the region; what the paper leaves open moves its boundary (`cohold paper reproduce`)" },
    Number { law: "wave", paper: COOPERATION, place: "§5.2, Fig. 9", what: "mean position discrepancy at 1590 N/m", unit: "mm", says: Printed,
        theirs: || 0.644, ours: || of::discrepancy_mm("wave"), why: "" },
    Number { law: "wave", paper: COOPERATION, place: "§5.1, Fig. 6", what: "largest gain, 16 ms round trip", unit: "N/m", says: Printed,
        theirs: || 1590.0, ours: || of::boundary_n_per_m("wave", 1590.0), why: "" },
    Number { law: "passive-wave", paper: COOPERATION, place: "§5.2, Fig. 9", what: "mean position discrepancy at 10620 N/m", unit: "mm", says: Printed,
        theirs: || 0.099, ours: || of::discrepancy_mm("passive-wave"), why: "" },
    Number { law: "passive-wave", paper: COOPERATION, place: "§5.1, Fig. 6", what: "largest gain, 16 ms round trip", unit: "N/m", says: Printed,
        theirs: || 10620.0, ours: || of::boundary_n_per_m("passive-wave", 10620.0), why: "" },
    Number { law: "passive-mean", paper: "Niemeyer & Slotine 1991", place: "a line's inertia b·T", what: "mass of both copies and a line of 16 ms", unit: "kg", says: Algebra,
        theirs: || 2.0 * of::MASS_KG + of::IMPEDANCE * of::LINE_S, ours: || of::mass_kg("passive-mean"), why: "" },
    Number { law: "self-timed", paper: "docs/reference/theory.md, section 8", place: "a line of constant delay in its own time", what: "apart under 1 N: 2F/K_T + F·T/b, T = (mass − 2m_O)/b", unit: "mm", says: Algebra,
        theirs: || of::distance_by_its_mass_mm("self-timed").unwrap_or(f64::NAN), ours: || of::distance_mm("self-timed"), why: "" },
    Number { law: "set-position", paper: "Lee & Huang 2010", place: "ΔP ≤ E of the set position", what: "first set position with E = 20 mJ: √(2E/K)", unit: "mm", says: Algebra,
        theirs: || 1e3 * (2.0 * of::TANK_J / 1000.0_f64).sqrt(), ours: of::first_set_position_mm, why: "" },
    Number { law: "passive-spring", paper: "docs/reference/theory.md, section 12", place: "ΔV ≤ W of the spring's middle", what: "force when 4 mJ are known to be absorbed: 2√(W·K)", unit: "N", says: Algebra,
        theirs: || 2.0 * (4e-3 * 1000.0_f64).sqrt(), ours: of::force_of_what_was_absorbed_n, why: "" },
    Number { law: "two-layer", paper: "Franken et al. 2011", place: "simple energy transfer protocol, share β", what: "level of two tanks and the line, 20 ticks each way: E/(2 + 2βd)", unit: "mJ", says: Algebra,
        theirs: || 40.0 / (2.0 + 2.0 * 0.01 * 20.0), ours: of::tank_level_mj, why: "" },
    Number { law: "wave-integral", paper: "Niemeyer & Slotine 2004", place: "a line's stiffness b/T", what: "apart under 1 N: 2F/K_T + F·T/b, a line of 16 ms", unit: "mm", says: Algebra,
        theirs: || 1e3 * (2.0 / 1e4 + of::LINE_S / of::IMPEDANCE), ours: || of::distance_mm("wave-integral"), why: "" },
    Number { law: "wave-compensator", paper: "Ye & Liu 2009", place: "bias b·(ẋ_r − ẋ_d), low-passed at λ", what: "bias of the force left after 1/λ, of b·ẋ_r", unit: "", says: Algebra,
        theirs: || (-1.0_f64).exp(), ours: of::bias_left, why: "" },
    Number { law: "four-channel", paper: "Lawrence 1993", place: "transparency-optimised: Z_t = Z_e", what: "stiffness felt of the far hand's contact, without delay", unit: "N/m", says: Algebra,
        theirs: || 500.0, ours: || of::stiffness_felt_n_per_m(&["four_channel.remote_force=1"]), why: "" },
    Number { law: "p-plus-d", paper: "Lee & Spong 2006", place: "dissipation K_d ≥ K_p·T, in motion", what: "drag of each of two who push alike, by positions 12 ms old: B + K·T", unit: "N·s/m", says: Algebra,
        theirs: || 30.0 + 310.0 * of::POSITIONS_S, ours: of::drag_of_a_common_push, why: "" },
    Number { law: "average-position", paper: "Rakhsha & Constantinescu, Average-Position Coordination", place: "effective gain K_T instead of N·K_T", what: "ω² of the copies' swing, power-domain over average, N = 2", unit: "", says: Algebra,
        theirs: || 2.0, ours: of::gain_of_the_others_over_the_mean, why: "" },
    Number { law: "remote-dynamic-proxy", paper: "Li & Constantinescu 2010", place: "proxy K_p behind the coupling K_T", what: "apart under 1 N: F/K_T + F/K_p", unit: "mm", says: Algebra,
        theirs: || 1e3 * (1.0 / 1590.0 + 1.0 / 310.0), ours: || of::distance_mm("remote-dynamic-proxy"), why: "" },
    Number { law: "fractal-impedance", paper: "Tiseo et al. 2020, arXiv 2011.00390", place: "eq. 1, divergence and convergence", what: "what a way there and back keeps, of ½K·X²", unit: "", says: Algebra,
        theirs: || 1.0, ours: of::kept_of_a_way_there_and_back, why: "" },
    Number { law: "deadband", paper: "Hirche, Hinterseer, Steinbach & Buss 2007", place: "Weber's law, threshold k·|ẋ|", what: "packets for a speed that grows tenfold, k = 0.1: ln 10/ln 1.1", unit: "", says: Algebra,
        theirs: || 10.0_f64.ln() / 1.1_f64.ln(), ours: of::packets_of_a_ramp, why: "" },
    Number { law: "deadband", paper: "Hinterseer, Hirche, Chaudhuri, Steinbach & Buss 2008", place: "abstract, up to 90 %", what: "packets saved of 1000 /s, a hand that pushes 4 N to and fro once a second", unit: "%", says: Printed,
        theirs: || 90.0, ours: of::packets_saved_percent, why: "" },
    Number { law: "passive-deadband", paper: "Hirche, Hinterseer, Steinbach & Buss 2007", place: "modified hold, ẋ* − Δ·sign(F)", what: "velocity that is held over the one that was sent, k = 0.1", unit: "", says: Algebra,
        theirs: || 0.9, ours: of::velocity_held, why: "" },
    Number { law: "passivity-observer", paper: "Hannaford & Ryu 2002", place: "observer and controller of one port", what: "largest force with 0.4 mJ observed: √(4κW/T_c)", unit: "N", says: Algebra,
        theirs: || (4.0 * 2.5 * 4e-4 / 1e-3_f64).sqrt(), ours: of::gated_force_n, why: "" },
    Number { law: "model-mediated", paper: "Mitra & Niemeyer 2008", place: "the model becomes the environment", what: "stiffness learned of a hand of 600 N/m", unit: "N/m", says: Algebra,
        theirs: || 600.0, ours: of::stiffness_learned_n_per_m, why: "" },
    Number { law: "none", paper: "Minsky, Ouh-young, Steele, Brooks & Behensky 1990", place: "B/(K·T) > 1/2", what: "b/(K·T) at the first unstable wall, a device of 1 kg", unit: "", says: Printed,
        theirs: || 0.5, ours: || of::wall(0.0), why: "" },
    Number { law: "none", paper: "Gil, Sánchez, Hulin, Preusche & Hirzinger 2009", place: "K < b/(T/2 + t_d)", what: "b/(K·T) with a tick of computing", unit: "", says: Algebra,
        theirs: || 1.5, ours: || of::wall(1.0), why: "" },
];

/// All of it, in the order of the table.
///
/// # Errors
/// Settings that no peer accepts.
pub(crate) fn rows() -> Result<Vec<Row>, Error> {
    let row = |number: &Number| Ok(Row { number: *number, theirs: (number.theirs)(), ours: (number.ours)()? });
    NUMBERS.par_iter().map(row).collect()
}

/// Declares the columns of the rows.
pub(crate) fn columns(rows: &[Row]) -> Columns {
    Columns::of(rows)
        .value("law", |row| row.number.law)
        .means("what coordination.comm calls it")
        .value("paper", |row| row.number.paper)
        .means("which paper")
        .value("place", |row| row.number.place)
        .means("section, figure or equation")
        .value("what", |row| row.number.what)
        .means("what the number is of")
        .value("says", |row| row.number.says.name())
        .means("printed: the number stands in the paper, at that place; algebra of ours: what the law's equation gives at the values of the scene")
        .number("theirs", 4, |row| row.theirs)
        .means("what the paper prints, or its equation gives")
        .number("ours", 4, |row| row.ours)
        .means("what was measured here")
        .value("unit", |row| Some(row.number.unit).filter(|unit| !unit.is_empty()))
        .means("unit of both")
        .number("off", 1, |row| 100.0 * row.off())
        .means("difference over the paper's, %")
        .value("why", |row| Some(row.number.why).filter(|why| !why.is_empty()))
        .means("why it is more than 5 % off")
        .done()
}

/// Its kind of table.
pub(crate) fn tables() -> Vec<TableKind> {
    vec![TableKind::new("published", "`paper published --json`", "a number of a law's paper", columns(&[]))]
}

#[cfg(test)]
#[path = "../tests/inside/published.rs"]
mod tests;
