//! Plots as SVG.

use crate::report::grouped;
use plotters::coord::Shift;
use plotters::prelude::*;
use serde_json::json;
use std::io;
use std::path::Path;

/// Colours of the first machines, told apart by those who see few colours too: M. Okabe and K. Ito, 2008.
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
/// Least width of a group of bars in pixels, if there are many of them.
const GROUP: u32 = 110;
/// Width of a letter below a group in pixels, and some room between labels.
const LETTER: u32 = 9;
/// The scale is logarithmic where the highest bar would be more than so many times the lowest.
const FLATTENED: f64 = 20.0;
/// What bars take of their group's width.
const FILLED: f64 = 0.8;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The colour of machine `k`.
pub(super) fn colour(k: usize) -> RGBColor {
    COLOURS.get(k).copied().unwrap_or_else(|| {
        // Hues by the golden section lie well apart, however many there are.
        let hue = (k as f64 * 0.618_034).fract();
        let (r, g, b) = HSLColor(hue, 0.55, if k.is_multiple_of(2) { 0.35 } else { 0.65 }).rgb();
        RGBColor(r, g, b)
    })
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
    let lowest =
        bars.iter().map(|bar| bar.2).filter(|height| *height >= 1.0).fold(highest, f64::min);
    let logarithmic = highest > FLATTENED * lowest;
    // A logarithmic scale begins at a power of ten that is below all bars.
    let (foot, top) = if logarithmic {
        ((lowest.log10() - 0.3).floor().max(0.0), highest.log10() + 0.05)
    } else {
        (0.0, highest * 1.05)
    };
    let height = |value: f64| if logarithmic { value.max(1.0).log10().max(foot) } else { value };
    let value = |y: usize| if logarithmic { 10_u64.pow(y as u32) } else { y as u64 };
    let up = if logarithmic { format!("{up}, logarithmic") } else { up.to_string() };
    let mut chart = ChartBuilder::on(area)
        .margin(10)
        .x_label_area_size(45)
        .y_label_area_size(MARGIN)
        .build_cartesian_2d(from..to, foot..top)?;
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(labels)
        .x_label_formatter(&|x| whole(*x).map_or(String::new(), label))
        .y_labels(6)
        .y_label_formatter(&|y| whole(*y).map_or(String::new(), |y| grouped(&json!(value(y)))))
        .label_style(("sans-serif", 14))
        .x_desc(along)
        .y_desc(up)
        .draw()?;
    let bars = bars.iter().map(|(left, right, value, colour)| {
        Rectangle::new([(*left, foot), (*right, height(*value))], colour.filled())
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

/// Names of scenes for labels: of a file its name without its folders, unless two have the same.
pub(super) fn short<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let file = |name: &'a str| Path::new(name).file_name().and_then(|f| f.to_str()).unwrap_or(name);
    let alone = |name: &'a str| names.iter().filter(|other| file(other) == file(name)).count() == 1;
    names.iter().map(|name| if alone(name) { file(name) } else { name }).collect()
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
    let longest = names.iter().map(|name| name.chars().count() as u32).max().unwrap_or(0);
    let group = GROUP.max(LETTER * (longest + 2));
    svg(WIDTH.max(MARGIN + group * count), |area| {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_machine_has_a_colour_of_its_own() {
        let all: Vec<(u8, u8, u8)> = (0..60).map(|k| colour(k).rgb()).collect();
        for (k, one) in all.iter().enumerate() {
            assert_eq!(all.iter().position(|other| other == one), Some(k));
        }
    }

    #[test]
    fn a_file_is_labelled_by_its_name_unless_two_have_the_same() {
        let names = ["glass", "/far/away/dragon.ply", "a/b.obj", "c/b.obj"];
        assert_eq!(short(&names), ["glass", "dragon.ply", "a/b.obj", "c/b.obj"]);
    }

    /// Heights of a plot's bars in pixels, in their order, and its text.
    fn heights(values: &[f64]) -> (Vec<f64>, String) {
        let text = groups(&["glass"], &[values.to_vec()], "words").unwrap();
        let bars = text.split("<rect ").skip(1).map(|bar| {
            let (_, height) = bar.split_once("height=\"").unwrap();
            height.split('"').next().unwrap().parse().unwrap()
        });
        (bars.collect(), text)
    }

    #[test]
    fn a_machine_that_is_far_above_the_others_does_not_flatten_them() {
        let (linear, text) = heights(&[100.0, 2000.0]);
        assert!(!text.contains("logarithmic"));
        assert!((linear[1] / linear[0] - 20.0).abs() < 2.0, "{linear:?}");
        // From 10 on: one, two and five powers of ten.
        let (bars, text) = heights(&[100.0, 1000.0, 1_000_000.0]);
        assert!(text.contains("words, logarithmic") && text.contains("1,000,000"), "{text}");
        assert!((bars[1] / bars[0] - 2.0).abs() < 0.1, "{bars:?}");
        assert!((bars[2] / bars[0] - 5.0).abs() < 0.2, "{bars:?}");
    }

    /// A letter is at most 9 pixels wide, so that labels of so many letters do not meet.
    #[test]
    fn labels_of_groups_have_room_beside_each_other() {
        let name = "a-name-of-thirty-characters.ply";
        let text = groups(&[name, name], &[vec![1.0], vec![2.0]], "words").unwrap();
        let at: Vec<f64> = text
            .split("<text ")
            .filter(|label| label.contains(name))
            .map(|label| {
                let (_, x) = label.split_once("x=\"").unwrap();
                x.split('"').next().unwrap().parse().unwrap()
            })
            .collect();
        assert!(at[1] - at[0] > 8.0 * name.len() as f64, "{at:?}");
    }
}
