//! What a study leaves, in Python.

use super::explore::{STUDY, explore, rows, write};
use super::*;
use roxmltree::{Document, Node, ParsingOptions};

/// What pandas reads of it: one line, a row for each point, numbers as numbers.
#[test]
fn pandas_loads_points() {
    let folder = folder();
    let python =
        |code: &str| Command::new("python3").args(["-c", code]).current_dir(folder.path()).output();
    if !python("import pandas").is_ok_and(|output| output.status.success()) {
        println!("skipped: python3 with pandas is not installed");
        return;
    }
    write(folder.path(), STUDY);
    exact(explore(folder.path(), &[]));
    let rows = rows(&folder.path().join("pellucid-explore"));
    let right = rows.iter().filter(|row| row["status"] == "right");
    let total: u64 = right.clone().map(|row| row["cycles.total"].as_u64().unwrap()).sum();
    let code = "import pandas; p = pandas.read_csv('pellucid-explore/points.csv')\n\
                r = p[p.status == 'right']; print(len(p), len(r), int(r['cycles.total'].sum()))";
    let output = python(code).unwrap();
    assert_eq!(stdout(&output).trim(), format!("{} {} {total}", rows.len(), right.count()));
}

/// The script of the book draws a mark for each design that is right on every scene.
#[test]
fn a_script_plots_points() {
    let folder = folder();
    let python =
        |args: &[&str]| Command::new("python3").args(args).current_dir(folder.path()).output();
    if !python(&["-c", "import pandas, matplotlib"]).is_ok_and(|output| output.status.success()) {
        println!("skipped: python3 with pandas and matplotlib is not installed");
        return;
    }
    write(folder.path(), STUDY);
    exact(explore(folder.path(), &[]));
    let script = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/studies/plots.py");
    let args = [script, "pellucid-explore", "cycles.total", "storage.on_chip_bytes"];
    // It may say that it looks for fonts.
    let plotted = python(&args).unwrap();
    assert!(plotted.status.success(), "{}", stderr(&plotted));
    let out = folder.path().join("pellucid-explore");
    let mut designs: BTreeMap<u64, bool> = BTreeMap::new();
    for row in rows(&out) {
        *designs.entry(row["design"].as_u64().unwrap()).or_insert(true) &= row["status"] == "right";
    }
    let front = fs::read_to_string(out.join("front.svg")).unwrap();
    let options = ParsingOptions { allow_dtd: true, ..ParsingOptions::default() };
    let front = Document::parse_with_options(&front, options).unwrap();
    let within = |node: &Node, what: &str| {
        node.ancestors().any(|above| above.attribute("id").is_some_and(|id| id.starts_with(what)))
    };
    let marks = front.descendants().filter(|node| {
        node.tag_name().name() == "use" && within(node, "PathCollection") && !within(node, "legend")
    });
    assert_eq!(marks.count(), designs.values().filter(|right| **right).count());
    let effects = fs::read_to_string(out.join("effects.svg")).unwrap();
    assert!(effects.contains("<!-- dfb: index -->"), "{effects}");
    let output = python(&[script, "pellucid-explore", "cycles.total", "bytes"]).unwrap();
    let error = "error: `bytes` is no column of pellucid-explore/points.csv\n";
    assert!(stderr(&output).ends_with(error), "{}", stderr(&output));
}
