//! Netlists as Verilog-2005 that Icarus, Verilator and Yosys take alike.
//!
//! [`files`] gives one module per block, in the hierarchy of the Rust source; a block that stands in
//! several configurations gives several. [`lockstep`] writes the testbench that replays a recorded run.
//!
//! ```
//! use pellucid_sim::netlist::elaborate;
//! use pellucid_sim::{Fifo, fifo};
//!
//! // A queue of four numbers of eight bits.
//! let queue = elaborate::<Fifo<u32>>(&fifo::Config { depth: 4, item: 8 });
//! let files = pellucid_verilog::files(&queue, &["an example".to_string()]);
//! let top = files.iter().find(|file| file.name == "fifo.v").unwrap();
//! assert!(top.text.contains("module fifo"));
//! ```

mod expression;
pub mod lockstep;
pub mod macros;
mod module;
mod names;
pub mod outside;
mod ram;

use pellucid_sim::netlist::{Ask, Module};
use std::collections::BTreeMap;

pub use module::{Signal, instances, ports};

/// A file of an export.
#[derive(Clone)]
pub struct File {
    /// Its name.
    pub name: String,
    /// What stands in it.
    pub text: String,
}

/// The modules of a design, children before parents; those with the same text are one.
#[derive(Default)]
struct Library {
    /// The block's name, what its first instance is called, and the text with placeholders.
    known: Vec<(&'static str, String, String)>,
    /// Where each block's source stands.
    sources: Vec<&'static str>,
}

/// Stands for the name of module `k` until all names are known.
fn placeholder(k: usize) -> String {
    format!("\u{1}{k}\u{1}")
}

impl Library {
    fn add(&mut self, module: &Module, called: &str) -> usize {
        let children: Vec<usize> =
            module.instances.iter().map(|i| self.add(&i.module, &i.path)).collect();
        let own = "\u{1}self\u{1}";
        let text = module::text(module, own, |k| placeholder(children[k]));
        let same =
            |(block, _, known): &(&str, String, String)| *block == module.name && *known == text;
        self.known.iter().position(same).unwrap_or_else(|| {
            self.known.push((module.name, called.to_string(), text));
            self.sources.push(module.source);
            self.known.len() - 1
        })
    }

    /// A block's name alone where there is one module of it, else with what the instance is called.
    fn names(&self) -> Vec<String> {
        let mut count = BTreeMap::new();
        for (block, ..) in &self.known {
            *count.entry(*block).or_insert(0) += 1;
        }
        let mut names = names::Names::default();
        self.known
            .iter()
            .map(|(block, called, _)| {
                let last = called.rsplit('.').next().unwrap_or(called);
                let several = count[block] > 1 && !last.is_empty();
                names.unique(&if several { format!("{block}_{last}") } else { block.to_string() })
            })
            .collect()
    }
}

/// Every memory of a module and its children.
fn each_ram(module: &Module, see: &mut dyn FnMut(&Ask)) {
    module.rams.iter().for_each(|ram| see(&ram.ask));
    module.instances.iter().for_each(|i| each_ram(&i.module, see));
}

/// The files of a design: a module each, the top one last. `about` are the lines of their first comment.
pub fn files(top: &Module, about: &[String]) -> Vec<File> {
    let mut library = Library::default();
    library.add(top, "");
    let names = library.names();
    let about: String = about.iter().map(|line| format!("// {line}\n")).collect();
    let mut files = vec![];
    let (mut two_ports, mut one_port) = (false, false);
    each_ram(top, &mut |ask| match ask {
        Ask::OneReadOneWrite { .. } => two_ports = true,
        Ask::One { .. } => one_port = true,
    });
    let rams = [
        ("ram_1r1w", ram::RAM_1R1W, two_ports),
        ("ram_1rw", ram::RAM_1RW, one_port),
        ("ram_delay", ram::RAM_DELAY, two_ports || one_port),
    ];
    for (name, text, needed) in rams {
        if needed {
            files.push(File { name: format!("{name}.v"), text: text.to_string() });
        }
    }
    for (k, (_, _, text)) in library.known.iter().enumerate() {
        let mut text = text.replace("\u{1}self\u{1}", &names[k]);
        for (child, name) in names.iter().enumerate() {
            text = text.replace(&placeholder(child), name);
        }
        let source = format!("// From the Rust block in {}.\n", library.sources[k]);
        files
            .push(File { name: format!("{}.v", names[k]), text: format!("{about}{source}{text}") });
    }
    files
}
