//! Whole figures: what must hold of any sheet, whatever the data.

use tempfile::tempdir;

use super::layout;
use super::sheet::{Anchor, Frame, Mark, Sheet, Text};
use super::*;

/// The sheet of a figure.
fn sheet(figure: &Figure, print: Print) -> Sheet {
    layout::sheet(figure, print).unwrap()
}

/// As wide as a page of a journal.
fn page() -> Print {
    Print { width_mm: 180.0, ..Print::default() }
}

fn wave(count: usize, height: f64) -> Vec<(f64, f64)> {
    let value = |i: usize| height * ((i as f64 * 12.9898).sin() * 43758.5453).fract();
    (0..count).map(|i| (i as f64 * 1e-3, value(i))).collect()
}

/// Three systems side by side, three quantities below each other, as dense as noise can be.
fn grid(count: usize) -> Figure {
    let panel = |i: usize| Panel {
        title: if i < 3 { format!("System {i} (K_T = {i}000 N/m)") } else { String::new() },
        x_label: "Time (s)".to_owned(),
        y_label: ["Position (mm)", "Force (N)", "Discrepancy (mm)"][i / 3].to_owned(),
        series: vec![
            Series::line("local copy", 0, wave(count, 1.0)),
            Series::dashed("remote copy", 1, Dash::Dashed, wave(count, 2.0 + i as f64)),
        ],
        ..Panel::default()
    };
    let panels = (0..9).map(panel).collect();
    let (title, caption) = ("Nine panels".to_owned(), "Left to right three systems. ".repeat(9));
    Figure { title, caption, columns: 3, share_x: true, share_y: ShareY::Rows, panels }
}

/// Every shape with these points, on every kind of axis.
fn shapes(points: &[(f64, f64)]) -> Figure {
    let series = |points: &[(f64, f64)]| {
        let side = |at: usize| (points[at].0, points[at].1, 2.0 * points[at].1);
        let pieces = (1..points.len()).map(|at| Strip { left: side(at - 1), right: side(at) }).collect();
        let names = vec!["first".to_owned(), "second".to_owned()];
        vec![
            Series::line("line", 0, points.to_vec()),
            Series::dashed("dots and strokes", 1, Dash::DashDot, points.to_vec()),
            Series::dots("dots", 3, points.to_vec(), names),
            Series::bars("bars", 4, points.to_vec()),
            Series::bars("more bars", 5, points.to_vec()),
            Series::region("region", 6, pieces),
            Series::region("no region", 7, Vec::new()),
        ]
    };
    let panel = |i: usize| Panel {
        log_x: i & 1 > 0,
        log_y: i & 2 > 0,
        off_scale: i & 4 > 0,
        x_range: (i == 9).then_some((f64::NAN, 2.0)),
        y_range: (i == 10).then_some((5.0, 5.0)),
        categories: if i == 11 { vec!["one".to_owned(), "a second one".to_owned()] } else { Vec::new() },
        note: Some("diverges".to_owned()),
        series: series(points),
        ..Panel::default()
    };
    Figure { panels: (0..16).map(panel).collect(), share_y: ShareY::All, ..Figure::default() }
}

fn texts(sheet: &Sheet) -> Vec<&Text> {
    sheet.marks.iter().filter_map(|mark| if let Mark::Text(text) = mark { Some(text) } else { None }).collect()
}

/// The room that a text takes.
fn area(text: &Text) -> Frame {
    let width = font::width(&text.text, text.size);
    let start = match text.anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => -width / 2.0,
        Anchor::End => -width,
    };
    let ((x, y), up, down) = (text.at, 0.72 * text.size, 0.1 * text.size);
    if text.upward {
        Frame { left: x - up, right: x + down, top: y - start - width, bottom: y - start }
    } else {
        Frame { left: x + start, right: x + start + width, top: y - up, bottom: y + down }
    }
}

fn assert_tidy(sheet: &Sheet) {
    let whole = Frame { left: 0.0, top: 0.0, right: sheet.width, bottom: sheet.height };
    let areas: Vec<(Frame, &str)> = texts(sheet).iter().map(|t| (area(t), t.text.as_str())).collect();
    for (i, (one, text)) in areas.iter().enumerate() {
        assert!(one.corners().into_iter().all(|c| whole.contains(c)), "`{text}` is clipped: {one:?}");
        for (two, other) in &areas[i + 1..] {
            assert!(!one.overlaps(two), "`{text}` and `{other}` overlap: {one:?} {two:?}");
        }
    }
    assert_letters(sheet);
}

/// Six points at least, as is readable in print.
fn assert_letters(sheet: &Sheet) {
    for text in texts(sheet) {
        for word in font::words(&text.text, text.size).0 {
            let points = word.size * sheet.width_mm / sheet.width / (25.4 / 72.0);
            assert!(points >= 6.0, "`{}` of `{}` has letters of {points:.2} points", word.text, text.text);
        }
    }
}

fn assert_finite(sheet: &Sheet) {
    for mark in &sheet.marks {
        let points = match mark {
            Mark::Line { points, .. } => points.clone(),
            Mark::Fill { frame, .. } => frame.corners(),
            Mark::Region { strips, .. } => strips.concat(),
            Mark::Disc { at, .. } => vec![*at],
            Mark::Text(text) => vec![text.at],
        };
        let near = |v: f64| (-1000.0..20_000.0).contains(&v);
        assert!(points.iter().all(|(x, y)| near(*x) && near(*y)), "{mark:?}");
    }
}

#[test]
fn no_text_is_clipped_or_covers_another() {
    assert_tidy(&sheet(&grid(300), page()));
    let bars = |values: [f64; 3]| values.iter().enumerate().map(|(i, v)| (i as f64, *v)).collect();
    let panel = Panel {
        y_label: "Mean discrepancy (mm)".to_owned(),
        categories: ["power", "traditional wave", "passive wave communications"].map(str::to_owned).to_vec(),
        series: vec![
            Series::bars("paper", 6, bars([3.5, 0.644, 0.099])),
            Series::bars("here", 0, bars([3.25, 0.638, 0.0946])),
        ],
        ..Panel::default()
    };
    assert_tidy(&sheet(
        &Figure { columns: 3, panels: vec![panel.clone(), panel.clone(), panel], ..Figure::default() },
        page(),
    ));
}

/// Powers at the ticks of both axes, indices in labels, headings, legends and captions; in a column and on a page.
#[test]
fn no_letter_is_smaller_than_six_points() {
    let points: Vec<(f64, f64)> = (0..60).map(|i| (10_f64.powi(i % 9 - 4), 10_f64.powi(i % 7 - 5))).collect();
    let panel = Panel {
        title: "K_T at 10^−3 s".to_owned(),
        x_label: "Stiffness K_LC (N/m)".to_owned(),
        y_label: "Discrepancy x_o − x_d (mm)".to_owned(),
        log_x: true,
        log_y: true,
        series: vec![
            Series::line("of F_T", 0, points.clone()),
            Series::dots("", 1, points, vec!["K_T".to_owned(); 60]),
        ],
        ..Panel::default()
    };
    let caption = "Where b_T is 10^2 N·s/m.".to_owned();
    for (width_mm, columns) in [(88.0, 1), (88.0, 2), (180.0, 3)] {
        let figure =
            Figure { columns, caption: caption.clone(), panels: vec![panel.clone(); columns], ..Figure::default() };
        assert_letters(&sheet(&figure, Print { width_mm, ..Print::default() }));
    }
}

/// Where a panel of a column is narrower or lower than its labels, these take several lines instead of smaller letters.
#[test]
fn a_label_that_is_longer_than_its_axis_has_several_lines() {
    let panel = Panel {
        x_label: "Coordination stiffness of both peers over the contact's (N/m over N/m)".to_owned(),
        y_label: "Mean true discrepancy of both copies over the last half of the run (mm)".to_owned(),
        series: vec![Series::line("", 0, vec![(0.0, 1.0), (1.0, 2.0)])],
        ..Panel::default()
    };
    let figure = Figure { columns: 2, panels: vec![panel.clone(), panel], ..Figure::default() };
    let sheet = sheet(&figure, Print::default());
    assert_tidy(&sheet);
    let lines = texts(&sheet).iter().filter(|text| text.upward).count();
    assert!(lines > 1, "{lines} lines along the vertical axis");
}

#[test]
fn a_row_has_one_vertical_axis_and_its_texts_once() {
    let sheet = sheet(&grid(300), page());
    let count = |text: &str| texts(&sheet).iter().filter(|t| t.text == text).count();
    assert_eq!((count("Force (N)"), count("Time (s)"), count("local copy")), (1, 3, 9));
}

#[test]
fn a_legend_gets_room_above_dense_data() {
    let sheet = sheet(&grid(3000), page());
    let boxes = sheet.marks.iter().enumerate().filter_map(|(i, mark)| match mark {
        Mark::Fill { frame, color: sheet::PAPER, .. } => Some((i, *frame)),
        _ => None,
    });
    let boxes: Vec<(usize, Frame)> = boxes.collect();
    assert_eq!(boxes.len(), 9);
    for (i, area) in boxes {
        // What lies below the box: the data of its panel, painted before it.
        for mark in &sheet.marks[..i] {
            if let Mark::Line { points, width: panel::STROKE, .. } = mark {
                assert!(!points.iter().any(|p| area.contains(*p)), "{area:?}");
            }
        }
    }
}

/// Ten names in a panel that has room for six, above data in its middle: they stand below, and nothing is covered.
#[test]
fn a_legend_that_is_too_tall_stands_below_all_panels() {
    let level = |i: usize| (0..100).map(|x| (f64::from(x), 1.0 + i as f64)).collect();
    let series = (0..10).map(|i| Series::line(format!("series number {i}"), i, level(i)));
    let named = Panel { x_label: "Time (s)".to_owned(), series: series.collect(), ..Panel::default() };
    let caption = "What the reader should see.".to_owned();
    let figure = Figure { columns: 2, panels: vec![named; 4], caption, ..Figure::default() };
    let sheet = sheet(&figure, page());
    assert_tidy(&sheet);
    let heights = |text: &str| texts(&sheet).iter().filter(|t| t.text == text).map(|t| t.at.1).collect::<Vec<_>>();
    let lowest = heights("Time (s)").into_iter().fold(0.0, f64::max);
    for i in 0..10 {
        let heights = heights(&format!("series number {i}"));
        assert!(heights.len() == 4 && heights.iter().all(|y| *y > lowest && *y < sheet.height), "{i}: {heights:?}");
    }
    assert!(!sheet.marks.iter().any(|mark| matches!(mark, Mark::Fill { color: sheet::PAPER, .. })));
    assert!(heights("What the reader should see.")[0] > heights("series number 9")[3]);
}

#[test]
fn odd_data_are_drawn_without_a_panic_and_stay_on_the_sheet() {
    let odd = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -0.0, -1.0, 1e-310, 1e308, -1e308, 1.0, 2.0];
    let pairs: Vec<(f64, f64)> = odd.iter().flat_map(|x| odd.map(|y| (*x, y))).collect();
    let cases: [&[(f64, f64)]; 7] = [
        &[],
        &[(1.0, f64::NAN)],
        &[(1.0, 5.0); 4],
        &[(0.0, -2.0), (1.0, -2.0)],
        &[(0.0, 1e300), (1.0, -1e300)],
        &[(2.0, 1.0), (1.0, 2.0), (f64::NAN, f64::NAN), (3.0, 3.0)],
        &pairs,
    ];
    for points in cases {
        let sheet = sheet(&shapes(points), page());
        assert_finite(&sheet);
        let bare = Sheet { data: String::new(), ..sheet };
        assert!(!svg::render(&bare, "").contains("NaN,"));
    }
}

#[test]
fn figures_without_panels_or_data_are_written() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let panels = vec![Panel::default(), Panel { log_x: true, log_y: true, ..Panel::default() }];
    for (i, figure) in [Figure::default(), Figure { columns: 5, panels, ..Figure::default() }].iter().enumerate() {
        assert_eq!(draw(figure, &folder.join(format!("new folder/{i}"))).unwrap().len(), 3);
    }
}

#[test]
fn the_same_figure_gives_the_same_bytes_and_dense_panels_stay_small() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let read = |name: &str| -> Vec<Vec<u8>> {
        let paths = draw(&grid(20_000), &folder.join(name)).unwrap();
        assert!(
            paths[0].ends_with("fig.6.svg") && paths[1].ends_with("fig.6.pdf") && paths[2].ends_with("fig.6.png"),
            "{paths:?}"
        );
        paths.iter().map(|path| std::fs::read(path).unwrap()).collect()
    };
    let (first, second) = (read("one/fig.6"), read("two/fig.6"));
    assert!(first == second);
    let svg = std::str::from_utf8(&first[0]).unwrap();
    let (data, drawn) = svg.split_once("</metadata>").unwrap();
    assert!(drawn.len() < 300_000 && data.len() < 600_000, "{} bytes drawn, {} of data", drawn.len(), data.len());
    assert!(first[1].len() < 300_000, "{} bytes of PDF", first[1].len());
    // PNG: signature, then the header chunk with width and height, then how many pixels a metre has: 88 mm across.
    assert_eq!(first[2][..8], *b"\x89PNG\r\n\x1a\n");
    assert_eq!(first[2][16..20], 1564_u32.to_be_bytes());
    assert_eq!(first[2][37..45], *[&b"pHYs"[..], &17_773_u32.to_be_bytes()].concat());
}

#[test]
fn an_error_names_the_file_and_the_cause() {
    let folder = tempdir().unwrap();
    let folder = folder.path();
    let file = folder.join("a-file");
    std::fs::write(&file, "").unwrap();
    let text = draw(&Figure::default(), &file.join("figure")).unwrap_err().to_string();
    assert!(text.starts_with("cannot write ") && text.contains("a-file/figure.svg as svg: "), "{text}");
}

/// A legend over a range that was given has nowhere to go but below the panels.
#[test]
fn a_legend_covers_nothing_in_a_range_that_was_given() {
    let dense: Vec<(f64, f64)> = (0..3000).map(|i| (f64::from(i), f64::from(i % 7))).collect();
    let panel = Panel { y_range: Some((0.0, 6.0)), series: vec![Series::line("dense", 0, dense)], ..Panel::default() };
    let sheet = sheet(&Figure { panels: vec![panel], ..Figure::default() }, page());
    assert!(!sheet.marks.iter().any(|mark| matches!(mark, Mark::Fill { color: sheet::PAPER, .. })));
    assert_eq!(texts(&sheet).iter().filter(|text| text.text == "dense").count(), 1);
}

/// A column of a journal is laid out anew: the letters keep their size in print, and nothing is clipped.
#[test]
fn a_figure_fits_a_column_and_a_page() {
    let line: Vec<(f64, f64)> = (0..100).map(|i| (f64::from(i), f64::from(i % 9))).collect();
    let series = vec![Series::line("local copy", 0, line)];
    let panel = Panel {
        x_label: "Time (s)".to_owned(),
        y_label: "Coordination force (N)".to_owned(),
        series,
        ..Panel::default()
    };
    let caption = "What the reader should see, in a sentence or two. ".repeat(4);
    let figure = Figure { title: "One panel".to_owned(), caption, panels: vec![panel], ..Figure::default() };
    // 22 pixels are 7 points of 0.353 mm: 1600 of them 180 mm, and at 8 points 1403.
    let usual = Print::default();
    assert!((usual.font_pt - 7.02).abs() < 0.01, "{usual:?}");
    for (print, width) in [(usual, 782.0), (page(), 1600.0), (Print { font_pt: 8.0, ..page() }, 1403.0)] {
        let sheet = sheet(&figure, print);
        assert_eq!(sheet.width, width);
        assert_tidy(&sheet);
        let [(_, svg), ..] = paint(&figure, print, "").unwrap();
        assert!(String::from_utf8(svg).unwrap().contains(&format!(" width=\"{}mm\" ", print.width_mm)));
    }
}

/// A legend that is wider than its panel stands below, under its axis' name; a note is broken; neither lies on a neighbour.
#[test]
fn in_a_column_no_legend_is_wider_than_its_panel() {
    let line: Vec<(f64, f64)> = (0..100).map(|i| (f64::from(i), f64::from(i % 9))).collect();
    let panel = |at: usize, y_label: &str, label: &str| Panel {
        title: "Passive wave, K_T\u{a0}= 10620\u{a0}N/m".to_owned(),
        x_label: "Time (s)".to_owned(),
        y_label: y_label.to_owned(),
        note: (at == 1).then(|| "peer 1 stops at 2.95 s: Overspeed".to_owned()),
        series: vec![Series::line(if at == 0 { label } else { "" }, 0, line.clone())],
        ..Panel::default()
    };
    let rows =
        [("Position (mm)", "remote copy, decoded here"), ("Force on the copy (N)", "coordination, at either end")];
    let panels = rows.iter().flat_map(|(y_label, label)| (0..3).map(|at| panel(at, y_label, label))).collect();
    let figure =
        Figure { title: "Six panels".to_owned(), columns: 3, share_y: ShareY::Rows, panels, ..Figure::default() };
    let column = sheet(&figure, Print::default());
    assert_tidy(&column);
    let lowest = |words: &str| {
        let of = texts(&column).into_iter().filter(|text| text.text == words).map(|text| text.at.1);
        of.fold(f64::NAN, f64::max)
    };
    let axis = lowest("Time (s)");
    for (y_label, label) in rows {
        assert!(
            lowest(y_label) > axis && lowest(label) > lowest(y_label),
            "{label} stands under {y_label}, below all panels"
        );
    }
    assert!(texts(&column).iter().any(|text| text.text == "N/m" || text.text.ends_with("10620\u{a0}N/m")));
    // On a page there is room inside.
    assert!(texts(&sheet(&figure, page())).iter().filter(|text| text.text == "Position (mm)").count() == 1);
}

/// Where a row shares nothing, a column of a journal has fewer panels side by side, and names of categories do not meet.
#[test]
fn in_a_column_fewer_panels_stand_side_by_side() {
    let panel = Panel {
        y_label: "Peak coordination force (N)".to_owned(),
        categories: ["passive-mean", "self-timed"].map(str::to_owned).to_vec(),
        series: vec![Series::intervals("", 0, vec![(0.0, -0.05, 0.06), (1.0, -0.18, 0.21)])],
        ..Panel::default()
    };
    let figure = Figure { columns: 3, panels: vec![panel; 5], ..Figure::default() };
    let column = sheet(&figure, Print::default());
    assert_tidy(&column);
    let lefts = |sheet: &Sheet| {
        let mut lefts: Vec<i64> =
            texts(sheet).iter().filter(|text| text.upward).map(|text| text.at.0.round() as i64).collect();
        lefts.sort_unstable();
        lefts.dedup();
        lefts.len()
    };
    assert_eq!([lefts(&column), lefts(&sheet(&figure, page()))], [2, 3]);
}

/// Names of categories that do not fit side by side are written upwards, values above narrow bars keep apart.
#[test]
fn names_of_many_categories_do_not_meet() {
    let names = ["one peer", "power", "passive wave", "encoder", "2 axes", "five-bar"].map(str::to_owned);
    let bars = (0..6).map(|at| (f64::from(at), 386.0 + 50.0 * f64::from(at))).collect();
    let panel = Panel {
        y_label: "Instructions per tick".to_owned(),
        categories: names.to_vec(),
        series: vec![Series::bars("", 0, bars)],
        ..Panel::default()
    };
    let figure = Figure { columns: 2, panels: vec![panel; 2], caption: "Two panels.".to_owned(), ..Figure::default() };
    let column = sheet(&figure, Print::default());
    assert_tidy(&column);
    let upward = |sheet: &Sheet| texts(sheet).iter().filter(|text| text.upward && text.text == "passive wave").count();
    assert_eq!(upward(&column), 2);
    assert!(texts(&sheet(&figure, page())).iter().all(|text| text.text != "passive wave" || !text.upward));
}

/// Dots that lie on each other, in a narrow panel: a stroke leads to a name that finds no room beside its dot.
#[test]
fn names_of_dots_that_lie_close_together_do_not_meet() {
    let points = vec![(10.0, 2.0), (10.1, 2.0), (10.1, 2.02), (9.9, 2.01), (30.0, 4.0)];
    let names = ["filtered", "filtered, 80 Hz", "adaptive", "difference", "measured"].map(str::to_owned);
    let panel = Panel { series: vec![Series::dots("", 0, points, names.to_vec())], ..Panel::default() };
    let figure = Figure { columns: 2, panels: vec![panel; 2], ..Figure::default() };
    assert_tidy(&sheet(&figure, Print::default()));
}
