//! A block as a netlist: its ports, registers, memories and children, and the wires between them.

use super::node::{Graph, Node, Op, Type};
use super::shape::Shape;
use crate::StorageInfo;
use std::rc::Rc;

/// The netlist of a block.
#[derive(Debug)]
pub struct Module {
    /// The block's name.
    pub name: &'static str,
    /// Where its source stands: the path of its Rust module.
    pub source: &'static str,
    /// Its wires.
    pub graph: Graph,
    /// Its input ports.
    pub inputs: Shape,
    /// Its output ports that depend on registers alone, then the others.
    pub outputs: [Shape; 2],
    /// What drives the outputs, in the order of `outputs`.
    pub driven: Vec<Node>,
    /// Its registers.
    pub registers: Vec<Register>,
    /// Its memories.
    pub rams: Vec<Ram>,
    /// Its children.
    pub instances: Vec<Instance>,
}

/// A register.
#[derive(Clone, Debug)]
pub struct Register {
    /// Its path in the block's state.
    pub path: String,
    /// How many bits.
    pub width: u32,
    /// What they mean.
    pub ty: Type,
    /// Its value after reset.
    pub reset: u64,
    /// Its next value. Its own node: it never changes.
    pub next: Node,
}

/// A memory.
#[derive(Debug)]
pub struct Ram {
    /// Its path in the block's memories; empty if it is the only one.
    pub path: String,
    /// Its size.
    pub info: StorageInfo,
    /// The fields of its word.
    pub word: Shape,
    /// What it is asked.
    pub ask: Ask,
}

/// What a memory is asked in a cycle.
#[derive(Debug)]
pub enum Ask {
    /// On one read and one write port.
    OneReadOneWrite {
        /// A read is asked for.
        read: Node,
        /// Of this word.
        read_addr: Node,
        /// A write is asked for.
        write: Node,
        /// Of this word.
        write_addr: Node,
        /// Of this data, field by field.
        data: Vec<Node>,
    },
    /// On its only port.
    One {
        /// An access is asked for.
        en: Node,
        /// It writes.
        write: Node,
        /// Of this word.
        addr: Node,
        /// Of this data, field by field.
        data: Vec<Node>,
    },
}

/// A child.
#[derive(Debug)]
pub struct Instance {
    /// Where its registers or, if it has none, its memories lie in its parent's.
    pub path: String,
    /// Its module.
    pub module: Rc<Module>,
    /// It is clocked where this is 1.
    pub enable: Node,
    /// What drives its inputs.
    pub inputs: Vec<Node>,
    /// Where its registers lie in its parent's, if it has any.
    pub(super) state: Option<Rc<str>>,
    /// Where its memories lie.
    pub(super) memory: Option<Rc<str>>,
    /// It was clocked.
    pub(super) called: bool,
}

/// Whether `path` is `place` or lies in it.
pub(super) fn within(path: &str, place: &str) -> bool {
    place.is_empty()
        || path.strip_prefix(place).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
}

impl Module {
    /// Every node that something outside the graph reads, children included.
    pub fn roots(&self) -> Vec<Node> {
        let mut roots = self.driven.clone();
        for (k, register) in self.registers.iter().enumerate() {
            if !self.is_constant(k) && self.owner(k).is_none() {
                roots.push(register.next);
            }
        }
        for ram in &self.rams {
            match &ram.ask {
                Ask::OneReadOneWrite { read, read_addr, write, write_addr, data } => {
                    roots.extend([*read, *read_addr, *write, *write_addr]);
                    roots.extend(data);
                }
                Ask::One { en, write, addr, data } => {
                    roots.extend([*en, *write, *addr]);
                    roots.extend(data);
                }
            }
        }
        for instance in &self.instances {
            roots.push(instance.enable);
            roots.extend(&instance.inputs);
        }
        roots
    }

    /// Which nodes have an effect.
    pub fn live(&self) -> Vec<bool> {
        let mut live = vec![false; self.graph.drivers.len()];
        let mut stack = self.roots();
        while let Some(Node(n)) = stack.pop() {
            if !std::mem::replace(&mut live[n as usize], true) {
                self.graph.drivers[n as usize].op.operands(|operand| stack.push(operand));
            }
        }
        live
    }

    /// Whether register `k` never changes.
    pub fn is_constant(&self, k: usize) -> bool {
        self.graph.drivers[self.registers[k].next.0 as usize].op == Op::Register(k)
    }

    /// The child that register `k` belongs to, if to one.
    pub fn owner(&self, k: usize) -> Option<&Instance> {
        let path = &self.registers[k].path;
        self.instances.iter().find(|i| i.state.as_deref().is_some_and(|place| within(path, place)))
    }

    /// Holds it to the rule that no block reads a register of its child.
    pub(super) fn check_reads(&self) {
        let live = self.live();
        for (driver, _) in self.graph.drivers.iter().zip(live).filter(|(_, live)| *live) {
            if let Op::Register(k) = driver.op
                && let Some(child) = self.owner(k)
            {
                panic!(
                    "`{}` reads the register `{}` of its child `{}`: the child must give it as an \
                     output",
                    self.name, self.registers[k].path, child.path
                );
            }
        }
    }
}
