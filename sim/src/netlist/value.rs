//! Hardware values: what a variable of a next-state function is while a netlist is built from it.
//!
//! A value is a wire or a bundle of values by name or by number. Where two branches meet, a value is
//! chosen field by field ([`Value::choose`]). A bundle lies in the graph of its module and a value is its number there:
//! values are copied without a thought, and the functions that `#[rtl]` makes have nothing to drop.

use super::node::{Graph, Node, Type};
use super::shape::Shape;
use crate::signals::Signals;
use std::rc::Rc;

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    /// All bits 0, whatever the shape: a default.
    Zero,
    /// Without meaning, whatever the shape: the address of a port that is not used.
    Unused,
    /// A wire.
    Wire(Node),
    /// Values by name or by number.
    Bundle(Bundle),
    /// The registers or memories of a child after its `next`: it is clocked where the wire is 1.
    Clocked(Node),
}

/// A bundle of the module that is being elaborated. It never changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bundle(usize);

/// What a bundle holds.
#[derive(Debug)]
pub(super) enum Contents {
    /// Values by name; one that is missing is zero.
    Record(Record),
    /// Values by number: an array or a tuple.
    List(Vec<Value>),
}

/// Values by name.
#[derive(Clone, Debug, Default)]
pub(super) struct Record {
    /// Where it lies among the registers or memories of its block, if it is one of them.
    pub(super) place: Option<Rc<str>>,
    pub(super) fields: Vec<(Rc<str>, Value)>,
}

impl Record {
    fn put(&mut self, name: &str, value: Value) {
        match self.fields.iter_mut().find(|(field, _)| **field == *name) {
            Some((_, place)) => *place = value,
            None => self.fields.push((name.into(), value)),
        }
    }
    pub(super) fn into_value(self) -> Value {
        Value::Bundle(Bundle::of(Contents::Record(self)))
    }
}

impl Bundle {
    fn of(contents: Contents) -> Bundle {
        Graph::with(|graph| {
            graph.bundles.push(Rc::new(contents));
            Bundle(graph.bundles.len() - 1)
        })
    }
    fn contents(self) -> Rc<Contents> {
        Graph::with(|graph| graph.bundles[self.0].clone())
    }
}

/// One step from a value to a part of it.
#[derive(Clone, Copy, Debug)]
pub enum Step {
    /// To a field.
    Field(&'static str),
    /// To an element, whose number may be a wire.
    Element(Value),
}

impl Value {
    /// A bundle of fields.
    pub fn record(fields: &[(&'static str, Value)]) -> Value {
        let fields = fields.iter().map(|(name, value)| ((*name).into(), *value)).collect();
        Record { place: None, fields }.into_value()
    }
    /// `self` with other values for some of its fields.
    pub fn updated(self, fields: &[(&'static str, Value)]) -> Value {
        let mut record = self.to_record();
        for (name, field) in fields {
            record.put(name, *field);
        }
        record.into_value()
    }
    /// An array or a tuple.
    pub fn list(values: &[Value]) -> Value {
        Value::Bundle(Bundle::of(Contents::List(values.to_vec())))
    }
    /// An array of `len` equal elements.
    pub fn repeated(self, len: usize) -> Value {
        Value::list(&vec![self; len])
    }
    /// An integer literal.
    pub fn literal(value: u64) -> Value {
        Value::Wire(Node::number(value, Type::Literal))
    }

    /// A state by its number.
    pub fn state<T: Signals<Config = ()>>(number: u64) -> Value {
        let shape = Shape::of(|to| T::declare(&(), "", to));
        let leaf = &shape.leaves[0];
        Value::Wire(Node::constant(number, leaf.width, Type::of(leaf.kind)))
    }

    /// What it holds, if it is a bundle.
    fn contents(self) -> Option<Rc<Contents>> {
        match self {
            Value::Bundle(bundle) => Some(bundle.contents()),
            _ => None,
        }
    }
    /// Its fields, to be changed; none if it has none.
    fn to_record(self) -> Record {
        match self.contents().as_deref() {
            Some(Contents::Record(record)) => record.clone(),
            _ => Record::default(),
        }
    }

    /// Where it lies among its block's registers or memories.
    pub fn place(self) -> Option<Rc<str>> {
        match self.contents().as_deref() {
            Some(Contents::Record(record)) => record.place.clone(),
            _ => None,
        }
    }

    /// Its only wire.
    ///
    /// # Panics
    /// If it is a bundle.
    pub fn wire(self) -> Node {
        match self {
            Value::Wire(node) | Value::Clocked(node) => node,
            Value::Zero | Value::Unused => Node::number(0, Type::Literal),
            Value::Bundle(bundle) => panic!("one wire is expected here: {:?}", bundle.contents()),
        }
    }

    /// One of its fields.
    pub fn field(self, name: &str) -> Value {
        let contents = match self {
            Value::Zero | Value::Unused => return self,
            other => other.contents(),
        };
        match contents.as_deref() {
            Some(Contents::Record(record)) => {
                let found = record.fields.iter().find(|(field, _)| **field == *name);
                found.map_or(Value::Zero, |(_, value)| *value)
            }
            _ => panic!("`.{name}` of {self:?}: the next state of a child is not to be read"),
        }
    }

    /// One of its elements.
    pub fn at(self, index: Value) -> Value {
        let contents = self.contents();
        let Some(Contents::List(values)) = contents.as_deref() else { return self };
        let index = index.wire();
        if let Some(k) = index.known() {
            return values.get(k as usize).copied().unwrap_or(Value::Zero);
        }
        // The last element needs no test: an index beyond it does not occur.
        let Some((last, others)) = values.split_last() else { return Value::Zero };
        others.iter().enumerate().rev().fold(*last, |rest, (k, value)| {
            let here = index.equals(Node::number(k as u64, Type::Literal));
            Value::choose(here, *value, rest)
        })
    }

    /// Its elements, for a loop over them.
    pub fn elements(self) -> Vec<Value> {
        match self.contents().as_deref() {
            Some(Contents::List(values)) => values.clone(),
            _ => vec![],
        }
    }

    /// A bundle without fields that holds everything else of a block.
    pub(super) fn at_root() -> Value {
        Record { place: Some("".into()), fields: vec![] }.into_value()
    }

    /// The part at `path` among a block's registers or memories.
    pub(super) fn placed(self, path: &str) -> Value {
        let mut names = path.split('.').filter(|name| !name.is_empty());
        names
            .try_fold(self, |value, name| match value {
                Value::Clocked(_) => Err(value),
                _ => Ok(match element(name) {
                    (name, None) => value.field(name),
                    (array, Some(k)) => value.field(array).at(Value::literal(k as u64)),
                }),
            })
            .unwrap_or_else(|clocked| clocked)
    }

    /// Puts `ports` at `path`, and tells them and the bundles on the way where they lie.
    pub(super) fn insert(&mut self, path: &str, ports: Value) {
        let leaf = Record { place: Some(path.into()), fields: ports.to_record().fields };
        let leaf = leaf.into_value();
        let Some((parent, name)) =
            path.rsplit_once('.').or((!path.is_empty()).then_some(("", path)))
        else {
            *self = leaf;
            return;
        };
        let mut bundle = self.placed(parent).to_record();
        match element(name) {
            (name, None) => bundle.put(name, leaf),
            (array, Some(k)) => {
                let before = bundle.fields.iter().find(|(field, _)| **field == *array);
                let mut values = before.map_or(vec![], |(_, value)| value.elements());
                values.resize(values.len().max(k + 1), Value::Zero);
                values[k] = leaf;
                bundle.put(array, Value::list(&values));
            }
        }
        let bundle = bundle.into_value();
        if parent.is_empty() {
            *self = bundle;
        } else {
            self.insert(parent, bundle);
        }
    }

    /// The part that `steps` lead to.
    pub fn part(self, steps: &[Step]) -> Value {
        steps.iter().fold(self, |value, step| match step {
            Step::Field(name) => value.field(name),
            Step::Element(index) => value.at(*index),
        })
    }

    /// Puts another value where `steps` lead to.
    pub fn set(&mut self, steps: &[Step], new: Value) {
        match steps.split_first() {
            None => *self = new,
            Some((Step::Field(name), rest)) => {
                let mut field = self.field(name);
                field.set(rest, new);
                *self = self.updated(&[(name, field)]);
            }
            Some((Step::Element(index), rest)) => {
                let contents = self.contents();
                let Some(Contents::List(values)) = contents.as_deref() else {
                    panic!("{self:?} has no elements")
                };
                let index = index.wire();
                let mut values = values.clone();
                for (value, k) in values.iter_mut().zip(0..) {
                    let here = index.equals(Node::number(k, Type::Literal));
                    if here.known() != Some(0) {
                        let mut changed = *value;
                        changed.set(rest, new);
                        *value = Value::choose(here, changed, *value);
                    }
                }
                *self = Value::list(&values);
            }
        }
    }

    /// `a` where `cond` is 1, else `b`.
    pub fn choose(cond: Node, a: Value, b: Value) -> Value {
        match (a, b) {
            (Value::Clocked(x), Value::Clocked(y)) => Value::Clocked(cond.mux(x, y)),
            (Value::Clocked(x), _) => Value::Clocked(cond.and(x)),
            (_, Value::Clocked(y)) => Value::Clocked(cond.inverted().and(y)),
            (Value::Unused, _) => b,
            (_, Value::Unused) => a,
            (Value::Zero, Value::Zero) => Value::Zero,
            (Value::Wire(x), Value::Wire(y)) => Value::Wire(cond.mux(x, y)),
            (Value::Wire(x), Value::Zero) => {
                Value::Wire(cond.mux(x, Node::constant(0, x.width(), x.ty())))
            }
            (Value::Zero, Value::Wire(y)) => {
                Value::Wire(cond.mux(Node::constant(0, y.width(), y.ty()), y))
            }
            (Value::Bundle(x), Value::Bundle(y)) if x == y => a,
            (Value::Bundle(x), _) | (Value::Zero, Value::Bundle(x)) => match &*x.contents() {
                Contents::Record(x) => x.choose(cond, a, b),
                Contents::List(x) => {
                    let number = |k: usize| Value::literal(k as u64);
                    let chosen = |k| Value::choose(cond, a.at(number(k)), b.at(number(k)));
                    Value::list(&(0..x.len()).map(chosen).collect::<Vec<_>>())
                }
            },
            _ => panic!("two branches give values of two shapes: {a:?} and {b:?}"),
        }
    }

    /// Calls `see` for every wire with its name: `name`, those of a bundle with their own behind it.
    fn each_wire(self, name: &str, see: &mut dyn FnMut(Node, &str)) {
        match self {
            Value::Wire(node) => see(node, name),
            Value::Bundle(bundle) => match &*bundle.contents() {
                Contents::Record(record) => {
                    for (field, value) in &record.fields {
                        value.each_wire(&format!("{name}_{field}"), see);
                    }
                }
                Contents::List(values) => {
                    for (k, value) in values.iter().enumerate() {
                        value.each_wire(&format!("{name}_{k}"), see);
                    }
                }
            },
            Value::Zero | Value::Unused | Value::Clocked(_) => {}
        }
    }

    /// Names its wires after a variable that is bound to it.
    pub fn named(self, name: &str) -> Value {
        self.each_wire(name, &mut |node, name| node.named(name));
        self
    }

    /// Names its wires, if they need a name, after a variable that two branches assign.
    pub fn hinted(self, name: &str) -> Value {
        self.each_wire(name, &mut |node, name| node.hinted(name));
        self
    }
}

impl Record {
    /// [`Value::choose`] of two values of which one has these fields.
    fn choose(&self, cond: Node, a: Value, b: Value) -> Value {
        let mut fields = self.fields.clone();
        // The other may have fields that are still zero here.
        for (name, _) in b.to_record().fields {
            if !fields.iter().any(|(known, _)| *known == name) {
                fields.push((name, Value::Zero));
            }
        }
        for (name, value) in &mut fields {
            *value = Value::choose(cond, a.field(name), b.field(name));
        }
        Record { place: self.place.clone(), fields }.into_value()
    }
}

/// What becomes a hardware value: every type with signals, integers and tuples of them.
pub trait Lift {
    /// As a hardware value; what is known while the netlist is built is constant in it.
    fn lift(self) -> Value;
}

impl Lift for Value {
    fn lift(self) -> Value {
        self
    }
}
impl Lift for () {
    fn lift(self) -> Value {
        Value::Zero
    }
}
impl Lift for bool {
    fn lift(self) -> Value {
        Value::Wire(Node::flag(self))
    }
}
macro_rules! integers {
    ($($t:ty: $bits:expr),*) => { $(
        impl Lift for $t {
            fn lift(self) -> Value {
                Value::Wire(Node::number(self as u64, Type::Integer($bits)))
            }
        }
    )* };
}
integers!(u8: 8, u16: 16, u32: 32, u64: 64, usize: 64);
/// A literal whose type only the native source determines.
impl Lift for i32 {
    fn lift(self) -> Value {
        Value::literal(i64::from(self) as u64)
    }
}
impl<T: Lift, const N: usize> Lift for [T; N] {
    fn lift(self) -> Value {
        Value::list(&self.map(T::lift))
    }
}
macro_rules! tuples {
    ($($($t:ident $n:tt),+;)*) => { $(
        impl<$($t: Lift),+> Lift for ($($t,)+) {
            fn lift(self) -> Value {
                Value::list(&[$(self.$n.lift()),+])
            }
        }
    )* };
}
tuples! { A 0, B 1; A 0, B 1, C 2; A 0, B 1, C 2, D 3; }

/// How an argument that is known while the netlist is built goes to a twin: configuration as it is,
/// anything else as a hardware value.
pub trait Pass<T> {
    /// As the parameter's type wants it.
    fn pass(self) -> T;
}
impl<'a, T> Pass<&'a T> for &'a T {
    fn pass(self) -> &'a T {
        self
    }
}
impl<T: Lift> Pass<Value> for T {
    fn pass(self) -> Value {
        self.lift()
    }
}

/// A field's name, and the number if it is an array's element: `x[3]` is `x` and 3.
pub(super) fn element(name: &str) -> (&str, Option<usize>) {
    match name.strip_suffix(']').and_then(|n| n.split_once('[')) {
        Some((array, k)) => (array, k.parse().ok()),
        None => (name, None),
    }
}
