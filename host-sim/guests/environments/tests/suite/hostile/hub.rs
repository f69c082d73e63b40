//! A hostile member at a hub of two honest ones, whose arms hold them where they began.

use super::program::Program;
use super::table::Table;
use super::{asked, scene};
use cohold_core::device::AXES;
use cohold_core::settings::Safety;
use cohold_protocol::wire::Flows;
use cohold_sim::peers::Builds;
use cohold_sim::rng::Rng;

const ARMS: [&str; 4] = [
    "user.1.arm_stiffness_n_per_m=300",
    "user.1.arm_damping_n_s_per_m=5",
    "user.2.arm_stiffness_n_per_m=100",
    "user.2.arm_damping_n_s_per_m=8",
];

/// Programs from one look at the copies to the next, along all axes.
const BETWEEN_LOOKS: u64 = 25;

/// `programs` programs one after the other at a hub of this scene that takes what is within its limits, or these, which goes on through
/// all of them; now and then everybody comes to rest.
/// Along each shared axis it says another one.
fn programs<const SHARED: usize, const N: usize>(name: &str, programs: u64, limits: Option<Safety>)
where
    f32: Builds<SHARED, N>,
{
    let mut rng = Rng::new(asked("HOSTILE_SEED", 1));
    let axes = ["count", "shared"].map(|key| format!("axis.{key}={SHARED}"));
    let keys: Vec<&str> = ARMS.into_iter().chain(axes.iter().map(String::as_str)).collect();
    let begin = || Table::<SHARED, N>::new(scene(name, &keys), limits);
    let mut table = begin();
    let ticks_per_packet = table.ticks_per_packet();
    let between = BETWEEN_LOOKS / SHARED as u64;
    let mut most = [0.0_f64; 2];
    let (mut looks, mut farthest_m, mut faults, mut taken) = (0, 0.0_f64, 0, [0; 2]);
    for number in 1..=programs {
        let mut each: [Program; SHARED] = std::array::from_fn(|_| Program::new(&mut rng, table.bound));
        for at in 0..each[0].ticks {
            let due = table.is_due().then(|| {
                let period_s = 1e-3 * f64::from(ticks_per_packet);
                let flows =
                    each.each_mut().map(|program| program.flow(&mut rng, table.tick, at, ticks_per_packet, period_s));
                let engaged = flows.iter().all(|flow| flow.engaged);
                Flows { engaged, fading: false, tick: flows[0].tick, axes: flows.map(|flow| flow.axes[0]) }
            });
            table.step(due);
        }
        if rng.chance(0.3) {
            table.gone();
        }
        if number % between > 0 {
            continue;
        }
        // Known to be gone, or silent until it is let go of.
        let silent = rng.chance(0.2);
        if !silent {
            table.gone();
        }
        (0..if silent { 12_000 } else { 3_000 }).for_each(|_| table.step(None));
        table.rest();
        assert!(table.holds(), "program {number}: somebody is not taken in again");
        for honest in &table.honest {
            most = [most[0].max(honest.force_most_n), most[1].max(honest.speed_most)];
        }
        let gone_off: u32 = table.honest.iter().map(|honest| honest.faults).sum();
        if gone_off == 0 {
            looks += 1;
            farthest_m = farthest_m.max(table.apart_m());
            assert!(table.apart_m() <= 1e-3, "program {number}: {} m apart", table.apart_m());
        } else {
            // Whoever was off begins where his own device is.
            faults += gone_off;
            taken = [0, 1].map(|at| taken[at] + table.taken[at]);
            table = begin();
        }
    }
    taken = [0, 1].map(|at| taken[at] + table.taken[at]);
    println!(
        "{name}, {SHARED} axes: {taken:?} flows taken and not, {looks} looks, {farthest_m} m, {most:?} N and m/s, {faults} faults"
    );
    assert!(looks > programs / between / 4 && taken.iter().all(|flows| *flows > programs), "{looks}, {taken:?}");
}

#[test]
fn ten_thousand_programs_at_a_hub_of_self_timed_lines() {
    programs::<1, AXES>("any-network", asked("HOSTILE_PROGRAMS", 10_000), None);
}

#[test]
fn ten_thousand_programs_at_a_hub_of_waves() {
    programs::<1, AXES>("hub", asked("HOSTILE_PROGRAMS", 10_000), None);
}

#[test]
fn a_thousand_programs_along_each_of_several_axes() {
    let tenth = asked("HOSTILE_PROGRAMS", 10_000) / 10;
    for name in ["any-network", "hub"] {
        programs::<2, 2>(name, tenth, None);
        programs::<3, 3>(name, tenth, None);
    }
}

/// A hub that takes any number: the same programs find it out.
#[test]
#[should_panic(expected = "a hub says what can be")]
fn the_programs_find_a_hub_that_takes_anything() {
    let anything = Safety { max_speed_m_per_s: 1e300, ..scene("any-network", &[]).peer.safety };
    programs::<1, AXES>("any-network", 1_000, Some(anything));
}
