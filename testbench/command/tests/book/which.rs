//! The worked study: its tables and its plot are made of the results that are stored beside it.

use super::page::{holds, root, stored, text_of};
use pellucid_testbench::plots::{hex, lines};
use pellucid_testbench::report::grouped;
use serde_json::{Value, json};
use std::process::Command;

/// The page.
const PAGE: &str = "which-machine.md";
/// Bytes on the chip, in KiB.
const BUDGETS: [u64; 5] = [1024, 1280, 1536, 1792, 2048];

/// A design with what came of it on every scene.
struct Design {
    name: String,
    arch: String,
    points: Vec<Value>,
}

impl Design {
    /// Nothing is wrong with it on any scene.
    fn is_right(&self) -> bool {
        self.points.iter().all(|point| point["status"] == "right")
    }

    fn cycles(&self, scene: usize) -> u64 {
        self.points[scene]["cycles"].as_u64().unwrap()
    }

    /// The geometric mean of all scenes.
    fn mean(&self) -> f64 {
        let logs = (0..self.points.len()).map(|scene| (self.cycles(scene) as f64).ln());
        (logs.sum::<f64>() / self.points.len() as f64).exp()
    }

    fn bytes(&self) -> u64 {
        self.points.iter().map(|point| point["on_chip_bytes"].as_u64().unwrap()).max().unwrap()
    }
}

fn designs() -> Vec<Design> {
    let mut designs: Vec<Design> = vec![];
    for line in text_of(&root().join("docs/studies/which-machine/results.jsonl")).lines() {
        let point: Value = serde_json::from_str(line).unwrap();
        let name = point["machine"].as_str().unwrap();
        match designs.iter_mut().find(|design| design.name == name) {
            Some(design) => design.points.push(point),
            None => designs.push(Design {
                name: name.to_string(),
                arch: point["arch"].as_str().unwrap().to_string(),
                points: vec![point],
            }),
        }
    }
    designs
}

/// The fastest right design of an architecture within so many bytes.
fn best<'a>(designs: &'a [Design], arch: &str, bytes: u64) -> Option<&'a Design> {
    let those = designs.iter().filter(|d| d.arch == arch && d.is_right() && d.bytes() <= bytes);
    those.min_by(|a, b| a.mean().total_cmp(&b.mean()))
}

fn archs(designs: &[Design]) -> Vec<&str> {
    let mut archs: Vec<&str> = vec![];
    for design in designs {
        if !archs.contains(&&*design.arch) {
            archs.push(&design.arch);
        }
    }
    archs
}

fn thousands(cycles: f64) -> String {
    grouped(&json!((cycles / 1000.0).round() as u64))
}

#[test]
fn the_worked_study_says_what_its_results_say() {
    let designs = designs();
    let archs = archs(&designs);
    let mut budgets = String::from("| kilocycles, geometric mean |");
    budgets += &BUDGETS.map(|kib| format!(" {:.2} MiB |", kib as f64 / 1024.0)).concat();
    budgets += &format!("\n|---|{}\n", "---|".repeat(BUDGETS.len()));
    let mut series = vec![];
    for arch in &archs {
        let means = BUDGETS.map(|kib| best(&designs, arch, kib * 1024).map(Design::mean));
        let cells = means.map(|mean| mean.map_or("-".to_string(), thousands));
        budgets += &format!("| `{arch}` | {} |\n", cells.join(" | "));
        series.push(means.map(|mean| mean.unwrap_or(f64::NAN) / 1000.0).to_vec());
    }
    holds(PAGE, "budgets", &budgets);

    let labels = BUDGETS.map(|kib| format!("{:.2}", kib as f64 / 1024.0));
    let axes = ("MiB on the chip", "kilocycles, geometric mean of four scenes");
    // As a file of its own it says what it is.
    let plot = lines(&labels, &series, axes, &[]).unwrap();
    let plot = plot.replacen("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ", 1);
    stored("docs/src/which-machine.svg", &plot);
    let legend = archs
        .iter()
        .enumerate()
        .map(|(k, arch)| format!("<span style=\"color:{}\">&#9632;</span> `{arch}`", hex(k)));
    holds(PAGE, "legend", &legend.collect::<Vec<_>>().join(" &nbsp; "));

    let most = BUDGETS[BUDGETS.len() - 1] * 1024;
    let mut fastest: Vec<&Design> =
        archs.iter().filter_map(|arch| best(&designs, arch, most)).collect();
    fastest.sort_by(|a, b| a.mean().total_cmp(&b.mean()));
    let mut table = String::from(
        "| design | on chip, bytes | glass | smoke | plant | dragon | against the best |\n|---|---|---|---|---|---|---|\n",
    );
    for design in &fastest {
        let scenes = (0..design.points.len()).map(|scene| thousands(design.cycles(scene) as f64));
        table += &format!(
            "| `{}` | {} | {} | {:.2} |\n",
            design.name,
            grouped(&json!(design.bytes())),
            scenes.collect::<Vec<_>>().join(" | "),
            design.mean() / fastest[0].mean()
        );
    }
    holds(PAGE, "fastest", &table);
}

/// What is stored is what runs say today: the best design of each architecture on the first scene.
#[test]
fn the_stored_results_are_those_of_the_commands_beside_them() {
    let designs = designs();
    let folder = tempfile::tempdir().unwrap();
    for arch in archs(&designs) {
        let Some(design) = best(&designs, arch, u64::MAX) else { continue };
        let point = &design.points[0];
        let words = point["command"].as_str().unwrap().split(' ').skip(1);
        let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(words)
            .args(["--no-wave", "--json", "--out"])
            .arg(folder.path())
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let report: Value = serde_json::from_slice(&run.stdout).unwrap();
        assert_eq!(report["cycles"]["total"], point["cycles"], "{}", point["command"]);
        assert_eq!(report["storage"]["on_chip_bytes"], point["on_chip_bytes"]);
    }
}
