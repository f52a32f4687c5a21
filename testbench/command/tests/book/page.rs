//! Pages with parts that are made from the code.
//!
//! Such a part stands between the lines `<!-- made from the code: NAME -->` and
//! `<!-- end of NAME -->`. [`holds`] compares it with what the code says; with the environment
//! variable `PELLUCID_UPDATE_BOOK=1` it writes it into the page instead.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Tests run side by side, and several write to one page.
static PAGES: Mutex<()> = Mutex::new(());

/// The folder of the workspace.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).ancestors().nth(2).unwrap()
}

/// What a file holds.
pub fn text_of(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Checks that the part `name` of `page` is `text`, or makes it so.
pub fn holds(page: &str, name: &str, text: &str) {
    let guard = PAGES.lock().unwrap_or_else(PoisonError::into_inner);
    let path = root().join("docs/src").join(page);
    let whole = text_of(&path);
    let (begin, end) =
        (format!("<!-- made from the code: {name} -->\n"), format!("<!-- end of {name} -->"));
    let start =
        whole.find(&begin).unwrap_or_else(|| panic!("{page} has no line {begin}")) + begin.len();
    let length = whole[start..].find(&end).unwrap_or_else(|| panic!("{page} has no line {end}"));
    let text = format!("\n{}\n\n", text.trim());
    if whole[start..start + length] == text {
        return;
    }
    if updates() {
        let rest = &whole[start + length..];
        std::fs::write(&path, format!("{}{text}{rest}", &whole[..start])).unwrap();
        return;
    }
    drop(guard);
    panic!(
        "docs/src/{page}, part `{name}`, is out of date. The code says:\n{text}\
         `PELLUCID_UPDATE_BOOK=1 cargo test --workspace --test book` rewrites the page; then look \
         at the prose around it."
    );
}

/// Whether pages are to be brought up to date.
fn updates() -> bool {
    std::env::var_os("PELLUCID_UPDATE_BOOK").is_some_and(|value| value == "1")
}

/// Checks that a file of the workspace is `text`, or makes it so.
pub fn stored(file: &str, text: &str) {
    let path = root().join(file);
    if updates() {
        std::fs::write(&path, text).unwrap();
    }
    assert!(
        std::fs::read_to_string(&path).is_ok_and(|found| found == text),
        "{file} is out of date: `PELLUCID_UPDATE_BOOK=1 cargo test --workspace --test book` writes it anew"
    );
}

/// The first block that begins with `fence` in the documentation at the top of a source file.
pub fn documented(file: &str, fence: &str) -> String {
    let source = text_of(&root().join(file));
    let lines = source.lines().map_while(|line| line.strip_prefix("//!"));
    let text: Vec<&str> = lines.map(|line| line.strip_prefix(' ').unwrap_or(line)).collect();
    let text = text.join("\n");
    let (_, block) = text.split_once(fence).unwrap_or_else(|| panic!("{file} has no {fence}"));
    block.split_once("\n```").unwrap_or_else(|| panic!("{file}: {fence} has no end")).0.to_string()
}

/// Every Rust file below a folder of the workspace, as a path from the workspace.
pub fn source_files(folder: &Path, to: &mut Vec<String>) {
    for entry in std::fs::read_dir(root().join(folder)).unwrap() {
        let entry = entry.unwrap();
        let path = folder.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            source_files(&path, to);
        } else if path.extension().is_some_and(|e| e == "rs") {
            to.push(path.to_str().unwrap().to_string());
        }
    }
}

/// The name of a file without its folder and ending.
pub fn stem(file: &str) -> &str {
    Path::new(file).file_stem().and_then(|stem| stem.to_str()).unwrap_or_default()
}

/// The files that a page links to or shows, without their anchors.
pub fn link_targets(page: &str) -> Vec<String> {
    let mut targets = vec![];
    let mut fenced = false;
    for line in page.lines() {
        fenced ^= line.starts_with("```");
        if fenced {
            continue;
        }
        for rest in line.split("](").skip(1) {
            let target = rest.split([')', '#']).next().unwrap_or_default();
            if !target.is_empty() && !target.contains("://") {
                targets.push(PathBuf::from(target).to_str().unwrap().to_string());
            }
        }
    }
    targets
}
