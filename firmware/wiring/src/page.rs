//! The tables of the pages that tell how to build a board, between marks that name them.

use crate::netlist::{Buy, Netlist, Sheet, split};

/// The pages, in docs/.
pub const PAGES: [&str; 2] = ["guides/board/assembly.md", "guides/board/variants.md"];

/// The pages with their tables as the netlist says.
///
/// # Errors
/// No page has the marks of a table.
pub fn filled(mut pages: [String; 2], netlist: &Netlist) -> Result<[String; 2], String> {
    let tables = netlist.sheet.iter().map(|sheet| (sheet.file.as_str(), wires(netlist, sheet)));
    for (table, rows) in tables.chain([("parts", parts(netlist))]) {
        let marks =
            (format!("<!-- {table}: written by cargo xtask drawings -->\n"), format!("<!-- end of {table} -->"));
        let missing = || format!("neither {} nor {} has the marks of {table}", PAGES[0], PAGES[1]);
        let page = pages.iter_mut().find(|page| page.contains(&marks.0)).ok_or_else(missing)?;
        let (before, rest) = page.split_once(&marks.0).ok_or_else(missing)?;
        let (_, after) = rest.split_once(&marks.1).ok_or_else(missing)?;
        *page = format!("{before}{}{rows}{}{after}", marks.0, marks.1);
    }
    Ok(pages)
}

fn parts(netlist: &Netlist) -> String {
    let mut rows =
        "| parts | what it must be | fits | or | about, € | looked up |\n|---|---|---|---|---|---|\n".to_owned();
    for Buy { what, number, second, euros, checked, parts } in &netlist.buy {
        rows += &format!("| {} | {what} | {number} | {second} | {euros} | {checked} |\n", parts.join(", "));
    }
    rows
}

/// A row for each wire of a sheet that is there: from the board where it begins at one.
fn wires(netlist: &Netlist, sheet: &Sheet) -> String {
    let mut rows = "| from | chip | signal | to | wire |\n|---|---|---|---|---|\n".to_owned();
    let here = |pin: &&String| sheet.columns.iter().flatten().any(|part| part == split(pin).0);
    for net in netlist.nets(&sheet.build) {
        let (boards, others): (Vec<&String>, Vec<&String>) =
            net.pins.iter().filter(here).partition(|pin| netlist.part[split(pin).0].kind == "board");
        if boards.len() + others.len() < 2 && !net.rail || others.is_empty() {
            continue;
        }
        let (from, chip) = match boards.first() {
            Some(pin) => {
                let (part, name) = split(pin);
                let place = netlist.place(name).unwrap_or_default();
                let chip = netlist.board.pins.iter().find(|chip| chip.pin == name);
                (format!("{part} {place}"), chip.map_or("–".to_owned(), |chip| format!("{name}, {}", chip.does)))
            }
            None => (spelled(others[0]), "–".to_owned()),
        };
        let rest = &others[usize::from(boards.is_empty())..];
        let to = rest.iter().map(|pin| spelled(pin)).collect::<Vec<_>>().join(", ");
        let to = if to.is_empty() { "the rest of this net, on the other sheets".to_owned() } else { to };
        rows += &format!("| {from} | {chip} | {} | {to} | {} |\n", net.name, net.colour);
    }
    rows
}

fn spelled(pin: &str) -> String {
    pin.replacen('.', " ", 1)
}
