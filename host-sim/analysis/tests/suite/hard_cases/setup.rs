//! What the hard cases share: scenes from overrides, and how fast a linear pair grows.

use cohold_sim::pair::Pair;
use cohold_sim::peers::Number;
use cohold_sim::scene::Scene;

/// Every way to communicate that the papers compare, with a gain of its own at which the default scene is stable.
pub(crate) const COMMS: [(&str, f64); 3] = [("power", 200.0), ("wave", 1000.0), ("passive-wave", 2000.0)];

/// The default scene with overrides `table.key=value`, separated by blanks.
pub(crate) fn scene(overrides: &str) -> Scene {
    let overrides: Vec<String> = overrides.split_whitespace().map(str::to_owned).collect();
    Scene::load(cohold_guest_laws::laws(), None, &overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// Growth of the dominant oscillation over one packet period, measured on the running pair: of the objects' velocities s(k)
/// at every packet, s² − s(k+1)·s(k−1) = A²·ρ^(2k)·sin²φ where s = A·ρ^k·cos(kφ + θ), whatever the phase.
///
/// The pair is kicked by `kick_m_per_s`, left alone for `settle` packets until faster modes are gone, and watched over
/// `count` more.
pub(crate) fn growth<S: Number>(linear: &Scene, kick_m_per_s: f64, settle: u64, count: u64) -> f64 {
    let mut pair = Pair::<S>::new(linear).expect("a good scene");
    for (side, share) in pair.sides_mut().zip([1.0, -0.6]) {
        side.plant.free_axis().0.velocity = share * kick_m_per_s;
    }
    let ticks = u64::from(linear.peer.timing.ticks_per_packet);
    let pass = |pair: &mut Pair<S>, packets: u64| (0..packets * ticks).for_each(|_| pair.step());
    pass(&mut pair, settle);
    let start = squared_amplitudes(&mut pair, ticks);
    pass(&mut pair, count - 3);
    let end = squared_amplitudes(&mut pair, ticks);
    assert_eq!(pair.fault(), None);
    // Of sum and difference, the one that is left.
    let mode = usize::from(end[1] > end[0]);
    (end[mode] / start[mode]).powf(0.5 / count as f64)
}

/// A²·sin²φ of the sum and of the difference of both objects' velocities, over three packets.
fn squared_amplitudes<S: Number>(pair: &mut Pair<S>, ticks: u64) -> [f64; 2] {
    let mut sample = || {
        (0..ticks).for_each(|_| pair.step());
        let [first, second] = pair.sides().map(|side| side.peer.observed()[0].object.velocity.to_f64());
        [first + second, first - second]
    };
    let [before, now, after] = [sample(), sample(), sample()];
    [0, 1].map(|mode: usize| now[mode] * now[mode] - after[mode] * before[mode])
}
