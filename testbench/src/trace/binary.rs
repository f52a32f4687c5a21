//! The compact form of a trace, `.ptrace`: 16 or 18 bytes of header, then records of 11 bytes, little-endian.
//!
//! | part | bytes | content |
//! | --- | --- | --- |
//! | header | 0..8 | `89 50 54 52 41 43 45 01`: a byte that no text has, `PTRACE`, version 1 |
//! | | 8..10, 10..12 | width, height |
//! | | 12..15, 15 | background red, green, blue; zero |
//! | | 16..18 | in version 2 alone: number of frames, at least 2 |
//! | fragment | 0..2, 2..4 | x, y |
//! | | 4..7 | z |
//! | | 7..11 | red, green, blue, alpha |
//! | end | 0..4 | `FF FF FF FF`, an x and y that no frame has |
//! | | 4..11 | number of fragments |
//!
//! The number stands at the end, so that a writer need not know it beforehand and a reader finds a file that
//! was cut short. In version 2 each frame has its fragments and its end record, one frame after the other.

use std::io::Read;
use std::path::Path;

use pellucid_machine::pixel::Fragment;

use super::csv_header;
use super::error::TraceError;
use super::fields;
use super::starts::Start;
use super::window::Window;
use super::{Header, MOST_FRAMES};
use pellucid_machine::pixel::Screen;

/// The first bytes of a file, before its version.
pub(super) const MAGIC: [u8; 7] = *b"\x89PTRACE";
/// The version of a file with one frame, and that of one with several.
const VERSIONS: [u8; 2] = [1, 2];

/// Bytes of the header in version 1.
const HEADER_BYTES: usize = 16;
/// Bytes of the header in version 2.
const LONG_HEADER_BYTES: usize = 18;
/// Bytes of a fragment, and of the end record.
const RECORD_BYTES: usize = 11;
/// Records read at a time.
const BLOCK_RECORDS: usize = 1 << 14;

/// The header of a file.
pub(super) fn header(Header { screen, frames }: Header) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.push(VERSIONS[usize::from(frames > 1)]);
    bytes.extend_from_slice(&(screen.width as u16).to_le_bytes());
    bytes.extend_from_slice(&(screen.height as u16).to_le_bytes());
    bytes.extend_from_slice(&screen.background.to_be_bytes()[1..]);
    bytes.push(0);
    if frames > 1 {
        bytes.extend_from_slice(&(frames as u16).to_le_bytes());
    }
    bytes
}

/// Appends a fragment's record.
pub(super) fn encode(fragment: Fragment, bytes: &mut Vec<u8>) {
    let [x0, x1, ..] = fragment.x.to_le_bytes();
    let [y0, y1, ..] = fragment.y.to_le_bytes();
    let [z0, z1, z2, _] = fragment.z.to_le_bytes();
    let [r, g, b, a] = fragment.rgba.to_be_bytes();
    bytes.extend_from_slice(&[x0, x1, y0, y1, z0, z1, z2, r, g, b, a]);
}

/// The end record of a frame with so many fragments.
pub(super) fn end(count: u64) -> [u8; RECORD_BYTES] {
    let mut bytes = [0xff; RECORD_BYTES];
    bytes[4..].copy_from_slice(&count.to_le_bytes()[..7]);
    bytes
}

/// A reader at the start of a frame.
pub(super) struct Reader<'a, R> {
    path: &'a Path,
    window: Window<R>,
    header: Header,
    /// Where it began.
    start: Start,
}

impl<'a, R: Read> Reader<'a, R> {
    /// Reads and checks the header. `path` is for messages.
    pub(super) fn new(path: &'a Path, reader: R) -> Result<Reader<'a, R>, TraceError> {
        let mut window = Window::new(reader);
        window.want(LONG_HEADER_BYTES).map_err(|error| TraceError::read(path, &error))?;
        let bytes = window.bytes();
        if bytes.starts_with(csv_header::MARK.as_bytes()) {
            return Err(TraceError::OtherForm {
                path: path.to_owned(),
                found: "text",
                extension: ".csv",
            });
        }
        let (header, length) = parse_header(bytes).map_err(|(offset, problem)| {
            TraceError::Header { path: path.to_owned(), offset, problem }
        })?;
        window.consume(length);
        Ok(Reader { path, window, header, start: Start::default() })
    }

    /// A reader of what comes at the start of a frame in a file with that header.
    pub(super) fn at(path: &'a Path, reader: R, header: Header, start: Start) -> Reader<'a, R> {
        Reader { path, window: Window::new(reader), header, start }
    }

    pub(super) fn header(&self) -> Header {
        self.header
    }

    /// Where it is.
    pub(super) fn start(&self) -> Start {
        let offset = self.start.offset + self.window.used();
        let length = if self.header.frames > 1 { LONG_HEADER_BYTES } else { HEADER_BYTES };
        Start { offset, before: (offset - length as u64) / RECORD_BYTES as u64 }
    }

    /// Plays the fragments of the frame with that number, and checks its end and that of the file after the last.
    pub(super) fn frame<E: From<TraceError>>(
        &mut self,
        number: u32,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let largest = fields::largest(self.header.screen);
        let first = self.start().before;
        loop {
            self.want(RECORD_BYTES)?;
            let block = self.window.bytes();
            let block = &block[..block.len().min(RECORD_BYTES * BLOCK_RECORDS)];
            let mut used = 0;
            let mut other = None;
            for record in block.as_chunks::<RECORD_BYTES>().0 {
                let values = decode(record);
                if !fields::in_range(&values, &largest) {
                    other = Some((*record, values));
                    break;
                }
                sink(fields::fragment(values))?;
                used += RECORD_BYTES;
            }
            self.window.consume(used);
            if let Some((record, values)) = other {
                if record[..4] == [0xff; 4] {
                    let is_last = number + 1 == self.header.frames;
                    return Ok(self.check_end(record, self.start().before - first, is_last)?);
                }
                fields::check(&values, &largest).map_err(|problem| self.error(problem))?;
            }
            self.want(RECORD_BYTES)?;
            let left = self.window.bytes().len();
            if left < RECORD_BYTES {
                let problem = format!(
                    "the file is cut short, found {left} of {RECORD_BYTES} bytes, expected a fragment or the end record"
                );
                return Err(self.error(problem).into());
            }
        }
    }

    /// Checks the end record of a frame with so many fragments, and that nothing follows the last one.
    fn check_end(
        &mut self,
        record: [u8; RECORD_BYTES],
        expected: u64,
        is_last: bool,
    ) -> Result<(), TraceError> {
        let mut count = [0; 8];
        count[..7].copy_from_slice(&record[4..]);
        let found = u64::from_le_bytes(count);
        if found != expected {
            return Err(self.error(format!(
                "the end record counts {found} fragments, expected {expected}, as many as there are"
            )));
        }
        self.want(RECORD_BYTES + 1)?;
        if is_last && self.window.bytes().len() > RECORD_BYTES {
            return Err(
                self.error("bytes follow the end record, expected the end of the file".into())
            );
        }
        self.window.consume(RECORD_BYTES);
        Ok(())
    }

    fn want(&mut self, bytes: usize) -> Result<(), TraceError> {
        self.window.want(bytes).map_err(|error| TraceError::read(self.path, &error))
    }

    /// An error in the record that it is at.
    fn error(&self, problem: String) -> TraceError {
        let Start { offset, before } = self.start();
        TraceError::Record { path: self.path.to_owned(), record: before + 1, offset, problem }
    }
}

fn decode(record: &[u8; RECORD_BYTES]) -> [u32; 7] {
    let [x0, x1, y0, y1, z0, z1, z2, r, g, b, a] = record.map(u32::from);
    [x0 | x1 << 8, y0 | y1 << 8, z0 | z1 << 8 | z2 << 16, r, g, b, a]
}

/// What a header says and how many bytes it has, or the offset and what is wrong there.
fn parse_header(bytes: &[u8]) -> Result<(Header, usize), (u64, String)> {
    if !bytes.starts_with(&MAGIC) {
        return Err((0, "found no trace, expected the bytes 89 50 54 52 41 43 45".into()));
    }
    let cut = |expected: usize| {
        let problem = format!("the file is cut short, expected {expected} bytes of header");
        (bytes.len() as u64, problem)
    };
    let header = bytes.first_chunk::<HEADER_BYTES>().ok_or_else(|| cut(HEADER_BYTES))?;
    let [one, several] = VERSIONS;
    let version = header[MAGIC.len()];
    if !VERSIONS.contains(&version) {
        return Err((7, format!("version is {version}, expected {one} or {several}")));
    }
    let half = |bytes: &[u8], at: usize| u32::from(bytes[at]) | u32::from(bytes[at + 1]) << 8;
    let screen = Screen {
        width: half(header, 8),
        height: half(header, 10),
        background: u32::from_be_bytes([0, header[12], header[13], header[14]]),
    };
    fields::check_frame(screen).map_err(|problem| (8, problem))?;
    if header[15] != 0 {
        return Err((15, format!("found {}, expected 0", header[15])));
    }
    if version == one {
        return Ok((Header { screen, frames: 1 }, HEADER_BYTES));
    }
    let header = bytes.first_chunk::<LONG_HEADER_BYTES>().ok_or_else(|| cut(LONG_HEADER_BYTES))?;
    match half(header, HEADER_BYTES) {
        frames @ 2.. => Ok((Header { screen, frames }, LONG_HEADER_BYTES)),
        frames => Err((16, fields::problem("frames", &frames.to_string(), 2, MOST_FRAMES))),
    }
}

#[cfg(test)]
mod tests;
