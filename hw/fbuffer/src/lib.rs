//! The hardware F-buffer of seed 003: shading in several passes over the same primitives, with a FIFO in rasterisation order for
//! what a pass leaves for the next one.
//!
//! ```text
//!               +--------+   +--------+   +--------+ last pass, opaque +-------+   +------------+
//!  primitive -->| Walker |-->| Window |-->| Shader |------------------>| Front |-->| Compositor |
//!               +--------+   +--------+   +--------+                   |       |   +------------+
//!                    ^            | read    ^    | write               |       |<------- colour
//!  replay            |            v         |    v                     +-------+--> image
//!    ^          +--------+      +---------------------+
//!    +----------| Plays  |      | F-buffer            |<--> outside memory,
//!               +--------+      +---------------------+     if it lies there
//! ```
//! A frame is played once for each pass of each [window] of fragments. In the last pass fragments are tested and blended
//! in the order in which they come; before it tests and blending are off, and each fragment leaves its values in its own place
//! of the F-buffer, where it finds them again in the next pass, as the same fragments come in the same order.
//!
//! Where the frame buffer lies in outside memory a fragment is blended as it is tested, by the [front](Front), and there is no compositor.

pub mod ahead;
pub mod architecture;
pub mod buffer;
pub mod compositor;
pub mod config;
pub mod early_test;
mod forms;
pub mod golden;
pub mod monitor;
mod phases;
pub mod plays;
pub mod program;
pub mod shader;
pub mod sort;
pub mod survivors;
pub mod window;

#[cfg(test)]
mod test_util;

use ahead::{Ahead, Left};
use buffer::Buffer;
use compositor::Compositor;
use config::Config;
use early_test::EarlyTest;
use pellucid_blocks::front::{self, Front};
use pellucid_blocks::pixels::{self, Resolve, Revisit};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_blocks::walker::{self, Walker};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment, is_opaque};
use pellucid_machine::primitive::{Format, Primitive};
use pellucid_machine::{InConfig, PrimitiveIn, outside};
use pellucid_sim::{Block, Handshake, Memory, Optional, Signals, Stream, WritePort, rtl};
pub use phases::{MachinePhase, PHASES};
use plays::{Play, Plays};
use shader::Shader;
use sort::Sort;
use survivors::Survivors;
use window::Window;

/// The machine.
#[derive(Clone, Copy, Debug)]
pub struct FBuffer;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`plays`].
    #[with(cfg.plays)]
    #[block(Plays)]
    pub plays: plays::State,
    /// See [`walker`].
    #[with(cfg.walker)]
    #[block(Walker)]
    pub walker: walker::State,
    /// See [`early_test`].
    #[with(cfg.walker.screen)]
    #[block(EarlyTest)]
    #[exists(cfg.early)]
    pub early_test: early_test::State,
    /// See [`window`].
    #[with(cfg.plays.window)]
    #[block(Window)]
    pub window: window::State,
    /// See [`survivors`].
    #[with(cfg.plays.window)]
    #[block(Survivors)]
    #[exists(cfg.plays.window.compacts)]
    pub survivors: survivors::State,
    /// See [`shader`].
    #[with(cfg.shader)]
    #[block(Shader)]
    pub shader: shader::State,
    /// See [`buffer`].
    #[with(cfg.shader)]
    #[block(Buffer)]
    #[exists(cfg.stores() && !cfg.outside())]
    pub buffer: buffer::State,
    /// See [`ahead`].
    #[with(cfg.ahead)]
    #[block(Ahead)]
    #[exists(cfg.outside())]
    pub ahead: ahead::State,
    /// See [`front`].
    #[with(cfg.front)]
    #[block(Front)]
    pub front: front::State,
    /// See [`sort`].
    #[with(cfg.sort)]
    #[block(Sort)]
    #[exists(cfg.plays.sorts)]
    pub sort: sort::State,
    /// See [`compositor`].
    #[with(cfg.walker.screen)]
    #[block(Compositor)]
    #[exists(!cfg.front.outside())]
    pub compositor: compositor::State,
    /// Where the frame buffer lies outside: all fragments of the play are blended.
    #[exists(cfg.front.outside())]
    pub ended: bool,
    /// See [`shared_port`].
    #[with(cfg.port)]
    #[exists(cfg.port.memory().exists())]
    #[block(SharedPort)]
    pub port: shared_port::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`survivors`].
    #[block(Survivors, cfg.plays.window)]
    #[exists(cfg.plays.window.compacts)]
    pub survivors: Optional<survivors::Mem>,
    /// See [`buffer`].
    #[block(Buffer, cfg.shader)]
    #[exists(cfg.stores() && !cfg.outside())]
    pub buffer: Optional<buffer::Mem>,
    /// See [`ahead`].
    #[block(Ahead, cfg.ahead)]
    #[exists(cfg.outside())]
    pub ahead: Optional<ahead::Mem>,
    /// See [`sort`].
    #[block(Sort, cfg.sort)]
    #[exists(cfg.plays.sorts)]
    pub sort: Optional<sort::Mem>,
    /// See [`front`].
    #[block(Front, cfg.front)]
    pub front: front::Mem,
    /// See [`shared_port`].
    #[block(SharedPort, cfg.port)]
    #[exists(cfg.port.memory().exists())]
    pub port: Optional<shared_port::Mem>,
}

/// What can be seen of the machine in a cycle: its ports, the streams between its blocks, and what its blocks did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What the machine is at.
    pub phase: MachinePhase,
    /// Primitives come in, then the end of the frame.
    #[with(Format::whole(cfg.walker.screen))]
    pub primitive: Handshake<Marked<Primitive>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(24)]
    pub image: Handshake<u32>,
    /// What comes next is the same frame again, from its first primitive.
    pub replay: bool,
    /// What the play is.
    #[with(cfg.plays.window)]
    pub play: Play,
    /// Fragments on their way to be counted.
    #[with(cfg.walker.screen)]
    pub fragment: Handshake<Marked<Fragment>>,
    /// Fragments on their way to the depth test: opaque ones, and shaded ones that were not tested before.
    #[with(cfg.walker.screen)]
    pub shaded: Handshake<Marked<Fragment>>,
    /// Shaded ones that are in front, to be blended.
    #[with(cfg.walker.screen)]
    pub blends: Handshake<Marked<PixelFragment>>,
    /// Transparent fragments of the play so far.
    #[width(window::COUNT_BITS)]
    #[exists(cfg.plays.window.counts())]
    pub counted: u32,
    /// The port to F-buffer and frame buffer outside.
    #[with(cfg.port.memory())]
    #[exists(cfg.port.memory().exists())]
    pub outside: outside::Wires,
    /// What happened.
    pub events: Events,
    /// What can be seen of a frame buffer outside.
    #[exists(cfg.front.outside())]
    pub framebuffer: pixels::Wires,
}

/// What happened in a cycle, one wire each.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Events {
    /// A primitive is submitted.
    pub submitted: bool,
    /// A fragment goes on to be shaded.
    pub shaded: bool,
    /// A fragment is discarded: outside of the window, or dropped before.
    pub discarded: bool,
    /// An opaque fragment was drawn.
    pub drawn: bool,
    /// An opaque fragment was hidden.
    pub hidden: bool,
    /// A transparent fragment was hidden.
    pub culled: bool,
    /// A fragment goes no further since it was killed.
    pub killed: bool,
    /// A shaded fragment was blended.
    pub blended: bool,
    /// A play is over.
    pub play_done: bool,
    /// It was the first pass of a batch that does not fit.
    pub wasted: bool,
    /// A pass of the sort is complete.
    pub sort_pass: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "fbuffer",
    input = InConfig { screen: cfg.walker.screen, outside: cfg.port.memory() },
    check(FBuffer, crate::test_util::small_fbuffer(&[])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("overflow", "batch"), ("fragment_cycles", "3")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("program", "tint")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("store", "framebuffer")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("early_depth", "before_window")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("mode", "sort"), ("program", "tint"), ("sorter_lanes", "2")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("program", "sieve")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("program", "sieve"), ("kill", "compact")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("buffer", "outside")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("program", "sieve"), ("kill", "compact"), ("buffer", "outside")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("framebuffer", "cached")])),
    check(FBuffer, crate::test_util::small_fbuffer(&[("framebuffer", "cached"), ("buffer", "outside")]))
)]
impl Block for FBuffer {
    type Config = Config;
    type State = State;
    type In = PrimitiveIn;
    type Moore = ();
    type Out = Out;
    type Mem = Mem;

    fn moore(_: &Config, _: &State, _: &Mem) {}

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: PrimitiveIn) -> Out {
        let screen = &cfg.walker.screen;

        // What every block shows before its inputs are known.
        let plays = Plays::moore(&cfg.plays, &q.plays, &());
        let walked = Walker::moore(&cfg.walker, &q.walker, &()).fragment;
        let window = Window::moore(&cfg.plays.window, &q.window, &());
        let mut survivors = survivors::Moore::default();
        if cfg.plays.window.compacts {
            survivors = Survivors::moore(&cfg.plays.window, &q.survivors, &m.survivors);
        }
        let mut ahead = ahead::Moore { room: true, there: true, ..ahead::Moore::default() };
        if cfg.outside() {
            ahead = Ahead::moore(&cfg.ahead, &q.ahead, &m.ahead);
            survivors.next = ahead.next;
        }
        let running = Shader::moore(&cfg.shader, &q.shader, &()).shaded;
        let front = Front::moore(&cfg.front, &q.front, &m.front);
        let over = if cfg.front.outside() {
            q.ended
        } else {
            Compositor::moore(screen, &q.compositor, &()).ended
        };
        let mut sort = sort::Moore { ready: true, gives: false, left: false };
        if cfg.plays.sorts {
            sort = Sort::moore(&cfg.sort, &q.sort, &m.sort);
        }

        // What a pass gives: to the depth test; or at once to be blended, if it was tested before; or to the F-buffer. One that was killed
        // goes no further once there is no place to keep for it.
        let Marked { end, item } = running.payload;
        let coloured = shader::coloured(&cfg.shader, item);
        let shades = running.valid && !end && !is_opaque(coloured.rgba);
        let gone = shades && item.killed && (plays.last || cfg.plays.window.compacts);
        let left = shades && !gone;
        let tests = end || is_opaque(coloured.rgba) || (left && plays.last && !cfg.early);
        let shaded =
            Stream { valid: running.valid && tests, payload: Marked { end, item: coloured } };
        let direct = cfg.early && left && plays.last;
        let stored = left && !plays.last;
        let taken = (!shaded.valid || front.status.ready) && (!direct || sort.ready);
        let advance = taken && (!stored || ahead.room);
        let writes = stored && ahead.room;
        let mut write = Stream { valid: writes, payload: item.placed.place };
        let beyond = window::beyond(&cfg.plays.window, plays.play.window, window);
        let mut number = plays.play.window << cfg.plays.window.place_bits() | item.placed.place;
        if cfg.plays.window.compacts {
            write.payload = survivors.free;
            number = item.placed.number;
        }
        let mut to_blend = front.passed;
        if direct {
            let Fragment { x, y, z, rgba, label } = coloured;
            to_blend = Stream::offer(Marked::item(PixelFragment {
                pixel: y * cfg.walker.screen.width + x,
                z,
                rgba,
                label,
            }));
        }

        // Where it is sorted, what leaves the sort is blended.
        let sorting = cfg.plays.sorts && plays.last;
        let mut sort_pass = false;
        if cfg.plays.sorts {
            let to_sort = sort::In {
                fragment: Stream { valid: sorting && to_blend.valid, payload: to_blend.payload },
                number,
                last: !beyond,
                over: sorting && over,
            };
            let sorted = Sort::next(&cfg.sort, &q.sort, &mut d.sort, &mut m.sort, to_sort);
            sort_pass = sorted.pass;
            if sorting {
                to_blend = sorted.sorted;
            }
        }

        let mut composed = compositor::Out::default();
        if cfg.front.outside() {
            // The depth test has blended it.
            d.ended = to_blend.valid && to_blend.payload.end;
            composed.blended = to_blend.valid && !to_blend.payload.end;
        } else {
            let to_compositor = compositor::In { fragment: to_blend, colour: front.colour };
            composed =
                Compositor::next(screen, &q.compositor, &mut d.compositor, &mut (), to_compositor);
        }

        // What F-buffer and frame buffer see of the outside memory.
        let (mut of_ahead, mut of_pixels) = (outside::In::default(), outside::In::default());
        if cfg.port.memory().exists() {
            let port = SharedPort::moore(&cfg.port, &q.port, &m.port);
            of_ahead = shared_port::fragments(&cfg.port, port, i.outside);
            of_pixels = shared_port::pixels(&cfg.port, port, i.outside);
        }

        // Primitives come while the play is open; of those that are not submitted nothing is seen.
        let open =
            plays.open && matches!(front.status.phase, front::Phase::Idle | front::Phase::Store);
        let Marked { end: ends, item: primitive } = i.primitive.payload;
        let offered = i.primitive.valid && open;
        let skipped = !ends && plays.skips;
        let mut fragment = walked;
        if cfg.early {
            fragment = early_test::passed(
                EarlyTest::moore(screen, &q.early_test, &()).stage,
                front.depth,
                plays.play.shades,
            );
        }
        let there = ahead.there;
        let to_window = window::In { fragment, play: plays.play, survivors, there, advance, over };
        let windowed =
            Window::next(&cfg.plays.window, &q.window, &mut d.window, &mut (), to_window);
        if cfg.plays.window.compacts {
            let of_survivors = survivors::In {
                enters: windowed.shaded,
                leaves: shades && advance,
                survives: Stream { valid: writes, payload: number },
                over,
            };
            Survivors::next(
                &cfg.plays.window,
                &q.survivors,
                &mut d.survivors,
                &mut m.survivors,
                of_survivors,
            );
        }
        let mut values = ahead.values;
        let leaves = shader::values(&cfg.shader, item);
        let mut asked = Stream::idle();
        if cfg.outside() {
            let to_ahead = ahead::In {
                write: Stream { valid: writes, payload: Left { values: leaves, number } },
                label: coloured.label,
                taken: windowed.read.valid,
                reads: plays.play.reads,
                over,
                memory: of_ahead,
            };
            asked = Ahead::next(&cfg.ahead, &q.ahead, &mut d.ahead, &mut m.ahead, to_ahead);
        } else if cfg.stores() {
            values = Buffer::moore(&cfg.shader, &q.buffer, &m.buffer).values;
            let to_buffer = buffer::In {
                read: windowed.read,
                write,
                values: leaves,
                second: plays.pass & 1 == 1,
            };
            Buffer::next(&cfg.shader, &q.buffer, &mut d.buffer, &mut m.buffer, to_buffer);
        }
        let mut tested = early_test::Out { taken: windowed.taken, ..early_test::Out::default() };
        if cfg.early {
            let to_early_test = early_test::In {
                fragment: walked,
                tests: plays.play.shades,
                depth: front.depth,
                passed_taken: windowed.taken,
            };
            tested =
                EarlyTest::next(screen, &q.early_test, &mut d.early_test, &mut (), to_early_test);
        }
        let to_walker = walker::In {
            primitive: Stream {
                valid: offered && !skipped,
                payload: Marked { end: ends, item: primitive },
            },
            fragment_ready: tested.taken,
        };
        let taken = Walker::next(&cfg.walker, &q.walker, &mut d.walker, &mut (), to_walker).taken;
        let ready = open && (skipped || taken);

        let to_shader = shader::In { fragment: window.placed, values, pass: plays.pass, advance };
        Shader::next(&cfg.shader, &q.shader, &mut d.shader, &mut (), to_shader);

        let to_plays = plays::In {
            comes: i.primitive.valid && ready,
            end: ends,
            over,
            beyond,
            next_window: window.end,
            left: sort.left,
            done: plays.finished && !front.busy,
        };
        let played = Plays::next(&cfg.plays, &q.plays, &mut d.plays, &mut (), to_plays);

        let to_front = front::In {
            fragment: shaded,
            image_ready: i.image_ready,
            passed_ready: !sorting || sort.ready,
            stored: played.finished,
            resolved: plays.finished,
            again: played.again,
            cleared: true,
            depth_read: tested.depth_read,
            depth_write: WritePort::default(),
            colour_read: composed.colour_read,
            colour_write: composed.colour_write,
            resolve: Resolve::default(),
            revisit: Revisit::default(),
            memory: of_pixels,
        };
        let done = Front::next(&cfg.front, &q.front, &mut d.front, &mut m.front, to_front);

        let mut outside = outside::Wires::default();
        if cfg.port.memory().exists() {
            let to_port =
                shared_port::In { fragments: asked, pixels: done.request, memory: i.outside };
            outside = SharedPort::next(&cfg.port, &q.port, &mut d.port, &mut m.port, to_port);
        }

        let busy = plays.busy || offered;
        Out {
            phase: phases::phase(
                front.status.phase,
                busy,
                plays.play.shades,
                plays.last,
                sort.gives,
            ),
            primitive: i.primitive.with(ready),
            image: front.status.image.with(i.image_ready),
            replay: plays.replay,
            play: plays.play,
            fragment: walked.with(tested.taken),
            shaded: shaded.with(front.status.ready),
            blends: to_blend.with(true),
            counted: window.counted,
            outside,
            framebuffer: pixels::Wires { events: done.events },
            events: Events {
                submitted: offered && !skipped && taken && !ends,
                shaded: windowed.shaded,
                discarded: windowed.discarded,
                drawn: done.drawn,
                hidden: done.hidden,
                culled: done.culled || tested.culled,
                killed: gone && advance,
                blended: composed.blended,
                play_done: over,
                wasted: played.wasted,
                sort_pass,
                scanout: front.status.shows,
                frame_done: done.frame_done,
            },
        }
    }
}
