//! The program compiled for wider vectors, if it lies beside this one and the processor has them: what is downloaded is then as fast as what
//! is compiled where it runs.
//!
//! Named as this one and its level, `cohold-x86-64-v4`. Both compute the same bits. `COHOLD_VECTORS` names the widest level that is
//! taken: `x86-64-v4`, `x86-64-v3`, or `compiled` for none. Why another program and no function of this one: docs/results/speed.md.

use super::Failure;

/// What names the widest level.
const MOST: &str = "COHOLD_VECTORS";
/// That no wider program is taken.
const COMPILED: &str = "compiled";

/// Becomes the program for the widest vectors of this processor; returns where there is none, or it does not start.
///
/// # Errors
/// A widest level that is none.
pub(super) fn widest() -> Result<(), Failure> {
    let most = std::env::var_os(MOST).unwrap_or_default();
    let level = most.to_str().filter(|most| ["", V4, V3, COMPILED].contains(most));
    let level = level.ok_or_else(|| {
        let most = most.to_string_lossy();
        format!("{MOST} = {most:?} is not allowed: it must be {V4}, {V3} or {COMPILED}, or not be set")
    })?;
    become_widest(level);
    Ok(())
}

#[cfg(all(unix, target_arch = "x86_64"))]
fn become_widest(most: &str) {
    use std::os::unix::process::CommandExt as _;

    let (Ok(program), mut words) = (std::env::current_exe(), std::env::args_os()) else { return };
    let (Some(file), Some(word)) = (program.file_name(), words.next()) else { return };
    for Level { name, is_there, is_this } in LEVELS.iter().skip_while(|level| !most.is_empty() && level.name != most) {
        if *is_this {
            return;
        }
        let mut named = file.to_owned();
        named.push(format!("-{name}"));
        let wider = program.with_file_name(named);
        if is_there() && wider.is_file() {
            let _did_not_start = std::process::Command::new(wider).arg0(word).args(words).exec();
            return;
        }
    }
}

/// Other systems and processors have one program.
#[cfg(not(all(unix, target_arch = "x86_64")))]
fn become_widest(_most: &str) {}

/// Levels of the psABI of x86-64.
const V4: &str = "x86-64-v4";
const V3: &str = "x86-64-v3";

/// A level.
#[cfg(all(unix, target_arch = "x86_64"))]
struct Level {
    name: &'static str,
    is_there: fn() -> bool,
    /// This program is compiled for it.
    is_this: bool,
}

/// The levels that make a difference, the widest first.
#[cfg(all(unix, target_arch = "x86_64"))]
const LEVELS: [Level; 2] = [
    Level { name: V4, is_there: has_v4, is_this: cfg!(target_feature = "avx512vl") },
    Level { name: V3, is_there: has_v3, is_this: cfg!(target_feature = "avx2") },
];

#[cfg(all(unix, target_arch = "x86_64"))]
macro_rules! has {
    ($($feature:tt)+) => { $( is_x86_feature_detected!($feature) )&&+ };
}

#[cfg(all(unix, target_arch = "x86_64"))]
fn has_v3() -> bool {
    has!("avx" "avx2" "bmi1" "bmi2" "f16c" "fma" "lzcnt" "movbe" "popcnt" "cmpxchg16b")
}

#[cfg(all(unix, target_arch = "x86_64"))]
fn has_v4() -> bool {
    has_v3() && has!("avx512f" "avx512bw" "avx512cd" "avx512dq" "avx512vl")
}
