//! The ports of a frame buffer in outside memory, and what a machine asks and tells while it blends.

use super::{Config, Pixel};
use pellucid_machine::outside::{self, Request};
use pellucid_machine::pixel::{
    Arrived, COLOUR_BITS, Fragment, Marked, PixelFragment, Screen, Z_BITS,
};
use pellucid_sim::{Read, ReadPort, Signals, Stream, WritePort, rtl};

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments come.
    pub storing: bool,
    /// Fragments in arrival order, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Stream<Marked<Fragment>>,
    /// The receiver of `passed` is ready.
    pub passed_ready: bool,
    /// The frame's last fragment is stored.
    pub stored: bool,
    /// What the machine asks and tells while it resolves.
    #[with(cfg.screen)]
    #[exists(cfg.resolves())]
    pub resolve: Resolve,
    /// What it asks and tells where fragments come again.
    #[with(cfg.screen)]
    #[exists(cfg.revisits())]
    pub revisit: Revisit,
    /// The blender takes a pixel's first fragment.
    #[with(cfg.screen.pixel_bits())]
    #[exists(cfg.resolves())]
    pub colour_read: ReadPort,
    /// Writes a colour, `0xRRGGBB`.
    #[with(cfg.screen.pixel_bits(), COLOUR_BITS)]
    #[exists(cfg.resolves())]
    pub colour_write: WritePort<u32>,
    /// Both banks are being cleared.
    pub clearing: bool,
    /// The pixel that is cleared there, taken where `clear_ready` is high.
    #[with(cfg.screen.pixel_bits())]
    pub clear: Stream<u32>,
    /// The frame in the front bank is complete: it is shown from the next cycle on. Only while not `busy`, and `drained`.
    pub show: bool,
    /// The receiver takes a colour.
    pub image_ready: bool,
    /// What the memory drives.
    #[with(cfg.port())]
    pub memory: outside::In,
}

/// What a machine asks and tells while it resolves, where the frame buffer lies outside.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Resolve {
    /// A pixel that will be used.
    #[with(cfg.pixel_bits())]
    pub ask: Stream<u32>,
    /// The depth at hand is done with.
    pub taken: bool,
    /// Fragments of its pixel will arrive at the sorter.
    pub kept: bool,
    /// A fragment arrives there.
    pub comes: bool,
    /// It is visible.
    pub visible: bool,
    /// It is its pixel's last, in its last pass.
    pub last: bool,
}

/// What a machine asks and tells where fragments come again.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Revisit {
    /// They do.
    pub on: bool,
    /// Fragments, then the end of a pass. As [`passed`](Moore::passed) they go on without a test.
    #[with(*cfg)]
    pub fragment: Stream<Marked<PixelFragment>>,
    /// The pixel at hand is done with.
    pub taken: bool,
    /// What it holds from now on.
    #[with(*cfg)]
    pub write: Stream<Pixel>,
    /// The frame's last one is.
    pub over: bool,
}

/// Whether what arrives may go to the sorter.
#[inline(always)]
#[rtl]
pub fn opens(seen: Resolved, arrived: Stream<Marked<Arrived>>) -> bool {
    seen.open && (seen.there || arrived.payload.end)
}

/// What a machine tells, where what is offered at the sorter is taken there or not.
#[inline(always)]
#[rtl]
pub fn arriving(told: Resolve, arrived: Stream<Marked<Arrived>>, ready: bool) -> Resolve {
    let Marked { end, item } = arrived.payload;
    Resolve {
        ask: told.ask,
        taken: told.taken,
        kept: told.kept,
        comes: arrived.valid && ready && !end,
        visible: item.visible,
        last: item.last && item.last_pass,
    }
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// Transparent fragments in front, in order, then the end of the frame.
    #[with(cfg.screen)]
    pub passed: Stream<Marked<PixelFragment>>,
    /// What the machine sees while it resolves.
    #[exists(cfg.resolves())]
    pub resolve: Resolved,
    /// The pixel of the first of the fragments that came again and are not done with it, once it is there.
    #[with(cfg.screen)]
    #[exists(cfg.revisits())]
    pub pixel: Read<Pixel>,
    /// The depth of the pixel that was asked for first, once it is there.
    #[with(Z_BITS)]
    #[exists(cfg.resolves())]
    pub depth: Read<u32>,
    /// The colour of the pixel whose first fragment the blender took.
    #[with(COLOUR_BITS)]
    #[exists(cfg.resolves())]
    pub colour: Read<u32>,
    /// A pixel that is cleared is taken.
    pub clear_ready: bool,
    /// The image, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Stream<u32>,
    /// A frame is being shown.
    pub busy: bool,
    /// All that was drawn is in memory, or on its way there.
    pub drained: bool,
}

/// What a machine sees while it resolves, where the frame buffer lies outside.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(())]
pub struct Resolved {
    /// A pixel may be asked for.
    pub ready: bool,
    /// Fragments may arrive at the sorter.
    pub open: bool,
    /// The colour of the pixel whose fragments arrive is there.
    pub there: bool,
    /// Fragments may go to the blender.
    pub colour_ready: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What is asked of the memory.
    #[with(cfg.port())]
    pub request: Stream<Request>,
    /// An opaque fragment is drawn.
    pub drawn: bool,
    /// An opaque fragment is hidden.
    pub hidden: bool,
    /// A transparent fragment is hidden on arrival.
    pub culled: bool,
    /// What is told of the cache.
    pub events: Events,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(())]
pub struct Events {
    /// A fragment's pixel is found in the cache, or on its way there.
    pub framebuffer_hit: bool,
    /// A fragment's pixel is not.
    pub framebuffer_miss: bool,
    /// A pixel goes from the cache to memory.
    pub framebuffer_write_back: bool,
}

/// What can be seen of a frame buffer outside in a cycle.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(())]
pub struct Wires {
    /// What happened.
    pub events: Events,
}
