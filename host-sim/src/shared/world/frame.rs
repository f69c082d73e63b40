//! Vectors in the plane, and a line as seen from its free side.

/// Along x and y.
pub(super) type Vector = [f64; 2];

pub(super) fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn minus(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1]]
}

/// A line with a free side on its left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    pub(super) from: Vector,
    pub(super) along: Vector,
    /// To the free side.
    pub(super) out: Vector,
    pub(super) length: f64,
}

impl Frame {
    pub(super) fn new(from: [f32; 2], to: [f32; 2]) -> Self {
        let from = from.map(f64::from);
        let way = minus(to.map(f64::from), from);
        let length = libm::sqrt(dot(way, way));
        let along = way.map(|part| part / length);
        Self { from, along, out: [-along[1], along[0]], length }
    }

    /// How far along the line and how far out a point is, m.
    pub(super) fn local(&self, point: Vector) -> Vector {
        let from = minus(point, self.from);
        [dot(from, self.along), dot(from, self.out)]
    }
}
