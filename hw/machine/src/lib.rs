//! What every architecture shows to the outside: frames of fragments or of primitives in, images out; what it
//! counts; the parameters that a user chooses; and the clock under which it runs.
//!
//! | module | what it is |
//! | --- | --- |
//! | [`pixel`] | fragments, screens, and what is fixed about colour and depth |
//! | [`primitive`] | triangles that are set up for an edge walk |
//! | [`item`] | what frames are made of, and how a machine is sent it |
//! | [`machine`] | the contract of a machine |
//! | [`arithmetic`] | how a machine makes a pixel's colour of its fragments |
//! | [`accumulation`] | how a machine makes one image of several frames |
//! | [`monitor`] | watches a machine cycle by cycle |
//! | [`phase`] | the phases of an architecture, and its cycles in each |
//! | [`tally`] | what a run came to |
//! | [`census`] | what is known of a frame before a machine has seen it |
//! | [`dut`] | a machine under the clock, whatever its architecture |
//! | [`clocked`] | the same of one architecture |
//! | [`outside`] | the port to memory outside of the chip |
//! | [`room`] | how large a machine must be for a frame |
//! | [`board`] | a machine with that memory |
//! | [`model`] | a machine that is ready to run |
//! | [`params`] | parameters |
//! | [`architecture`] | what an architecture says of itself |

pub mod accumulation;
pub mod architecture;
pub mod arithmetic;
pub mod board;
pub mod census;
pub mod clocked;
pub mod dut;
pub mod item;
pub mod machine;
pub mod model;
pub mod monitor;
pub mod outside;
pub mod params;
pub mod phase;
pub mod pixel;
pub mod primitive;
pub mod room;
pub mod tally;

pub use accumulation::Accumulation;
pub use architecture::Architecture;
pub use arithmetic::Arithmetic;
pub use census::{Census, Check};
pub use dut::{Dut, Failure};
pub use item::{FragmentIn, InConfig, Item, ItemType, Kind, Offer, PrimitiveIn};
pub use machine::{Dealer, Machine, Ports};
pub use model::Model;
pub use monitor::{Memories, Monitor, Seen, seen, waits};
pub use outside::Outside;
pub use phase::{Cycles, PhaseCounts, PhaseInfo};
pub use room::{Rest, Room};
pub use tally::{Fragments, MemoryTally, StreamTally, Tally};
