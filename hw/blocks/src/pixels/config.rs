//! The shape of the depths and colours of pixels in outside memory.

use super::fetch;
use crate::arbiter::{self, Policy};
use crate::cached_table::{self, Cached};
use pellucid_machine::outside::{self, Table};
use pellucid_machine::pixel::{COLOUR_BITS, Screen, Z_BITS};
use pellucid_sim::fifo;

/// Colours that wait for memory while further ones may come.
pub(super) const WAITING: u32 = 8;

/// When transparent fragments are blended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blends {
    /// Once all of the frame are stored, pixel by pixel.
    Resolved,
    /// As they come.
    Coming,
    /// Once all are stored, fragment by fragment, and those of a pixel come again and again.
    Revisiting,
}

/// Everything that the blocks need to know.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// A bank, with the cache that fragments find their pixels in.
    pub table: cached_table::Shape,
    /// Reads under way at once, of those that are to be blended and of those that are shown; at least 2.
    pub reads_in_flight: u32,
    /// The most pixels between where fragments arrive and where the colour that comes of them is written.
    pub blended: u32,
    /// What is resolved is compared with its pixel's depth; else it needs the colour alone.
    pub depths: bool,
    /// When transparent fragments are blended.
    pub blends: Blends,
}

impl Config {
    /// What is named where depth and colour are on chip.
    pub const NONE: Config = Config {
        screen: Screen { width: 1, height: 1, background: 0 },
        table: cached_table::Shape::NONE,
        reads_in_flight: 2,
        blended: 1,
        depths: true,
        blends: Blends::Resolved,
    };

    /// With so much on chip. The port is that of both banks alone; see [`Config::behind`].
    pub fn new(screen: Screen, cached: Cached, reads_in_flight: u32, blended: u32) -> Config {
        let table = cached.shape(screen.pixels(), Z_BITS + COLOUR_BITS, reads_in_flight).flushed();
        Config { screen, table, reads_in_flight, blended, depths: true, blends: Blends::Resolved }
    }
    /// The same behind a port with words of `bits` bits, as many as a pixel has at least.
    #[must_use]
    pub fn behind(mut self, bits: u32) -> Config {
        self.table = self.table.behind(bits);
        self
    }
    /// The same where what is resolved is known to be visible, so that it needs no depth.
    #[must_use]
    pub fn without_depths(mut self) -> Config {
        self.depths = false;
        self
    }
    /// The same where transparent fragments are blended at that time.
    #[must_use]
    pub fn blending(mut self, blends: Blends) -> Config {
        self.blends = blends;
        self
    }
    /// Pixels are resolved, each once.
    #[inline]
    pub fn resolves(&self) -> bool {
        self.blends == Blends::Resolved
    }
    /// Fragments are blended as they come.
    #[inline]
    pub fn composes(&self) -> bool {
        self.blends == Blends::Coming
    }
    /// Fragments come again to be blended.
    #[inline]
    pub fn revisits(&self) -> bool {
        self.blends == Blends::Revisiting
    }
    /// What is read of it to be resolved.
    #[inline]
    pub(super) fn resolved(&self) -> fetch::Config {
        fetch::Config { pixels: *self, depths: self.depths }
    }
    /// What is read of it to be shown.
    #[inline]
    pub(super) fn shown(&self) -> fetch::Config {
        fetch::Config { pixels: *self, depths: false }
    }
    /// The port: both banks.
    pub fn port(&self) -> outside::Config {
        self.arbiter().memory()
    }
    /// Both banks as a part of outside memory, that is called `path`.
    pub fn memory(&self, path: &str) -> Table {
        let Table { path, words, bits } = self.table.table(path);
        Table { path, words: 2 * words, bits }
    }
    /// Words that are cleared after a reset: all lines of both banks that have a pixel.
    pub fn cleared(&self) -> u32 {
        2 * (self.table.entries + self.table.padding())
    }
    /// A bank.
    #[inline]
    pub fn bank(&self) -> outside::Config {
        self.table.cache.port
    }
    /// Who draws and who shows take turns: the front bank lies first, then the back bank.
    #[inline]
    pub fn arbiter(&self) -> arbiter::Config {
        let outside::Config { words, bits } = self.bank();
        arbiter::Config {
            words: [words, words, 0, 0],
            bits,
            policy: Policy::RoundRobin,
            reads_in_flight: 2 * (self.reads_in_flight + self.table.cache.line),
        }
    }
    /// The table of a bank.
    #[inline]
    pub fn cached(&self) -> cached_table::Config<Screen> {
        cached_table::Config { entry: self.screen, shape: self.table }
    }
    /// Fragments that wait for their pixel: as many as the cache may have been asked for.
    #[inline]
    pub(super) fn waiting(&self) -> fifo::Config<Screen> {
        fifo::Config { depth: self.table.ahead(), item: self.screen }
    }
    /// Those of which is kept whether their pixel holds something, until they are done with it.
    #[inline]
    pub(super) fn firsts(&self) -> fifo::Config<()> {
        fifo::Config { depth: self.table.ahead(), item: () }
    }
    /// Pixels whose fragments will arrive: as many as there may be fragments on their way, so that none waits for another.
    #[inline]
    pub(super) fn coming(&self) -> fifo::Config<u32> {
        fifo::Config { depth: self.reads_in_flight + 4, item: COLOUR_BITS }
    }
    /// Those of which one has.
    #[inline]
    pub(super) fn sorted(&self) -> fifo::Config<u32> {
        fifo::Config { depth: self.blended, item: COLOUR_BITS }
    }
    /// Colours that wait for memory: some, and all that may come.
    #[inline]
    pub(super) fn writes(&self) -> fifo::Config<Screen> {
        fifo::Config { depth: WAITING + self.blended, item: self.screen }
    }
}
