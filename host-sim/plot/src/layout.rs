//! Layout: from a figure to a sheet.
//!
//! All frames of a sheet are equally large. A column is as far from its left neighbour as its own tick texts and label need; a row is as
//! high as its headings and axis texts need. In a row that shares its vertical axis only the first panel carries its texts; of panels
//! below each other with the same horizontal axis only the lowest does. If a legend would cover data, every vertical range of its group
//! found from data is widened upwards once, until the legend is clear; a legend that would take more than a third of its panel, that is
//! wider than its panel, or that covers data in a range that was given, stands below all panels instead: of several, each under its axis'
//! name. Where panels would be narrow, fewer stand beside each other, unless a row shares its axis.

use super::error::Cause;
use super::range::{self, Axes};
use super::scale::Scale;
use super::sheet::{Anchor, Frame, INK, LEAST, Mark, Print, Sheet, TICK, Text};
use super::{Figure, Panel, ShareY, data, font, legend, panel};

const MARGIN: f64 = 26.0;
const TITLE: f64 = 30.0;
const HEADING: f64 = 23.0;
const LABEL: f64 = 22.0;
const CAPTION: f64 = 21.0;
/// From one base line to the next, as a multiple of the em.
const LEADING: f64 = 1.3;
/// Between two frames side by side, and two rows.
const GAP: f64 = 46.0;
/// Width of a sheet for each of its columns of panels, with what stands around them, where it is free to have fewer.
const NARROWEST: f64 = 330.0;
/// Share of a panel that a legend may take above the data.
const TALL: f64 = 1.0 / 3.0;

/// The figure as marks in pixels.
pub(crate) fn sheet(figure: &Figure, print: Print) -> Result<Sheet, Cause> {
    let width = print.pixels();
    let axes = range::resolve(figure);
    // Legends that stand below all panels.
    let needs_room = needs(figure, &axes, width).into_iter().zip(&axes);
    let tall: Vec<bool> = needs_room.map(|(need, axes)| need > if axes.y_auto { TALL } else { 0.0 }).collect();
    let axes = with_headroom(figure, axes, &tall, width);
    let mut writer = Writer(Vec::new());
    let mut top = MARGIN;
    for line in font::wrap(&figure.title, TITLE, width - 2.0 * MARGIN) {
        top += LEADING * TITLE;
        writer.text((width / 2.0, top - 12.0), Anchor::Middle, TITLE, &line);
    }
    let (slots, bottom) = slots(figure, &axes, top, width);
    for (((panel, axes), slot), tall) in figure.panels.iter().zip(&axes).zip(&slots).zip(&tall) {
        let x_grid: Vec<f64> = slot.x_ticks.iter().map(|(v, _)| *v).filter(|_| panel.categories.is_empty()).collect();
        let y_grid: Vec<f64> = slot.y_ticks.iter().map(|(v, _)| *v).collect();
        let drawing = panel::draw(panel, axes, &slot.frame, &x_grid, &y_grid);
        writer.0.extend(drawing.marks);
        // The note stays with its panel.
        let inside = if *tall { &Panel { series: Vec::new(), ..panel.clone() } } else { panel };
        if let Some(spot) = legend::place(inside, &slot.frame, &drawing.obstacles) {
            writer.0.extend(legend::marks(inside, &slot.frame, spot.area));
        }
        writer.around(axes, slot);
    }
    let mut base = bottom + 6.0;
    let below =
        figure.panels.iter().zip(&tall).filter(|(panel, tall)| **tall && legend::labelled(panel).next().is_some());
    let below: Vec<&Panel> = below.map(|(panel, _)| panel).collect();
    for panel in &below {
        let name = if below.len() > 1 { &*panel.y_label } else { "" };
        let (marks, end) = legend::below(panel, name, base, (MARGIN, width - MARGIN));
        writer.0.extend(marks);
        base = end + 6.0;
    }
    for line in font::wrap(&figure.caption, CAPTION, width - 2.0 * MARGIN) {
        base += LEADING * CAPTION;
        writer.text((MARGIN, base), Anchor::Start, CAPTION, &line);
    }
    let widths: Vec<f64> = slots.iter().map(|slot| slot.frame.width()).collect();
    let (title, caption, data) = (figure.title.clone(), figure.caption.clone(), data::csv(figure, &axes, &widths)?);
    Ok(Sheet { width, width_mm: print.width_mm, height: (base + MARGIN).ceil(), title, caption, data, marks: writer.0 })
}

/// Where one panel lies and what stands around it.
#[derive(Default)]
struct Slot {
    frame: Frame,
    /// Values and the lines of their texts.
    x_ticks: Vec<(f64, Vec<String>)>,
    /// The horizontal axis has names that are too long to stand side by side.
    names_upward: bool,
    y_ticks: Vec<(f64, String)>,
    heading: Vec<String>,
    /// Lines of the labels along the axes.
    x_label: Vec<String>,
    y_label: Vec<String>,
    /// The left edge of the column's texts, so that labels below each other line up.
    label_left: f64,
    shows_x: bool,
    shows_y: bool,
}

impl Slot {
    fn below(&self) -> f64 {
        let lines = |(_, lines): &(f64, Vec<String>)| LEADING * TICK * lines.len() as f64;
        let longest = |(_, lines): &(f64, Vec<String>)| widest(lines, TICK) + 8.0;
        let ticks = self.x_ticks.iter().map(|tick| if self.names_upward { longest(tick) } else { lines(tick) });
        if self.shows_x { 8.0 + ticks.fold(0.0, f64::max) + room(&self.x_label) } else { 0.0 }
    }

    fn beside(&self) -> f64 {
        let widths = self.y_ticks.iter().map(|(_, text)| font::width(text, TICK));
        if self.shows_y { 10.0 + widths.fold(0.0, f64::max) + room(&self.y_label) } else { 0.0 }
    }
}

fn room(label: &[String]) -> f64 {
    if label.is_empty() { 0.0 } else { LEADING * LABEL * label.len() as f64 + 4.0 }
}

/// All panels' slots, the first row starting at `top`, and where the last row ends.
fn slots(figure: &Figure, axes: &[Axes], mut top: f64, width: f64) -> (Vec<Slot>, f64) {
    let count = figure.panels.len();
    let fitting = if figure.share_y == ShareY::Rows { count } else { (width / NARROWEST) as usize };
    let columns = figure.columns.min(fitting).clamp(1, count.max(1));
    let rows = count.div_ceil(columns);
    let room = width - 2.0 * MARGIN - GAP * columns as f64;
    let height = (room / columns as f64 * if rows > 1 { 0.62 } else { 0.74 }).clamp(250.0, 640.0).round();

    let mut slots: Vec<Slot> = figure
        .panels
        .iter()
        .zip(axes)
        .enumerate()
        .map(|(i, (panel, axis))| {
            let left =
                (figure.share_y != ShareY::None && i % columns > 0).then(|| (&figure.panels[i - 1], &axes[i - 1]));
            let below = figure.panels.get(i + columns).zip(axes.get(i + columns));
            let repeats_y = left.is_some_and(|(p, a)| a.y == axis.y && p.y_label == panel.y_label);
            let repeats_x = below
                .is_some_and(|(p, a)| a.x == axis.x && p.x_label == panel.x_label && p.categories == panel.categories);
            Slot {
                y_ticks: axis.y.ticks((height / 58.0) as usize),
                y_label: font::wrap(&panel.y_label, LEAST, height),
                shows_x: !repeats_x,
                shows_y: !repeats_y,
                ..Slot::default()
            }
        })
        .collect();

    let beside: Vec<f64> = (0..columns)
        .map(|column| slots.iter().skip(column).step_by(columns).map(Slot::beside).fold(0.0, f64::max))
        .collect();
    let width = ((room - beside.iter().sum::<f64>()) / columns as f64).max(60.0);
    // With what stands beside the frames known, so is the room for texts above and below them.
    for ((slot, panel), axis) in slots.iter_mut().zip(&figure.panels).zip(axes) {
        (slot.x_ticks, slot.names_upward) = x_ticks(panel, &axis.x, width);
        slot.heading = font::wrap(&panel.title, HEADING, width + GAP - 10.0);
        slot.x_label = font::wrap(&panel.x_label, LEAST, width);
    }
    for (row, slots) in slots.chunks_mut(columns).enumerate() {
        let heading = slots.iter().map(|s| s.heading.len()).max().unwrap_or(0) as f64;
        top += if row == 0 { 6.0 } else { 0.0 } + LEADING * HEADING * heading + 8.0;
        for (column, slot) in slots.iter_mut().enumerate() {
            let before: f64 = beside.iter().take(column + 1).sum();
            let left = (MARGIN + before + (width + GAP) * column as f64).round();
            slot.label_left = left - beside.get(column).copied().unwrap_or(0.0);
            slot.frame = Frame { left, top: top.round(), right: (left + width).round(), bottom: top.round() + height };
        }
        let below = slots.iter().map(Slot::below).fold(0.0, f64::max);
        top = top.round() + height + below + if row + 1 < rows { GAP / 2.0 } else { 0.0 };
    }
    (slots, top)
}

/// The width of the widest of these lines.
fn widest(lines: &[String], size: f64) -> f64 {
    lines.iter().map(|line| font::width(line, size)).fold(0.0, f64::max)
}

/// Ticks of a horizontal axis, as many as their texts leave room for; or its categories, and whether these are written upwards because
/// they do not fit side by side.
fn x_ticks(panel: &Panel, scale: &Scale, width: f64) -> (Vec<(f64, Vec<String>)>, bool) {
    if !panel.categories.is_empty() {
        let limit = width / panel.categories.len() as f64 - 10.0;
        let names = |wrap: &dyn Fn(&String) -> Vec<String>| -> Vec<(f64, Vec<String>)> {
            panel.categories.iter().enumerate().map(|(i, name)| (i as f64, wrap(name))).collect()
        };
        let side_by_side = names(&|name| font::wrap(name, TICK, limit));
        return if side_by_side.iter().all(|(_, lines)| widest(lines, TICK) <= limit) {
            (side_by_side, false)
        } else {
            (names(&|name| vec![name.clone()]), true)
        };
    }
    let fits = |ticks: &Vec<(f64, String)>| {
        let at = |v: f64| scale.fraction(v) * width;
        ticks.windows(2).all(|pair| {
            let half: f64 = pair.iter().map(|(_, text)| font::width(text, TICK) / 2.0).sum();
            at(pair[1].0) - at(pair[0].0) > half + 16.0
        })
    };
    let most = (width / 75.0).min(12.0) as usize;
    // Of those of a logarithmic axis, which has fewest to a decade, every other or third may fit.
    let thinned = |every: usize| (2..=most.max(2)).rev().map(move |count| (count, every));
    let some = |(count, every)| scale.ticks(count).into_iter().step_by(every).collect::<Vec<_>>();
    let ticks = (1..4).flat_map(thinned).map(some).filter(|ticks| ticks.len() > 1).find(fits);
    // Where no two fit beside each other there is one.
    let ticks = ticks.unwrap_or_else(|| scale.ticks(1).into_iter().take(1).collect());
    (ticks.into_iter().map(|(v, text)| (v, vec![text])).collect(), false)
}

/// The height of its panel that each legend needs above the data, as a fraction; 0 where it finds room between them, without end where its
/// panel is too narrow.
fn needs(figure: &Figure, axes: &[Axes], width: f64) -> Vec<f64> {
    let (slots, _) = slots(figure, axes, 0.0, width);
    let need = |((panel, axes), slot): ((&Panel, &Axes), &Slot)| {
        let drawing = panel::draw(panel, axes, &slot.frame, &[], &[]);
        if legend::is_wide(panel, &slot.frame) {
            return f64::INFINITY;
        }
        let covers = legend::place(panel, &slot.frame, &drawing.obstacles).is_some_and(|spot| spot.covered > 0);
        if covers && !panel.off_scale { legend::headroom(panel, &slot.frame) } else { 0.0 }
    };
    figure.panels.iter().zip(axes).zip(&slots).map(need).collect()
}

/// The axes, with room made above the data where a legend would cover them.
fn with_headroom(figure: &Figure, axes: Vec<Axes>, tall: &[bool], width: f64) -> Vec<Axes> {
    let needs = needs(figure, &axes, width).into_iter().zip(tall).map(|(need, tall)| if *tall { 0.0 } else { need });
    let needs: Vec<f64> = needs.collect();
    let widened = |axis: &Axes| {
        let group = axes.iter().zip(&needs).filter(|(a, _)| a.y_auto && a.y_group == axis.y_group && a.y == axis.y);
        let need = group.map(|(_, need)| *need).fold(0.0, f64::max);
        if axis.y_auto && need > 0.0 { Axes { y: axis.y.widened(0.0, need / (1.0 - need)), ..*axis } } else { *axis }
    };
    axes.iter().map(widened).collect()
}

struct Writer(Vec<Mark>);

impl Writer {
    fn text(&mut self, at: (f64, f64), anchor: Anchor, size: f64, text: &str) {
        if !text.is_empty() {
            self.0.push(Mark::text(at, anchor, size, INK, text));
        }
    }

    fn upward(&mut self, at: (f64, f64), anchor: Anchor, size: f64, text: &str) {
        self.0.push(Mark::Text(Text { at, anchor, size, color: INK, upward: true, text: text.to_owned() }));
    }

    /// Heading, tick texts and labels around a frame.
    fn around(&mut self, axes: &Axes, slot: &Slot) {
        let frame = &slot.frame;
        let centre = (frame.left + frame.right) / 2.0;
        for (i, line) in slot.heading.iter().rev().enumerate() {
            self.text((centre, frame.top - 10.0 - LEADING * HEADING * i as f64), Anchor::Middle, HEADING, line);
        }
        if slot.shows_x {
            for (value, lines) in &slot.x_ticks {
                let x = frame.left + axes.x.fraction(*value) * frame.width();
                for (i, line) in lines.iter().enumerate() {
                    if slot.names_upward {
                        self.upward((x + 0.35 * TICK, frame.bottom + 8.0), Anchor::End, TICK, line);
                        continue;
                    }
                    let y = frame.bottom + 6.0 + TICK + LEADING * TICK * i as f64;
                    self.text((x, y), Anchor::Middle, TICK, line);
                }
            }
            let (last, size) = (frame.bottom + slot.below() - 6.0, fitted(&slot.x_label, frame.width()));
            for (i, line) in slot.x_label.iter().rev().enumerate() {
                self.text((centre, last - LEADING * LABEL * i as f64), Anchor::Middle, size, line);
            }
        }
        if slot.shows_y {
            for (value, text) in &slot.y_ticks {
                let y = frame.bottom - axes.y.fraction(*value) * frame.height();
                self.text((frame.left - 10.0, y + 0.35 * TICK), Anchor::End, TICK, text);
            }
            let (middle, size) = ((frame.top + frame.bottom) / 2.0, fitted(&slot.y_label, frame.height()));
            for (i, line) in slot.y_label.iter().enumerate() {
                let at = (slot.label_left + LABEL - 2.0 + LEADING * LABEL * i as f64, middle);
                self.upward(at, Anchor::Middle, size, line);
            }
        }
    }
}

/// The size at which every line of a label fits along its axis, as far as it can be read.
fn fitted(label: &[String], length: f64) -> f64 {
    (LABEL * (length / widest(label, LABEL).max(1.0)).min(1.0)).max(LEAST)
}
