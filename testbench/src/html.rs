//! Pages that need nothing beside them.
//!
//! A page is XML too, so that it can be checked, and read by other programs.

use crate::image::Image;
use crate::plots;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use plotters::style::RGBColor;
use std::io;

/// How it looks.
const STYLE: &str = "
body { font-family: sans-serif; line-height: 1.4; margin: 2em auto; max-width: 70em; padding: 0 1em; }
table { border-collapse: collapse; }
th, td { padding: 0.2em 0.8em; text-align: left; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.name { white-space: nowrap; }
th.machine { text-align: right; }
td small { color: #555; display: block; max-width: 26em; }
tr.scene th { border-bottom: 1px solid #888; padding-top: 1em; }
#figures tr:first-child th { background: white; position: sticky; top: 0; z-index: 1; }
#figures td:first-child { background: white; left: 0; min-width: 16em; position: sticky; }
pre { background: #eee; overflow-wrap: break-word; padding: 0.5em; white-space: pre-wrap; }
figure { margin: 1.5em 0; overflow-x: auto; }
.wide { left: 50%; max-height: 90vh; max-width: 96vw; overflow: auto; position: relative; transform: translateX(-50%); width: max-content; }
.plots { display: flex; flex-wrap: wrap; gap: 0 1em; }
.plots figure { margin: 0.5em 0; width: 34em; }
.plots svg { height: auto; width: 100%; }
img { border: 1px solid #888; image-rendering: pixelated; max-width: 100%; min-width: 20em; }
.colour { border: 1px solid #888; display: inline-block; height: 0.8em; width: 1.6em; }
.sample { margin-right: 1.5em; }
";

/// A text as it stands in a page.
pub fn escaped(text: &str) -> String {
    let mut safe = String::new();
    for c in text.chars() {
        match c {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            '"' => safe += "&quot;",
            c if c.is_control() => safe.push(char::REPLACEMENT_CHARACTER),
            c => safe.push(c),
        }
    }
    safe
}

/// The bytes of a PNG as an address that needs no file.
pub fn png_data(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

/// A picture with a caption.
///
/// # Errors
/// The picture cannot be encoded.
pub fn figure(image: &Image, caption: &str) -> io::Result<String> {
    let data = png_data(&image.png()?);
    let caption = escaped(caption);
    Ok(format!(
        "<figure>\n<img src=\"{data}\" width=\"{}\" alt=\"{caption}\"/>\n\
         <figcaption>{caption}</figcaption>\n</figure>\n",
        image.width
    ))
}

/// A row of a table of numbers, whose cells are of this tag, `th` or `td`.
pub fn cells<'a>(tag: &str, cells: impl IntoIterator<Item = &'a str>) -> String {
    let cell = |text| format!("<{tag} class=\"number\">{}</{tag}>", escaped(text));
    format!("<tr>{}</tr>\n", cells.into_iter().map(cell).collect::<String>())
}

/// A plot with a caption.
pub fn plot(svg: &str, caption: &str) -> String {
    format!("<figure>\n{svg}<figcaption>{}</figcaption>\n</figure>\n", escaped(caption))
}

/// A colour and what it means.
pub(crate) fn sample(rgb: u32, meaning: &str) -> String {
    format!(
        "<span class=\"sample\"><span class=\"colour\" style=\"background: #{rgb:06x}\"></span> {}</span>\n",
        escaped(meaning)
    )
}

/// A sample of the colour of each series of a plot, in their order.
pub fn legend<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    samples(names.into_iter().enumerate().map(|(k, name)| (plots::colour(k), name)))
}

/// A sample of the grey of each share that [`plots::lines`] stacks, in their order.
pub fn shades<'a>(names: impl ExactSizeIterator<Item = &'a str>) -> String {
    let all = names.len();
    samples(names.enumerate().map(|(k, name)| (plots::shade(k, all), name)))
}

fn samples<'a>(colours: impl Iterator<Item = (RGBColor, &'a str)>) -> String {
    let each = colours
        .map(|(RGBColor(r, g, b), meaning)| sample(u32::from_be_bytes([0, r, g, b]), meaning));
    format!("<p>\n{}</p>\n", each.collect::<String>())
}

/// The page of this title that was made by a command. `about` says in a sentence or two what it shows; it and the body are
/// parts of a page already.
pub fn page(title: &str, about: &str, command: &str, body: &str) -> String {
    let (version, command) = (env!("CARGO_PKG_VERSION"), escaped(command));
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
         <title>Pellucid: {}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<h1>{}</h1>\n\
         <p>Clocked models of hardware for order-independent transparency, by Pellucid {version}. {about} This page was \
         made by</p>\n<pre>{command}</pre>\n{body}</body>\n</html>\n",
        escaped(&title.to_lowercase()),
        escaped(title)
    )
}
