//! Timing and energy of outside memory, device clock by device clock: what stands behind a machine's memory port.
//!
//! ```text
//!            +--------------------------------------------------------+
//!   push --->| Layout -> Channel -> Controller (queues, Timer) -> Device |---> pop
//!            +--------------------------------------------------------+
//!               a Controller with its Device for each data bus: of a channel, or of a pseudo-channel
//! ```
//!
//! [`Dram`] takes requests for bursts and says when the data of each read are there; the data themselves are kept elsewhere.
//! What it is made of is a [`Config`] around a [`Part`], a table of organisation and timing. [`constraints`] makes of that the
//! rules between commands, which [`Device`](device::Device) keeps and the controller obeys.
//!
//! ```
//! use pellucid_dram::{Config, Dram, Part, Request};
//!
//! let mut dram = Dram::new(Config::new(Part::named("ddr4-3200")?))?;
//! dram.push(Request { write: false, address: 0x1000, tag: 7, client: 0 });
//! let mut clocks = 0;
//! let tag = loop {
//!     dram.cycle();
//!     clocks += 1;
//!     if let Some(tag) = dram.pop() {
//!         break tag;
//!     }
//! };
//! // The row must be opened: rcd_read, cl and a burst.
//! assert_eq!((tag, clocks), (7, 22 + 22 + 4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod channel;
mod command;
mod config;
mod controller;
pub mod device;
mod dram;
mod energy;
mod mapping;
mod names;
mod part;
mod queue;
mod refresh;
mod statistics;
mod table;

pub use command::{Command, Issued};
pub use config::{Config, ConfigError, Page, Refresh, Scheduler};
pub use dram::{Dram, Request};
pub use energy::Spent;
pub use mapping::{Layout, Mapping, Place};
pub use names::NameError;
pub use part::{BankRefresh, CommandBuses, Energy, Organisation, Part, PartError, Timing};
pub use statistics::{ClientStatistics, Statistics};
pub use table::{Constraint, Scope, constraints};
