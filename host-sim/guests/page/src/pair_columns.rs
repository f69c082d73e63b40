//! What is in a sample of two peers, with unit and meaning: of peer 1 first where there are two. Every window gets these lists.
//!
//! Of an object that is shared along several axes the columns of the first one, and of both peers, are those of one axis; those of the
//! second follow with `_y` behind their names, and those of the third with `_z`.

use super::environment::{Column, MOST, Sample, joined};

/// Numbers of both peers along an axis, in pairs.
pub(super) const OF_AXIS: usize = 8;
/// Numbers beside those, but for the count of starts.
pub(super) const OF_BOTH: usize = 7;
/// One axis: these, and how often both have started anew.
const ONE: usize = 2 * OF_AXIS + OF_BOTH + 1;

/// Columns of an axis: what is behind their names, and behind their meanings.
macro_rules! along {
    ($suffix:literal, $way:literal: $($name:literal, $unit:literal, $means:literal, $more:literal;)+) => {
        [$((concat!($name, $suffix), $unit, concat!($means, $way, $more))),+]
    };
    ($suffix:literal, $way:literal) => {
        along! { $suffix, $way:
            "wanted_1", "m", "hand of person 1", ", no number while it holds nothing";
            "wanted_2", "m", "hand of person 2", "";
            "device_1", "m", "device 1", "";
            "device_2", "m", "device 2", "";
            "object_1", "m", "copy of the object at peer 1", "";
            "object_2", "m", "copy of the object at peer 2", "";
            "decoded_1", "m", "where peer 1 believes the other copy to be", "";
            "decoded_2", "m", "where peer 2 believes the other copy to be", "";
            "contact_1", "N", "force of device 1 on its copy", "";
            "contact_2", "N", "force of device 2 on its copy", "";
            "coordination_1", "N", "coordination force F_T on copy 1", "";
            "coordination_2", "N", "coordination force F_T on copy 2", "";
            "hand_1", "N", "force of hand 1 on its device", "";
            "hand_2", "N", "force of hand 2 on its device", "";
            "push_1", "N", "force of the scene's user 1 on device 1, its arm's included", "";
            "push_2", "N", "force of the scene's user 2 on device 2, its arm's included", "";
        }
    };
}

const BOTH: [Column; OF_BOTH + 1] = [
    ("line", "J", "energy that both have sent and neither has received: on its way, or lost with its packet"),
    (
        "kept_1",
        "J",
        "energy that the coordination of peer 1 took in and neither gave out nor stores; below 0 it makes energy",
    ),
    ("kept_2", "J", "the same of peer 2"),
    ("delay_1", "s", "how long the newest packet was on its way to peer 1"),
    ("delay_2", "s", "how long the newest packet was on its way to peer 2"),
    ("live_1", "", "1 while what peer 1 hears is fresh, or its line lives; 0 while it stands"),
    ("live_2", "", "the same of peer 2"),
    ("restarts", "", "how often both have started anew"),
];

/// An object in space, which has all of them.
const SPACE: [Column; MOST - 1] = joined(&[&along!("", ""), &BOTH, &along!("_y", ", across"), &along!("_z", ", up")]);

/// The columns of an object that is shared along so many axes.
pub(super) fn columns(axes: usize) -> &'static [Column] {
    &SPACE[..ONE + 2 * OF_AXIS * (axes.clamp(1, 3) - 1)]
}

/// A sample of what both have along each axis, of the numbers beside those, and of how often they have started anew.
pub(super) fn sample<const SHARED: usize>(
    axes: [[[f32; 2]; OF_AXIS]; SHARED],
    rest: [f32; OF_BOTH],
    restarts: u32,
) -> Sample {
    let mut sample = [f32::NAN; MOST];
    let restarts = restarts as f32;
    let (first, others) = axes.split_at(1);
    let numbers = first.iter().flatten().flatten().chain(&rest).chain([&restarts]);
    let numbers = numbers.chain(others.iter().flatten().flatten());
    sample.iter_mut().zip(numbers).for_each(|(to, number)| *to = *number);
    sample[MOST - 1] = restarts;
    sample
}
