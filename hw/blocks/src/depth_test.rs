//! The early depth test: draws opaque fragments, drops hidden ones, passes transparent ones on.
//!
//! ```text
//!                    +-----------+
//!  fragment -------->|           |---> passed (transparent, in front)
//!  ready <-----------| DepthTest |<--- passed_ready
//!  depth data ------>|           |---> depth read / write, colour write
//!                    +-----------+
//! ```
//! One fragment a cycle; two cycles from input to output. A fragment passes if it is nearer than the
//! depth that its pixel holds, so of two equal opaque ones the first stays. A transparent fragment
//! that passes here may still be hidden by a later opaque one: whoever reads it back tests again.

use pellucid_machine::pixel::{
    COLOUR_BITS, Fragment, Marked, PixelFragment, Screen, Z_BITS, is_opaque,
};
use pellucid_sim::Block;
use pellucid_sim::{Fifo, Memory, Read, ReadPort, Signals, Stream, WritePort, fifo, rtl};

/// See the module's description.
pub struct DepthTest;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// Fragments that arrived.
    #[with(QUEUE_DEPTH)]
    pub queue: fifo::State,
    /// The fragment whose pixel's depth was asked for.
    #[with(*cfg)]
    pub stage: Stream<Marked<PixelFragment>>,
}

const QUEUE_DEPTH: u32 = 2;

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Fragments in arrival order, then the end of the frame.
    #[with(*cfg)]
    pub fragment: Stream<Marked<Fragment>>,
    /// The depth that was asked for.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The receiver of `passed` is ready.
    pub passed_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// A fragment is taken.
    pub ready: bool,
    /// The fragment whose pixel's depth was asked for: see [`passed`].
    #[with(*cfg)]
    pub stage: Stream<Marked<PixelFragment>>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Out {
    /// Reads a pixel's depth.
    #[with(cfg.pixel_bits())]
    pub depth_read: ReadPort,
    /// Writes a pixel's depth.
    #[with(cfg.pixel_bits(), Z_BITS)]
    pub depth_write: WritePort<u32>,
    /// Writes a pixel's colour, `0xRRGGBB`.
    #[with(cfg.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// An opaque fragment is drawn in this cycle.
    pub drawn: bool,
    /// An opaque fragment is dropped in this cycle: it is hidden.
    pub hidden: bool,
    /// A transparent fragment is dropped in this cycle: it is hidden.
    pub culled: bool,
}

/// What is passed on, before inputs are known: transparent fragments in front, in order, then the end of the frame.
/// `depth` is what was read for `stage`.
#[inline(always)]
#[rtl]
pub fn passed(
    stage: Stream<Marked<PixelFragment>>,
    depth: Read<u32>,
) -> Stream<Marked<PixelFragment>> {
    let f = stage.payload.item;
    let in_front = !is_opaque(f.rgba) && f.z < depth.data;
    Stream { valid: stage.valid && (stage.payload.end || in_front), payload: stage.payload }
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Fragments that arrived.
    pub queue: <Queue as Block>::Mem,
}

type Queue = Fifo<Marked<Fragment>>;

fn queue(cfg: &Screen) -> fifo::Config<Screen> {
    fifo::Config { depth: QUEUE_DEPTH, item: *cfg }
}

#[rtl(check(DepthTest, crate::test_util::screen(5, 3)))]
impl Block for DepthTest {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Screen) -> State {
        cfg.check();
        State { queue: Queue::reset(&queue(cfg)), stage: Stream::idle() }
    }

    fn memories(cfg: &Screen) -> Mem {
        Mem { queue: Queue::memories(&queue(cfg)) }
    }

    fn moore(cfg: &Screen, q: &State, m: &Self::Mem) -> Moore {
        Moore { ready: Queue::moore(&queue(cfg), &q.queue, &m.queue).ready, stage: q.stage }
    }

    fn next(cfg: &Screen, q: &State, d: &mut State, m: &mut Self::Mem, i: In) -> Out {
        let (mut depth_read, mut depth_write) = (ReadPort::default(), WritePort::default());
        let mut colour_write = WritePort::default();

        // Second stage: the pixel's depth is at hand.
        let f = q.stage.payload.item;
        let fragment = q.stage.valid && !q.stage.payload.end;
        let opaque = is_opaque(f.rgba);
        let nearer = f.z < i.depth.data;
        let stall = passed(q.stage, i.depth).valid && !i.passed_ready;
        let drawn = fragment && opaque && nearer;
        if drawn {
            depth_write.write(f.pixel, f.z);
            colour_write.write(f.pixel, f.rgba >> 8);
        }

        // First stage: ask for the depth of the next fragment's pixel.
        let front = Queue::moore(&queue(cfg), &q.queue, &m.queue).front;
        if !stall {
            let Fragment { x, y, z, rgba, label } = front.payload.item;
            let item = PixelFragment { pixel: y * cfg.width + x, z, rgba, label };
            d.stage =
                Stream { valid: front.valid, payload: Marked { end: front.payload.end, item } };
            if front.valid && !front.payload.end {
                depth_read.read(item.pixel);
            }
        }
        let to_queue = fifo::In { push: i.fragment, pop: !stall };
        Queue::next(&queue(cfg), &q.queue, &mut d.queue, &mut m.queue, to_queue);

        Out {
            depth_read,
            depth_write,
            colour_write,
            drawn,
            hidden: fragment && opaque && !nearer,
            culled: fragment && !opaque && !nearer,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{Pattern, Source, contents, edge, holding, pattern, screen, traffic};
    use pellucid_machine::pixel::{Z_FAR, rgba};
    use pellucid_sim::{Ram1R1W, ReadDuringWrite, Sim, StreamMonitor};
    use proptest::prelude::*;

    const WIDTH: u32 = 3;
    const HEIGHT: u32 = 2;

    /// What a frame comes to.
    #[derive(Debug, Default, PartialEq)]
    struct Result {
        passed: Vec<Marked<PixelFragment>>,
        depth: Vec<u32>,
        colour: Vec<u32>,
        drawn: u32,
        hidden: u32,
        culled: u32,
    }

    /// The early depth test as a plain loop.
    fn reference(fragments: &[Fragment]) -> Result {
        let pixels = (WIDTH * HEIGHT) as usize;
        let mut r =
            Result { depth: vec![Z_FAR; pixels], colour: vec![0; pixels], ..Result::default() };
        for f in fragments {
            let pixel = f.y * WIDTH + f.x;
            let nearer = f.z < r.depth[pixel as usize];
            match (f.rgba & 0xff == 255, nearer) {
                (true, true) => {
                    r.depth[pixel as usize] = f.z;
                    r.colour[pixel as usize] = f.rgba >> 8;
                    r.drawn += 1;
                }
                (true, false) => r.hidden += 1,
                (false, true) => {
                    r.passed.push(Marked::item(PixelFragment {
                        pixel,
                        z: f.z,
                        rgba: f.rgba,
                        label: f.label,
                    }));
                }
                (false, false) => r.culled += 1,
            }
        }
        r.passed.push(Marked::end());
        r
    }

    /// Plays a frame; also gives the cycle of each output, counted from the first cycle in which a
    /// fragment is offered. An output is a passed item or a fragment that ends here.
    fn play(fragments: &[Fragment], starts: Pattern, ready: &Pattern) -> (Result, Vec<u64>) {
        let cfg = screen(WIDTH, HEIGHT);
        let pixels = cfg.pixels() as usize;
        let mut sim = Sim::<DepthTest>::new(cfg);
        let mut depth: Ram1R1W<u32> = holding(&vec![Z_FAR; pixels], Z_BITS, ReadDuringWrite::New);
        let mut colour: Ram1R1W<u32> =
            holding(&vec![0; pixels], COLOUR_BITS, ReadDuringWrite::Forbidden);
        let frame = fragments.iter().copied().map(Marked::item).chain([Marked::end()]);
        let mut source = Source::new(frame, starts);
        let mut monitor = StreamMonitor::new("passed", "DepthTest", "test");
        let (mut r, mut cycles) = (Result::default(), vec![]);
        for cycle in 0.. {
            assert!(cycle < 10_000, "the end of the frame does not come");
            let passed_ready = ready.at(cycle);
            let i = In { fragment: source.offer(cycle), depth: depth.q(), passed_ready };
            let passed = passed(sim.moore().stage, i.depth).with(passed_ready);
            source.edge(sim.moore().ready);
            let out = sim.clock(i).unwrap().out;
            depth.pass_read(out.depth_read);
            depth.pass_write(out.depth_write);
            edge(&mut depth);
            colour.pass_write(out.colour_write);
            edge(&mut colour);
            monitor.observe(passed).unwrap();
            r.drawn += u32::from(out.drawn);
            r.hidden += u32::from(out.hidden);
            r.culled += u32::from(out.culled);
            if passed.fires() || out.drawn || out.hidden || out.culled {
                cycles.push(cycle);
            }
            if passed.fires() && passed.payload.end {
                r.passed.push(Marked::end());
                break;
            }
            r.passed.extend(passed.fires().then_some(passed.payload));
        }
        // Each fragment reads one depth, each drawn one writes one, whatever stalled.
        let (reads, writes) = (fragments.len() as u64, pixels as u64 + u64::from(r.drawn));
        assert_eq!(traffic(&mut depth), (reads, writes));
        r.depth = contents(&mut depth, cfg.pixels());
        r.colour = contents(&mut colour, cfg.pixels());
        (r, cycles)
    }

    fn at(x: u32, y: u32, z: u32, alpha: u8) -> Fragment {
        Fragment { x, y, z, rgba: rgba(z as u8, 7, 9, alpha), ..Fragment::default() }
    }

    #[test]
    fn one_fragment_a_cycle_two_cycles_from_input_to_output() {
        // One pixel after the other and the same pixel in a row, of every outcome.
        let fragments = [
            at(0, 0, 9, 255),
            at(1, 1, 9, 100),
            at(0, 0, 8, 255),
            at(0, 0, 8, 255),
            at(0, 0, 7, 0),
            at(0, 0, 8, 0),
            at(2, 1, 5, 254),
        ];
        let (_, cycles) = play(&fragments, Pattern::always(), &Pattern::always());
        let expected: Vec<u64> = (0..=fragments.len() as u64).map(|k| k + 2).collect();
        assert_eq!(cycles, expected);
    }

    #[test]
    fn the_same_pixel_in_a_row_sees_the_new_depth() {
        let fragments = [at(1, 0, 50, 255), at(1, 0, 50, 128), at(1, 0, 49, 128)];
        let (r, _) = play(&fragments, Pattern::always(), &Pattern::always());
        let passed = PixelFragment {
            pixel: 1,
            z: 49,
            rgba: rgba(49, 7, 9, 128),
            ..PixelFragment::default()
        };
        assert_eq!(r.passed, [Marked::item(passed), Marked::end()]);
        assert_eq!((r.drawn, r.hidden, r.culled), (1, 0, 1));
    }

    #[test]
    fn of_equal_opaque_fragments_the_first_stays() {
        let opaque =
            |red| Fragment { x: 2, y: 1, z: 5, rgba: rgba(red, 0, 0, 255), ..Fragment::default() };
        let (r, _) = play(&[opaque(1), opaque(2)], Pattern::always(), &Pattern::always());
        assert_eq!(r.colour[5], 0x01_00_00);
        assert_eq!((r.drawn, r.hidden), (1, 1));
    }

    #[test]
    fn nothing_is_seen_at_the_far_plane() {
        let fragments = [at(0, 0, Z_FAR, 255), at(0, 0, Z_FAR, 10), at(0, 1, Z_FAR - 1, 10)];
        let (r, _) = play(&fragments, Pattern::always(), &Pattern::always());
        assert_eq!((r.drawn, r.hidden, r.culled, r.passed.len()), (0, 1, 1, 2));
    }

    proptest! {
        /// Against the plain loop, with gaps before and back-pressure behind.
        #[test]
        fn behaves_as_a_plain_depth_test(
            fragments in proptest::collection::vec(
                (0..WIDTH, 0..HEIGHT, 0u32..6, prop_oneof![Just(255u8), 0u8..255], any::<u8>()),
                0..60,
            ),
            starts in pattern(),
            ready in pattern(),
        ) {
            let fragments: Vec<Fragment> = fragments
                .into_iter()
                .map(|(x, y, z, a, red)| Fragment { x, y, z, rgba: rgba(red, 1, 2, a), ..Fragment::default() })
                .collect();
            prop_assert_eq!(play(&fragments, starts, &ready).0, reference(&fragments));
        }
    }
}
