//! The bench as a page of the documentation: docs/laws.md, whole but for what other commands write between lines of their own, which is
//! kept as it is found.

use cohold_core::settings::Key;
use cohold_io::Most;
use cohold_sim::run::Verdict;

use super::tables::parts;
use super::{LADDER, PACKET_BYTES, Row};
use crate::Error;
use crate::bench::page::BENCH;

/// Between these lines of the page stands what `cohold stability prove --page` writes.
pub const PROOFS: [&str; 2] = ["<!-- proofs begin -->", "<!-- proofs end -->"];

/// What stands there at first.
const NO_PROOFS: &str = "No law is proved here yet.";

/// Between these stands what `cargo xtask readme --page docs/laws.md` writes: numbers of the laws' papers.
pub const PAPERS: [&str; 2] = ["<!-- papers begin -->", "<!-- papers end -->"];

/// What stands there at first: what is to be written.
const NO_PAPERS: &str = "<!-- table of cohold paper published -->";

/// What stands between the bench's lines at first.
const NO_BENCH: &str = "No bench was run yet.";

/// How the page calls its picture.
pub const PICTURE: &str = "laws-impedance.png";
/// The longest file of such a page.
pub const MOST: Most = Most::new(1 << 22, "a page");

/// The page, from the bench in the campaign's scene and with a packet a tick; of the `old` page the sections that others write.
pub fn page(rows: &[Row], each_tick: &[Row], old: &str) -> String {
    let networks = rows.first().map_or(0, |row| row.cells.len());
    let [first, felt, judged] = parts(rows);
    let [fast, ..] = parts(each_tick);
    let sections: String = rows.iter().map(section).collect();
    let proofs = between(old, PROOFS).filter(|proofs| !proofs.is_empty()).unwrap_or(NO_PROOFS);
    let papers = between(old, PAPERS).filter(|papers| !papers.is_empty()).unwrap_or(NO_PAPERS);
    let bench = between(old, BENCH).filter(|bench| !bench.is_empty()).unwrap_or(NO_BENCH);
    let ([begin, end], [first_paper, last_paper], [first_bench, last_bench]) = (PROOFS, PAPERS, BENCH);
    let ladder = LADDER.map(|setting| format!("`{setting}`")).join(", ");
    format!(
        "# Coordination laws beside each other\n\n\
         Which law is nearest, for how much drag: the bench. What each promises, keeps and costs at the gains that it declares: [below](#at-the-gains-that-laws-declare). Do not edit\n\
         this page by hand. A law is one file in `core/src/law/` and one line in its list, or a crate of its own ([example](../examples/outside-law)).\n\n\
         ## Fronts\n\n{first_bench}\n{bench}\n{last_bench}\n\n\
         ## At the gains that laws declare\n\n\
         Written by `cohold study laws all --page docs/laws.md`. **One scene for all**: two users push 1 N toward each other, one adds 0.25 sin 3t N (the cooperation paper's\n\
         §5.2); m_O = 0.3 kg, K_LC = 1000 N/m, B_LC = 2 N·s/m, 8 ms one way, a packet every 8 ms; one solve a tick (`object.integrator = \"midpoint\"`, `coordination.decode =\n\
         \"implicit\"`, no object delay); in silence every peer lets go as late ({ladder}), whatever its law declares. Each law\n\
         has the gains that it declares, in the column K_T and below; nothing is tuned, so the table ranks no law: it says what holds where. {networks} networks, 20 seeds wherever a\n\
         network draws random numbers, 20 s each; a network counts for a law only with what its worst seed does. Means are over the networks on which the law is stable: of a law that is\n\
         stable on few they are of the easy ones. [What the columns mean](data.md#laws); [what stable, apart and NO mean](networks.md).\n\n\
         ```text\n{first}```\n\n\
         The same with a packet every tick (`--set timing.ticks_per_packet=1 --set network.one_way_delay_packets=8`):\n\n```text\n{fast}```\n\n\
         ## What a hand feels, and what it costs\n\n\
         Z-width: the impedance with the far hand holding its device over that with it off, 0.5 to 2 Hz, in dB; lacks: damping that the device would need for what is felt to be passive\n\
         from 0.5 to 50 Hz. A packet has {PACKET_BYTES} bytes (sealed, UDP, IPv4). Instructions are of a tick in f32 on a Cortex-M7 (QEMU;\n\
         `cargo xtask count`); `-` was not counted.\n\n```text\n{felt}```\n\n\
         <img src=\"{PICTURE}\" width=\"500\" alt=\"Impedance that a hand feels, law by law\">\n\n\
         ## Stability region\n\n\
         First unstable K_T with both hands on, one and none, and first unstable K_LC in the worst mode, by the analyser, from 0 to 20,000 N/m (20000: none). Nothing is said of a law that is not\n\
         linear. Every crossing is in the files (`--out`).\n\n```text\n{judged}```\n\n\
         ## The papers' own numbers\n\n{first_paper}\n{papers}\n{last_paper}\n\n\
         ## Proofs\n\n{begin}\n{proofs}\n{end}\n\n\
         ## Law by law\n{sections}"
    )
}

/// What a page has between two lines of its own.
pub fn between<'a>(page: &'a str, [begin, end]: [&str; 2]) -> Option<&'a str> {
    page.split_once(begin).and_then(|(_, rest)| rest.split_once(end)).map(|(found, _)| found.trim())
}

/// A page with this text between two lines of its own.
///
/// # Errors
/// A page without these lines.
pub fn with(page: &str, [begin, end]: [&str; 2], text: &str) -> Result<String, Error> {
    let parts = page.split_once(begin).and_then(|(before, rest)| Some((before, rest.split_once(end)?.1)));
    let (before, after) = parts.ok_or_else(|| format!("there is no line {begin} before a line {end}"))?;
    Ok(format!("{before}{begin}\n{}\n{end}{after}", text.trim()))
}

/// The section of one law.
fn section(row: &Row) -> String {
    let law = row.law;
    let mut text = format!("\n### `{}`\n\n", law.name);
    let mut say = |what: &str, words: String| text += &format!("- {what}: {words}\n");
    let or_none = |words: &str| if words.is_empty() { "none".to_owned() } else { words.to_owned() };
    say("Source", or_none(law.source));
    say("Promises", row.promise_texts().unwrap_or_else(|| "none".to_owned()));
    say("Gains", or_none(&law.gains.iter().map(|gain| format!("`{gain}`")).collect::<Vec<_>>().join(", ")));
    match &row.stability {
        Ok(stability) => {
            let verdict = if stability.judgement.worst.stable { "stable in every mode" } else { "NOT stable" };
            say(
                "Analyser",
                format!("{verdict} at these gains, spectral radius {:.4}", stability.judgement.worst.spectral_radius),
            );
            let left_out = stability.judgement.not_judged.join("; ");
            say("Not judged", left_out);
        }
        Err(why) => say("Analyser", format!("not judged: {why}")),
    }
    let failing = |verdict: Verdict| -> String {
        let of = row.cells.iter().filter(|cell| cell.count(verdict) > 0);
        or_none(&of.map(|cell| cell.network.as_str()).collect::<Vec<_>>().join(", "))
    };
    say("A run stops or grows on", failing(Verdict::Unstable));
    say("Copies come apart in a run on", failing(Verdict::Apart));
    if !law.keys.is_empty() {
        text += "\n| key | here | unit | meaning |\n|---|---|---|---|\n";
        law.keys.iter().for_each(|key| text += &key_row(row, key));
    }
    text
}

/// A key of a law.
fn key_row(row: &Row, key: &Key) -> String {
    let value = row.scene.get(key.name).map_or_else(String::new, |value| value.to_string());
    let unit = if key.unit.is_empty() { "–" } else { key.unit };
    format!("| `{}` | {value} | {unit} | {} |\n", key.name, key.doc.replace('|', "\\|"))
}
