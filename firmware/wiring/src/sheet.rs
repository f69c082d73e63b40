//! Where everything goes on a drawing: parts in columns, wires in the channels between them.
//!
//! A net has one upright track in each channel that it crosses, and a level line to each of its pins there; where it passes a column
//! without a part of its own, a lane leads through below the parts. Pins of neighbouring columns stand on different rows, and each net
//! has a track of its own: so no two lines lie on each other, wherever they cross. A dot is a joint; lines that cross without one do
//! not touch. Names of rails, and of nets that go on on another sheet, stand at the pin.
//!
//! Units: a sheet is at most 1100 wide and 180 mm on paper, where letters of 13 are 6.0 pt.

use std::collections::BTreeSet;

use crate::netlist::{Is, Net, Netlist, Sheet, Symbol, split};

/// Height of letters, and that of the title.
pub const SIZE: f64 = 13.0;
/// See [`SIZE`].
pub const TITLE: f64 = 16.0;
/// The widest that a sheet may be: letters are 6 pt on 180 mm of paper.
pub const WIDEST: f64 = 1100.0;

/// Rows of pins, and what neighbouring columns differ by.
const ROW: f64 = 24.0;
const SHIFT: f64 = 6.0;
/// Between tracks, parts, and a pin and what is written at it.
const TRACK: f64 = 10.0;
const GAP: f64 = 22.0;
const STUB: f64 = 11.0;
/// Half of a symbol that has two ends.
const HALF: f64 = 22.0;

/// Which side of `x` a text is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(missing_docs, reason = "as in SVG")]
pub enum Anchor {
    Start,
    Middle,
    End,
}

/// A text, at the left, middle or right of its baseline.
#[derive(Clone, Debug)]
#[expect(missing_docs, reason = "x and y are where it is")]
pub struct Text {
    pub x: f64,
    pub y: f64,
    pub size: f64,
    pub anchor: Anchor,
    pub text: String,
}

impl Text {
    /// How wide it is at the most in the fonts that a page is shown in.
    pub fn width(&self) -> f64 {
        if self.is_bold() { bold(&self.text, self.size) } else { width(&self.text, self.size) }
    }

    /// Names of parts and the title are.
    pub fn is_bold(&self) -> bool {
        self.anchor == Anchor::Middle || self.size > SIZE
    }
}

/// A piece of a wire: level or upright.
#[derive(Clone, Debug)]
pub struct Line {
    /// From where to where.
    pub ends: [(f64, f64); 2],
    /// Of the net.
    pub colour: String,
}

/// A part: the frame of a box, or a symbol between two ends.
#[derive(Clone, Debug)]
pub struct Body {
    /// What it looks like.
    pub symbol: Symbol,
    /// Upper left corner, lower right one. Of a symbol: its ends.
    pub corners: [(f64, f64); 2],
    /// Its first end is on the right.
    pub turned: bool,
}

/// A drawing.
#[derive(Clone, Debug, Default)]
pub struct Drawing {
    /// Of the whole.
    pub size: (f64, f64),
    /// Where the pins are, by their names.
    pub pins: Vec<(String, (f64, f64))>,
    /// Parts.
    pub bodies: Vec<Body>,
    /// Wires.
    pub lines: Vec<Line>,
    /// Joints.
    pub dots: Vec<((f64, f64), String)>,
    /// Words.
    pub texts: Vec<Text>,
}

/// How wide a text is at the most: DejaVu Sans, the widest of the fonts that are asked for, rounded up.
pub fn width(text: &str, size: f64) -> f64 {
    let em = |sign: char| match sign {
        'i' | 'j' | 'l' | 'I' | 'J' => 0.3,
        ' ' | ',' | '.' | ':' | '-' | 'f' | 't' => 0.4,
        'r' | '(' | ')' => 0.42,
        's' | 'c' | 'z' | 'k' | 'v' | 'x' | 'y' | 'L' | 'F' => 0.6,
        'm' | 'W' => 0.99,
        'w' | 'M' | '+' => 0.87,
        'D' | 'G' | 'H' | 'N' | 'O' | 'Q' | 'U' | 'Ω' => 0.79,
        'A' | 'B' | 'C' | 'K' | 'R' | 'V' | 'X' | 'Z' => 0.7,
        _ => 0.64,
    };
    text.chars().map(em).sum::<f64>() * size
}

/// The same in bold letters, in which parts and titles are.
fn bold(text: &str, size: f64) -> f64 {
    1.12 * width(text, size)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// A pin on one side of a part.
struct Port {
    /// `PART.PIN`; of a lane: nothing.
    pin: String,
    side: Side,
    /// Inside the frame.
    label: String,
    /// At the end of the stub.
    beside: String,
    /// Number of the net, if it has a line here.
    net: Option<usize>,
    y: f64,
}

/// A part, or a lane that leads through a column.
struct Item {
    symbol: Option<Symbol>,
    called: String,
    ports: Vec<Port>,
    turned: bool,
    top: f64,
    bottom: f64,
}

/// Draws a sheet.
///
/// # Errors
/// A part of it is not of its build, or has no such pins.
pub fn draw(netlist: &Netlist, sheet: &Sheet) -> Result<Drawing, String> {
    let nets = netlist.nets(&sheet.build);
    let reach: Vec<Option<(usize, usize)>> = nets.iter().map(|net| reach(net, sheet)).collect();
    let mut columns = Vec::new();
    for (number, parts) in sheet.columns.iter().enumerate() {
        let mut column = Vec::new();
        for part in parts {
            if !netlist.has(&sheet.build, part) {
                return Err(format!("{}: {part} is not of this build", sheet.file));
            }
            column.push(item(netlist, sheet, &nets, &reach, number, part)?);
        }
        let passes = |(from, to): (usize, usize)| from < number && number < to;
        let lanes = reach.iter().enumerate().filter(|(_, reach)| reach.is_some_and(passes));
        column.extend(lanes.map(|(net, _)| lane(net)));
        columns.push(column);
    }
    let height = stack(&mut columns);
    Ok(put(&nets, &sheet.title, columns, height))
}

/// The columns from and to which a net is drawn with lines; nothing, if it is a rail or has one pin here.
fn reach(net: &Net, sheet: &Sheet) -> Option<(usize, usize)> {
    let column = |pin: &String| sheet.columns.iter().position(|parts| parts.iter().any(|part| part == split(pin).0));
    let columns: Vec<usize> = net.pins.iter().filter_map(column).collect();
    let (from, to) = (*columns.iter().min()?, *columns.iter().max()?);
    (!net.rail && columns.len() > 1).then_some((from, to))
}

fn lane(net: usize) -> Item {
    let port =
        |side| Port { pin: String::new(), side, label: String::new(), beside: String::new(), net: Some(net), y: 0.0 };
    let ports = vec![port(Side::Left), port(Side::Right)];
    Item { symbol: None, called: String::new(), ports, turned: false, top: 0.0, bottom: 0.0 }
}

/// A part with those of its pins that belong on this sheet.
fn item(
    netlist: &Netlist,
    sheet: &Sheet,
    nets: &[Net],
    reach: &[Option<(usize, usize)>],
    column: usize,
    part: &str,
) -> Result<Item, String> {
    let (symbol, called) = netlist.drawn(part);
    let board = netlist.part[part].kind == "board";
    let last = sheet.columns.len() - 1;
    let mut ports: Vec<Port> = Vec::new();
    // Those with lines first: where the others go depends on them.
    let mut others = Vec::new();
    for (name, _) in netlist.pins(part)? {
        let pin = format!("{part}.{name}");
        let net = nets.iter().position(|net| net.pins.contains(&pin));
        let elsewhere = |net: &Net| {
            let here = |other: &String| *other != pin && sheet.columns.iter().flatten().any(|of| of == split(other).0);
            net.pins.iter().any(here)
        };
        // Of a board only what has to do with the other parts.
        if board && !net.is_some_and(|net| elsewhere(&nets[net])) {
            continue;
        }
        let place = netlist.place(&name).filter(|_| board);
        let chip = netlist.board.pins.iter().any(|chip| chip.pin == name && chip.is != Is::Board);
        let label = match (symbol, place) {
            (Symbol::Box, Some(place)) if chip => format!("{name} {place}"),
            (Symbol::Box, Some(place)) => place.to_owned(),
            (Symbol::Box, None) => name.clone(),
            _ => String::new(),
        };
        match net.and_then(|net| reach[net].map(|reach| (net, reach))) {
            Some((net, (from, to))) => {
                let right = if from == to { column < last } else { column == from };
                let side = if right { Side::Right } else { Side::Left };
                ports.push(Port { pin, side, label, beside: String::new(), net: Some(net), y: 0.0 });
            }
            None => {
                let beside = net.map_or("open".to_owned(), |net| nets[net].name.clone());
                others.push(Port { pin, side: Side::Left, label, beside, net: None, y: 0.0 });
            }
        }
    }
    let count = |ports: &[Port], side| ports.iter().filter(|port| port.side == side).count();
    for mut port in others {
        let fewer = count(&ports, Side::Right) < count(&ports, Side::Left);
        let right = if column == 0 && board { false } else { (column == last && board) || fewer };
        port.side = if right { Side::Right } else { Side::Left };
        ports.push(port);
    }
    if board {
        // In the order of the nets, as their lines go on.
        ports.sort_by_key(|port| port.net.unwrap_or(usize::MAX));
    }
    if symbol != Symbol::Box && (count(&ports, Side::Left) > 1 || count(&ports, Side::Right) > 1) {
        // Its symbol lies between its ends.
        return Err(format!("{}: both ends of {part} are on one side; put it into another column", sheet.file));
    }
    let turned = symbol != Symbol::Box && ports.iter().any(|port| port.side == Side::Right && first_end(&port.pin));
    Ok(Item { symbol: Some(symbol), called, ports, turned, top: 0.0, bottom: 0.0 })
}

fn first_end(pin: &str) -> bool {
    matches!(split(pin).1, "1" | "A")
}

/// Heights of all parts and pins; that of the sheet.
fn stack(columns: &mut [Vec<Item>]) -> f64 {
    let mut height: f64 = 0.0;
    for (number, column) in columns.iter_mut().enumerate() {
        let shift = if number % 2 == 1 { SHIFT } else { 0.0 };
        let mut y = 48.0;
        for item in column {
            item.top = y;
            let head = if item.symbol.is_some() { 1.0 } else { 0.0 };
            // Rows of a column are whole ones from its shift on: those of its neighbours lie between them.
            let first = ((y + 4.0) / ROW).ceil() * ROW + head * ROW - ROW / 2.0 + shift;
            let mut rows = [0.0, 0.0];
            for port in &mut item.ports {
                let row = &mut rows[port.side as usize];
                port.y = first + *row * ROW;
                *row += 1.0;
            }
            item.bottom = first + (f64::max(rows[0], rows[1]) - 1.0) * ROW + ROW / 2.0;
            y = item.bottom + if item.symbol.is_some() { GAP } else { 0.0 };
        }
        height = height.max(y);
    }
    height + 4.0
}

/// Widths, tracks and everything in its place.
fn put(nets: &[Net], title: &str, columns: Vec<Vec<Item>>, height: f64) -> Drawing {
    let mut drawing = Drawing::default();
    let mut x = 12.0;
    // Ends of lines at the left of the channel that comes next: net, where.
    let mut waiting: Vec<(usize, (f64, f64))> = Vec::new();
    for (number, column) in columns.iter().enumerate() {
        let room = |side| {
            let beside = column.iter().flat_map(|item| &item.ports).filter(|port| port.side == side);
            beside
                .map(|port| if port.beside.is_empty() { 4.0 } else { width(&port.beside, SIZE) + STUB + 5.0 })
                .fold(0.0, f64::max)
        };
        let nets_here: BTreeSet<usize> = waiting.iter().map(|(net, _)| *net).collect();
        let (left, tracks) = (room(Side::Left), nets_here.len() as f64 * TRACK);
        let start = x + tracks + left + if number == 0 { 0.0 } else { TRACK };
        let end = start + column.iter().map(wide).fold(0.0, f64::max);
        let at = |port: &Port| (if port.side == Side::Left { start } else { end }, port.y);
        let arriving = column.iter().flat_map(|item| &item.ports).filter(|port| port.side == Side::Left);
        waiting.extend(arriving.filter_map(|port| Some((port.net?, at(port)))));
        route(&mut drawing, nets, &waiting, x + TRACK);
        for item in column {
            body(&mut drawing, nets, item, (start, end));
        }
        let leaving = column.iter().flat_map(|item| &item.ports).filter(|port| port.side == Side::Right);
        waiting = leaving.filter_map(|port| Some((port.net?, at(port)))).collect();
        x = end + room(Side::Right);
    }
    // A net within the last column has its line at its left: nothing waits here.
    drawing.size = ((x + 12.0).max(bold(title, TITLE) + 24.0), height);
    drawing.texts.push(Text { x: 12.0, y: 28.0, size: TITLE, anchor: Anchor::Start, text: title.to_owned() });
    drawing
}

/// How wide a part is.
fn wide(item: &Item) -> f64 {
    let Some(symbol) = item.symbol else { return 0.0 };
    let label = |side| {
        let labels = item.ports.iter().filter(|port| port.side == side).map(|port| width(&port.label, SIZE));
        labels.fold(0.0, f64::max)
    };
    let words = bold(&item.called, SIZE);
    if symbol == Symbol::Box {
        f64::max(label(Side::Left) + label(Side::Right) + 26.0, words + 12.0)
    } else {
        f64::max(words, 2.0 * HALF + 16.0)
    }
}

/// The lines of a channel: tracks from the left, those of nets that begin higher first.
fn route(drawing: &mut Drawing, nets: &[Net], ends: &[(usize, (f64, f64))], left: f64) {
    let mut here: Vec<usize> = ends.iter().map(|(net, _)| *net).collect();
    let top = |net: usize| ends.iter().filter(|(of, _)| *of == net).map(|(_, (_, y))| *y as i64).min();
    here.sort_by_key(|net| (std::cmp::Reverse(top(*net)), *net));
    here.dedup();
    for (track, net) in here.into_iter().enumerate() {
        let (x, colour) = (left + track as f64 * TRACK, nets[net].colour.clone());
        let points: Vec<(f64, f64)> = ends.iter().filter(|(of, _)| *of == net).map(|(_, at)| *at).collect();
        let (low, high) = points.iter().fold((f64::MAX, f64::MIN), |(low, high), (_, y)| (low.min(*y), high.max(*y)));
        let mut line = |ends| drawing.lines.push(Line { ends, colour: colour.clone() });
        line([(x, low), (x, high)]);
        points.iter().for_each(|(from, y)| line([(*from, *y), (x, *y)]));
        let between = points.iter().filter(|(_, y)| low < *y && *y < high);
        drawing.dots.extend(between.map(|(_, y)| ((x, *y), colour.clone())));
    }
}

/// A part with its words and stubs, or a lane.
fn body(drawing: &mut Drawing, nets: &[Net], item: &Item, (start, end): (f64, f64)) {
    let mut text = |x, y, anchor, text: &str| {
        if !text.is_empty() {
            drawing.texts.push(Text { x, y, size: SIZE, anchor, text: text.to_owned() });
        }
    };
    for port in &item.ports {
        let (edge, out, inside, outside) = match port.side {
            Side::Left => (start, -1.0, Anchor::Start, Anchor::End),
            Side::Right => (end, 1.0, Anchor::End, Anchor::Start),
        };
        text(edge - 7.0 * out, port.y + 4.5, inside, &port.label);
        if port.net.is_none() {
            text(edge + (STUB + 3.0) * out, port.y + 4.5, outside, &port.beside);
            let known = nets.iter().find(|net| net.pins.contains(&port.pin));
            let colour = known.map_or("open", |net| net.colour.as_str()).to_owned();
            drawing.lines.push(Line { ends: [(edge, port.y), (edge + STUB * out, port.y)], colour });
        }
        if !port.pin.is_empty() {
            drawing.pins.push((port.pin.clone(), (edge, port.y)));
        }
    }
    match item.symbol {
        None => {
            let (y, net) = (item.ports[0].y, item.ports[0].net.unwrap_or_default());
            drawing.lines.push(Line { ends: [(start, y), (end, y)], colour: nets[net].colour.clone() });
        }
        Some(Symbol::Box) => {
            let top = item.ports.iter().map(|port| port.y).fold(f64::MAX, f64::min) - ROW - 8.0;
            text((start + end) / 2.0, top + 16.0, Anchor::Middle, &item.called);
            let corners = [(start, top), (end, item.bottom)];
            drawing.bodies.push(Body { symbol: Symbol::Box, corners, turned: false });
        }
        Some(symbol) => {
            let y = item.ports[0].y;
            text((start + end) / 2.0, y - 13.0, Anchor::Middle, &item.called);
            drawing.bodies.push(Body { symbol, corners: [(start, y), (end, y)], turned: item.turned });
        }
    }
}

/// Half of a symbol's length.
pub fn half() -> f64 {
    HALF
}
