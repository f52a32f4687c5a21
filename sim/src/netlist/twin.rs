//! What the functions that `#[rtl]` makes are written in: each operator and method of the native
//! source by its name, on hardware values.

use super::node::{Binary, Node};
use super::value::{Step, Value};

macro_rules! operators {
    ($($(#[$meta:meta])* $name:ident: |$a:ident, $b:ident| $result:expr;)*) => { $(
        $(#[$meta])*
        pub fn $name(a: Value, b: Value) -> Value {
            let ($a, $b) = (a.wire(), b.wire());
            Value::Wire($result)
        }
    )* };
}
operators! {
    /// `a + b`
    add: |a, b| a.plus(b);
    /// `a - b`
    sub: |a, b| a.minus(b);
    /// `a * b`
    mul: |a, b| a.times(b);
    /// `a & b`, and `a && b`, whose sides have no effect
    and: |a, b| a.and(b);
    /// `a | b`, and `a || b`
    or: |a, b| a.or(b);
    /// `a ^ b`
    xor: |a, b| a.xor(b);
    /// `a << b`
    shl: |a, b| a.shifted_left(b);
    /// `a >> b`
    shr: |a, b| a.shifted_right(b);
    /// `a == b`
    eq: |a, b| a.equals(b);
    /// `a != b`
    ne: |a, b| a.equals(b).inverted();
    /// `a < b`
    lt: |a, b| a.less(b);
    /// `a > b`
    gt: |a, b| b.less(a);
    /// `a <= b`
    le: |a, b| b.less(a).inverted();
    /// `a >= b`
    ge: |a, b| a.less(b).inverted();
}

/// `!a`
pub fn not(a: Value) -> Value {
    Value::Wire(a.wire().inverted())
}

/// `a as T` and `T::from(a)`, for an integer type of `bits` bits
pub fn cast(a: Value, bits: u32) -> Value {
    Value::Wire(a.wire().cast(bits))
}

/// The condition of a branch.
pub fn cond(a: Value) -> Node {
    a.wire()
}

/// The methods that native values have.
impl Value {
    /// Sum at the type's width.
    pub fn wrapping_add(self, other: Value) -> Value {
        Value::Wire(self.wire().wrapping(Binary::Add, other.wire()))
    }
    /// Difference at the type's width.
    pub fn wrapping_sub(self, other: Value) -> Value {
        Value::Wire(self.wire().wrapping(Binary::Sub, other.wire()))
    }
    /// Difference, 0 where it would be less.
    pub fn saturating_sub(self, other: Value) -> Value {
        let (a, b) = (self.wire(), other.wire());
        let zero = Node::constant(0, 1, a.ty());
        Value::Wire(a.less(b).mux(zero, a.minus(b)))
    }
    /// The smaller one.
    pub fn min(self, other: Value) -> Value {
        let (a, b) = (self.wire(), other.wire());
        Value::Wire(a.less(b).mux(a, b))
    }
    /// The larger one.
    pub fn max(self, other: Value) -> Value {
        let (a, b) = (self.wire(), other.wire());
        Value::Wire(a.less(b).mux(b, a))
    }
    /// How many zeros stand below the lowest one.
    pub fn trailing_zeros(self) -> Value {
        Value::Wire(self.wire().trailing_zeros())
    }
    /// A stream's offer with the receiver's side: see [`crate::Stream::with`].
    pub fn with(self, ready: Value) -> Value {
        Value::record(&[
            ("valid", self.field("valid")),
            ("ready", ready),
            ("payload", self.field("payload")),
        ])
    }
    /// Whether a transfer happens: see [`crate::Handshake::fires`].
    pub fn fires(self) -> Value {
        and(self.field("valid"), self.field("ready"))
    }

    /// Asks a port, or a memory's port, for the word at `addr`.
    pub fn read(&mut self, addr: Value) {
        let ask = [("en", Value::Wire(Node::flag(true))), ("addr", addr)];
        self.port("read", |port| port.updated(&ask));
    }
    /// Tells a memory how many of its words are of use: no hardware.
    pub fn holds(&mut self, _words: Value) {}
    /// Asks a port, or a memory's port, to put `data` at `addr`.
    pub fn write(&mut self, addr: Value, data: Value) {
        let yes = Value::Wire(Node::flag(true));
        let ask = [("en", yes), ("write", yes), ("addr", addr), ("data", data)];
        self.port("write", |port| port.updated(&ask));
    }
    /// Asks a memory's read port for what `user` asks, if anything.
    pub fn pass_read(&mut self, user: Value) {
        self.port("read", |port| Value::choose(user.field("en").wire(), user, port));
    }
    /// Asks a memory's write port for what `user` asks, if anything.
    pub fn pass_write(&mut self, user: Value) {
        self.port("write", |port| Value::choose(user.field("en").wire(), user, port));
    }
    /// Asks a memory's only port, or that of its two ports which does it, for what `user` asks, if anything.
    pub fn pass(&mut self, user: Value) {
        let (mut reads, mut writes) = (*self, *self);
        reads.read(user.field("addr"));
        writes.write(user.field("addr"), user.field("data"));
        let asks = Value::choose(user.field("write").wire(), writes, reads);
        *self = Value::choose(user.field("en").wire(), asks, *self);
    }

    /// Changes one port: of a memory that one of its ports, or its only one; else the value itself.
    fn port(&mut self, name: &'static str, change: impl FnOnce(Value) -> Value) {
        let step = match super::elaborate::ports_of(*self) {
            None => None,
            Some(crate::Ports::OneReadOneWrite) => Some(name),
            Some(crate::Ports::One) => Some("port"),
        };
        match step {
            Some(step) => {
                let changed = change(self.field(step));
                self.set(&[Step::Field(step)], changed);
            }
            None => *self = change(*self),
        }
    }
    /// What a memory shows.
    pub fn q(self) -> Value {
        super::elaborate::shown_by(self)
    }
}
