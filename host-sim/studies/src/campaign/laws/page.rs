//! The laws' tables in pages of the documentation, each between two lines of the page.

use std::fmt::Write as _;

use cohold_io::Most;
use cohold_sim::run::Verdict;

use super::Row;
use super::tables::parts;

/// Between these lines is what `cohold stability prove --page` writes.
pub const PROOFS: [&str; 2] = ["<!-- proofs begin -->", "<!-- proofs end -->"];

/// Between these lines is what `cohold study laws --page` writes: what laws keep at the gains that they declare, what a hand feels,
/// which stiffness is stable, and which law fails on which network.
pub const LAWS: [[&str; 2]; 4] = [
    ["<!-- laws declared begin -->", "<!-- laws declared end -->"],
    ["<!-- laws felt begin -->", "<!-- laws felt end -->"],
    ["<!-- laws region begin -->", "<!-- laws region end -->"],
    ["<!-- laws networks begin -->", "<!-- laws networks end -->"],
];

/// What the page calls its picture.
pub const PICTURE: &str = "laws-impedance.png";
/// The longest file of such a page.
pub const MOST: Most = Most::new(1 << 22, "a page");

/// What is between [`LAWS`], from laws with a packet every 8 ms and with one in every tick.
pub fn sections(rows: &[Row], each_tick: &[Row]) -> Vec<([&'static str; 2], String)> {
    let [kept, felt, judged] = parts(rows);
    let [fast, ..] = parts(each_tick);
    let texts = [
        format!(
            "With a packet every 8 ms:\n\n```text\n{kept}```\n\n\
             With a packet in every tick (`--set timing.ticks_per_packet=1 --set network.one_way_delay_packets=8`):\n\n```text\n{fast}```"
        ),
        format!(
            "```text\n{felt}```\n\n<img src=\"{PICTURE}\" width=\"500\" alt=\"Impedance that a hand feels, law by law\">"
        ),
        format!("```text\n{judged}```"),
        networks(rows),
    ];
    LAWS.into_iter().zip(texts).collect()
}

/// A row for each network: the laws of which a run stops or grows there, and those whose copies come apart.
fn networks(rows: &[Row]) -> String {
    let mut text =
        "| Network | NO: stops, or a force grows | apart: the copies are too far from each other |\n|---|---|---|\n"
            .to_owned();
    for (at, cell) in rows.first().into_iter().flat_map(|row| row.cells.iter().enumerate()) {
        let failing = |verdict: Verdict| {
            let laws = rows.iter().filter(|row| row.law.name != "none" && row.cells[at].count(verdict) > 0);
            let names: Vec<String> = laws.map(|row| format!("`{}`", row.law.name)).collect();
            if names.is_empty() { "–".to_owned() } else { names.join(", ") }
        };
        let _ = writeln!(text, "| {} | {} | {} |", cell.network, failing(Verdict::Unstable), failing(Verdict::Apart));
    }
    text
}

/// What a page has between two lines of its own.
pub fn between<'a>(page: &'a str, [begin, end]: [&str; 2]) -> Option<&'a str> {
    page.split_once(begin).and_then(|(_, rest)| rest.split_once(end)).map(|(found, _)| found.trim())
}

/// A page with this text between two lines of its own. None for a page without them.
pub fn with(page: &str, [begin, end]: [&str; 2], text: &str) -> Option<String> {
    let (before, rest) = page.split_once(begin)?;
    let (_, after) = rest.split_once(end)?;
    Some(format!("{before}{begin}\n{}\n{end}{after}", text.trim()))
}
