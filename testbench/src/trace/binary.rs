//! The compact form of a trace, `.ptrace`: 16 bytes of header, then records of 11 bytes, little-endian.
//!
//! | part | bytes | content |
//! | --- | --- | --- |
//! | header | 0..8 | `89 50 54 52 41 43 45 01`: a byte that no text has, `PTRACE`, version 1 |
//! | | 8..10, 10..12 | width, height |
//! | | 12..15, 15 | background red, green, blue; zero |
//! | fragment | 0..2, 2..4 | x, y |
//! | | 4..7 | z |
//! | | 7..11 | red, green, blue, alpha |
//! | end | 0..4 | `FF FF FF FF`, an x and y that no frame has |
//! | | 4..11 | number of fragments |
//!
//! The number stands at the end, so that a writer need not know it beforehand and a reader finds a file that
//! was cut short.

use std::io::Read;
use std::path::Path;

use pellucid_machine::pixel::Fragment;

use super::csv_header;
use super::error::TraceError;
use super::fields;
use super::window::Window;
use pellucid_machine::pixel::Screen;

/// The first bytes of a file; the last of them is the version.
pub(super) const MAGIC: [u8; 8] = *b"\x89PTRACE\x01";

/// Bytes of the header.
const HEADER_BYTES: usize = 16;
/// Bytes of a fragment, and of the end record.
const RECORD_BYTES: usize = 11;
/// Records read at a time.
const BLOCK_RECORDS: usize = 1 << 14;

/// The header of a file.
pub(super) fn header(info: Screen) -> [u8; HEADER_BYTES] {
    let mut bytes = [0; HEADER_BYTES];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..10].copy_from_slice(&(info.width as u16).to_le_bytes());
    bytes[10..12].copy_from_slice(&(info.height as u16).to_le_bytes());
    bytes[12..15].copy_from_slice(&info.background.to_be_bytes()[1..]);
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

/// The end record of a file with so many fragments.
pub(super) fn end(count: u64) -> [u8; RECORD_BYTES] {
    let mut bytes = [0xff; RECORD_BYTES];
    bytes[4..].copy_from_slice(&count.to_le_bytes()[..7]);
    bytes
}

/// A reader past the header.
pub(super) struct Reader<'a, R> {
    path: &'a Path,
    window: Window<R>,
    info: Screen,
    /// Fragments read.
    count: u64,
}

impl<'a, R: Read> Reader<'a, R> {
    /// Reads and checks the header. `path` is for messages.
    pub(super) fn new(path: &'a Path, reader: R) -> Result<Reader<'a, R>, TraceError> {
        let mut window = Window::new(reader);
        window.want(HEADER_BYTES).map_err(|error| TraceError::read(path, &error))?;
        let bytes = window.bytes();
        if bytes.starts_with(csv_header::MARK.as_bytes()) {
            return Err(TraceError::OtherForm {
                path: path.to_owned(),
                found: "text",
                extension: ".csv",
            });
        }
        let info = parse_header(bytes).map_err(|(offset, problem)| TraceError::Header {
            path: path.to_owned(),
            offset,
            problem,
        })?;
        window.consume(HEADER_BYTES);
        Ok(Reader { path, window, info, count: 0 })
    }

    pub(super) fn info(&self) -> Screen {
        self.info
    }

    /// Plays all fragments and checks the end.
    pub(super) fn play<E: From<TraceError>>(
        mut self,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let largest = fields::largest(self.info);
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
                self.count += 1;
            }
            self.window.consume(used);
            if let Some((record, values)) = other {
                if record[..4] == [0xff; 4] {
                    return Ok(self.check_end(record)?);
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

    /// Checks the end record, which is not consumed yet, and that nothing follows.
    fn check_end(&mut self, record: [u8; RECORD_BYTES]) -> Result<(), TraceError> {
        let mut count = [0; 8];
        count[..7].copy_from_slice(&record[4..]);
        let (found, expected) = (u64::from_le_bytes(count), self.count);
        if found != expected {
            return Err(self.error(format!(
                "the end record counts {found} fragments, expected {expected}, as many as there are"
            )));
        }
        self.want(RECORD_BYTES + 1)?;
        if self.window.bytes().len() > RECORD_BYTES {
            return Err(
                self.error("bytes follow the end record, expected the end of the file".into())
            );
        }
        Ok(())
    }

    fn want(&mut self, bytes: usize) -> Result<(), TraceError> {
        self.window.want(bytes).map_err(|error| TraceError::read(self.path, &error))
    }

    /// An error in the record after the fragments read.
    fn error(&self, problem: String) -> TraceError {
        TraceError::Record {
            path: self.path.to_owned(),
            record: self.count + 1,
            offset: HEADER_BYTES as u64 + self.count * RECORD_BYTES as u64,
            problem,
        }
    }
}

fn decode(record: &[u8; RECORD_BYTES]) -> [u32; 7] {
    let [x0, x1, y0, y1, z0, z1, z2, r, g, b, a] = record.map(u32::from);
    [x0 | x1 << 8, y0 | y1 << 8, z0 | z1 << 8 | z2 << 16, r, g, b, a]
}

/// The frame of a header, or the offset and what is wrong there.
fn parse_header(bytes: &[u8]) -> Result<Screen, (u64, String)> {
    let magic = bytes.iter().zip(&MAGIC).take_while(|(a, b)| a == b).count();
    if magic < 7 {
        return Err((0, "found no trace, expected the bytes 89 50 54 52 41 43 45".into()));
    }
    let Some(header) = bytes.first_chunk::<HEADER_BYTES>() else {
        let found = bytes.len();
        let problem = format!("the file is cut short, expected {HEADER_BYTES} bytes of header");
        return Err((found as u64, problem));
    };
    if magic < MAGIC.len() {
        return Err((7, format!("version is {}, expected {}", header[7], MAGIC[7])));
    }
    let half = |at: usize| u32::from(header[at]) | u32::from(header[at + 1]) << 8;
    let info = Screen {
        width: half(8),
        height: half(10),
        background: u32::from_be_bytes([0, header[12], header[13], header[14]]),
    };
    fields::check_frame(info).map_err(|problem| (8, problem))?;
    match header[15] {
        0 => Ok(info),
        found => Err((15, format!("found {found}, expected 0"))),
    }
}

#[cfg(test)]
mod tests;
