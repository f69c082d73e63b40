//! What a board's ticks saw and did, as a table for each shared axis: one row for each record that came.
//!
//! Records are those of firmware/src/record.rs; tests/board compares the two. Records travel once and some get lost: the
//! column `tick` says which came. Times count from the first; where a board started anew its ticks begin again, and how long
//! it was away is not known.

use haptic_core::device::AXES;

use crate::quantities::{self, Named};
use crate::report::Columns;

/// Meaning of an encoder's column.
const COUNTS: &str = "counter of the encoder of this number, modulo 65536";
/// Meaning of a motor's column.
const DUTY: &str = "command to the motor of this number, -1 to 1";

/// Columns of the first shared axis; duties, currents and voltages are shares of all there is, currents and voltages 0 without a current loop.
pub const COLUMNS: [Named; 24] = [
    ("time_s", "control periods as time: since the first record in CSV, since the board started in a recording"),
    quantities::TICK,
    quantities::MODE,
    quantities::FAULT,
    (
        "flags",
        "sum of 1 bridges enabled, 2 a packet went out, 4 one came in, 8 the tick before overran, 16 let go of the other peer, 32 \
         the coordination acts",
    ),
    ("encoder_1_counts", COUNTS),
    ("encoder_2_counts", COUNTS),
    ("duty_1", DUTY),
    ("duty_2", DUTY),
    quantities::DEVICE,
    quantities::DEVICE_SPEED,
    quantities::OBJECT,
    quantities::OBJECT_SPEED,
    quantities::DECODED,
    quantities::DECODED_SPEED,
    quantities::CONTACT,
    quantities::COORDINATION,
    quantities::ENERGY_RECEIVED,
    quantities::ENERGY_SENT,
    ("current_1", "mean current of motor 1 since the tick before, of full scale"),
    ("current_2", "mean current of motor 2 since the tick before, of full scale"),
    ("voltage_1", "mean voltage of motor 1 since the tick before, of the supply"),
    ("voltage_2", "mean voltage of motor 2 since the tick before, of the supply"),
    ("supply_v", "supply of the bridges"),
];

/// Columns of a shared axis (from 0) of `axes`: of joints it has the axis' own and the next one's, after the last the
/// first.
pub fn columns(axis: usize, axes: usize) -> impl Iterator<Item = (String, &'static str)> {
    let joint = move |at: usize| if axes > 1 { (axis + at) % axes + 1 } else { at + 1 };
    COLUMNS.into_iter().map(move |(name, meaning)| match name {
        "encoder_1_counts" => (format!("encoder_{}_counts", joint(0)), COUNTS),
        "encoder_2_counts" => (format!("encoder_{}_counts", joint(1)), COUNTS),
        "duty_1" => (format!("duty_{}", joint(0)), DUTY),
        "duty_2" => (format!("duty_{}", joint(1)), DUTY),
        _ => (name.to_owned(), meaning),
    })
}

/// A row from a record, its time counted in ticks since boot (s), and the shared axis (from 0) that it is of; `None` when the bytes are
/// no record.
pub fn row(record: &[u8], period_s: f64) -> Option<(usize, [f64; COLUMNS.len()])> {
    const BYTES: usize = 108;
    let record: &[u8; BYTES] = record.try_into().ok()?;
    let word = |at: usize| u32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]]);
    let half = |at: usize| u16::from_le_bytes([record[at], record[at + 1]]);
    let number = |at: usize| f64::from(f32::from_bits(word(at)));
    let mut row = [0.0; COLUMNS.len()];
    let counts = (0..AXES).map(|joint| f64::from(half(4 + 2 * joint)));
    let duties = (0..AXES).map(|joint| f64::from(half(8 + 2 * joint).cast_signed()) / 32767.0);
    let motions = (28..60).step_by(4).map(number);
    let energies = [number(64), number(68)];
    let tick = f64::from(word(0));
    let head = [period_s * tick, tick, f64::from(record[12]), f64::from(record[13]), f64::from(record[14])];
    // Means since the tick before: currents of full scale, voltages of the supply; 0 without a current loop.
    let share = |at: usize, of: f64| f64::from(half(at).cast_signed()) / of;
    let supply_counts = f64::from(half(106).max(1));
    let currents = [92, 98].map(|at| share(at, 32767.0));
    let voltages = [96, 102].map(|at| share(at, supply_counts));
    let stage = currents.into_iter().chain(voltages).chain([f64::from(half(104)) / 1e3]);
    let values = head.into_iter().chain(counts).chain(duties).chain(motions).chain(energies).chain(stage);
    row.iter_mut().zip(values).for_each(|(to, from)| *to = from);
    Some((usize::from(record[15]), row))
}

/// A table for each of so many shared axes, of the records among these payloads. Times count from the first of all.
pub fn tables<'a>(payloads: impl IntoIterator<Item = &'a [u8]>, period_s: f64, axes: usize) -> Vec<Columns> {
    let mut tables: Vec<_> = (0..axes).map(|axis| Columns::named(columns(axis, axes))).collect();
    let mut first_s = None;
    for (axis, mut row) in payloads.into_iter().filter_map(|payload| row(payload, period_s)) {
        row[0] -= *first_s.get_or_insert(row[0]);
        if let Some(table) = tables.get_mut(axis) {
            table.push_row(&row);
        }
    }
    tables
}

/// When the longest gap in a recording began and how long it was, s; `None` where the ticks come evenly. One or two that the
/// network lost are none.
pub fn longest_gap(table: &Columns) -> Option<(f64, f64)> {
    let times = table.column("time_s").unwrap_or_default();
    // Backwards: a record that came late, or a board that started anew.
    let gaps = || times.windows(2).map(|two| (two[0], two[1] - two[0])).filter(|(_, gap)| *gap > 0.0);
    let usual = gaps().map(|(_, gap)| gap).min_by(f64::total_cmp)?;
    gaps().max_by(|(_, one), (_, other)| one.total_cmp(other)).filter(|(_, gap)| *gap > 3.5 * usual)
}

/// The row, counted from 1, before which the board started anew; the last if it did so more than once.
pub fn started_anew(table: &Columns) -> Option<usize> {
    /// More ticks than a record can come late.
    const LATE: f64 = 1000.0;
    let ticks = table.column("tick").unwrap_or_default();
    ticks.windows(2).rposition(|two| two[0] - two[1] > LATE).map(|at| at + 2)
}
