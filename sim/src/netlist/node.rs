//! The wires of one module and what drives them.
//!
//! A [`Node`] is a number in the graph of the module that is being elaborated. Nodes are made in
//! order, each after those that it reads; equal ones are one, and constants fold. A node is as wide as
//! what it can hold: a sum is one bit wider than its parts, a difference as wide as the larger, which
//! is exact as long as the native arithmetic does not overflow.

use super::value::Contents;
use crate::signals::{Kind, States, bits_for};
use std::cell::RefCell;
use std::collections::HashMap;
use std::rc::Rc;

/// A wire of the module that is being elaborated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Node(pub u32);

/// What a wire's bits mean in the Rust source.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Type {
    /// `bool`.
    Flag,
    /// An unsigned integer of so many bits: it wraps and inverts at that width.
    Integer(u32),
    /// An integer literal, of whatever type it meets.
    Literal,
    /// A state, by number.
    State(&'static States),
}

impl std::hash::Hash for Type {
    fn hash<H: std::hash::Hasher>(&self, to: &mut H) {
        let tag = match self {
            Type::Flag => 0,
            Type::Integer(bits) => *bits,
            Type::Literal => 128,
            Type::State(_) => 129,
        };
        tag.hash(to);
    }
}

impl Type {
    /// The type of signals of that kind.
    pub fn of(kind: Kind) -> Type {
        match kind {
            Kind::Flag => Type::Flag,
            Kind::Bits(bits) => Type::Integer(bits),
            Kind::State(states) => Type::State(states),
        }
    }
    /// The width at which its arithmetic ends.
    fn bits(self) -> u32 {
        match self {
            Type::Integer(bits) => bits,
            _ => 64,
        }
    }
    /// The type of two operands together.
    fn with(self, other: Type) -> Type {
        if self == Type::Literal { other } else { self }
    }
}

/// An operation of two operands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Binary {
    /// Sum.
    Add,
    /// Difference.
    Sub,
    /// Product.
    Mul,
    /// Bitwise and.
    And,
    /// Bitwise or.
    Or,
    /// Bitwise exclusive or.
    Xor,
    /// Equal.
    Eq,
    /// Less than, unsigned.
    Lt,
    /// Shift left.
    Shl,
    /// Shift right, zeros come in.
    Shr,
}

/// What drives a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Op {
    /// A number.
    Const(u64),
    /// Input `k` of the module.
    Input(usize),
    /// Register `k`.
    Register(usize),
    /// Output `output` of instance `instance`.
    Output {
        /// Which instance.
        instance: usize,
        /// Which of its outputs.
        output: usize,
    },
    /// Memory `k` shows the data of a read.
    ReadValid(usize),
    /// Field `field` of the word that memory `ram` shows.
    ReadData {
        /// Which memory.
        ram: usize,
        /// Which field of its word.
        field: usize,
    },
    /// An operation of two operands.
    Binary(Binary, Node, Node),
    /// Every bit inverted.
    Not(Node),
    /// The second where the first is 1, else the third.
    Mux(Node, Node, Node),
    /// Its low bits.
    Low(Node),
    /// How many zeros stand below the lowest one; the type's width if there is none.
    TrailingZeros(Node),
}

impl Op {
    /// Calls `see` for every node that the operation reads.
    pub fn operands(&self, mut see: impl FnMut(Node)) {
        match *self {
            Op::Binary(_, a, b) => [a, b].into_iter().for_each(see),
            Op::Mux(c, a, b) => [c, a, b].into_iter().for_each(see),
            Op::Not(a) | Op::Low(a) | Op::TrailingZeros(a) => see(a),
            Op::Const(_)
            | Op::Input(_)
            | Op::Register(_)
            | Op::Output { .. }
            | Op::ReadValid(_)
            | Op::ReadData { .. } => {}
        }
    }
}

/// A node's operation, width and type.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Driver {
    /// What drives it.
    pub op: Op,
    /// How many bits, 1..=64.
    pub width: u32,
    /// What they mean.
    pub ty: Type,
}

/// The nodes of one module.
#[derive(Debug, Default)]
pub struct Graph {
    /// `[n]` drives node `n`.
    pub drivers: Vec<Driver>,
    /// Names that the source gives to nodes.
    pub names: HashMap<Node, String>,
    /// Names of variables that hold nodes where two branches meet.
    pub hints: HashMap<Node, String>,
    known: HashMap<Driver, Node>,
    /// What the bundles of hardware values hold.
    pub(super) bundles: Vec<Rc<Contents>>,
}

thread_local! {
    static GRAPHS: RefCell<Vec<Graph>> = const { RefCell::new(vec![]) };
}

impl Graph {
    /// Begins a graph: nodes are made in it until [`Graph::finish`].
    pub fn begin() {
        GRAPHS.with_borrow_mut(|graphs| graphs.push(Graph::default()));
    }
    /// Ends the graph that was begun last.
    pub fn finish() -> Graph {
        let graph = GRAPHS.with_borrow_mut(|graphs| graphs.pop().expect("a graph was begun"));
        Graph { bundles: vec![], ..graph }
    }
    pub(super) fn with<R>(f: impl FnOnce(&mut Graph) -> R) -> R {
        GRAPHS.with_borrow_mut(|graphs| {
            f(graphs.last_mut().expect("hardware values are made while a block is elaborated"))
        })
    }
}

/// The highest number of `width` bits.
pub fn mask(width: u32) -> u64 {
    if width >= 64 { u64::MAX } else { (1 << width) - 1 }
}

/// A result of an operation on known operands, at `width` bits.
pub fn compute(op: Binary, a: u64, b: u64, width: u32) -> u64 {
    let shift =
        |f: fn(u64, u32) -> Option<u64>| u32::try_from(b).ok().and_then(|b| f(a, b)).unwrap_or(0);
    let value = match op {
        Binary::Add => a.wrapping_add(b),
        Binary::Sub => a.wrapping_sub(b),
        Binary::Mul => a.wrapping_mul(b),
        Binary::And => a & b,
        Binary::Or => a | b,
        Binary::Xor => a ^ b,
        Binary::Eq => u64::from(a == b),
        Binary::Lt => u64::from(a < b),
        Binary::Shl => shift(u64::checked_shl),
        Binary::Shr => shift(u64::checked_shr),
    };
    value & mask(width)
}

impl Node {
    /// A node with that driver: the one that there is already, or a new one.
    pub fn driven(op: Op, width: u32, ty: Type) -> Node {
        let driver = Driver { op, width, ty };
        Graph::with(|graph| match graph.known.get(&driver) {
            Some(node) => *node,
            None => {
                let node = Node(graph.drivers.len() as u32);
                graph.drivers.push(driver);
                graph.known.insert(driver, node);
                node
            }
        })
    }
    /// A constant.
    pub fn constant(value: u64, width: u32, ty: Type) -> Node {
        Node::driven(Op::Const(value & mask(width)), width, ty)
    }
    /// A constant as wide as it needs to be.
    pub fn number(value: u64, ty: Type) -> Node {
        Node::constant(value, bits_for(value), ty)
    }
    /// `true` or `false`.
    pub fn flag(value: bool) -> Node {
        Node::constant(u64::from(value), 1, Type::Flag)
    }
    /// Its driver.
    pub fn driver(self) -> Driver {
        Graph::with(|graph| graph.drivers[self.0 as usize])
    }
    /// How many bits.
    pub fn width(self) -> u32 {
        self.driver().width
    }
    /// What its bits mean.
    pub fn ty(self) -> Type {
        self.driver().ty
    }
    /// Its value, if it is constant.
    pub fn known(self) -> Option<u64> {
        match self.driver().op {
            Op::Const(value) => Some(value),
            _ => None,
        }
    }
    /// Gives it a name, unless it has one.
    pub fn named(self, name: &str) {
        Graph::with(|graph| {
            graph.names.entry(self).or_insert_with(|| name.to_string());
        });
    }
    /// Gives it a name to be used if it needs one, unless it has one.
    pub fn hinted(self, name: &str) {
        Graph::with(|graph| {
            graph.hints.entry(self).or_insert_with(|| name.to_string());
        });
    }

    fn binary(op: Binary, a: Node, b: Node, width: u32, ty: Type) -> Node {
        let width = width.clamp(1, 64);
        if let (Some(x), Some(y)) = (a.known(), b.known()) {
            let value = compute(op, x, y, width);
            return Node::constant(value, if ty == Type::Flag { 1 } else { width }, ty);
        }
        Node::driven(Op::Binary(op, a, b), width, ty)
    }

    /// `self + other`.
    pub fn plus(self, other: Node) -> Node {
        let ty = self.ty().with(other.ty());
        match (self.known(), other.known()) {
            (Some(0), _) => other,
            (_, Some(0)) => self,
            _ => {
                let width = (self.width().max(other.width()) + 1).min(ty.bits());
                Node::binary(Binary::Add, self, other, width, ty)
            }
        }
    }
    /// `self - other`, not below 0.
    pub fn minus(self, other: Node) -> Node {
        if other.known() == Some(0) {
            return self;
        }
        let width = self.width().max(other.width());
        Node::binary(Binary::Sub, self, other, width, self.ty().with(other.ty()))
    }
    /// `self * other`.
    pub fn times(self, other: Node) -> Node {
        let ty = self.ty().with(other.ty());
        match (self.known(), other.known()) {
            (Some(1), _) => other,
            (_, Some(1)) => self,
            (_, Some(n)) if n.is_power_of_two() => {
                self.shifted_left(Node::number(n.trailing_zeros().into(), Type::Literal))
            }
            _ => {
                let width = (self.width() + other.width()).min(ty.bits());
                Node::binary(Binary::Mul, self, other, width, ty)
            }
        }
    }
    /// `self` wrapping as its type does, after `op`.
    pub fn wrapping(self, op: Binary, other: Node) -> Node {
        let ty = self.ty().with(other.ty());
        Node::binary(op, self, other, ty.bits(), ty)
    }
    /// `self & other`, of flags or of bits.
    pub fn and(self, other: Node) -> Node {
        let ty = self.ty().with(other.ty());
        let width = self.width().min(other.width());
        for (a, b) in [(self, other), (other, self)] {
            match a.known() {
                Some(0) => return Node::constant(0, width, ty),
                Some(v) if v == mask(b.width()) => return b,
                // All ones from the lowest bit on: bits are cut off.
                Some(v) if v < mask(b.width()) && v & (v + 1) == 0 && b.known().is_none() => {
                    return Node::driven(Op::Low(b), bits_for(v), ty);
                }
                _ => {}
            }
        }
        if self == other { self } else { Node::binary(Binary::And, self, other, width, ty) }
    }
    /// `self | other`, of flags or of bits.
    pub fn or(self, other: Node) -> Node {
        let ty = self.ty().with(other.ty());
        for (a, b) in [(self, other), (other, self)] {
            match a.known() {
                Some(0) => return b,
                Some(1) if ty == Type::Flag => return a,
                _ => {}
            }
        }
        let width = self.width().max(other.width());
        if self == other { self } else { Node::binary(Binary::Or, self, other, width, ty) }
    }
    /// `self ^ other`, of flags or of bits.
    pub fn xor(self, other: Node) -> Node {
        for (a, b) in [(self, other), (other, self)] {
            match a.known() {
                Some(0) => return b,
                Some(1) if b.ty() == Type::Flag => return b.inverted(),
                _ => {}
            }
        }
        let width = self.width().max(other.width());
        Node::binary(Binary::Xor, self, other, width, self.ty().with(other.ty()))
    }
    /// `self == other`.
    pub fn equals(self, other: Node) -> Node {
        if self == other {
            return Node::flag(true);
        }
        if self.ty() == Type::Flag {
            return self.xor(other).inverted();
        }
        // A number that does not fit is never met.
        for (a, b) in [(self, other), (other, self)] {
            if a.known().is_some_and(|v| v > mask(b.width())) {
                return Node::flag(false);
            }
        }
        Node::binary(Binary::Eq, self, other, 1, Type::Flag)
    }
    /// `self < other`.
    pub fn less(self, other: Node) -> Node {
        if self == other || other.known() == Some(0) {
            return Node::flag(false);
        }
        if self.known() == Some(0) {
            return other.equals(Node::constant(0, other.width(), other.ty())).inverted();
        }
        if other.known().is_some_and(|v| v > mask(self.width())) {
            return Node::flag(true);
        }
        // Nothing is more than all ones.
        if self.known().is_some_and(|v| v >= mask(other.width())) {
            return Node::flag(false);
        }
        Node::binary(Binary::Lt, self, other, 1, Type::Flag)
    }
    /// `self << other`.
    pub fn shifted_left(self, other: Node) -> Node {
        let most = other.known().unwrap_or_else(|| mask(other.width().min(6)));
        let width = self.width().saturating_add(most.min(64) as u32).min(self.ty().bits());
        Node::binary(Binary::Shl, self, other, width, self.ty())
    }
    /// `self >> other`.
    pub fn shifted_right(self, other: Node) -> Node {
        if other.known() == Some(0) {
            return self;
        }
        let least = other.known().unwrap_or(0).min(64) as u32;
        let width = self.width().saturating_sub(least);
        if width == 0 {
            return Node::constant(0, 1, self.ty());
        }
        Node::binary(Binary::Shr, self, other, width, self.ty())
    }
    /// `!self`.
    pub fn inverted(self) -> Node {
        let ty = self.ty();
        let width = if ty == Type::Flag { 1 } else { ty.bits() };
        match self.driver().op {
            Op::Const(value) => Node::constant(!value, width, ty),
            Op::Not(inner) if ty == Type::Flag => inner,
            _ => Node::driven(Op::Not(self), width, ty),
        }
    }
    /// Its low `bits` bits, as an integer of that many.
    pub fn cast(self, bits: u32) -> Node {
        let (width, ty) = (self.width().min(bits), Type::Integer(bits));
        match self.known() {
            Some(value) => Node::constant(value, width, ty),
            None if self.ty() == ty => self,
            None => Node::driven(Op::Low(self), width, ty),
        }
    }
    /// How many zeros stand below the lowest one.
    pub fn trailing_zeros(self) -> Node {
        let all = self.ty().bits();
        match self.known() {
            Some(0) => Node::number(all.into(), Type::Integer(32)),
            Some(v) => Node::number(v.trailing_zeros().into(), Type::Integer(32)),
            None => {
                Node::driven(Op::TrailingZeros(self), bits_for(u64::from(all)), Type::Integer(32))
            }
        }
    }
    /// `a` where `self` is 1, else `b`.
    pub fn mux(self, a: Node, b: Node) -> Node {
        let (cond, mut a, mut b) = match self.driver().op {
            Op::Not(inner) => (inner, b, a),
            _ => (self, a, b),
        };
        match cond.known() {
            Some(0) => return b,
            Some(_) => return a,
            None => {}
        }
        // Within a branch its condition is known.
        if let Op::Mux(c, x, _) = a.driver().op
            && c == cond
        {
            a = x;
        }
        if let Op::Mux(c, _, y) = b.driver().op
            && c == cond
        {
            b = y;
        }
        if a == b {
            return a;
        }
        let ty = a.ty().with(b.ty());
        if ty == Type::Flag {
            match (a.known(), b.known()) {
                _ if a == cond => return cond.or(b),
                _ if b == cond => return cond.and(a),
                (Some(1), Some(_)) => return cond,
                (Some(_), Some(_)) => return cond.inverted(),
                (Some(1), _) => return cond.or(b),
                (Some(_), _) => return cond.inverted().and(b),
                (_, Some(0)) => return cond.and(a),
                (_, Some(_)) => return cond.inverted().or(a),
                _ => {}
            }
        }
        Node::driven(Op::Mux(cond, a, b), a.width().max(b.width()), ty)
    }
}
