//! Units, which names end with, and what a column of numbers holds by its name.

use super::Holds;

/// Units by the ends of names, the longer one first where one ends like the other.
const UNITS: &[(&str, &str)] = &[
    ("counts_per_m", "counts/m"),
    ("bytes_per_s", "B/s"),
    ("bit_per_s", "bit/s"),
    ("mm_per_n", "mm/N"),
    ("n_s_per_m", "N·s/m"),
    ("n_per_m", "N/m"),
    ("m_per_s", "m/s"),
    ("per_s", "/s"),
    ("n_s", "N·s"),
    ("percent", "percent"),
    ("rad", "rad"),
    ("deg", "deg"),
    ("ppm", "ppm"),
    ("khz", "kHz"),
    ("hz", "Hz"),
    ("kg", "kg"),
    ("mm", "mm"),
    ("um", "µm"),
    ("ms", "ms"),
    ("us", "µs"),
    ("mn", "mN"),
    ("mj", "mJ"),
    ("m", "m"),
    ("s", "s"),
    ("n", "N"),
    ("j", "J"),
    ("v", "V"),
];

/// A name without its unit, and the unit: at the end, or before a dot (`force_n.mean`).
pub(super) fn split_unit(name: &str) -> (String, &'static str) {
    let without = |part: &str| {
        let of = |(end, unit): &(&str, &'static str)| Some((part.strip_suffix(end)?.strip_suffix(['_', '.'])?, *unit));
        let (rest, unit) = UNITS.iter().find_map(of).filter(|(rest, _)| !rest.is_empty())?;
        Some((rest.to_owned() + &name[part.len()..], unit))
    };
    let ends = std::iter::once(name.len()).chain(name.rmatch_indices('.').map(|(dot, _)| dot));
    ends.map(|end| &name[..end]).find_map(without).unwrap_or_else(|| (name.to_owned(), ""))
}

/// Columns of numbers that are yes or no, and whole numbers, without the number of whose they are.
const FLAGS: &str = "live lan stable";
const COUNTS: &str = "row tick mode fault flags session missing way copies line lines_up restarts engine encoder_counts next rally \
                      stroke score felt touched state version owner";

/// What a column of numbers with this name holds.
pub(super) fn holds(name: &str) -> Holds {
    let parts: Vec<&str> = name.split('_').filter(|part| part.parse::<u8>().is_err()).collect();
    let is = |list: &str| list.split(' ').any(|known| known == parts.join("_"));
    match (is(FLAGS), is(COUNTS)) {
        (true, _) => Holds::Flags,
        (_, true) => Holds::Counts,
        _ => Holds::Numbers,
    }
}

/// The name of what there is several of, with a number before its unit: `object_m` of peer 2 is `object_2_m`.
pub fn numbered(name: &str, number: usize) -> String {
    let (rest, _) = split_unit(name);
    format!("{rest}_{number}{}", &name[rest.len()..])
}

/// What a name is called on an axis, with its unit: `coordination.stiffness_n_per_m` is `Stiffness (N/m)`.
pub fn label(name: &str) -> String {
    let (rest, unit) = split_unit(name.rsplit('.').next().unwrap_or(name));
    let rest = rest.replace('_', " ");
    let mut letters = rest.chars();
    let first = letters.next().map(|letter| letter.to_uppercase().to_string()).unwrap_or_default();
    let unit = if unit.is_empty() { String::new() } else { format!(" ({unit})") };
    format!("{first}{}{unit}", letters.as_str())
}
