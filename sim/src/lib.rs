//! The clock: everything that a cycle-accurate model needs and no pixel.
//!
//! A [`Block`] is a configuration, a struct of registers, ports, memories and two functions. [`Sim`]
//! steps one on the clock edge. Blocks talk through [`Stream`]s, keep bulk data in [`Ram1R1W`] and
//! [`Ram1RW`] memories, and declare their registers and wires once, with [`Signals`] or, where they hold
//! lines of children, [`Registers`], for every waveform format and for the width check.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`mod@block`] | the contract of a block, and the driver that clocks one |
//! | [`mod@signals`] | names, widths and kinds of registers and wires |
//! | [`mod@sampler`] | takes a cycle's values, and finds what changed |
//! | [`mod@stream`] | valid/ready streams, their four rules and the monitor that holds them |
//! | [`mod@memory`] | what a memory is to the clock |
//! | [`mod@ram`] | memories with one read and one write port, or with one port for both |
//! | [`mod@netlist`] | the second meaning of a block's source: wires, registers and memories |
//! | [`mod@fifo`] | a queue in a memory |
//! | [`mod@range`] | ranges of a configuration, checked where the block is built |
//! | [`mod@figures`] | counters with unit and sentence |
//! | [`mod@label`] | which item it is that a register or a wire holds |
//! | [`mod@watchdog`] | stops a simulation in which nothing moves |
//!
//! # Example
//! A counter that stops at its limit:
//! ```
//! use pellucid_sim::{Block, Signals, Sim};
//!
//! pub struct Config { limit: u32 }
//! #[derive(Clone, Copy, Signals)]
//! pub struct State { #[width(8)] count: u32 }
//! #[derive(Clone, Copy, Signals)]
//! pub struct In { up: bool }
//! #[derive(Clone, Copy, Signals)]
//! pub struct Out { full: bool }
//!
//! struct Counter;
//! impl Block for Counter {
//!     type Config = Config;
//!     type State = State;
//!     type In = In;
//!     type Moore = ();
//!     type Out = Out;
//!     type Mem = ();
//!     fn reset(_: &Config) -> State { State { count: 0 } }
//!     fn memories(_: &Config) {}
//!     fn moore(_: &Config, _: &State, _: &()) {}
//!     fn next(cfg: &Config, q: &State, d: &mut State, _: &mut (), i: In) -> Out {
//!         let full = q.count == cfg.limit;
//!         if i.up && !full {
//!             d.count = q.count + 1;
//!         }
//!         Out { full }
//!     }
//! }
//!
//! let mut sim = Sim::<Counter>::new(Config { limit: 2 });
//! let full: Vec<bool> = (0..4).map(|_| sim.clock(In { up: true }).unwrap().out.full).collect();
//! assert_eq!(full, [false, false, true, true]);
//! ```

// The derives name this crate from outside; inside it they reach it by the same name.
extern crate self as pellucid_sim;

pub mod block;
pub mod fifo;
pub mod figures;
pub mod label;
pub mod memory;
pub mod netlist;
mod panics;
pub mod ram;
pub mod range;
pub mod sampler;
pub mod signals;
pub mod stream;
pub mod watchdog;

pub use block::{Block, Sim};
pub use fifo::Fifo;
pub use figures::{Figure, Figures};
pub use label::Label;
pub use memory::{
    Fault, FaultKind, Memory, Optional, Ports, ReadDuringWrite, Storage, StorageInfo, join,
};
pub use netlist::Netlist;
pub use panics::panic_text;
pub use pellucid_sim_derive::{Memory, Registers, Signals, rtl};
pub use ram::{Port, Ram1R1W, Ram1RW, Read, ReadPort, WritePort};
pub use range::check_range;
pub use sampler::Sampler;
pub use signals::{
    Declare, Kind, Overflow, Registers, Signals, Sink, States, bits_for, state_name, width_of,
};
pub use stream::{Handshake, Stream, StreamMonitor, Violation};
pub use watchdog::{Deadlock, Wait, Watchdog};
