//! The merging unit: of two opaque pixels the one that is nearer to the viewer.
//!
//! ```text
//!               +-------------+
//!  upstream --->|             |---> merged (Stream)
//!  ready <------| MergingUnit |<--- merged_ready
//!  local ------>|             |---> read, wipe (back local frame buffer)
//!               +-------------+
//! ```
//! Pixels come in raster order, one a cycle. Four cycles later each comes out: in the first the local frame
//! buffer is asked for its pixel, then it gives it, then the depths are compared, then the nearer pixel is
//! chosen; of equal depths the one from upstream. What was read is wiped for the frame after next. A
//! pixel that comes as the unit has to stop waits in a register of its own.

use pellucid_machine::pixel::{COLOUR_BITS, Screen, Z_BITS};
use pellucid_sim::{Block, ReadPort, Signals, Stream, rtl};

/// See the module's description.
pub struct MergingUnit;

/// From a pixel's coming in to its coming out, in cycles.
pub const STAGES: u32 = 4;

/// An opaque pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Opaque {
    /// Its depth, [`Z_FAR`](pellucid_machine::pixel::Z_FAR) where nothing was drawn.
    #[width(Z_BITS)]
    pub z: u32,
    /// Its colour, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// Two pixels of one place.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(())]
pub struct Pair {
    /// They are there.
    pub valid: bool,
    /// The one from upstream.
    pub upstream: Opaque,
    /// The one of the local frame buffer.
    pub local: Opaque,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// What came in while the unit had to stop.
    pub waits: Stream<Opaque>,
    /// The number of the next pixel.
    #[width(cfg.pixel_bits())]
    pub next: u32,
    /// The number of the pixel that the local frame buffer gives.
    #[width(cfg.pixel_bits())]
    pub asked: u32,
    /// First stage: the pixel from upstream for it.
    pub asks: Stream<Opaque>,
    /// Second stage: both pixels.
    pub both: Pair,
    /// Third stage: both pixels.
    pub compared: Pair,
    /// The local one is nearer.
    pub local_is_nearer: bool,
    /// Fourth stage: the nearer one.
    pub nearer: Stream<Opaque>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Pixels in raster order.
    pub upstream: Stream<Opaque>,
    /// The pixel of the local frame buffer that was asked for last.
    pub local: Opaque,
    /// The receiver takes a pixel.
    pub merged_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A pixel is taken.
    pub ready: bool,
    /// The nearer pixels in raster order.
    pub merged: Stream<Opaque>,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Out {
    /// Reads a pixel of the local frame buffer.
    #[with(cfg.pixel_bits())]
    pub read: ReadPort,
    /// Wipes a pixel of it.
    #[with(cfg.pixel_bits())]
    pub wipe: Stream<u32>,
}

#[rtl(moore = (), check(MergingUnit, crate::test_util::screen(3, 2)))]
impl Block for MergingUnit {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Screen) -> State {
        cfg.check();
        State {
            waits: Stream::idle(),
            next: 0,
            asked: 0,
            asks: Stream::idle(),
            both: Pair::default(),
            compared: Pair::default(),
            local_is_nearer: false,
            nearer: Stream::idle(),
        }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, q: &State, (): &()) -> Moore {
        Moore { ready: !q.waits.valid, merged: q.nearer }
    }

    fn next(cfg: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let mut read = ReadPort::default();
        let mut wipe = Stream::idle();
        let comes = if q.waits.valid { q.waits } else { i.upstream };
        if q.nearer.valid && !i.merged_ready {
            d.waits = comes;
        } else {
            d.waits.valid = false;

            if comes.valid {
                read.read(q.next);
                d.asked = q.next;
                d.next = if q.next + 1 == cfg.pixels() { 0 } else { q.next + 1 };
            }
            d.asks = comes;

            if q.asks.valid {
                wipe = Stream::offer(q.asked);
            }
            d.both = Pair { valid: q.asks.valid, upstream: q.asks.payload, local: i.local };

            d.compared = q.both;
            d.local_is_nearer = q.both.local.z < q.both.upstream.z;

            let Pair { valid, upstream, local } = q.compared;
            d.nearer = Stream { valid, payload: if q.local_is_nearer { local } else { upstream } };
        }
        Out { read, wipe }
    }
}

#[cfg(test)]
mod tests;
