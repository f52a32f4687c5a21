//! What an engineer looks at: waveforms of the signals that a model declares, and how viewers show them.
//!
//! A model declares its registers and wires once ([`pellucid_sim::Signals`]). From these declarations come
//! a [`Layout`], the list of what is shown; a [`Wave`], which writes what changes as VCD or FST; and a
//! [`View`], set-ups with which GTKWave and Surfer show it at once.
//!
//! ```
//! use pellucid_sim::{Registers, Signals};
//! use pellucid_waveforms::{FileFormat, Layout, Wave};
//!
//! #[derive(Clone, Copy, Signals)]
//! #[signals(())]
//! struct State {
//!     #[width(4)]
//!     count: u32,
//! }
//!
//! let layout = Layout::new(vec![], |to| <State as Registers>::declare(&(), "counter", to));
//! let path = std::env::temp_dir().join(format!("counter-{}.vcd", std::process::id()));
//! let mut wave = Wave::new(FileFormat::Vcd, std::fs::File::create(&path)?, layout, 0)?;
//! for cycle in 0..3 {
//!     let state = State { count: 5 + cycle as u32 };
//!     wave.sample(|to| Registers::sample(&state, &(), to));
//!     wave.show(cycle)?;
//! }
//! wave.finish(3)?;
//! let text = std::fs::read_to_string(&path)?;
//! std::fs::remove_file(&path)?;
//! assert!(text.contains("count") && text.contains("b111 "));
//! # Ok::<(), std::io::Error>(())
//! ```

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
