use super::*;
use pellucid_machine::pixel::Z_FAR;
use pellucid_sim::Label;
use proptest::prelude::*;
use std::fs;
use tempfile::TempDir;

const INFO: Screen = Screen { width: 640, height: 480, background: 0xff8000 };
/// Of three frames.
const THREE: Header = Header { screen: INFO, frames: 3 };
const ONE: Header = Header { frames: 1, ..THREE };

fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

fn write(path: &Path, info: Screen, fragments: &[Fragment]) {
    let mut writer = TraceWriter::create(path, info, 1).unwrap();
    for &fragment in fragments {
        writer.push(fragment).unwrap();
    }
    writer.finish().unwrap();
}

fn read(trace: &Trace) -> Result<Vec<Fragment>, TraceError> {
    let mut fragments = Vec::new();
    trace.play(&mut |fragment| {
        fragments.push(fragment);
        Ok::<_, TraceError>(())
    })?;
    Ok(fragments)
}

/// The message of opening or playing the file, with the folder taken out of it.
fn message(folder: &TempDir, name: &str) -> String {
    let error = Trace::open(&folder.path().join(name)).and_then(|trace| read(&trace)).unwrap_err();
    let prefix = format!("{}/", folder.path().display());
    error.to_string().replace(&prefix, "")
}

#[cfg(unix)]
#[test]
fn file_messages() {
    let folder = folder();
    fs::create_dir(folder.path().join("dir.csv")).unwrap();
    assert_eq!(message(&folder, "no.csv"), "cannot read `no.csv`: No such file or directory");
    assert_eq!(
        message(&folder, "dir.csv"),
        "cannot read `dir.csv`: it is a folder, expected a file"
    );
    assert_eq!(
        message(&folder, "t.txt"),
        "`t.txt` does not name a trace, expected a name that ends in `.csv` or `.ptrace`"
    );
    std::os::unix::fs::symlink("/dev/null", folder.path().join("null.csv")).unwrap();
    assert_eq!(
        message(&folder, "null.csv"),
        "cannot read `null.csv`: it is no regular file, and a trace is read more than once"
    );
}

#[test]
fn the_ending_counts_in_any_case_and_play_repeats() {
    let folder = folder();
    let fragments = [Fragment { x: 1, y: 2, z: 3, rgba: 4, label: Label::NONE }; 3];
    for name in ["t.CSV", "t.PTrace"] {
        let path = folder.path().join(name);
        write(&path, INFO, &fragments);
        let trace = Trace::open(&path).unwrap();
        assert_eq!(trace.info(), INFO);
        assert_eq!(read(&trace).unwrap(), fragments);
        assert_eq!(read(&trace).unwrap(), fragments);
    }
}

#[test]
fn a_changed_header_is_noticed() {
    let folder = folder();
    let path = folder.path().join("t.csv");
    write(&path, INFO, &[]);
    let trace = Trace::open(&path).unwrap();
    write(&path, Screen { width: 1, ..INFO }, &[]);
    assert_eq!(
        read(&trace).unwrap_err().to_string(),
        format!(
            "`{}` was changed while it was in use, expected the header that it had when it was opened",
            path.display()
        )
    );
}

#[test]
fn the_sink_can_stop_the_play() {
    #[derive(Debug)]
    enum Stop {
        Here,
        Trace,
    }
    impl From<TraceError> for Stop {
        fn from(_: TraceError) -> Stop {
            Stop::Trace
        }
    }
    let folder = folder();
    let path = folder.path().join("t.ptrace");
    write(&path, INFO, &[Fragment::default(); 5]);
    let mut count = 0;
    let result = Trace::open(&path).unwrap().play(&mut |_| {
        count += 1;
        if count == 3 { Err(Stop::Here) } else { Ok(()) }
    });
    assert!(matches!(result, Err(Stop::Here)));
    assert_eq!(count, 3);
}

#[test]
fn a_writer_refuses_what_no_reader_takes_and_leaves_nothing() {
    let folder = folder();
    let path = folder.path().join("t.ptrace");
    let mut writer = TraceWriter::create(&path, INFO, 1).unwrap();
    writer.push(Fragment::default()).unwrap();
    let outside = Fragment { z: Z_FAR + 1, ..Fragment::default() };
    assert_eq!(
        writer.push(outside).unwrap_err().to_string(),
        format!(
            "cannot write `{}`: fragment 2: z is 16777216, expected an integer from 0 to 16777215",
            path.display()
        )
    );
    drop(writer);
    let error = TraceWriter::create(&path, Screen { height: 0, ..INFO }, 1).unwrap_err();
    assert_eq!(
        error.to_string(),
        format!(
            "cannot write `{}`: height is 0, expected an integer from 1 to 8192",
            path.display()
        )
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named() {
    let folder = folder();
    let path = folder.path().join("full.csv");
    std::os::unix::fs::symlink("/dev/full", &path).unwrap();
    let writer = TraceWriter::create(&path, INFO, 1).unwrap();
    assert_eq!(
        writer.finish().unwrap_err().to_string(),
        format!("cannot write `{}`: No space left on device", path.display())
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_writer_that_failed_cannot_be_finished() {
    let folder = folder();
    let path = folder.path().join("full.ptrace");
    std::os::unix::fs::symlink("/dev/full", &path).unwrap();
    let mut writer = TraceWriter::create(&path, INFO, 1).unwrap();
    // More than any buffer on the way holds.
    let failed = (0..100_000).any(|_| writer.push(Fragment::default()).is_err());
    assert!(failed, "a full disk must be noticed while writing");
    assert_eq!(
        writer.finish().unwrap_err().to_string(),
        format!("cannot write `{}`: No space left on device", path.display())
    );
}

prop_compose! {
    fn any_fragment()(x in 0..640_u32, y in 0..480_u32, z in 0..=Z_FAR, rgba: u32) -> Fragment {
        Fragment { x, y, z, rgba, label: Label::NONE }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn both_forms_give_back_what_was_written(
        fragments in prop::collection::vec(any_fragment(), 0..200),
    ) {
        let folder = folder();
        let [text, binary, again] = ["a.csv", "b.ptrace", "c.csv"].map(|n| folder.path().join(n));
        write(&text, INFO, &fragments);
        for (from, to) in [(&text, &binary), (&binary, &again)] {
            let trace = Trace::open(from).unwrap();
            prop_assert_eq!(read(&trace).unwrap(), fragments.clone());
            let mut writer = TraceWriter::create(to, trace.info(), 1).unwrap();
            trace.play(&mut |fragment| writer.push(fragment)).unwrap();
            writer.finish().unwrap();
        }
        prop_assert!(fs::read(&text).unwrap() == fs::read(&again).unwrap());
        let expected = 16 + 11 * (fragments.len() as u64 + 1);
        prop_assert_eq!(fs::metadata(&binary).unwrap().len(), expected);
    }
}

/// Reads the bytes as both forms; only a panic fails.
fn read_anything(bytes: &[u8]) {
    let path = Path::new("t");
    let sink = &mut |fragment: Fragment| {
        assert!(fragment.x < 8192 && fragment.y < 8192 && fragment.z <= Z_FAR);
        Ok::<_, TraceError>(())
    };
    let _ = csv::Reader::new(path, bytes).and_then(|mut reader| {
        (0..reader.header().frames).try_for_each(|number| reader.frame(number, sink))
    });
    let _ = binary::Reader::new(path, bytes).and_then(|mut reader| {
        (0..reader.header().frames).try_for_each(|number| reader.frame(number, sink))
    });
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        read_anything(&bytes);
        for header in [ONE, THREE] {
            let mut text = csv::header(header).into_bytes();
            text.extend_from_slice(&bytes);
            read_anything(&text);
            let mut binary = binary::header(header);
            binary.extend_from_slice(&bytes);
            read_anything(&binary);
        }
    }

    #[test]
    fn mutated_files_are_read_or_refused(
        fragments in prop::collection::vec(any_fragment(), 1..20),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut text = csv::header(THREE).into_bytes();
        let mut bytes = binary::header(THREE);
        for number in 0..3 {
            if number > 0 {
                text.extend_from_slice(format!("{}\n", csv::frame_line(number)).as_bytes());
            }
            for &fragment in &fragments {
                csv::encode(fragment, &mut text);
                binary::encode(fragment, &mut bytes);
            }
            bytes.extend_from_slice(&binary::end(fragments.len() as u64));
        }
        for mut file in [text, bytes] {
            for (at, byte) in &changes {
                let at = at.index(file.len());
                file[at] = *byte;
            }
            read_anything(&file);
            file.truncate(cut.index(file.len()));
            read_anything(&file);
        }
    }
}

/// Writes frames of which some may be empty.
fn write_frames(path: &Path, frames: &[Vec<Fragment>]) {
    let mut writer = TraceWriter::create(path, INFO, frames.len() as u32).unwrap();
    for (number, frame) in frames.iter().enumerate() {
        if number > 0 {
            writer.next_frame().unwrap();
        }
        frame.iter().for_each(|&fragment| writer.push(fragment).unwrap());
    }
    writer.finish().unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// In order, and asked for from the last to the first of a file of which nothing is known yet.
    #[test]
    fn frames_are_given_back_one_by_one_in_any_order(
        frames in prop::collection::vec(prop::collection::vec(any_fragment(), 0..9), 2..7),
        backwards: bool,
    ) {
        let folder = folder();
        for name in ["t.csv", "t.ptrace"] {
            let path = folder.path().join(name);
            write_frames(&path, &frames);
            let first = Trace::open(&path).unwrap();
            prop_assert_eq!(first.frames() as usize, frames.len());
            let mut numbers: Vec<usize> = (0..frames.len()).collect();
            if backwards {
                numbers.reverse();
            }
            for number in numbers {
                let frame = first.later(number as u32).unwrap().unwrap();
                prop_assert_eq!(&read(&frame).unwrap(), &frames[number], "{}", number);
                prop_assert_eq!(&read(&frame).unwrap(), &frames[number], "{}, again", number);
            }
            prop_assert_eq!(&read(&first).unwrap(), &frames[0]);
            let alone = first.clone().alone();
            prop_assert!(alone.frames() == 1 && alone.later(1).unwrap().is_none());
            prop_assert_eq!(read(&alone).unwrap(), frames[0].clone());
        }
    }
}

#[test]
fn a_frame_that_there_is_not_is_refused() {
    let folder = folder();
    let path = folder.path().join("t.csv");
    write_frames(&path, &[vec![], vec![]]);
    let first = Trace::open(&path).unwrap();
    for number in [2, u32::MAX] {
        let expected =
            format!("`{}` has no frame {number}, expected a frame from 0 to 1", path.display());
        assert_eq!(first.later(number).unwrap_err().to_string(), expected);
    }
    for frames in [0, MOST_FRAMES + 1] {
        let error = TraceWriter::create(&path, INFO, frames).unwrap_err();
        let expected = format!(
            "cannot write `{}`: frames is {frames}, expected an integer from 1 to 65535",
            path.display()
        );
        assert_eq!(error.to_string(), expected);
    }
}

/// An error in a later frame tells the line or record of the file.
#[test]
fn places_of_later_frames_are_those_of_the_file() {
    let folder = folder();
    let fragment = Fragment { x: 1, y: 2, z: 3, rgba: 4, label: Label::NONE };
    let frames = [vec![fragment; 2], vec![fragment; 3], vec![fragment]];
    let of_last = |name: &str, change: &dyn Fn(Vec<u8>) -> Vec<u8>| {
        let path = folder.path().join(name);
        write_frames(&path, &frames);
        fs::write(&path, change(fs::read(&path).unwrap())).unwrap();
        let last = Trace::open(&path).unwrap().later(2).unwrap().unwrap();
        let error = read(&last).unwrap_err().to_string();
        // Now its start is known.
        assert_eq!(read(&last).unwrap_err().to_string(), error);
        error.replace(&format!("{}/", folder.path().display()), "")
    };
    let text = of_last("t.csv", &|mut bytes| {
        bytes.extend_from_slice(b"bad\n");
        bytes
    });
    // Two lines of header, fragments, and two lines of frames before it.
    assert_eq!(text, "`t.csv`, line 11: `bad` has 1 field, expected 7: x,y,z,r,g,b,a");
    let binary = of_last("t.ptrace", &|mut bytes| {
        bytes.pop();
        bytes
    });
    // The end record is the ninth, after 18 bytes of header.
    assert_eq!(
        binary,
        "`t.ptrace`, record 9 at byte 106: the file is cut short, found 10 of 11 bytes, expected a fragment or the end \
         record"
    );
}
