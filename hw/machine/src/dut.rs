//! A machine under the clock, whatever its architecture: fed with items, watched, and its images caught.
//!
//! Whoever plays, records, compares, reports and tests deals with a [`Dut`], the device under test. Its code is
//! compiled once, where the architecture is. A call is a cycle or many: [`Dut::send`] and [`Dut::run`] loop inside.

use crate::board::Timing;
use crate::item::Offer;
use crate::phase::PhaseInfo;
use crate::tally::Tally;
use pellucid_sim::{Deadlock, Declare, Fault, Memory, Sampler, Violation};
use std::any::Any;

/// Why a run of a model ended early: a bug in a block, or a simulation in which nothing moves.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// A block misused its hardware.
    #[error("fault in the model: {0}")]
    Fault(#[from] Fault),
    /// A stream broke its rules.
    #[error("fault in the model: {0}")]
    Violation(#[from] Violation),
    /// Nothing moved.
    #[error("the simulation stands still, {0}")]
    Deadlock(#[from] Deadlock),
}

/// What a [`Dut`] is in the middle of, for whoever watches it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct At {
    /// The cycle, counted from the first in which the machine was ready; nothing before that.
    pub time: Option<u64>,
    /// The number of its phase.
    pub phase: u8,
}

/// One cycle as it can be seen.
pub trait Observed {
    /// Registers and wires, in the order of [`Dut::declare`].
    fn sample(&self, to: &mut Sampler);
    /// The registers alone, as the netlist has them.
    fn registers(&self, to: &mut Vec<u64>);
    /// The input and output ports, as the netlist has them.
    fn ports(&self, inputs: &mut Vec<u64>, outputs: &mut Vec<u64>);
}

/// How long an [`Observer`] looks away: as long as the phase stays the same, until a time. Before the machine is ready the time is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Quiet {
    /// The phase.
    pub phase: u8,
    /// The first time that is to be looked at again.
    pub until: u64,
}

/// Watches a machine cycle by cycle.
pub trait Observer: Any {
    /// Whether it looks into memories: then [`Observer::peek`] is called before each cycle.
    fn peeks(&self) -> bool {
        false
    }
    /// Looks into the memories.
    fn peek(&mut self, _memories: &mut dyn Memory) {}
    /// A cycle; how long none need be shown.
    fn cycle(&mut self, at: At, seen: &dyn Observed) -> Quiet;
    /// A reset.
    fn reset(&mut self) {}
}

/// See the module's description.
pub trait Dut {
    /// Sends an item or the end of a frame, for as many cycles as that takes.
    ///
    /// # Errors
    /// See [`Failure`].
    ///
    /// # Panics
    /// The item is of another type than those that the machine takes; an assertion in a block does not hold.
    fn send(&mut self, offer: Offer) -> Result<(), Box<Failure>>;
    /// One cycle in which something is offered; whether something is taken in it, or would be.
    ///
    /// # Errors
    /// See [`Failure`].
    ///
    /// # Panics
    /// As [`Dut::send`].
    fn step(&mut self, offer: Offer) -> Result<bool, Box<Failure>>;
    /// Up to `cycles` cycles in which nothing is offered, until as many images as are told have been shown and not
    /// been taken; how many it took.
    ///
    /// # Errors
    /// See [`Failure`].
    ///
    /// # Panics
    /// An assertion in a block does not hold.
    fn run(&mut self, cycles: u64, images: usize) -> Result<u64, Box<Failure>>;
    /// What comes next is the same frame again: see [`Ports::replay`](crate::machine::Ports::replay).
    fn replay(&self) -> bool;
    /// Reset in mid-flight: whatever frame is under way is lost, and the machine clears its memories before it is
    /// ready again. Counts begin anew.
    fn reset(&mut self);
    /// Makes the display take a pixel only in cycles for which `ready` says so.
    fn set_display(&mut self, ready: Box<dyn FnMut(u64) -> bool>);
    /// Gives the outside memory another timing, at power-up. Without effect where the machine has none.
    fn set_timing(&mut self, timing: Box<dyn Timing>);
    /// Shows every cycle from now on to `observer`.
    fn watch(&mut self, observer: Box<dyn Observer>);
    /// The observer back, if there is one.
    fn unwatch(&mut self) -> Option<Box<dyn Observer>>;
    /// Shows the cycle in which the machine was found at fault to the observer, as far as it got; when that was, counted
    /// from the first cycle in which the machine was ready.
    fn show_fault(&mut self) -> u64;
    /// The images that have been shown, in order, each pixel by pixel; they are taken out.
    fn take_images(&mut self) -> Vec<Vec<u32>>;
    /// How many images have been shown and not been taken.
    fn images(&self) -> usize;
    /// What was counted.
    fn tally(&mut self) -> Tally;
    /// Counts from here on. Between two frames, when the image of the one before is complete, nothing is left
    /// of that one but what the memories hold.
    fn count_anew(&mut self);
    /// Edges since power-up.
    fn cycles(&self) -> u64;
    /// Edges since the machine was first ready; 0 before.
    fn time(&self) -> u64;
    /// The number of the phase of the last cycle.
    fn phase(&self) -> u8;
    /// Its phases.
    fn phases(&self) -> &'static [PhaseInfo];
    /// Declares registers and wires.
    fn declare(&self, to: &mut dyn Declare);
    /// Its memories.
    fn memories(&mut self) -> &mut dyn Memory;
    /// Forgets of the registers what is not declared: see [`Sim::forget_undeclared`](pellucid_sim::Sim::forget_undeclared).
    fn forget_undeclared(&mut self);
}
