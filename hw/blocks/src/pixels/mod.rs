//! The display side with its frame buffer in outside memory: depth and colour of every pixel, twice, and what reads and writes
//! them.
//!
//! ```text
//!                 +------------+  ask, write  +-------------+
//!  fragment ----->| DepthAhead |------------->| CachedTable |---+
//!  passed <-------|            |<-------------|             |   |
//!                 +------------+  pixel       +-------------+   |   +---------+
//!  ask ---------->| Fetch      |------------------------------->+-->|         |
//!  depth <--------|            |--> Destination --> colour      |   | Arbiter |---> request (Stream)
//!  colour write ->| colours    |------------------------------->+   |         |<--- memory
//!                 +------------+                                    |         |
//!  image <--------| ScanoutAhead |--------------------------------->|         |
//!                 +--------------+                                  +---------+
//! ```
//! A word is a pixel, depth and colour: an opaque fragment that is drawn writes both, and what is resolved reads both. [`Marks`] on
//! chip say which pixels hold something at all.
//!
//! *While fragments come*, several wait for their pixel in [`DepthAhead`], and a cache of the front bank keeps those that were
//! used. When the frame is `stored` it is flushed: what follows reads memory.
//!
//! *While they are resolved*, each pixel is named in `ask` before it is used, in the order of its use, once. It is read ahead, and its
//! depth is shown until it is taken; where its fragments will arrive (`kept`) its colour goes to the
//! [`Destination`]. The colour that comes of it is written to memory, a word a cycle; while `colour_ready` is low, no further
//! fragment may go to the blender. A pixel that is written hides everything from then on: its depth is 0.
//!
//! Where fragments are blended [as they come](Blends::Coming) there is nothing to resolve. Where they come [again and
//! again](Blends::Revisiting) they go the way of those that come for the first time, to whoever blends them and says what their pixel holds then:
//! see [`Revisit`].
//!
//! *While it is shown* it is read ahead, too, in the bank that is in the back then. Who draws and who shows take turns. The
//! banks may change places while it is `drained`.
//!
//! After a reset both banks are cleared, a pixel a cycle, so that no word of memory is read before it was written.

mod config;
pub mod depth_test;
pub mod destination;
pub mod fetch;
pub mod marks;
mod pixel;
mod ports;
pub mod scanout;
#[cfg(test)]
mod tests;

pub use config::{Blends, Config};
pub use pixel::Pixel;
pub use ports::*;

use crate::arbiter::{self, Arbiter};
use crate::cached_table::{self, CachedTable};
use depth_test::DepthAhead;
use destination::Destination;
use fetch::Fetch;
use marks::Marks;
use pellucid_machine::outside::Request;
use pellucid_machine::pixel::{COLOUR_BITS, Fragment, Marked, PixelFragment, Screen};
use pellucid_sim::ram::port;
use pellucid_sim::{Block, Fifo, Memory, Optional, Read, Signals, Stream, fifo, rtl};
use scanout::ScanoutAhead;

/// See the module's description.
pub struct Pixels;

type Table = CachedTable<Pixel>;
type Turns = Arbiter;
type Writes = Fifo<Written>;

/// A colour on its way to memory.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
#[signals(Screen)]
pub struct Written {
    /// Its pixel.
    #[width(cfg.pixel_bits())]
    pub pixel: u32,
    /// The colour, `0xRRGGBB`.
    #[width(COLOUR_BITS)]
    pub colour: u32,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`marks`].
    #[with(cfg.screen)]
    #[block(Marks)]
    pub marks: marks::State,
    /// See [`depth_test`].
    #[with(*cfg)]
    #[block(DepthAhead)]
    pub depth_test: depth_test::State,
    /// The front bank, while fragments come.
    #[with(cfg.table)]
    #[block(Table, cfg.cached())]
    pub table: cached_table::State,
    /// Pixels of the front bank that are to be resolved.
    #[with(cfg.resolved())]
    #[exists(cfg.resolves())]
    #[block(Fetch)]
    pub fetch: fetch::State,
    /// See [`destination`].
    #[with(*cfg)]
    #[exists(cfg.resolves())]
    #[block(Destination)]
    pub destination: destination::State,
    /// Colours on their way to memory.
    #[with(cfg.writes().depth)]
    #[exists(cfg.resolves())]
    #[block(Writes, cfg.writes())]
    pub writes: fifo::State,
    /// See [`scanout`].
    #[with(*cfg)]
    #[block(ScanoutAhead)]
    pub scanout: scanout::State,
    /// Who draws and who shows take turns.
    #[with(cfg.arbiter())]
    #[block(Turns, cfg.arbiter())]
    pub turns: arbiter::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`marks`].
    #[block(Marks, cfg.screen)]
    pub marks: marks::Mem,
    /// See [`depth_test`].
    #[block(DepthAhead, *cfg)]
    pub depth_test: depth_test::Mem,
    /// The front bank, while fragments come.
    #[block(Table, cfg.cached())]
    pub table: cached_table::Mem,
    /// Pixels of the front bank that are to be resolved.
    #[block(Fetch, cfg.resolved())]
    #[exists(cfg.resolves())]
    pub fetch: Optional<fetch::Mem>,
    /// See [`destination`].
    #[block(Destination, *cfg)]
    #[exists(cfg.resolves())]
    pub destination: Optional<destination::Mem>,
    /// Colours on their way to memory.
    #[block(Writes, cfg.writes())]
    #[exists(cfg.resolves())]
    pub writes: Optional<<Writes as Block>::Mem>,
    /// See [`scanout`].
    #[block(ScanoutAhead, *cfg)]
    pub scanout: scanout::Mem,
    /// Whose answers come.
    #[block(Turns, cfg.arbiter())]
    pub turns: arbiter::Mem,
}

/// The request of whoever draws or shows, where bank b is in front or not: bank a lies first.
#[inline(always)]
#[rtl]
fn banked(cfg: &Config, request: Stream<Request>, front_is_b: bool) -> Stream<Request> {
    let words = cfg.bank().words;
    let mut asked = request;
    let back = request.payload.address >= words;
    if front_is_b && back {
        asked.payload.address = request.payload.address - words;
    } else if front_is_b {
        asked.payload.address = request.payload.address + words;
    }
    asked
}

#[rtl(
    check(Pixels, tests::config(1, 2)),
    check(Pixels, tests::config(4, 7)),
    check(Pixels, tests::config(4, 7).blending(Blends::Coming)),
    check(Pixels, tests::config(4, 7).blending(Blends::Revisiting))
)]
impl Block for Pixels {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let table = Table::moore(&cfg.cached(), &q.table, &m.table);
        let test = DepthAhead::moore(cfg, &q.depth_test, &m.depth_test);
        let scanout = ScanoutAhead::moore(cfg, &q.scanout, &m.scanout);
        let turns = Turns::moore(&cfg.arbiter(), &q.turns, &m.turns);
        let mut seen = Moore {
            ready: test.ready,
            passed: depth_test::passed(cfg, test, table.entry),
            resolve: Resolved::default(),
            pixel: Read::default(),
            depth: Read::default(),
            colour: Read::default(),
            clear_ready: table.clear_ready && turns.ready[0] && turns.ready[1],
            image: scanout.image,
            busy: scanout.busy,
            drained: table.idle && turns.idle,
        };
        if cfg.resolves() {
            let fetch = Fetch::moore(&cfg.resolved(), &q.fetch, &m.fetch);
            let destination = Destination::moore(cfg, &q.destination, &m.destination);
            let waiting = Writes::moore(&cfg.writes(), &q.writes, &m.writes).count;
            seen.resolve = Resolved {
                ready: fetch.ready && table.idle,
                open: destination.open,
                there: destination.there,
                colour_ready: waiting <= config::WAITING,
            };
            seen.depth = Read {
                valid: fetch.pixel.valid && destination.ready,
                data: fetch.pixel.payload.depth,
            };
            seen.colour = Read { valid: true, data: destination.colour };
            seen.drained &= fetch.idle && waiting == 0;
        }
        if cfg.revisits() {
            seen.pixel = depth_test::revisited(cfg, test, table.entry);
        }
        seen
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // What every block shows before its inputs are known.
        let marks = Marks::moore(&cfg.screen, &q.marks, &m.marks);
        let table = Table::moore(&cfg.cached(), &q.table, &m.table);
        let (mut fetching, mut written) = (false, Stream::idle());
        if cfg.resolves() {
            fetching = !Fetch::moore(&cfg.resolved(), &q.fetch, &m.fetch).idle;
            written = Writes::moore(&cfg.writes(), &q.writes, &m.writes).front;
        }
        let busy = ScanoutAhead::moore(cfg, &q.scanout, &m.scanout).busy;
        let turns = Turns::moore(&cfg.arbiter(), &q.turns, &m.turns);
        let draws = arbiter::client(&0, turns, i.memory);
        let shows = arbiter::client(&1, turns, i.memory);

        let taken = i.clear.valid && table.clear_ready && draws.ready && shows.ready;
        let clear = Stream { valid: taken, payload: i.clear.payload };

        // Colours go first, then pixels that are read, then the cache. The last two are never under way at once.
        let mut to_fetch_memory = draws;
        to_fetch_memory.ready = draws.ready && !written.valid;
        to_fetch_memory.response.valid = draws.response.valid && fetching;
        let mut to_table_memory = draws;
        to_table_memory.ready = to_fetch_memory.ready && (!i.clearing || shows.ready);
        to_table_memory.response.valid = draws.response.valid && !fetching;

        // Store: fragments meet their pixels.
        let again = cfg.revisits() && i.revisit.on;
        let test = if i.storing || again {
            let Marked { end, item: Fragment { x, y, z, rgba, label } } = i.fragment.payload;
            let item = PixelFragment { pixel: y * cfg.screen.width + x, z, rgba, label };
            let mut fragment = Stream { valid: i.fragment.valid, payload: Marked { end, item } };
            if again {
                fragment = i.revisit.fragment;
            }
            let to_test = depth_test::In {
                fragment,
                again,
                taken: i.revisit.taken,
                write: i.revisit.write,
                marked: marks.front,
                table_ready: table.ready && !fetching,
                pixel: table.entry,
                passed_ready: i.passed_ready,
            };
            DepthAhead::next(cfg, &q.depth_test, &mut d.depth_test, &mut m.depth_test, to_test)
        } else {
            depth_test::Out::default()
        };
        let to_table = cached_table::In {
            ask: test.ask,
            taken: test.taken,
            write: test.write,
            clear,
            flush: if cfg.revisits() { i.revisit.over } else { i.stored },
            memory: to_table_memory,
        };
        let cached = Table::next(&cfg.cached(), &q.table, &mut d.table, &mut m.table, to_table);

        // Resolve: depths and colours are read ahead.
        let mut fetch = fetch::Out::default();
        let mut coloured = Stream::idle();
        if cfg.resolves() {
            let fetched = Fetch::moore(&cfg.resolved(), &q.fetch, &m.fetch).pixel;
            let kept = Destination::moore(cfg, &q.destination, &m.destination);
            let taken = fetched.valid && kept.ready && i.resolve.taken;
            let to_fetch = fetch::In {
                ask: Stream {
                    valid: i.resolve.ask.valid && table.idle,
                    payload: i.resolve.ask.payload,
                },
                marked: marks.front,
                taken,
                memory: to_fetch_memory,
            };
            fetch = Fetch::next(&cfg.resolved(), &q.fetch, &mut d.fetch, &mut m.fetch, to_fetch);
            let to_destination = destination::In {
                push: Stream { valid: taken && i.resolve.kept, payload: fetched.payload.colour },
                comes: i.resolve.comes,
                visible: i.resolve.visible,
                last: i.resolve.last,
                pop: port::read_at(i.colour_read).valid,
            };
            Destination::next(
                cfg,
                &q.destination,
                &mut d.destination,
                &mut m.destination,
                to_destination,
            );
            coloured = port::written_at(i.colour_write);
            let colour = port::written(i.colour_write);
            let to_writes = fifo::In {
                push: Stream {
                    valid: colour.valid,
                    payload: Written { pixel: coloured.payload, colour: colour.payload },
                },
                pop: draws.ready,
            };
            Writes::next(&cfg.writes(), &q.writes, &mut d.writes, &mut m.writes, to_writes);
        }

        // The frame before is shown.
        let shown = if busy || i.show {
            let to_scanout = scanout::In {
                start: i.show,
                marked: marks.back,
                memory: shows,
                image_ready: i.image_ready,
            };
            ScanoutAhead::next(cfg, &q.scanout, &mut d.scanout, &mut m.scanout, to_scanout)
        } else {
            scanout::Out::default()
        };

        let to_marks = marks::In {
            read: [test.mark_read, fetch.mark_read],
            mark: [test.mark, coloured],
            back_read: shown.mark_read,
            wipe: shown.wipe,
            clear,
            swap: i.show,
        };
        Marks::next(&cfg.screen, &q.marks, &mut d.marks, &mut m.marks, to_marks);

        let mut drawn = cached.request;
        if written.valid {
            let Written { pixel, colour } = written.payload;
            let word = Pixel::word(&cfg.screen, Pixel { depth: 0, colour });
            drawn = Stream::offer(Request { write: true, address: pixel, word });
        } else if fetch.request.valid {
            drawn = fetch.request;
        }
        let mut back = shown.request;
        if i.clearing {
            // What is cleared is cleared in both banks at once.
            drawn.valid &= shows.ready;
            back = drawn;
            back.valid &= draws.ready;
        }
        let to_turns = arbiter::In {
            request: [drawn, back, Stream::idle(), Stream::idle()],
            memory: i.memory,
        };
        let request =
            Turns::next(&cfg.arbiter(), &q.turns, &mut d.turns, &mut m.turns, to_turns).request;

        Out {
            request: banked(cfg, request, marks.front_is_b),
            drawn: test.drawn,
            hidden: test.hidden,
            culled: test.culled,
            events: Events {
                framebuffer_hit: cached.hit,
                framebuffer_miss: cached.miss,
                framebuffer_write_back: cached.write_back,
            },
        }
    }
}
