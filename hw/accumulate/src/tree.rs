//! The accumulation tree: frames in, their mean out, merged level by level as a binary counter carries.
//!
//! ```text
//!                +-------+ result +-------+ result       +-------+
//!  frame ------->| Level |------->| Level |-----> ... -->| Level |---> image (pixels)
//!  (pixels)  ^   +-------+   ^    +-------+              +-------+
//!            |               |        |
//!            |   +-----+     |        | schedule=nodes
//!            +---| top |-----+--------+
//!                +-----+
//! ```
//! The planes of all levels are a stack: what is merged last lies below what waits for it. With `schedule=stream` a frame's pixels go
//! through all levels that it completes in one sweep. With `schedule=nodes` each node has a sweep of its own, and what it gives, or a
//! frame that completes a node, waits for that in one more plane, the `top`. Unless such a sweep is under way a pixel comes a cycle.

use crate::colour::{Format, Pixel};
use crate::level::{self, Level};
use pellucid_machine::pixel::Screen;
use pellucid_sim::{
    Block, Memory, Ram1R1W, ReadDuringWrite, Registers, Signals, Stream, bits_for, rtl,
};

/// See the module's description.
pub struct Tree;

/// The most levels: those of 1024 frames in pairs.
pub const MOST_LEVELS: usize = 10;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Each node has a sweep of its own.
    pub sweeps: bool,
    /// Bits of a channel in the planes.
    pub plane_bits: u32,
    /// How many levels there are, none for an image of one frame.
    pub count: u32,
    /// The levels, from that of the frames on.
    pub levels: [level::Config; MOST_LEVELS],
}

impl Config {
    /// The level of that number.
    pub fn level(&self, number: u32) -> &level::Config {
        &self.levels[number as usize]
    }
    /// There is a plane for what is merged next.
    pub fn has_top(&self) -> bool {
        self.sweeps && self.count > 0
    }
    /// Cycles from a pixel of the image being asked for, of a frame or the top, to its going out, at most.
    pub fn latency(&self) -> u32 {
        if self.has_top() { 2 } else { self.count }
    }
    /// Pixels between levels, and of the image.
    pub fn format(&self) -> Format {
        Format { pixel_bits: self.screen.pixel_bits(), channel_bits: self.plane_bits, closes: true }
    }
    fn sweep(&self) -> SweepConfig {
        let exists = self.has_top();
        let level_bits = if exists { bits_for(u64::from(self.count - 1)) } else { 0 };
        let pixel_bits = if exists { self.screen.pixel_bits() } else { 0 };
        SweepConfig { level_bits, pixel_bits, exists }
    }
}

/// Bits of a sweep.
#[derive(Clone, Copy, Debug)]
pub struct SweepConfig {
    level_bits: u32,
    pixel_bits: u32,
    exists: bool,
}

/// A pixel of a node's own sweep.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(SweepConfig)]
pub struct Sweep {
    /// The node's level.
    #[width(cfg.level_bits)]
    pub level: u32,
    /// The pixel.
    #[width(cfg.pixel_bits)]
    pub pixel: u32,
    /// The image ends with it.
    #[exists(cfg.exists)]
    pub closes: bool,
}

/// Registers.
#[derive(Clone, Debug, Registers)]
pub struct State {
    /// The levels.
    #[with(*cfg.level(k as u32))]
    #[len(cfg.count)]
    pub levels: Vec<level::State>,
    /// The pixel that a node's sweep is at.
    #[with(cfg.sweep())]
    #[exists(cfg.has_top())]
    pub sweep: Stream<Sweep>,
    /// The pixel of the top that was asked for.
    #[with(cfg.sweep())]
    #[exists(cfg.has_top())]
    pub fetched: Stream<Sweep>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A pixel of a frame, only while `ready`.
    #[with(cfg.format())]
    pub frame: Stream<Pixel>,
    /// The image can take all that is under way and one more.
    pub image_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// No node's own sweep is under way.
    pub ready: bool,
    /// A pixel is.
    pub busy: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// A pixel of the image; its channels have 8 bits.
    #[with(cfg.format())]
    pub image: Stream<Pixel>,
    /// Levels whose node gives its result.
    #[width(cfg.count)]
    pub merges: u32,
    /// Levels whose node gives the last pixel of it.
    #[width(cfg.count)]
    pub merged: u32,
    /// That node of each level, by number.
    #[width(cfg.level(k as u32).number_bits())]
    #[len(cfg.count)]
    pub nodes: [u32; MOST_LEVELS],
    /// A pixel of the top is read.
    pub sweeps: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The levels.
    pub levels: Vec<level::Mem>,
    /// What is merged next.
    pub top: Ram1R1W<crate::colour::Colour>,
}

#[rtl(
    moore = (),
    check(Tree, crate::test_util::tree(&[2, 4], false, 0)),
    check(Tree, crate::test_util::tree(&[2, 4], true, 0)),
    check(Tree, crate::test_util::tree(&[2, 2, 2], true, 3)),
    check(Tree, crate::test_util::tree(&[], false, 0))
)]
impl Block for Tree {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            levels: (0..cfg.count).map(|k| Level::reset(cfg.level(k))).collect(),
            sweep: Stream::idle(),
            fetched: Stream::idle(),
        }
    }

    fn memories(cfg: &Config) -> Mem {
        let words = if cfg.has_top() { cfg.screen.pixels() } else { 0 };
        Mem {
            levels: (0..cfg.count).map(|k| Level::memories(cfg.level(k))).collect(),
            top: Ram1R1W::new(words, cfg.plane_bits, 1, ReadDuringWrite::Forbidden),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let mut busy = cfg.has_top() && (q.sweep.valid || q.fetched.valid);
        for k in 0..cfg.count {
            let level = Level::moore(cfg.level(k), &q.levels[k as usize], &m.levels[k as usize]);
            busy |= level.result.valid;
        }
        Moore { ready: !(cfg.has_top() && busy), busy }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // What comes to each level from the one below: the frame to the first.
        let mut value = i.frame;
        let (mut merges, mut merged, mut nodes) = (0, 0, [0; MOST_LEVELS]);
        let top = m.top.q().data;
        if cfg.has_top() {
            d.fetched.valid = false;
            if q.sweep.valid && i.image_ready {
                m.top.read(q.sweep.payload.pixel);
                d.fetched = q.sweep;
                d.sweep.payload.pixel = q.sweep.payload.pixel + 1;
                if q.sweep.payload.pixel == cfg.screen.pixels() - 1 {
                    d.sweep = Stream::idle();
                }
            }
        }
        for k in 0..cfg.count {
            let level = Level::moore(cfg.level(k), &q.levels[k as usize], &m.levels[k as usize]);
            let mut comes = value;
            if cfg.has_top() {
                // What completes a node waits for its sweep.
                let Pixel { pixel, closes, colour } = value.payload;
                if value.valid && (level.full || closes) {
                    comes.valid = false;
                    m.top.write(pixel, colour);
                    if pixel == cfg.screen.pixels() - 1 {
                        d.sweep = Stream::offer(Sweep { level: k, pixel: 0, closes });
                    }
                }
                let Sweep { level: of, pixel, closes } = q.fetched.payload;
                if q.fetched.valid && of == k {
                    comes = Stream::offer(Pixel { pixel, closes, colour: top });
                }
            }
            let to_level = level::In { value: comes };
            Level::next(
                cfg.level(k),
                &q.levels[k as usize],
                &mut d.levels[k as usize],
                &mut m.levels[k as usize],
                to_level,
            );
            value = level.result;
            let last = value.payload.pixel == cfg.screen.pixels() - 1;
            nodes[k as usize] = level.node;
            merges |= u32::from(value.valid) << k;
            merged |= u32::from(value.valid && last) << k;
        }
        let sweeps = cfg.has_top() && q.sweep.valid && i.image_ready;
        Out { image: value, merges, merged, nodes, sweeps }
    }
}

#[cfg(test)]
mod tests;
