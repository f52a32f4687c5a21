//! Proofs about exported Verilog, for all inputs and any number of cycles, by Yosys and z3.
//!
//! `formal/allocator.v` states the contract of a section allocator at its ports, `formal/free_list.vh`
//! what holds inside the free list. Induction proves both together: they hold before the first
//! cycle, and a cycle from any state in which they hold leads to one in which they hold. Nothing
//! that is said of the inside is taken for granted.
//!
//! A check that cannot fail proves nothing. So each of [`FAULTS`] is put into the text, and the
//! contract alone must find it from reset; and a run must exist in which all sections go out, come
//! back and go out again, so that the assumptions do not exclude what matters.

#[path = "../../testbench/command/tests/tools/mod.rs"]
mod tools;

use pellucid_blocks::allocator::{Config, FreeList};
use pellucid_sim::netlist::elaborate;
use pellucid_verilog::{File, files};
use std::fmt::Write;
use std::path::Path;
use std::process::Command;

/// Longer than the longest run that a fault or a cover needs, in cycles.
const CYCLES: &str = "20";

fn have_tools() -> bool {
    tools::have(&["yosys", "yosys-smtbmc", "z3"])
}

/// What a tool printed, and whether it ended well.
fn run(folder: &Path, tool: &str, arguments: &[&str]) -> (bool, String) {
    let output = Command::new(tool).args(arguments).current_dir(folder).output().unwrap();
    let printed = [output.stdout, output.stderr].concat();
    (output.status.success(), String::from_utf8_lossy(&printed).into_owned())
}

/// The words of the queue as one vector. A memory's words are wires of their own once Yosys made
/// registers of them, and only text can count through their names.
fn words(sections: u32) -> String {
    let name = |k| format!("\\list.u_queue.u_memory.words[{k}] ");
    let mut text = String::new();
    for k in 0..sections {
        writeln!(text, "(* hierconn *) wire [ID_BITS-1:0] {};", name(k)).unwrap();
    }
    let all: Vec<String> = (0..sections).rev().map(name).collect();
    text + &format!("wire [N*ID_BITS-1:0] words = {{{}}};\n", all.join(", "))
}

/// What is asked of a design.
enum Question {
    /// Every property, of the ports and of the inside, holds in the first cycle.
    Base,
    /// And in any cycle that follows one in which all hold.
    Induction,
    /// The contract holds in the first cycles, whatever the inside does.
    Bounded,
    /// The run exists in which all sections go round.
    Cover,
}

/// The solver's answer: whether what was asked is so, and what it printed.
fn ask(design: &[File], sections: u32, question: Question) -> (bool, String) {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    design.iter().for_each(|file| write(&file.name, &file.text));
    write("contract.v", include_str!("formal/allocator.v"));
    write("inside.vh", include_str!("formal/free_list.vh"));
    write("words.vh", &words(sections));

    let (inside, arguments) = match question {
        Question::Base => ("-DINSIDE", ["-t", "1"].as_slice()),
        Question::Induction => ("-DINSIDE", ["-i", "-t", "1"].as_slice()),
        Question::Bounded => ("", ["-t", CYCLES].as_slice()),
        Question::Cover => ("", ["-c", "-t", CYCLES].as_slice()),
    };
    let names: Vec<&str> = design.iter().map(|file| file.name.as_str()).collect();
    let script = format!(
        "read_verilog {}; read_verilog -formal -DSECTIONS={sections} {inside} contract.v; \
         hierarchy -check -top contract; proc; memory_collect; memory_map; flatten; opt_clean; \
         write_smt2 -wires contract.smt2",
        names.join(" ")
    );
    let (built, printed) = run(folder.path(), "yosys", &["-q", "-p", &script]);
    assert!(built, "{printed}");

    // Without `--unroll` z3 takes minutes over the nested functions of three sections.
    let arguments =
        [&["-s", "z3", "--unroll", "--noprogress"], arguments, &["contract.smt2"]].concat();
    let (_, printed) = run(folder.path(), "yosys-smtbmc", &arguments);
    let yes = printed.contains("Status: PASSED");
    assert!(yes || printed.contains("Status: FAILED"), "{printed}");
    (yes, printed)
}

fn free_list(sections: u32) -> Vec<File> {
    files(&elaborate::<FreeList>(&Config { sections }), &[])
}

#[test]
fn no_section_is_granted_twice_or_lost() {
    if !have_tools() {
        return;
    }
    for sections in 1..=5 {
        for question in [Question::Base, Question::Induction, Question::Cover] {
            let (holds, printed) = ask(&free_list(sections), sections, question);
            assert!(holds, "{sections} sections:\n{printed}");
        }
    }
}

/// A fault: the file, what stands there once, what is put in its place.
type Fault = (&'static str, &'static str, &'static str);

/// Faults of a free list of three sections.
const FAULTS: [Fault; 8] = [
    // A push writes where the front is.
    ("fifo.v", ".write_addr_i(tail_q)", ".write_addr_i(head_q)"),
    // The front stays in the read register after a pop.
    ("fifo.v", "(pop || (count_q", "(1'd0 || (count_q"),
    // A word that is pushed into an empty queue is read before it is written.
    ("ram_1r1w.v", "bypass_q <= write_en_i &&", "bypass_q <= 1'b0 &&"),
    // The last place of the queue is passed over when it is read.
    ("fifo.v", "n_2 == 3'd3", "n_2 == 3'd2"),
    // A grant of a section that came back does not pop.
    ("free_list.v", "take_i && n;", "1'd0 && n;"),
    // Every second section is never granted.
    ("free_list.v", "fresh_q + 2'd1", "fresh_q + 2'd2"),
    // The first section is lost by a reset.
    ("free_list.v", "fresh_q <= 2'd0", "fresh_q <= 2'd1"),
    // The queue goes on while the list is not enabled.
    ("free_list.v", ".en_i(en_i)", ".en_i(1'd1)"),
];

#[test]
fn every_fault_is_seen() {
    if !have_tools() {
        return;
    }
    // Without a fault the contract holds: that is proved above.
    let sections = 3;
    for (name, from, to) in FAULTS {
        let mut design = free_list(sections);
        let file = design.iter_mut().find(|file| file.name == name).unwrap();
        assert_eq!(file.text.matches(from).count(), 1, "`{from}` in {name}");
        file.text = file.text.replace(from, to);
        let (holds, printed) = ask(&design, sections, Question::Bounded);
        let seen = printed.contains("Assert failed in contract: ");
        assert!(!holds && seen, "`{to}` in {name} is not seen:\n{printed}");
    }
}
