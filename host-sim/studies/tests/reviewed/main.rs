//! Tables that are reviewed line by line, and the search beside the whole grid: thousands of runs, as a release computes them. In debug there are none.
#![cfg(not(debug_assertions))]

mod campaign;
mod halving;
