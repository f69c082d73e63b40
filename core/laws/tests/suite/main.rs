//! What the laws of other papers do, against closed forms and numbers of their papers; and all that is asked of any law of core, by core's
//! own files, of these as well.
//!
//! | file | asks |
//! |---|---|
//! | [`copies`], [`tank`], [`deadband`] | does every law keep its promise? |
//! | `total` | is every tick of every scene defined, and within its limits? |
//! | `bounds` | does what another end may say follow from the limits? |
//! | `letting_go` | does no force step when a peer lets go? |

mod copies;
mod deadband;
mod setup;
mod tank;

#[path = "../../../tests/suite/bounds.rs"]
mod bounds;
#[path = "../../../tests/suite/peer/letting_go.rs"]
mod letting_go;
#[path = "../../../tests/suite/total.rs"]
mod total;
#[path = "../../../tests/suite/two_copies.rs"]
mod two_copies;

use cohold_core::schema::Schema;
use cohold_laws::{EveryLaw as AnyLaw, LAWS};

const SCHEMA: Schema = Schema::new(LAWS);

/// Laws whose waves or sums are bounded.
const BOUNDED: &[&str] = &["wave-integral", "wave-compensator"];

/// A law that was put into one list alone would be missing on a board, or in the simulator.
#[test]
fn every_law_is_in_the_list_of_all_and_once() {
    use cohold_core::law::{AnyLaw as OfCore, Law};
    let sorted = |laws: &[&[cohold_core::law::LawInfo]]| {
        let mut names: Vec<_> = laws.iter().flat_map(|laws| laws.iter()).map(|law| law.name).collect();
        names.sort_unstable();
        names
    };
    let both = [<OfCore<f64> as Law<f64>>::LAWS, cohold_laws::OtherLaw::<f64>::LAWS];
    assert_eq!(sorted(&[LAWS]), sorted(&both));
}

/// Every peer has room for the largest state: a law that is new must not make it larger.
#[test]
fn no_state_of_a_law_is_larger_than_the_self_timed_line_s() {
    use cohold_core::law::{Law, self_timed::SelfTimed};
    let largest = size_of::<<SelfTimed<f32> as Law<f32>>::State>();
    let room = size_of::<cohold_laws::EveryLawState<f32>>();
    assert!(room <= largest + 8, "{room} bytes, {largest} of the line");
    let fractal = size_of::<<cohold_laws::fractal_impedance::FractalImpedance<f32> as Law<f32>>::State>();
    assert!(fractal < largest / 2, "{fractal} bytes");
}
