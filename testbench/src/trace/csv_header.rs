//! The first line of the text form: `# pellucid-trace width=W height=H background=R,G,B frames=N`, keys in any order, the last one
//! only where there are several frames.

use super::csv::quote;
use super::digits;
use super::fields;
use super::{Header, MOST_FRAMES};
use pellucid_machine::pixel::{MAX_SIDE, Screen};

/// How the line starts.
pub(super) const MARK: &str = "# pellucid-trace";

/// What the line says, or what is wrong with it. `None` is an empty file.
pub(super) fn parse(line: Option<&[u8]>) -> Result<Header, String> {
    let line = line.unwrap_or_default();
    let text = std::str::from_utf8(line)
        .ok()
        .and_then(|text| text.strip_prefix(MARK))
        .filter(|rest| rest.is_empty() || rest.starts_with([' ', '\t']));
    let Some(text) = text else {
        return Err(format!(
            "found {}, expected `{MARK} width=W height=H background=R,G,B`",
            if line.is_empty() { "nothing".into() } else { quote(line) }
        ));
    };
    let (mut width, mut height, mut background, mut frames) = (None, None, None, None);
    for part in joined(text).split_whitespace() {
        let Some((key, value)) = part.split_once('=') else {
            return Err(format!("found {}, expected key=value", quote(part.as_bytes())));
        };
        let slot = match key {
            "width" => &mut width,
            "height" => &mut height,
            "background" => &mut background,
            "frames" => &mut frames,
            _ => {
                let key = quote(key.as_bytes());
                return Err(format!(
                    "key {key} is unknown, expected width, height, background and frames"
                ));
            }
        };
        let value = match key {
            "background" => colour(value)?,
            "frames" => number(key, value, 1, MOST_FRAMES)?,
            _ => number(key, value, 1, MAX_SIDE)?,
        };
        if slot.replace(value).is_some() {
            return Err(format!("{key} is there twice, expected once"));
        }
    }
    let screen = Screen {
        width: width.ok_or("width is missing, expected width=W")?,
        height: height.ok_or("height is missing, expected height=H")?,
        background: background.ok_or("background is missing, expected background=R,G,B")?,
    };
    Ok(Header { screen, frames: frames.unwrap_or(1) })
}

/// Without the spaces around `=` and `,`, so that spaces part the keys only.
fn joined(text: &str) -> String {
    ["=", ","].iter().fold(text.to_owned(), |text, sign| {
        let parts: Vec<&str> = text.split(sign).map(str::trim).collect();
        parts.join(sign)
    })
}

fn number(name: &str, value: &str, smallest: u32, largest: u32) -> Result<u32, String> {
    digits::integer(value.as_bytes(), smallest, largest)
        .ok_or_else(|| fields::problem(name, &quote(value.as_bytes()), smallest, largest))
}

/// `R,G,B` as `0xRRGGBB`.
fn colour(value: &str) -> Result<u32, String> {
    let channels: Vec<&str> = value.split(',').collect();
    let [r, g, b] = channels[..] else {
        let value = quote(value.as_bytes());
        return Err(format!("background is {value}, expected three integers R,G,B"));
    };
    Ok(number("background red", r, 0, 255)? << 16
        | number("background green", g, 0, 255)? << 8
        | number("background blue", b, 0, 255)?)
}
