//! All eigenvalues of a small matrix by Francis' double-shift QR, in the memory of the matrix.
//!
//! Reflections bring the matrix to Hessenberg form, and double shifts then chase its lowest rows off one by one or in pairs, as in
//! LAPACK's `dlahqr` 3.10: its test of when a row is off (Ahues & Tisseur 1997), its start below two small subdiagonals, and its
//! exceptional shifts each tenth step, which get rings of states going that ordinary shifts pass round for ever. Nothing is kept
//! but eigenvalues, so each step touches only the rows that are not off yet: for a dozen states half the work of a Schur form.
//!
//! Error: that of eigenvalues of a matrix a few 1e-16 of its norm away. Range: any finite entries up to 2^400.

use crate::matrix::Matrix;

/// A square matrix, stored column by column.
struct Square<'a> {
    entries: &'a mut [f64],
    size: usize,
}

/// Steps for each row until the iteration gives up: two or three are usual.
const STEPS_PER_ROW: usize = 30;

/// Steps after which an exceptional shift is tried.
const STANDSTILL: usize = 10;

/// Below this an entry off the diagonal is nothing beside any other.
const NOTHING: f64 = f64::MIN_POSITIVE / f64::EPSILON;

/// Finds eigenvalues, one matrix after the other, in the same memory.
#[derive(Debug, Default)]
pub(super) struct Francis {
    /// Those of the matrix before as (real, imaginary), in no order.
    pub(super) found: Vec<(f64, f64)>,
    sums: Vec<f64>,
}

impl Francis {
    /// Finds the eigenvalues of a matrix, which it overwrites; false where the iteration stands still.
    pub(super) fn iterate(&mut self, matrix: &mut Matrix) -> bool {
        self.found.clear();
        let size = matrix.nrows();
        let mut square = Square { entries: matrix.as_mut_slice(), size };
        square.reduce(&mut self.sums);
        let mut rows = size;
        while rows > 0 {
            let Some(off) = square.take_off(rows, &mut self.found) else { return false };
            rows -= off;
        }
        true
    }
}

impl Square<'_> {
    #[inline(always)]
    fn at(&self, row: usize, column: usize) -> f64 {
        self.entries[column * self.size + row]
    }

    #[inline(always)]
    fn at_mut(&mut self, row: usize, column: usize) -> &mut f64 {
        &mut self.entries[column * self.size + row]
    }

    /// Reflects to Hessenberg form, column by column.
    fn reduce(&mut self, sums: &mut Vec<f64>) {
        let size = self.size;
        for at in 0..size.saturating_sub(2) {
            // The reflector stands in the column that it clears, from row `at + 1` on, while it is used.
            let (left, right) = self.entries.split_at_mut((at + 1) * size);
            let reflector = &mut left[at * size + at + 1..];
            let Some((head, share)) = reflect(reflector) else {
                reflector[1..].fill(0.0);
                continue;
            };
            for column in right.chunks_exact_mut(size) {
                let rows = &mut column[at + 1..];
                let sum = share * rows.iter().zip(&*reflector).map(|(entry, part)| entry * part).sum::<f64>();
                rows.iter_mut().zip(&*reflector).for_each(|(entry, part)| *entry -= sum * part);
            }
            // The same from the right: columns `at + 1` on, all rows.
            sums.clear();
            sums.resize(size, 0.0);
            for (column, part) in right.chunks_exact(size).zip(&*reflector) {
                sums.iter_mut().zip(column).for_each(|(sum, entry)| *sum += part * entry);
            }
            for (column, part) in right.chunks_exact_mut(size).zip(&*reflector) {
                column.iter_mut().zip(&*sums).for_each(|(entry, sum)| *entry -= share * part * sum);
            }
            reflector.fill(0.0);
            reflector[0] = head;
        }
    }

    /// Steps until the lowest one or two of the first `rows` rows are off; how many these were.
    fn take_off(&mut self, rows: usize, found: &mut Vec<(f64, f64)>) -> Option<usize> {
        let last = rows - 1;
        for step in 0..=STEPS_PER_ROW * rows.max(10) {
            let first = self.first_of_block(last);
            if first > 0 {
                *self.at_mut(first, first - 1) = 0.0;
            }
            if first == last {
                found.push((self.at(last, last), 0.0));
                return Some(1);
            }
            if first + 1 == last {
                found.extend(self.pair(first));
                return Some(2);
            }
            let shifts = self.shifts(first, last, step);
            self.chase(first, last, shifts);
        }
        None
    }

    /// The first row of the block that ends with `last`: above it, the subdiagonal is nothing.
    fn first_of_block(&self, last: usize) -> usize {
        let mut row = last;
        while row > 0 {
            let (above, here) = (self.at(row - 1, row - 1), self.at(row, row));
            let below = self.at(row, row - 1).abs();
            if below <= NOTHING {
                break;
            }
            let mut near = above.abs() + here.abs();
            if near == 0.0 {
                near += if row > 1 { self.at(row - 1, row - 2).abs() } else { 0.0 };
                near += if row < last { self.at(row + 1, row).abs() } else { 0.0 };
            }
            if below <= f64::EPSILON * near {
                let beside = self.at(row - 1, row).abs();
                let (large, small) = (below.max(beside), below.min(beside));
                let difference = (above - here).abs();
                let (far, close) = (here.abs().max(difference), here.abs().min(difference));
                let sum = far + large;
                if small * (large / sum) <= NOTHING.max(f64::EPSILON * (close * (far / sum))) {
                    break;
                }
            }
            row -= 1;
        }
        row
    }

    /// The eigenvalues of two rows.
    fn pair(&self, first: usize) -> [(f64, f64); 2] {
        let (a, b) = (self.at(first, first), self.at(first, first + 1));
        let (c, d) = (self.at(first + 1, first), self.at(first + 1, first + 1));
        let (half, product) = (0.5 * (a - d), b * c);
        let inside = half * half + product;
        if inside < 0.0 {
            let (middle, difference) = (d + half, (-inside).sqrt());
            return [(middle, difference), (middle, -difference)];
        }
        let far = half + inside.sqrt().copysign(half);
        let near = if far == 0.0 { 0.0 } else { product / far };
        [(d + far, 0.0), (d - near, 0.0)]
    }

    /// Two shifts as (real, real, squared imaginary): the eigenvalues of the last two rows, or after a standstill others.
    fn shifts(&self, first: usize, last: usize, step: usize) -> [f64; 3] {
        let exceptional = |corner: f64, sum: f64| [corner + 0.75 * sum, -0.4375 * sum, sum, corner + 0.75 * sum];
        let [a, b, c, d] = match step {
            _ if step > 0 && step.is_multiple_of(2 * STANDSTILL) => {
                exceptional(self.at(last, last), self.at(last, last - 1).abs() + self.at(last - 1, last - 2).abs())
            }
            _ if step > 0 && step.is_multiple_of(STANDSTILL) => exceptional(
                self.at(first, first),
                self.at(first + 1, first).abs() + self.at(first + 2, first + 1).abs(),
            ),
            _ => [self.at(last - 1, last - 1), self.at(last - 1, last), self.at(last, last - 1), self.at(last, last)],
        };
        let middle = 0.5 * (a + d);
        let inside = 0.25 * (a - d) * (a - d) + b * c;
        if inside < 0.0 {
            return [middle, middle, -inside];
        }
        // Two real ones: twice that which is nearer to the last entry.
        let root = inside.sqrt();
        let near = if (middle + root - d).abs() <= (middle - root - d).abs() { middle + root } else { middle - root };
        [near, near, 0.0]
    }

    /// One double-shift step on the rows from `first` to `last`.
    fn chase(&mut self, first: usize, last: usize, [one, other, squared]: [f64; 3]) {
        let (start, head) = self.start(first, last, [one, other, squared]);
        let mut bulge = head;
        for row in start..last {
            let three = row + 2 <= last;
            if row > start {
                bulge = [
                    self.at(row, row - 1),
                    self.at(row + 1, row - 1),
                    if three { self.at(row + 2, row - 1) } else { 0.0 },
                ];
            }
            let reflected = reflect(&mut bulge);
            if row > start {
                *self.at_mut(row, row - 1) = reflected.map_or(bulge[0], |(head, _)| head);
                *self.at_mut(row + 1, row - 1) = 0.0;
                if three {
                    *self.at_mut(row + 2, row - 1) = 0.0;
                }
            }
            let Some((_, share)) = reflected else { continue };
            if row == start && start > first {
                *self.at_mut(row, row - 1) *= 1.0 - share;
            }
            if three {
                self.turn::<3>(row, [first, last], bulge, share);
            } else {
                self.turn::<2>(row, [first, last], [bulge[0], bulge[1]], share);
            }
        }
    }

    /// Where a step starts, and the first column that its shifts make there: below two small subdiagonals one after the other.
    fn start(&self, first: usize, last: usize, [one, other, squared]: [f64; 3]) -> (usize, [f64; 3]) {
        let imaginary = squared.sqrt();
        let mut row = last - 2;
        loop {
            let (here, next, below) = (self.at(row, row), self.at(row + 1, row + 1), self.at(row + 1, row));
            let size = (here - other).abs() + imaginary + below.abs();
            let share = below / size;
            let mut head = [
                share * self.at(row, row + 1) + (here - one) * ((here - other) / size) + imaginary * (imaginary / size),
                share * (here + next - one - other),
                share * self.at(row + 2, row + 1),
            ];
            let size = head.iter().map(|entry| entry.abs()).sum::<f64>();
            head.iter_mut().for_each(|entry| *entry /= size);
            if row == first {
                return (row, head);
            }
            let above = self.at(row - 1, row - 1).abs();
            let small = self.at(row, row - 1).abs() * (head[1].abs() + head[2].abs());
            if small <= f64::EPSILON * head[0].abs() * (above + here.abs() + next.abs()) {
                return (row, head);
            }
            row -= 1;
        }
    }

    /// Reflects `COUNT` rows from `row` on, and the columns of the same numbers, within the block.
    #[inline(always)]
    fn turn<const COUNT: usize>(&mut self, row: usize, [first, last]: [usize; 2], reflector: [f64; COUNT], share: f64) {
        let size = self.size;
        let scaled = reflector.map(|part| share * part);
        for column in self.entries[row * size..(last + 1) * size].chunks_exact_mut(size) {
            let Some(rows) = column[row..].first_chunk_mut::<COUNT>() else { continue };
            let sum = (1..COUNT).fold(rows[0], |sum, at| sum + reflector[at] * rows[at]);
            (0..COUNT).for_each(|at| rows[at] -= sum * scaled[at]);
        }
        let end = (row + COUNT).min(last) + 1;
        let (head, rest) = self.entries[row * size..(row + COUNT) * size].split_at_mut(size);
        let head = &mut head[first..end];
        match (rest.split_at_mut(size), COUNT) {
            ((next, after), 3) => {
                let rows = head.iter_mut().zip(&mut next[first..end]).zip(&mut after[first..end]);
                for ((one, two), three) in rows {
                    let sum = *one + reflector[1] * *two + reflector[2] * *three;
                    *one -= sum * scaled[0];
                    *two -= sum * scaled[1];
                    *three -= sum * scaled[2];
                }
            }
            ((next, _), _) => {
                for (one, two) in head.iter_mut().zip(&mut next[first..end]) {
                    let sum = *one + reflector[1] * *two;
                    *one -= sum * scaled[0];
                    *two -= sum * scaled[1];
                }
            }
        }
    }
}

/// Turns a vector into the reflector 1 − share·v·vᵀ, v₀ = 1, that clears all of it but its head: the new head and the share; nothing where
/// there is nothing to clear.
#[inline(always)]
fn reflect(vector: &mut [f64]) -> Option<(f64, f64)> {
    let head = vector[0];
    let rest = vector[1..].iter().map(|entry| entry * entry).sum::<f64>();
    if rest == 0.0 {
        return None;
    }
    let turned = -(head * head + rest).sqrt().copysign(head);
    let scale = 1.0 / (head - turned);
    vector[1..].iter_mut().for_each(|entry| *entry *= scale);
    vector[0] = 1.0;
    Some((turned, (turned - head) / turned))
}
