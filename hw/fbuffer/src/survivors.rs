//! The numbers of the fragments that are left in the F-buffer, in order, where those that are killed are dropped from it
//! (`kill=compact`).
//!
//! ```text
//!                 +-----------+
//!  enters ------->|           |---> next (Stream), place
//!  leaves ------->| Survivors |---> free
//!  first, over -->|           |---> room, full
//!                 +-----------+
//! ```
//! A survivor keeps its number in the play. What a pass leaves lies in the places from 0 on without a gap, and so do these
//! numbers: the next pass passes over fragments until one comes that has the number of the `next` survivor, which is
//! at hand beforehand, a fragment a cycle. So a pass need not know how those before it came to kill; what must hold is that each
//! brings the same fragments in the same order, as without any kill.
//!
//! A pass reads and writes one memory: survivors only become fewer, so that what is written never overtakes what is read.
//!
//! Where the F-buffer lies in outside memory, numbers lie there beside the values, and the next one comes [from there](crate::ahead).
//!
//! The first pass of a window does not know how many will be left. A fragment may `enter` it while there is `room` for it and for all that are
//! on their way; the window is complete once it is `full`.

use crate::window::{COUNT_BITS, Config};
use pellucid_sim::{Block, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, rtl};

/// See the module's description.
pub struct Survivors;

/// The most fragments between the window and the end of the shader.
pub const MOST_ON_THEIR_WAY: u32 = crate::program::MOST_INSTRUCTIONS as u32 + 1;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Survivors of the pass before.
    #[width(cfg.place_bits() + 1)]
    #[exists(!cfg.outside)]
    pub count: u32,
    /// Of these, how many have come in this pass.
    #[width(cfg.place_bits() + 1)]
    #[exists(!cfg.outside)]
    pub read: u32,
    /// Survivors of this pass so far.
    #[width(cfg.place_bits() + 1)]
    pub written: u32,
    /// Fragments of which is not known yet whether they are killed.
    #[width(bits_for(u64::from(MOST_ON_THEIR_WAY)))]
    pub on_their_way: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A fragment goes on to be shaded.
    pub enters: bool,
    /// One leaves the shader.
    pub leaves: bool,
    /// It is left in the F-buffer, and has this number.
    #[with(COUNT_BITS)]
    pub survives: Stream<u32>,
    /// The play is over.
    pub over: bool,
}

/// Outputs of registers, and of what was read.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Moore {
    /// The number of the next survivor of the pass before.
    #[with(COUNT_BITS)]
    pub next: Stream<u32>,
    /// Its place.
    #[width(cfg.place_bits())]
    pub place: u32,
    /// The place of this pass's next survivor.
    #[width(cfg.place_bits())]
    pub free: u32,
    /// There is a place for one more fragment, if none is killed.
    pub room: bool,
    /// There is none, whatever is killed.
    pub full: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// A survivor's number in each place.
    pub numbers: Ram1R1W<u32>,
}

#[rtl(
    output = (),
    check(Survivors, crate::test_util::compacting(2)),
    check(Survivors, Config { outside: true, ..crate::test_util::compacting(2) })
)]
impl Block for Survivors {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Config) -> State {
        State { count: 0, read: 0, written: 0, on_their_way: 0 }
    }

    fn memories(cfg: &Config) -> Mem {
        let places = if cfg.outside { 0 } else { cfg.places() };
        Mem { numbers: Ram1R1W::new(places, COUNT_BITS, 1, ReadDuringWrite::Forbidden) }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        Moore {
            next: Stream { valid: q.read < q.count, payload: m.numbers.q().data },
            place: q.read & (cfg.places() - 1),
            free: q.written & (cfg.places() - 1),
            room: q.written + q.on_their_way < cfg.places(),
            full: q.written == cfg.places(),
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) {
        if i.survives.valid {
            if !cfg.outside {
                m.numbers.write(q.written, i.survives.payload);
            }
            d.written = q.written + 1;
        }
        d.on_their_way = q.on_their_way + u32::from(i.enters) - u32::from(i.leaves);
        if i.over {
            d.written = 0;
        }
        if !cfg.outside {
            if i.enters && q.read < q.count {
                d.read = q.read + 1;
            }
            if i.over {
                d.count = q.written;
                d.read = 0;
            }
            // The memory holds the next number in its read register: it is read when that changes.
            if d.read < d.count && (i.enters || i.over) {
                m.numbers.read(d.read);
            }
        }
    }
}

#[cfg(test)]
mod tests;
