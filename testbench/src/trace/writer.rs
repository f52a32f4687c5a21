//! Writing a trace of either form as a stream.

use std::io::Write;
use std::path::{Path, PathBuf};

use pellucid_machine::pixel::Fragment;

use super::error::TraceError;
use super::{Form, Header, MOST_FRAMES, binary, csv, fields};
use crate::output::{AtomicFile, OutputError};
use pellucid_machine::pixel::Screen;

/// Bytes gathered before they go to the file.
const GATHER_BYTES: usize = 1 << 16;

/// Writes a trace; the file has its name only when [`TraceWriter::finish`] succeeds.
///
/// Dropped unfinished, or after an error, it leaves nothing behind.
#[derive(Debug)]
pub struct TraceWriter {
    path: PathBuf,
    file: AtomicFile,
    form: Form,
    largest: [u32; 7],
    header: Header,
    /// Which frame is being written, from 0.
    number: u32,
    /// Fragments of it so far.
    count: u64,
    gathered: Vec<u8>,
    /// The error of an earlier write.
    failed: Option<OutputError>,
}

impl TraceWriter {
    /// Starts the trace that will be `path`, of so many frames, in the form that the name's ending says, `.csv` or `.ptrace`.
    ///
    /// # Errors
    /// Another ending, no frames or more than [`MOST_FRAMES`], frames without pixels or above `MAX_SIDE`, a folder that is missing or
    /// not writable.
    pub fn create(path: &Path, screen: Screen, frames: u32) -> Result<TraceWriter, TraceError> {
        let form = Form::of(path)?;
        let counted = match frames {
            1..=MOST_FRAMES => Ok(()),
            _ => Err(fields::problem("frames", &frames.to_string(), 1, MOST_FRAMES)),
        };
        counted
            .and_then(|()| fields::check_frame(screen))
            .map_err(|problem| TraceError::Frame { path: path.to_owned(), problem })?;
        let header = Header { screen, frames };
        let mut gathered = Vec::with_capacity(GATHER_BYTES + 128);
        match form {
            Form::Csv => gathered.extend_from_slice(csv::header(header).as_bytes()),
            Form::Binary => gathered.extend_from_slice(&binary::header(header)),
        }
        Ok(TraceWriter {
            path: path.to_owned(),
            file: AtomicFile::create(path)?,
            form,
            largest: fields::largest(screen),
            header,
            number: 0,
            count: 0,
            gathered,
            failed: None,
        })
    }

    /// Writes the next fragment in arrival order.
    ///
    /// # Errors
    /// The fragment is outside the frame or its depth beyond 24 bits; the disk is full.
    pub fn push(&mut self, fragment: Fragment) -> Result<(), TraceError> {
        fields::check(&fields::values(fragment), &self.largest).map_err(|problem| {
            TraceError::Fragment { path: self.path.clone(), number: self.count + 1, problem }
        })?;
        match self.form {
            Form::Csv => csv::encode(fragment, &mut self.gathered),
            Form::Binary => binary::encode(fragment, &mut self.gathered),
        }
        self.count += 1;
        if self.gathered.len() >= GATHER_BYTES {
            self.write_gathered()?;
        }
        Ok(())
    }

    /// Ends the frame; what is written from now on is the next one.
    ///
    /// # Errors
    /// The disk is full.
    ///
    /// # Panics
    /// It is the last one.
    pub fn next_frame(&mut self) -> Result<(), TraceError> {
        self.number += 1;
        assert!(self.number < self.header.frames, "the frame is not the last one");
        match self.form {
            Form::Csv => {
                let line = csv::frame_line(self.number);
                self.gathered.extend_from_slice(line.as_bytes());
                self.gathered.push(b'\n');
            }
            Form::Binary => self.gathered.extend_from_slice(&binary::end(self.count)),
        }
        self.count = 0;
        self.write_gathered()
    }

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// The disk is full, or the target cannot be replaced. Nothing is left behind then.
    ///
    /// # Panics
    /// There are frames left to be written.
    pub fn finish(mut self) -> Result<(), TraceError> {
        assert_eq!(self.number + 1, self.header.frames, "all frames are written");
        if self.form == Form::Binary {
            self.gathered.extend_from_slice(&binary::end(self.count));
        }
        self.write_gathered()?;
        Ok(self.file.finish()?)
    }

    fn write_gathered(&mut self) -> Result<(), TraceError> {
        // After a failed write a part may be missing: no later one may succeed, nor the file get its name.
        if let Some(error) = &self.failed {
            return Err(error.clone().into());
        }
        let written = self.file.write_all(&self.gathered);
        self.gathered.clear();
        written.map_err(|error| {
            let error = OutputError::write(&self.path, &error);
            self.failed = Some(error.clone());
            error.into()
        })
    }
}
