//! Runs a module: its children are dissolved into one list of operations, which is carried out once a
//! cycle.

use super::module::{Ask, Instance, Module};
use super::node::{Binary, Node, Op, Type, compute, mask};
use crate::{ReadDuringWrite, StorageInfo};
use std::collections::{HashMap, VecDeque};

/// An operation on earlier ones, by number.
#[derive(Clone, Copy, Debug)]
pub(super) enum Flat {
    Const(u64),
    Input(usize),
    Register(usize),
    ReadValid(usize),
    ReadData(usize, usize),
    Binary(Binary, usize, usize),
    Not(usize),
    Mux(usize, usize, usize),
    Low(usize),
    TrailingZeros(usize, u32),
}

pub(super) struct Register {
    value: u64,
    reset: u64,
    width: u32,
    pub next: usize,
    pub enable: usize,
}

/// What a memory is asked, by number of operation.
pub(super) struct Port {
    pub read: usize,
    pub read_addr: usize,
    pub write: usize,
    pub write_addr: usize,
    pub data: Vec<usize>,
}

pub(super) struct Ram {
    info: StorageInfo,
    pub widths: Vec<u32>,
    words: HashMap<u64, Vec<u64>>,
    pub port: Port,
    /// What the last read gave.
    held: Vec<u64>,
    /// What is under way: `latency` entries, the oldest is shown.
    line: VecDeque<(bool, Vec<u64>)>,
}

/// A module under the clock.
pub struct Evaluator {
    ops: Vec<(Flat, u32)>,
    values: Vec<u64>,
    registers: Vec<Register>,
    rams: Vec<Ram>,
    /// The registers of the module and its children in the order of the block's declaration.
    order: Vec<usize>,
    outputs: Vec<usize>,
}

/// A module on its way to being dissolved.
pub(super) struct Place<'a> {
    pub module: &'a Module,
    pub path: String,
    parent: Option<(usize, &'a Instance)>,
    children: Vec<usize>,
    done: Vec<Option<usize>>,
    registers: usize,
    rams: usize,
}

/// A module whose children are being dissolved.
pub(super) struct Dissolve<'a> {
    pub places: Vec<Place<'a>>,
    pub ops: Vec<(Flat, u32)>,
    registers: usize,
    rams: usize,
}

impl<'a> Dissolve<'a> {
    /// What drives the outputs of a module, and what these depend on in the same cycle.
    pub fn of(module: &'a Module) -> (Dissolve<'a>, Vec<usize>) {
        let mut dissolve = Dissolve { places: vec![], ops: vec![], registers: 0, rams: 0 };
        let top = dissolve.enter(module, String::new(), None);
        let outputs = (0..module.driven.len()).map(|k| dissolve.output(top, k)).collect();
        (dissolve, outputs)
    }

    fn enter(
        &mut self,
        module: &'a Module,
        path: String,
        parent: Option<(usize, &'a Instance)>,
    ) -> usize {
        let at = self.places.len();
        let nodes = module.graph.drivers.len();
        self.places.push(Place {
            module,
            path: path.clone(),
            parent,
            children: vec![],
            done: vec![None; nodes],
            registers: self.registers,
            rams: self.rams,
        });
        self.registers += module.registers.len();
        self.rams += module.rams.len();
        for instance in &module.instances {
            let inside = crate::join(&path, &instance.path);
            let child = self.enter(&instance.module, inside, Some((at, instance)));
            self.places[at].children.push(child);
        }
        at
    }

    fn push(&mut self, op: Flat, width: u32) -> usize {
        self.ops.push((op, width));
        self.ops.len() - 1
    }

    /// Output `output` of the module at `at`.
    fn output(&mut self, at: usize, output: usize) -> usize {
        let module = self.places[at].module;
        let leaves = module.outputs.iter().flat_map(|shape| &shape.leaves);
        let width = leaves.map(|leaf| leaf.width).nth(output).unwrap_or(1);
        let driven = self.node(at, module.driven[output]);
        self.push(Flat::Low(driven), width)
    }

    fn enable(&mut self, at: usize) -> usize {
        match self.places[at].parent {
            None => self.push(Flat::Const(1), 1),
            Some((parent, instance)) => {
                let outer = self.enable(parent);
                let own = self.node(parent, instance.enable);
                self.push(Flat::Binary(Binary::And, outer, own), 1)
            }
        }
    }

    fn node(&mut self, at: usize, node: Node) -> usize {
        let n = node.0 as usize;
        if let Some(done) = self.places[at].done[n] {
            return done;
        }
        let place = &self.places[at];
        let (registers, rams) = (place.registers, place.rams);
        let driver = place.module.graph.drivers[n];
        let op = match driver.op {
            Op::Const(value) => Flat::Const(value),
            Op::Input(k) => match place.parent {
                None => Flat::Input(k),
                Some((parent, instance)) => match instance.inputs.get(k) {
                    Some(input) => Flat::Low(self.node(parent, *input)),
                    None => Flat::Const(0),
                },
            },
            Op::Register(k) => Flat::Register(registers + k),
            Op::Output { instance, output } => {
                let child = place.children[instance];
                Flat::Low(self.output(child, output))
            }
            Op::ReadValid(ram) => Flat::ReadValid(rams + ram),
            Op::ReadData { ram, field } => Flat::ReadData(rams + ram, field),
            Op::Binary(op, a, b) => Flat::Binary(op, self.node(at, a), self.node(at, b)),
            Op::Not(a) => Flat::Not(self.node(at, a)),
            Op::Mux(c, a, b) => Flat::Mux(self.node(at, c), self.node(at, a), self.node(at, b)),
            Op::Low(a) => Flat::Low(self.node(at, a)),
            Op::TrailingZeros(a) => {
                let all = match self.places[at].module.graph.drivers[a.0 as usize].ty {
                    Type::Integer(bits) => bits,
                    _ => 64,
                };
                Flat::TrailingZeros(self.node(at, a), all)
            }
        };
        let done = self.push(op, driver.width);
        self.places[at].done[n] = Some(done);
        done
    }

    pub fn registers_of(&mut self, at: usize) -> Vec<Register> {
        let module = self.places[at].module;
        let enable = self.enable(at);
        let mut registers = vec![];
        for r in &module.registers {
            let next = self.node(at, r.next);
            registers.push(Register {
                value: r.reset,
                reset: r.reset,
                width: r.width,
                next,
                enable,
            });
        }
        registers
    }

    pub fn rams_of(&mut self, at: usize) -> Vec<Ram> {
        let module = self.places[at].module;
        let enable = self.enable(at);
        let mut rams = vec![];
        for ram in &module.rams {
            let and = |d: &mut Self, a: usize, b: Node| {
                let b = d.node(at, b);
                d.push(Flat::Binary(Binary::And, a, b), 1)
            };
            let port = match &ram.ask {
                Ask::OneReadOneWrite { read, read_addr, write, write_addr, data } => Port {
                    read: and(self, enable, *read),
                    read_addr: self.node(at, *read_addr),
                    write: and(self, enable, *write),
                    write_addr: self.node(at, *write_addr),
                    data: data.iter().map(|n| self.node(at, *n)).collect(),
                },
                Ask::One { en, write, addr, data } => {
                    let en = and(self, enable, *en);
                    let write_node = self.node(at, *write);
                    let not = self.push(Flat::Not(write_node), 1);
                    let addr = self.node(at, *addr);
                    Port {
                        read: self.push(Flat::Binary(Binary::And, en, not), 1),
                        read_addr: addr,
                        write: self.push(Flat::Binary(Binary::And, en, write_node), 1),
                        write_addr: addr,
                        data: data.iter().map(|n| self.node(at, *n)).collect(),
                    }
                }
            };
            let widths: Vec<u32> = ram.word.leaves.iter().map(|leaf| leaf.width).collect();
            let zero = vec![0; widths.len()];
            let line =
                std::iter::repeat_n((false, zero.clone()), ram.info.latency as usize).collect();
            let words = HashMap::new();
            rams.push(Ram { info: ram.info, widths, words, port, held: zero, line });
        }
        rams
    }
}

impl Evaluator {
    /// The module at power-up, in reset.
    pub fn new(module: &Module) -> Evaluator {
        let (mut dissolve, outputs) = Dissolve::of(module);
        let (mut registers, mut rams, mut paths) = (vec![], vec![], HashMap::new());
        for at in 0..dissolve.places.len() {
            for (k, r) in dissolve.places[at].module.registers.iter().enumerate() {
                // A child's registers stand in its parent too: the child's own are entered later.
                paths.insert(crate::join(&dissolve.places[at].path, &r.path), registers.len() + k);
            }
            registers.extend(dissolve.registers_of(at));
            rams.extend(dissolve.rams_of(at));
        }
        let order = module.registers.iter().map(|r| paths[&r.path]).collect();
        let values = vec![0; dissolve.ops.len()];
        Evaluator { ops: dissolve.ops, values, registers, rams, order, outputs }
    }

    /// Puts inputs to the module, in the order of their declaration, and gives its outputs.
    pub fn evaluate(&mut self, inputs: &[u64]) -> Vec<u64> {
        for (k, (op, width)) in self.ops.iter().enumerate() {
            let v = &self.values;
            let value = match *op {
                Flat::Const(value) => value,
                Flat::Input(k) => inputs[k],
                Flat::Register(k) => self.registers[k].value,
                Flat::ReadValid(k) => u64::from(self.rams[k].line[0].0),
                Flat::ReadData(k, field) => self.rams[k].line[0].1[field],
                Flat::Binary(op, a, b) => compute(op, v[a], v[b], *width),
                Flat::Not(a) => !v[a],
                Flat::Mux(c, a, b) => v[if v[c] != 0 { a } else { b }],
                Flat::Low(a) => v[a],
                Flat::TrailingZeros(a, all) => u64::from(v[a].trailing_zeros().min(all)),
            };
            self.values[k] = value & mask(*width);
        }
        self.outputs.iter().map(|k| self.values[*k]).collect()
    }

    /// The registers after the coming edge, in the order of the block's declaration.
    pub fn next(&self) -> Vec<u64> {
        self.order.iter().map(|k| self.after(&self.registers[*k])).collect()
    }

    /// The registers now, in the order of the block's declaration.
    pub fn registers(&self) -> Vec<u64> {
        self.order.iter().map(|k| self.registers[*k].value).collect()
    }

    fn after(&self, r: &Register) -> u64 {
        if self.values[r.enable] != 0 { self.values[r.next] & mask(r.width) } else { r.value }
    }

    /// The clock edge, after [`Evaluator::evaluate`].
    pub fn edge(&mut self) {
        let after: Vec<u64> = self.registers.iter().map(|r| self.after(r)).collect();
        for (register, value) in self.registers.iter_mut().zip(after) {
            register.value = value;
        }
        for ram in &mut self.rams {
            ram.edge(&self.values);
        }
    }

    /// Reset: the registers go back; the memories keep what they hold and forget what is under way.
    pub fn reset(&mut self) {
        for register in &mut self.registers {
            register.value = register.reset;
        }
        for ram in &mut self.rams {
            for (valid, _) in &mut ram.line {
                *valid = false;
            }
        }
    }

    /// Sets the registers, in the order of the block's declaration.
    pub fn set(&mut self, registers: &[u64]) {
        for (k, value) in self.order.iter().zip(registers) {
            self.registers[*k].value = *value;
        }
    }
}

impl Ram {
    fn edge(&mut self, values: &[u64]) {
        let Ram { info, widths, words, port, held, line } = self;
        let (read, write) = (values[port.read] != 0, values[port.write] != 0);
        let (read_addr, write_addr) = (values[port.read_addr], values[port.write_addr]);
        let new: Vec<u64> =
            port.data.iter().zip(widths).map(|(k, width)| values[*k] & mask(*width)).collect();
        if write && info.read_during_write != ReadDuringWrite::Old {
            words.insert(write_addr, new.clone());
        }
        if read {
            *held = words.get(&read_addr).cloned().unwrap_or_else(|| vec![0; held.len()]);
        }
        if write {
            words.insert(write_addr, new);
        }
        line.push_back((read, held.clone()));
        line.pop_front();
    }
}
