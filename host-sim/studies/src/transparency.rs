//! Transparency of a leader and a follower: what each end feels of the other, and how far position and force are from equal, over frequency.
//!
//! Each end in turn is led by a hand; the other device is alone, in nobody's hand, or held. With it alone, the **position error** is
//! |x₁ − x₂|/|x₁|; with it held, the **force error** is |F₁ − F₂|/|F₂| of what the hand gives and what the far device presses with
//! (Lawrence 1993 asks for both to be zero). Between the impedances with the far device held and alone, lies all that can be felt there: the
//! **Z-width** (Colgate & Brown 1994). All in the world's units.
//!
//! Everything is found twice: in frequency from the matrices of the code that flies ([`cohold_analysis::answers`]), and in time from peers that
//! run ([`cohold_sim::measure::impedance`]). A third are closed forms, at low frequencies: behind contacts, couplings and a wave line that is T
//! long, a held device is a spring of 1/(2/K_LC + 2/K_T + T/b), and one that is alone a mass of all masses and b·T.
//!
//! **The largest stable impedance** is a wall without damping that the far device meets for good, judged in every mode at
//! [`WALLS_N_PER_M`]. Left out: jitter and loss.

use std::f64::consts::TAU;

use cohold_analysis::{answers, judge};
use cohold_plot::{Dash, Figure, Panel, Series};
use cohold_report::Columns;
use cohold_sim::measure::impedance::{Answer, RemoteEnd, SPEED_M_PER_S, answer, frequencies_hz};
use cohold_sim::scene::Scene;
use rayon::prelude::*;

use super::Error;

/// Stiffness of the walls that are judged, N/m.
pub const WALLS_N_PER_M: [f64; 4] = [1e3, 1e4, 1e5, 1e6];
/// Highest frequency at which the largest ratio of the impedances is looked for, Hz: about as fast as a hand follows what it does not foresee.
pub const WIDTH_TO_HZ: f64 = 2.0;
/// Lowest and highest frequency, Hz.
const BAND_HZ: [f64; 2] = [0.1, 100.0];
/// Frequencies at which runs are measured, and how many analysed ones come to each: a resonance is narrower than what runs can be asked for.
const POINTS: usize = 31;
const FINER: usize = 10;
/// The far device held, and alone.
const FARS: [RemoteEnd; 2] = [RemoteEnd::Held, RemoteEnd::Alone];

/// Answers at one frequency: with the far device held, and alone.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Frequency of the hand's motion, Hz.
    pub frequency_hz: f64,
    /// Answer by the matrices.
    pub analysed: [Answer; 2],
    /// From a run; none where none ran, or where it did not repeat.
    pub measured: [Option<Answer>; 2],
}

impl Point {
    /// |x₁ − x₂|/|x₁| of an answer with the far device alone.
    pub fn position_error(alone: &Answer) -> f64 {
        (1.0 - alone.motion).norm()
    }

    /// |F₁ − F₂|/|F₂| of an answer with the far device held.
    pub fn force_error(held: &Answer) -> f64 {
        let [hand, far] = [held.impedance, held.pushed];
        (hand - far).norm() / far.norm()
    }

    /// How far the two ways to an impedance are apart, relative; none where nothing was measured.
    fn disagreement(&self) -> impl Iterator<Item = f64> {
        let both = self.analysed.into_iter().zip(self.measured);
        both.filter_map(|(one, other)| {
            let (one, other) = (one.impedance, other?.impedance);
            Some((other - one).norm() / one.norm())
        })
    }
}

/// One end at one delay.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Delay there and back, ms.
    pub round_trip_ms: f64,
    /// Whose hand leads: 1, the leader, or 2, the follower.
    pub end: usize,
    /// The answers, frequency by frequency.
    pub points: Vec<Point>,
    /// The stiffest of [`WALLS_N_PER_M`] up to which the far device may meet all; none where the first is too much.
    pub stiffest_wall_n_per_m: Option<f64>,
}

impl Curve {
    fn lowest(&self) -> (f64, [Answer; 2]) {
        let point = self.points.iter().min_by(|one, other| one.frequency_hz.total_cmp(&other.frequency_hz));
        point.map_or((f64::NAN, [Answer::default(); 2]), |point| (TAU * point.frequency_hz, point.analysed))
    }

    /// Stiffness felt of a far device that is held, at the lowest frequency, N/m.
    pub fn felt_stiffness_n_per_m(&self) -> f64 {
        let (omega, [held, _]) = self.lowest();
        -omega * held.impedance.im
    }

    /// Mass felt of one that is alone, there, kg.
    pub fn felt_mass_kg(&self) -> f64 {
        let (omega, [_, alone]) = self.lowest();
        alone.impedance.im / omega
    }

    /// Largest impedance felt over the smallest, mean up to [`WIDTH_TO_HZ`], dB.
    pub fn width_db(&self) -> f64 {
        let band: Vec<&Point> = self.points.iter().filter(|point| point.frequency_hz <= WIDTH_TO_HZ).collect();
        let ratio = |[held, alone]: [Answer; 2]| 20.0 * (held.impedance.norm() / alone.impedance.norm()).log10();
        band.iter().map(|point| ratio(point.analysed)).sum::<f64>() / band.len() as f64
    }

    /// The highest frequency up to which an error is below a tenth, Hz; none where it never is.
    fn within_hz(&self, error: impl Fn(&[Answer; 2]) -> f64) -> Option<f64> {
        let good = self.points.iter().take_while(|point| error(&point.analysed) < 0.1);
        good.last().map(|point| point.frequency_hz)
    }

    /// The most that the two ways to an impedance are apart, relative; none where no run repeated.
    pub fn disagreement(&self) -> Option<f64> {
        self.points.iter().flat_map(Point::disagreement).reduce(f64::max)
    }
}

/// The scene at a constant delay, there and back.
///
/// # Errors
/// Half of it is no whole number of packets, or more than a scene takes.
fn delayed(scene: &Scene, round_trip_ms: f64) -> Result<Scene, Error> {
    let mut delayed = scene.linear();
    let packet_ms = 1e3 * scene.peer.timing.packet_period_s();
    let packets = 0.5 * round_trip_ms / packet_ms;
    if (packets - packets.round()).abs() > 1e-6 {
        let allowed = format!("it must be a multiple of {} ms", 2.0 * packet_ms);
        return Err(cohold_sim::Error::not_allowed(format!("a round trip of {round_trip_ms} ms"), allowed).into());
    }
    delayed.set_number("network.one_way_delay_packets", packets.round())?;
    delayed.set_number("network.extra_delay_s", 0.0)?;
    delayed.set_number("network.asymmetry_s", 0.0)?;
    delayed.users = Default::default();
    Ok(delayed)
}

/// Both ends at each of these delays; `done` is called once for each of the curves.
///
/// # Errors
/// An object that is shared along several axes; delays that are no whole packets; packets that do not go every tick; settings that no peer
/// accepts.
pub fn study(scene: &Scene, round_trips_ms: &[f64], done: &(dyn Fn() + Sync)) -> Result<Vec<Curve>, Error> {
    if scene.is_shared_along_several() {
        let shared = scene.peer.axis.shared;
        let allowed = "it must be 1: along several an impedance is a matrix, and this study tells of a number";
        return Err(cohold_sim::Error::not_allowed(format!("axis.shared = {shared}"), allowed).into());
    }
    let cases = round_trips_ms.iter().flat_map(|round_trip_ms| [1, 2].map(|end| (*round_trip_ms, end)));
    let curve = |(round_trip_ms, end): (f64, usize)| {
        let scene = delayed(scene, round_trip_ms)?;
        let [frequencies, run] = [FINER, 1].map(|finer| frequencies_hz(&scene, BAND_HZ, finer * (POINTS - 1) + 1));
        let [held, alone] = FARS.map(|far| answers(&scene, end - 1, far, &frequencies));
        let analysed = held?.into_iter().zip(alone?).map(|(held, alone)| [held, alone]);
        let points: Vec<(f64, [Answer; 2])> = frequencies.iter().copied().zip(analysed).collect();
        let point = |(frequency_hz, analysed): (f64, [Answer; 2])| {
            let measured = |far| match run.contains(&frequency_hz) {
                true => answer(&scene, end - 1, far, frequency_hz, SPEED_M_PER_S),
                false => Ok(None),
            };
            let [held, alone] = FARS.map(measured);
            Ok::<_, Error>(Point { frequency_hz, analysed, measured: [held?, alone?] })
        };
        let points = points.into_par_iter().map(point).collect::<Result<_, _>>()?;
        let curve = Curve { round_trip_ms, end, points, stiffest_wall_n_per_m: stiffest_wall(&scene, 3 - end)? };
        done();
        Ok(curve)
    };
    cases.map(curve).collect()
}

/// The stiffest wall up to which the device of peer `number` may meet all of [`WALLS_N_PER_M`], for good, in every mode.
fn stiffest_wall(scene: &Scene, number: usize) -> Result<Option<f64>, Error> {
    let mut stiffest = None;
    for stiffness in WALLS_N_PER_M {
        let mut walled = scene.clone();
        walled.set_number(&format!("user.{number}.wall_stiffness_n_per_m"), stiffness)?;
        if !judge(&walled)?.worst.stable {
            break;
        }
        stiffest = Some(stiffness);
    }
    Ok(stiffest)
}

/// A row for every end and delay.
pub fn columns(curves: &[Curve]) -> Columns {
    Columns::of(curves)
        .value("round_trip_ms", |curve| curve.round_trip_ms)
        .means("delay there and back")
        .value("end", |curve| curve.end)
        .means("whose hand leads its device: 1 is the leader, 2 the follower")
        .significant("felt_stiffness_n_per_m", 3, Curve::felt_stiffness_n_per_m)
        .means("stiffness felt of the far device held, at the lowest frequency")
        .significant("felt_mass_kg", 3, Curve::felt_mass_kg)
        .means("mass felt with the far device in nobody's hand, at the lowest frequency")
        .number("z_width_db", 1, Curve::width_db)
        .means("largest impedance over the smallest: far device held, over alone, mean up to 2 Hz, dB")
        .value("stiffest_wall_n_per_m", |curve| curve.stiffest_wall_n_per_m)
        .means("wall without damping that the far device may meet for good, every mode stable up to it; 1000000 is the most that was tried")
        .significant("position_to_hz", 2, |curve| curve.within_hz(|[_, alone]| Point::position_error(alone)))
        .means("up to there the far device, in nobody's hand, follows within a tenth of the motion")
        .significant("force_to_hz", 2, |curve| curve.within_hz(|[held, _]| Point::force_error(held)))
        .means("up to there the hand's force is that of the far device, held, within a tenth")
        .power("disagreement", 1, |curve| curve.disagreement())
        .means("how far impedances measured in time are from those analysed in frequency, relative, at the most")
        .done()
}

/// A row for every end, delay and frequency.
pub fn response_columns(curves: &[Curve]) -> Columns {
    let points: Vec<(&Curve, &Point)> =
        curves.iter().flat_map(|curve| curve.points.iter().map(move |point| (curve, point))).collect();
    let measured =
        |at: usize, of: fn(&Answer) -> f64| move |(_, point): &(&Curve, &Point)| point.measured[at].as_ref().map(of);
    let size = |answer: &Answer| answer.impedance.norm();
    let phase = |answer: &Answer| answer.impedance.arg();
    Columns::of(&points)
        .value("round_trip_ms", |(curve, _)| curve.round_trip_ms)
        .means("delay there and back")
        .value("end", |(curve, _)| curve.end)
        .means("whose hand leads its device: 1 is the leader, 2 the follower")
        .value("frequency_hz", |(_, point)| point.frequency_hz)
        .means("how often it goes to and fro")
        .value("held_n_s_per_m", move |(_, point)| size(&point.analysed[0]))
        .means(
            "size of the felt impedance, the far device held; analysed in frequency, as all that does not say measured",
        )
        .value("held_phase_rad", move |(_, point)| phase(&point.analysed[0]))
        .means("its phase: force before speed; beyond a quarter of a turn it is not passive")
        .value("alone_n_s_per_m", move |(_, point)| size(&point.analysed[1]))
        .means("size of the felt impedance, the far device in nobody's hand")
        .value("alone_phase_rad", move |(_, point)| phase(&point.analysed[1]))
        .means("its phase")
        .value("position_error", |(_, point)| Point::position_error(&point.analysed[1]))
        .means("|x_1 - x_2| over |x_1|, the far device in nobody's hand")
        .value("force_error", |(_, point)| Point::force_error(&point.analysed[0]))
        .means("|F_1 - F_2| over |F_2|, what the hand gives and what the far device, held, presses with")
        .value("measured_held_n_s_per_m", measured(0, |answer| answer.impedance.norm()))
        .means("held_n_s_per_m from a run in time; nothing where none ran, or it did not repeat")
        .value("measured_held_phase_rad", measured(0, |answer| answer.impedance.arg()))
        .means("its phase")
        .value("measured_alone_n_s_per_m", measured(1, |answer| answer.impedance.norm()))
        .means("alone_n_s_per_m from a run in time")
        .value("measured_alone_phase_rad", measured(1, |answer| answer.impedance.arg()))
        .means("its phase")
        .value("measured_position_error", measured(1, Point::position_error))
        .means("position_error from a run in time")
        .value("measured_force_error", measured(0, Point::force_error))
        .means("force_error from a run in time")
        .done()
}

/// What is drawn of a point.
type Of = fn(&[Answer; 2]) -> f64;

/// Bode plots of what either end feels, and both errors.
pub fn figure(curves: &[Curve]) -> Figure {
    let ends = ["leader", "follower"];
    let [held, alone]: [Of; 2] = [|both| both[0].impedance.norm(), |both| both[1].impedance.norm()];
    let [held_deg, alone_deg]: [Of; 2] =
        [|both| both[0].impedance.arg().to_degrees(), |both| both[1].impedance.arg().to_degrees()];
    let [position, force]: [Of; 2] = [|both| Point::position_error(&both[1]), |both| Point::force_error(&both[0])];
    let panel = |end: usize, title: String, y_label: &str, lines: &[(Of, Dash, &str)], log_y: bool, legend: bool| {
        let of_end = curves.iter().filter(|curve| curve.end == end);
        let series = of_end.enumerate().flat_map(|(colour, curve)| {
            let points = |of: Of| curve.points.iter().map(move |point| (point.frequency_hz, of(&point.analysed)));
            let runs = move |of: Of| {
                let measured = curve.points.iter().filter_map(move |point| {
                    let [Some(held), Some(alone)] = point.measured else { return None };
                    Some((point.frequency_hz, of(&[held, alone])))
                });
                measured.step_by(3)
            };
            lines.iter().flat_map(move |(of, dash, name)| {
                let label = if legend { format!("{} ms, {name}", curve.round_trip_ms) } else { String::new() };
                [
                    Series::dashed(label, colour, *dash, points(*of).collect()).wide(1.6 + 1.4 * colour as f64),
                    Series::dots("", colour, runs(*of).collect(), Vec::new()),
                ]
            })
        });
        Panel {
            title,
            x_label: "Frequency (Hz)".to_owned(),
            y_label: y_label.to_owned(),
            log_x: true,
            log_y,
            series: series.collect(),
            ..Panel::default()
        }
    };
    let sizes = [(held, Dash::Solid, "far device held"), (alone, Dash::Dashed, "alone")];
    let phases = [(held_deg, Dash::Solid, ""), (alone_deg, Dash::Dashed, "")];
    let panels = (1..=2).flat_map(|end| {
        let who = ends[end - 1];
        [
            panel(end, format!("Felt at the {who}"), "|Z| (N·s/m)", &sizes, true, end == 1),
            panel(end, format!("Felt at the {who}, phase"), "Phase (degrees)", &phases, false, false),
        ]
    });
    let last = [
        panel(1, "Follower alone".to_owned(), "Position error", &[(position, Dash::Solid, "")], true, false),
        panel(1, "Follower held".to_owned(), "Force error", &[(force, Dash::Solid, "")], true, false),
    ];
    Figure {
        title: "What a leader and a follower feel of each other".to_owned(),
        caption: format!(
            "Lines: analysed in frequency, dots: measured in time with a hand of up to {} mm/s, in the world's units; one colour and width a round trip. \
             What can be felt lies between the impedance of a far device that is held and of one that is alone. Errors are \
             |x_1 - x_2|/|x_1| and |F_1 - F_2|/|F_2|.",
            1e3 * SPEED_M_PER_S
        ),
        columns: 2,
        share_x: true,
        panels: panels.chain(last).collect(),
        ..Figure::default()
    }
}
