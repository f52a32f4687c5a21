//! The window: counts a play's transparent fragments, gives those of the window their place in the F-buffer, and discards all
//! others before they are shaded.
//!
//! ```text
//!               +--------+
//!  fragment --->|        |---> placed (Stream)
//!  taken <------| Window |---> read (of the place)
//!  play ------->|        |---> counted, end
//!  survivors -->|        |
//!               +--------+<--- advance
//! ```
//! Fragment `n` of a play, counted from 0, is in window `n / S` and has place `n % S`, for a buffer of S places; so it has the same
//! one in each pass. From one that is shaded to the next it takes `fragment_cycles`; one that is discarded takes a cycle, and so
//! does an opaque one, which is drawn in a frame's first play and is not counted. Where places are those of pixels there is one
//! window.
//!
//! Where fragments that are killed leave no gap, a window begins with a fragment's number and ends where [`Survivors`] have no place left;
//! in a pass behind the first one it shades those alone that are left, each with its place among them.
//!
//! Where places lie in outside memory, a fragment waits until what the pass before has left of it is `there`.
//!
//! [`Survivors`]: crate::survivors

use crate::plays::Play;
use crate::survivors;
use pellucid_machine::pixel::{Fragment, MOST_PIXEL_BITS, Marked, Screen, is_opaque};
use pellucid_sim::{Block, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct Window;

/// Bits of how many fragments a play has.
pub const COUNT_BITS: u32 = 32;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// Where a fragment leaves what it knows.
    pub places: Places,
    /// Cycles from a fragment that is shaded to the next, at least 1.
    pub fragment_cycles: u32,
    /// There are windows beyond the first; else what is beyond it is not shaded.
    pub windows: bool,
    /// Fragments that are killed leave their place to others. Each has a place of its own, and there are several passes.
    pub compacts: bool,
    /// Places, which are counted, lie in outside memory.
    pub outside: bool,
}

/// Where a fragment leaves what it knows between two passes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// Nowhere: there is one pass.
    None,
    /// In a place of its own, of 2 to the power of so many, at most 22.
    Counted(u32),
    /// At its pixel.
    Pixel,
}

impl Config {
    /// Fragments have places of their own.
    #[inline]
    pub fn counts(&self) -> bool {
        matches!(self.places, Places::Counted(_))
    }
    /// There are places.
    #[inline]
    pub fn stores(&self) -> bool {
        self.places != Places::None
    }
    /// Bits of a place.
    #[inline]
    pub fn place_bits(&self) -> u32 {
        match self.places {
            Places::None => 0,
            Places::Counted(bits) => bits,
            Places::Pixel => self.screen.pixel_bits(),
        }
    }
    /// Places.
    #[inline]
    pub fn places(&self) -> u32 {
        match self.places {
            Places::None => 0,
            Places::Counted(bits) => 1 << bits,
            Places::Pixel => self.screen.pixels(),
        }
    }
    /// Bits of a window's number, or of that of its first fragment where fragments that are killed leave no gap.
    #[inline]
    pub fn window_bits(&self) -> u32 {
        match self {
            Config { windows: false, .. } => 0,
            Config { compacts: true, .. } => COUNT_BITS,
            _ => COUNT_BITS - self.place_bits(),
        }
    }
}

/// A fragment with its place, by which it is found on chip; that of an opaque one is without meaning.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Placed {
    /// The fragment.
    #[with(cfg.screen)]
    pub fragment: Fragment,
    /// Its place.
    #[width(cfg.place_bits())]
    #[exists(!cfg.compacts && !cfg.outside)]
    pub place: u32,
    /// Its number in the play.
    #[width(COUNT_BITS)]
    #[exists(cfg.compacts)]
    pub number: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// Transparent fragments of the play so far.
    #[width(COUNT_BITS)]
    #[exists(cfg.counts())]
    pub counted: u32,
    /// The number behind the last fragment of the window.
    #[width(COUNT_BITS)]
    #[exists(cfg.compacts)]
    pub end: u32,
    /// Cycles until the next one can be shaded.
    #[width(bits_for(u64::from(cfg.fragment_cycles - 1)))]
    pub pause: u32,
    /// The fragment at hand.
    #[with(*cfg)]
    pub placed: Stream<Marked<Placed>>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments, then the end of the play.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<Fragment>>,
    /// What the play is.
    #[with(*cfg)]
    pub play: Play,
    /// What is left of those that were shaded.
    #[with(*cfg)]
    #[exists(cfg.compacts)]
    pub survivors: survivors::Moore,
    /// What the pass before has left of the next one of the window is here, or there is none.
    #[exists(cfg.outside)]
    pub there: bool,
    /// The receiver takes what is at hand.
    pub advance: bool,
    /// The play is over.
    pub over: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Fragments with their places, then the end of the play.
    #[with(*cfg)]
    pub placed: Stream<Marked<Placed>>,
    /// Transparent fragments of the play so far.
    #[width(COUNT_BITS)]
    #[exists(cfg.counts())]
    pub counted: u32,
    /// The number behind the last one of the window.
    #[width(COUNT_BITS)]
    #[exists(cfg.compacts)]
    pub end: u32,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// The fragment is taken.
    pub taken: bool,
    /// Reads what the pass before has left of it.
    #[with(cfg.place_bits())]
    #[exists(cfg.stores())]
    pub read: Stream<u32>,
    /// It goes on to be shaded.
    pub shaded: bool,
    /// It is outside of the window, or was dropped before.
    pub discarded: bool,
}

/// Whether there are fragments behind the window, for the number of windows or of a fragment that it is: where all of the play has
/// gone through.
#[inline(always)]
#[rtl]
pub fn beyond(cfg: &Config, window: u32, of: Moore) -> bool {
    let within = of.counted == 0 || (of.counted.saturating_sub(1) >> cfg.place_bits()) <= window;
    if cfg.compacts { of.end < of.counted } else { cfg.counts() && !within }
}

#[rtl(
    check(Window, crate::test_util::window(2, 1, true)),
    check(Window, crate::test_util::window(3, 3, true)),
    check(Window, crate::test_util::window(2, 1, false)),
    check(Window, crate::test_util::compacting(2)),
    check(Window, Config { places: Places::Pixel, ..crate::test_util::window(2, 1, false) })
)]
impl Block for Window {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        cfg.screen.check();
        check_range("the bits of a place", cfg.place_bits(), ..=MOST_PIXEL_BITS);
        check_range("the number of cycles of a fragment", cfg.fragment_cycles, 1..);
        State { counted: 0, end: 0, pause: 0, placed: Stream::idle() }
    }

    fn memories(_: &Config) {}

    fn moore(_: &Config, q: &State, (): &()) -> Moore {
        Moore { placed: q.placed, counted: q.counted, end: q.end }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let Marked { end, item } = i.fragment.payload;
        let transparent = !end && !is_opaque(item.rgba);
        let mut within = !cfg.counts() || (q.counted >> cfg.place_bits()) == i.play.window;
        let mut waits = false;
        if cfg.compacts {
            let survivors::Moore { next, room, full, .. } = i.survivors;
            within = if i.play.reads {
                next.valid && next.payload == q.counted
            } else {
                q.counted >= i.play.window && !full
            };
            waits = !i.play.reads && !room;
        }
        let shaded = transparent && i.play.shades && within;
        let goes_on = end || shaded || (!transparent && i.play.draws);

        // Where fragments that are killed leave no gap, what is there says whether one is shaded.
        let asks = transparent && i.play.shades && i.play.reads && (within || cfg.compacts);
        let late = cfg.outside && asks && !i.there;

        let passes = i.advance && (!shaded || (q.pause == 0 && !waits));
        let taken = !late && (!goes_on || passes);
        let takes = i.fragment.valid && taken;
        if q.pause > 0 {
            d.pause = q.pause - 1;
        }
        if i.advance {
            d.placed.valid = takes && goes_on;
        }
        let mut place = 0;
        match cfg.places {
            Places::None => {}
            // What lies outside is in the order of the fragments.
            Places::Counted(_) if cfg.outside => {}
            Places::Counted(bits) => place = q.counted & ((1 << bits) - 1),
            Places::Pixel => place = item.y * cfg.screen.width + item.x,
        }
        if cfg.compacts && !cfg.outside {
            place = i.survivors.place;
        }
        if takes && goes_on {
            let placed = Placed { fragment: item, place, number: q.counted };
            d.placed.payload = Marked { end, item: placed };
            if shaded {
                d.pause = cfg.fragment_cycles - 1;
            }
        }
        if takes && transparent && i.play.shades && cfg.counts() {
            d.counted = q.counted + 1;
            if shaded && !i.play.reads {
                d.end = q.counted + 1;
            }
        }
        if i.over {
            d.counted = 0;
        }
        Out {
            taken,
            read: Stream { valid: takes && shaded && i.play.reads, payload: place },
            shaded: takes && shaded,
            discarded: takes && transparent && i.play.shades && !within,
        }
    }
}

#[cfg(test)]
mod tests;
