//! Plots as SVG, which can stand in a page.

use crate::report::grouped;
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
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
/// From which height on a linear scale has whole numbers alone.
const COUNTED: f64 = 10.0;
/// What bars take of their group's width.
const FILLED: f64 = 0.8;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// The colour of machine `k`.
pub(crate) fn colour(k: usize) -> RGBColor {
    COLOURS.get(k).copied().unwrap_or_else(|| {
        // Hues by the golden section lie well apart, however many there are.
        let hue = (k as f64 * 0.618_034).fract();
        let (r, g, b) = HSLColor(hue, 0.55, if k.is_multiple_of(2) { 0.35 } else { 0.65 }).rgb();
        RGBColor(r, g, b)
    })
}

/// The same as a page says it.
pub fn hex(k: usize) -> String {
    let RGBColor(r, g, b) = colour(k);
    format!("#{r:02x}{g:02x}{b:02x}")
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
    let heights = || bars.iter().map(|bar| bar.2).filter(|height| *height > 0.0);
    let highest = heights().reduce(f64::max).unwrap_or(1.0);
    let lowest = heights().fold(highest, f64::min);
    let logarithmic = highest > FLATTENED * lowest;
    // A logarithmic scale begins at a power of ten that is below all bars; what is counted, at one.
    let (foot, top) = if logarithmic {
        let below = (lowest.log10() - 0.3).floor();
        (if lowest < 1.0 { below } else { below.max(0.0) }, highest.log10() + 0.05)
    } else {
        (0.0, highest * 1.05)
    };
    let height = |value: f64| match logarithmic {
        true if value > 0.0 => value.log10().max(foot),
        true => foot,
        false => value,
    };
    let beside = |y: &f64| match logarithmic {
        true if (y - y.round()).abs() < 1e-6 => decimal(10f64.powi(y.round() as i32)),
        true => String::new(),
        false if highest < COUNTED => decimal(*y),
        false => whole(*y).map_or(String::new(), |y| grouped(&json!(y))),
    };
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
        .y_label_formatter(&beside)
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

/// A number to six digits behind its point, as few as it takes.
fn decimal(number: f64) -> String {
    if number.fract() == 0.0 {
        return grouped(&json!(number as u64));
    }
    let text = format!("{number:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_string()
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
pub(crate) fn short<'a>(names: &[&'a str]) -> Vec<&'a str> {
    let file = |name: &'a str| Path::new(name).file_name().and_then(|f| f.to_str()).unwrap_or(name);
    let alone = |name: &'a str| names.iter().filter(|other| file(other) == file(name)).count() == 1;
    names.iter().map(|name| if alone(name) { file(name) } else { name }).collect()
}

/// A group of bars for each of `names`: `values[k]` are those of group `k`, a bar each, in the machines'
/// colours.
///
/// # Errors
/// The plot cannot be drawn.
pub fn groups(names: &[&str], values: &[Vec<f64>], unit: &str) -> io::Result<String> {
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
pub(crate) fn histogram(pixels: &[u64]) -> io::Result<String> {
    let bar = |(layers, count): (usize, &u64)| {
        let (middle, half) = (layers as f64, FILLED / 2.0);
        (middle - half, middle + half, *count as f64, COLOURS[0])
    };
    let bars: Vec<Bar> = pixels.iter().enumerate().skip(1).map(bar).collect();
    let ends = (0.5, pixels.len() as f64 - 0.5);
    let label = |layers: usize| layers.to_string();
    svg(WIDTH, |area| draw(area, ends, &bars, (20, &label), ("layers", "pixels")))
}

/// A line for each of `series`, in their colours: `series[k][n]` stands above `labels[n]`, unless it is not finite: then there is
/// none. Behind them `shares`, in percent, are stacked from the axis on, in the same way, as far as there are any; they
/// have an axis of their own to the right, and are the darker the further up.
///
/// # Errors
/// The plot cannot be drawn.
pub fn lines(
    labels: &[String],
    series: &[Vec<f64>],
    (along, up): (&str, &str),
    shares: &[Vec<f64>],
) -> io::Result<String> {
    let finite = series.iter().flatten().copied().filter(|value| value.is_finite());
    let highest = finite.fold(1.0, f64::max);
    let all = |n: usize| shares.iter().map(|share| share[n]).sum::<f64>();
    let most = (0..labels.len()).map(all).fold(1.0, f64::max);
    svg(WIDTH, |area| {
        let ends = || -0.25..labels.len() as f64 - 0.75;
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .x_label_area_size(45)
            .y_label_area_size(MARGIN)
            .right_y_label_area_size(if shares.is_empty() { 0 } else { 60 })
            .build_cartesian_2d(ends(), 0.0..highest * 1.05)?
            .set_secondary_coord(ends(), 0.0..most * 1.05);
        let mut below = vec![0.0; labels.len()];
        for (k, share) in shares.iter().enumerate() {
            let above: Vec<f64> =
                below.iter().zip(share).map(|(below, share)| below + share).collect();
            let along = |heights: &[f64]| -> Vec<(f64, f64)> {
                heights.iter().enumerate().map(|(n, height)| (n as f64, *height)).collect()
            };
            let outline = along(&above).into_iter().chain(along(&below).into_iter().rev());
            let strip = Polygon::new(outline.collect::<Vec<_>>(), shade(k, shares.len()).filled());
            chart.draw_secondary_series([strip])?;
            below = above;
        }
        axes(&mut chart, labels, (along, up))?;
        if !shares.is_empty() {
            chart
                .configure_secondary_axes()
                .label_style(("sans-serif", 14))
                .y_desc("% of the pixels")
                .draw()?;
        }
        for (k, values) in series.iter().enumerate() {
            let points = || {
                let points = values.iter().enumerate().map(|(n, value)| (n as f64, *value));
                points.filter(|(_, value)| value.is_finite())
            };
            let line = PathElement::new(points().collect::<Vec<_>>(), colour(k).stroke_width(2));
            chart.draw_series([line])?;
            chart.draw_series(points().map(|at| Circle::new(at, 4, colour(k).filled())))?;
        }
        area.present()?;
        Ok(())
    })
}

/// The grey of share `k` of so many: see [`lines`].
pub(crate) fn shade(k: usize, all: usize) -> RGBColor {
    let light = 235 - (130 * k / all.max(1)) as u8;
    RGBColor(light, light, light)
}

type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Axes with `labels` at the whole numbers along the lower one.
fn axes(
    chart: &mut Chart,
    labels: &[String],
    (along, up): (&str, &str),
) -> Result<(), Box<dyn std::error::Error>> {
    let label = |x: &f64| whole(*x).and_then(|x| labels.get(x).cloned()).unwrap_or_default();
    chart
        .configure_mesh()
        .disable_x_mesh()
        .light_line_style(TRANSPARENT)
        .x_labels(2 * labels.len() + 1)
        .x_label_formatter(&label)
        .y_labels(6)
        .y_label_formatter(&number)
        .label_style(("sans-serif", 14))
        .x_desc(along)
        .y_desc(up)
        .draw()?;
    Ok(())
}

/// A number beside an axis.
fn number(value: &f64) -> String {
    if value.fract() == 0.0 { grouped(&json!(*value as u64)) } else { value.to_string() }
}

/// Least value, lower quartile, median, upper quartile and greatest value.
pub type FiveNumbers = [f64; 5];

/// A group of boxes for each of `names`: `values[k][n]` has the box of group `k` in the colour of machine `n`, with whiskers
/// to both ends. A machine without values has a gap.
///
/// # Errors
/// The plot cannot be drawn.
pub fn boxes(
    names: &[String],
    values: &[Vec<Option<FiveNumbers>>],
    unit: &str,
) -> io::Result<String> {
    let highest = values.iter().flatten().flatten().map(|numbers| numbers[4]).fold(1.0, f64::max);
    svg(WIDTH, |area| {
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .x_label_area_size(45)
            .y_label_area_size(MARGIN)
            .build_cartesian_2d(-0.5..names.len() as f64 - 0.5, 0.0..highest * 1.05)?;
        axes(&mut chart, names, ("", unit))?;
        for (k, group) in values.iter().enumerate() {
            let width = FILLED / group.len() as f64;
            for (n, numbers) in group.iter().enumerate() {
                let Some([least, lower, median, upper, greatest]) = *numbers else { continue };
                let middle = k as f64 - FILLED / 2.0 + (n as f64 + 0.5) * width;
                let (left, right) = (middle - width * 0.4, middle + width * 0.4);
                let path =
                    |points: [(f64, f64); 2]| PathElement::new(points, colour(n).stroke_width(2));
                chart.draw_series([
                    path([(middle, least), (middle, lower)]),
                    path([(middle, upper), (middle, greatest)]),
                ])?;
                let body =
                    Rectangle::new([(left, lower), (right, upper)], colour(n).mix(0.4).filled());
                chart.draw_series([body])?;
                chart.draw_series([path([(left, median), (right, median)])])?;
            }
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
        let bars = elements(&text, "rect").iter().map(|bar| attribute(bar, "height")).collect();
        (bars, text)
    }

    /// What each `<name .../>` of a plot says.
    fn elements<'a>(text: &'a str, name: &str) -> Vec<&'a str> {
        let start = format!("<{name} ");
        text.split(&*start).skip(1).map(|rest| rest.split("/>").next().unwrap()).collect()
    }

    fn attribute(element: &str, name: &str) -> f64 {
        let (_, value) = element.split_once(&format!("{name}=\"")).unwrap();
        value.split('"').next().unwrap().parse().unwrap()
    }

    #[test]
    fn a_value_that_is_missing_has_no_point_and_shares_lie_on_each_other() {
        let labels = ["0", "1", "2"].map(str::to_string);
        let series = [vec![1.0, f64::NAN, 3.0], vec![2.0, 2.0, 2.0]];
        let plain = lines(&labels, &series, ("frame", "cycles"), &[]).unwrap();
        assert_eq!(elements(&plain, "circle").len(), 5);
        assert_eq!(elements(&plain, "polygon").len(), 0);
        assert!(!plain.contains("% of the pixels"));
        // The higher, the further up.
        let circles = elements(&plain, "circle");
        let heights: Vec<f64> = circles.iter().map(|circle| attribute(circle, "cy")).collect();
        assert!(heights[1] < heights[2] && heights[2] < heights[0], "{heights:?}");

        let shares = [vec![10.0; 3], vec![20.0; 3]];
        let stacked = lines(&labels, &series, ("frame", "cycles"), &shares).unwrap();
        assert!(stacked.contains("% of the pixels"));
        let strips = elements(&stacked, "polygon").into_iter().map(|strip| {
            let (_, points) = strip.split_once("points=\"").unwrap();
            let points = points.split('"').next().unwrap().split_whitespace();
            let ys = points.map(|at| at.split_once(',').unwrap().1.parse().unwrap());
            let ys: Vec<f64> = ys.collect();
            let end = |of: fn(f64, f64) -> f64| ys.iter().copied().reduce(of).unwrap();
            (end(f64::min), end(f64::max))
        });
        let strips: Vec<(f64, f64)> = strips.collect();
        assert_eq!(strips.len(), 2);
        assert_eq!(strips[0].0, strips[1].1);
        let height = |(top, foot): (f64, f64)| foot - top;
        assert!((height(strips[1]) / height(strips[0]) - 2.0).abs() < 0.05, "{strips:?}");
    }

    #[test]
    fn a_box_goes_from_quartile_to_quartile() {
        let names = ["50x50".to_string()];
        let all = [vec![Some([0.0, 10.0, 20.0, 40.0, 100.0]), None, Some([5.0; 5])]];
        let text = boxes(&names, &all, "cycles a frame").unwrap();
        let bodies = elements(&text, "rect");
        let heights: Vec<f64> = bodies.iter().map(|body| attribute(body, "height")).collect();
        assert_eq!(heights.len(), 2, "{text}");
        // Of 105 up to the top of the axis, above the labels.
        let axis = f64::from(HEIGHT) - 10.0 - 10.0 - 45.0;
        assert!((heights[0] / axis - 30.0 / 105.0).abs() < 0.02, "{heights:?}");
        assert_eq!(heights[1], 0.0);
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

    #[test]
    fn what_is_below_one_has_a_scale_too() {
        let (bars, text) = heights(&[0.2, 0.4]);
        assert!((bars[1] / bars[0] - 2.0).abs() < 0.1, "{bars:?}");
        assert!(!text.contains("logarithmic") && text.contains(">\n0.1\n<"), "{text}");
        // From 0.001 on: one and three powers of ten; none has no bar.
        let (bars, text) = heights(&[0.01, 1.0, 0.0]);
        assert!(text.contains("words, logarithmic") && text.contains(">\n0.01\n<"), "{text}");
        assert!((bars[1] / bars[0] - 3.0).abs() < 0.2 && bars[2] == 0.0, "{bars:?}");
        assert!(heights(&[0.0, 0.0]).0.iter().all(|height| *height == 0.0));
    }

    /// A letter is at most 9 pixels wide, so that labels of so many letters do not meet.
    #[test]
    fn labels_of_groups_have_room_beside_each_other() {
        let name = "a-name-of-thirty-characters.ply";
        let text = groups(&[name, name], &[vec![1.0], vec![2.0]], "words").unwrap();
        let at: Vec<f64> = text
            .split("<text ")
            .filter(|label| label.contains(name))
            .map(|label| attribute(label, "x"))
            .collect();
        assert!(at[1] - at[0] > 8.0 * name.len() as f64, "{at:?}");
    }
}
