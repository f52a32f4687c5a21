//! Fragment traces: what a rasteriser handed over, in arrival order, in a file.
//!
//! Two forms have the same content. The text form (`.csv`) is for people and other programs; the binary form
//! (`.ptrace`) is usually less than half as long and several times faster to read. Both are read and written as a
//! stream in constant memory, so a trace may be larger than memory. The name's ending says the form.

mod binary;
mod csv;
mod csv_header;
mod digits;
mod error;
mod fields;
mod window;
mod writer;

use std::fs::File;
use std::path::{Path, PathBuf};

use pellucid_machine::pixel::Fragment;

pub use error::TraceError;
use pellucid_machine::pixel::Screen;
pub use writer::TraceWriter;

/// A trace file whose header has been checked.
#[derive(Clone, Debug)]
pub struct Trace {
    path: PathBuf,
    info: Screen,
}

impl Trace {
    /// Opens a trace and checks its header. The fragments are checked as they are played.
    ///
    /// # Errors
    /// The name ends neither in `.csv` nor in `.ptrace` (in any case), the file is missing or no regular file,
    /// or its header is wrong.
    pub fn open(path: &Path) -> Result<Trace, TraceError> {
        let info = Reader::open(path)?.info();
        Ok(Trace { path: path.to_owned(), info })
    }

    /// Size and background of the frame.
    pub fn info(&self) -> Screen {
        self.info
    }

    /// Reads the file from its start and hands every fragment to `sink`, in arrival order; the same at every call.
    ///
    /// # Errors
    /// The first error of the file or of `sink`. `sink` has had every fragment before it.
    pub fn play<E: From<TraceError>>(
        &self,
        sink: &mut dyn FnMut(Fragment) -> Result<(), E>,
    ) -> Result<(), E> {
        let reader = Reader::open(&self.path)?;
        if reader.info() != self.info {
            let path = self.path.clone();
            return Err(TraceError::Changed { path }.into());
        }
        match reader {
            Reader::Csv(reader) => reader.play(sink),
            Reader::Binary(reader) => reader.play(sink),
        }
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

/// A reader of either form, past the header.
enum Reader<'a> {
    Csv(csv::Reader<'a, File>),
    Binary(binary::Reader<'a, File>),
}

impl Reader<'_> {
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

    fn info(&self) -> Screen {
        match self {
            Reader::Csv(reader) => reader.info(),
            Reader::Binary(reader) => reader.info(),
        }
    }
}

#[cfg(test)]
mod tests;
