//! From a block to its module: the twins of its functions are called on wires instead of numbers.
//!
//! Each call of a child's `moore` and `next` becomes an instance of the child's module. A call under a
//! condition becomes an instance whose clock enable is that condition.

use super::module::{Ask, Instance, Module, Ram, Register, within};
use super::node::{Graph, Node, Op, Type};
use super::shape::Shape;
use super::value::Value;
use crate::memory::Memory;
use crate::{Block, Declare, Ports, StorageInfo};
use std::cell::RefCell;
use std::rc::Rc;

/// A block that can be turned into a netlist. `#[rtl]` implements it beside [`Block`], from the same
/// source.
pub trait Netlist: Block {
    /// Its module's name.
    fn name(cfg: &Self::Config) -> &'static str;
    /// Where its source stands: the path of its Rust module.
    fn source(cfg: &Self::Config) -> &'static str;
    /// Declares its registers.
    fn declare_state(cfg: &Self::Config, to: &mut dyn Declare);
    /// Declares its input ports.
    fn declare_in(cfg: &Self::Config, to: &mut dyn Declare);
    /// Declares the output ports that depend on registers alone.
    fn declare_moore(cfg: &Self::Config, to: &mut dyn Declare);
    /// Declares the other output ports.
    fn declare_out(cfg: &Self::Config, to: &mut dyn Declare);
    /// Its registers, its inputs and outputs as numbers, and back: for the comparison of the native
    /// source with the netlist.
    fn numbers() -> Numbers<Self>;
    /// The twin of [`Block::moore`].
    fn moore_netlist(cfg: &Self::Config, q: Value, m: Value) -> Value;
    /// The twin of [`Block::next`]: the outputs, the registers and the memories after it.
    fn next_netlist(cfg: &Self::Config, q: Value, d: Value, m: Value, i: Value) -> [Value; 3];
}

/// How a block's bundles become numbers, in the order of their declaration, and how numbers become
/// bundles.
pub struct Numbers<B: Block + ?Sized> {
    /// Registers to numbers.
    pub state: fn(&B::Config, &B::State, &mut Vec<u64>),
    /// Inputs to numbers.
    pub input: fn(&B::Config, &B::In, &mut Vec<u64>),
    /// Moore outputs to numbers.
    pub moore: fn(&B::Config, &B::Moore, &mut Vec<u64>),
    /// Other outputs to numbers.
    pub out: fn(&B::Config, &B::Out, &mut Vec<u64>),
    /// Numbers to registers.
    pub to_state: fn(&B::Config, &mut dyn Iterator<Item = u64>) -> B::State,
    /// Numbers to inputs.
    pub to_in: fn(&B::Config, &mut dyn Iterator<Item = u64>) -> B::In,
}

/// A block of any type, of one configuration: what [`build`] needs of it.
trait Twins {
    fn name(&self) -> &'static str;
    fn source(&self) -> &'static str;
    fn storages(&self) -> Vec<Storage>;
    fn state(&self) -> Shape;
    fn inputs(&self) -> Shape;
    fn moore_outputs(&self) -> Shape;
    fn outputs(&self) -> Shape;
    /// Its registers after reset.
    fn reset(&self) -> Vec<u64>;
    fn moore(&self, q: Value, m: Value) -> Value;
    fn next(&self, q: Value, m: Value, i: Value) -> [Value; 3];
}

struct Of<'a, B: Netlist>(&'a B::Config);

impl<B: Netlist> Twins for Of<'_, B> {
    fn name(&self) -> &'static str {
        B::name(self.0)
    }
    fn source(&self) -> &'static str {
        B::source(self.0)
    }
    fn storages(&self) -> Vec<Storage> {
        let mut storages = vec![];
        B::memories(self.0).visit("", &mut |path, storage| {
            let word = Shape::of(|to| storage.word("", to));
            storages.push(Storage { path: path.to_string(), info: storage.info(), word });
        });
        storages
    }
    fn state(&self) -> Shape {
        Shape::of(|to| B::declare_state(self.0, to))
    }
    fn inputs(&self) -> Shape {
        Shape::of(|to| B::declare_in(self.0, to))
    }
    fn moore_outputs(&self) -> Shape {
        Shape::of(|to| B::declare_moore(self.0, to))
    }
    fn outputs(&self) -> Shape {
        Shape::of(|to| B::declare_out(self.0, to))
    }
    fn reset(&self) -> Vec<u64> {
        let mut reset = vec![];
        (B::numbers().state)(self.0, &B::reset(self.0), &mut reset);
        reset
    }
    fn moore(&self, q: Value, m: Value) -> Value {
        B::moore_netlist(self.0, q, m)
    }
    fn next(&self, q: Value, m: Value, i: Value) -> [Value; 3] {
        B::next_netlist(self.0, q, q, m, i)
    }
}

/// A memory of the block that is being elaborated, used or not.
struct Storage {
    path: String,
    info: StorageInfo,
    word: Shape,
}

#[derive(Default)]
struct Builder {
    storages: Vec<Storage>,
    /// Which of them the block itself uses.
    used: Vec<usize>,
    instances: Vec<Instance>,
}

thread_local! {
    static BUILDERS: RefCell<Vec<Builder>> = const { RefCell::new(vec![]) };
}

fn with<R>(f: impl FnOnce(&mut Builder) -> R) -> R {
    BUILDERS.with_borrow_mut(|builders| f(builders.last_mut().expect("a block is elaborated")))
}

/// The memory whose ports are `value`, if they are a memory's.
fn storage_of(value: Value) -> Option<usize> {
    let place = value.place()?;
    with(|b| b.storages.iter().position(|s| *s.path == *place))
}

/// What ports the memory has whose ports are `value`, if they are a memory's.
pub(super) fn ports_of(value: Value) -> Option<Ports> {
    storage_of(value).map(|k| with(|b| b.storages[k].info.ports))
}

/// What the memory shows whose ports are `value`.
pub(super) fn shown_by(value: Value) -> Value {
    let storage = storage_of(value).expect("a memory is asked for what it shows");
    let (ram, word, words) = with(|b| {
        let ram = b.used.iter().position(|k| *k == storage).unwrap_or_else(|| {
            b.used.push(storage);
            b.used.len() - 1
        });
        let Storage { word, info, .. } = &b.storages[storage];
        (ram, word.clone(), info.words)
    });
    if words == 0 {
        return Value::Zero;
    }
    let data = word.build(false, &mut |field| {
        let leaf = &word.leaves[field];
        Node::driven(Op::ReadData { ram, field }, leaf.width, Type::of(leaf.kind))
    });
    let valid = Node::driven(Op::ReadValid(ram), 1, Type::Flag);
    Value::record(&[("valid", Value::Wire(valid)), ("data", data)])
}

/// The wires of a value, cut or extended to the signals of a shape by whoever uses them.
fn nodes(shape: &Shape, value: Value) -> Vec<Node> {
    shape.wires(value).into_iter().map(Value::wire).collect()
}

/// Memory ports at the start of a cycle: nothing is asked.
fn idle_ports(storages: &[Storage]) -> Value {
    let flag = || Value::Wire(Node::flag(false));
    let mut root = Value::at_root();
    for Storage { path, info, .. } in storages {
        let read = || Value::record(&[("en", flag()), ("addr", Value::Unused)]);
        let write = || {
            let unused = [("addr", Value::Unused), ("data", Value::Unused)];
            Value::record(&[("en", flag()), ("write", flag())]).updated(&unused)
        };
        let ports = match info.ports {
            Ports::OneReadOneWrite => Value::record(&[("read", read()), ("write", write())]),
            Ports::One => Value::record(&[("port", write())]),
        };
        root.insert(path, ports);
    }
    root
}

/// Elaborates a block.
///
/// # Panics
/// If the block breaks a rule of the exportable subset that the compiler cannot see: it reads a
/// register of a child, or clocks a child twice.
pub fn elaborate<B: Netlist>(cfg: &B::Config) -> Module {
    build(&Of::<B>(cfg))
}

fn build(block: &dyn Twins) -> Module {
    Graph::begin();
    let builder = Builder { storages: block.storages(), ..Builder::default() };
    let ports = idle_ports(&builder.storages);
    BUILDERS.with_borrow_mut(|builders| builders.push(builder));

    let (state, inputs) = (block.state(), block.inputs());
    let outputs = [block.moore_outputs(), block.outputs()];
    let register = |k: usize| {
        let leaf = &state.leaves[k];
        Node::driven(Op::Register(k), leaf.width, Type::of(leaf.kind))
    };
    let q = state.build(true, &mut |k| register(k));
    let i = inputs.build(false, &mut |k| {
        let leaf = &inputs.leaves[k];
        Node::driven(Op::Input(k), leaf.width, Type::of(leaf.kind))
    });
    let moore = block.moore(q, ports);
    let [out, d, m] = block.next(q, ports, i);
    let mut driven = nodes(&outputs[0], moore);
    driven.extend(nodes(&outputs[1], out));

    let (reset, next) = (block.reset(), state.wires(d));
    let registers: Vec<Register> = state
        .leaves
        .iter()
        .enumerate()
        .map(|(k, leaf)| Register {
            path: leaf.path.clone(),
            width: leaf.width,
            ty: Type::of(leaf.kind),
            reset: reset[k],
            next: next[k].wire(),
        })
        .collect();

    let Builder { storages, mut used, mut instances } = BUILDERS
        .with_borrow_mut(|builders| builders.pop())
        .unwrap_or_else(|| unreachable!("it was pushed above"));
    for instance in &mut instances {
        let after = [(&instance.state, d), (&instance.memory, m)];
        let clocked =
            after.into_iter().find_map(|(place, value)| match value.placed(place.as_deref()?) {
                Value::Clocked(enable) => Some(enable),
                _ => None,
            });
        instance.enable = clocked.unwrap_or_else(|| Node::flag(false));
    }
    let owned = |path: &str| {
        instances.iter().any(|i| i.memory.as_deref().is_some_and(|place| within(path, place)))
    };
    used.extend((0..storages.len()).filter(|k| !owned(&storages[*k].path)));
    let mut seen = std::collections::HashSet::new();
    used.retain(|k| seen.insert(*k) && storages[*k].info.words > 0);
    let rams = used
        .iter()
        .map(|k| {
            let Storage { path, info, word } = &storages[*k];
            let ports = m.placed(path);
            Ram {
                path: path.clone(),
                info: *info,
                word: word.clone(),
                ask: ask(ports, *info, word),
            }
        })
        .collect();

    let graph = Graph::finish();
    let module = Module {
        name: block.name(),
        source: block.source(),
        graph,
        inputs,
        outputs,
        driven,
        registers,
        rams,
        instances,
    };
    module.check_reads();
    module
}

fn ask(ports: Value, info: StorageInfo, word: &Shape) -> Ask {
    let wire = |port: Value, name: &str| port.field(name).wire();
    let data = |port: Value| nodes(word, port.field("data"));
    match info.ports {
        Ports::OneReadOneWrite => {
            let (read, write) = (ports.field("read"), ports.field("write"));
            Ask::OneReadOneWrite {
                read: wire(read, "en"),
                read_addr: wire(read, "addr"),
                write: wire(write, "en"),
                write_addr: wire(write, "addr"),
                data: data(write),
            }
        }
        Ports::One => {
            let port = ports.field("port");
            Ask::One {
                en: wire(port, "en"),
                write: wire(port, "write"),
                addr: wire(port, "addr"),
                data: data(port),
            }
        }
    }
}

/// The instance whose registers are `q` and whose memories are `m`, made if it is not there.
fn instance(block: &dyn Twins, q: Value, m: Value) -> usize {
    let (state, memory) = (q.place(), m.place());
    let place = state.clone().or(memory.clone()).unwrap_or_else(|| {
        panic!("`{}` has neither registers nor memories of its own in its parent", block.name())
    });
    let found = with(|b| {
        b.instances.iter().position(|i| i.state.as_ref().or(i.memory.as_ref()) == Some(&place))
    });
    if let Some(k) = found {
        return k;
    }
    let module = Rc::new(build(block));
    with(|b| {
        b.instances.push(Instance {
            path: place.to_string(),
            module,
            enable: Node(0),
            inputs: vec![],
            state,
            memory,
            called: false,
        });
        b.instances.len() - 1
    })
}

/// Elaborates a block that stands alone, such as a whole machine: it has the outputs of [`Block::Out`], while
/// those of [`Block::moore`] are for a parent, which needs them before it knows what to put in.
///
/// # Panics
/// As [`elaborate`].
pub fn elaborate_alone<B: Netlist>(cfg: &B::Config) -> Module {
    let mut module = elaborate::<B>(cfg);
    let for_parent = std::mem::replace(&mut module.outputs[0], Shape::of(|_| {}));
    module.driven.drain(..for_parent.leaves.len());
    module
}

/// The outputs of instance `k`: those of the registers (`group` 0) or the others (1).
fn output_value(module: &Module, k: usize, group: usize) -> Value {
    let before = if group == 0 { 0 } else { module.outputs[0].leaves.len() };
    let shape = &module.outputs[group];
    shape.build(false, &mut |j| {
        let leaf = &shape.leaves[j];
        let op = Op::Output { instance: k, output: before + j };
        Node::driven(op, leaf.width, Type::of(leaf.kind))
    })
}

/// The twin of a parent's call of [`Block::moore`].
pub fn moore<B: Netlist>(cfg: &B::Config, q: Value, m: Value) -> Value {
    moore_of(&Of::<B>(cfg), q, m)
}

fn moore_of(child: &dyn Twins, q: Value, m: Value) -> Value {
    let k = instance(child, q, m);
    let module = with(|b| b.instances[k].module.clone());
    output_value(&module, k, 0)
}

/// The twin of a parent's call of [`Block::next`]: the outputs, and `d` and `m` after it.
///
/// # Panics
/// If the child was clocked already.
pub fn next<B: Netlist>(cfg: &B::Config, q: Value, m: Value, i: Value) -> [Value; 3] {
    next_of(&Of::<B>(cfg), q, m, i)
}

fn next_of(child: &dyn Twins, q: Value, m: Value, i: Value) -> [Value; 3] {
    let k = instance(child, q, m);
    let module = with(|b| {
        let instance = &mut b.instances[k];
        assert!(!instance.called, "`{}` is clocked twice in one cycle", instance.path);
        instance.called = true;
        instance.module.clone()
    });
    let inputs = nodes(&module.inputs, i);
    with(|b| b.instances[k].inputs = inputs);
    let clocked = Value::Clocked(Node::flag(true));
    [output_value(&module, k, 1), clocked, clocked]
}
