//! A machine that is ready to run: an architecture with its parameters, for a screen.

use crate::accumulation::Accumulation;
use crate::arithmetic::Arithmetic;
use crate::census::{Census, Check};
use crate::clocked::Clocked;
use crate::dut::Dut;
use crate::item::{ItemType, Kind};
use crate::machine::{Dealer, Machine};
use crate::outside;
use crate::params::Value;
use crate::phase::PhaseInfo;
use crate::pixel::Screen;
use crate::room::Room;
use crate::tally::Tally;
use pellucid_sim::netlist::{Module, elaborate_alone};

/// See the module's description.
pub trait Model: Send + Sync {
    /// Its parameters' final values.
    fn values(&self) -> Vec<(String, Value)>;
    /// The screen.
    fn screen(&self) -> Screen;
    /// What its frames are made of.
    fn kind(&self) -> Kind;
    /// How it makes colours.
    fn arithmetic(&self) -> Arithmetic;
    /// How it makes one image of several frames, if it does: see [`Machine::accumulation`].
    fn accumulation(&self) -> Option<Accumulation>;
    /// Its phases.
    fn phases(&self) -> &'static [PhaseInfo];
    /// Whether it may ask for a frame again: see [`Machine::replays`].
    fn replays(&self) -> bool;
    /// Frames of an image.
    fn frames_of_image(&self) -> u32 {
        self.accumulation().map_or(1, |accumulation| accumulation.frames())
    }
    /// To which of several engines an item goes: see [`Machine::dealer`].
    fn dealer(&self) -> Option<Dealer>;
    /// What a run must have counted: see [`Machine::closed_forms`].
    fn closed_forms(&self, tally: &Tally, frames: &[Census]) -> Vec<Check>;
    /// How large it must be for a frame: see [`Machine::room`].
    fn room(&self, frame: &Census) -> Option<Room>;
    /// Its port to outside memory.
    fn port(&self) -> outside::Config;
    /// Cycles from a read request at the port to its word, if there is a port and these are always as many.
    fn latency(&self) -> Option<u32>;
    /// The machine at power-up.
    fn power_up(&self) -> Box<dyn Dut>;
    /// The machine as a netlist.
    fn netlist(&self) -> Module;
}

/// A machine of one architecture.
pub struct Configured<M: Machine> {
    /// Its configuration.
    pub cfg: M::Config,
    /// Its parameters' final values.
    pub values: Vec<(String, Value)>,
}

impl<M: Machine> Model for Configured<M> {
    fn values(&self) -> Vec<(String, Value)> {
        self.values.clone()
    }
    fn screen(&self) -> Screen {
        M::screen(&self.cfg)
    }
    fn kind(&self) -> Kind {
        M::Item::KIND
    }
    fn arithmetic(&self) -> Arithmetic {
        M::arithmetic(&self.cfg)
    }
    fn accumulation(&self) -> Option<Accumulation> {
        M::accumulation(&self.cfg)
    }
    fn phases(&self) -> &'static [PhaseInfo] {
        M::PHASES
    }
    fn replays(&self) -> bool {
        M::replays(&self.cfg)
    }
    fn dealer(&self) -> Option<Dealer> {
        M::dealer(&self.cfg)
    }
    fn closed_forms(&self, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        M::closed_forms(&self.cfg, tally, frames)
    }
    fn room(&self, frame: &Census) -> Option<Room> {
        M::room(&self.cfg, frame)
    }
    fn port(&self) -> outside::Config {
        M::port(&self.cfg)
    }
    fn latency(&self) -> Option<u32> {
        M::outside(&self.cfg).map(|outside| outside.latency)
    }
    fn power_up(&self) -> Box<dyn Dut> {
        Box::new(Clocked::<M>::new(self.cfg))
    }
    fn netlist(&self) -> Module {
        elaborate_alone::<M>(&self.cfg)
    }
}
