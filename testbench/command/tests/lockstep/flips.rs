//! How much the comparison sees: operators of the exported text are flipped, one at a time, and the comparison must
//! fail. Those with which it does not stand in `faults/survivors.txt`, each with the reason.

use super::text::{Flip, flips, with_choice};
use super::{exercised, in_folder, text as said, tools, triangles};
use pellucid_hw::ARCHITECTURES;
use pellucid_machine::Architecture;
use rayon::prelude::*;
use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use wildmatch::WildMatch;

/// How many for each architecture, in the first of the ways to build it.
const FLIPS: usize = 300;

/// Files that are the same in every export.
const BY_HAND: [&str; 5] =
    ["outside_memory.v", "ram_1r1w.v", "ram_1rw.v", "ram_delay.v", "lockstep_tb.v"];

/// A flip in a module.
struct Chosen {
    /// The module's file.
    file: String,
    flip: Flip,
    /// The line in which it stands; what is put in an operator's place stands behind it in braces.
    line: String,
}

/// Some operators of a folder's modules.
fn choose(folder: &Path) -> Vec<Chosen> {
    let list = std::fs::read_to_string(folder.join("files.f")).unwrap();
    let mut all = vec![];
    for file in list.lines().filter(|file| !BY_HAND.contains(file)) {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        all.extend(flips(&text).into_iter().map(|flip| {
            let (before, after) = text.split_at(flip.at + flip.right.len());
            let before = before.rsplit('\n').next().unwrap_or_default().trim_start();
            let after = after.lines().next().unwrap_or_default();
            let line = format!("{before}{{{}}}{after}", flip.wrong);
            Chosen { file: file.to_string(), flip, line }
        }));
    }
    // By a hash of the text, so that a change of one line does not choose others.
    all.sort_by_cached_key(|Chosen { file, line, .. }| {
        let mut hasher = DefaultHasher::new();
        (file, line).hash(&mut hasher);
        hasher.finish()
    });
    let mut seen = HashSet::new();
    all.retain(|Chosen { file, flip, .. }| seen.insert((file.clone(), flip.at)));
    all.truncate(FLIPS);
    all
}

/// Builds the export in `folder` so that each of these can be flipped: the first is number 1.
fn build(folder: &Path, chosen: &[Chosen]) {
    let files: HashSet<&str> = chosen.iter().map(|c| c.file.as_str()).collect();
    for file in files {
        let numbered = (1..).zip(chosen).filter(|(_, c)| c.file == file);
        let own: Vec<(usize, Flip)> = numbered.map(|(n, c)| (n, c.flip)).collect();
        let path = folder.join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, with_choice(&text, &own)).unwrap();
    }
    // To build takes longer than to run. Memories begin with anything.
    let quick = "OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0";
    let args = [
        "--binary",
        "-Wno-fatal",
        "-MAKEFLAGS",
        quick,
        "--x-initial",
        "unique",
        "--top-module",
        "lockstep_tb",
        "-f",
        "files.f",
    ];
    let build = in_folder(folder, "verilator", &args);
    assert!(build.status.success(), "{}", said(&build));
}

/// Flips operators of a machine's text; how many, and those that its frame does not tell.
fn survivors(arch: &'static Architecture) -> (usize, Vec<Chosen>) {
    let folder = exercised((arch, arch.ways[0]), triangles::MANY);
    let chosen = choose(folder.path());
    build(folder.path(), &chosen);
    let differs = |flip: usize| {
        let run = in_folder(
            folder.path(),
            "obj_dir/Vlockstep_tb",
            &[&format!("+flip={flip}"), "+verilator+rand+reset+2"],
        );
        let said = said(&run);
        assert_ne!(said.contains("PASS: "), said.contains("FAIL: "), "{said}");
        said.contains("FAIL: ")
    };
    assert!(!differs(0), "without a flip");
    let told: Vec<bool> = (1..=chosen.len()).into_par_iter().map(differs).collect();
    let (of, told) = (chosen.len(), chosen.into_iter().zip(told));
    (of, told.filter(|(_, told)| !told).map(|(chosen, _)| chosen).collect())
}

/// Why flips survive: modules, what the line has in which it stands, reason.
fn reasons() -> Vec<[String; 3]> {
    let table = concat!(env!("CARGO_MANIFEST_DIR"), "/../faults/survivors.txt");
    let text = std::fs::read_to_string(table).unwrap();
    let rows = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let cells = |row: &str| row.split("; ").map(String::from).collect::<Vec<_>>();
    rows.map(|row| cells(row).try_into().unwrap_or_else(|_| panic!("three cells: {row}"))).collect()
}

/// The comparison tells every flipped operator but those that stand in the table, and those it does not tell.
#[test]
#[ignore = "builds a machine of each architecture in Verilator and runs it hundreds of times"]
fn flipped_operators_are_told() {
    if !tools::have(&["verilator"]) {
        return;
    }
    let reasons = reasons();
    let row_of = |Chosen { file, line, .. }: &Chosen| {
        let fits = |module: &str, part| WildMatch::new(module).matches(file) && line.contains(part);
        reasons.iter().position(|[module, part, _]| fits(module, part.as_str()))
    };
    let rows: Vec<Option<usize>> = ARCHITECTURES
        .par_iter()
        .flat_map_iter(|arch| {
            let (of, survivors) = survivors(arch);
            let told = of - survivors.len();
            let mut said = format!("{}: {told} of {of} flips are told\n", arch.name);
            let rows: Vec<_> = survivors.iter().map(row_of).collect();
            for (Chosen { file, line, .. }, row) in survivors.iter().zip(&rows) {
                let reason = row.map_or("NO REASON", |row| &reasons[row][2]);
                said += &format!("  {file}; {line}; {reason}\n");
            }
            println!("{said}");
            rows
        })
        .collect();
    let unknown = rows.iter().filter(|row| row.is_none()).count();
    assert_eq!(unknown, 0, "survivors for which no row gives a reason");
    for row in (0..reasons.len()).filter(|row| !rows.contains(&Some(*row))) {
        println!("nothing needs {:?}", reasons[row]);
    }
}
