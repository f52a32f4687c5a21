//! What an engineer looks at: value-change dumps of the signals that a model declares.
//!
//! A model declares its registers and wires once ([`pellucid_sim::Signals`]); [`Vcd`] turns that
//! declaration into a file for GTKWave, Surfer and any other viewer, and [`gtkwave`] into a set-up with
//! which GTKWave shows it.

mod gtkwave;
mod vcd;

pub use gtkwave::{ViewFile, gtkwave};
pub use vcd::{PERIOD_NS, Vcd};
