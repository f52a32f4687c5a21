//! The read-back: from the stored fragments of a frame to a stream of them, pixel by pixel.
//!
//! ```text
//!          +------+  pixel  +--------+  chain  +-------------+
//! start -->| Scan |-------->| Lookup |-------->| ChainReader |--> arrived (Stream)
//!          +------+         +--------+         +-------------+
//!             |               |    |             |   |   |
//!         Occupancy          Ssa  depth         Nsa  | Sections
//!                                                +--------------+
//!                                                | ReleaseQueue |--> release
//!                                                +--------------+
//! ```
//! One fragment a cycle from end to end, while all are on chip and no pixel takes a second pass. Where sections are counted
//! out none is released: there is no queue.

use super::config::Config;
use super::lookup::{self, Chain, Lookup};
use super::occupancy;
use super::reader::{self, ChainReader};
use super::release::{self, ReleaseQueue};
use super::scan::{self, Scan};
use super::tables::{NsaEntry, Place, SsaEntry, Word};
use pellucid_machine::pixel::{Arrived, Marked, Z_BITS};
use pellucid_sim::{
    Block, Handshake, Memory, Optional, Port, Read, ReadPort, Signals, Stream, WritePort, rtl,
};

/// See the module's description.
pub struct ReadBack;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// See [`scan`].
    #[with(*cfg)]
    #[block(Scan)]
    pub scan: scan::State,
    /// See [`lookup`].
    #[with(*cfg)]
    #[block(Lookup)]
    pub lookup: lookup::State,
    /// See [`reader`].
    #[with(*cfg)]
    #[block(ChainReader)]
    pub reader: reader::State,
    /// See [`release`].
    #[with(cfg.release)]
    #[exists(!cfg.counts_out())]
    #[block(ReleaseQueue)]
    pub release: release::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// See [`lookup`].
    #[block(Lookup, *cfg)]
    pub lookup: lookup::Mem,
    /// See [`reader`].
    #[block(ChainReader, *cfg)]
    pub reader: reader::Mem,
    /// See [`release`].
    #[block(ReleaseQueue, cfg.release)]
    #[exists(!cfg.counts_out())]
    pub release: Optional<release::Mem>,
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// A frame is stored.
    pub start: bool,
    /// The SSA entry that was asked for.
    #[with(*cfg)]
    pub ssa: Read<SsaEntry>,
    /// SSA entries may be asked for, where the table is cached.
    #[exists(cfg.caches_ssa())]
    pub ssa_ready: bool,
    /// Depths may be asked for, where they lie outside.
    #[exists(cfg.shape.depth_ahead)]
    pub depth_ready: bool,
    /// The NSA entry that was asked for.
    #[with(*cfg)]
    pub nsa: Read<NsaEntry>,
    /// The occupancy words that were asked for.
    #[with(*cfg)]
    pub occupancy: occupancy::Moore,
    /// The oldest fragment that was asked for and is not there yet, if it comes.
    #[with(*cfg)]
    pub word: Read<Word>,
    /// The depth that was asked for. Where depths lie outside, once it is there.
    #[with(Z_BITS)]
    pub depth: Read<u32>,
    /// The receiver takes a fragment.
    pub arrived_ready: bool,
    /// Sections outside may be asked for.
    pub outside_ready: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Fragments of one pixel after the other, then the end of the frame.
    #[with(cfg.screen.pixel_bits(), cfg.shape.weight_bits)]
    pub arrived: Stream<Marked<Arrived>>,
    /// No section is on its way back.
    pub released: bool,
    /// A read is under way; whether the oldest one went outside.
    pub oldest: Stream<bool>,
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
    /// The SSA entry at hand is done with, and the depth.
    pub taken: bool,
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
    /// A section that is given back; it is always taken.
    #[with(cfg.release.id_bits)]
    #[exists(!cfg.counts_out())]
    pub release: Stream<u32>,
    /// Pixels to visit.
    #[with(cfg.screen.pixel_bits())]
    pub pixel: Handshake<Marked<u32>>,
    /// Pixels with their chains.
    #[with(*cfg)]
    pub chain: Handshake<Marked<Chain>>,
    /// A chain is begun to be read.
    pub chain_begun: bool,
    /// The fragment is read in a second pass or later.
    pub read_again: bool,
    /// A stored fragment turned out to be hidden.
    pub culled: bool,
}

#[rtl(
    check(ReadBack, crate::test_util::small(true)),
    check(ReadBack, crate::test_util::small(false)),
    check(ReadBack, crate::test_util::small_newest_first()),
    check(ReadBack, crate::test_util::small_owned(false))
)]
impl Block for ReadBack {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let reader = ChainReader::moore(cfg, &q.reader, &m.reader);
        let mut released = true;
        if !cfg.counts_out() {
            released = ReleaseQueue::moore(&cfg.release, &q.release, &m.release).empty;
        }
        Moore { arrived: reader.arrived, released, oldest: reader.oldest }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // What every block shows before its inputs are known.
        let pixel = Scan::moore(cfg, &q.scan, &()).pixel;
        let mut lookup_ready = Lookup::moore(cfg, &q.lookup, &m.lookup).ready;
        let mut asked = pixel;
        if cfg.caches_ssa() {
            lookup_ready &= i.ssa_ready;
            asked.valid &= i.ssa_ready;
        }
        if cfg.shape.depth_ahead {
            lookup_ready &= i.depth_ready;
            asked.valid &= i.depth_ready;
        }
        let chain_ready = ChainReader::moore(cfg, &q.reader, &m.reader).ready;
        let (mut release, mut release_ready) = (Stream::idle(), true);
        if !cfg.counts_out() {
            let seen = ReleaseQueue::moore(&cfg.release, &q.release, &m.release);
            release = seen.front;
            release_ready = seen.ready;
        }

        // From upstream to downstream.
        let to_scan = scan::In {
            start: i.start,
            summary: i.occupancy.summary,
            word: i.occupancy.word,
            pixel_ready: lookup_ready,
        };
        let scan = Scan::next(cfg, &q.scan, &mut d.scan, &mut (), to_scan);
        let to_lookup = lookup::In { pixel: asked, ssa: i.ssa, depth: i.depth, chain_ready };
        let lookup = Lookup::next(cfg, &q.lookup, &mut d.lookup, &mut m.lookup, to_lookup);
        let to_reader = reader::In {
            chain: lookup.chain,
            nsa: i.nsa,
            word: i.word,
            arrived_ready: i.arrived_ready,
            release_ready,
            outside_ready: i.outside_ready,
        };
        let reader = ChainReader::next(cfg, &q.reader, &mut d.reader, &mut m.reader, to_reader);
        if !cfg.counts_out() {
            let to_release = reader.release;
            ReleaseQueue::next(
                &cfg.release,
                &q.release,
                &mut d.release,
                &mut m.release,
                to_release,
            );
        }

        Out {
            ssa_read: lookup.ssa_read,
            ssa_write: lookup.ssa_write,
            taken: lookup.taken,
            nsa: reader.nsa,
            scan,
            read: reader.read,
            depth_read: lookup.depth_read,
            release,
            pixel: pixel.with(lookup_ready),
            chain: lookup.chain.with(chain_ready),
            chain_begun: reader.begins,
            read_again: reader.read_again,
            culled: reader.culled,
        }
    }
}

#[cfg(test)]
mod tests;
