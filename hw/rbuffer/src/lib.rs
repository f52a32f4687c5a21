//! The R-buffer (seed 000): transparent fragments in a queue in arrival order, sent round until each
//! pixel's are blended, the farthest first.
//!
//! ```text
//!             +-----------+ passed       +----------+ picked   +---------+
//! fragment -->| DepthTest |------->+---->| Selector |--------->| Blender |
//!             +-----------+        |     +----------+          +---------+
//!                   |              |      |   ^    |                |
//!                   |       popped |      |   |    | pushed         |
//!                   |     +--------+      | +--------+ +-------+    |
//!                   |     | Passes |------|>| Rounds | | Queue |    |
//!                   |     +--------+      | +--------+ +-------+    |
//!                   |          ^----------|----------------+        |
//!                   | depth, colour       | depth            colour |
//!                   v                     v                         v
//!             +--------------------------------------------------------------+
//!             | Display: frame buffer (depth and colour, two banks), scanout |--> image
//!             +--------------------------------------------------------------+
//! ```
//! A frame's transparent fragments go through the selector into the queue: all of them or, if they do not fit
//! and `overflow=replay`, those of one band of pixels after the other, each time that the frame is sent. Then
//! pass follows pass: all that is in the queue goes through the selector once, the farthest fragment of each
//! pixel is blended, and the rest goes back. Nothing has to be cleared between frames.
//!
//! Where the frame buffer lies in outside memory what leaves the queue goes through the [front](Front), which brings its pixel, to the
//! selector, which blends it: there is no blender.

pub mod architecture;
pub mod config;
pub mod monitor;
pub mod passes;
pub mod queue;
pub mod rounds;
pub mod selector;

#[cfg(test)]
mod test_util;

use config::Config;
use passes::Passes;
use pellucid_blocks::blender::{self, Blender, Sorted};
use pellucid_blocks::front::{self, Front, Phase, Status};
use pellucid_blocks::pixels::{self, Resolve, Revisit};
use pellucid_blocks::shared_port::{self, SharedPort};
use pellucid_machine::pixel::{Fragment, Marked, PixelFragment};
use pellucid_machine::{FragmentIn, InConfig, outside};
use pellucid_sim::Block;
use pellucid_sim::{Handshake, Memory, Optional, Read, Signals, Stream, rtl};
use queue::Queue;
use rounds::Rounds;
use selector::Selector;

/// The machine.
#[derive(Clone, Copy, Debug)]
pub struct RBuffer;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`front`].
    #[with(cfg.front)]
    #[block(Front)]
    pub front: front::State,
    /// See [`rounds`].
    #[with(*cfg)]
    #[exists(cfg.replay)]
    #[block(Rounds)]
    pub rounds: rounds::State,
    /// See [`selector`].
    #[with(*cfg)]
    #[block(Selector)]
    pub selector: selector::State,
    /// See [`queue`].
    #[with(cfg.queue)]
    #[block(Queue)]
    pub queue: queue::State,
    /// See [`passes`].
    #[with(cfg.queue)]
    #[block(Passes)]
    pub passes: passes::State,
    /// See [`blender`].
    #[with(cfg.screen.pixel_bits())]
    #[block(Blender)]
    #[exists(!cfg.front.outside())]
    pub blender: blender::State,
    /// Where the frame buffer lies outside: the frame's last fragment was blended in the cycle before.
    #[exists(cfg.front.outside())]
    pub blended: bool,
    /// See [`shared_port`].
    #[with(cfg.port)]
    #[exists(cfg.port.memory().exists())]
    #[block(SharedPort)]
    pub port: shared_port::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`front`].
    #[block(Front, cfg.front)]
    pub front: front::Mem,
    /// See [`selector`].
    #[block(Selector, *cfg)]
    pub selector: selector::Mem,
    /// See [`queue`].
    #[block(Queue, cfg.queue)]
    pub queue: queue::Mem,
    /// See [`shared_port`].
    #[block(SharedPort, cfg.port)]
    #[exists(cfg.port.memory().exists())]
    pub port: Optional<shared_port::Mem>,
}

/// What can be seen of the machine in a cycle: its ports, the streams between its blocks, and what
/// its blocks did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What the machine is at.
    pub phase: Phase,
    /// Fragments come in, then the end of the frame.
    #[with(cfg.screen)]
    pub fragment: Handshake<Marked<Fragment>>,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(24)]
    pub image: Handshake<u32>,
    /// What comes next is the same frame again, from its first fragment.
    pub replay: bool,
    /// Transparent fragments in front, then the end of the arrivals.
    #[with(cfg.screen)]
    pub passed: Handshake<Marked<PixelFragment>>,
    /// What comes out of the queue, then the end of the pass.
    #[with(cfg.screen)]
    pub popped: Handshake<Marked<PixelFragment>>,
    /// What goes into the queue.
    #[with(cfg.screen)]
    pub pushed: Handshake<PixelFragment>,
    /// Fragments in each pixel's blending order.
    #[with(cfg.screen.pixel_bits())]
    pub picked: Handshake<Marked<Sorted>>,
    /// The port to what lies outside of queue and frame buffer.
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
    /// An opaque fragment was drawn.
    pub drawn: bool,
    /// An opaque fragment was hidden.
    pub hidden: bool,
    /// A transparent fragment was hidden on arrival.
    pub culled_early: bool,
    /// A fragment went into outside memory.
    pub spilled: bool,
    /// A fragment found no room.
    pub dropped: bool,
    /// The frame is sent again.
    pub again: bool,
    /// A round ends, and the frame is to be sent again.
    pub round_ends: bool,
    /// It ends since the fragments of its band do not fit.
    pub round_failed: bool,
    /// A pass begins with the next cycle.
    pub pass_begins: bool,
    /// A stored fragment turned out to be hidden.
    pub culled_late: bool,
    /// A fragment was blended.
    pub blended: bool,
    /// The image is being shown.
    pub scanout: bool,
    /// The machine holds a finished frame.
    pub frame_done: bool,
}

#[rtl(
    name = "rbuffer",
    input = InConfig { screen: cfg.screen, outside: cfg.port.memory() },
    moore = (),
    output = *cfg,
    check(RBuffer, crate::test_util::small_rbuffer(4, Some(7))),
    check(RBuffer, crate::test_util::small_rbuffer(9, Some(0))),
    check(RBuffer, crate::test_util::small_rbuffer(4, None)),
    check(RBuffer, crate::test_util::framebuffer_outside(4, Some(7))),
    check(RBuffer, crate::test_util::framebuffer_outside(4, None))
)]
impl Block for RBuffer {
    type Config = Config;
    type State = State;
    type In = FragmentIn;
    type Moore = Status;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Self::Mem) -> Status {
        let front = Front::moore(&cfg.front, &q.front, &m.front).status;
        let replay = if cfg.replay { Rounds::moore(cfg, &q.rounds, &()).replay } else { false };
        Status { replay, ..front }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Self::Mem, i: FragmentIn) -> Out {
        let screen = &cfg.screen;

        // What every block shows before its inputs are known.
        let front = Front::moore(&cfg.front, &q.front, &m.front);
        let selector_ready = Selector::moore(cfg, &q.selector, &m.selector).ready;
        let queue = Queue::moore(&cfg.queue, &q.queue, &m.queue);
        let passes = Passes::moore(&cfg.queue, &q.passes, &());
        let round = if cfg.replay { Rounds::moore(cfg, &q.rounds, &()) } else { rounds::once(cfg) };

        let storing = matches!(front.status.phase, Phase::Store);
        let resolving = matches!(front.status.phase, Phase::Resolve);

        // What queue and frame buffer see of the outside memory.
        let (mut of_queue, mut of_pixels) = (outside::In::default(), outside::In::default());
        if cfg.port.memory().exists() {
            let port = SharedPort::moore(&cfg.port, &q.port, &m.port);
            of_queue = shared_port::fragments(&cfg.port, port, i.outside);
            of_pixels = shared_port::pixels(&cfg.port, port, i.outside);
        }

        // What comes for the first time, or again: to the selector, or by way of a frame buffer outside, which brings its pixel.
        let popped = if passes.end {
            Stream::offer(Marked::end())
        } else {
            Stream {
                valid: passes.items && queue.front.valid,
                payload: Marked::item(queue.front.payload),
            }
        };
        let (mut fragment, mut popped_ready, mut depth) = (popped, selector_ready, front.depth);
        if cfg.front.outside() {
            popped_ready = front.revisits;
            depth = Read { valid: front.pixel.valid, data: front.pixel.data.depth };
        }
        if !resolving || cfg.front.outside() {
            fragment = front.passed;
        }
        let select = if storing || resolving || front.clear.valid {
            let to_selector = selector::In {
                fragment,
                arrival: !resolving,
                first_pass: passes.first,
                parity: passes.parity,
                depth,
                colour: front.pixel.data.colour,
                pushed_ready: queue.ready,
                full: queue.full,
                round,
                clear: front.clear,
            };
            Selector::next(cfg, &q.selector, &mut d.selector, &mut m.selector, to_selector)
        } else {
            selector::Out::default()
        };
        let stored = select.ended && !resolving;
        let queued = if storing || resolving {
            let pop = resolving && passes.items && popped_ready;
            let to_queue = queue::In { push: select.pushed, pop, outside: of_queue };
            Queue::next(&cfg.queue, &q.queue, &mut d.queue, &mut m.queue, to_queue)
        } else {
            queue::Out::default()
        };

        // Passes, clocked from the end of the arrivals on.
        let pass = if stored || resolving {
            let to_passes = passes::In {
                start: stored,
                count: queue.count,
                taken: popped.valid && popped_ready,
                ended: select.ended,
            };
            Passes::next(&cfg.queue, &q.passes, &mut d.passes, &mut (), to_passes)
        } else {
            passes::Out::default()
        };
        let rounds = if cfg.replay {
            let to_rounds = rounds::In {
                overflowed: select.overflowed,
                stored,
                roomy: queue.count <= cfg.queue.on_chip >> 1,
                emptied: pass.done,
                comes: i.fragment.valid && front.status.ready,
            };
            Rounds::next(cfg, &q.rounds, &mut d.rounds, &mut (), to_rounds)
        } else {
            rounds::Out { ends: false, done: pass.done }
        };
        let picked = if rounds.done { Stream::offer(Marked::end()) } else { select.picked };
        let mut blend = blender::Out::default();
        if cfg.front.outside() {
            // The selector has blended it.
            d.blended = resolving && rounds.done;
            blend.blended = select.picked.valid;
            blend.frame_done = q.blended;
        } else if resolving {
            let to_blender = blender::In { sorted: picked, colour: front.colour };
            blend = Blender::next(
                &screen.pixel_bits(),
                &q.blender,
                &mut d.blender,
                &mut (),
                to_blender,
            );
        }

        let to_front = front::In {
            fragment: i.fragment,
            image_ready: i.image_ready,
            passed_ready: selector_ready,
            stored,
            resolved: blend.frame_done,
            again: rounds.ends,
            cleared: true,
            depth_read: select.depth_read,
            depth_write: select.depth_write,
            colour_read: blend.colour_read,
            colour_write: blend.colour_write,
            resolve: Resolve::default(),
            revisit: Revisit {
                on: resolving,
                fragment: popped,
                taken: select.taken,
                write: select.pixel,
                over: d.blended,
            },
            memory: of_pixels,
        };
        let done = Front::next(&cfg.front, &q.front, &mut d.front, &mut m.front, to_front);

        let mut outside = outside::Wires::default();
        if cfg.port.memory().exists() {
            let to_port = shared_port::In {
                fragments: queued.request,
                pixels: done.request,
                memory: i.outside,
            };
            outside = SharedPort::next(&cfg.port, &q.port, &mut d.port, &mut m.port, to_port);
        }

        let mut passed = front.passed;
        passed.valid &= !(cfg.front.outside() && resolving);
        Out {
            phase: done.phase,
            fragment: i.fragment.with(front.status.ready),
            image: front.status.image.with(i.image_ready),
            replay: round.replay,
            passed: passed.with(selector_ready),
            popped: popped.with(popped_ready),
            pushed: select.pushed.with(queue.ready),
            picked: picked.with(true),
            outside,
            events: Events {
                drawn: done.drawn,
                hidden: done.hidden,
                culled_early: done.culled,
                spilled: queued.spilled,
                dropped: select.dropped,
                again: round.again,
                round_ends: rounds.ends,
                round_failed: rounds.ends && round.failed,
                pass_begins: pass.begins,
                culled_late: select.culled,
                blended: blend.blended,
                scanout: front.status.shows,
                frame_done: done.frame_done,
            },
            framebuffer: pixels::Wires { events: done.events },
        }
    }
}
