//! What can be wrong with a trace, each as one sentence: where, what was found, what was expected.

use std::io;
use std::path::{Path, PathBuf};

use crate::output::{OutputError, reason};

/// A trace that cannot be read or written.
#[derive(Debug, thiserror::Error)]
pub enum TraceError {
    /// The name does not say which form the trace has.
    #[error("`{}` does not name a trace, expected a name that ends in `.csv` or `.ptrace`", path.display())]
    Name {
        /// The path.
        path: PathBuf,
    },
    /// The file is missing or cannot be read.
    #[error("cannot read `{}`: {reason}", path.display())]
    Read {
        /// The path.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// The file has the other form than its name says.
    #[error("`{}` holds a {found} trace, rename it to end in `{extension}`", path.display())]
    OtherForm {
        /// The path.
        path: PathBuf,
        /// The form found.
        found: &'static str,
        /// The ending of that form.
        extension: &'static str,
    },
    /// A line of the text form is wrong.
    #[error("`{}`, line {line}: {problem}", path.display())]
    Line {
        /// The path.
        path: PathBuf,
        /// Line number, from 1.
        line: u64,
        /// What was found and what was expected.
        problem: String,
    },
    /// The header of the binary form is wrong.
    #[error("`{}`, byte {offset}: {problem}", path.display())]
    Header {
        /// The path.
        path: PathBuf,
        /// Offset from the start of the file in bytes.
        offset: u64,
        /// What was found and what was expected.
        problem: String,
    },
    /// A record of the binary form is wrong.
    #[error("`{}`, record {record} at byte {offset}: {problem}", path.display())]
    Record {
        /// The path.
        path: PathBuf,
        /// Record number, from 1.
        record: u64,
        /// Offset of the record from the start of the file in bytes.
        offset: u64,
        /// What was found and what was expected.
        problem: String,
    },
    /// The header is not the one that was there when the trace was opened.
    #[error("`{}` was changed while it was in use, expected the header that it had when it was opened", path.display())]
    Changed {
        /// The path.
        path: PathBuf,
    },
    /// There are fewer frames than are asked for.
    #[error("`{}` has no frame {number}, expected a frame from 0 to {}", path.display(), frames - 1)]
    Frames {
        /// The path.
        path: PathBuf,
        /// How many there are.
        frames: u32,
        /// Which one is asked for, from 0.
        number: u32,
    },
    /// A trace of such a frame cannot be written.
    #[error("cannot write `{}`: {problem}", path.display())]
    Frame {
        /// The path.
        path: PathBuf,
        /// What was given and what was expected.
        problem: String,
    },
    /// A fragment that no trace of this frame can hold was to be written.
    #[error("cannot write `{}`: fragment {number}: {problem}", path.display())]
    Fragment {
        /// The path.
        path: PathBuf,
        /// The fragment's number in arrival order, from 1.
        number: u64,
        /// What was given and what was expected.
        problem: String,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

impl TraceError {
    pub(super) fn read(path: &Path, error: &io::Error) -> TraceError {
        TraceError::Read { path: path.to_owned(), reason: reason(error) }
    }

    pub(super) fn line(path: &Path, line: u64, problem: String) -> TraceError {
        TraceError::Line { path: path.to_owned(), line, problem }
    }
}
