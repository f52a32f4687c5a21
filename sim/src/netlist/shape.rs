//! The form of a bundle: which signals it has, and how they nest.

use super::node::Node;
use super::value::{Record, Value, element};
use crate::signals::{Declare, Kind};

/// One signal of a [`Shape`].
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// Its path: `payload.item.z`, `entries[3].z`.
    pub path: String,
    /// How many bits.
    pub width: u32,
    /// What they mean.
    pub kind: Kind,
}

/// The form of a bundle: its signals in the order of their declaration, and how they nest.
#[derive(Clone, Debug, Default)]
pub struct Shape {
    /// Every signal.
    pub leaves: Vec<Leaf>,
    root: Option<Form>,
    path: Vec<(String, Vec<(String, Form)>)>,
}

#[derive(Clone, Debug)]
enum Form {
    Leaf(usize),
    Record(Vec<(String, Form)>),
}

impl Shape {
    /// The form of what `declare` declares.
    pub fn of(declare: impl FnOnce(&mut dyn Declare)) -> Shape {
        let mut shape = Shape::default();
        declare(&mut shape);
        shape
    }

    fn add(&mut self, name: &str, form: Form) {
        match self.path.last_mut() {
            Some((_, fields)) => fields.push((name.to_string(), form)),
            None => self.root = Some(form),
        }
    }

    fn path_of(&self, name: &str) -> String {
        let opened = self.path.iter().map(|(n, _)| n.as_str());
        opened.chain([name]).filter(|n| !n.is_empty()).collect::<Vec<_>>().join(".")
    }

    /// A value of this form whose wire of signal `k` is `wire(k)`. If `placed`, its bundles know
    /// their paths.
    pub fn build(&self, placed: bool, wire: &mut dyn FnMut(usize) -> Node) -> Value {
        match &self.root {
            Some(form) => build(form, "", placed, wire),
            None => Value::Zero,
        }
    }

    /// The wires of `value`, one for each signal.
    pub fn wires(&self, value: Value) -> Vec<Value> {
        let mut wires = vec![Value::Zero; self.leaves.len()];
        if let Some(form) = &self.root {
            gather(form, value, &mut wires);
        }
        wires
    }
}

fn of_one_array(a: &str, b: &str) -> bool {
    matches!((element(a), element(b)), ((a, Some(_)), (b, Some(_))) if a == b)
}

fn build(form: &Form, path: &str, placed: bool, wire: &mut dyn FnMut(usize) -> Node) -> Value {
    let fields = match form {
        Form::Leaf(k) => return Value::Wire(wire(*k)),
        Form::Record(fields) => fields,
    };
    let mut record = Record { place: placed.then(|| path.into()), fields: vec![] };
    // The elements of an array stand one after the other.
    for run in fields.chunk_by(|(a, _), (b, _)| of_one_array(a, b)) {
        let part = |(name, form): &(String, Form)| {
            build(form, &crate::join(path, name), placed, &mut *wire)
        };
        let values: Vec<Value> = run.iter().map(part).collect();
        record.fields.push(match element(&run[0].0) {
            (name, None) => (name.into(), values[0]),
            (array, Some(_)) => (array.into(), Value::list(&values)),
        });
    }
    record.into_value()
}

fn gather(form: &Form, value: Value, wires: &mut [Value]) {
    match form {
        Form::Leaf(k) => wires[*k] = value,
        Form::Record(fields) => {
            for (name, form) in fields {
                if matches!(value, Value::Clocked(_)) {
                    continue;
                }
                let part = match element(name) {
                    (name, None) => value.field(name),
                    (array, Some(k)) => value.field(array).at(Value::literal(k as u64)),
                };
                gather(form, part, wires);
            }
        }
    }
}

impl Declare for Shape {
    fn open(&mut self, name: &str) {
        self.path.push((name.to_string(), vec![]));
    }
    fn close(&mut self) {
        if let Some((name, fields)) = self.path.pop() {
            self.add(&name, Form::Record(fields));
        }
    }
    fn signal(&mut self, name: &str, width: u32, kind: Kind) {
        let path = self.path_of(name);
        let form = Form::Leaf(self.leaves.len());
        self.leaves.push(Leaf { path, width, kind });
        self.add(name, form);
    }
}
