//! How much the comparison sees: operators of the exported text are flipped, one at a time, and the comparison must
//! fail. Those with which it does not stand in `faults/survivors.txt`, each with the reason.

use super::text::{Flip, flips, with_choice};
use super::{exercised, in_folder, text as said, tools};
use pellucid_hw::ARCHITECTURES;
use pellucid_machine::Architecture;
use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use std::collections::HashSet;
use std::path::Path;
use wildmatch::WildMatch;

/// Which flips are tried; the same ones each time.
const SEED: u64 = 1;

/// How many for each architecture, in the first of the ways to build it.
const FLIPS: usize = 100;

/// Files that are the same in every export.
const BY_HAND: [&str; 4] = ["ram_1r1w.v", "ram_1rw.v", "ram_delay.v", "lockstep_tb.v"];

/// A flip in a module.
struct Chosen {
    /// The module's file.
    file: String,
    flip: Flip,
    /// The line in which it stands.
    line: String,
}

/// Some operators of a folder's modules.
fn choose(folder: &Path) -> Vec<Chosen> {
    let list = std::fs::read_to_string(folder.join("files.f")).unwrap();
    let mut all = vec![];
    for file in list.lines().filter(|file| !BY_HAND.contains(file)) {
        let text = std::fs::read_to_string(folder.join(file)).unwrap();
        all.extend(flips(&text).into_iter().map(|flip| {
            let start = text[..flip.at].rfind('\n').map_or(0, |k| k + 1);
            let line = text[start..].lines().next().unwrap_or_default().trim().to_string();
            Chosen { file: file.to_string(), flip, line }
        }));
    }
    all.shuffle(&mut ChaCha8Rng::seed_from_u64(SEED));
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
    let folder = exercised((arch, arch.ways[0]));
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

/// Why flips survive: modules, operator, what the line has in which it stands, reason.
fn reasons() -> Vec<[String; 4]> {
    let table = concat!(env!("CARGO_MANIFEST_DIR"), "/../faults/survivors.txt");
    let text = std::fs::read_to_string(table).unwrap();
    let rows = text.lines().filter(|line| !line.is_empty() && !line.starts_with('#'));
    let cells = |row: &str| row.split("; ").map(String::from).collect::<Vec<_>>();
    rows.map(|row| cells(row).try_into().unwrap_or_else(|_| panic!("four cells: {row}"))).collect()
}

/// The comparison tells every flipped operator but those that stand in the table, and those it does not tell.
#[test]
#[ignore = "builds a machine of each architecture in Verilator and runs it a hundred times"]
fn flipped_operators_are_told() {
    if !tools::have(&["verilator"]) {
        return;
    }
    let reasons = reasons();
    let row_of = |Chosen { file, flip, line }: &Chosen| {
        let flip = format!("{} {}", flip.right, flip.wrong);
        reasons.iter().position(|[module, operator, part, _]| {
            WildMatch::new(module).matches(file) && *operator == flip && line.contains(part)
        })
    };
    let rows: Vec<Option<usize>> = ARCHITECTURES
        .par_iter()
        .flat_map_iter(|arch| {
            let (of, survivors) = survivors(arch);
            let told = of - survivors.len();
            let mut said = format!("{}: {told} of {of} flips are told\n", arch.name);
            let rows: Vec<_> = survivors.iter().map(row_of).collect();
            for (Chosen { file, flip, line }, row) in survivors.iter().zip(&rows) {
                let reason = row.map_or("NO REASON", |row| &reasons[row][3]);
                let (right, wrong) = (flip.right, flip.wrong);
                said += &format!("  {file}; {right} {wrong}; {line}; {reason}\n");
            }
            println!("{said}");
            rows
        })
        .collect();
    let unknown = rows.iter().filter(|row| row.is_none()).count();
    assert_eq!(unknown, 0, "survivors for which no row gives a reason");
    let rest: Vec<_> = (0..reasons.len()).filter(|row| !rows.contains(&Some(*row))).collect();
    let rest: Vec<_> = rest.iter().map(|row| &reasons[*row]).collect();
    assert!(rest.is_empty(), "nothing needs these rows: {rest:?}");
}
