//! Columns, by name and meaning. Those of a peer after a tick are views of [`cohold_core::sample`], called the same everywhere.

use cohold_core::sample::Quantities;

/// A column: its name, which ends in its unit, and what it means.
pub type Named = (&'static str, &'static str);

/// The column of the true discrepancy between both peers' copies, m.
pub const TRUE_DISCREPANCY: Named = ("true_discrepancy_m", "distance of the two copies at one instant, |x_o1 - x_o2|");

/// Columns of a recording: `before`, the quantities of the peer, `between`, those of one shared axis, `behind`, in this order.
///
/// # Panics
/// If these are not `N` columns; in a constant, that is a compile error.
pub const fn around<const N: usize>(of: &Quantities, [before, between, behind]: [&[Named]; 3]) -> [Named; N] {
    let mut columns = [("", ""); N];
    let mut at = 0;
    macro_rules! put {
        ($list:expr, $one:ident => $named:expr) => {
            let mut rest = $list;
            while let [$one, others @ ..] = rest {
                columns[at] = $named;
                (rest, at) = (others, at + 1);
            }
        };
    }
    put!(before, one => *one);
    put!(of.peer, one => one.named());
    put!(between, one => *one);
    put!(of.recorded, one => one.named());
    put!(behind, one => *one);
    assert!(at == N, "there are other columns than that");
    columns
}

/// Index, from 0, of the column with this name.
///
/// # Panics
/// If there is no such column; in a constant, that is a compile error.
pub const fn place(columns: &[Named], name: &str) -> usize {
    let mut at = 0;
    while !cohold_core::sample::same(columns[at].0, name) {
        at += 1;
    }
    at
}
