//! How far f32 and fixed point stray from f64 in the same scene, and whether that is rounding or the scene's own chaos.
//!
//! Three pairs run side by side, f64, f32 and I32F32, each with its own devices in f64, on the same pushes; and a **shadow**, a
//! second pair in f64 whose first device starts 1 nm (10⁻⁹ m) further to the right, otherwise the same. What the shadow's distance
//! grows to, the scene makes of any difference. A number type that is no further from f64 than that makes of one of its own
//! rounding steps is called **chaos**: a better number type would not help. Otherwise its rounding adds up: **error**. Where nothing
//! grows and the number type is no further off than one step, it is **rounding** and no more.
//!
//! - Distance: the largest difference of either copy's position so far.
//! - Growth rate λ: least squares of the logarithm of the shadow's distance over time, of the largest in each tenth of a second, until
//!   it is [`GROWN`] times that of the start, 10 µm; after that it saturates. If it never is, all of the run is fitted.
//! - What the scene makes of one step: the shadow's largest distance over 1 nm; once that has grown, e^(λt), but no more than
//!   [`APART`] times the shadow's distance, for two runs that have nothing to do with each other any more differ by chance.
//!
//! Two modes of the copies are distinguished: the **common** one, their mean position, which nothing pulls back where the hands have
//! no arms, so that forces that are rounded move it at random; and the **relative** one, x_1 − x_2, which the coordination holds. In a
//! line that decodes its waves into a velocity (`wave`) the relative mode is at rest anywhere, too (THEORY §2), and walks; a
//! self-timed line sums the waves themselves, and it does not.
//!
//! Along several shared axes each has distances, a growth rate and verdicts of its own, and the shadow starts 1 nm further along every one.
//! A row is of the **worst axis** until then and names it: of the number type and the axis where error comes before chaos and chaos before
//! rounding, and of those where it is most of its own steps off.

use std::array::from_fn;

use cohold_core::{names::Choice, num::Fixed, settings::Refused};

use cohold_report::Columns;
use cohold_sim::peers::Builds;
use cohold_sim::run::AXIS_NAMES;
use cohold_sim::{Plant, of_axes, pair, scene::Scene};

/// Two peers at their own simulated devices, as in a run.
type Pair<S, const SHARED: usize, const N: usize> = pair::Pair<S, Plant<N>, SHARED, N>;

/// How much further the first device of the shadow starts, m.
const DISPLACED_M: f64 = 1e-9;
/// How much a distance grows before it counts as the scene's own making, and is fitted no further.
pub const GROWN: f64 = 1e4;
/// How much further apart than f64 and its shadow two runs may be by chance that part at other times.
pub const APART: f64 = 10.0;
/// The shadow's distance is fitted by its largest in so many seconds.
const WINDOW_S: f64 = 0.1;
/// When a row is taken, beside the end, s: a minute, an hour, ten.
pub const ROWS_S: [f64; 3] = [60.0, 3600.0, 36_000.0];

/// Largest differences from f64 so far.
#[derive(Clone, Copy, Debug, Default)]
pub struct Differences {
    /// Of the mean of both copies' positions, m.
    pub common_m: f64,
    /// Of x_1 − x_2, m.
    pub relative_m: f64,
    /// Of either copy's position, m.
    pub position_m: f64,
    /// Of either coordination force, N.
    pub force_n: f64,
}

cohold_sim::choices! {
    /// Where a difference from f64 comes from.
    #[derive(PartialOrd, Ord)]
    Verdict {
        "rounding" => Rounding, "It is one rounding step.";
        "chaos" => Chaos, "The scene makes as much of one rounding step.";
        "error" => Error, "Rounding steps add up.";
    }
}

/// Differences of a number type from f64.
#[derive(Clone, Copy, Debug)]
pub struct Rounded {
    /// Largest differences from the pair in f64 so far.
    pub from_f64: Differences,
    /// Step of the number type at the largest position seen, m.
    pub position_step_m: f64,
    /// Whether its distance from f64 is chaos, rounding or error.
    pub verdict: Verdict,
}

/// What a run of a scene in three number types gave until a time.
#[derive(Clone, Debug)]
pub struct Precision {
    /// Name of the scene that was run.
    pub scene: String,
    /// The worst of several shared axes, whose figures these are; none where there is one.
    pub axis: Option<&'static str>,
    /// Simulated time until here, s.
    pub time_s: f64,
    /// Largest position of either copy in f64, m.
    pub largest_position_m: f64,
    /// Largest differences of the shadow from the pair in f64.
    pub shadow: Differences,
    /// λ; none where there is too little to fit.
    pub growth_per_s: Option<f64>,
    /// What the scene makes of a difference of 1.
    pub amplification: f64,
    /// How far the pair in f32 strayed from f64.
    pub f32: Rounded,
    /// How far the pair in fixed point, I32F32, strayed from f64.
    pub i32f32: Rounded,
    /// Where f64 itself faulted: differences were taken until then.
    pub faulted_after_s: Option<f64>,
    /// Chaos or error, and how much of it.
    pub why: String,
}

/// Runs the scene for `duration_s`: a row at each of [`ROWS_S`] within it, and at the end.
///
/// # Errors
/// The first key of the scene that is out of range or impossible beside the others.
pub fn measure(name: &str, scene: &Scene, duration_s: f64) -> Result<Vec<Precision>, Refused<'static>> {
    of_axes!(scene, measure_along(name, scene, duration_s))
}

fn measure_along<const SHARED: usize, const N: usize>(
    name: &str,
    scene: &Scene,
    duration_s: f64,
) -> Result<Vec<Precision>, Refused<'static>>
where
    f64: Builds<SHARED, N>,
    f32: Builds<SHARED, N>,
    Fixed: Builds<SHARED, N>,
{
    let [mut double, mut shadow] = [Pair::<f64, SHARED, N>::build(scene)?, Pair::build(scene)?];
    let (mut single, mut fixed) = (Pair::<f32, SHARED, N>::build(scene)?, Pair::<Fixed, SHARED, N>::build(scene)?);
    if let Some(first) = shadow.sides_mut().next() {
        first.plant.each_axis().take(SHARED).for_each(|(motion, _)| motion.position += DISPLACED_M);
    }
    let ticks_in = |time_s: f64| (time_s / scene.peer.timing.control_period_s).round().max(1.0) as u64;
    let (ticks, window) = (ticks_in(duration_s), ticks_in(WINDOW_S));
    let rows_at = ROWS_S.map(ticks_in);
    let mut axes: [Divergence; SHARED] = from_fn(|axis| Divergence { axis, ..Divergence::default() });
    let mut rows = Vec::new();
    for tick in 1..=ticks {
        double.step();
        if double.fault().is_some() {
            rows.extend(worst(&axes, name, scene, double.time_s(), true));
            break;
        }
        shadow.step();
        single.step();
        fixed.step();
        for seen in &mut axes {
            let exact = copies(&double, seen.axis);
            for copy in exact {
                seen.largest_m = seen.largest_m.max(copy.position_m.abs());
            }
            let distance_m = seen.shadow.see(exact, copies(&shadow, seen.axis));
            seen.f32.see(exact, copies(&single, seen.axis));
            seen.i32f32.see(exact, copies(&fixed, seen.axis));
            seen.window_m = seen.window_m.max(distance_m);
            if tick % window == 0 {
                seen.distances.push((double.time_s(), std::mem::take(&mut seen.window_m)));
            }
        }
        if tick == ticks || rows_at.contains(&tick) {
            rows.extend(worst(&axes, name, scene, double.time_s(), false));
        }
    }
    Ok(rows)
}

/// A copy of the object along an axis: where it is, m, and the coordination force on it, N.
#[derive(Clone, Copy)]
struct Copied {
    position_m: f64,
    force_n: f64,
}

/// Both copies of a pair along an axis.
fn copies<S: Builds<SHARED, N>, const SHARED: usize, const N: usize>(
    pair: &Pair<S, SHARED, N>,
    axis: usize,
) -> [Copied; 2] {
    pair.sides().map(|side| {
        let observed = side.peer.observed()[axis];
        Copied { position_m: observed.object.position.to_f64(), force_n: observed.coordination_force.to_f64() }
    })
}

/// The row of the worst axis, the first of those that are as bad.
fn worst(axes: &[Divergence], name: &str, scene: &Scene, time_s: f64, faulted: bool) -> Option<Precision> {
    let rows = axes.iter().map(|seen| {
        let axis = (axes.len() > 1).then(|| AXIS_NAMES[seen.axis]);
        Precision { axis, ..seen.row(name, scene, time_s, faulted) }
    });
    rows.reduce(|worst, row| if row.strays() > worst.strays() { row } else { worst })
}

/// What was seen along an axis until now.
#[derive(Default)]
struct Divergence {
    /// Which, from 0.
    axis: usize,
    largest_m: f64,
    shadow: Differences,
    f32: Differences,
    i32f32: Differences,
    /// Time, s, and largest distance of the shadow in the window that ended then, m.
    distances: Vec<(f64, f64)>,
    /// The same in this window.
    window_m: f64,
}

impl Divergence {
    fn row(&self, name: &str, scene: &Scene, time_s: f64, faulted: bool) -> Precision {
        let shadow = self.shadow;
        let grown = shadow.position_m >= GROWN * DISPLACED_M;
        let until_m = GROWN * DISPLACED_M;
        let fitted: Vec<_> =
            self.distances.iter().take_while(|(_, distance_m)| *distance_m < until_m).copied().collect();
        let growth_per_s = growth_per_s(&fitted);
        let ratio = shadow.position_m / DISPLACED_M;
        let amplification = match growth_per_s {
            Some(rate) if grown => ratio.max((rate * time_s).exp()),
            _ => ratio,
        };
        let rounded = |from_f64: Differences, position_step_m: f64| {
            let makes_m = amplification * position_step_m;
            let verdict = if grown && from_f64.position_m <= makes_m.min(APART * shadow.position_m) {
                Verdict::Chaos
            } else if !grown && from_f64.position_m <= makes_m.max(position_step_m) {
                Verdict::Rounding
            } else {
                Verdict::Error
            };
            Rounded { from_f64, position_step_m, verdict }
        };
        // Steps: 2^(exponent − 23) for f32, 2^−32 for I32F32.
        let step_of_f32 = if self.largest_m > 0.0 { (self.largest_m.log2().floor() - 23.0).exp2() } else { 0.0 };
        let (f32, i32f32) = (rounded(self.f32, step_of_f32), rounded(self.i32f32, (-32.0_f64).exp2()));
        let why = if faulted && scene.is_linear() {
            "unstable: every difference grows with the oscillation until the peers fault".to_owned()
        } else {
            let grows = if grown { "as far as the shadow".to_owned() } else { format!("to {amplification:.1}") };
            format!("f32 {}; I32F32 {}; one step grows {grows}", f32.judged(), i32f32.judged())
        };
        Precision {
            scene: name.to_owned(),
            axis: None,
            time_s,
            largest_position_m: self.largest_m,
            shadow,
            growth_per_s,
            amplification,
            f32,
            i32f32,
            faulted_after_s: faulted.then_some(time_s),
            why,
        }
    }
}

impl Differences {
    /// Takes in how far the copies are apart now; how far that is, m.
    fn see(&mut self, exact: [Copied; 2], rounded: [Copied; 2]) -> f64 {
        let [first, second] = [0, 1].map(|at| {
            self.force_n = self.force_n.max((exact[at].force_n - rounded[at].force_n).abs());
            rounded[at].position_m - exact[at].position_m
        });
        let distance_m = first.abs().max(second.abs());
        self.common_m = self.common_m.max((0.5 * (first + second)).abs());
        self.relative_m = self.relative_m.max((first - second).abs());
        self.position_m = self.position_m.max(distance_m);
        distance_m
    }
}

impl Rounded {
    /// Its own rounding steps from f64, at the most.
    fn steps(&self) -> f64 {
        if self.position_step_m > 0.0 { self.from_f64.position_m / self.position_step_m } else { 0.0 }
    }

    fn judged(&self) -> String {
        format!("{}, {:.0} steps", self.verdict.name(), self.steps())
    }
}

impl Precision {
    /// How the number type that strays worse does so, and by how many of its own steps.
    fn strays(&self) -> (Verdict, f64) {
        let [one, other] = [&self.f32, &self.i32f32].map(|rounded| (rounded.verdict, rounded.steps()));
        if one > other { one } else { other }
    }
}

/// Slope of the logarithm of distances (m) over time (s) by least squares, 1/s; a distance of 0 has none.
fn growth_per_s(distances: &[(f64, f64)]) -> Option<f64> {
    let points =
        || distances.iter().filter(|point| point.1 > 0.0).map(|(time_s, distance_m)| (*time_s, distance_m.ln()));
    let count = points().count() as f64;
    let sums = points().fold((0.0, 0.0), |sums, point| (sums.0 + point.0, sums.1 + point.1));
    let mean = (sums.0 / count, sums.1 / count);
    let (over, under) = points().fold((0.0, 0.0), |(over, under), (time, log)| {
        (over + (time - mean.0) * (log - mean.1), under + (time - mean.0) * (time - mean.0))
    });
    (count >= 3.0).then(|| over / under)
}

/// A row for each scene and time: what each column means, its unit, and which are for the data only. Where there are rows and none is of
/// several axes there is no column that names one.
pub fn columns(rows: &[Precision]) -> Columns {
    let mut columns = Columns::of(rows).value("scene", |row| row.scene.as_str()).means("name of the scene");
    if rows.is_empty() || rows.iter().any(|row| row.axis.is_some()) {
        columns = columns
            .value("axis", |row| row.axis)
            .means("of several shared axes the one that strays most, whose figures these are; not of one alone");
    }
    columns = columns
        .number("time_s", 0, |row| row.time_s)
        .means("simulated time until here")
        .data("largest_position_m", |row| row.largest_position_m)
        .means("largest position of either copy in f64")
        .number("shadow.position_m", 4, |row| row.shadow.position_m)
        .means("largest distance of either copy from the shadow, which starts 1 nm further to the right")
        .shown_in("µm", 1e6)
        .head("shadow")
        .number("growth_per_s", 3, |row| row.growth_per_s)
        .means("rate at which the shadow's distance grows; nothing where there is too little to fit")
        .data("amplification", |row| row.amplification)
        .means("what the scene makes of a difference of 1");
    for (name, of) in [("f32", (|row| &row.f32) as fn(&Precision) -> &Rounded), ("i32f32", |row| &row.i32f32)] {
        columns = columns
            .number(format!("{name}.common_m"), 4, |row| of(row).from_f64.common_m)
            .means("largest difference from f64 of the mean of both copies' positions")
            .shown_in("µm", 1e6)
            .number(format!("{name}.relative_m"), 4, |row| of(row).from_f64.relative_m)
            .means("largest difference from f64 of x_o1 - x_o2")
            .shown_in("µm", 1e6)
            .data(format!("{name}.position_m"), |row| of(row).from_f64.position_m)
            .means("largest difference from f64 of either copy's position")
            .data(format!("{name}.force_n"), |row| of(row).from_f64.force_n)
            .means("largest difference from f64 of either coordination force")
            .data(format!("{name}.position_step_m"), |row| of(row).position_step_m)
            .means("step of the number type at the largest position")
            .data(format!("{name}.verdict"), |row| of(row).verdict.name())
            .means("chaos, rounding or error: where the difference comes from");
    }
    columns
        .data("faulted_after_s", |row| row.faulted_after_s)
        .means("where f64 itself stopped: differences were taken until then")
        .value("why", |row| row.why.as_str())
        .means("what either number type's difference is, and of how many steps")
        .done()
}
