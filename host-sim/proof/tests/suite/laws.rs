//! Every law of core, whichever there are, and the law that says anything.

use cohold_core::device::kinematics::AnyKinematics;
use cohold_core::law::Law;
use cohold_core::{peer::Peer, settings::Value};
use cohold_proof::prove::{prove_in, scenes};
use cohold_proof::{Number, Proved, Whatever, prove_named};

fn named(name: &str) {
    let (law, proved) = prove_named(name).or_else(|| cohold_guest_laws::prove(name)).expect("a law");
    assert_eq!(law, name);
    holds(name, &proved, 10);
}

fn holds(name: &str, proved: &Proved, scenes: usize) {
    println!("{name}: {proved:?}");
    assert_eq!(proved.broken, None, "{name}");
    assert!(proved.scenes >= scenes && proved.states >= 2 * proved.scenes && proved.paths > 1000, "{name}: {proved:?}");
    // The limits are reached: what was looked at was not nothing.
    assert!(proved.widest_n == 40.0 && (proved.widest_step_n - 20.0).abs() < 1e-4, "{name}: {proved:?}");
}

#[test]
fn every_law_keeps_forces_within_their_limits() {
    for law in cohold_laws::LAWS {
        named(law.name);
    }
}

#[test]
fn so_does_a_law_that_says_anything() {
    Whatever::LAWS.iter().for_each(|law| named(law.name));
}

#[test]
fn so_it_does_along_two_shared_axes() {
    let [law] = Whatever::LAWS else { unreachable!() };
    let shared = ["axis.count", "axis.shared"].map(|key| (key, Value::Number(2.0)));
    let scenes = scenes::<Whatever, 2, 2, AnyKinematics<Number>>(law, &shared, false);
    holds(law.name, &prove_in::<Whatever, 2, 2, AnyKinematics<Number>>(&scenes, Peer::tick), 2);
}
