//! An adversary on the path, without a key: what it may do with a datagram, what it does by time, way and length, and the search for
//! what harms most. Suites of other packages include this file.

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Lengths of datagrams that are told apart.
const LENGTHS: usize = 8;

/// What becomes of a datagram: each of these many ms later it comes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fate(pub(crate) [Option<u16>; 2]);

/// Nobody touches it.
pub(crate) const PASS: Fate = Fate([Some(1), None]);

/// Fates by phase, way and length.
#[derive(Clone, Debug)]
pub(crate) struct Strategy<const PHASES: usize, const WAYS: usize>(pub(crate) [[[Fate; LENGTHS]; WAYS]; PHASES]);

impl Fate {
    fn random(rng: &mut Xoshiro256PlusPlus) -> Self {
        let held = |rng: &mut Xoshiro256PlusPlus| (rng.next_u32() % 1000) as u16 + 1;
        match rng.next_u32() % 8 {
            0..3 => PASS,
            3..5 => Self([None; 2]),
            5 => Self([Some(held(rng)), None]),
            6 => Self([Some(1), Some(held(rng))]),
            _ => Self([Some(held(rng) % 200 + 1), None]),
        }
    }
}

impl<const PHASES: usize, const WAYS: usize> Strategy<PHASES, WAYS> {
    /// Nobody is on the path.
    pub(crate) const NOTHING: Self = Self([[[PASS; LENGTHS]; WAYS]; PHASES]);

    /// Another one, as different as chance has it.
    fn altered(&self, rng: &mut Xoshiro256PlusPlus) -> Self {
        let mut altered = self.clone();
        let rate = 1 << (rng.next_u32() % 6);
        for fate in altered.0.iter_mut().flatten().flatten() {
            if rng.next_u32().is_multiple_of(rate) {
                *fate = Fate::random(rng);
            }
        }
        altered
    }
}

/// What is under way, each way by itself.
pub(crate) struct Path<const WAYS: usize> {
    /// When it comes, ms.
    pub(crate) under_way: [Vec<(u64, Vec<u8>)>; WAYS],
    /// Lengths that anybody sent, each its own place; further ones share the last.
    lengths: Vec<usize>,
}

impl<const WAYS: usize> Default for Path<WAYS> {
    fn default() -> Self {
        Self { under_way: [const { Vec::new() }; WAYS], lengths: Vec::new() }
    }
}

impl<const WAYS: usize> Path<WAYS> {
    /// What comes out of this way by now, ms. The order of what comes at once is the adversary's, too: last in, first out.
    pub(crate) fn come(&mut self, now_ms: u64, way: usize) -> Vec<Vec<u8>> {
        let under_way = &mut self.under_way[way];
        let mut came = Vec::new();
        for at in (0..under_way.len()).rev() {
            if under_way[at].0 <= now_ms {
                came.push(under_way.swap_remove(at).1);
            }
        }
        came
    }

    /// A datagram goes in, which meets the fate that this says by way and place of its length.
    pub(crate) fn say(&mut self, now_ms: u64, way: usize, datagram: &[u8], fate: impl Fn(usize, usize) -> Fate) {
        let place = self.lengths.iter().position(|known| *known == datagram.len()).unwrap_or_else(|| {
            self.lengths.push(datagram.len());
            self.lengths.len() - 1
        });
        for after_ms in fate(way, place.min(LENGTHS - 1)).0.into_iter().flatten() {
            self.under_way[way].push((now_ms + u64::from(after_ms), datagram.to_vec()));
        }
    }

    /// Nothing is under way any more.
    pub(crate) fn clear(&mut self) {
        self.under_way.iter_mut().for_each(Vec::clear);
    }
}

/// Plays random strategies, and alterations of those that came nearest to harm: the largest of each score, or the number of the strategy
/// that broke a promise, and how.
pub(crate) fn search<const PHASES: usize, const WAYS: usize, T: Copy + Default + PartialOrd, const SCORES: usize>(
    seed: u64,
    strategies: usize,
    mut play: impl FnMut(&Strategy<PHASES, WAYS>) -> Result<[T; SCORES], String>,
) -> Result<[T; SCORES], (usize, String)> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let nothing = Strategy::<PHASES, WAYS>::NOTHING;
    let mut best = [const { Strategy::NOTHING }; SCORES];
    let mut most = [T::default(); SCORES];
    for tried in 0..strategies {
        let from = match rng.next_u32() {
            chance if chance.is_multiple_of(4) => &nothing,
            chance => &best[chance as usize / 4 % SCORES],
        };
        let strategy = from.altered(&mut rng);
        let scores = play(&strategy).map_err(|why| (tried, format!("{why}: {strategy:?}")))?;
        for ((score, most), best) in scores.into_iter().zip(&mut most).zip(&mut best) {
            if score > *most {
                *most = score;
                *best = strategy.clone();
            }
        }
    }
    Ok(most)
}
