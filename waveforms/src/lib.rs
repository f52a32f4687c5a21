//! What an engineer looks at: waveforms of the signals that a model declares, and how viewers show them.
//!
//! A model declares its registers and wires once ([`pellucid_sim::Signals`]). From these declarations come
//! a [`Layout`], the list of what is shown; a [`Wave`], which writes what changes as VCD or FST; and a
//! [`View`], set-ups with which GTKWave and Surfer show it at once.

mod fst;
mod gtkwave;
mod layout;
mod surfer;
mod vcd;
mod view;
mod wave;
mod worker;

pub use layout::{Layout, NoSignal, StreamOf};
pub use view::{Found, Marker, View, ViewFile};
pub use wave::{FileFormat, PERIOD_NS, Wave};
