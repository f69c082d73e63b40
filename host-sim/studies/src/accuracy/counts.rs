//! Instructions, counted: the reviewed files `instructions-….txt` beside this one, one for each [`Processor`].
//!
//! | processor | counted by | with |
//! |---|---|---|
//! | Cortex-M7, the board's | `cargo xtask count` | QEMU: a virtual clock that every instruction moves |
//! | x86-64 | `cargo bench --package cohold-studies --bench choices` | valgrind's callgrind |
//!
//! Both run the very same [`cohold_cases`] and give the same counts on every run of the same binary. Unit: instructions per
//! call (loading the parameters, storing the state and the call itself included) or, for `tick/…`, per tick of a whole
//! peer, an eighth of its exchange included.
//!
//! **Cost per scene**: a scene carries only the models it needs, so cost is a sum that a user can read off: every row is a scene,
//! the row it is compared with, and the instructions between them. The list of scenes is [`cohold_cases::scenes`].
//!
//! Limits: instructions are not cycles. In particular f64 takes as many instructions as f32 on both, but not everywhere as
//! few cycles; what a scheme or a model adds carries over, the price of a number type must be timed on the hardware.

use std::{collections::BTreeMap, sync::LazyLock};

use cohold_cases::scenes::{NAMED, SCENES, Scene};
use cohold_core::names::Choice;
use cohold_report::Columns;
use serde::Serialize;

/// What instructions are instructions of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Processor {
    /// The board's, with its double-precision FPU (thumbv7em), under QEMU.
    #[default]
    CortexM7,
    /// A PC's, under callgrind.
    #[serde(rename = "x86-64")]
    X86,
}

impl Choice for Processor {
    const NAMES: &'static [&'static str] = &["cortex-m7", "x86-64"];
    const ALL: &'static [Self] = &[Self::CortexM7, Self::X86];
}

impl Processor {
    /// Name of the processor in reports.
    pub fn label(self) -> &'static str {
        match self {
            Self::CortexM7 => "a Cortex-M7, counted under QEMU",
            Self::X86 => "x86-64, counted under callgrind",
        }
    }

    /// Text of the processor's reviewed file.
    pub fn reviewed(self) -> &'static str {
        match self {
            Self::CortexM7 => include_str!("instructions-cortex-m7.txt"),
            Self::X86 => include_str!("instructions-x86-64.txt"),
        }
    }

    /// Instructions of one case in one number type; `None` where nobody has counted it, as for a choice that is new.
    pub fn count(self, case: &str, scalar: &str) -> Option<u64> {
        static COUNTS: LazyLock<[BTreeMap<&str, [u64; 3]>; 2]> =
            LazyLock::new(|| [Processor::CortexM7, Processor::X86].map(|processor| parse(processor.reviewed())));
        let column = SCALARS.iter().position(|known| *known == scalar)?;
        COUNTS[self as usize].get(case).map(|counts| counts[column])
    }
}

/// Number types, in the order of the columns.
pub const SCALARS: [&str; 3] = ["f32", "f64", "i32f32"];

/// Counts of every case, in the order of [`SCALARS`].
pub fn parse(text: &str) -> BTreeMap<&str, [u64; 3]> {
    let row = |line| {
        let mut words = str::split_whitespace(line);
        let case = words.next()?;
        let counts: Vec<u64> = words.map_while(|word| word.parse().ok()).collect();
        Some((case, counts.try_into().ok()?))
    };
    text.lines().filter(|line| !line.starts_with('#')).filter_map(row).collect()
}

/// What a scene costs, in the order of [`SCALARS`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Cost {
    /// Name of the scene.
    pub scene: &'static str,
    /// What it adds to the other scene.
    pub adds: &'static str,
    /// The scene that it is compared with.
    pub over: Option<&'static str>,
    /// Instructions of one tick.
    pub instructions: [u64; 3],
    /// More than the scene it is compared with; for the first, all.
    pub added: [i64; 3],
}

/// The table, in instructions of this processor; scenes that nobody has counted are not in it.
pub fn costs(processor: Processor) -> Vec<Cost> {
    let of = |name: &str| -> Option<[u64; 3]> {
        let case = format!("tick/{name}");
        let [a, b, c] = SCALARS.map(|scalar| processor.count(&case, scalar));
        Some([a?, b?, c?])
    };
    let row = |scene: &Scene| {
        let instructions = of(scene.name)?;
        let base = scene.over.map_or(Some([0; 3]), of)?;
        let added = [0, 1, 2].map(|column: usize| instructions[column] as i64 - base[column] as i64);
        Some(Cost { scene: scene.name, adds: scene.adds, over: scene.over, instructions, added })
    };
    SCENES.iter().chain([&NAMED]).filter_map(row).collect()
}

/// The table for people.
pub fn cost_columns(costs: &[Cost]) -> Columns {
    let mut columns = Columns::of(costs).value("scene", |cost| cost.scene).value("adds", |cost| cost.adds);
    columns = columns.value("over", |cost| cost.over).head("to");
    for (at, scalar) in SCALARS.into_iter().enumerate() {
        columns = columns.value(scalar, move |cost| cost.instructions[at]);
    }
    for (at, scalar) in SCALARS.into_iter().enumerate() {
        columns = columns.signed(format!("added.{at}"), move |cost| cost.added[at]).head(&format!("+{scalar}"));
    }
    columns.done()
}
