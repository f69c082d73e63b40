//! The step `recordings`: what cohold records is read by a library that is not its own, Python's `mcap` from the registry, in the
//! versions of tests/recordings/requirements.txt, in a virtual environment below target/.

use crate::python::environment;
use crate::run::{self, Failure, command, run};

/// Has tests/recordings/check.py record a run in memory and two live peers, convert both and compare them.
pub(crate) fn recordings() -> Result<(), Failure> {
    let folder = run::root().join("target/recordings");
    let python = environment("python3", &folder, "tests/recordings/requirements.txt", &[])?;
    let mut check = command(&python.to_string_lossy(), &["tests/recordings/check.py"]);
    run(check.arg(run::cohold(false)?))
}
