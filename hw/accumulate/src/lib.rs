//! Accumulation (seed 004): several frames as one image, by a tree of averages, a buffer of sums, or blending.
//!
//! ```text
//!              +---------+ frame       +-------------+
//!  fragment -->| TBuffer |------------>| Accumulator |--> image
//!              |         | (colours)   |             |
//!              +---------+             +-------------+
//! ```
//! A [T-buffer](pellucid_tbuffer) draws each frame. As it shows one, the accumulator merges it, pixel by pixel, into what stands of
//! the image, while the next frame is drawn. With the last frame of an image its pixels go out.

pub mod accumulator;
pub mod architecture;
pub mod bound;
pub mod branching;
pub mod colour;
pub mod config;
pub mod golden;
pub mod level;
pub mod monitor;
pub mod node;
pub mod planes;
pub mod sums;
pub mod tree;
pub mod weights;

#[cfg(test)]
mod test_util;

use accumulator::Accumulator;
use config::Config;
use pellucid_blocks::allocator::Chosen;
use pellucid_blocks::arbiter::{self, Arbiter};
use pellucid_blocks::front::{self, Phase};
use pellucid_machine::pixel::COLOUR_BITS;
use pellucid_machine::{FragmentIn, InConfig, PhaseInfo, outside};
use pellucid_sim::{Block, Handshake, Memory, Optional, Registers, Signals, Stream, rtl};
use pellucid_tbuffer::TBuffer;

/// The machine.
#[derive(Clone, Copy, Debug)]
pub struct Accumulate;

/// What the machine is at.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub enum MachinePhase {
    /// After reset: clearing its memories.
    #[default]
    Clear,
    /// Ready for a frame.
    Idle,
    /// Storing a frame's fragments.
    Store,
    /// Turning fragments into a frame.
    Resolve,
    /// The frame is done, but the one before is still being shown.
    Wait,
    /// Merging a frame into the image, and nothing else.
    Accumulate,
}

/// The same by name, in the order of [`MachinePhase`].
pub const PHASES: &[PhaseInfo] = &[
    front::PHASES[Phase::Clear as usize],
    front::PHASES[Phase::Idle as usize],
    front::PHASES[Phase::Store as usize],
    front::PHASES[Phase::Resolve as usize],
    front::PHASES[Phase::Wait as usize],
    PhaseInfo {
        name: "accumulate",
        about: "Merging frames into their image while no frame is drawn; none where each frame is an image.",
        works: true,
        counts: true,
    },
];

/// Registers.
#[derive(Clone, Registers)]
pub struct State {
    /// See [`pellucid_tbuffer`].
    #[with(cfg.tbuffer)]
    #[block(TBuffer<Chosen>)]
    pub tbuffer: pellucid_tbuffer::State<Chosen>,
    /// See [`accumulator`].
    #[with(*cfg)]
    #[block(Accumulator)]
    pub accumulator: accumulator::State,
    /// T-buffer and planes take turns at the port.
    #[with(cfg.arbiter())]
    #[exists(cfg.shares())]
    #[block(Arbiter, cfg.arbiter())]
    pub turns: arbiter::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Whose words come.
    #[block(Arbiter, cfg.arbiter())]
    #[exists(cfg.shares())]
    pub turns: Optional<arbiter::Mem>,
    /// See [`pellucid_tbuffer`].
    #[block(TBuffer<Chosen>, cfg.tbuffer)]
    pub tbuffer: pellucid_tbuffer::Mem<Chosen>,
    /// See [`accumulator`].
    #[block(Accumulator, *cfg)]
    pub accumulator: accumulator::Mem,
}

/// What can be seen of the machine in a cycle: its ports, the frames between its blocks, and what its blocks did.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// What the machine is at.
    pub phase: MachinePhase,
    /// What can be seen of the T-buffer: its image is a frame.
    #[with(cfg.tbuffer)]
    pub tbuffer: pellucid_tbuffer::Out,
    /// The finished image goes out, pixel by pixel, `0xRRGGBB`.
    #[with(COLOUR_BITS)]
    pub image: Handshake<u32>,
    /// What the accumulator did.
    #[with(*cfg)]
    pub accumulator: accumulator::Out,
    /// The port to outside memory, where planes lie there; else the T-buffer's.
    #[with(cfg.port())]
    #[exists(cfg.outside())]
    pub outside: outside::Wires,
}

#[rtl(
    name = "accumulate",
    input = InConfig { screen: cfg.screen, outside: cfg.port() },
    moore = (),
    check(Accumulate, crate::test_util::small(&[("frames", "2")])),
    check(Accumulate, crate::test_util::small(&[("frames", "2"), ("method", "buffer")])),
    check(Accumulate, crate::test_util::outside(&[("frames", "2"), ("method", "buffer"), ("sum_bits", "24")])),
    check(Accumulate, crate::test_util::outside(&[("frames", "4"), ("tbuffer.outside_sections", "0")])),
    check(Accumulate, crate::test_util::outside(&[("frames", "2"), ("tbuffer.outside_sections", "0"), ("tbuffer.ssa", "cached"), ("tbuffer.ssa_sets", "1")]))
)]
impl Block for Accumulate {
    type Config = Config;
    type State = State;
    type In = FragmentIn;
    type Moore = ();
    type Out = Out;
    type Mem = Mem;

    fn moore(_: &Config, _: &State, _: &Mem) {}

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: FragmentIn) -> Out {
        let given = Accumulator::moore(cfg, &q.accumulator, &m.accumulator);
        // What T-buffer and planes see of the outside memory.
        let (mut of_tbuffer, mut of_planes) = (i.outside, i.outside);
        if cfg.shares() {
            let turns = Arbiter::moore(&cfg.arbiter(), &q.turns, &m.turns);
            of_tbuffer = arbiter::client(&0, turns, i.outside);
            let word = of_tbuffer.response.payload;
            of_tbuffer.response.payload = outside::cut(&cfg.tbuffer.port.memory(), word);
            of_planes = arbiter::client(&1, turns, i.outside);
        } else if cfg.outside() {
            of_tbuffer = outside::In::default();
        }
        let to_tbuffer =
            FragmentIn { fragment: i.fragment, image_ready: given.ready, outside: of_tbuffer };
        let tbuffer = TBuffer::<Chosen>::next(
            &cfg.tbuffer,
            &q.tbuffer,
            &mut d.tbuffer,
            &mut m.tbuffer,
            to_tbuffer,
        );
        let Handshake { valid, ready, payload } = tbuffer.image;
        let to_accumulator = accumulator::In {
            frame: Stream { valid: valid && ready, payload },
            image_ready: i.image_ready,
            memory: of_planes,
        };
        let accumulator = Accumulator::next(
            cfg,
            &q.accumulator,
            &mut d.accumulator,
            &mut m.accumulator,
            to_accumulator,
        );

        let mut outside = tbuffer.chains.outside;
        if cfg.tbuffer.front.outside() {
            outside = tbuffer.outside;
        }
        let mut request = accumulator.request;
        if cfg.shares() {
            let of_tbuffer = outside.request;
            let of_tbuffer = Stream { valid: of_tbuffer.valid, payload: of_tbuffer.payload };
            let to_turns = arbiter::In {
                request: [of_tbuffer, request, Stream::idle(), Stream::idle()],
                memory: i.outside,
            };
            request = Arbiter::next(&cfg.arbiter(), &q.turns, &mut d.turns, &mut m.turns, to_turns)
                .request;
        }
        if cfg.outside() {
            // What was asked for always finds room.
            outside = outside::Wires {
                request: request.with(i.outside.ready),
                response: i.outside.response.with(true),
            };
        }

        let merges = cfg.frames() > 1 && (tbuffer.events.scanout || given.busy);
        let phase = match tbuffer.phase {
            Phase::Clear => MachinePhase::Clear,
            Phase::Idle => {
                if merges {
                    MachinePhase::Accumulate
                } else {
                    MachinePhase::Idle
                }
            }
            Phase::Store => MachinePhase::Store,
            Phase::Resolve => MachinePhase::Resolve,
            Phase::Wait => {
                if merges {
                    MachinePhase::Accumulate
                } else {
                    MachinePhase::Wait
                }
            }
        };
        Out { phase, tbuffer, image: given.image.with(i.image_ready), accumulator, outside }
    }
}
