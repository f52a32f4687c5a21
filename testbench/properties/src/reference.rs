//! What a clocked block is held to: a plain reference that says what to play and judges what is seen.

use pellucid_sim::{Block, Fault, Registers, Signals};
use proptest::strategy::BoxedStrategy;
use std::fmt::{Debug, Display};

/// What must hold, or what is broken and what was seen instead.
pub type Judged<P> = Result<(), (P, String)>;

/// A long random sequence, for what shows only after many steps.
pub struct Long<R: Reference> {
    /// What is fixed while it is played.
    pub setup: BoxedStrategy<R::Setup>,
    /// A step of it. There is no reset among them, which would be the end of what is counted.
    pub step: BoxedStrategy<R::Step>,
    /// How many.
    pub steps: usize,
}

/// The steps of a long sequence, where what is sent sets no bound.
pub const LONG: usize = 100_000;

/// The contract of a kind of blocks. A value of it is a plain model beside a block under the clock.
pub trait Reference: Sized + 'static {
    /// The block.
    type Block: Block<
            Config = Self::Config,
            State: Registers<Config = Self::Config>,
            In: Signals<Config = Self::Config>,
        >;
    /// The block's parameters.
    type Config;
    /// What is fixed while a sequence is played: the block's parameters, and what is sent to it.
    type Setup: Clone + Debug;
    /// What happens in a cycle.
    type Step: Clone + Debug;
    /// What can be broken; shown as a sentence.
    type Property: Copy + Debug + Display + PartialEq;
    /// The outputs that a waveform shows.
    type Outputs: Signals<Config = Self::Config>;
    /// What the block is called in waveforms.
    const NAME: &'static str;

    /// Setups for random sequences.
    fn setups() -> BoxedStrategy<Self::Setup>;
    /// Steps of a random sequence.
    fn steps(setup: &Self::Setup) -> BoxedStrategy<Self::Step>;
    /// Long random sequences, each to be played once.
    fn long() -> Vec<Long<Self>>;
    /// Setups of which every state is looked at, from the smallest on.
    fn small() -> Vec<Self::Setup>;
    /// A setup in words.
    fn told(setup: &Self::Setup) -> String;
    /// The block's parameters.
    fn config(setup: &Self::Setup) -> Self::Config;
    /// The model of a block in reset.
    fn new(setup: &Self::Setup) -> Self;

    /// What is seen in a cycle before the inputs come.
    ///
    /// # Errors
    /// What is broken.
    fn look(&mut self, cycle: u64, seen: &<Self::Block as Block>::Moore) -> Judged<Self::Property>;
    /// The inputs of a step; none if the block is reset instead.
    fn inputs(
        &mut self,
        step: &Self::Step,
        seen: &<Self::Block as Block>::Moore,
    ) -> Option<<Self::Block as Block>::In>;
    /// What came out of a cycle with inputs.
    ///
    /// # Errors
    /// What is broken.
    fn judge(&mut self, _: &<Self::Block as Block>::Out) -> Judged<Self::Property> {
        Ok(())
    }
    /// A memory was misused or a register overflowed. Where that must be, it is the sequence's end.
    ///
    /// # Errors
    /// What is broken.
    fn fault(&mut self, fault: &Fault) -> Judged<Self::Property>;
    /// Behind a sequence, the next step of those that show that nothing is lost; none if that is shown.
    fn rest(&self) -> Option<Self::Step>;

    /// Every step that a search tries in a state.
    fn choices(&self) -> Vec<Self::Step>;
    /// All that the model remembers, for a search.
    fn known(&self, to: &mut Vec<u64>);
    /// What a waveform shows as outputs; the second part is missing where the block was not clocked.
    fn outputs(
        seen: &<Self::Block as Block>::Moore,
        out: Option<&<Self::Block as Block>::Out>,
    ) -> Self::Outputs;
    /// The inputs that it gave last, in words; none where nothing happens.
    fn tell(&self, inputs: &<Self::Block as Block>::In) -> Vec<String>;
}
