//! The scan-line engine: adds the transparent primitives to the merged opaque image, scan line by scan line.
//!
//! ```text
//!               +------------+   +-------+ columns of +-------+   +--------+   +--------+   +---------+
//!  primitive -->| BucketSort |-->| Sweep |----------->| Sweep |-->| Layers |-->| Sorter |-->| Blender |
//!               +------------+   | down  | a line     | along |   +--------+   +--------+   +---------+
//!                                +-------+            +-------+       ^                          |
//!                                                  +----------+       | opaque                   v
//!  merged ---------------------------------------->|  Lines   |-------+                      +------+
//!                                                  | (LFB_n)  |                              | Fifo |--> result
//!                                                  +----------+                              +------+
//! ```
//! Two sweeps, one down the scan lines and one along a line's pixels. The first gives the primitives that are
//! active in a line, from buckets by first line; each one's columns go into the second, by first column,
//! while it gives those of the line before, pixel by pixel. Both keep the order of arrival. A pixel's
//! fragments are tested against its merged depth, sorted, and blended over its merged colour. A line is
//! begun once all of it has been merged.
//!
//! The buckets of the next frame are filled beside all this.

pub mod bucket_sort;
pub mod layers;

use super::buckets::{self, Insert};
use super::merging_unit::Opaque;
use super::sweep::{self, Sweep};
use bucket_sort::BucketSort;
use layers::{Layers, Segment};
use pellucid_blocks::blender::{self, Blender};
use pellucid_blocks::sorter::{self, Sorter};
use pellucid_machine::pixel::{COLOUR_BITS, Marked, Screen};
use pellucid_machine::primitive::{Format, Primitive, next_row, plus, span, times};
use pellucid_sim::ram::port::written;
use pellucid_sim::{
    Block, Fifo, Memory, Ram1R1W, Read, ReadDuringWrite, Signals, Stream, bits_for, fifo, rtl,
};

/// See the module's description.
pub struct ScanLine;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Which lines are its own, and how many primitives they may have.
    pub bucket_sort: bucket_sort::Config,
    /// Primitives that a line may have, at least 1.
    pub line_primitives: u32,
    /// Fragments that the sorter takes in a pass, 1..=[`sorter::MAX_DEPTH`].
    pub sorter_depth: u32,
}

/// Bits of the number of a pixel whose fragments are blended: its turn tells which it is.
const PIXEL_BITS: u32 = 0;
/// Opaque pixels that are read before they are needed.
const READ_AHEAD: u32 = 3;

impl Config {
    fn screen(&self) -> &Screen {
        &self.bucket_sort.screen
    }
    /// A line as a screen.
    fn line(&self) -> Screen {
        Screen { height: 1, ..*self.screen() }
    }
    fn lines(&self) -> u32 {
        self.bucket_sort.lines()
    }
    fn lines_bits(&self) -> u32 {
        bits_for(u64::from(self.lines()))
    }
    /// Pixels of its lines.
    fn pixels(&self) -> u32 {
        self.lines() * self.screen().width
    }
    fn down(&self) -> buckets::Config<Format> {
        self.bucket_sort.buckets()
    }
    fn along(&self) -> buckets::Config<Screen> {
        let size = buckets::Size { positions: self.screen().width, capacity: self.line_primitives };
        buckets::Config { size, item: self.line() }
    }
    fn layers(&self) -> layers::Config {
        layers::Config {
            line: self.line(),
            sorter_depth: self.sorter_depth,
            layers: self.line_primitives,
        }
    }
    fn sorter(&self) -> sorter::Config {
        sorter::Config {
            depth: self.sorter_depth,
            pixel_bits: PIXEL_BITS,
            layer_bits: bits_for(u64::from(self.line_primitives) + 1),
            newest_first: false,
        }
    }
    fn opaque(&self) -> fifo::Config<()> {
        fifo::Config { depth: READ_AHEAD, item: () }
    }
    fn results(&self) -> fifo::Config<u32> {
        fifo::Config { depth: 2 * self.screen().width, item: COLOUR_BITS }
    }
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`bucket_sort`].
    #[with(cfg.bucket_sort)]
    pub bucket_sort: bucket_sort::State,
    /// Down the lines, see [`sweep`].
    #[with(cfg.down().size)]
    pub down: sweep::State,
    /// Along a line, see [`sweep`].
    #[with(cfg.along().size)]
    pub along: sweep::State,
    /// All primitives of a line have given their columns.
    pub line_filled: bool,
    /// Lines that were begun, to be swept along.
    #[width(cfg.lines_bits())]
    pub begun: u32,
    /// Lines that were merged.
    #[width(cfg.lines_bits())]
    pub merged: u32,
    /// Where the next merged pixel goes.
    #[width(bits_for(u64::from(cfg.pixels() - 1)))]
    pub write: u32,
    /// The merged pixel that is read next.
    #[width(bits_for(u64::from(cfg.pixels() - 1)))]
    pub read: u32,
    /// Pixels of the line that are still to be read.
    #[width(bits_for(u64::from(cfg.screen().width)))]
    pub unread: u32,
    /// A merged pixel was asked for.
    pub asked: bool,
    /// Merged pixels that were read ahead.
    #[with(READ_AHEAD)]
    pub opaque: fifo::State,
    /// See [`mod@layers`].
    #[with(cfg.layers())]
    pub layers: layers::State,
    /// See [`sorter`].
    #[with(cfg.sorter())]
    pub sorter: sorter::State,
    /// See [`blender`].
    #[with(PIXEL_BITS)]
    pub blender: blender::State,
    /// Colours of complete pixels.
    #[with(cfg.results().depth)]
    pub results: fifo::State,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Transparent primitives, then the end of the frame.
    #[with(Format::transparent(*cfg.screen()))]
    pub primitive: Stream<Marked<Primitive>>,
    /// The frame that was sorted is rendered from now on, and the next one may come. Only while `sorted`, and
    /// all results of the frame before are taken.
    pub swap: bool,
    /// Merged pixels of its lines, in raster order; always taken.
    pub merged: Stream<Opaque>,
    /// A line of them is complete.
    pub line_merged: bool,
    /// A result is taken.
    pub result_ready: bool,
    /// A position's lists are emptied, after reset: a line, or a column.
    #[with(cfg.screen().pixel_bits())]
    pub clear: Stream<u32>,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// A primitive is taken.
    pub ready: bool,
    /// The frame's primitives are sorted.
    pub sorted: bool,
    /// Colours of complete pixels in raster order, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub result: Stream<u32>,
    /// Those of a complete line are there.
    pub line_complete: bool,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// A transparent fragment was given for the last time.
    pub fragment: bool,
    /// It is hidden.
    pub hidden: bool,
    /// A fragment is blended: each pixel's opaque one, and transparent ones.
    pub blended: bool,
    /// Columns of a primitive for which there is no place, 0 if there is or none come.
    #[width(bits_for(u64::from(cfg.screen().width)))]
    pub lost: u32,
}

/// The primitive that comes and finds no place in the buckets, if one does.
pub fn lost(cfg: &Config, q: &State) -> Option<Primitive> {
    let insert = BucketSort::moore(&cfg.bucket_sort, &q.bucket_sort, &()).insert;
    let front = &q.down.buckets[usize::from(q.down.second_is_front)];
    (insert.valid && front.filled == cfg.bucket_sort.capacity).then_some(insert.payload.item)
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`sweep`].
    pub down: sweep::Mem<Primitive>,
    /// See [`sweep`].
    pub along: sweep::Mem<Segment>,
    /// The merged pixels of its lines: LFB_n.
    pub lines: Ram1R1W<Opaque>,
    /// Merged pixels that were read ahead.
    pub opaque: <Pixels as Block>::Mem,
    /// Colours of complete pixels.
    pub results: <Results as Block>::Mem,
}

type Down = Sweep<Primitive>;
type Along = Sweep<Segment>;
type Pixels = Fifo<Opaque>;
type Results = Fifo<u32>;

#[rtl(
    check(ScanLine, crate::test_util::scan_line(1, 0)),
    check(ScanLine, crate::test_util::scan_line(3, 1))
)]
impl Block for ScanLine {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            bucket_sort: BucketSort::reset(&cfg.bucket_sort),
            down: Down::reset(&cfg.down()),
            along: Along::reset(&cfg.along()),
            line_filled: false,
            begun: cfg.lines(),
            merged: 0,
            write: 0,
            read: 0,
            unread: 0,
            asked: false,
            opaque: Pixels::reset(&cfg.opaque()),
            layers: Layers::reset(&cfg.layers()),
            sorter: Sorter::reset(&cfg.sorter()),
            blender: Blender::reset(&PIXEL_BITS),
            results: Results::reset(&cfg.results()),
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem {
            down: Down::memories(&cfg.down()),
            along: Along::memories(&cfg.along()),
            lines: Ram1R1W::new(cfg.pixels(), (), 1, ReadDuringWrite::Forbidden),
            opaque: Pixels::memories(&cfg.opaque()),
            results: Results::memories(&cfg.results()),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let sort = BucketSort::moore(&cfg.bucket_sort, &q.bucket_sort, &());
        let results = Results::moore(&cfg.results(), &q.results, &m.results);
        Moore {
            ready: sort.ready,
            sorted: sort.done,
            result: results.front,
            line_complete: results.count >= cfg.screen().width,
        }
    }

    // It is so much code that one copy of it is enough.
    #[inline(never)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        let width = cfg.screen().width;
        let sort = BucketSort::moore(&cfg.bucket_sort, &q.bucket_sort, &());
        let down = Down::moore(&cfg.down(), &q.down, &m.down);
        let along = Along::moore(&cfg.along(), &q.along, &m.along);
        let opaque = Pixels::moore(&cfg.opaque(), &q.opaque, &m.opaque);
        let sorter = Sorter::moore(&cfg.sorter(), &q.sorter, &());
        let results = Results::moore(&cfg.results(), &q.results, &m.results);

        // Primitives by their first line.
        let to_sort = bucket_sort::In { primitive: i.primitive, restart: i.swap };
        BucketSort::next(&cfg.bucket_sort, &q.bucket_sort, &mut d.bucket_sort, &mut (), to_sort);

        // The line that was filled is begun once it is merged and the one before is complete.
        let begins = q.line_filled && !along.runs && q.begun < q.merged;

        // Of each primitive of a line its columns.
        let fills = down.open && !q.line_filled;
        let primitive = down.item.payload;
        let columns = span(primitive.edges, width);
        let Primitive { at, per_column, label, .. } = primitive;
        let at = plus(at, times(per_column, columns.first));
        let item = Segment { last: columns.last, at, per_column, label };
        let insert = Stream {
            valid: fills && down.item.valid && !columns.empty,
            payload: Insert { position: columns.first, item },
        };
        let filled = fills && down.count <= 1;
        d.line_filled = (q.line_filled && !begins) || filled;
        let to_down = sweep::In {
            insert: sort.insert,
            swap: i.swap,
            take: fills && down.item.valid,
            back: Stream {
                valid: primitive.row < primitive.last_row,
                payload: next_row(primitive),
            },
            next: filled,
            clear: Stream {
                valid: i.clear.valid && i.clear.payload < cfg.lines(),
                payload: i.clear.payload,
            },
        };
        Down::next(&cfg.down(), &q.down, &mut d.down, &mut m.down, to_down);

        // Merged pixels, written as they come and read ahead in a line that is begun.
        if i.merged.valid {
            m.lines.write(q.write, i.merged.payload);
            d.write = if q.write + 1 == cfg.pixels() { 0 } else { q.write + 1 };
        }
        let asks = q.unread > 0 && opaque.count + u32::from(q.asked) < READ_AHEAD;
        d.asked = asks;
        if asks {
            m.lines.read(q.read);
            d.read = if q.read + 1 == cfg.pixels() { 0 } else { q.read + 1 };
            d.unread = q.unread - 1;
        }
        if begins {
            d.unread = width;
            d.begun = q.begun + 1;
        }
        if i.line_merged {
            d.merged = q.merged + 1;
        }
        if i.swap {
            d.begun = 0;
            d.merged = 0;
        }

        // Pixel by pixel.
        let to_layers = layers::In {
            opaque: opaque.front,
            open: along.open,
            count: along.count,
            item: along.item,
            arrived_ready: sorter.ready,
        };
        let layers = Layers::next(&cfg.layers(), &q.layers, &mut d.layers, &mut (), to_layers);
        let to_along = sweep::In {
            insert,
            swap: begins,
            take: layers.take,
            back: layers.back,
            next: layers.next,
            clear: Stream {
                valid: i.clear.valid && i.clear.payload < width,
                payload: i.clear.payload,
            },
        };
        Along::next(&cfg.along(), &q.along, &mut d.along, &mut m.along, to_along);
        let to_opaque = fifo::In {
            push: Stream { valid: q.asked, payload: m.lines.q().data },
            pop: layers.next,
        };
        Pixels::next(&cfg.opaque(), &q.opaque, &mut d.opaque, &mut m.opaque, to_opaque);

        // Sorted and blended, as long as there is room for what comes of it.
        let sorted_ready = results.count + 2 <= cfg.results().depth;
        let to_sorter = sorter::In { arrived: layers.arrived, sorted_ready };
        Sorter::next(&cfg.sorter(), &q.sorter, &mut d.sorter, &mut (), to_sorter);
        let sorted =
            Stream { valid: sorter.sorted.valid && sorted_ready, payload: sorter.sorted.payload };
        // A pixel's first fragment is opaque: what is below it does not matter.
        let to_blender = blender::In { sorted, colour: Read::default() };
        let blended = Blender::next(&PIXEL_BITS, &q.blender, &mut d.blender, &mut (), to_blender);
        let push = written(blended.colour_write);
        let to_results = fifo::In { push, pop: i.result_ready };
        Results::next(&cfg.results(), &q.results, &mut d.results, &mut m.results, to_results);

        Out {
            fragment: layers.fragment,
            hidden: layers.hidden,
            blended: blended.blended,
            lost: if insert.valid && along.full { columns.last + 1 - columns.first } else { 0 },
        }
    }
}

#[cfg(test)]
mod tests;
