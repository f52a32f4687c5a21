//! The opaque colours that are to be blended with, from when they were read until the blender asks for them.
//!
//! ```text
//!                      +-------------+
//!  colour (pixels) --->|             |---> ready, open
//!  comes, visible, --->| Destination |
//!  last                |             |<--- pop
//!                      +-------------+---> colour
//! ```
//! A colour comes for each pixel whose fragments will arrive, and waits for these. Of a pixel of which nothing is visible it goes
//! away with the pixel's last fragment; of any other it is kept for the blender, which asks for it (`pop`) with the first
//! fragment that it takes of the pixel, and finds it in the next cycle. Fragments may arrive while it is `open` and the colour of
//! their pixel is `there`.

use super::config::Config;
use pellucid_machine::pixel::COLOUR_BITS;
use pellucid_sim::{Block, Fifo, Memory, Signals, Stream, fifo, rtl};

/// See the module's description.
pub struct Destination;

type Colours = Fifo<u32>;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Colours of pixels whose fragments have not all arrived.
    #[with(cfg.coming().depth)]
    #[block(Colours, cfg.coming())]
    pub coming: fifo::State,
    /// Colours that the blender will ask for.
    #[with(cfg.blended)]
    #[block(Colours, cfg.sorted())]
    pub sorted: fifo::State,
    /// A visible fragment of the pixel at hand has arrived.
    pub seen: bool,
    /// The colour that was asked for.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct In {
    /// The colour of a pixel whose fragments will arrive.
    #[with(COLOUR_BITS)]
    pub push: Stream<u32>,
    /// A fragment arrives.
    pub comes: bool,
    /// It is visible.
    pub visible: bool,
    /// It is its pixel's last, in its last pass.
    pub last: bool,
    /// The blender takes a pixel's first fragment.
    pub pop: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
pub struct Moore {
    /// A colour is taken.
    pub ready: bool,
    /// Fragments may arrive.
    pub open: bool,
    /// The colour of the pixel whose fragments arrive is there.
    pub there: bool,
    /// The colour that was asked for.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Colours of pixels whose fragments have not all arrived.
    #[block(Colours, cfg.coming())]
    pub coming: <Colours as Block>::Mem,
    /// Colours that the blender will ask for.
    #[block(Colours, cfg.sorted())]
    pub sorted: <Colours as Block>::Mem,
}

#[rtl(
    check(Destination, super::tests::config(1, 2)),
    check(Destination, super::tests::config(4, 7))
)]
impl Block for Destination {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        Moore {
            ready: Colours::moore(&cfg.coming(), &q.coming, &m.coming).ready,
            open: Colours::moore(&cfg.sorted(), &q.sorted, &m.sorted).ready,
            there: Colours::moore(&cfg.coming(), &q.coming, &m.coming).count > 0,
            colour: q.colour,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) {
        let colour = Colours::moore(&cfg.coming(), &q.coming, &m.coming).front.payload;
        let kept = Colours::moore(&cfg.sorted(), &q.sorted, &m.sorted).front;
        let first = i.comes && i.visible && !q.seen;
        if i.comes {
            d.seen = (q.seen || i.visible) && !i.last;
        }
        let to_coming = fifo::In { push: i.push, pop: i.comes && i.last };
        Colours::next(&cfg.coming(), &q.coming, &mut d.coming, &mut m.coming, to_coming);
        // A blender that takes fragments as they arrive asks in the same cycle.
        let at_once = i.pop && !kept.valid;
        let push = Stream { valid: first && !at_once, payload: colour };
        let to_sorted = fifo::In { push, pop: i.pop };
        Colours::next(&cfg.sorted(), &q.sorted, &mut d.sorted, &mut m.sorted, to_sorted);
        if i.pop {
            d.colour = if kept.valid { kept.payload } else { colour };
        }
    }
}
