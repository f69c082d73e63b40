//! What two bare Nucleos and a cable are to show on silicon: each test, its wires, what it drives and measures, its bound; and
//! docs/silicon.md, which is made of that.
//!
//! One board is under test, with the release image; the other, the rig, plays device, faults and logic analyser. Wires go straight through:
//! each joins the pin of one name of both boards, but for the analogue ones. Nobody has run any of it yet, and the rig's image is
//! not written: the list says what each test would do.
#![forbid(unsafe_code)]

pub mod list;
pub mod page;
