//! The resolve unit: from the stored fragments of a frame to its blended pixels.
//!
//! ```text
//!          +------+  pixel  +--------+  chain  +-------------+ arrived +--------+ sorted +---------+
//! start -->| Scan |-------->| Lookup |-------->| ChainReader |-------->| Sorter |------->| Blender |
//!          +------+         +--------+         +-------------+         +--------+        +---------+
//!             |               |    |             |   |   |                                 |     |
//!         Occupancy          Ssa  depth         Nsa  | Sections                         colour  done
//!                                                +--------------+
//!                                                | ReleaseQueue |--> release
//!                                                +--------------+
//! ```
//! One fragment a cycle from end to end; `done` comes once the last pixel is written.

use super::chain::{self, ChainReader};
use super::config::Config;
use super::lookup::{self, Chain, Lookup};
use super::occupancy;
use super::release::{self, ReleaseQueue};
use super::scan::{self, Scan};
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use crate::blender::{self, Blender, Sorted};
use crate::pixel::{COLOUR_BITS, Marked, Z_BITS};
use crate::sorter::{self, Arrived, Sorter};
use pellucid_sim::{
    Block, Handshake, Memory, Port, Read, ReadPort, Signals, Stream, WritePort, rtl,
};

/// See the module's description.
pub struct Resolve;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`scan`].
    #[with(*cfg)]
    pub scan: scan::State,
    /// See [`lookup`].
    #[with(*cfg)]
    pub lookup: lookup::State,
    /// See [`chain`].
    #[with(*cfg)]
    pub chain: chain::State,
    /// See [`release`].
    #[with(cfg.release)]
    pub release: release::State,
    /// See [`sorter`].
    #[with(cfg.sorter)]
    pub sorter: sorter::State,
    /// See [`blender`].
    #[with(cfg.screen)]
    pub blender: blender::State,
    /// All pixels are blended; the last sections may still be on their way back.
    pub blended: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`lookup`].
    pub lookup: lookup::Mem,
    /// See [`chain`].
    pub chain: chain::Mem,
    /// See [`release`].
    pub release: release::Mem,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame is stored.
    pub start: bool,
    /// The SSA entry that was asked for.
    #[with(*cfg)]
    pub ssa: Read<SsaEntry>,
    /// The NSA entry that was asked for.
    #[with(*cfg)]
    pub nsa: Read<NsaEntry>,
    /// The occupancy words that were asked for.
    #[with(*cfg)]
    pub occupancy: occupancy::Moore,
    /// The fragment that was asked for.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// The depth that was asked for.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The colour that was asked for.
    #[with(COLOUR_BITS)]
    pub colour: Read<u32>,
}

/// Outputs. The default is what the unit shows while it is not clocked.
#[derive(Clone, Copy, Debug, Default, Signals)]
pub struct Out {
    /// Reads an SSA entry.
    #[with(cfg.screen.pixel_bits())]
    pub ssa_read: ReadPort,
    /// Sets an SSA entry to NULL.
    #[with(cfg.screen.pixel_bits(), *cfg)]
    pub ssa_write: WritePort<SsaEntry>,
    /// Reads an NSA entry.
    #[with(cfg.id_bits(), *cfg)]
    pub nsa: Port<NsaEntry>,
    /// Reads and clears occupancy words.
    #[with(*cfg)]
    pub scan: scan::Out,
    /// Reads a fragment.
    #[with(*cfg)]
    pub read: Stream<Place>,
    /// Reads a pixel's opaque depth.
    #[with(cfg.screen.pixel_bits())]
    pub depth_read: ReadPort,
    /// Reads a pixel's opaque colour.
    #[with(cfg.screen.pixel_bits())]
    pub colour_read: ReadPort,
    /// Writes a pixel's final colour.
    #[with(cfg.screen.pixel_bits(), COLOUR_BITS)]
    pub colour_write: WritePort<u32>,
    /// A section that is given back; it is always taken.
    #[with(cfg.release.id_bits)]
    pub release: Stream<u32>,
    /// Every pixel is written and every section given back.
    pub done: bool,
    /// Pixels to visit.
    #[with(cfg.screen.pixel_bits())]
    pub pixel: Handshake<Marked<u32>>,
    /// Pixels with their chains.
    #[with(*cfg)]
    pub chain: Handshake<Marked<Chain>>,
    /// Fragments that were read back.
    #[with(cfg.sorter)]
    pub arrived: Handshake<Marked<Arrived>>,
    /// Fragments in blending order.
    #[with(cfg.screen)]
    pub sorted: Handshake<Marked<Sorted>>,
    /// A chain is begun to be read.
    pub chain_begun: bool,
    /// The fragment is read in a second pass or later.
    pub read_again: bool,
    /// A stored fragment turned out to be hidden.
    pub culled: bool,
    /// A fragment is blended.
    pub blended: bool,
}

#[rtl(
    check(Resolve, crate::test_util::small(true)),
    check(Resolve, crate::test_util::small(false))
)]
impl Block for Resolve {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        State {
            scan: Scan::reset(cfg),
            lookup: Lookup::reset(cfg),
            chain: ChainReader::reset(cfg),
            release: ReleaseQueue::reset(&cfg.release),
            sorter: Sorter::reset(&cfg.sorter),
            blender: Blender::reset(&cfg.screen),
            blended: false,
        }
    }

    fn memories(cfg: &Config) -> Mem {
        Mem {
            lookup: Lookup::memories(cfg),
            chain: ChainReader::memories(cfg),
            release: ReleaseQueue::memories(&cfg.release),
        }
    }

    fn moore(_: &Config, _: &State, _: &Mem) {}

    #[inline(always)]
    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // What every block shows before its inputs are known.
        let pixel = Scan::moore(cfg, &q.scan, &()).pixel;
        let lookup_ready = Lookup::moore(cfg, &q.lookup, &m.lookup).ready;
        let chain::Moore { ready: chain_ready, arrived } =
            ChainReader::moore(cfg, &q.chain, &m.chain);
        let release = ReleaseQueue::moore(&cfg.release, &q.release, &m.release);
        let sorter = Sorter::moore(&cfg.sorter, &q.sorter, &());

        // From upstream to downstream.
        let to_scan = scan::In {
            start: i.start,
            summary: i.occupancy.summary,
            word: i.occupancy.word,
            pixel_ready: lookup_ready,
        };
        let scan = Scan::next(cfg, &q.scan, &mut d.scan, &mut (), to_scan);
        let to_lookup = lookup::In { pixel, ssa: i.ssa, depth: i.depth, chain_ready };
        let lookup = Lookup::next(cfg, &q.lookup, &mut d.lookup, &mut m.lookup, to_lookup);
        let to_chain = chain::In {
            chain: lookup.chain,
            nsa: i.nsa,
            word: i.word,
            arrived_ready: sorter.ready,
            release_ready: release.ready,
        };
        let reader = ChainReader::next(cfg, &q.chain, &mut d.chain, &mut m.chain, to_chain);
        let to_sorter = sorter::In { arrived, sorted_ready: true };
        Sorter::next(&cfg.sorter, &q.sorter, &mut d.sorter, &mut (), to_sorter);
        let to_blender = blender::In { sorted: sorter.sorted, colour: i.colour };
        let blend = Blender::next(&cfg.screen, &q.blender, &mut d.blender, &mut (), to_blender);
        let to_release = reader.release;
        ReleaseQueue::next(&cfg.release, &q.release, &mut d.release, &mut m.release, to_release);

        let blended = q.blended || blend.frame_done;
        let done = blended && release.empty;
        d.blended = blended && !done;
        Out {
            ssa_read: lookup.ssa_read,
            ssa_write: lookup.ssa_write,
            nsa: reader.nsa,
            scan,
            read: reader.read,
            depth_read: lookup.depth_read,
            colour_read: blend.colour_read,
            colour_write: blend.colour_write,
            release: release.front,
            done,
            pixel: pixel.with(lookup_ready),
            chain: lookup.chain.with(chain_ready),
            arrived: arrived.with(sorter.ready),
            sorted: sorter.sorted.with(true),
            chain_begun: reader.begins,
            read_again: reader.read_again,
            culled: reader.culled,
            blended: blend.blended,
        }
    }
}
