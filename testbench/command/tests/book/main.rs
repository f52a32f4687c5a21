//! The book tells the truth: what its pages say of the code is what the code says.
//!
//! Parts of the pages are made from the code: see [`page`]. If one of them is out of date, its test
//! fails and says how to bring it up to date.

mod licences;
mod page;
mod reading;
mod timing;
mod which;

use page::{documented, holds, link_targets, root, text_of};
use pellucid_blocks::allocator::{self, FreeList};
use pellucid_blocks::chains::config::Scan;
use pellucid_hw::ARCHITECTURES;
use pellucid_machine::Architecture;
use pellucid_machine::params::Param;
use pellucid_machine::pixel::Screen;
use pellucid_sim::netlist::elaborate;
use pellucid_sim::{Declare, Kind};
use pellucid_tbuffer::config::Append;
use pellucid_testbench::outside::board;
use serde_json::{Map, Value};
use std::path::Path;
use std::process::Command;

#[test]
fn what_pages_quote_from_the_sources_is_there() {
    let example = documented("sim/src/lib.rs", "```\n");
    holds("clock.md", "example", &format!("```rust\n{example}\n```\n"));
    for arch in ARCHITECTURES {
        let diagram = documented(&format!("hw/{}/src/lib.rs", arch.name), "```text\n");
        holds(&format!("{}.md", arch.name), "diagram", &format!("```text\n{diagram}\n```\n"));
    }
    let diagram = documented("hw/machine/src/outside.rs", "```text\n");
    holds("outside.md", "outside", &format!("```text\n{diagram}\n```\n"));
    for (file, part) in [("mod", "chains"), ("read_back", "read-back")] {
        let diagram = documented(&format!("hw/blocks/src/chains/{file}.rs"), "```text\n");
        holds("tbuffer.md", part, &format!("```text\n{diagram}\n```\n"));
    }
    for (file, part) in [("merger", "merger"), ("scan_line/mod", "scan-line"), ("store", "store")] {
        let diagram = documented(&format!("hw/composer/src/{file}.rs"), "```text\n");
        holds("composer.md", part, &format!("```text\n{diagram}\n```\n"));
    }
    for (file, part) in [("mbuffer/src/array", "array"), ("blocks/src/chains/weigh", "weigh")] {
        let diagram = documented(&format!("hw/{file}.rs"), "```text\n");
        holds("mbuffer.md", part, &format!("```text\n{diagram}\n```\n"));
    }
}

/// What a fault changes stands once where it says; else the script that seeds faults ends there.
#[test]
fn every_fault_fits_its_source() {
    let faults = text_of(&root().join("testbench/faults/faults.txt"));
    for line in faults.lines().filter(|line| !line.is_empty() && !line.starts_with('#')) {
        // A bar of the source is escaped.
        let line = line.replace("\\|", "\0");
        let [file, from, ..] = line.split('|').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let from = from.trim().replace('\0', "|");
        let found = text_of(&root().join(file.trim())).matches(&from).count();
        assert_eq!(found, 1, "{file}: `{from}` is expected once");
    }
}

#[test]
fn the_readme_lists_every_architecture() {
    let mut table = String::from("| architecture | what it is |\n|---|---|\n");
    for Architecture { name, about, .. } in ARCHITECTURES {
        table += &format!("| [`{name}`](docs/src/{name}.md) | {about} |\n");
    }
    holds("../../README.md", "architectures", &table);
}

fn parameters(list: impl IntoIterator<Item = Param>) -> String {
    let mut table =
        String::from("| parameter | default | unit | range | meaning |\n|---|---|---|---|---|\n");
    for Param { name, default, unit, range, about } in list {
        table += &format!("| `{name}` | `{default}` | {unit} | {range} | {about} |\n");
    }
    table
}

/// The tables of an architecture's parameters and presets.
fn parameters_and_presets(arch: &Architecture) {
    let page = &format!("{}.md", arch.name);
    // Those of parts are on the pages of these.
    let own = (arch.parameters)().into_iter().filter(|p| !p.name.contains('.'));
    holds(page, "parameters", &parameters(own));

    let mut table =
        String::from("| preset | what it is | differs from the default in |\n|---|---|---|\n");
    let screen = Screen { width: 64, height: 48, background: 0 };
    for (preset, about) in (arch.presets)() {
        let values = arch.build(screen, Some(preset), &[]).unwrap().values().into_iter();
        let differs: Vec<String> = (arch.parameters)()
            .into_iter()
            .zip(values)
            .filter(|(parameter, (_, own))| parameter.default != own.to_string())
            .map(|(_, (name, value))| format!("`{name}={value}`"))
            .collect();
        let differs = if differs.is_empty() { "nothing".into() } else { differs.join(", ") };
        table += &format!("| `{preset}` | {about} | {differs} |\n");
    }
    holds(page, "presets", &table);
}

#[test]
fn the_tables_of_parameters_and_presets_are_those_of_the_code() {
    ARCHITECTURES.iter().for_each(|arch| parameters_and_presets(arch));
    holds("outside.md", "settings", &parameters(board::settings()));
}

/// Collects the state machines of a bundle of registers.
#[derive(Default)]
struct StateMachines {
    path: Vec<String>,
    found: Vec<(String, &'static [&'static str])>,
}

impl Declare for StateMachines {
    fn open(&mut self, name: &str) {
        self.path.push(name.to_string());
    }
    fn close(&mut self) {
        self.path.pop();
    }
    fn signal(&mut self, name: &str, _: u32, kind: Kind) {
        if let Kind::State(states) = kind {
            self.found.push((format!("{}.{name}", self.path.join(".")), states.variants));
        }
    }
}

#[test]
fn the_numbers_of_states_are_those_of_the_code() {
    let screen = Screen { width: 1, height: 1, background: 0 };
    let mut table = String::from("| architecture | state machine | states |\n|---|---|---|\n");
    for arch in ARCHITECTURES {
        let mut machines = StateMachines::default();
        arch.build(screen, None, &[]).unwrap().power_up().declare(&mut machines);
        // Of several in a line the first one stands for all.
        let first = |path: &str| path.split('[').skip(1).all(|rest| rest.starts_with("0]"));
        let registers = machines.found.into_iter();
        let registers = registers.filter(|(path, _)| path.starts_with("registers") && first(path));
        let arch = arch.name;
        for (path, states) in registers {
            let states: Vec<String> = states
                .iter()
                .enumerate()
                .map(|(number, name)| format!("{number} `{name}`"))
                .collect();
            table += &format!("| `{arch}` | `{path}` | {} |\n", states.join(", "));
        }
    }
    holds("waveforms.md", "states", &table);
}

#[test]
fn the_timing_diagrams_are_those_of_the_model() {
    let tail = timing::run(Append::Tail, Scan::Bitmap);
    holds("timing.md", "store-tail", &tail.store());
    holds("timing.md", "resolve-tail", &tail.resolve());
    holds("timing.md", "image", &tail.image());
    let walk = timing::run(Append::Walk, Scan::Linear);
    holds("timing.md", "store-walk", &walk.store());
    holds("timing.md", "resolve-walk", &walk.resolve());
}

#[test]
fn the_waveform_that_is_read_is_that_of_the_run() {
    let run = reading::Run::new(root());
    let page = text_of(&root().join("docs/src/reading.md"));
    let told: String = page.replace("\\\n", " ").split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(told.contains(&format!("pellucid {}", reading::ARGUMENTS)), "it is told how to run it");
    holds("reading.md", "markers", &run.markers());
    let store = [
        ("phase", "wires.phase"),
        ("fragment", "wires.fragment.label"),
        ("depth_test: stage", "registers.front.depth_test.stage.label"),
        ("passed", "wires.passed.label"),
        ("chains.store: stage", "registers.chains.store.stage.label"),
        ("  fsm", "registers.chains.store.fsm"),
        ("  queue.count", "registers.chains.store.queue.count"),
        ("  section_taken", "wires.chains.events.section_taken"),
        ("  grant.payload", "wires.chains.grant.payload"),
        ("  stored", "wires.chains.events.stored"),
        ("ssa.table word[1].head", "memories.chains.ssa.table.word[1].head"),
        ("ssa.table word[1].tail", "memories.chains.ssa.table.word[1].tail"),
        ("ssa.table word[1].fill", "memories.chains.ssa.table.word[1].fill"),
        ("nsa.table word[0].next", "memories.chains.nsa.table.word[0].next"),
    ];
    holds("reading.md", "store", &run.table(0..9, &store));
    let resolve = [
        ("phase", "wires.phase"),
        ("chains.arrived", "wires.chains.arrived.label"),
        ("sorter: entries[0]", "registers.sorter.entries[0].label"),
        ("  entries[1]", "registers.sorter.entries[1].label"),
        ("  entries[2]", "registers.sorter.entries[2].label"),
        ("  count", "registers.sorter.count"),
        ("  closed", "registers.sorter.closed"),
        ("sorted", "wires.sorted.label"),
        ("blender: stage", "registers.blender.stage.label"),
        ("  blended", "wires.events.blended"),
    ];
    holds("reading.md", "resolve", &run.table(16..29, &resolve));
}

/// Energy, area and time of every preset, on a small frame: on the page of each architecture, and of the first ones side by side.
#[test]
fn what_each_architecture_costs_is_what_runs_say() {
    let folder = tempfile::tempdir().unwrap();
    let head = |what: &str| {
        format!(
            "| {what} | cycles | clock, MHz | frame, us | memories, mm2 | reads and writes, nJ | leakage, nJ |\n\
             |---|---|---|---|---|---|---|\n"
        )
    };
    let mut first = head("architecture");
    for arch in ARCHITECTURES {
        let mut table = head("preset");
        for (k, (preset, _)) in (arch.presets)().into_iter().enumerate() {
            let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
                .args(["run", "--arch", arch.name, "--preset", preset])
                .args(["--width", "160", "--height", "120", "--no-wave", "--json", "--out"])
                .arg(folder.path())
                .output()
                .unwrap();
            assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
            let report: Value = serde_json::from_slice(&run.stdout).unwrap();
            let figure = |group: &str, name: &str| report[group][name].as_f64().unwrap();
            let dynamic = figure("energy", "reads") + figure("energy", "writes");
            let row = format!(
                "{} | {:.0} | {:.0} | {:.2} | {dynamic:.0} | {:.0} |\n",
                report["cycles"]["total"],
                figure("time", "clock"),
                figure("time", "frame"),
                figure("area", "memories"),
                figure("energy", "leakage"),
            );
            table += &format!("| `{preset}` | {row}");
            if k == 0 {
                first += &format!("| `{}` | {row}", arch.name);
            }
        }
        holds(&format!("{}.md", arch.name), "costs", &table);
    }
    holds("energy.md", "architectures", &first);
}

#[test]
fn every_figure_of_a_run_is_explained() {
    let folder = tempfile::tempdir().unwrap();
    let mut about = Map::new();
    // A frame buffer outside has figures of its own, and so has a DRAM.
    let alone = ARCHITECTURES.iter().map(|arch| {
        let has = (arch.parameters)().iter().any(|param| param.name == "framebuffer");
        (arch.name, if has { "framebuffer=cached" } else { "outside=fixed" })
    });
    for (arch, setting) in alone.chain([("tbuffer", "outside=ddr4-3200")]) {
        let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(["run", "--arch", arch, "--width", "64", "--height", "48", "--no-wave"])
            .args(["-p", setting, "--json", "--out"])
            .arg(folder.path())
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let report: Value = serde_json::from_slice(&run.stdout).unwrap();
        about.extend(report["about"].as_object().unwrap().clone());
    }
    let mut groups: Vec<&str> = vec![];
    for group in about.keys().map(|name| group_of(name)) {
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    let mut text = String::new();
    for group in groups {
        text += &figures_of(group, &about);
    }
    holds("figures.md", "figures", &text);
}

/// `cycles` of `cycles.store`.
fn group_of(name: &str) -> &str {
    name.split_once('.').map_or(name, |(group, _)| group)
}

fn figures_of(group: &str, about: &Map<String, Value>) -> String {
    let mut text = format!("### `{group}`\n\n| figure | unit | meaning |\n|---|---|---|\n");
    for (name, what) in about.iter().filter(|(name, _)| group_of(name) == group) {
        let field = |field: &str| what[field].as_str().unwrap();
        text += &format!("| `{name}` | {} | {} |\n", field("unit"), field("about"));
    }
    text + "\n"
}

#[test]
fn the_catalogue_lists_every_block_and_nothing_else() {
    let page = text_of(&root().join("docs/src/blocks.md"));
    let mut files = vec![];
    let architectures = ARCHITECTURES.iter().map(|arch| format!("hw/{}/src", arch.name));
    let shared = ["sim/src", "hw/blocks/src", "hw/machine/src"].map(String::from);
    for folder in shared.into_iter().chain(architectures) {
        page::source_files(Path::new(&folder), &mut files);
    }
    let is_block =
        |file: &str| !["lib", "tests", "test_util", "architecture"].contains(&page::stem(file));
    files.retain(|file| is_block(file));
    for file in &files {
        assert!(page.contains(&format!("`{file}`")), "docs/src/blocks.md does not list `{file}`");
    }
    let quoted = page.split('`').skip(1).step_by(2).filter(|text| text.ends_with(".rs"));
    for file in quoted {
        assert!(root().join(file).is_file(), "docs/src/blocks.md lists `{file}`: no such file");
    }
}

#[test]
fn links_lead_somewhere_and_the_contents_name_every_page() {
    let source = root().join("docs/src");
    let mut pages = vec![root().join("README.md"), root().join("CHANGELOG.md")];
    pages.extend(std::fs::read_dir(&source).unwrap().map(|entry| entry.unwrap().path()));
    pages.retain(|path| path.extension().is_some_and(|e| e == "md"));
    for page in &pages {
        for target in link_targets(&text_of(page)) {
            let file = page.parent().unwrap().join(&target);
            assert!(file.exists(), "{}: the link to `{target}` leads nowhere", page.display());
        }
    }
    let contents = link_targets(&text_of(&source.join("SUMMARY.md")));
    for page in pages.iter().filter(|page| page.starts_with(&source)) {
        let name = page.file_name().unwrap().to_str().unwrap();
        let listed = name == "SUMMARY.md" || contents.iter().any(|target| target == name);
        assert!(listed, "docs/src/SUMMARY.md does not name {name}");
    }
}

#[test]
fn the_verilog_on_its_page_is_what_is_exported() {
    let module = elaborate::<FreeList>(&allocator::Config { sections: 4 });
    let files = pellucid_verilog::files(&module, &[]);
    let text = &files.iter().find(|file| file.name == "free_list.v").unwrap().text;
    holds("verilog.md", "free-list", &format!("```verilog\n{text}```\n"));
}
