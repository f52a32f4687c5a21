use super::*;

const FRAME: &str = "# pellucid-trace width=640 height=480 background=1,2,3";

/// The fragments of a text, or the message.
fn read(text: impl AsRef<[u8]>) -> Result<Vec<[u32; 7]>, String> {
    let mut fragments = Vec::new();
    let mut run = || -> Result<(), TraceError> {
        let mut reader = Reader::new(Path::new("t.csv"), text.as_ref())?;
        let Header { screen, frames } = reader.header();
        assert_eq!(screen.background, 0x010203);
        (0..frames).try_for_each(|number| {
            reader.frame(number, &mut |fragment| {
                fragments.push(fields::values(fragment));
                Ok::<_, TraceError>(())
            })
        })
    };
    let result = run();
    result.map(|()| fragments).map_err(|error| error.to_string())
}

fn message(lines: &str) -> String {
    read(format!("{FRAME}\n{COLUMNS}\n{lines}")).unwrap_err()
}

fn header_message(line: &str) -> String {
    read(line).unwrap_err()
}

/// Enough plain lines that the line after them is met by the quick path.
fn long_tail() -> String {
    "1,2,3,4,5,6,7\n".repeat(20)
}

#[test]
fn what_is_tolerated_reads_like_the_plain_form() {
    let first = [12, 7, 16777215, 255, 128, 0, 127];
    let second = [639, 479, 0, 0, 0, 0, 255];
    let plain = "12,7,16777215,255,128,0,127\n639,479,0,0,0,0,255\n";
    let wide = " 12 ,\t7, 16777215,255,128,0,0127 \n639,479,000000000,0,0,0,255\n";
    let crlf = |text: &str| text.replace('\n', "\r\n");
    for lines in [plain, wide] {
        for tail in ["", "\n", "\n \n\t\n"] {
            let text = format!("{FRAME}\n{COLUMNS}\n{lines}{tail}");
            assert_eq!(read(&text).unwrap(), [first, second], "{text:?}");
            assert_eq!(read(crlf(&text)).unwrap(), [first, second], "{text:?}");
            assert_eq!(read(text.trim_end()).unwrap(), [first, second], "{text:?}");
        }
        // The same lines through the quick path.
        let text = format!("{FRAME}\n{COLUMNS}\n{lines}{}", long_tail());
        assert_eq!(read(&text).unwrap()[..2], [first, second]);
        assert_eq!(read(crlf(&text)).unwrap()[..2], [first, second]);
        assert_eq!(read(&text).unwrap().len(), 22);
    }
    assert!(read(format!("{FRAME}\n{COLUMNS}")).unwrap().is_empty());
    assert!(read(format!("{FRAME}\n x , y,z,r,g,b,a \n")).unwrap().is_empty());
}

#[test]
fn header_keys_come_in_any_order() {
    let line = "# pellucid-trace  background = 1, 2 ,3\theight=480 width =640 \r\nx,y,z,r,g,b,a\n";
    assert_eq!(read(line).unwrap().len(), 0);
}

#[test]
fn header_messages() {
    for (line, expected) in [
        (
            "",
            "`t.csv`, line 1: found nothing, expected `# pellucid-trace width=W height=H background=R,G,B`",
        ),
        (
            "x,y,z\n",
            "`t.csv`, line 1: found `x,y,z`, expected `# pellucid-trace width=W height=H background=R,G,B`",
        ),
        ("# pellucid-trace width=1", "`t.csv`, line 1: height is missing, expected height=H"),
        ("# pellucid-trace height=1", "`t.csv`, line 1: width is missing, expected width=W"),
        (
            "# pellucid-trace height=1 width=1",
            "`t.csv`, line 1: background is missing, expected background=R,G,B",
        ),
        (
            "# pellucid-trace width=0",
            "`t.csv`, line 1: width is `0`, expected an integer from 1 to 8192",
        ),
        (
            "# pellucid-trace height=8193",
            "`t.csv`, line 1: height is `8193`, expected an integer from 1 to 8192",
        ),
        (
            "# pellucid-trace height=",
            "`t.csv`, line 1: height is empty, expected an integer from 1 to 8192",
        ),
        (
            "# pellucid-trace depth=1",
            "`t.csv`, line 1: key `depth` is unknown, expected width, height, background and frames",
        ),
        (
            "# pellucid-trace frames=0",
            "`t.csv`, line 1: frames is `0`, expected an integer from 1 to 65535",
        ),
        (
            "# pellucid-trace width=1 width=2",
            "`t.csv`, line 1: width is there twice, expected once",
        ),
        ("# pellucid-trace 640x480", "`t.csv`, line 1: found `640x480`, expected key=value"),
        (
            "# pellucid-trace background=1,2",
            "`t.csv`, line 1: background is `1,2`, expected three integers R,G,B",
        ),
        (
            "# pellucid-trace background=1,256,3",
            "`t.csv`, line 1: background green is `256`, expected an integer from 0 to 255",
        ),
    ] {
        assert_eq!(header_message(line), expected);
    }
    assert_eq!(
        header_message(&format!("{FRAME}\n1,2,3,4,5,6,7\n")),
        "`t.csv`, line 2: found `1,2,3,4,5,6,7`, expected the columns `x,y,z,r,g,b,a`"
    );
    assert_eq!(
        header_message(FRAME),
        "`t.csv`, line 2: found the end of the file, expected the columns `x,y,z,r,g,b,a`"
    );
    assert_eq!(
        read(b"\x89PTRACE\x01").unwrap_err(),
        "`t.csv` holds a binary trace, rename it to end in `.ptrace`"
    );
}

#[test]
fn line_messages() {
    for (line, expected) in [
        ("640,0,0,0,0,0,0", "x is `640`, expected an integer from 0 to 639"),
        ("0,480,0,0,0,0,0", "y is `480`, expected an integer from 0 to 479"),
        ("0,0,16777216,0,0,0,0", "z is `16777216`, expected an integer from 0 to 16777215"),
        ("0,0,167772150,0,0,0,0", "z is `167772150`, expected an integer from 0 to 16777215"),
        ("0,0,0,256,0,0,0", "r is `256`, expected an integer from 0 to 255"),
        ("0,0,0,0,0,0,4294967296", "a is `4294967296`, expected an integer from 0 to 255"),
        ("0,0,0,0,-1,0,0", "g is `-1`, expected an integer from 0 to 255"),
        ("0,0,0,0,0,1.5,0", "b is `1.5`, expected an integer from 0 to 255"),
        ("0,,0,0,0,0,0", "y is empty, expected an integer from 0 to 479"),
        ("0,0,0,0,0,0", "`0,0,0,0,0,0` has 6 fields, expected 7: x,y,z,r,g,b,a"),
        ("0,0,0,0,0,0,0,0", "`0,0,0,0,0,0,0,0` has 8 fields, expected 7: x,y,z,r,g,b,a"),
        ("hello", "`hello` has 1 field, expected 7: x,y,z,r,g,b,a"),
    ] {
        // Line 4, alone and with enough behind it for the quick path.
        for tail in [String::new(), format!("\n{}", long_tail())] {
            let found = message(&format!("0,0,0,0,0,0,0\n{line}{tail}"));
            assert_eq!(found, format!("`t.csv`, line 4: {expected}"));
        }
    }
    assert_eq!(
        message("0,0,0,0,0,0,0\n\n\n0,0,0,0,0,0,0\n"),
        "`t.csv`, line 4: the line is empty, expected x,y,z,r,g,b,a or the end of the file"
    );
    assert_eq!(message(&"1".repeat(5000)), "`t.csv`, line 3: the line has more than 4096 bytes");
}

#[test]
fn frames_are_parted_by_lines_with_their_numbers() {
    let file = |lines: &str| read(format!("{FRAME} frames=3\n{COLUMNS}\n{lines}"));
    let fragment = "1,2,3,4,5,6,7\n";
    let whole = format!("{fragment}# frame 1\n \t# frame 2 \r\n{fragment}{fragment}\n");
    assert_eq!(file(&whole).unwrap(), [[1, 2, 3, 4, 5, 6, 7]; 3]);
    assert_eq!(read(format!("{FRAME} frames=1\n{COLUMNS}\n{fragment}")).unwrap().len(), 1);
    let missing = |line, next| {
        format!(
            "`t.csv`, line {line}: found the end of the file, expected `# frame {next}`, as the first line says 3 frames"
        )
    };
    let other = |line, found: &str| {
        format!("`t.csv`, line {line}: `{found}` has 1 field, expected 7: x,y,z,r,g,b,a")
    };
    for (lines, message) in [
        ("", missing(3, 1)),
        ("# frame 1\n\n", missing(5, 2)),
        ("# frame 1\n# frame 3\n", other(4, "# frame 3")),
        ("# frame 1\n# frame 2\n# frame 3\n", other(5, "# frame 3")),
        (
            "\n# frame 1\n",
            "`t.csv`, line 3: the line is empty, expected x,y,z,r,g,b,a or the end of the file"
                .into(),
        ),
    ] {
        assert_eq!(file(lines).unwrap_err(), message, "{lines:?}");
    }
}

#[test]
fn garbage_is_shown_short_and_printable() {
    let mut text = format!("{FRAME}\n{COLUMNS}\n").into_bytes();
    text.extend_from_slice(b"\xff\xfe,0,0,0,0,0,0\n");
    assert_eq!(
        read(&text).unwrap_err(),
        "`t.csv`, line 3: x is `\\xff\\xfe`, expected an integer from 0 to 639"
    );
    let long = "9".repeat(50);
    assert_eq!(
        message(&format!("{long},0,0,0,0,0,0")),
        format!("`t.csv`, line 3: x is `{}...`, expected an integer from 0 to 639", "9".repeat(40))
    );
}

#[test]
fn lines_across_the_edge_of_the_window_stay_whole() {
    let mut text = format!("{FRAME}\n{COLUMNS}\n");
    for i in 0..60_000_u32 {
        text += &format!("{},{},{i},1,2,3,4\n", i % 640, i % 480);
    }
    let found = read(&text).unwrap();
    assert_eq!(found.len(), 60_000);
    for (i, values) in (0..).zip(found) {
        assert_eq!(values, [i % 640, i % 480, i, 1, 2, 3, 4]);
    }
    text += "bad\n";
    assert!(read(&text).unwrap_err().starts_with("`t.csv`, line 60003: "));
}
