//! The sheet: a figure after layout, as a list of marks in pixels.
//!
//! This list is all that the painters see, so SVG, PDF and PNG cannot differ in what they show. The origin is the top left
//! corner, y grows downwards. Marks are painted in order. Everything in them is finite.

/// A position on the sheet in pixels.
pub(crate) type Point = (f64, f64);

/// Red, green and blue.
pub(crate) type Rgb = (u8, u8, u8);

/// Width of a sheet for a page of a journal, pixels.
const WIDTH: f64 = 1600.0;

/// Width of a page of a journal, mm.
const PAGE_MM: f64 = 180.0;

/// Em of the letters at the ticks, in pixels: what a size in points is of.
pub(crate) const TICK: f64 = 22.0;

/// Em of the smallest letters, indices and powers included, in pixels: 6 points where letters at the ticks have 7. Less is hard to
/// read in print.
pub(crate) const LEAST: f64 = 18.9;

/// Millimetres in a point.
const MM_PER_PT: f64 = 25.4 / 72.0;

/// How a figure is to be printed: what is narrower or has larger letters is laid out anew and not scaled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Print {
    /// Width, mm: 88 is a column of most journals, 180 a page.
    pub width_mm: f64,
    /// Size of the letters at the ticks, points; others are in proportion.
    pub font_pt: f64,
}

/// A column of a journal: what is read there is read on a page and on a screen.
impl Default for Print {
    fn default() -> Self {
        Self { width_mm: 88.0, font_pt: TICK * PAGE_MM / (MM_PER_PT * WIDTH) }
    }
}

impl Print {
    /// Width of its sheet, pixels.
    pub(crate) fn pixels(self) -> f64 {
        (self.width_mm * TICK / (self.font_pt * MM_PER_PT)).round()
    }
}

/// The colours of series: Okabe and Ito's palette, which colour-blind readers can tell apart, strongest first.
pub const PALETTE: [(u8, u8, u8); 8] = [
    (0, 114, 178),   // blue
    (213, 94, 0),    // vermillion
    (0, 158, 115),   // green
    (204, 121, 167), // purple
    (230, 159, 0),   // orange
    (86, 180, 233),  // sky blue
    (30, 30, 30),    // black
    (240, 228, 66),  // yellow: weak on white, for regions
];

/// Colour of letters and frames.
pub(crate) const INK: Rgb = (25, 25, 25);
/// Colour of the lines at labelled ticks.
pub(crate) const GRID: Rgb = (222, 222, 222);
/// Colour of the lines at the ticks between them.
pub(crate) const FAINT: Rgb = (240, 240, 240);
/// Colour of the sheet.
pub(crate) const PAPER: Rgb = (255, 255, 255);
/// Colour of remarks in panels.
pub(crate) const ALERT: Rgb = (180, 60, 0);

/// The colour with this number, cyclically.
pub(crate) fn color(index: usize) -> Rgb {
    PALETTE[index % PALETTE.len()]
}

/// How a line is broken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Dash {
    /// A line without gaps.
    #[default]
    Solid,
    /// A line of long strokes.
    Dashed,
    /// A line of dots.
    Dotted,
    /// Long strokes and dots in turn.
    DashDot,
}

impl Dash {
    /// Lengths of strokes and gaps in turn, in pixels; empty for a solid line.
    pub(crate) fn pattern(self) -> &'static [f64] {
        match self {
            Self::Solid => &[],
            Self::Dashed => &[12.0, 7.0],
            Self::Dotted => &[3.0, 6.0],
            Self::DashDot => &[14.0, 6.0, 3.0, 6.0],
        }
    }
}

/// An upright rectangle: left, top, right, bottom.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Frame {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) right: f64,
    pub(crate) bottom: f64,
}

impl Frame {
    /// The rectangle of this size with this upper left corner.
    pub(crate) fn sized((left, top): Point, width: f64, height: f64) -> Self {
        Self { left, top, right: left + width, bottom: top + height }
    }

    pub(crate) fn width(&self) -> f64 {
        self.right - self.left
    }

    pub(crate) fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub(crate) fn contains(&self, (x, y): Point) -> bool {
        x >= self.left && x <= self.right && y >= self.top && y <= self.bottom
    }

    pub(crate) fn overlaps(&self, other: &Self) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    /// The rectangle with every side moved outwards by `by`.
    pub(crate) fn grown(&self, by: f64) -> Self {
        Self { left: self.left - by, top: self.top - by, right: self.right + by, bottom: self.bottom + by }
    }

    /// The corners, and the first of them again.
    pub(crate) fn outline(&self) -> Vec<Point> {
        [self.corners(), vec![(self.left, self.top)]].concat()
    }

    pub(crate) fn corners(&self) -> Vec<Point> {
        vec![(self.left, self.top), (self.right, self.top), (self.right, self.bottom), (self.left, self.bottom)]
    }
}

/// The part of a text that stands at its position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    /// How far before its position a text of this width starts.
    pub(crate) fn back(self, width: f64) -> f64 {
        match self {
            Self::Start => 0.0,
            Self::Middle => width / 2.0,
            Self::End => width,
        }
    }
}

/// A line of letters.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Text {
    /// A point of the base line.
    pub(crate) at: Point,
    pub(crate) anchor: Anchor,
    /// Height of the letters' em square.
    pub(crate) size: f64,
    pub(crate) color: Rgb,
    /// Written upwards instead of to the right.
    pub(crate) upward: bool,
    pub(crate) text: String,
}

/// One thing to paint.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Mark {
    Line {
        points: Vec<Point>,
        color: Rgb,
        width: f64,
        dash: Dash,
    },
    Fill {
        frame: Frame,
        color: Rgb,
        opacity: f64,
    },
    /// Pieces with upright sides that do not overlap, as one shape: upper left corner, upper right, lower right, lower left.
    Region {
        strips: Vec<[Point; 4]>,
        color: Rgb,
        opacity: f64,
    },
    Disc {
        at: Point,
        radius: f64,
        color: Rgb,
    },
    Text(Text),
}

impl Mark {
    /// A solid line.
    pub(crate) fn line(points: Vec<Point>, color: Rgb, width: f64) -> Self {
        Self::Line { points, color, width, dash: Dash::Solid }
    }

    /// A filled rectangle.
    pub(crate) fn fill(frame: Frame, color: Rgb, opacity: f64) -> Self {
        Self::Fill { frame, color, opacity }
    }

    /// A text to the right, the anchor of its base line at a point.
    pub(crate) fn text(at: Point, anchor: Anchor, size: f64, color: Rgb, text: &str) -> Self {
        Self::Text(Text { at, anchor, size, color, upward: false, text: text.to_owned() })
    }
}

/// A figure after layout.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Sheet {
    pub(crate) width: f64,
    /// Of the width when printed.
    pub(crate) width_mm: f64,
    pub(crate) height: f64,
    /// For readers that cannot see the picture.
    pub(crate) title: String,
    pub(crate) caption: String,
    /// What is drawn, as a table in the units of the axes.
    pub(crate) data: String,
    pub(crate) marks: Vec<Mark>,
}
