//! `host-sim stability`: verdicts, limits and regions, from the code that flies.

mod bench;
mod limit;
mod map;
mod paper;
mod point;
mod rendering;
mod tune;

super::commands! {
    /// What is asked.
    Question {
        /// Is this scene stable? Spectral radius of one packet period, rest modes left out.
        Point(point::Point),
        /// At which values of one key does that change? All of them, pockets included.
        Limit(limit::Limit),
        /// The region in two keys, as file and picture.
        Map(map::Map),
        /// Figure 4 of the cooperation paper: three ways to communicate, four delays.
        Paper(paper::Paper),
        /// Figure 4 of the architectures paper: one device, one object, largest stiffness against delay and sampling period.
        Rendering(rendering::Rendering),
        /// The stiffest contact and coordination that leave a margin, for this device, network and loop.
        Tune(tune::Tune),
        /// Spectral radii per second.
        Bench(bench::Bench),
    }
}
