//! What is refused, in which words, and what is left behind.

use super::*;

#[test]
fn names_and_values_are_checked() {
    let folder = folder();
    let known = "`sections`, `section_capacity`, `append`, `scan`, `allocator`, `sorter_depth`, \
                 `outside_sections`, `outside_latency`, `reads_in_flight`, `ssa`, `ssa_sets`, `ssa_ways`, `ssa_line`, \
                 `framebuffer`, `framebuffer_sets`, `framebuffer_ways`, `framebuffer_line`";
    let window = "expected `FROM..TO` with FROM below TO, a phase as `store` or `resolve`, `all`, `stall:N` \
                  with N from 1 to 10000, or `event:NAME`";
    let cases: &[(&[&str], String)] = &[
        (
            &["--arch", "tbufer"],
            "--arch tbufer: unknown architecture `tbufer` (did you mean `tbuffer`?); known are `tbuffer`, `rbuffer`, `mbuffer`, `composer`, `dfb`, `b3d`, `ppll`, `fbuffer`, `accumulate`".into(),
        ),
        (
            &["--preset", "fats"],
            "--preset fats: unknown preset `fats` of `tbuffer` (did you mean `fast`?); known are `fast`, `paper`"
                .into(),
        ),
        (
            &["--scene", "teapto"],
            "unknown scene `teapto` (did you mean `teapot`?); known are glass, teapot, smoke, plant, panes, triangles, rainbow, \
             sphere-12288, sphere-196608, cube, quads-N-P, \
             paper-0, paper-120, paper-180, paper-240, paper-300, paper-360, paper-420, paper-480, \
             or a file: a mesh (.obj, .ply, .ply.gz, .gltf or .glb) or a trace (.csv or .ptrace)"
                .into(),
        ),
        (
            &["--scene", "quads-65-50"],
            "unknown scene `quads-65-50`: expected quads-N-P with N from 1 to 64, the number of quads, and P from 0 to 100, \
             the percentage of the screen"
                .into(),
        ),
        (
            &["-p", "section=3"],
            format!(
                "-p section=3: unknown parameter `section` (did you mean `sections`?); known are \
                 {known}"
            ),
        ),
        (
            &["--order", "rows"],
            "invalid value 'rows' for '--order <ORDER>': `rows` is not an order: expected scan-line, tile-8x8, morton or \
             quad"
                .into(),
        ),
        (&["-p", "sections"], "-p sections: expected NAME=VALUE".into()),
        (&["-p", "=3"], "-p =3: expected NAME=VALUE".into()),
        (
            &["-p", "section_capacity=65"],
            "-p section_capacity=65: parameter `section_capacity` is `65`: expected a whole number \
             from 1 to 64"
                .into(),
        ),
        (
            &["-p", "scan=bitmp"],
            "-p scan=bitmp: parameter `scan` is `bitmp`: expected `linear` or `bitmap`".into(),
        ),
        (
            &["-p", "sections=16777216", "-p", "section_capacity=16"],
            "parameters `sections` + `outside_sections` times `section_capacity` hold 285212672 \
             fragments: expected at most 268435456"
                .into(),
        ),
        (
            &["--wave", "-5..3"],
            format!(
                "invalid value '-5..3' for '--wave <WINDOW>': `-5..3` is no window of cycles: \
                 {window}"
            ),
        ),
        (
            &["--wave", "store,9..2"],
            format!(
                "invalid value '9..2' for '--wave <WINDOW>': `9..2` is no window of cycles: {window}"
            ),
        ),
    ];
    for (args, message) in cases {
        refused(folder.path(), &[&["run"], &SMALL[..], args].concat(), message);
    }
    for side in ["0", "-5", "8193", "abc", "99999999999"] {
        let expected = "expected a whole number from 1 to 8192";
        let message = format!("invalid value '{side}' for '--width <PIXELS>': {expected}");
        refused(folder.path(), &["run", "--width", side], &message);
    }
    assert_eq!(names(folder.path()), [""; 0]);
}

#[test]
fn configuration_files_are_checked() {
    let folder = folder();
    let number = "expected a number or a string";
    let cases = [
        (
            "sections = 5\nscan = \n",
            "line 2: string values must be quoted, expected literal string",
        ),
        ("sections = 1\nsections = 2\n", "line 2: duplicate key"),
        ("sections = 5.5\n", &format!("key `sections`: found float, {number}")),
        ("sections = true\n", &format!("key `sections`: found boolean, {number}")),
        ("[store]\n", &format!("key `store`: found table, {number}")),
        ("[store]\nsections = [5]\n", &format!("key `store.sections`: found array, {number}")),
        (
            "[store]\nsections = 5\n",
            "key `store.sections`: unknown parameter `store.sections` (did you mean `sections`?); known are \
             `sections`, `section_capacity`, `append`, `scan`, `allocator`, `sorter_depth`, \
             `outside_sections`, `outside_latency`, `reads_in_flight`, `ssa`, `ssa_sets`, `ssa_ways`, `ssa_line`, \
             `framebuffer`, `framebuffer_sets`, `framebuffer_ways`, `framebuffer_line`",
        ),
        (
            "sections = -1\n",
            "key `sections`: parameter `sections` is `-1`: expected a whole number from 1 to 268435456",
        ),
        (
            "scna = \"bitmap\"\n",
            "key `scna`: unknown parameter `scna` (did you mean `scan`?); known are `sections`, \
             `section_capacity`, `append`, `scan`, `allocator`, `sorter_depth`, `outside_sections`, \
             `outside_latency`, `reads_in_flight`, `ssa`, `ssa_sets`, `ssa_ways`, `ssa_line`, \
             `framebuffer`, `framebuffer_sets`, `framebuffer_ways`, `framebuffer_line`",
        ),
    ];
    for (text, message) in cases {
        fs::write(folder.path().join("c.toml"), text).unwrap();
        refused(folder.path(), &["run", "--config", "c.toml"], &format!("`c.toml`, {message}"));
    }
    refused(
        folder.path(),
        &["run", "--config", "no.toml"],
        "cannot read `no.toml`: No such file or directory",
    );
    assert_eq!(names(folder.path()), ["c.toml"]);
}

#[test]
fn meshes_are_checked() {
    let folder = folder();
    let files = "a mesh (.obj, .ply, .ply.gz, .gltf or .glb) or a trace (.csv or .ptrace)";
    fs::create_dir(folder.path().join("folder.obj")).unwrap();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (name, text) in [
        ("a.txt", "hello\n".into()),
        ("a.ply", "hello\n".into()),
        ("a.ply.gz", "hello\n".into()),
        ("empty.obj", String::new()),
        ("points.obj", triangle.into()),
        ("nan.obj", "v 0 0 0\nv nan 0 0\nv 0 1 0\nf 1 2 3\n".into()),
        ("index.obj", format!("{triangle}f 1 2 9\n")),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    for (name, message) in [
        ("no.ply", "no.ply: no such file".to_string()),
        ("folder.obj", format!("folder.obj: is a directory, expected a file: {files}")),
        ("a.txt", format!("a.txt: unknown kind of file, expected {files}")),
        ("a.ply", "a.ply, line 1: expected `ply` as the first line".into()),
        ("a.ply.gz", "a.ply.gz: the gzip data is truncated".into()),
        ("empty.obj", "empty.obj: has no triangles with an area, expected at least one".into()),
        (
            "points.obj",
            "points.obj: has no triangles with an area, expected at least one: it has 3 vertices".into(),
        ),
        (
            "nan.obj",
            "nan.obj, line 2: expected a vertex as v X Y Z, v X Y Z W or v X Y Z R G B, of finite numbers".into(),
        ),
        ("index.obj", "index.obj, line 4: vertex index 9 is out of range, expected 1..=3".into()),
    ] {
        refused(folder.path(), &["run", "--scene", name], &message);
    }
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink("/dev/zero", folder.path().join("zero.ply")).unwrap();
        let message = format!("zero.ply: is no regular file, expected {files}");
        refused(folder.path(), &["run", "--scene", "zero.ply"], &message);
        let message = "cannot read `/dev/zero`: it is longer than 1048576 bytes";
        refused(folder.path(), &["run", "--config", "/dev/zero"], message);
    }
}

#[test]
fn a_mesh_has_a_limit_of_memory_and_notes() {
    let folder = folder();
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nl 1 2\nf 1 2 3\n";
    fs::write(folder.path().join("a.obj"), triangle).unwrap();
    let limited = |limit| {
        ["run", "--scene", "a.obj", "--width", "8", "--height", "6", "--memory-limit", limit]
    };
    refused(
        folder.path(),
        &limited("20"),
        "a.obj: does not fit into the memory that a scene may take, 20; `--memory-limit` sets another limit",
    );
    let output = pellucid(folder.path(), &limited("1M"));
    assert_eq!(
        stderr(&output),
        "note: a.obj: not seen: 1 line (line 4)\n\
         note: a.obj: what has no opacity of its own is drawn at 0.5, `--alpha` sets another\n"
    );
    assert!(output.status.success());
}

#[test]
fn traces_are_checked() {
    let folder = folder();
    let head = "# pellucid-trace width=4 height=4 background=0,0,0\nx,y,z,r,g,b,a\n";
    for (name, text) in [
        ("hello.csv", "hello\n".into()),
        ("hello.ptrace", "hello\n".into()),
        ("side.csv", head.replace("width=4", "width=0")),
        ("y.csv", format!("{head}1,9,3,4,5,6,7\n")),
        ("z.csv", format!("{head}1,1,16777216,4,5,6,7\n")),
        ("short.csv", format!("{head}1,1,3\n")),
        ("good.csv", format!("{head}1,1,3,4,5,6,7\n")),
    ] {
        fs::write(folder.path().join(name), text).unwrap();
    }
    exact(pellucid(folder.path(), &["trace", "--scene", "good.csv", "--out", "t.ptrace", "-q"]));
    let mut bytes = fs::read(folder.path().join("t.ptrace")).unwrap();
    bytes.pop();
    fs::write(folder.path().join("short.ptrace"), bytes).unwrap();
    for (name, message) in [
        ("no.csv", "cannot read `no.csv`: No such file or directory".to_string()),
        (
            "hello.csv",
            "`hello.csv`, line 1: found `hello`, expected `# pellucid-trace width=W height=H \
             background=R,G,B`"
                .into(),
        ),
        (
            "hello.ptrace",
            "`hello.ptrace`, byte 0: found no trace, expected the bytes 89 50 54 52 41 43 45"
                .into(),
        ),
        ("side.csv", "`side.csv`, line 1: width is `0`, expected an integer from 1 to 8192".into()),
        ("y.csv", "`y.csv`, line 3: y is `9`, expected an integer from 0 to 3".into()),
        (
            "z.csv",
            "`z.csv`, line 3: z is `16777216`, expected an integer from 0 to 16777215".into(),
        ),
        (
            "short.csv",
            "`short.csv`, line 3: `1,1,3` has 3 fields, expected 7: x,y,z,r,g,b,a".into(),
        ),
        (
            "short.ptrace",
            "`short.ptrace`, record 2 at byte 27: the file is cut short, found 10 of 11 bytes, \
             expected a fragment or the end record"
                .into(),
        ),
    ] {
        refused(folder.path(), &["run", "--scene", name, "--out", "out"], &message);
    }
    refused(
        folder.path(),
        &["run", "--scene", "good.csv", "--order", "quad"],
        "`good.csv` is a trace: an order of fragments cannot be set, a trace has its own pixels",
    );
    refused(
        folder.path(),
        &["run", "--scene", "good.csv", "--width", "9"],
        "`good.csv` is a trace: a width cannot be set, a trace has its own pixels",
    );
    assert_eq!(names(&folder.path().join("out")), [""; 0], "nothing half-written is left");
}

#[test]
fn outputs_are_checked() {
    let folder = folder();
    fs::write(folder.path().join("file"), "").unwrap();
    refused(
        folder.path(),
        &["run", "--out", "file"],
        "cannot use `file` as output folder: it is a file, not a folder",
    );
    refused(
        folder.path(),
        &["run", "--out", "file/below"],
        "cannot use `file/below` as output folder: Not a directory",
    );
    refused(
        folder.path(),
        &["trace", "--out", "t.txt"],
        "`t.txt` does not name a trace, expected a name that ends in `.csv` or `.ptrace`",
    );
    refused(
        folder.path(),
        &["trace", "--out", "no/t.csv"],
        "cannot write `no/t.csv`: No such file or directory",
    );
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_said() {
    use std::os::unix::fs::symlink;
    use std::process::Stdio;
    let folder = folder();
    let space = "No space left on device";
    symlink("/dev/full", folder.path().join("full.csv")).unwrap();
    refused(
        folder.path(),
        &["trace", "--out", "full.csv"],
        &format!("cannot write `full.csv`: {space}"),
    );
    for name in ["image.png", "stats.json", "stats.csv", "wave.vcd"] {
        let out = tempfile::tempdir().unwrap();
        symlink("/dev/full", out.path().join(name)).unwrap();
        let output = run(out.path(), &["--out", "."]);
        assert_eq!(stderr(&output), format!("error: cannot write `./{name}`: {space}\n"));
        assert_eq!(output.status.code(), Some(2));
    }
    let full = fs::File::options().write(true).open("/dev/full").unwrap();
    let child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .arg("list")
        .stdout(Stdio::from(full))
        .stderr(Stdio::piped())
        .spawn();
    let output = child.unwrap().wait_with_output().unwrap();
    assert_eq!(stderr(&output), format!("error: cannot write `standard output`: {space}\n"));
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
        .arg("list")
        .stdout(writer)
        .stderr(std::process::Stdio::piped())
        .spawn();
    exact(child.unwrap().wait_with_output().unwrap());
}

#[cfg(unix)]
#[test]
fn a_signal_leaves_no_unfinished_file() {
    use std::io::{BufRead, BufReader};
    let folder = folder();
    for signal in ["-TERM", "-INT"] {
        // Far more work than a signal takes to arrive.
        let mut child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(["trace", "--scene", "smoke", "--width", "8192", "--height", "8192"])
            .args(["--out", "t.csv"])
            .current_dir(&folder)
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        while names(folder.path()).is_empty() {
            assert_eq!(child.try_wait().unwrap(), None, "it ended before it could be stopped");
            std::thread::yield_now();
        }
        let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        let mut said = String::new();
        BufReader::new(child.stderr.take().unwrap()).read_line(&mut said).unwrap();
        assert_eq!(
            said,
            "error: stopped by a signal, the files that were not complete are removed\n"
        );
        assert_eq!(child.wait().unwrap().code(), Some(130));
        assert_eq!(names(folder.path()), [""; 0]);
    }
}
