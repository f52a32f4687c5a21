//! Fragment traces: what a rasteriser handed over, in arrival order, in a file.
//!
//! Two forms have the same content. The text form (`.csv`) is for people and other programs; the binary form
//! (`.ptrace`) is usually less than half as long and several times faster to read. Both are read and written as a
//! stream in constant memory, so a trace may be larger than memory. The name's ending says the form. A trace may have several
//! frames, one after the other, on one screen.

mod binary;
mod csv;
mod csv_header;
mod digits;
mod error;
mod fields;
mod starts;
mod window;
mod writer;

use std::fs::File;
use std::io::{Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use pellucid_machine::pixel::Fragment;

pub use error::TraceError;
use pellucid_machine::pixel::Screen;
use starts::{Start, Starts};
pub use writer::TraceWriter;

/// The most frames of a trace.
pub const MOST_FRAMES: u32 = u16::MAX as u32;

/// What the header of a file says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Header {
    screen: Screen,
    /// Frames, `1..=MOST_FRAMES`.
    frames: u32,
}

/// A frame of a trace file whose header has been checked.
#[derive(Clone, Debug)]
pub struct Trace {
    path: PathBuf,
    header: Header,
    /// Which frame it is, from 0.
    number: u32,
    /// Whether it is taken as the only one.
    alone: bool,
    starts: Arc<Starts>,
}

impl Trace {
    /// Opens a trace at its first frame and checks its header. The fragments are checked as they are played.
    ///
    /// # Errors
    /// The name ends neither in `.csv` nor in `.ptrace` (in any case), the file is missing or no regular file,
    /// or its header is wrong.
    pub fn open(path: &Path) -> Result<Trace, TraceError> {
        let reader = Reader::open(path)?;
        let starts = Arc::new(Starts::new(reader.start()));
        Ok(Trace {
            path: path.to_owned(),
            header: reader.header(),
            number: 0,
            alone: false,
            starts,
        })
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Size and background of each frame.
    pub fn info(&self) -> Screen {
        self.header.screen
    }

    /// How many frames there are.
    pub fn frames(&self) -> u32 {
        if self.alone { 1 } else { self.header.frames }
    }

    /// The frame without those that come after it.
    #[must_use]
    pub fn alone(self) -> Trace {
        Trace { alone: true, ..self }
    }

    /// The frame so many frames later; nothing if there is one alone.
    ///
    /// # Errors
    /// There are fewer.
    pub fn later(&self, frames: u32) -> Result<Option<Trace>, TraceError> {
        if self.frames() == 1 {
            return Ok(None);
        }
        let number = self.number.saturating_add(frames);
        if number >= self.header.frames {
            let (path, frames) = (self.path.clone(), self.header.frames);
            return Err(TraceError::Frames { path, frames, number });
        }
        Ok(Some(Trace { number, ..self.clone() }))
    }

    /// Reads the frame from the file and hands every fragment to `sink`, in arrival order; the same at every call. Where frames
    /// begin is remembered, so that each is found at once after the one before has been played.
    ///
    /// # Errors
    /// The first error of the file or of `sink`. `sink` has had every fragment before it.
    pub fn play<E: From<TraceError>>(
        &self,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut reader = Reader::open(&self.path)?;
        if reader.header() != self.header {
            let path = self.path.clone();
            return Err(TraceError::Changed { path }.into());
        }
        let (nearest, start) = self.starts.nearest(self.number);
        if nearest > 0 {
            reader = Reader::at(&self.path, self.header, start)?;
        }
        for number in nearest..self.number {
            reader.frame::<TraceError>(number, &mut |_| Ok(()))?;
            self.starts.found(number + 1, reader.start());
        }
        reader.frame(self.number, sink)?;
        self.starts.found(self.number + 1, reader.start());
        Ok(())
    }
}

/// The form of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Form {
    Csv,
    Binary,
}

impl Form {
    /// The form that a name's ending says.
    fn of(path: &Path) -> Result<Form, TraceError> {
        match path.extension() {
            Some(ending) if ending.eq_ignore_ascii_case("csv") => Ok(Form::Csv),
            Some(ending) if ending.eq_ignore_ascii_case("ptrace") => Ok(Form::Binary),
            _ => Err(TraceError::Name { path: path.to_owned() }),
        }
    }
}

/// A reader of either form, at the start of a frame.
enum Reader<'a> {
    Csv(csv::Reader<'a, File>),
    Binary(binary::Reader<'a, File>),
}

impl Reader<'_> {
    /// At the first frame, after the header, which is checked.
    fn open(path: &Path) -> Result<Reader<'_>, TraceError> {
        let form = Form::of(path)?;
        let refused =
            |reason: &str| TraceError::Read { path: path.to_owned(), reason: reason.to_owned() };
        let found = std::fs::metadata(path).map_err(|error| TraceError::read(path, &error))?;
        if found.is_dir() {
            return Err(refused("it is a folder, expected a file"));
        }
        // A pipe would give its content only once, and opening it could wait for ever.
        if !found.is_file() {
            return Err(refused("it is no regular file, and a trace is read more than once"));
        }
        let file = File::open(path).map_err(|error| TraceError::read(path, &error))?;
        Ok(match form {
            Form::Csv => Reader::Csv(csv::Reader::new(path, file)?),
            Form::Binary => Reader::Binary(binary::Reader::new(path, file)?),
        })
    }

    /// At a later frame of a file with that header.
    fn at(path: &Path, header: Header, start: Start) -> Result<Reader<'_>, TraceError> {
        let mut file = File::open(path).map_err(|error| TraceError::read(path, &error))?;
        let sought = file.seek(SeekFrom::Start(start.offset));
        sought.map_err(|error| TraceError::read(path, &error))?;
        Ok(match Form::of(path)? {
            Form::Csv => Reader::Csv(csv::Reader::at(path, file, header, start)),
            Form::Binary => Reader::Binary(binary::Reader::at(path, file, header, start)),
        })
    }

    fn header(&self) -> Header {
        match self {
            Reader::Csv(reader) => reader.header(),
            Reader::Binary(reader) => reader.header(),
        }
    }

    /// Where it is.
    fn start(&self) -> Start {
        match self {
            Reader::Csv(reader) => reader.start(),
            Reader::Binary(reader) => reader.start(),
        }
    }

    /// Plays the frame that it is at, which has that number, and goes to the next; checks the end of the file after the last.
    fn frame<E: From<TraceError>>(
        &mut self,
        number: u32,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        match self {
            Reader::Csv(reader) => reader.frame(number, sink),
            Reader::Binary(reader) => reader.frame(number, sink),
        }
    }
}

#[cfg(test)]
mod tests;
