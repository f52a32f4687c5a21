//! The early depth test: drops hidden fragments before they are counted, once the depth of all that is opaque is known.
//!
//! ```text
//!               +-----------+
//!  fragment --->|           |---> passed (Stream)
//!  ready <------| EarlyTest |<--- passed_taken
//!  depth ------>|           |---> depth read
//!               +-----------+
//! ```
//! One fragment a cycle, one cycle from input to output. What it drops is the same in each play. While it does not test
//! everything goes through. In a frame's own depth test, where opaque fragments are drawn, use a
//! [`DepthTest`](pellucid_blocks::depth_test).

use pellucid_machine::pixel::{Fragment, Marked, Screen, Z_BITS, is_opaque};
use pellucid_sim::{Block, Read, ReadPort, Signals, Stream, rtl};

/// See the module's description.
pub struct EarlyTest;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// The fragment whose pixel's depth was asked for.
    #[with(*cfg)]
    pub stage: Stream<Marked<Fragment>>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Fragments, then the end of the play.
    #[with(*cfg)]
    pub fragment: Stream<Marked<Fragment>>,
    /// Hidden ones are dropped. It stays from a play's first fragment to its end.
    pub tests: bool,
    /// The depth that was asked for.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The receiver takes what passes.
    pub passed_taken: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// The fragment whose pixel's depth was asked for: see [`passed`].
    #[with(*cfg)]
    pub stage: Stream<Marked<Fragment>>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(Screen)]
pub struct Out {
    /// The fragment is taken.
    pub taken: bool,
    /// Reads a pixel's depth.
    #[with(cfg.pixel_bits())]
    pub depth_read: ReadPort,
    /// A transparent fragment is dropped in this cycle: it is hidden.
    pub culled: bool,
}

/// What is passed on, before inputs are known.
#[inline(always)]
#[rtl]
pub fn passed(
    stage: Stream<Marked<Fragment>>,
    depth: Read<u32>,
    tests: bool,
) -> Stream<Marked<Fragment>> {
    let visible = !tests || stage.payload.item.z < depth.data;
    Stream { valid: stage.valid && (stage.payload.end || visible), payload: stage.payload }
}

#[rtl(check(EarlyTest, crate::test_util::screen(5, 3)))]
impl Block for EarlyTest {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = ();

    fn reset(cfg: &Screen) -> State {
        cfg.check();
        State { stage: Stream::idle() }
    }

    fn memories(_: &Screen) {}

    fn moore(_: &Screen, q: &State, (): &()) -> Moore {
        Moore { stage: q.stage }
    }

    fn next(cfg: &Screen, q: &State, d: &mut State, (): &mut (), i: In) -> Out {
        let passes = passed(q.stage, i.depth, i.tests).valid;
        let free = !passes || i.passed_taken;
        let mut depth_read = ReadPort::default();
        if free {
            d.stage = i.fragment;
            let Marked { end, item } = i.fragment.payload;
            if i.fragment.valid && !end && i.tests {
                depth_read.read(item.y * cfg.width + item.x);
            }
        }
        let transparent = !is_opaque(q.stage.payload.item.rgba);
        Out { taken: free, depth_read, culled: q.stage.valid && transparent && !passes }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::{Pattern, Source, edge, holding, pattern, screen};
    use pellucid_sim::{ReadDuringWrite, Sim};
    use proptest::prelude::*;

    /// The numbers of those that pass, in order, and the cycle in which the end does.
    fn play(
        depths: &[u32],
        fragments: &[(u32, u32)],
        tests: bool,
        starts: Pattern,
        taken: &Pattern,
    ) -> (Vec<u32>, u64) {
        let items = (0..).zip(fragments).map(|(rgba, (x, z))| {
            Marked::item(Fragment { x: *x, z: *z, rgba, ..Fragment::default() })
        });
        let mut source = Source::new(items.chain([Marked::end()]), starts);
        let mut sim = Sim::<EarlyTest>::new(screen(depths.len() as u32, 1));
        let mut memory = holding(depths, Z_BITS, ReadDuringWrite::New);
        let mut seen = vec![];
        for cycle in 0.. {
            assert!(cycle < 10_000, "the end of the play does not come");
            let passed = passed(sim.moore().stage, memory.q(), tests).with(taken.at(cycle));
            if passed.fires() && passed.payload.end {
                return (seen, cycle);
            }
            seen.extend(passed.fires().then_some(passed.payload.item.rgba));
            let (depth, passed_taken) = (memory.q(), taken.at(cycle));
            let i = In { fragment: source.offer(cycle), tests, depth, passed_taken };
            let out = sim.clock(i).unwrap().out;
            memory.pass_read(out.depth_read);
            edge(&mut memory);
            source.edge(out.taken);
        }
        unreachable!()
    }

    proptest! {
        #[test]
        fn what_is_in_front_passes_in_order(
            fragments in prop::collection::vec((0..3u32, 0..9u32), 0..40),
            tests: bool, starts in pattern(), taken in pattern(),
        ) {
            let depths = [0, 4, 9];
            let expected: Vec<u32> = (0..)
                .zip(&fragments)
                .filter(|(_, (x, z))| !tests || *z < depths[*x as usize])
                .map(|(number, _)| number)
                .collect();
            prop_assert_eq!(play(&depths, &fragments, tests, starts, &taken).0, expected);
        }
    }

    #[test]
    fn one_fragment_a_cycle() {
        let always = Pattern::always();
        let fragments = [(1, 3), (1, 4), (0, 0), (2, 8)];
        assert_eq!(play(&[0, 4, 9], &fragments, true, always.clone(), &always), (vec![0, 3], 5));
    }
}
