//! Counts pixels in raster order, with the cycles of overhead that follow each scan line.
//!
//! ```text
//!           +--------+
//!  start -->|        |---> pixel (the next is due), row
//!  moves -->| Raster |---> line_done, frame_done
//!           +--------+
//! ```
//! From `start` on a pixel is due, until it `moves`; after a line's last pixel `beta` cycles pass. A frame
//! that never waits takes `(width + beta) * height` cycles.

use pellucid_machine::pixel::Screen;
use pellucid_sim::{Block, Signals, bits_for, rtl};

/// See the module's description.
pub struct Raster;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Cycles of overhead after each scan line.
    pub beta: u32,
}

impl Config {
    fn column_bits(&self) -> u32 {
        bits_for(u64::from(self.screen.width + self.beta - 1))
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// A frame is under way.
    pub runs: bool,
    /// The column; beyond the last one, cycles of overhead.
    #[width(cfg.column_bits())]
    pub column: u32,
    /// The row.
    #[width(cfg.screen.y_bits())]
    pub row: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame begins with the next cycle. Only while none is under way.
    pub start: bool,
    /// The pixel that is due moves.
    pub moves: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A frame is under way.
    pub runs: bool,
    /// A pixel is due.
    pub pixel: bool,
    /// The row.
    #[width(cfg.screen.y_bits())]
    pub row: u32,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// The row's last cycle.
    pub line_done: bool,
    /// The frame's last cycle.
    pub frame_done: bool,
}

#[rtl(
    input = (),
    output = (),
    check(Raster, Config { screen: crate::test_util::screen(3, 2), beta: 0 }),
    check(Raster, Config { screen: crate::test_util::screen(2, 3), beta: 3 })
)]
impl Block for Raster {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        cfg.screen.check();
        State { runs: false, column: 0, row: 0 }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        Moore { runs: q.runs, pixel: q.runs && q.column < cfg.screen.width, row: q.row }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut out = Out::default();
        if i.start {
            d.runs = true;
        }
        if q.runs && (i.moves || q.column >= cfg.screen.width) {
            if q.column + 1 < cfg.screen.width + cfg.beta {
                d.column = q.column + 1;
            } else {
                d.column = 0;
                out.line_done = true;
                if q.row + 1 < cfg.screen.height {
                    d.row = q.row + 1;
                } else {
                    d.row = 0;
                    d.runs = false;
                    out.frame_done = true;
                }
            }
        }
        out
    }
}

#[cfg(test)]
mod tests;
