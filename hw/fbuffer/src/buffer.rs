//! The F-buffer on chip: a word for each place, with what a pass has left of the fragment there.
//!
//! ```text
//!               +--------+
//!  read ------->|        |---> values
//!  write ------>| Buffer |
//!               +--------+
//! ```
//! A read and a write a cycle. One buffer is input and output of a pass at once: a fragment's place is read before it is
//! written, and no other fragment of the pass has it. Where places are those of pixels that does not hold: there are two buffers
//! then, which are output in turns.

use crate::shader::{Config, Values};
use crate::window::Places;
use pellucid_sim::{Block, Memory, Ram1R1W, Read, ReadDuringWrite, Signals, Stream, rtl};

/// See the module's description.
pub struct Buffer;

/// Registers: none.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct State {}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Reads a place.
    #[with(cfg.window.place_bits())]
    pub read: Stream<u32>,
    /// Writes one.
    #[with(cfg.window.place_bits())]
    pub write: Stream<u32>,
    /// What is written.
    #[with(*cfg)]
    pub values: Values,
    /// The second buffer is output, the first one input.
    #[exists(cfg.window.places == Places::Pixel)]
    pub second: bool,
}

/// Outputs of read data.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// What was asked for.
    #[with(*cfg)]
    pub values: Read<Values>,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// A word for each place.
    pub words: Ram1R1W<Values>,
}

#[rtl(check(Buffer, crate::test_util::shader("glass", 2, 16)))]
impl Block for Buffer {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) -> State {
        State {}
    }

    fn memories(cfg: &Config) -> Mem {
        Mem { words: Ram1R1W::new(cfg.words(), *cfg, 1, ReadDuringWrite::Forbidden) }
    }

    fn moore(_: &Config, _: &State, m: &Mem) -> Moore {
        Moore { values: m.words.q() }
    }

    fn next(cfg: &Config, _: &State, _: &mut State, m: &mut Mem, i: In) {
        let (mut from, mut to) = (i.read.payload, i.write.payload);
        if cfg.window.places == Places::Pixel {
            // Both buffers, word by word.
            from = i.read.payload << 1 | u32::from(!i.second);
            to = i.write.payload << 1 | u32::from(i.second);
        }
        if i.read.valid {
            m.words.read(from);
        }
        if i.write.valid {
            m.words.write(to, i.values);
        }
    }
}
