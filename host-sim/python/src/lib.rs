//! cohold as a Python module. Nothing is computed here: scenes, runs, verdicts and sweeps are those of the command line, to the
//! last bit.
//!
//! Whatever takes time runs detached from the interpreter, so that Python's other threads go on, and looks for Ctrl-C ([`work`]).
//! Recorded columns become NumPy arrays without a copy. What is refused is a `ValueError` with the command line's own sentence.

mod columns;
mod device;
mod law;
mod live;
mod pair;
mod pairs;
mod peer;
mod push;
mod raised;
mod run;
mod scene;
mod stability;
mod study;
mod sweep;
mod work;

use cohold_report::Provenance;
use pyo3::prelude::*;

/// The program that files name.
fn provenance() -> Provenance {
    cohold_cli::provenance(option_env!("COHOLD_COMMIT"))
}

#[pymodule]
mod _native {
    #[pymodule_export]
    #[allow(non_upper_case_globals)]
    const __version__: &str = env!("CARGO_PKG_VERSION");
    #[pymodule_export]
    use super::columns::unit;
    #[pymodule_export]
    use super::law::add_law;
    #[pymodule_export]
    use super::live::{LivePeer, LiveState, generate_key};
    #[pymodule_export]
    use super::pair::Pair;
    #[pymodule_export]
    use super::pairs::Pairs;
    #[pymodule_export]
    use super::peer::Peer;
    #[pymodule_export]
    use super::run::{Run, run};
    #[pymodule_export]
    use super::scene::{Scene, keys, scenes};
    #[pymodule_export]
    use super::stability::{Stability, advice, limit, stability};
    #[pymodule_export]
    use super::study::{Findings, Study};
    #[pymodule_export]
    use super::sweep::{Journal, Sweep};
}
