//! Figures: declared as data, drawn once, written as SVG, PDF and PNG.
//!
//! A [`Figure`] is a grid of [`Panel`]s, a panel holds [`Series`]. [`draw`] lays the figure out into a list of marks
//! (`layout`; it asks `range` and `scale` for axes and ticks, `panel` for the shapes inside a frame, `legend` for free
//! space) and paints the same marks three times (`svg`, `pdf`, `png`). The sheet is as wide as [`Print`] asks, a column of a journal unless
//! it asks, and as high as its rows need; letters are 6 pt and larger on paper. SVG and PDF carry the figure's data (`data`) and what made it.
//!
//! Axes: a range that is given is kept; any other is found from the finite data in view, on a logarithmic axis from the positive ones.
//! Panels that share an axis get the union of their ranges, except [`Panel::off_scale`] ones, which are drawn until they have left the
//! frame: one run that diverges does not flatten the others. Texts that a neighbour repeats are left out.
//!
//! In all texts `K_T` is written with an index and `10^3` with a power.
//!
//! Limits: points are drawn in the order given, at most two for each column of pixels that they pass (the extremes, so
//! the envelope is exact to one pixel). Letters come from one built-in font (Latin, Greek, common signs); in an SVG the
//! viewer's own font is fitted to the same widths.

mod data;
mod error;
mod font;
mod layout;
mod legend;
mod panel;
mod pdf;
mod png;
mod range;
mod scale;
mod sheet;
mod svg;
mod trace;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use cohold_io::Kind;

pub use cohold_io::significant;
pub use error::Error;
pub use sheet::{Dash, PALETTE, Print};

/// Columns of the table that a figure carries, by name and meaning.
pub const DATA_COLUMNS: [(&str, &str); 7] = [
    ("panel", "number of the panel, from 1; what its axes are stands above the table"),
    ("series", "what the legend calls it"),
    ("name", "name of a dot or a category"),
    ("x", "in the unit of the horizontal axis"),
    ("y", "in the unit of the vertical axis"),
    ("low", "lower edge of an interval or a region, in the unit of y"),
    ("high", "upper edge of an interval or a region, in the unit of y"),
];

/// A sheet of panels with a title above and a caption below.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Figure {
    /// Heading of the sheet; empty for none.
    pub title: String,
    /// What the reader should see, in sentences; wrapped below the panels.
    pub caption: String,
    /// Panels in one row of the grid; 0 counts as 1.
    pub columns: usize,
    /// Whether all panels have the same horizontal range.
    pub share_x: bool,
    /// The panels that have a common vertical range.
    pub share_y: ShareY,
    /// The panels, row by row.
    pub panels: Vec<Panel>,
}

/// The panels of a figure that have a common vertical range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShareY {
    /// Each panel has its own.
    #[default]
    None,
    /// The panels of one row: the same quantity, several systems side by side.
    Rows,
    /// All panels of the figure.
    All,
}

/// One pair of axes with its series.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Panel {
    /// Heading of the panel; empty for none.
    pub title: String,
    /// Quantity and unit of the horizontal axis, for example `Time (s)`.
    pub x_label: String,
    /// Quantity and unit of the vertical axis.
    pub y_label: String,
    /// Horizontal range; found from the data when absent.
    pub x_range: Option<(f64, f64)>,
    /// Vertical range; found from the data in view when absent.
    pub y_range: Option<(f64, f64)>,
    /// Logarithmic horizontal axis; values that are not positive are not drawn.
    pub log_x: bool,
    /// Logarithmic vertical axis; values that are not positive are not drawn.
    pub log_y: bool,
    /// The data do not take part in finding a shared range, and lines end where they are a frame's height outside: for
    /// a run that diverges. Say so in `note`.
    pub off_scale: bool,
    /// A remark written into the panel, for example `diverges`.
    pub note: Option<String>,
    /// Names of the positions 0, 1, 2… of the horizontal axis, for bars; empty for an axis of numbers.
    pub categories: Vec<String>,
    /// The data; later series lie on top of earlier ones.
    pub series: Vec<Series>,
}

/// Data of one kind and colour.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty for no entry.
    pub label: String,
    /// Number of the colour in [`PALETTE`], which is used cyclically.
    pub color: usize,
    /// Width of its lines, pixels of the sheet: a ninth of a millimetre each.
    pub width: f64,
    /// Kind of mark, with its points.
    pub shape: Shape,
}

/// What a series looks like. Points are (x, y) in the units of the axes. In a line NaN leaves a gap and an infinite y
/// leaves through the edge.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// Points joined by straight lines.
    Line {
        /// The points.
        points: Vec<(f64, f64)>,
        /// Solid or broken.
        dash: Dash,
    },
    /// Separate dots, each with its own name if there is one.
    Dots {
        /// The points.
        points: Vec<(f64, f64)>,
        /// Names written beside the dots, in the same order; may be empty or shorter.
        names: Vec<String>,
    },
    /// Separate rings: what is there but does not count, so that no colour has to tell.
    Rings(Vec<(f64, f64)>),
    /// Bars from zero to y, at x = number of the category, with the value written at the end. Bars of several series
    /// at the same x stand side by side.
    Bars(Vec<(f64, f64)>),
    /// Values with half of an interval each, (x, y, within): a dot, and a stroke from y − within to y + within.
    Intervals(Vec<(f64, f64, f64)>),
    /// A tinted region, in pieces that do not overlap.
    Region(Vec<Strip>),
}

/// A piece of a region between two upright sides: x, lower and upper edge of each. The edges between them are straight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Strip {
    /// Left side: x, lower and upper edge.
    pub left: (f64, f64, f64),
    /// Right side: x, lower and upper edge.
    pub right: (f64, f64, f64),
}

impl Series {
    /// A solid line through these points.
    pub fn line(label: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self::dashed(label, color, Dash::Solid, points)
    }

    /// A line with this dash.
    pub fn dashed(label: impl Into<String>, color: usize, dash: Dash, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, color, Shape::Line { points, dash })
    }

    /// Dots with the names in `names` beside them.
    pub fn dots(label: impl Into<String>, color: usize, points: Vec<(f64, f64)>, names: Vec<String>) -> Self {
        Self::new(label, color, Shape::Dots { points, names })
    }

    /// Rings around nothing, for points that do not count.
    pub fn rings(label: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, color, Shape::Rings(points))
    }

    /// Values with their intervals: (x, y, half of the interval).
    pub fn intervals(label: impl Into<String>, color: usize, points: Vec<(f64, f64, f64)>) -> Self {
        Self::new(label, color, Shape::Intervals(points))
    }

    /// Bars at the positions of [`Panel::categories`].
    pub fn bars(label: impl Into<String>, color: usize, points: Vec<(f64, f64)>) -> Self {
        Self::new(label, color, Shape::Bars(points))
    }

    /// A tinted region of these strips.
    pub fn region(label: impl Into<String>, color: usize, strips: Vec<Strip>) -> Self {
        Self::new(label, color, Shape::Region(strips))
    }

    /// As wide as this, where it is a line: wide ones below and narrow ones above show all of several lines that lie on each other.
    #[must_use]
    pub fn wide(mut self, width: f64) -> Self {
        self.width = width;
        self
    }

    fn new(label: impl Into<String>, color: usize, shape: Shape) -> Self {
        Self { label: label.into(), color, width: panel::STROKE, shape }
    }
}

/// A figure painted: the ending of a file and what is in it, as SVG, PDF and PNG. The first two carry `about`: what made it.
///
/// # Errors
/// What the painter could not draw.
pub fn paint(figure: &Figure, print: Print, about: &str) -> Result<[(&'static str, Vec<u8>); 3], Error> {
    let sheet = layout::sheet(figure, print)?;
    Ok([
        ("svg", svg::render(&sheet, about).into_bytes()),
        ("pdf", pdf::render(&sheet, about)?),
        ("png", png::render(&sheet)?),
    ])
}

/// Draws the figure to `base` with `.svg`, `.pdf` and `.png` appended, creating the folder if needed. Returns their paths.
///
/// # Errors
/// A file cannot be written, or the painter could not draw.
pub fn draw(figure: &Figure, base: &Path) -> Result<Vec<PathBuf>, Error> {
    let painted = paint(figure, Print::default(), "").map_err(Error::write(base, "a figure"))?;
    let write = |(ending, bytes): (&'static str, Vec<u8>)| {
        // Appended, not replaced: the base may contain a dot (`fig.6`).
        let mut name = OsString::from(base);
        name.push(format!(".{ending}"));
        let path = PathBuf::from(name);
        write_file(&path, ending, &bytes, Kind::Named).map(|()| path)
    };
    painted.into_iter().map(write).collect()
}

/// Writes a file whole or not at all, its folder made if needed.
///
/// # Errors
/// The file or its folder cannot be written, or what is there may not be written over.
pub fn write_file(path: &Path, format: &'static str, bytes: &[u8], kind: Kind) -> Result<(), Error> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let written = std::fs::create_dir_all(folder).and_then(|()| cohold_io::write(path, bytes, kind));
    written.map_err(Error::write(path, format))
}

#[cfg(test)]
#[path = "../tests/inside/root.rs"]
mod tests;
