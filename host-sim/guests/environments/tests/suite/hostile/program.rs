//! What a hostile member says: shapes of a wave with sums that are true to it, sums that are not, and any bits at all.

use cohold_protocol::wire::{AxisFlow, Flow};
use cohold_sim::rng::Rng;

/// How the wave goes in time.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Step,
    Square(u64),
    Ramp,
    Sine(u64),
    Noise,
}

/// What is done to what it says.
#[derive(Clone, Copy, Debug)]
enum Lie {
    /// Nothing: the sums are those of the wave.
    None,
    /// This number of this field is said instead, every so many flows.
    Number(usize, f64, u64),
    /// Any bits in any field, every so many flows; on the wire those that are no number are refused before.
    Bits(u64),
    /// The flow of so many flows ago, as it was.
    Replays(u64),
    /// Motors are said to be off in every so many flows.
    Rearms(u64),
    /// Sums begin again from nothing every so many flows.
    Restarts(u64),
    /// More ticks than there were, so many in each flow.
    Ahead(u32),
    /// No energy is claimed, or all there is.
    Energy(f64),
}

/// A program: what is said tick by tick.
#[derive(Clone, Debug)]
pub(super) struct Program {
    shape: Shape,
    size: f64,
    lie: Lie,
    /// Ticks that it takes.
    pub(super) ticks: u64,
    sums: AxisFlow,
    said: Vec<Flow>,
}

impl Program {
    /// A program by chance, for waves of up to `bound` √W that are let in.
    pub(super) fn new(rng: &mut Rng, bound: f64) -> Self {
        let period = 1 << rng.below(7);
        let shapes = [Shape::Step, Shape::Square(period), Shape::Ramp, Shape::Sine(8 * period), Shape::Noise];
        // Half of them within what is let in.
        let sizes = [0.01, 0.1, 0.3, 0.7, 0.999, 0.999_999, 1.001, 300.0 / bound, 1e3, 3e38 / bound];
        let numbers = [
            0.0,
            1.0,
            -1.0,
            bound,
            -bound,
            300.0,
            1e4,
            1e9,
            3.4e38,
            -3.4e38,
            1.7e308,
            -1.7e308,
            f64::MIN_POSITIVE,
            f64::NAN,
        ];
        let (field, number) = (rng.below(6) as usize, numbers[rng.below(numbers.len() as u64) as usize]);
        let every = 1 + rng.below(40);
        let lies = [
            Lie::None,
            Lie::None,
            Lie::None,
            Lie::Number(field, number, every),
            Lie::Number(field, number, every),
            Lie::Bits(every),
            Lie::Replays(every),
            Lie::Rearms(every),
            Lie::Restarts(every),
            Lie::Ahead(1 << rng.below(31)),
            Lie::Energy([0.0, 1e6, 1e9][rng.below(3) as usize]),
        ];
        let sign = if rng.chance(0.5) { 1.0 } else { -1.0 };
        Self {
            shape: shapes[rng.below(5) as usize],
            size: sign * bound * sizes[rng.below(sizes.len() as u64) as usize],
            lie: lies[rng.below(lies.len() as u64) as usize],
            ticks: 20 + rng.below(120),
            sums: AxisFlow::default(),
            said: Vec::new(),
        }
    }

    /// The flow of tick `tick` on the sender's clock, `at` ticks after the program began; `period_s` is that of a flow.
    pub(super) fn flow(&mut self, rng: &mut Rng, tick: u32, at: u64, ticks: u32, period_s: f64) -> Flow {
        let share = match self.shape {
            Shape::Step => 1.0,
            Shape::Square(period) => [1.0, -1.0][(at / period % 2) as usize],
            Shape::Ramp => at as f64 / self.ticks as f64,
            Shape::Sine(period) => (std::f64::consts::TAU * at as f64 / period as f64).sin(),
            Shape::Noise => 2.0 * rng.unit() - 1.0,
        };
        let wave = self.size * share;
        let sums = &mut self.sums;
        sums.wave = wave as f32;
        sums.wave_integral += period_s * wave;
        sums.energy_sent += 0.5 * period_s * wave * wave;
        sums.live_ticks = sums.live_ticks.wrapping_add(ticks);
        let count = self.said.len() as u64 + 1;
        let mut flow = Flow { engaged: true, fading: false, tick, axes: [*sums] };
        let [said] = &mut flow.axes;
        match self.lie {
            Lie::None => {}
            Lie::Number(field, number, every) if count.is_multiple_of(every) => match field {
                0 => said.position = number as f32,
                1 => said.velocity = number as f32,
                2 => said.wave = number as f32,
                3 => said.energy_sent = number,
                4 => said.live_ticks = number as u32,
                _ => said.wave_integral = number,
            },
            Lie::Bits(every) if count.is_multiple_of(every) => {
                let mut bits = || rng.below(u64::MAX);
                *said = AxisFlow {
                    position: f32::from_bits(bits() as u32),
                    velocity: f32::from_bits(bits() as u32),
                    wave: f32::from_bits(bits() as u32),
                    wave_integral: f64::from_bits(bits()),
                    energy_sent: f64::from_bits(bits()),
                    live_ticks: bits() as u32,
                };
            }
            Lie::Replays(back) => {
                if let Some(old) = count.checked_sub(back).and_then(|at| self.said.get(at as usize)) {
                    flow = *old;
                }
            }
            Lie::Rearms(every) => flow.engaged = !count.is_multiple_of(every),
            Lie::Restarts(every) if count.is_multiple_of(every) => self.sums = AxisFlow::default(),
            Lie::Ahead(more) => self.sums.live_ticks = self.sums.live_ticks.wrapping_add(more),
            Lie::Energy(joule) => said.energy_sent = joule,
            _ => {}
        }
        self.said.push(flow);
        flow
    }
}
