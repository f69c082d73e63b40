//! The shared environments from outside. One program: several would each link it.
//!
//! | file | asks |
//! |---|---|
//! | [`roles`] | what do roles make of their messages? |
//! | [`records`] | what do records of a world make of any bytes? |
//! | [`fuzz`] | what do the fuzz targets make of what fuzzers found? |
//! | [`hostile`] | what can a member with a key do to the others? |
//! | [`path`] | what can somebody without a key do on the path of agreed starts, clocks and consent? |
//! | [`architectures`] | does the choice of an architecture hold what must hold, whatever its numbers? |
//! | [`collaborate`], [`cooperative`], [`hub`], [`lifted`], [`squash`], [`static_scene`] | what do the environments do in virtual time? |

mod architectures;
mod collaborate;
mod cooperative;
mod fuzz;
mod hostile;
mod hub;
mod lifted;
#[path = "../../../../board-tools/tests/suite/on_path.rs"]
mod on_path;
mod path;
#[path = "../../../../../protocol/tests/suite/protocol/random.rs"]
mod random;
mod records;
mod roles;
mod squash;
mod static_scene;
mod vectors;
