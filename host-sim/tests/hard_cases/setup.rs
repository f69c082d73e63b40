//! What the hard cases share: scenes from overrides, and how a linear pair grows.

use haptic_core::scalar::Scalar;
use haptic_core::vector::StateVector;
use host_sim::harness::Pair;
use host_sim::scene::SceneFile;

/// The three ways to communicate.
pub const COMMS: [&str; 3] = ["power", "wave", "passive-wave"];

/// The default scene with these overrides, `table.key=value`.
pub fn scene(overrides: &[String]) -> SceneFile {
    SceneFile::load(None, overrides).unwrap_or_else(|error| panic!("{error}"))
}

/// Growth of the dominant oscillation over one packet period, measured on the running pair: from the object's velocities
/// s(k) at every packet, with s² − s(k+1)·s(k−1) = A²·ρ^(2k)·sin²φ for s = A·ρ^k·cos(kφ + θ), free of the phase.
///
/// The pair is kicked by `kick` (m/s), left for `settle` packets until the faster modes are gone, and measured over `count`.
pub fn growth<S: Scalar>(linear: &SceneFile, kick: f64, settle: u64, count: u64) -> f64 {
    let mut pair = Pair::<S>::new(linear).expect("a good scene");
    for (side, share) in pair.sides.iter_mut().zip([1.0, -0.6]) {
        side.plant.free_axis().0.velocity = share * kick;
        let mut state = side.state;
        let mut numbers = 0;
        state.visit(&mut |_: &mut S| numbers += 1);
        assert!(numbers > 0);
    }
    let ticks = u64::from(linear.peer.timing.ticks_per_packet);
    let packets = |pair: &mut Pair<S>, count: u64| (0..count * ticks).for_each(|_| pair.step());
    packets(&mut pair, settle);
    let start = squared_amplitude(&mut pair, ticks);
    packets(&mut pair, count - 3);
    let end = squared_amplitude(&mut pair, ticks);
    assert_eq!(pair.fault(), None);
    // Of sum and difference, the one that is left.
    let mode = usize::from(end[1] > end[0]);
    (end[mode] / start[mode]).powf(0.5 / count as f64)
}

/// A²·sin²φ of the sum and of the difference of both objects' velocities, over three packets.
fn squared_amplitude<S: Scalar>(pair: &mut Pair<S>, ticks: u64) -> [f64; 2] {
    let mut samples = [[0.0; 3]; 2];
    for at in 0..3 {
        (0..ticks).for_each(|_| pair.step());
        let [first, second] = pair.sides.each_ref().map(|side| side.state.observed().object.velocity.to_f64());
        (samples[0][at], samples[1][at]) = (first + second, first - second);
    }
    samples.map(|[before, now, after]| now * now - after * before)
}
