//! What the chains of sections are made of.

use super::release;
use super::tables::Word;
use crate::allocator::{self, AllocatorKind, Choice};
use crate::arbiter::{self, Policy};
use crate::cached_table::{self, Cached};
use pellucid_machine::Outside;
use pellucid_machine::choice;
use pellucid_machine::outside::{self, Table};
use pellucid_machine::pixel::Screen;
use pellucid_sim::{bits_for, check_range};

choice! {
    /// How resolve finds the pixels that have fragments.
    pub enum Scan {
        /// It looks at every pixel (seed 000).
        Linear = "linear",
        /// An occupancy bitmap and its summary skip empty pixels, words at a time.
        Bitmap = "bitmap",
    }
}

/// Where a section that a pixel needs goes in its chain, and what its SSA entry keeps for that.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Link {
    /// Behind the last one. The entry has the first one, and a store walks the chain.
    Walk,
    /// Behind the last one. The entry has the last one too, and how full that is.
    Tail,
    /// Before the first one. The entry has the first one and how full that is, so that a chain goes from the newest section to
    /// the oldest, and is read from its newest fragment to its oldest. Sections are counted out, and all given back at once.
    Head,
}

/// The chains' shape. Sections are numbered: those that pixels own, then the free ones on chip, then those
/// outside.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    /// Each pixel owns a section from the start: pixel `i` section `i`.
    pub owned: bool,
    /// Sections on chip that any pixel can have.
    pub on_chip: u32,
    /// Further ones in outside memory, used once those on chip are all taken.
    pub outside: u32,
    /// From a read request to outside memory to its data, in cycles, at least 1.
    pub outside_latency: u32,
    /// Fragments that a section holds, at least 1.
    pub capacity: u32,
    /// Where a section that a pixel needs goes in its chain.
    pub link: Link,
    /// An occupancy bitmap finds the pixels that have fragments; else every pixel is visited.
    pub bitmap: bool,
    /// Fragment reads under way at once, at least 2.
    pub reads_in_flight: u32,
    /// How a pixel's fragments are read back.
    pub passes: Passes,
    /// Bits of the weight that is kept beside a fragment, 0 if there is none.
    pub weight_bits: u32,
    /// Which allocator hands out sections.
    pub allocator: AllocatorKind,
    /// The SSA table lies outside, with so much of it on chip; else it lies there as a whole.
    pub ssa: Option<Cached>,
    /// Opaque depths lie outside, too: they are asked for ahead, and come some time later.
    pub depth_ahead: bool,
}

/// How often a pixel's fragments are read back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Passes {
    /// Once, however many there are.
    One,
    /// Once for every so many, at least 1, of those that are visible.
    Each(u32),
    /// As [`Passes::Each`], but from the second time on twice: to load so many, then to compare them with
    /// all.
    Twice(u32),
}

/// Everything that the blocks need to know.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The shape.
    pub shape: Shape,
    /// Sections that pixels own: 0 or one each.
    pub owned: u32,
    /// All sections; as a section number it stands for NULL.
    pub null: u32,
    /// The release queue: room for the sections of one pass, and some on their way.
    pub release: release::Config,
    /// The SSA table, where it lies outside.
    pub ssa: Option<SsaOutside>,
}

/// An SSA table in outside memory, as [`Cached`] asks for it.
#[derive(Clone, Copy, Debug)]
pub struct SsaOutside {
    /// The table, an entry a word.
    pub table: cached_table::Shape,
    /// The arbiter between sections and it, where sections lie outside, too.
    pub arbiter: arbiter::Config,
}

impl Config {
    /// All of that shape.
    ///
    /// # Panics
    /// If a number is outside of its range.
    pub fn new(screen: Screen, shape: Shape) -> Config {
        check_range("the capacity of a section", shape.capacity, 1..);
        check_range("the latency of outside sections", shape.outside_latency, 1..);
        check_range("the number of reads in flight", shape.reads_in_flight, 2..);
        assert!(
            !shape.owned || shape.link == Link::Tail,
            "a pixel that owns a section keeps its tail"
        );
        let owned = if shape.owned { screen.pixels() } else { 0 };
        let null = owned + shape.on_chip + shape.outside;
        let in_pass = match shape.passes {
            Passes::One => 0,
            Passes::Each(depth) | Passes::Twice(depth) => {
                check_range("the number of fragments of a pass", depth, 1..);
                depth.div_ceil(shape.capacity)
            }
        };
        let release = release::Config { depth: in_pass + 4, id_bits: bits_for(u64::from(null)) };
        let mut cfg = Config { screen, shape, owned, null, release, ssa: None };
        cfg.ssa = shape.ssa.map(|cached| cfg.ssa_outside(cached));
        cfg
    }

    /// The SSA table outside.
    fn ssa_outside(&self, cached: Cached) -> SsaOutside {
        let fill = if self.keeps_fill() { self.fill_bits() } else { 0 };
        let entry_bits = self.head_bits() + self.tail_bits() + fill;
        let (sections, reads) = (self.section_words(), self.shape.reads_in_flight);
        let bits = entry_bits.max(sections.bits);
        let table = cached.shape(self.screen.pixels(), entry_bits, reads).behind(bits);
        let words = [sections.words.max(1), table.words().words, 0, 0];
        let arbiter =
            arbiter::Config { words, bits, policy: Policy::RoundRobin, reads_in_flight: 2 * reads };
        SsaOutside { table, arbiter }
    }

    /// Bits of a section number, NULL included.
    #[inline]
    pub fn id_bits(&self) -> u32 {
        bits_for(u64::from(self.null))
    }
    /// Bits of how full a section is, 0..=capacity.
    #[inline]
    pub fn fill_bits(&self) -> u32 {
        bits_for(u64::from(self.shape.capacity))
    }
    /// Bits of a fragment's place in a section.
    #[inline]
    pub fn slot_bits(&self) -> u32 {
        bits_for(u64::from(self.shape.capacity - 1))
    }
    /// Bits of how many fragments a pixel may have.
    pub fn layer_bits(&self) -> u32 {
        let free = u64::from(self.null - self.owned) + u64::from(self.shape.owned);
        bits_for(free * u64::from(self.shape.capacity))
    }
    /// All section numbers, NULL included, as the ports of an allocator have them.
    #[inline]
    pub fn section_numbers(&self) -> allocator::Config {
        allocator::Config { sections: self.null + 1 }
    }
    /// The allocator of the sections on chip.
    #[inline]
    pub fn on_chip<C: From<Choice>>(&self) -> C {
        self.choice(self.shape.on_chip)
    }
    /// The allocator of the sections outside.
    #[inline]
    pub fn outside<C: From<Choice>>(&self) -> C {
        self.choice(self.shape.outside)
    }
    #[inline]
    fn choice<C: From<Choice>>(&self, sections: u32) -> C {
        let numbers = allocator::Config { sections };
        Choice { kind: self.shape.allocator, numbers }.into()
    }
    /// Whether the weights are kept in memory, so that each fragment that comes is compared with those of its pixel.
    #[inline]
    pub fn weighs(&self) -> bool {
        self.shape.weight_bits > 0
    }
    /// Whether the NSA table lends the entries of free sections to the allocator, and has a second port for
    /// that: an allocator of one's own that asks for them is built with [`AllocatorKind::Threaded`].
    #[inline]
    pub fn lends(&self) -> bool {
        self.shape.allocator == AllocatorKind::Threaded
    }
    /// Whether SSA entries have a chain's last section.
    #[inline]
    pub fn keeps_tail(&self) -> bool {
        self.shape.link == Link::Tail
    }
    /// Whether they have how full the section is into which the pixel's next fragment goes. In all others fragments fill
    /// every slot.
    #[inline]
    pub fn keeps_fill(&self) -> bool {
        self.shape.link != Link::Walk
    }
    /// Whether a chain is read from its newest fragment to its oldest.
    #[inline]
    pub fn newest_first(&self) -> bool {
        self.shape.link == Link::Head
    }
    /// Whether sections are counted out, and all given back at once.
    #[inline]
    pub fn counts_out(&self) -> bool {
        self.shape.link == Link::Head
    }
    /// Bits of an SSA entry's first section.
    #[inline]
    pub fn head_bits(&self) -> u32 {
        if self.shape.owned { 0 } else { self.id_bits() }
    }
    /// Bits of its last section.
    #[inline]
    pub fn tail_bits(&self) -> u32 {
        if self.keeps_tail() { self.id_bits() } else { 0 }
    }
    /// Whether the SSA table lies outside, with a cache on chip.
    #[inline]
    pub fn caches_ssa(&self) -> bool {
        self.ssa.is_some()
    }
    /// Pixels that wait for their SSA entry or their depth.
    #[inline]
    pub fn pixels_ahead(&self) -> u32 {
        // As many as the cache may have been asked for, or depths.
        let depths = if self.shape.depth_ahead { self.shape.reads_in_flight + 2 } else { 2 };
        self.ssa.map_or(depths, |ssa| ssa.table.ahead().max(depths))
    }
    /// Fragments in outside memory.
    #[inline]
    pub fn fragments_outside(&self) -> u32 {
        self.shape.outside * self.shape.capacity
    }
    /// The port to outside memory: to the sections there, a fragment a word, and to the SSA table behind them if it lies there,
    /// an entry a word.
    #[inline]
    pub fn port(&self) -> outside::Config {
        let tables = [self.section_words(), self.ssa_words()];
        outside::Config {
            words: tables.iter().map(|port| port.words).sum(),
            bits: tables.iter().map(|port| port.bits).max().unwrap_or(0),
        }
    }
    /// The memory behind it.
    pub fn outside_memory(&self) -> Option<Outside> {
        let latency = self.shape.outside_latency;
        let tables =
            [("sections.outside", self.section_words()), ("ssa.outside", self.ssa_words())];
        let tables = tables.into_iter().filter(|(_, port)| port.exists());
        let table = |(path, outside::Config { words, bits }): (&str, _)| Table {
            path: path.to_string(),
            words,
            bits,
        };
        self.port().exists().then(|| Outside { tables: tables.map(table).collect(), latency })
    }
    /// The part of it that the sections have.
    #[inline]
    pub fn section_port(&self) -> outside::Config {
        outside::Config { words: self.fragments_outside(), ..self.port() }
    }
    /// The SSA table, where it lies outside.
    #[inline]
    pub fn ssa_table(&self) -> cached_table::Config<Config> {
        cached_table::Config { entry: *self, shape: self.ssa_shape() }
    }
    #[inline]
    pub(super) fn ssa_shape(&self) -> cached_table::Shape {
        self.ssa.map_or(cached_table::Shape::NONE, |ssa| ssa.table)
    }
    /// Whether sections and the SSA table take turns at the port.
    #[inline]
    pub fn shares(&self) -> bool {
        self.fragments_outside() > 0 && self.caches_ssa()
    }
    /// The arbiter between sections and the SSA table.
    #[inline]
    pub fn arbiter(&self) -> arbiter::Config {
        self.ssa.map_or(arbiter::Config::NONE, |ssa| ssa.arbiter)
    }
    pub(super) fn head_mask(&self) -> u64 {
        (1 << self.head_bits()) - 1
    }
    pub(super) fn tail_mask(&self) -> u64 {
        (1 << self.tail_bits()) - 1
    }
    pub(super) fn fill_mask(&self) -> u64 {
        if self.keeps_fill() { (1 << self.fill_bits()) - 1 } else { 0 }
    }
    fn section_words(&self) -> outside::Config {
        match self.fragments_outside() {
            0 => outside::Config::NONE,
            words => outside::Config { words, bits: Word::bits(self) },
        }
    }
    fn ssa_words(&self) -> outside::Config {
        self.ssa.map_or(outside::Config::NONE, |ssa| ssa.table.words())
    }
    /// The first section outside.
    #[inline]
    pub fn first_outside(&self) -> u32 {
        self.owned + self.shape.on_chip
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{screen, shape};

    #[test]
    fn null_is_a_section_number_too() {
        for (on_chip, bits) in [(1, 1), (2, 2), (3, 2), (4, 3), (7, 3), (8, 4), (64, 7)] {
            let shape = Shape { on_chip, outside: 0, ..shape() };
            assert_eq!(Config::new(screen(2, 2), shape).id_bits(), bits, "{on_chip} sections");
        }
    }

    #[test]
    #[should_panic(expected = "the capacity of a section is 0: expected at least 1")]
    fn a_section_holds_a_fragment() {
        Config::new(screen(2, 2), Shape { capacity: 0, ..shape() });
    }

    #[test]
    #[should_panic(expected = "the latency of outside sections is 0: expected at least 1")]
    fn outside_memory_answers_later() {
        Config::new(screen(2, 2), Shape { outside_latency: 0, ..shape() });
    }

    #[test]
    #[should_panic(expected = "the number of reads in flight is 1: expected at least 2")]
    fn two_reads_are_in_flight() {
        Config::new(screen(2, 2), Shape { reads_in_flight: 1, ..shape() });
    }

    #[test]
    #[should_panic(expected = "the number of fragments of a pass is 0: expected at least 1")]
    fn a_pass_has_a_fragment() {
        Config::new(screen(2, 2), Shape { passes: Passes::Each(0), ..shape() });
    }
}
