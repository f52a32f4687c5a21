use super::*;
use pellucid_sim::Label;

const SCREEN: Screen = Screen { width: 640, height: 480, background: 0x010203 };
const INFO: Header = Header { screen: SCREEN, frames: 1 };

/// Header, one fragment, end record, by hand: x 12, y 7, z 0x800000, colour 255,128,0, alpha 127.
const FILE: [u8; 38] = [
    0x89, b'P', b'T', b'R', b'A', b'C', b'E', 1, 0x80, 0x02, 0xe0, 0x01, 1, 2, 3, 0, //
    12, 0, 7, 0, 0, 0, 0x80, 255, 128, 0, 127, //
    0xff, 0xff, 0xff, 0xff, 1, 0, 0, 0, 0, 0, 0,
];

/// Of two frames, by hand: that fragment, then it twice.
const TWO: [u8; 73] = [
    0x89, b'P', b'T', b'R', b'A', b'C', b'E', 2, 0x80, 0x02, 0xe0, 0x01, 1, 2, 3, 0, 2, 0, //
    12, 0, 7, 0, 0, 0, 0x80, 255, 128, 0, 127, //
    0xff, 0xff, 0xff, 0xff, 1, 0, 0, 0, 0, 0, 0, //
    12, 0, 7, 0, 0, 0, 0x80, 255, 128, 0, 127, //
    12, 0, 7, 0, 0, 0, 0x80, 255, 128, 0, 127, //
    0xff, 0xff, 0xff, 0xff, 2, 0, 0, 0, 0, 0, 0,
];

const FRAGMENT: Fragment =
    Fragment { x: 12, y: 7, z: 0x80_0000, rgba: 0xff80007f, label: Label::NONE };

fn read(bytes: &[u8]) -> Result<Vec<Fragment>, String> {
    let mut fragments = Vec::new();
    let mut run = || -> Result<(), TraceError> {
        let mut reader = Reader::new(Path::new("t.ptrace"), bytes)?;
        (0..reader.header().frames).try_for_each(|number| {
            reader.frame(number, &mut |fragment| {
                fragments.push(fragment);
                Ok::<_, TraceError>(())
            })
        })
    };
    let result = run();
    result.map(|()| fragments).map_err(|error| error.to_string())
}

/// The message for the file with the bytes from `at` replaced.
fn message(at: usize, bytes: &[u8]) -> String {
    let mut file = FILE;
    file[at..at + bytes.len()].copy_from_slice(bytes);
    read(&file).unwrap_err()
}

#[test]
fn the_file_by_hand_is_read_and_written() {
    assert_eq!(read(&FILE).unwrap(), [FRAGMENT]);
    let mut bytes = header(INFO).to_vec();
    encode(FRAGMENT, &mut bytes);
    bytes.extend_from_slice(&end(1));
    assert_eq!(bytes, FILE);
    assert_eq!(read(&TWO).unwrap(), [FRAGMENT; 3]);
    let mut bytes = header(Header { frames: 2, ..INFO });
    for fragments in 1..=2 {
        (0..fragments).for_each(|_| encode(FRAGMENT, &mut bytes));
        bytes.extend_from_slice(&end(fragments));
    }
    assert_eq!(bytes, TWO);
}

/// Also one after the end record of a frame.
#[test]
fn every_cut_between_frames_is_noticed() {
    for length in 0..TWO.len() {
        assert!(read(&TWO[..length]).is_err(), "{length} bytes");
    }
    assert_eq!(
        read(&TWO[..17]).unwrap_err(),
        "`t.ptrace`, byte 17: the file is cut short, expected 18 bytes of header"
    );
    let mut longer = TWO.to_vec();
    longer.push(0);
    assert_eq!(
        read(&longer).unwrap_err(),
        "`t.ptrace`, record 5 at byte 62: bytes follow the end record, expected the end of the file"
    );
    for frames in [0, 1] {
        let mut file = TWO;
        file[16] = frames;
        assert_eq!(
            read(&file).unwrap_err(),
            format!("`t.ptrace`, byte 16: frames is {frames}, expected an integer from 2 to 65535")
        );
    }
}

#[test]
fn header_messages() {
    for (at, bytes, expected) in [
        (0, &b"PK"[..], "byte 0: found no trace, expected the bytes 89 50 54 52 41 43 45"),
        (7, &[3], "byte 7: version is 3, expected 1 or 2"),
        (8, &[0, 0], "byte 8: width is 0, expected an integer from 1 to 8192"),
        (10, &[1, 0x20], "byte 8: height is 8193, expected an integer from 1 to 8192"),
        (15, &[9], "byte 15: found 9, expected 0"),
    ] {
        assert_eq!(message(at, bytes), format!("`t.ptrace`, {expected}"));
    }
    assert_eq!(
        read(&FILE[..10]).unwrap_err(),
        "`t.ptrace`, byte 10: the file is cut short, expected 16 bytes of header"
    );
    assert_eq!(
        read(b"# pellucid-trace width=1").unwrap_err(),
        "`t.ptrace` holds a text trace, rename it to end in `.csv`"
    );
}

#[test]
fn record_messages() {
    for (at, bytes, expected) in [
        (16, &[0x80, 2][..], "record 1 at byte 16: x is 640, expected an integer from 0 to 639"),
        (18, &[0xe0, 1], "record 1 at byte 16: y is 480, expected an integer from 0 to 479"),
        (27, &[0, 0], "record 2 at byte 27: y is 65535, expected an integer from 0 to 479"),
        (
            31,
            &[2],
            "record 2 at byte 27: the end record counts 2 fragments, expected 1, as many as there are",
        ),
    ] {
        assert_eq!(message(at, bytes), format!("`t.ptrace`, {expected}"));
    }
    let mut longer = FILE.to_vec();
    longer.push(0);
    assert_eq!(
        read(&longer).unwrap_err(),
        "`t.ptrace`, record 2 at byte 27: bytes follow the end record, expected the end of the file"
    );
}

#[test]
fn every_cut_is_noticed() {
    assert_eq!(
        read(&FILE[..30]).unwrap_err(),
        "`t.ptrace`, record 2 at byte 27: the file is cut short, found 3 of 11 bytes, expected a fragment or the end record"
    );
    assert_eq!(
        read(&FILE[..27]).unwrap_err(),
        "`t.ptrace`, record 2 at byte 27: the file is cut short, found 0 of 11 bytes, expected a fragment or the end record"
    );
    for length in 0..FILE.len() {
        assert!(read(&FILE[..length]).is_err(), "{length} bytes");
    }
}

#[test]
fn records_across_the_edge_of_the_window_stay_whole() {
    let mut bytes = header(INFO).to_vec();
    let fragment = |i: u32| Fragment { x: i % 640, y: i % 480, z: i, rgba: i, label: Label::NONE };
    for i in 0..60_000 {
        encode(fragment(i), &mut bytes);
    }
    bytes.extend_from_slice(&end(60_000));
    let expected: Vec<Fragment> = (0..60_000).map(fragment).collect();
    assert!(read(&bytes).unwrap() == expected);
}
