//! Memories as macros: what a library of standard cells does not have, and synthesis leaves as it is.
//!
//! The words of a memory become an instance of a module without a body. What stands around them in the exported memories, valid bits and
//! the bypass of a word that is read as it is written, stays logic.

use crate::File;
use pellucid_sim::Ports;
use pellucid_sim::bits_for;
use pellucid_sim::netlist::Module;

/// The words of a memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Macro {
    /// Its ports.
    pub ports: Ports,
    /// How many words.
    pub words: u64,
    /// Bits of a word.
    pub bits: u32,
}

impl Macro {
    /// The module's name.
    pub fn name(&self) -> String {
        let kind = match self.ports {
            Ports::OneReadOneWrite => "1r1w",
            Ports::One => "1rw",
        };
        format!("sram_{kind}_{}x{}", self.words, self.bits)
    }

    /// Bits of an address.
    pub fn address_bits(&self) -> u32 {
        bits_for(self.words - 1)
    }

    /// The inputs beside the clock, with how many bits each has; there is one output, `data_o`.
    pub fn inputs(&self) -> Vec<(&'static str, u32)> {
        let address = self.address_bits();
        match self.ports {
            Ports::OneReadOneWrite => vec![
                ("read_i", 1),
                ("read_addr_i", address),
                ("write_i", 1),
                ("write_addr_i", address),
                ("data_i", self.bits),
            ],
            Ports::One => {
                vec![("read_i", 1), ("write_i", 1), ("addr_i", address), ("data_i", self.bits)]
            }
        }
    }

    /// The module, without a body.
    fn module(&self) -> String {
        let inputs = self.inputs().into_iter();
        let inputs: String =
            inputs.map(|(name, bits)| format!("  input [{}:0] {name},\n", bits - 1)).collect();
        format!(
            "(* blackbox *)\nmodule {} (\n  input clk,\n{inputs}  output [{}:0] data_o\n);\nendmodule\n",
            self.name(),
            self.bits - 1
        )
    }

    /// An instance of it in the exported memory of its size.
    fn instance(&self) -> String {
        let asked = match self.ports {
            Ports::OneReadOneWrite => {
                ".read_i(read), .read_addr_i(read_addr_i), .write_i(write_en_i && !rst), \
                 .write_addr_i(write_addr_i), .data_i(write_data_i)"
            }
            Ports::One => {
                ".read_i(access && !write_i), .write_i(access && write_i), .addr_i(addr_i), .data_i(data_i)"
            }
        };
        let (name, Macro { words, bits, .. }) = (self.name(), self);
        format!(
            "    if (WORDS == {words} && BITS == {bits}) begin : {name}\n      {name} u_words \
             (.clk(clk), {asked}, .data_o(read_data_q));\n    end\n"
        )
    }
}

/// Each size of memory that the design has, once.
fn sizes(module: &Module, into: &mut Vec<Macro>) {
    for ram in &module.rams {
        let info = &ram.info;
        let size = Macro { ports: info.ports, words: info.words, bits: info.bits_per_word };
        if !into.contains(&size) {
            into.push(size);
        }
    }
    module.instances.iter().for_each(|instance| sizes(&instance.module, into));
}

/// The file of the macros.
pub const FILE: &str = "macros.v";

/// The files of a design with macros in the place of its memories' words, and these.
pub fn with_macros(design: &Module, files: &[File]) -> (Vec<File>, Vec<Macro>) {
    let mut macros = vec![];
    sizes(design, &mut macros);
    let text = macros.iter().map(Macro::module).collect();
    let all = [File { name: FILE.to_string(), text }].into_iter().chain(files.iter().map(|file| {
        let ports = match file.name.as_str() {
            "ram_1r1w.v" => Ports::OneReadOneWrite,
            "ram_1rw.v" => Ports::One,
            _ => return file.clone(),
        };
        let of_kind = macros.iter().filter(|size| size.ports == ports);
        let instances: String = of_kind.map(Macro::instance).collect();
        File { name: file.name.clone(), text: without_words(&file.text, &instances) }
    }));
    (all.collect(), macros)
}

/// A memory's module with `instances` in the place of its words.
fn without_words(text: &str, instances: &str) -> String {
    let mut without = String::new();
    for line in text.lines() {
        let register = line.trim_start().starts_with("reg [BITS-1:0] read_data_q;");
        let of_words =
            ["words [", "words[", "initial read_data_q"].iter().any(|part| line.contains(part));
        if register {
            without += "  wire [BITS-1:0] read_data_q;\n";
        } else if line == "endmodule" {
            without += &format!("  generate\n{instances}  endgenerate\nendmodule\n");
        } else if !of_words {
            without += &format!("{line}\n");
        }
    }
    without
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ram::{RAM_1R1W, RAM_1RW};

    #[test]
    fn nothing_is_left_of_the_words_but_the_macro() {
        for (text, ports, name) in [
            (RAM_1R1W, Ports::OneReadOneWrite, "sram_1r1w_5x7"),
            (RAM_1RW, Ports::One, "sram_1rw_5x7"),
        ] {
            let size = Macro { ports, words: 5, bits: 7 };
            assert_eq!((size.name().as_str(), size.address_bits()), (name, 3));
            let found = without_words(text, &size.instance());
            let code: Vec<&str> = found.lines().filter(|line| !line.starts_with("//")).collect();
            let with = |part: &str| code.iter().filter(|line| line.contains(part)).count();
            assert_eq!(
                [with("words["), with("words ["), with("reg [BITS-1:0] read_data_q")],
                [0; 3]
            );
            assert_eq!(
                [with("wire [BITS-1:0] read_data_q"), with("u_words"), with("valid_q <=")],
                [1; 3]
            );
            assert!(
                size.module().contains("  input [2:0] ")
                    && size.module().contains("output [6:0] data_o")
            );
        }
    }
}
