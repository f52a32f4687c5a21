//! The blocks of a machine, and which of them something of the flattened design is in.

use pellucid_sim::netlist::{Module, Ram};
use pellucid_verilog::instances;

/// A block of the hierarchy.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Where it stands below the machine; empty for the machine itself.
    pub path: String,
    /// Its block.
    pub block: &'static str,
    /// Bits of all memories that are in it.
    pub memory_bits: u64,
    /// Its name in the flattened Verilog, with a dot behind it.
    prefix: String,
    /// How many places from here on are in it, itself among them.
    size: usize,
}

/// The machine and its blocks, each before those in it.
#[derive(Clone, Debug)]
pub(super) struct Tree {
    pub places: Vec<Place>,
}

fn joined(path: &str, below: &str) -> String {
    let separator = if path.is_empty() || below.is_empty() { "" } else { "." };
    format!("{path}{separator}{below}")
}

impl Tree {
    pub fn new(machine: &Module) -> Tree {
        Tree::with_memories(machine, &mut |_, _| {})
    }

    /// The same, and tells `see` of every memory, with the number of the place that it stands in.
    pub fn with_memories(machine: &Module, see: &mut dyn FnMut(usize, &Ram)) -> Tree {
        let mut tree = Tree { places: vec![] };
        tree.lay_out(machine, "", String::new(), see);
        tree
    }

    /// Adds a block and all that is in it, with their memories' bits; the bits of it all.
    fn lay_out(
        &mut self,
        module: &Module,
        path: &str,
        prefix: String,
        see: &mut dyn FnMut(usize, &Ram),
    ) -> u64 {
        let at = self.places.len();
        let (block, name) = (module.name, prefix.clone());
        self.places.push(Place { path: path.to_string(), block, memory_bits: 0, prefix, size: 1 });
        module.rams.iter().for_each(|ram| see(at, ram));
        let bits_of = |ram: &Ram| ram.info.words * u64::from(ram.info.bits_per_word);
        let mut bits = module.rams.iter().map(bits_of).sum();
        for (child, called) in module.instances.iter().zip(instances(module)) {
            let (path, prefix) = (joined(path, &child.path), format!("{name}{called}."));
            bits += self.lay_out(&child.module, &path, prefix, see);
        }
        self.places[at].size = self.places.len() - at;
        self.places[at].memory_bits = bits;
        bits
    }

    /// The numbers of the block in which something of the flattened design stands, and of those around it, from the outermost on.
    pub fn around(&self, name: &str) -> Vec<usize> {
        let name = name.replace("$flatten", "").replace('\\', "");
        let mut around = vec![0];
        let (mut k, mut end) = (1, self.places.len());
        while k < end {
            let Place { prefix, size, .. } = &self.places[k];
            if name.starts_with(prefix.as_str()) {
                around.push(k);
                (k, end) = (k + 1, k + size);
            } else {
                k += size;
            }
        }
        around
    }

    /// The numbers of a place and of those around it.
    pub fn over(&self, at: usize) -> impl Iterator<Item = usize> + '_ {
        (0..=at).filter(move |k| at < k + self.places[*k].size)
    }
}
