//! The text form of a trace: a comment line with the frame, a line with the columns, one fragment a line.
//!
//! ```text
//! # pellucid-trace width=640 height=480 background=0,0,0
//! x,y,z,r,g,b,a
//! 12,7,8388608,255,128,0,127
//! ```
//!
//! Of several frames, the first line has their number, `frames=2`, and before each but the first comes a line `# frame 1`, with its
//! number from 0.
//!
//! Traces are long, so reading has two paths. The quick one takes lines exactly as our writer makes them,
//! a field at a time in one machine word ([`digits`]). Whatever it does not
//! recognise goes to the careful one, which tolerates CRLF, spaces around numbers, blank lines at the end and
//! a missing last newline, and says what is wrong with everything else.

use std::io::Read;
use std::path::Path;

use pellucid_machine::pixel::Fragment;

use super::Header;
use super::binary::MAGIC;
use super::csv_header;
use super::digits;
use super::error::TraceError;
use super::fields;
use super::starts::Start;
use super::window::Window;

/// The line that names the columns.
pub(super) const COLUMNS: &str = "x,y,z,r,g,b,a";

/// What may stand before a text in UTF-8.
const BYTE_ORDER_MARK: &[u8] = "\u{feff}".as_bytes();

/// Longest accepted line in bytes, spaces and line end included.
const MAX_LINE_BYTES: usize = 4096;

/// Bytes that the quick path looks at: the longest line that it takes, 7 fields of at most 8 digits, each
/// with its delimiter, and a line feed.
const QUICK_BYTES: usize = 7 * 9 + 1;

/// A reader at the start of a frame.
pub(super) struct Reader<'a, R> {
    lines: Lines<'a, R>,
    header: Header,
    /// Bytes of the file before the window's.
    skipped: u64,
}

impl<'a, R: Read> Reader<'a, R> {
    /// Reads and checks the first two lines. `path` is for messages.
    pub(super) fn new(path: &'a Path, reader: R) -> Result<Reader<'a, R>, TraceError> {
        let mut lines = Lines { path, window: Window::new(reader), number: 0 };
        lines.want_line()?;
        if lines.window.bytes().starts_with(BYTE_ORDER_MARK) {
            lines.window.consume(BYTE_ORDER_MARK.len());
        }
        if lines.window.bytes().starts_with(&MAGIC) {
            return Err(TraceError::OtherForm {
                path: path.to_owned(),
                found: "binary",
                extension: ".ptrace",
            });
        }
        let header = csv_header::parse(lines.next()?)
            .map_err(|problem| TraceError::line(path, 1, problem))?;
        let columns = lines.next()?;
        let found = columns.map(|line| line.split(|&byte| byte == b',').map(trim));
        if !found.is_some_and(|found| found.eq(fields::NAMES.map(str::as_bytes))) {
            let found = columns.map_or("the end of the file".into(), quote);
            let problem = format!("found {found}, expected the columns `{COLUMNS}`");
            return Err(TraceError::line(path, 2, problem));
        }
        Ok(Reader { lines, header, skipped: 0 })
    }

    /// A reader of what comes at the start of a frame in a file with that header.
    pub(super) fn at(path: &'a Path, reader: R, header: Header, start: Start) -> Reader<'a, R> {
        let lines = Lines { path, window: Window::new(reader), number: start.before };
        Reader { lines, header, skipped: start.offset }
    }

    pub(super) fn header(&self) -> Header {
        self.header
    }

    /// Where it is.
    pub(super) fn start(&self) -> Start {
        Start { offset: self.skipped + self.lines.window.used(), before: self.lines.number }
    }

    /// Plays the fragments of the frame with that number, and the line after it, of which there is none after the last.
    pub(super) fn frame<E: From<TraceError>>(
        &mut self,
        number: u32,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let path = self.lines.path;
        let largest = fields::largest(self.header.screen);
        let next = (number + 1 < self.header.frames).then(|| frame_line(number + 1));
        let mut blank = None;
        loop {
            if blank.is_none() {
                self.lines.quick(&largest, sink)?;
            }
            let Some(line) = self.lines.next()? else {
                let Some(next) = next else { return Ok(()) };
                let problem = format!(
                    "found the end of the file, expected `{next}`, as the first line says {} frames",
                    self.header.frames
                );
                return Err(TraceError::line(path, self.lines.number + 1, problem).into());
            };
            if trim(line).is_empty() {
                blank = blank.or(Some(self.lines.number));
                continue;
            }
            if let Some(blank) = blank {
                let problem =
                    format!("the line is empty, expected {COLUMNS} or the end of the file");
                return Err(TraceError::line(path, blank, problem).into());
            }
            if next.as_ref().is_some_and(|next| trim(line) == next.as_bytes()) {
                return Ok(());
            }
            let values = careful(line, &largest)
                .map_err(|problem| TraceError::line(path, self.lines.number, problem))?;
            sink(fields::fragment(values))?;
        }
    }
}

/// The line before the frame with that number.
pub(super) fn frame_line(number: u32) -> String {
    format!("# frame {number}")
}

/// The lines of a file, counted.
struct Lines<'a, R> {
    path: &'a Path,
    window: Window<R>,
    /// Lines handed out.
    number: u64,
}

impl<R: Read> Lines<'_, R> {
    fn want_line(&mut self) -> Result<(), TraceError> {
        self.window.want(MAX_LINE_BYTES).map_err(|error| TraceError::read(self.path, &error))
    }

    /// Plays lines while they have the plain form and lie in the window as a whole.
    fn quick<E>(
        &mut self,
        largest: &[u32; 7],
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let bytes = self.window.bytes();
        let mut used = 0;
        while let Some(text) = bytes[used..].first_chunk::<QUICK_BYTES>() {
            let Some((values, length)) = plain(text) else {
                break;
            };
            if !fields::in_range(&values, largest) {
                break;
            }
            sink(fields::fragment(values))?;
            used += length;
            self.number += 1;
        }
        self.window.consume(used);
        Ok(())
    }

    /// The next line without its line end, or `None` at the end of the file.
    fn next(&mut self) -> Result<Option<&[u8]>, TraceError> {
        self.want_line()?;
        let bytes = self.window.bytes();
        let reach = &bytes[..bytes.len().min(MAX_LINE_BYTES)];
        let (length, used) = match reach.iter().position(|&byte| byte == b'\n') {
            Some(end) => (end, end + 1),
            None if bytes.is_empty() => return Ok(None),
            None if bytes.len() >= MAX_LINE_BYTES => {
                let problem = format!("the line has more than {MAX_LINE_BYTES} bytes");
                return Err(TraceError::line(self.path, self.number + 1, problem));
            }
            None => (bytes.len(), bytes.len()),
        };
        self.number += 1;
        self.window.consume(used);
        let line = self.window.before(used, length);
        Ok(Some(line.strip_suffix(b"\r").unwrap_or(line)))
    }
}

/// The values of a line in plain form and its length in bytes with the line end, if it has that form.
fn plain(text: &[u8; QUICK_BYTES]) -> Option<([u32; 7], usize)> {
    let mut values = [0; 7];
    let mut at = 0;
    for value in &mut values[..6] {
        let (number, length) = digits::leading(text[at..].first_chunk()?)?;
        *value = number;
        at += length + 1;
        if text[at - 1] != b',' {
            return None;
        }
    }
    let (number, length) = digits::leading(text[at..].first_chunk()?)?;
    values[6] = number;
    at += length;
    match text[at] {
        b'\n' => Some((values, at + 1)),
        b'\r' if text[at + 1] == b'\n' => Some((values, at + 2)),
        _ => None,
    }
}

/// The values of any line, or what is wrong with it.
fn careful(line: &[u8], largest: &[u32; 7]) -> Result<[u32; 7], String> {
    let count = line.split(|&byte| byte == b',').count();
    if count != 7 {
        let s = if count == 1 { "" } else { "s" };
        let line = quote(line);
        return Err(format!("{line} has {count} field{s}, expected 7: {COLUMNS}"));
    }
    let mut values = [0; 7];
    for (i, field) in line.split(|&byte| byte == b',').enumerate() {
        let field = trim(field);
        values[i] = digits::integer(field, 0, largest[i])
            .ok_or_else(|| fields::problem(fields::NAMES[i], &quote(field), 0, largest[i]))?;
    }
    Ok(values)
}

/// Without spaces and tabs around.
pub(super) fn trim(mut text: &[u8]) -> &[u8] {
    while let [b' ' | b'\t', rest @ ..] | [rest @ .., b' ' | b'\t'] = text {
        text = rest;
    }
    text
}

/// What was found, as a message shows it: in back quotes, short, printable.
pub(super) fn quote(found: &[u8]) -> String {
    const LONGEST: usize = 40;
    if found.is_empty() {
        return "empty".into();
    }
    let text = match std::str::from_utf8(found) {
        Ok(text) => text.escape_debug().to_string(),
        Err(_) => found.escape_ascii().to_string(),
    };
    if text.chars().count() <= LONGEST {
        return format!("`{text}`");
    }
    let start: String = text.chars().take(LONGEST).collect();
    format!("`{start}...`")
}

/// The first two lines of a trace.
pub(super) fn header(Header { screen, frames }: Header) -> String {
    let [_, r, g, b] = screen.background.to_be_bytes();
    let (mark, width, height) = (csv_header::MARK, screen.width, screen.height);
    let frames = if frames > 1 { format!(" frames={frames}") } else { String::new() };
    format!("{mark} width={width} height={height} background={r},{g},{b}{frames}\n{COLUMNS}\n")
}

/// Appends a fragment's line.
pub(super) fn encode(fragment: Fragment, text: &mut Vec<u8>) {
    for (i, value) in fields::values(fragment).into_iter().enumerate() {
        if i > 0 {
            text.push(b',');
        }
        digits::append(value, text);
    }
    text.push(b'\n');
}

#[cfg(test)]
mod tests;
