//! The story of three laws on a bad network as a moving picture: an SVG that repeats itself, for a page that runs no program.
//!
//! Where copies and hands are is what [`ThreeLaws`] gives with nobody's hand, [`FRAMES_PER_S`] times a second, drawn to one scale. The
//! line on top is the network that all three share: it is broken while packets are lost. A viewer that shows no motion sees the
//! moment at which the first law's copies are farthest apart. Letters can be read in a column of a journal.

use std::fmt::{Display, Write};

use cohold_sim::scene::Scene;

use super::environment::{Environment, Sample};
use super::session::PERIOD_S;
use super::three_laws::{COLUMNS, ThreeLaws};
use cohold_cli::Failure;

/// Length of the picture, s, and its frames.
const LASTS_S: f64 = 12.0;
const FRAMES_PER_S: f64 = 20.0;
/// Copies that are farther apart than this hold no one object, m.
const TOGETHER_M: f64 = 0.01;
/// Width and height of the picture; where the lanes begin, and how high one is; units a metre.
const WIDTH: f64 = 600.0;
const HEIGHT: f64 = 440.0;
const TOP: f64 = 90.0;
const LANE: f64 = 106.0;
const UNITS_PER_M: f64 = 1300.0;
/// Half the width of a copy, and from its middle to the hand that holds it, units.
const HALF: f64 = 30.0;
const REACH: f64 = 62.0;
/// Each law by the end of its columns, its name, and what its packets carry.
const LAWS: [(&str, &str, &str); 3] = [
    ("power", "power", "packets carry positions"),
    ("wave", "passive wave", "packets carry waves"),
    ("timed", "self-timed", "packets carry sums of waves"),
];

/// A number of every frame.
struct Track(Vec<f64>);

impl Track {
    /// Numbers of the picture, in its units about the middle.
    fn places(samples: &[Sample], column: &str, beside: f64) -> Self {
        Self(numbers(samples, column).map(|metres| 0.5 * WIDTH + UNITS_PER_M * metres + beside).collect())
    }

    /// An attribute that follows these numbers, and is the one at `still` where nothing moves.
    fn attribute(&self, name: &str) -> String {
        let values: Vec<String> = self.0.iter().map(|place| format!("{place:.1}")).collect();
        animated(name, "linear", &values)
    }
}

/// What changes an attribute with the frames, again and again.
fn animated(name: &str, mode: &str, values: &[impl Display]) -> String {
    let mut text = format!(
        "<animate attributeName=\"{name}\" calcMode=\"{mode}\" dur=\"{LASTS_S}s\" repeatCount=\"indefinite\" values=\""
    );
    for (at, value) in values.iter().enumerate() {
        // Writing to a String cannot fail.
        let _ = write!(text, "{}{value}", if at == 0 { "" } else { ";" });
    }
    text + "\"/>"
}

/// A column of every frame.
fn numbers(samples: &[Sample], column: &str) -> impl Iterator<Item = f64> {
    let at = COLUMNS.iter().position(|(name, ..)| *name == column);
    samples.iter().map(move |sample| at.map_or(f64::NAN, |at| f64::from(sample[at])))
}

/// How far apart the copies of a law are, frame by frame, m.
fn apart(samples: &[Sample], law: &str) -> Vec<f64> {
    let [one, two] = [1, 2].map(|peer| numbers(samples, &format!("object_{peer}_{law}")).collect::<Vec<_>>());
    one.iter().zip(two).map(|(one, two)| (one - two).abs()).collect()
}

/// The picture of three laws on the network of this scene.
///
/// # Errors
/// A scene that cannot be shown so.
pub(crate) fn moving_picture(scene: &Scene) -> Result<String, Failure> {
    let mut laws = ThreeLaws::new(scene)?;
    let ticks_per_frame = (1.0 / (FRAMES_PER_S * PERIOD_S)).round() as usize;
    let mut samples = Vec::new();
    for _ in 0..(LASTS_S * FRAMES_PER_S) as usize {
        for _ in 1..ticks_per_frame {
            laws.step()?;
        }
        samples.push(laws.step()?);
    }
    let worst = apart(&samples, LAWS[0].0);
    let still = (0..worst.len()).max_by(|a, b| worst[*a].total_cmp(&worst[*b])).unwrap_or_default();
    let network = &scene.world.network;
    let mut out = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" role=\"img\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"Ubuntu,'Segoe UI','DejaVu Sans',Arial,sans-serif\" font-size=\"15\" fill=\"#222\">\n\
         <title>Three laws, the same hands, the same lost packets</title>\n\
         <desc>Two copies of one object under each of three laws: {}.</desc>\n\
         <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"#fff\"/>\n",
        LAWS.map(|(law, name, _)| format!("{name} comes {:.0} mm apart", 1e3 * largest(&apart(&samples, law))))
            .join(", "),
    );
    out += &line_of_packets(&samples, still, 100.0 * network.loss, network.loss_burst_packets);
    for (at, law) in LAWS.into_iter().enumerate() {
        out += &lane(&samples, still, law, TOP + LANE * at as f64);
    }
    let (x, y, mm) = (24.0, HEIGHT - 14.0, 20.0);
    let _ = writeln!(
        out,
        "<path d=\"M{x} {}v6h{}v-6\" fill=\"none\" stroke=\"#222\"/><text x=\"{}\" y=\"{y}\">{mm} mm</text>\n\
         <text x=\"{}\" y=\"{y}\" text-anchor=\"end\" fill=\"#555\">in each, two copies of one object; {LASTS_S} s, again and again</text>",
        y - 8.0,
        1e-3 * mm * UNITS_PER_M,
        x + 1e-3 * mm * UNITS_PER_M + 8.0,
        WIDTH - 24.0,
    );
    Ok(out + "</svg>\n")
}

fn largest(of: &[f64]) -> f64 {
    of.iter().copied().fold(0.0, f64::max)
}

/// The network, which is broken while more packets of a frame are lost than get through.
fn line_of_packets(samples: &[Sample], still: usize, percent: f64, in_a_row: f64) -> String {
    // A law that goes on counts every packet.
    let [sent, lost] = ["sent_timed", "lost_timed"].map(|column| numbers(samples, column).collect::<Vec<_>>());
    let of_frame = |counts: &[f64], at: usize| counts[at] - if at == 0 { 0.0 } else { counts[at - 1] };
    let broken: Vec<bool> = (0..samples.len()).map(|at| 2.0 * of_frame(&lost, at) > of_frame(&sent, at)).collect();
    let dash: Vec<&str> = broken.iter().map(|broken| if *broken { "3 13" } else { "16 0" }).collect();
    let colour: Vec<&str> = broken.iter().map(|broken| if *broken { "#c2410c" } else { "#555" }).collect();
    format!(
        "<text x=\"24\" y=\"28\" font-size=\"17\" font-weight=\"600\">Three laws, the same hands, the same lost packets</text>\n\
         <text x=\"24\" y=\"50\" fill=\"#555\">{percent:.0} % lost, {in_a_row:.0} in a row on average</text>\n\
         <path d=\"M24 66H{}\" stroke-width=\"4\" stroke=\"{}\" stroke-dasharray=\"{}\">{}{}</path>\n",
        WIDTH - 24.0,
        colour[still],
        dash[still],
        animated("stroke", "discrete", &colour),
        animated("stroke-dasharray", "discrete", &dash),
    )
}

/// One law: two hands, two copies, and how far they come apart.
fn lane(samples: &[Sample], still: usize, (law, name, carries): (&str, &str, &str), y: f64) -> String {
    let worst_m = largest(&apart(samples, law));
    let (sentence, ink) = if worst_m > TOGETHER_M {
        (format!("✗ up to {:.0} mm apart", 1e3 * worst_m), "#c2410c")
    } else {
        (format!("✓ never more than {:.0} mm apart", (1e3 * worst_m).ceil()), "#15803d")
    };
    let mut out = format!(
        "<text x=\"24\" y=\"{}\" font-weight=\"600\">{name}</text><text x=\"24\" y=\"{}\" fill=\"#555\">{carries}</text>\n\
         <text x=\"{}\" y=\"{}\" text-anchor=\"end\" font-weight=\"600\" fill=\"{ink}\">{sentence}</text>\n\
         <path d=\"M24 {}H{}\" stroke=\"#999\"/>\n",
        y + 16.0,
        y + 36.0,
        WIDTH - 24.0,
        y + 16.0,
        y + 84.0,
        WIDTH - 24.0,
    );
    for (peer, side, ink) in [(1, -1.0, "#1d4ed8"), (2, 1.0, "#b45309")] {
        let copy = Track::places(samples, &format!("object_{peer}_{law}"), 0.0);
        let corner = Track(copy.0.iter().map(|x| x - HALF).collect());
        let hand = Track::places(samples, &format!("device_{peer}_{law}"), side * REACH);
        let _ = writeln!(
            out,
            "<rect x=\"{:.1}\" y=\"{}\" width=\"{}\" height=\"54\" rx=\"5\" fill=\"{ink}\" fill-opacity=\".28\" stroke=\"{ink}\" stroke-width=\"2\">{}</rect>\
             <circle cx=\"{:.1}\" cy=\"{}\" r=\"13\" fill=\"{ink}\">{}</circle>",
            corner.0[still],
            y + 30.0,
            2.0 * HALF,
            corner.attribute("x"),
            hand.0[still],
            y + 57.0,
            hand.attribute("cx"),
        );
    }
    out
}

#[cfg(test)]
#[path = "../tests/inside/moving_picture.rs"]
mod tests;
