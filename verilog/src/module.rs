//! One module's text.
//!
//! Inputs end in `_i`, outputs in `_o`, registers in `_q`, their next values in `_d`; instances begin
//! with `u_`. Everything is reset synchronously by `rst` and clocked while `en_i` is high.

use crate::expression::{Expressions, Need, bare, laid_out, number, range};
use crate::names::{Names, identifier, upper};
use pellucid_sim::ReadDuringWrite;
use pellucid_sim::bits_for;
use pellucid_sim::netlist::{Ask, Binary, Leaf, Module, Node, Op, Ram, Register, Type};
use std::collections::HashMap;

/// A port or another signal as text declares it.
pub struct Signal {
    /// Its name.
    pub name: String,
    /// How many bits.
    pub width: u32,
}

fn signals(leaves: &[Leaf], suffix: &str, names: &mut Names) -> Vec<Signal> {
    let named = |leaf: &Leaf| {
        let path = if leaf.path.is_empty() { "value" } else { &leaf.path };
        let name = names.unique(&format!("{path}{suffix}"));
        Signal { name, width: leaf.width }
    };
    leaves.iter().map(named).collect()
}

/// The module's ports, in the order of the block's declaration: inputs, outputs.
pub fn ports(module: &Module) -> (Vec<Signal>, Vec<Signal>) {
    let mut names = reserved();
    let inputs = signals(&module.inputs.leaves, "_i", &mut names);
    let outputs: Vec<Leaf> = module.outputs.iter().flat_map(|s| s.leaves.clone()).collect();
    (inputs, signals(&outputs, "_o", &mut names))
}

fn reserved() -> Names {
    let mut names = Names::default();
    for name in ["clk", "rst", "en_i", "unused"] {
        names.unique(name);
    }
    names
}

/// The wires that a child or a memory drives.
struct Driven {
    instance: String,
    outputs: Vec<Signal>,
}

fn path_or(path: &str, otherwise: &str) -> String {
    identifier(if path.is_empty() { otherwise } else { path })
}

/// What a module's text calls its parts.
struct Named {
    inputs: Vec<Signal>,
    outputs: Vec<Signal>,
    /// Registers of the module's own that ever change: which, the register, its next value.
    q: Vec<(usize, String, String)>,
    children: Vec<Driven>,
    rams: Vec<Driven>,
}

/// What the text calls the module's children, in their order.
pub fn instances(module: &Module) -> Vec<String> {
    named(module).0.children.into_iter().map(|driven| driven.instance).collect()
}

/// The parts' names, and those that are still free.
fn named(module: &Module) -> (Named, Names) {
    let mut names = reserved();
    let inputs = signals(&module.inputs.leaves, "_i", &mut names);
    let outputs: Vec<Leaf> = module.outputs.iter().flat_map(|s| s.leaves.clone()).collect();
    let outputs = signals(&outputs, "_o", &mut names);

    let q = (0..module.registers.len())
        .filter(|k| module.owner(*k).is_none() && !module.is_constant(*k))
        .map(|k| {
            let path = &module.registers[k].path;
            (k, names.unique(&format!("{path}_q")), names.unique(&format!("{path}_d")))
        })
        .collect();
    let children: Vec<Driven> = module
        .instances
        .iter()
        .map(|i| {
            let path = identifier(&i.path);
            let instance = names.unique(&format!("u_{path}"));
            let outputs = ports(&i.module).1.into_iter().map(|port| {
                let stem = port.name.strip_suffix("_o").unwrap_or(&port.name);
                Signal { name: names.unique(&format!("{path}_{stem}")), width: port.width }
            });
            Driven { outputs: outputs.collect(), instance }
        })
        .collect();
    let rams: Vec<Driven> = module
        .rams
        .iter()
        .map(|ram| {
            let path = path_or(&ram.path, "memory");
            let instance = names.unique(&format!("u_{path}"));
            let valid = Signal { name: names.unique(&format!("{path}_valid")), width: 1 };
            let data = Signal {
                name: names.unique(&format!("{path}_data")),
                width: ram.info.bits_per_word,
            };
            Driven { instance, outputs: vec![valid, data] }
        })
        .collect();
    (Named { inputs, outputs, q, children, rams }, names)
}

/// The text from `module` to `endmodule`; `child` names the module of instance `k`.
pub fn text(module: &Module, name: &str, child: impl Fn(usize) -> String) -> String {
    let (Named { inputs, outputs, q, children, rams }, mut names) = named(module);
    let register = |k: usize| &module.registers[k];
    let own: Vec<usize> = q.iter().map(|(k, ..)| *k).collect();
    let needs = needs(module, &own);
    let leaf = |op: Op| match op {
        Op::Input(k) => Some((inputs[k].name.clone(), 0, true)),
        Op::Register(k) => match q.iter().find(|(own, ..)| *own == k) {
            Some((_, name, _)) => Some((name.clone(), 0, true)),
            None => {
                let r = register(k);
                Some((number(r.reset, r.width), 0, true))
            }
        },
        Op::Output { instance, output } => {
            Some((children[instance].outputs[output].name.clone(), 0, true))
        }
        Op::ReadValid(ram) => Some((rams[ram].outputs[0].name.clone(), 0, true)),
        Op::ReadData { ram, field } => {
            let leaves = &module.rams[ram].word.leaves;
            let low = leaves[..field].iter().map(|leaf| leaf.width).sum();
            Some((rams[ram].outputs[1].name.clone(), low, leaves.len() == 1))
        }
        _ => None,
    };
    // A register's next value is called after it, and what goes out after its port.
    let mut fixed = HashMap::new();
    for (k, _, d) in &q {
        let Register { next, width, .. } = register(*k);
        if module.graph.drivers[next.0 as usize].width == *width {
            fixed.entry(*next).or_insert_with(|| d.clone());
        }
    }
    let mut hints = module.graph.hints.clone();
    for (port, node) in outputs.iter().zip(&module.driven) {
        let stem = port.name.strip_suffix("_o").unwrap_or(&port.name);
        hints.entry(*node).or_insert_with(|| stem.to_string());
    }
    for (instance, driven) in module.instances.iter().zip(&children) {
        for (port, node) in ports(&instance.module).0.iter().zip(&instance.inputs) {
            let path = driven.instance.strip_prefix("u_").unwrap_or(&driven.instance);
            let hint = format!("{path}_{}", port.name.strip_suffix("_i").unwrap_or(&port.name));
            hints.entry(*node).or_insert(hint);
        }
    }
    for (n, driver) in module.graph.drivers.iter().enumerate() {
        if let Some(hint) = comparison(module, driver.op, &leaf) {
            hints.entry(Node(n as u32)).or_insert(hint);
        }
    }
    let mut e = Expressions::new(module, &needs, &mut names, &fixed, &hints, leaf);

    // Bodies that use the expressions come first: they tell which constants are needed.
    let mut body = String::new();
    for (k, driven) in children.iter().enumerate() {
        body += &child_instance(module, k, driven, &child(k), &e);
    }
    for (ram, driven) in module.rams.iter().zip(&rams) {
        body += &ram_instance(ram, driven, &e);
    }
    for (k, _, d) in &q {
        let r = register(*k);
        let next = e.at(r.next, r.width);
        if next != *d {
            body += &format!("  wire {}{d} ={};\n", range(r.width), laid_out(&next));
        }
    }
    for (port, node) in outputs.iter().zip(&module.driven) {
        body += &format!("  assign {} ={};\n", port.name, laid_out(&e.at(*node, port.width)));
    }
    if !q.is_empty() {
        body += "\n  always @(posedge clk)\n    if (rst) begin\n";
        for (k, q, _) in &q {
            let r = register(*k);
            let reset = e.state(r.reset, r.width, r.ty);
            let reset = reset.unwrap_or_else(|| number(r.reset, r.width));
            body += &format!("      {q} <= {reset};\n");
        }
        body += "    end else if (en_i) begin\n";
        for (_, q, d) in &q {
            body += &format!("      {q} <= {d};\n");
        }
        body += "    end\n";
    }

    let unused = unused(module, &e, &inputs, &q, &children, &rams);
    e.unused.extend(unused);
    let clocked = !(q.is_empty() && children.is_empty() && rams.is_empty());
    if !clocked {
        e.unused.extend(["clk", "rst", "en_i"].map(String::from));
    }

    let mut text = format!("module {name} (\n  input clk,\n  input rst,\n  input en_i");
    for port in &inputs {
        text += &format!(",\n  input {}{}", range(port.width), port.name);
    }
    for port in &outputs {
        text += &format!(",\n  output {}{}", range(port.width), port.name);
    }
    text += "\n);\n";
    for (_, value, width, name) in &e.constants {
        text += &format!("  localparam {}{name} = {};\n", range(*width), number(*value, *width));
    }
    for (bits, width) in &e.trailing_zeros {
        text += &trailing_zeros(*bits, *width);
    }
    for (k, q, _) in &q {
        text += &format!("  reg {}{q};\n", range(register(*k).width));
    }
    for signal in children.iter().chain(&rams).flat_map(|driven| &driven.outputs) {
        text += &format!("  wire {}{};\n", range(signal.width), signal.name);
    }
    text += &format!("\n{}{body}", e.wires);
    if !e.unused.is_empty() {
        text +=
            "\n  // Signals, or bits of them, that a bundle has and this block has no use for.\n";
        text += &format!("  wire unused = &{{1'b0, {}}};\n", e.unused.join(", "));
    }
    text + "endmodule\n"
}

/// `fsm_is_walk` for `fsm_q == FSM_WALK`.
fn comparison(
    module: &Module,
    op: Op,
    leaf: &impl Fn(Op) -> Option<(String, u32, bool)>,
) -> Option<String> {
    let Op::Binary(Binary::Eq, a, b) = op else { return None };
    let driver = |node: Node| module.graph.drivers[node.0 as usize];
    let (Type::State(states), Op::Const(value)) = (driver(b).ty, driver(b).op) else { return None };
    let (name, ..) = leaf(driver(a).op)?;
    let state = upper(states.variants.get(value as usize)?).to_lowercase();
    Some(format!("{}_is_{state}", name.strip_suffix("_q").unwrap_or(&name)))
}

/// What the module's ports, registers, memories and children need.
fn needs(module: &Module, own: &[usize]) -> Vec<Need> {
    let outputs = module.outputs.iter().flat_map(|shape| &shape.leaves);
    let mut needs: Vec<Need> =
        module.driven.iter().zip(outputs).map(|(node, leaf)| (*node, leaf.width)).collect();
    needs.extend(own.iter().map(|k| (module.registers[*k].next, module.registers[*k].width)));
    for ram in &module.rams {
        let addr_bits = addr_bits(ram);
        let (asked, data) = match &ram.ask {
            Ask::OneReadOneWrite { read, read_addr, write, write_addr, data } => (
                vec![(*read, 1), (*read_addr, addr_bits), (*write, 1), (*write_addr, addr_bits)],
                data,
            ),
            Ask::One { en, write, addr, data } => {
                (vec![(*en, 1), (*write, 1), (*addr, addr_bits)], data)
            }
        };
        needs.extend(asked);
        needs.extend(data.iter().zip(&ram.word.leaves).map(|(node, leaf)| (*node, leaf.width)));
    }
    for instance in &module.instances {
        needs.push((instance.enable, 1));
        let leaves = &instance.module.inputs.leaves;
        needs.extend(instance.inputs.iter().zip(leaves).map(|(node, leaf)| (*node, leaf.width)));
    }
    needs
}

fn addr_bits(ram: &Ram) -> u32 {
    bits_for(ram.info.words - 1)
}

/// `en_i`, or `en_i` and a condition.
fn enabled(node: Node, e: &Expressions) -> String {
    match e.at(node, 1).as_str() {
        "1'd1" => "en_i".to_string(),
        "1'd0" => "1'd0".to_string(),
        cond => format!("en_i && {cond}"),
    }
}

fn pins(list: &[(String, String)]) -> String {
    list.iter().map(|(port, wire)| format!("    .{port}({wire})")).collect::<Vec<_>>().join(",\n")
}

fn child_instance(module: &Module, k: usize, driven: &Driven, of: &str, e: &Expressions) -> String {
    let instance = &module.instances[k];
    let (inputs, outputs) = ports(&instance.module);
    let mut list = vec![
        ("clk".to_string(), "clk".to_string()),
        ("rst".to_string(), "rst".to_string()),
        ("en_i".to_string(), enabled(instance.enable, e)),
    ];
    for (k, port) in inputs.iter().enumerate() {
        let wire = match instance.inputs.get(k) {
            Some(node) => bare(e.at(*node, port.width)),
            None => number(0, port.width),
        };
        list.push((port.name.clone(), wire));
    }
    for (port, wire) in outputs.iter().zip(&driven.outputs) {
        list.push((port.name.clone(), wire.name.clone()));
    }
    format!("  {of} {} (\n{}\n  );\n", driven.instance, pins(&list))
}

fn ram_instance(ram: &Ram, driven: &Driven, e: &Expressions) -> String {
    let addr_bits = addr_bits(ram);
    let info = &ram.info;
    let word = |data: &[Node]| {
        let fields = data.iter().zip(&ram.word.leaves).rev();
        let fields: Vec<String> = fields.map(|(n, leaf)| bare(e.at(*n, leaf.width))).collect();
        match fields.as_slice() {
            [one] => one.clone(),
            all => format!("{{{}}}", all.join(", ")),
        }
    };
    let addr = |node: &Node| bare(e.at(*node, addr_bits));
    let mut parameters = format!(
        ".WORDS({}), .BITS({}), .ADDR_BITS({addr_bits}), .LATENCY({})",
        info.words, info.bits_per_word, info.latency
    );
    let (of, mut list) = match &ram.ask {
        Ask::OneReadOneWrite { read, read_addr, write, write_addr, data } => {
            let first = u32::from(info.read_during_write == ReadDuringWrite::New);
            parameters += &format!(", .WRITE_FIRST({first})");
            let list = vec![
                ("read_en_i", enabled(*read, e)),
                ("read_addr_i", addr(read_addr)),
                ("write_en_i", enabled(*write, e)),
                ("write_addr_i", addr(write_addr)),
                ("write_data_i", word(data)),
            ];
            ("ram_1r1w", list)
        }
        Ask::One { en, write, addr: at, data } => {
            let list = vec![
                ("en_i", enabled(*en, e)),
                ("write_i", bare(e.at(*write, 1))),
                ("addr_i", addr(at)),
                ("data_i", word(data)),
            ];
            ("ram_1rw", list)
        }
    };
    list.insert(0, ("rst", "rst".to_string()));
    list.insert(0, ("clk", "clk".to_string()));
    list.push(("valid_o", driven.outputs[0].name.clone()));
    list.push(("data_o", driven.outputs[1].name.clone()));
    let list: Vec<(String, String)> = list.into_iter().map(|(p, w)| (p.to_string(), w)).collect();
    format!("  {of} #({parameters}) {} (\n{}\n  );\n", driven.instance, pins(&list))
}

/// Signals of which something is not used.
fn unused(
    module: &Module,
    e: &Expressions,
    inputs: &[Signal],
    q: &[(usize, String, String)],
    children: &[Driven],
    rams: &[Driven],
) -> Vec<String> {
    let mut used = std::collections::HashMap::new();
    for (n, driver) in module.graph.drivers.iter().enumerate() {
        used.insert(driver.op, e.used(Node(n as u32)));
    }
    let all = |op: Op, width: u32| {
        let bits = used.get(&op).copied().unwrap_or(0);
        bits == pellucid_sim::netlist::node::mask(width)
    };
    let mut names = vec![];
    for (k, port) in inputs.iter().enumerate() {
        if !all(Op::Input(k), port.width) {
            names.push(port.name.clone());
        }
    }
    for (k, name, _) in q {
        if !all(Op::Register(*k), module.registers[*k].width) {
            names.push(name.clone());
        }
    }
    for (instance, driven) in children.iter().enumerate() {
        for (output, signal) in driven.outputs.iter().enumerate() {
            if !all(Op::Output { instance, output }, signal.width) {
                names.push(signal.name.clone());
            }
        }
    }
    for (k, driven) in rams.iter().enumerate() {
        if !all(Op::ReadValid(k), 1) {
            names.push(driven.outputs[0].name.clone());
        }
        let leaves = module.rams[k].word.leaves.iter().enumerate();
        let mut fields = leaves.map(|(field, leaf)| (Op::ReadData { ram: k, field }, leaf.width));
        if !fields.all(|(op, width)| all(op, width)) {
            names.push(driven.outputs[1].name.clone());
        }
    }
    names
}

fn trailing_zeros(bits: u32, width: u32) -> String {
    format!(
        "
  // How many zeros stand below the lowest one.
  function {range}trailing_zeros_{bits};
    input [{top}:0] word;
    reg [{width}:0] k;
    begin
      trailing_zeros_{bits} = {all};
      for (k = {more}; k > {zero}; k = k - {one})
        if (word[k[{index}:0] - {less}]) trailing_zeros_{bits} = k[{last}:0] - {low};
    end
  endfunction

",
        range = range(width),
        top = bits - 1,
        all = number(bits.into(), width),
        more = number(bits.into(), width + 1),
        zero = number(0, width + 1),
        one = number(1, width + 1),
        index = bits_for(u64::from(bits - 1)) - 1,
        less = number(1, bits_for(u64::from(bits - 1))),
        last = width - 1,
        low = number(1, width),
    )
}
