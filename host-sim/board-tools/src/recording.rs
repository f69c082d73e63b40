//! What a board's ticks saw and did, as a table for each shared axis: one row for each record that came.
//!
//! Records are [`cohold_protocol::record`]'s. They travel once and some get lost: the
//! column `tick` says which came. Times count from the first; where a board started anew its ticks begin again, and how long
//! it was away is not known.

use cohold_core::sample::{Quantities, SAMPLE};
use cohold_protocol::record::{self, Record};
use cohold_protocol::wire::Sample;

use cohold_report::Columns;
use cohold_sim::{quantities, quantities::Named};

/// Meaning of an encoder's column.
const COUNTS: &str = "counter of the encoder of this number, modulo 65536";
/// Meaning of a motor's column.
const DUTY: &str = "command to the motor of this number, -1 to 1";

/// Columns of the first shared axis; duties, currents and voltages are shares of all there is, currents and voltages 0 without a current loop.
pub const COLUMNS: [Named; 11 + SAMPLE.columns()] = columns_of(&SAMPLE);

/// The same of another list of quantities.
pub const fn columns_of<const N: usize>(quantities: &Quantities) -> [Named; N] {
    let time =
        ("time_s", "control periods as time: since the first record in CSV, since the board started in a recording");
    let between = [
        (
            "flags",
            "sum of 1 bridges enabled, 2 a packet went out, 4 one came in, 8 the tick before overran, 16 let go of the other peer, 32 \
             the coordination acts",
        ),
        ("encoder_1_counts", COUNTS),
        ("encoder_2_counts", COUNTS),
        ("duty_1", DUTY),
        ("duty_2", DUTY),
    ];
    let behind = [
        ("current_1", "mean current of motor 1 since the tick before, of full scale"),
        ("current_2", "mean current of motor 2 since the tick before, of full scale"),
        ("voltage_1", "mean voltage of motor 1 since the tick before, of the supply"),
        ("voltage_2", "mean voltage of motor 2 since the tick before, of the supply"),
        ("supply_v", "supply of the bridges"),
    ];
    quantities::around(quantities, [&[time], &between, &behind])
}

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
/// no record, or a number in it is not finite.
pub fn row(record: &[u8], period_s: f64) -> Option<(usize, [f64; COLUMNS.len()])> {
    let record = Record::from_bytes(record)?;
    let row = row_of(&SAMPLE, &record, period_s);
    row.iter().all(|number| number.is_finite()).then_some((record.axis().into(), row))
}

/// A row of [`columns_of`].
pub fn row_of<const N: usize, const MORE: usize>(of: &Quantities, record: &Record<MORE>, period_s: f64) -> [f64; N] {
    // Means since the tick before: currents of full scale, voltages of the supply; 0 without a current loop.
    let stage = record.stage().unwrap_or_default();
    let share = |part: i16, of: u16| f64::from(part) / f64::from(of.max(1));
    let currents = stage.motors.map(|motor| share(motor.mean, 32767));
    let voltages = stage.motors.map(|motor| share(motor.voltage, stage.supply_counts));
    let values = [period_s * f64::from(record.tick())].into_iter();
    let values = values.chain(of.of_peer(record.of_peer())).chain([f64::from(record.flags())]);
    let values = values.chain(record.counts().map(|counts| counts.0.into()));
    let values = values.chain(record.duties().map(|duty| share(duty.0, 32767)));
    let values = values.chain(of.recorded.iter().map(|quantity| record.number(quantity.word).into()));
    let values = values.chain(currents).chain(voltages).chain([f64::from(stage.supply_mv) / 1e3]);
    let mut row = [0.0; N];
    row.iter_mut().zip(values).for_each(|(to, from)| *to = from);
    row
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

/// Columns of a PWM period: of what the current loop did in it.
pub const PERIOD: [Named; 5] = [
    ("period", "number of the PWM period, of those with motors on since power came on"),
    ("current_1", "current of motor 1 at its beginning, of full scale"),
    ("current_2", "current of motor 2 at its beginning, of full scale"),
    ("voltage_1", "voltage of motor 1 over it, of the supply"),
    ("voltage_2", "voltage of motor 2 over it, of the supply"),
];

/// The rows of [`PERIOD`] in a sample, if it holds any.
pub fn periods(sample: &Sample) -> impl Iterator<Item = [f64; PERIOD.len()]> {
    let payload = if sample.code == record::PERIODS { sample.payload() } else { &[] };
    record::Period::of_payload(payload).map(|(number, period)| {
        let [[a, b], [c, d]] = [period.currents, period.voltages].map(|two| two.map(|part| f64::from(part) / 32767.0));
        [f64::from(number), a, b, c, d]
    })
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
