//! The second meaning of a block's source: a netlist.
//!
//! `#[rtl]` on a block's functions leaves them as they are and adds twins, which do to wires what the
//! functions do to numbers. [`elaborate()`] calls a block's twins and gives its [`Module`]: wires,
//! registers, memories and children. [`Evaluator`] runs a module, so that [`agrees`] can hold it to the
//! native source without any other tool; a Verilog writer turns it into text.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`node`] | wires and what drives them |
//! | [`value`] | bundles of wires, and where two branches meet |
//! | [`twin`] | operators and methods as the twins call them |
//! | [`mod@elaborate`] | from a block to its module |
//! | [`mod@evaluate`] | runs a module |
//! | [`check`] | holds a module to the native source on random inputs |

pub mod check;
pub mod elaborate;
pub mod evaluate;
pub mod node;
pub mod twin;
pub mod value;

pub use check::agrees;
pub use elaborate::{
    Ask, Instance, Module, Netlist, Numbers, Ram, Register, elaborate, elaborate_alone,
};
pub use evaluate::Evaluator;
pub use node::{Binary, Driver, Graph, Node, Op, Type};
pub use value::{Leaf, Lift, Shape, Step, Value};
