//! What arrays of fragments are made of.

use crate::allocator::AllocatorKind;
use crate::arbiter::{self, Policy};
use crate::cached_table::{self, Cached};
use crate::chains::config::{self as chains, Link, Passes};
use pellucid_machine::Outside;
use pellucid_machine::outside::{self, Table};
use pellucid_machine::pixel::Screen;
use pellucid_sim::{Signals, bits_for, check_range, rtl};

/// The most counters that a word can have.
pub const MAX_LANES: usize = 16;
/// The most bits of a word of counters, or of sums, in outside memory.
pub const OUTSIDE_BITS: u32 = u64::BITS;

/// The arrays' shape. Slots are numbered: those on chip, then those outside.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Counters of a word, and so those that are summed up at once: a power of two, 1..=[`MAX_LANES`]. Where they lie outside it has
    /// no more than fit into [`OUTSIDE_BITS`], and no more than there are sums in as many.
    pub lanes: u32,
    /// Bits of a counter, 1 to 32.
    pub count_bits: u32,
    /// A fragment's slot is found by counting down from the end of its pixel's array; else by counting up from its base.
    pub down: bool,
    /// Counters are summed up in sweeps over memory, each of which doubles how many are in a sum; else in one.
    pub sweeps: bool,
    /// What does not fit into the buffer is stored in a further band; else it is dropped.
    pub bands: bool,
    /// Slots on chip, at least 1.
    pub on_chip: u32,
    /// Further ones in outside memory.
    pub outside: u32,
    /// From a read request to outside memory to its data, in cycles, at least 1.
    pub outside_latency: u32,
    /// Fragment reads under way at once, at least 2.
    pub reads_in_flight: u32,
    /// Fragments of a pixel that the receiver takes in one pass, at least 1.
    pub depth: u32,
    /// Arrays are all of one length, at most this, and lie one behind the other in the order of the pixels: `down`, `sweeps` and
    /// `bands` mean nothing then. With 0 each is as long as a count found it to be.
    pub fixed: u32,
    /// Counters and sums lie outside, with so much of each on chip; else they lie there as a whole.
    pub cached: Option<Cached>,
    /// Pixels lie outside, too: they are asked for as their fragments are.
    pub pixels_ahead: bool,
}

/// Counters and sums in outside memory, as [`Cached`] asks for them.
#[derive(Clone, Copy, Debug)]
pub struct TablesOutside {
    /// The counters, a word of them in a word.
    pub counters: cached_table::Shape,
    /// The sums, none where arrays are of one length.
    pub sums: Option<cached_table::Shape>,
    /// The arbiter between them and the slots outside, in this order.
    pub arbiter: arbiter::Config,
}

/// Everything that the blocks need to know.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The shape.
    pub shape: Shape,
    /// The slots: sections of one fragment.
    pub fragments: chains::Config,
    /// Counters and sums, where they lie outside.
    pub tables: Option<TablesOutside>,
}

/// Pixels that are stored and read back at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Band {
    /// The first one.
    #[width(if cfg.shape.bands { cfg.band_bits() } else { 0 })]
    pub from: u32,
    /// The one behind the last.
    #[width(cfg.band_bits())]
    pub to: u32,
}

impl Config {
    /// All of that shape.
    ///
    /// # Panics
    /// If a number is outside of its range.
    pub fn new(screen: Screen, shape: Shape) -> Config {
        check_range("the number of lanes of a word of counters", shape.lanes, 1..=MAX_LANES as u32);
        assert!(
            shape.lanes.is_power_of_two(),
            "the number of lanes of a word of counters is {}: expected a power of two",
            shape.lanes
        );
        check_range("the number of bits of a counter", shape.count_bits, 1..=32);
        check_range("the number of slots on chip", shape.on_chip, 1..);
        let fragments = chains::Shape {
            owned: false,
            on_chip: shape.on_chip,
            outside: shape.outside,
            outside_latency: shape.outside_latency,
            capacity: 1,
            link: Link::Tail,
            bitmap: false,
            reads_in_flight: shape.reads_in_flight,
            passes: Passes::Each(shape.depth),
            weight_bits: 0,
            allocator: AllocatorKind::Fifo,
            ssa: None,
            depth_ahead: false,
        };
        let fragments = chains::Config::new(screen, fragments);
        let mut cfg = Config { screen, shape, fragments, tables: None };
        if let Some(cached) = shape.cached {
            let sum_bits = if cfg.is_fixed() { 0 } else { cfg.sum_bits() };
            let lanes = (OUTSIDE_BITS / shape.count_bits.max(sum_bits)).min(shape.lanes);
            cfg.shape.lanes = 1 << lanes.ilog2();
            cfg.tables = Some(cfg.outside_tables(cached));
        }
        cfg
    }

    fn outside_tables(&self, cached: Cached) -> TablesOutside {
        let Shape { lanes, count_bits, reads_in_flight: reads, .. } = self.shape;
        let counters = cached.shape(self.words(), lanes * count_bits, reads);
        let sums = cached.shape(self.words(), lanes * self.sum_bits(), reads);
        let sums = (!self.is_fixed()).then_some(sums);
        let fragments = self.fragments.port();
        let mut clients = vec![counters.words()];
        clients.extend(sums.map(|sums| sums.words()));
        clients.push(fragments);
        let bits = clients.iter().map(|client| client.bits).max().unwrap_or(0);
        let mut words = [0; arbiter::MAX_CLIENTS];
        for (words, client) in words.iter_mut().zip(clients) {
            *words = client.words;
        }
        TablesOutside {
            counters: counters.behind(bits),
            sums: sums.map(|sums| sums.behind(bits)),
            arbiter: arbiter::Config {
                words,
                bits,
                policy: Policy::RoundRobin,
                reads_in_flight: 2 * reads,
            },
        }
    }

    /// Whether arrays are all of one length.
    #[inline]
    pub fn is_fixed(&self) -> bool {
        self.shape.fixed > 0
    }
    /// Whether a pixel can be so deep that how many of its fragments are visible tells how often it is read.
    #[inline]
    pub fn settles(&self) -> bool {
        self.is_fixed() && self.shape.fixed > self.shape.depth
    }
    /// Slots, on chip and outside.
    #[inline]
    pub fn slots(&self) -> u32 {
        self.shape.on_chip + self.shape.outside
    }
    /// The most fragments of a pixel that are counted: a counter says no more, and the buffer holds no more; an array of a
    /// fixed length no more than that.
    #[inline]
    pub fn limit(&self) -> u32 {
        if self.is_fixed() {
            return self.shape.fixed;
        }
        self.slots().min(u32::MAX >> (u32::BITS - self.shape.count_bits))
    }
    /// What stands for every sum that is more than there are slots.
    #[inline]
    pub fn too_many(&self) -> u32 {
        self.slots() + 1
    }
    /// Bits of a sum.
    #[inline]
    pub fn sum_bits(&self) -> u32 {
        bits_for(u64::from(self.too_many()))
    }
    /// Bits of how many fragments a pixel may have.
    pub fn layer_bits(&self) -> u32 {
        bits_for(u64::from(self.limit()))
    }
    /// Words of counters.
    #[inline]
    pub fn words(&self) -> u32 {
        self.screen.pixels().div_ceil(self.shape.lanes)
    }
    /// Bits of a word's number, that behind the last one included.
    #[inline]
    pub fn word_bits(&self) -> u32 {
        bits_for(u64::from(self.words()))
    }
    /// Bits of the number of a word's lane, 0 if there is one.
    #[inline]
    pub fn lane_bits(&self) -> u32 {
        self.shape.lanes.trailing_zeros()
    }
    pub(super) fn count_mask(&self) -> u64 {
        (1 << self.shape.count_bits) - 1
    }
    pub(super) fn sum_mask(&self) -> u64 {
        (1 << self.sum_bits()) - 1
    }
    /// Bits of a border of a band.
    #[inline]
    pub fn band_bits(&self) -> u32 {
        bits_for(u64::from(self.screen.pixels()))
    }
    /// Whether words without a fragment are left out as a band is read back: there is a list of the others. Where counters lie
    /// outside words are looked at one after the other, as they come in lines, and there is no list on chip.
    #[inline]
    pub fn lists(&self) -> bool {
        self.shape.lanes > 1 && !self.caches()
    }
    /// Whether counters and sums lie outside, with caches on chip.
    #[inline]
    pub fn caches(&self) -> bool {
        self.tables.is_some()
    }
    /// The counters, where they lie outside.
    #[inline]
    pub fn counter_table(&self) -> cached_table::Config<Config> {
        cached_table::Config { entry: *self, shape: self.counter_shape() }
    }
    #[inline]
    pub(super) fn counter_shape(&self) -> cached_table::Shape {
        self.tables.map_or(cached_table::Shape::NONE, |tables| tables.counters)
    }
    /// Whether the sums lie outside.
    #[inline]
    pub fn caches_sums(&self) -> bool {
        self.caches() && !self.is_fixed()
    }
    /// The sums, where they lie outside.
    #[inline]
    pub fn sum_table(&self) -> cached_table::Config<Config> {
        cached_table::Config { entry: *self, shape: self.sum_shape() }
    }
    #[inline]
    pub(super) fn sum_shape(&self) -> cached_table::Shape {
        self.tables.and_then(|tables| tables.sums).unwrap_or(cached_table::Shape::NONE)
    }
    /// Fragments that wait for their counters.
    #[inline]
    pub fn fragments_ahead(&self) -> u32 {
        self.tables.map_or(2, |tables| tables.counters.ahead())
    }
    /// Whether several take turns at the port.
    #[inline]
    pub fn shares(&self) -> bool {
        self.caches() && self.arbiter().clients() > 1
    }
    /// The arbiter between counters, sums and the slots outside.
    #[inline]
    pub fn arbiter(&self) -> arbiter::Config {
        self.tables.map_or(arbiter::Config::NONE, |tables| tables.arbiter)
    }
    /// The port to outside memory: to counters, sums and slots, as far as they lie there.
    #[inline]
    pub fn port(&self) -> outside::Config {
        match self.tables {
            Some(TablesOutside { arbiter, .. }) => arbiter.memory(),
            None => self.fragments.port(),
        }
    }
    /// Sweeps that sum up so many words: one, or one each time that their number is doubled.
    pub fn sweeps(&self, words: u32) -> u32 {
        if self.shape.sweeps { words.next_power_of_two().trailing_zeros().max(1) } else { 1 }
    }
    /// The memory behind it.
    pub fn outside_memory(&self) -> Option<Outside> {
        let outside::Config { words, bits } = self.fragments.port();
        let mut tables = vec![];
        if let Some(TablesOutside { counters, sums, .. }) = self.tables {
            tables.push(counters.table("counters.outside"));
            tables.extend(sums.map(|sums| sums.table("sums.outside")));
        }
        if words > 0 {
            tables.push(Table { path: "fragments.outside".to_string(), words, bits });
        }
        let latency = self.shape.outside_latency;
        self.port().exists().then_some(Outside { tables, latency })
    }
}

#[rtl]
impl Config {
    /// Whether a word that was asked for is there. On chip it is in the next cycle.
    #[inline(always)]
    pub fn is_there(&self, valid: bool) -> bool {
        !self.caches() || valid
    }
    /// The word of a pixel's counter.
    #[inline(always)]
    pub fn word_of(&self, pixel: u32) -> u32 {
        pixel >> self.lane_bits()
    }
    /// Its lane in the word.
    #[inline(always)]
    pub fn lane_of(&self, pixel: u32) -> u32 {
        pixel & (self.shape.lanes - 1)
    }
    /// Whether a pixel is one of the band: all are where arrays are of one length.
    #[inline(always)]
    pub fn has(&self, band: Band, pixel: u32) -> bool {
        self.is_fixed() || (pixel >= band.from && pixel < band.to)
    }
    /// Whether a fragment's counter is looked at: as it is counted, or if its pixel is one of the band.
    #[inline(always)]
    pub fn is_asked(&self, counting: bool, band: Band, pixel: u32) -> bool {
        counting || self.has(band, pixel)
    }
    /// Whether a band is the frame's last.
    #[inline(always)]
    pub fn is_last(&self, band: Band) -> bool {
        !self.shape.bands || band.to == self.screen.pixels()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{arrays, screen};

    #[test]
    fn a_counter_says_no_more_than_its_bits_and_the_slots() {
        let limit = |count_bits, on_chip| {
            let shape = Shape { count_bits, on_chip, outside: 0, ..arrays(4, true).shape };
            Config::new(screen(5, 3), shape).limit()
        };
        assert_eq!([limit(1, 9), limit(3, 9), limit(4, 9), limit(32, 9)], [1, 7, 9, 9]);
    }

    #[test]
    fn sweeps_double_what_is_in_a_sum() {
        let mut cfg = arrays(1, true);
        assert_eq!(cfg.sweeps(1000), 1);
        cfg.shape.sweeps = true;
        let sweeps = [1, 2, 3, 4, 5, 8, 9, 307_200].map(|words| cfg.sweeps(words));
        assert_eq!(sweeps, [1, 1, 2, 2, 3, 3, 4, 19]);
    }

    #[test]
    #[should_panic(
        expected = "the number of lanes of a word of counters is 3: expected a power of two"
    )]
    fn a_word_has_a_power_of_two_of_lanes() {
        Config::new(screen(2, 2), Shape { lanes: 3, ..arrays(4, true).shape });
    }
}
