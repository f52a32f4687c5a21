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
//! | [`shape`] | which signals a bundle has, and how they nest |
//! | [`twin`] | operators and methods as the twins call them |
//! | [`module`] | a block's ports, registers, memories and children |
//! | [`mod@elaborate`] | from a block to its module |
//! | [`mod@evaluate`] | runs a module |
//! | [`reach`] | what of a module has an effect that can be seen from outside |
//! | [`check`] | holds a module to the native source on random inputs |

pub mod check;
pub mod elaborate;
pub mod evaluate;
pub mod module;
pub mod node;
pub mod reach;
pub mod shape;
pub mod twin;
pub mod value;

pub use check::agrees;
pub use elaborate::{Netlist, Numbers, elaborate, elaborate_alone};
pub use evaluate::Evaluator;
pub use module::{Ask, Instance, Module, Ram, Register};
pub use node::{Binary, Driver, Graph, Node, Op, Type};
pub use reach::without_effect;
pub use shape::{Leaf, Shape};
pub use value::{Lift, Step, Value};
