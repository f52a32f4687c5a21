//! Traces: the bytes are read in either form as the description of the format says, or refused where it says.
//!
//! What is read and written again reads the same, in either form. A file may have several frames; they are read from the last to the
//! first too, of a file of which nothing is known yet.

use crate::{path, write};
use pellucid_machine::pixel::{Fragment, Screen, Z_FAR};
use pellucid_testbench::trace::{Trace, TraceError, TraceWriter};
use std::fs;
use std::path::Path;

/// The fragments of each frame.
type Frames = Vec<Vec<Fragment>>;

/// Bytes of the binary form's header with one frame, and with several.
const HEADER_BYTES: [usize; 2] = [16, 18];
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
    let (frames, end) = play(&trace);
    let (expected, wrong) = described(bytes, &trace);
    assert_eq!(frames, expected);
    match end {
        Ok(()) => {
            assert_eq!(wrong, None, "a wrong line is read");
            check_written(trace.info(), &frames);
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
                    offset < HEADER_BYTES[1] as u64 && offset <= bytes.len() as u64
                }
                TraceError::OtherForm { .. } => bytes.starts_with(b"# pellucid-trace"),
                _ => false,
            };
            assert!(refused, "the header is refused by {error:?}");
            return;
        }
    };
    let (frames, end) = play(&trace);
    frames.iter().for_each(|frame| check_on_screen(frame, trace.info()));
    let Err(error) = end else {
        let written = check_written(trace.info(), &frames);
        assert!(written == bytes, "the same trace has other bytes");
        return;
    };
    check_message(&error, &path);
    let TraceError::Record { record, offset, .. } = error else { panic!("refused by {error:?}") };
    // Those of the frame that is wrong, and fragments and end records of those before.
    let before = frames.iter().map(Vec::len).sum::<usize>() + frames.len() - 1;
    assert_eq!(record, before as u64 + 1, "the records before the wrong one");
    let header = HEADER_BYTES[usize::from(trace.frames() > 1)];
    assert_eq!(offset, (header + RECORD_BYTES * before) as u64);
    // It is that record that is wrong: what comes before is right, and with an end record a whole trace of so many frames.
    let records = bytes.get(header..offset as usize).expect("the wrong record is in the file");
    let count = frames.len() as u16;
    let mut whole = bytes[..HEADER_BYTES[0]].to_vec();
    whole[7] = if count > 1 { 2 } else { 1 };
    if count > 1 {
        whole.extend_from_slice(&count.to_le_bytes());
    }
    whole.extend_from_slice(records);
    whole.extend_from_slice(&[0xff; 4]);
    let last = frames.last().expect("the wrong one is among them").len() as u64;
    whole.extend_from_slice(&last.to_le_bytes()[..RECORD_BYTES - 4]);
    let trace = Trace::open(&write("before.ptrace", &whole)).expect("the header is as it was");
    let (again, end) = play(&trace);
    end.expect("what comes before the wrong record is right");
    assert_eq!(again, frames);
}

/// Every frame up to the one that is wrong, if one is, with the fragments before what is wrong; the same from the last to the first,
/// and at a second play.
fn play(trace: &Trace) -> (Frames, Result<(), TraceError>) {
    let forwards = played(trace, 0..trace.frames());
    let other = Trace::open(trace.path()).expect("it was opened");
    let backwards = played(&other, (0..forwards.0.len() as u32).rev());
    let again = played(trace, 0..trace.frames());
    assert_eq!(again.0, forwards.0, "a second play");
    if forwards.1.is_ok() {
        assert!(backwards.0.iter().rev().eq(&forwards.0), "from the last to the first");
    }
    forwards
}

/// The frames of these numbers, up to the first that is wrong.
fn played(trace: &Trace, numbers: impl Iterator<Item = u32>) -> (Frames, Result<(), TraceError>) {
    let mut frames = vec![];
    for number in numbers {
        let later = trace.later(number).expect("there are so many");
        let mut fragments = vec![];
        let end = later.as_ref().unwrap_or(trace).play::<TraceError>(&mut |fragment| {
            fragments.push(fragment);
            Ok(())
        });
        frames.push(fragments);
        if end.is_err() {
            return (frames, end);
        }
    }
    (frames, Ok(()))
}

/// Writes the trace in either form and reads it back; the bytes of the binary form.
fn check_written(info: Screen, frames: &Frames) -> Vec<u8> {
    for name in ["again.csv", "again.ptrace"] {
        let path = path(name);
        let count = frames.len() as u32;
        let writer = TraceWriter::create(&path, info, count);
        let mut writer = writer.expect("what was read can be written");
        for (number, frame) in frames.iter().enumerate() {
            if number > 0 {
                writer.next_frame().expect("what was read can be written");
            }
            for &fragment in frame {
                writer.push(fragment).expect("what was read can be written");
            }
        }
        writer.finish().expect("a temporary file");
        let trace = Trace::open(&path).expect("what was written can be read");
        assert_eq!((trace.info(), trace.frames()), (info, count), "{name}");
        let (again, end) = play(&trace);
        end.expect("what was written can be read");
        assert_eq!(again, *frames, "{name}");
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

/// The frames of the text form up to what is wrong, and the number of that line, by the description of the format: one
/// field after the other, without a second path for plain lines.
fn described(bytes: &[u8], trace: &Trace) -> (Frames, Option<u64>) {
    let mut lines: Vec<&[u8]> = bytes.split(|&byte| byte == b'\n').collect();
    if lines.last().is_some_and(|line| line.is_empty()) {
        lines.pop();
    }
    let after = lines.len() as u64 + 1;
    let (mut frames, mut blank) = (vec![vec![]], None);
    for (number, line) in (1..).zip(lines).skip(2) {
        if line.len() >= LINE_BYTES {
            return (frames, Some(number));
        }
        let line = line.strip_suffix(b"\r").unwrap_or(line);
        let next = format!("# frame {}", frames.len());
        let is_blank = |byte: &u8| b" \t".contains(byte);
        if line.iter().all(is_blank) {
            blank = blank.or(Some(number));
        } else if blank.is_some() {
            return (frames, blank);
        } else if (frames.len() as u32) < trace.frames()
            && String::from_utf8_lossy(line).trim_matches([' ', '\t']) == next
        {
            frames.push(vec![]);
        } else if let Some(fragment) = described_line(line, trace.info()) {
            frames.last_mut().expect("there is a first one").push(fragment);
        } else {
            return (frames, Some(number));
        }
    }
    let is_whole = frames.len() as u32 == trace.frames();
    (frames, (!is_whole).then_some(after))
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
