//! The machine's port where fragments and frame buffer may both lie in outside memory: they take turns there.
//!
//! ```text
//!  fragments: request --->+------------+
//!  pixels: request ------>| SharedPort |---> request (Stream)
//!                         |            |<--- memory (ready, response)
//!                         +------------+
//! ```
//! Words of fragments lie first, those of pixels behind them. What either sees of the port, which [`fragments`] and [`pixels`] give,
//! is a memory of its own. An [`Arbiter`] is there where both are; else whoever is there has the port.

use crate::arbiter::{self, Arbiter, Policy};
use pellucid_machine::outside::{self, Request, Wires};
use pellucid_sim::{Block, Memory, Optional, Signals, Stream, rtl};

/// See the module's description.
pub struct SharedPort;

type Turns = Arbiter;

/// Who has words behind the port.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The port of whoever keeps fragments; none where all are on chip.
    pub fragments: outside::Config,
    /// That of the frame buffer, with words as the port's.
    pub pixels: outside::Config,
    /// Reads under way at once.
    pub reads_in_flight: u32,
}

impl Config {
    /// Fragments and pixels, of words of so many bits, behind a port with words for both.
    pub fn new(
        fragments: outside::Config,
        pixels: outside::Config,
        reads_in_flight: u32,
    ) -> Config {
        let pixels = outside::Config { bits: pixels.bits.max(fragments.bits), ..pixels };
        Config { fragments, pixels, reads_in_flight }
    }
    /// The port.
    #[inline]
    pub fn memory(&self) -> outside::Config {
        let words = self.fragments.words + self.pixels.words;
        outside::Config { words, bits: self.pixels.bits }
    }
    /// Whether both have words there.
    #[inline]
    pub fn shares(&self) -> bool {
        self.fragments.exists() && self.pixels.exists()
    }
    /// The arbiter between them.
    pub fn arbiter(&self) -> arbiter::Config {
        if !self.shares() {
            return arbiter::Config::NONE;
        }
        arbiter::Config {
            words: [self.fragments.words, self.pixels.words, 0, 0],
            bits: self.pixels.bits,
            policy: Policy::RoundRobin,
            reads_in_flight: self.reads_in_flight,
        }
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Whose turn it is.
    #[with(cfg.arbiter())]
    #[exists(cfg.shares())]
    #[block(Turns, cfg.arbiter())]
    pub turns: arbiter::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Whose answers come.
    #[block(Turns, cfg.arbiter())]
    #[exists(cfg.shares())]
    pub turns: Optional<arbiter::Mem>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// What is asked of fragments.
    #[with(cfg.fragments)]
    #[exists(cfg.fragments.exists())]
    pub fragments: Stream<Request>,
    /// What is asked of pixels.
    #[with(cfg.pixels)]
    #[exists(cfg.pixels.exists())]
    pub pixels: Stream<Request>,
    /// What the memory drives.
    #[with(cfg.memory())]
    #[exists(cfg.memory().exists())]
    pub memory: outside::In,
}

/// What is seen before the inputs are known.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Whose turn it is.
    #[with(cfg.arbiter())]
    #[exists(cfg.shares())]
    pub turns: arbiter::Moore,
}

/// What those who keep fragments see of the port.
#[inline(always)]
#[rtl]
pub fn fragments(cfg: &Config, seen: Moore, memory: outside::In) -> outside::In {
    let mut port = memory;
    if cfg.shares() {
        port = arbiter::client(&0, seen.turns, memory);
        port.response.payload = outside::cut(&cfg.fragments, port.response.payload);
    } else if cfg.pixels.exists() {
        port = outside::In::default();
    }
    port
}

/// What the frame buffer sees of it.
#[inline(always)]
#[rtl]
pub fn pixels(cfg: &Config, seen: Moore, memory: outside::In) -> outside::In {
    let mut port = memory;
    if cfg.shares() {
        port = arbiter::client(&1, seen.turns, memory);
    }
    port
}

#[rtl(
    output = cfg.memory(),
    check(SharedPort, tests::config(9, 7)),
    check(SharedPort, tests::config(0, 7)),
    check(SharedPort, tests::config(9, 0))
)]
impl Block for SharedPort {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Wires;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let mut turns = arbiter::Moore::default();
        if cfg.shares() {
            turns = Turns::moore(&cfg.arbiter(), &q.turns, &m.turns);
        }
        Moore { turns }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Wires {
        let mut request = i.fragments;
        if cfg.shares() {
            let to_turns = arbiter::In {
                request: [i.fragments, i.pixels, Stream::idle(), Stream::idle()],
                memory: i.memory,
            };
            request =
                Turns::next(&cfg.arbiter(), &q.turns, &mut d.turns, &mut m.turns, to_turns).request;
        } else if cfg.pixels.exists() {
            request = i.pixels;
        }
        // What was asked for always finds room.
        Wires { request: request.with(i.memory.ready), response: i.memory.response.with(true) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Words of 40 bits of fragments, and of 48 of pixels.
    pub(super) fn config(fragments: u32, pixels: u32) -> Config {
        let port = |words, bits| match words {
            0 => outside::Config::NONE,
            _ => outside::Config { words, bits },
        };
        Config::new(port(fragments, 40), port(pixels, 48), 3)
    }
}
