//! `export`: what it writes, says and refuses.

use super::*;

fn export(folder: &Path, args: &[&str]) -> Output {
    pellucid(folder, &[&["export"], &SMALL[..], args].concat())
}

#[test]
fn it_leaves_the_modules_the_testbench_and_the_recording() {
    let folder = folder();
    let output = exact(export(folder.path(), &["--out", "my rtl"]));
    let text = stdout(&output);
    assert!(text.contains("files of Verilog in my rtl/, a module each; tbuffer.v is the machine"));
    // The printed commands can be pasted into a shell.
    for tool in ["iverilog -g2005", "verilator --binary"] {
        let line = text.lines().find(|line| line.contains(tool)).unwrap();
        assert!(line.starts_with("  (cd 'my rtl' && "), "{line}");
    }
    let files = names(&folder.path().join("my rtl"));
    for file in ["files.f", "lockstep_tb.v", "store.v", "tbuffer.v", "vectors.txt"] {
        assert!(files.iter().any(|name| name == file), "{file} is missing in {files:?}");
    }
    let list = fs::read_to_string(folder.path().join("my rtl/files.f")).unwrap();
    let mut listed: Vec<&str> = list.lines().chain(["files.f", "vectors.txt"]).collect();
    listed.sort_unstable();
    assert_eq!(listed, files);
    let head = fs::read_to_string(folder.path().join("my rtl/store.v")).unwrap();
    for line in ["// --arch tbuffer --width 40 --height 30\n", "// -p section_capacity=3\n"] {
        assert!(head.contains(line), "{head}");
    }
}

#[test]
fn two_exports_give_the_same_bytes() {
    let folder = folder();
    for out in ["a", "b"] {
        exact(export(folder.path(), &["--quiet", "--stress", "--out", out]));
    }
    for name in names(&folder.path().join("a")) {
        let read = |out: &str| fs::read(folder.path().join(out).join(&name)).unwrap();
        assert_eq!(read("a"), read("b"), "{name}");
    }
}

#[test]
fn it_refuses_what_run_refuses() {
    let folder = folder();
    for (args, message) in [
        (
            ["--arch", "tbufer"],
            "--arch tbufer: unknown architecture `tbufer` (did you mean `tbuffer`?); known are `tbuffer`, `rbuffer`, `mbuffer`, `composer`, `dfb`, `b3d`, `ppll`, `fbuffer`, `accumulate`",
        ),
        (["-p", "sections"], "-p sections: expected NAME=VALUE"),
        (["--scene", "no.csv"], "cannot read `no.csv`: No such file or directory"),
        (["--out", "file"], "cannot use `file` as output folder: it is a file, not a folder"),
    ] {
        fs::write(folder.path().join("file"), "").unwrap();
        refused(folder.path(), &[&["export"], &args[..]].concat(), message);
        assert_eq!(names(folder.path()), ["file"]);
    }
}
