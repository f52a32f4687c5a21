//! Traces: the bytes are read in either form as the description of the format says, or refused where it says.
//!
//! What is read and written again reads the same, in either form.

use crate::{path, write};
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_testbench::trace::{Trace, TraceError, TraceWriter};
use std::fs;
use std::path::Path;

/// Bytes of the binary form's header.
const HEADER_BYTES: usize = 16;
/// Bytes of each of its records.
const RECORD_BYTES: usize = 11;
/// A line of the text form has fewer bytes.
const LINE_BYTES: usize = 4096;

/// Reads the bytes as either form.
///
/// # Panics
/// They are not read or refused as they must be.
pub fn check(bytes: &[u8]) {
    check_text(bytes);
    check_binary(bytes);
}

fn check_text(bytes: &[u8]) {
    let path = write("trace.csv", bytes);
    let trace = match Trace::open(&path) {
        Ok(trace) => trace,
        Err(error) => {
            check_message(&error, &path);
            let refused = match error {
                TraceError::Line { line, .. } => line == 1 || line == 2,
                TraceError::OtherForm { .. } => bytes.starts_with(b"\x89PTRACE"),
                _ => false,
            };
            assert!(refused, "the first two lines are refused by {error:?}");
            return;
        }
    };
    let (fragments, end) = play(&trace);
    let (expected, wrong) = described(bytes, trace.info());
    assert_eq!(fragments, expected);
    match end {
        Ok(()) => {
            assert_eq!(wrong, None, "a wrong line is read");
            check_written(trace.info(), &fragments);
        }
        Err(error) => {
            check_message(&error, &path);
            let TraceError::Line { line, .. } = error else { panic!("refused by {error:?}") };
            assert_eq!(wrong, Some(line), "the line that is wrong");
        }
    }
}

fn check_binary(bytes: &[u8]) {
    let path = write("trace.ptrace", bytes);
    let trace = match Trace::open(&path) {
        Ok(trace) => trace,
        Err(error) => {
            check_message(&error, &path);
            let refused = match error {
                TraceError::Header { offset, .. } => {
                    offset < HEADER_BYTES as u64 && offset <= bytes.len() as u64
                }
                TraceError::OtherForm { .. } => bytes.starts_with(b"# pellucid-trace"),
                _ => false,
            };
            assert!(refused, "the header is refused by {error:?}");
            return;
        }
    };
    let (fragments, end) = play(&trace);
    check_on_screen(&fragments, trace.info());
    let Err(error) = end else {
        let written = check_written(trace.info(), &fragments);
        assert!(written == bytes, "the same trace has other bytes");
        return;
    };
    check_message(&error, &path);
    let TraceError::Record { record, offset, .. } = error else { panic!("refused by {error:?}") };
    assert_eq!(record, fragments.len() as u64 + 1, "the fragments before the wrong record");
    assert_eq!(offset, (HEADER_BYTES + RECORD_BYTES * fragments.len()) as u64);
    // It is that record that is wrong: what comes before is right.
    let before = bytes.get(..offset as usize).expect("the wrong record begins in the file");
    let count = fragments.len() as u64;
    let end = [&[0xff; 4][..], &count.to_le_bytes()[..RECORD_BYTES - 4]].concat();
    let trace = Trace::open(&write("before.ptrace", &[before, &end].concat()));
    let (again, end) = play(&trace.expect("the header is as it was"));
    end.expect("what comes before the wrong record is right");
    assert_eq!(again, fragments);
}

/// Every fragment, and how the play ended; the same at a second play.
fn play(trace: &Trace) -> (Vec<Fragment>, Result<(), TraceError>) {
    let once = || {
        let mut fragments = vec![];
        let end = trace.play::<TraceError>(&mut |fragment| {
            fragments.push(fragment);
            Ok(())
        });
        (fragments, end)
    };
    let (first, second) = (once(), once());
    assert_eq!(first.0, second.0, "a second play");
    first
}

/// Writes the trace in either form and reads it back; the bytes of the binary form.
fn check_written(info: Screen, fragments: &[Fragment]) -> Vec<u8> {
    for name in ["again.csv", "again.ptrace"] {
        let path = path(name);
        let mut writer = TraceWriter::create(&path, info).expect("what was read can be written");
        for &fragment in fragments {
            writer.push(fragment).expect("what was read can be written");
        }
        writer.finish().expect("a temporary file");
        let trace = Trace::open(&path).expect("what was written can be read");
        assert_eq!(trace.info(), info, "{name}");
        let (again, end) = play(&trace);
        end.expect("what was written can be read");
        assert_eq!(again, fragments, "{name}");
    }
    fs::read(path("again.ptrace")).expect("a temporary file")
}

fn check_on_screen(fragments: &[Fragment], info: Screen) {
    for f in fragments {
        assert!(f.x < info.width && f.y < info.height && f.z <= Z_FAR, "{f:?} outside {info:?}");
    }
}

fn check_message(error: &TraceError, path: &Path) {
    let (text, path) = (error.to_string(), path.display().to_string());
    assert!(text.starts_with(&format!("`{path}`")), "no file is named: {text}");
    assert!(text.contains("expected") || text.contains("rename") || text.contains("has more than"));
}

/// The fragments of the text form before the first wrong line, and its number, by the description of the format: one
/// field after the other, without a second path for plain lines.
fn described(bytes: &[u8], info: Screen) -> (Vec<Fragment>, Option<u64>) {
    let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
    if lines.last().is_some_and(|line| line.is_empty()) {
        lines.pop();
    }
    let (mut fragments, mut blank) = (vec![], None);
    for (number, line) in (1..).zip(lines).skip(2) {
        if line.len() >= LINE_BYTES {
            return (fragments, Some(number));
        }
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        if line.iter().all(|byte| b" \t".contains(byte)) {
            blank = blank.or(Some(number));
        } else if blank.is_some() {
            return (fragments, blank);
        } else if let Some(fragment) = described_line(line, info) {
            fragments.push(fragment);
        } else {
            return (fragments, Some(number));
        }
    }
    (fragments, None)
}

fn described_line(line: &[u8], info: Screen) -> Option<Fragment> {
    let text = std::str::from_utf8(line).ok()?;
    let values = text.split(',').map(|field| {
        let digits = field.trim_matches([' ', '\t']);
        let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        let value = digits.trim_start_matches('0');
        plain.then(|| if value.is_empty() { Ok(0) } else { value.parse::<u32>() })?.ok()
    });
    let values: Vec<u32> = values.collect::<Option<_>>()?;
    let [x, y, z, r, g, b, a] = values[..] else { return None };
    let fits = x < info.width && y < info.height && z <= Z_FAR;
    let rgba = [r, g, b, a].map(|channel| u8::try_from(channel).ok());
    let [Some(r), Some(g), Some(b), Some(a)] = rgba else { return None };
    let rgba = u32::from_be_bytes([r, g, b, a]);
    fits.then(|| Fragment { x, y, z, rgba, ..Fragment::default() })
}
