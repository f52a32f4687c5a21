//! Plots as SVG.

use crate::report::grouped;
use plotters::coord::Shift;
use plotters::prelude::*;
use serde_json::json;
use std::io;

/// Colours of machines, told apart by those who see few colours too: M. Okabe and K. Ito, 2008. After
/// the last the first comes again.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x00, 0x9e, 0x73),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0x56, 0xb4, 0xe9),
    RGBColor(0xd5, 0x5e, 0x00),
    RGBColor(0xf0, 0xe4, 0x42),
    RGBColor(0x00, 0x00, 0x00),
];

/// Height of a plot in pixels.
const HEIGHT: u32 = 320;
/// Least width of a plot in pixels.
const WIDTH: u32 = 640;
/// Width of the numbers beside a plot in pixels.
const MARGIN: u32 = 110;
/// Width of a group of bars in pixels, if there are many of them.
const GROUP: u32 = 110;
/// What bars take of their group's width.
const FILLED: f64 = 0.8;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The colour of machine `k`.
pub(super) fn colour(k: usize) -> RGBColor {
    COLOURS[k % COLOURS.len()]
}

/// A bar: where it begins and ends along the axis, its height and its colour.
type Bar = (f64, f64, f64, RGBColor);

/// Bars with the axis from `from` to `to`, at `labels` of whose whole numbers `label` stands, or fewer.
fn draw(
    area: &Area,
    (from, to): (f64, f64),
    bars: &[Bar],
    (labels, label): (usize, &dyn Fn(usize) -> String),
    (along, up): (&str, &str),
) -> Result<(), Box<dyn std::error::Error>> {
    let highest = bars.iter().map(|bar| bar.2).fold(1.0, f64::max);
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(45)
        .y_label_area_size(MARGIN)
        .build_cartesian_2d(from..to, 0.0..highest * 1.05)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(labels)
        .x_label_formatter(&|x| whole(*x).map_or(String::new(), label))
        .y_labels(6)
        .y_label_formatter(&|y| whole(*y).map_or(String::new(), |y| grouped(&json!(y))))
        .label_style(("sans-serif", 14))
        .x_desc(along)
        .y_desc(up)
        .draw()?;
    let bars = bars.iter().map(|(left, right, height, colour)| {
        Rectangle::new([(*left, 0.0), (*right, *height)], colour.filled())
    });
    chart.draw_series(bars)?;
    area.present()?;
    Ok(())
}

/// The whole number that `x` is, if it is one.
fn whole(x: f64) -> Option<usize> {
    (x > -0.5 && (x - x.round()).abs() < 1e-6).then_some(x.round() as usize)
}

/// A drawing of `width` pixels as text that can stand in a page.
fn svg(
    width: u32,
    draw: impl FnOnce(&Area) -> Result<(), Box<dyn std::error::Error>>,
) -> io::Result<String> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (width, HEIGHT)).into_drawing_area();
    draw(&area).map_err(|error| io::Error::other(error.to_string()))?;
    drop(area);
    // Within a page the name space goes without saying, and the page names no address.
    Ok(text.replacen(r#" xmlns="http://www.w3.org/2000/svg""#, "", 1))
}

/// A group of bars for each of `names`: `values[k]` are those of group `k`, a bar each, in the machines'
/// colours.
///
/// # Errors
/// The plot cannot be drawn.
pub(super) fn groups(names: &[&str], values: &[Vec<f64>], unit: &str) -> io::Result<String> {
    let mut bars = vec![];
    for (k, values) in values.iter().enumerate() {
        let width = FILLED / values.len() as f64;
        let start = k as f64 - FILLED / 2.0;
        for (n, value) in values.iter().enumerate() {
            let left = start + n as f64 * width;
            bars.push((left, left + width, *value, colour(n)));
        }
    }
    let count = names.len() as u32;
    let ends = (-0.5, f64::from(count) - 0.5);
    let label = |k: usize| names.get(k).map_or_else(String::new, |name| name.to_string());
    svg(WIDTH.max(MARGIN + GROUP * count), |area| {
        draw(area, ends, &bars, (2 * names.len() + 1, &label), ("", unit))
    })
}

/// A bar for each number of layers from 1 on: how many pixels have it. `pixels[0]`, those without, are
/// left out.
///
/// # Errors
/// The plot cannot be drawn.
pub(super) fn histogram(pixels: &[u64]) -> io::Result<String> {
    let bar = |(layers, count): (usize, &u64)| {
        let (middle, half) = (layers as f64, FILLED / 2.0);
        (middle - half, middle + half, *count as f64, COLOURS[0])
    };
    let bars: Vec<Bar> = pixels.iter().enumerate().skip(1).map(bar).collect();
    let ends = (0.5, pixels.len() as f64 - 0.5);
    let label = |layers: usize| layers.to_string();
    svg(WIDTH, |area| draw(area, ends, &bars, (20, &label), ("layers", "pixels")))
}

/// A line for each of `series`, in their colours: `series[k][n]` stands above `labels[n]`.
///
/// # Errors
/// The plot cannot be drawn.
pub(super) fn lines(
    labels: &[String],
    series: &[Vec<f64>],
    along: &str,
    up: &str,
) -> io::Result<String> {
    let highest = series.iter().flatten().copied().fold(1.0, f64::max);
    svg(WIDTH, |area| {
        let ends = -0.25..labels.len() as f64 - 0.75;
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .x_label_area_size(45)
            .y_label_area_size(MARGIN)
            .build_cartesian_2d(ends, 0.0..highest * 1.05)?;
        let label = |x: &f64| whole(*x).and_then(|x| labels.get(x).cloned()).unwrap_or_default();
        chart
            .configure_mesh()
            .disable_x_mesh()
            .light_line_style(TRANSPARENT)
            .x_labels(2 * labels.len() + 1)
            .x_label_formatter(&label)
            .y_labels(6)
            .label_style(("sans-serif", 14))
            .x_desc(along)
            .y_desc(up)
            .draw()?;
        for (k, values) in series.iter().enumerate() {
            let points = || values.iter().enumerate().map(|(n, value)| (n as f64, *value));
            let line = PathElement::new(points().collect::<Vec<_>>(), colour(k).stroke_width(2));
            chart.draw_series([line])?;
            chart.draw_series(points().map(|at| Circle::new(at, 4, colour(k).filled())))?;
        }
        area.present()?;
        Ok(())
    })
}
