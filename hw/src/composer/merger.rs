//! The pipelined image merger: merging units in a line, one for each object-order engine, fed with the far
//! plane and the background.
//!
//! ```text
//!            +--------+   +-------------+         +-------------+   +--------+
//!  start --->| Raster |-->| MergingUnit |-> ... ->| MergingUnit |-->| Raster |--> merged (Stream)
//!            +--------+   +-------------+         +-------------+   +--------+
//!                           |         ^             |         ^
//!                      read, wipe   local      read, wipe   local
//! ```
//! An image goes through in raster order, a pixel a cycle, with `beta` cycles of overhead after each scan
//! line. Unless its receiver stalls it, that takes exactly `(width + beta) * height + 4 * engines` cycles.

use super::merging_unit::{self, MergingUnit, Opaque};
use super::raster::{self, Raster};
use crate::pixel::{Screen, Z_FAR};
use pellucid_sim::{Block, Handshake, ReadPort, Signals, Stream, rtl};

/// See the module's description. `N` is the most engines that it can have.
pub struct Merger<const N: usize>;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Merging units, 1..=N.
    pub engines: u32,
    /// The screen, and the overhead of its scan lines.
    pub raster: raster::Config,
}

impl Config {
    fn screen(&self) -> &Screen {
        &self.raster.screen
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State<const N: usize> {
    /// Pixels that enter the line.
    #[with(cfg.raster)]
    pub head: raster::State,
    /// The line.
    #[with(*cfg.screen())]
    #[len(cfg.engines)]
    pub units: [merging_unit::State; N],
    /// Pixels that leave it.
    #[with(cfg.raster)]
    pub tail: raster::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In<const N: usize> {
    /// An image is merged, from the next cycle on. Only while none is.
    pub start: bool,
    /// Of each engine's back local frame buffer, the pixel that was asked for last.
    #[len(cfg.engines)]
    pub local: [Opaque; N],
    /// The receiver takes a pixel.
    pub merged_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// An image is being merged.
    pub busy: bool,
    /// The merged image in raster order.
    pub merged: Stream<Opaque>,
    /// The row of the pixel that is offered.
    #[width(cfg.screen().y_bits())]
    pub row: u32,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out<const N: usize> {
    /// Reads a pixel of an engine's back local frame buffer.
    #[with(cfg.screen().pixel_bits())]
    #[len(cfg.engines)]
    pub read: [ReadPort; N],
    /// Wipes a pixel of it.
    #[with(cfg.screen().pixel_bits())]
    #[len(cfg.engines)]
    pub wipe: [Stream<u32>; N],
    /// The merged image.
    pub merged: Handshake<Opaque>,
    /// A scan line is complete, its overhead included.
    pub line_done: bool,
    /// The image is.
    pub frame_done: bool,
}

#[rtl(
    check(Merger<2>, Config { engines: 1, raster: small(0) }),
    check(Merger<4>, Config { engines: 3, raster: small(2) })
)]
impl<const N: usize> Block for Merger<N> {
    type Config = Config;
    type State = State<N>;
    type In = In<N>;
    type Moore = Moore;
    type Out = Out<N>;
    type Mem = ();

    fn reset(cfg: &Config) -> State<N> {
        State {
            head: Raster::reset(&cfg.raster),
            units: [MergingUnit::reset(cfg.screen()); N],
            tail: Raster::reset(&cfg.raster),
        }
    }

    fn memories(_: &Config) {}

    #[inline(always)]
    fn moore(cfg: &Config, q: &State<N>, (): &()) -> Moore {
        let tail = Raster::moore(&cfg.raster, &q.tail, &());
        let last = MergingUnit::moore(cfg.screen(), &q.units[cfg.engines as usize - 1], &());
        let merged =
            Stream { valid: last.merged.valid && tail.pixel, payload: last.merged.payload };
        Moore { busy: tail.runs, merged, row: tail.row }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State<N>, d: &mut State<N>, (): &mut (), i: In<N>) -> Out<N> {
        let head = Raster::moore(&cfg.raster, &q.head, &());
        let first = MergingUnit::moore(cfg.screen(), &q.units[0], &());
        let to_head = raster::In { start: i.start, moves: head.pixel && first.ready };
        Raster::next(&cfg.raster, &q.head, &mut d.head, &mut (), to_head);

        let tail = Raster::moore(&cfg.raster, &q.tail, &());
        let (mut read, mut wipe) = ([ReadPort::default(); N], [Stream::idle(); N]);
        let far = Opaque { z: Z_FAR, colour: cfg.screen().background };
        let mut upstream = Stream { valid: head.pixel, payload: far };
        for k in 0..cfg.engines as usize {
            let merged_ready = if k + 1 < cfg.engines as usize {
                MergingUnit::moore(cfg.screen(), &q.units[k + 1], &()).ready
            } else {
                tail.pixel && i.merged_ready
            };
            let unit = MergingUnit::moore(cfg.screen(), &q.units[k], &());
            let to_unit = merging_unit::In { upstream, local: i.local[k], merged_ready };
            let asked =
                MergingUnit::next(cfg.screen(), &q.units[k], &mut d.units[k], &mut (), to_unit);
            read[k] = asked.read;
            wipe[k] = asked.wipe;
            upstream = unit.merged;
        }

        let merged = Stream { valid: upstream.valid && tail.pixel, payload: upstream.payload };
        let to_tail = raster::In { start: i.start, moves: merged.valid && i.merged_ready };
        let counted = Raster::next(&cfg.raster, &q.tail, &mut d.tail, &mut (), to_tail);
        Out {
            read,
            wipe,
            merged: merged.with(i.merged_ready),
            line_done: counted.line_done,
            frame_done: counted.frame_done,
        }
    }
}

#[cfg(test)]
fn small(beta: u32) -> raster::Config {
    raster::Config { screen: crate::test_util::screen(3, 2), beta }
}

#[cfg(test)]
mod tests;
