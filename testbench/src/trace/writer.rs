//! Writing a trace of either form as a stream.

use std::io::Write;
use std::path::{Path, PathBuf};

use pellucid_machine::pixel::Fragment;

use super::error::TraceError;
use super::{Form, binary, csv, fields};
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
    count: u64,
    gathered: Vec<u8>,
    /// The error of an earlier write.
    failed: Option<OutputError>,
}

impl TraceWriter {
    /// Starts the trace that will be `path`, in the form that the name's ending says, `.csv` or `.ptrace`.
    ///
    /// # Errors
    /// Another ending, a frame without pixels or above `MAX_SIDE`, a folder that is missing or not writable.
    pub fn create(path: &Path, info: Screen) -> Result<TraceWriter, TraceError> {
        let form = Form::of(path)?;
        fields::check_frame(info)
            .map_err(|problem| TraceError::Frame { path: path.to_owned(), problem })?;
        let mut gathered = Vec::with_capacity(GATHER_BYTES + 128);
        match form {
            Form::Csv => gathered.extend_from_slice(csv::header(info).as_bytes()),
            Form::Binary => gathered.extend_from_slice(&binary::header(info)),
        }
        Ok(TraceWriter {
            path: path.to_owned(),
            file: AtomicFile::create(path)?,
            form,
            largest: fields::largest(info),
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

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// The disk is full, or the target cannot be replaced. Nothing is left behind then.
    pub fn finish(mut self) -> Result<(), TraceError> {
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
