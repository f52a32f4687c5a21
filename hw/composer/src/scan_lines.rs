//! The scan-line engines together, and the global frame buffer that they fill and that is shown.
//!
//! ```text
//!               +----------+ results +--------+   +---------------------+
//!  primitive -->| ScanLine |-------->| Raster |-->| global frame buffer |--> image (Stream)
//!  (to each)    +----------+         |        |   | (two banks),        |
//!  merged ----->| ScanLine |-------->|        |   | Scanout             |
//!  (by line)    +----------+         +--------+   +---------------------+
//!               | ...      |
//! ```
//! Of `engines` engines, each has every so-manieth line. The lines of the result go to the frame buffer in
//! order, each once it is complete: a pixel a cycle, then `beta` cycles of overhead. Then the banks change
//! places and the image is shown, while the next one is rendered.

pub mod monitor;

use super::raster::{self, Raster};
use super::scan_line::{self, ScanLine};
use super::transparency::{In, Moore};
use pellucid_blocks::scanout::{self, Scanout};
use pellucid_machine::pixel::{COLOUR_BITS, Screen};
use pellucid_machine::{InConfig, outside};
use pellucid_sim::{
    Block, Memory, Ram1R1W, ReadDuringWrite, Registers, Signals, Stream, bits_for, check_range, rtl,
};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct ScanLines;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Scan-line engines, at least 1 and at most the rows of the screen.
    pub engines: u32,
    /// The first of them.
    pub engine: scan_line::Config,
    /// The screen, and the overhead of its scan lines.
    pub raster: raster::Config,
}

impl Config {
    fn screen(&self) -> &Screen {
        &self.raster.screen
    }
    /// A bank is filled before it is shown again.
    fn scanout(&self) -> scanout::Config {
        scanout::Config { screen: *self.screen(), wipes: false }
    }
    fn count_bits(&self) -> u32 {
        bits_for(u64::from(self.engines))
    }
    fn lost_bits(&self) -> u32 {
        bits_for(u64::from(self.engines) * u64::from(self.screen().width))
    }
    fn engine_bits(&self) -> u32 {
        bits_for(u64::from(self.engines - 1))
    }
    /// The engine of that number.
    pub fn engine(&self, index: u32) -> scan_line::Config {
        let mut engine = self.engine;
        engine.bucket_sort.index = index;
        engine
    }
}

/// The engine whose turn it is after `turn`.
#[inline(always)]
#[rtl]
fn after(cfg: &Config, turn: u32) -> u32 {
    if turn + 1 == cfg.engines { 0 } else { turn + 1 }
}

/// Registers.
#[derive(Clone, Debug, Registers)]
pub struct State {
    /// The engine that has the line that is being merged.
    #[width(cfg.engine_bits())]
    pub merges: u32,
    /// The engines.
    #[with(cfg.engine(k as u32))]
    #[len(cfg.engines)]
    pub engines: Vec<scan_line::State>,
    /// Results on their way to the frame buffer.
    #[with(cfg.raster)]
    pub collect: raster::State,
    /// The engine that has the line that is collected.
    #[width(cfg.engine_bits())]
    pub from: u32,
    /// A part of it has gone.
    pub part: bool,
    /// The next pixel that is collected.
    #[width(cfg.screen().pixel_bits())]
    pub pixel: u32,
    /// The image is complete and waits to be shown.
    pub complete: bool,
    /// The second bank is shown.
    pub second_is_shown: bool,
    /// See [`scanout`].
    #[with(cfg.scanout())]
    pub scanout: scanout::State,
}

/// Outputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Out {
    /// Engines that gave a transparent fragment for the last time.
    #[width(cfg.count_bits())]
    pub fragments: u32,
    /// Those of which it is hidden.
    #[width(cfg.count_bits())]
    pub hidden: u32,
    /// Engines that blended a fragment: a pixel's opaque one or a transparent one.
    #[width(cfg.count_bits())]
    pub blended: u32,
    /// Columns of primitives for which there was no place.
    #[width(cfg.lost_bits())]
    pub lost: u32,
    /// A pixel of the result goes to the frame buffer.
    pub collects: bool,
    /// Results of the line that is collected are there.
    pub line_complete: bool,
    /// A line of them is in the frame buffer.
    pub line_done: bool,
    /// All of them are.
    pub frame_done: bool,
    /// An image is complete, and is shown from the next cycle on.
    pub show: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// The engines.
    pub engines: Vec<scan_line::Mem>,
    /// Colours of the global frame buffer, first bank.
    pub first: Ram1R1W<u32>,
    /// Colours of the global frame buffer, second bank.
    pub second: Ram1R1W<u32>,
    /// See [`scanout`].
    pub scanout: scanout::Mem,
}

#[rtl(
    input = InConfig { screen: cfg.raster.screen, outside: outside::Config::NONE },
    moore = cfg.raster.screen,
    check(ScanLines, crate::test_util::scan_lines(1)),
    check(ScanLines, crate::test_util::scan_lines(3))
)]
impl Block for ScanLines {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = Out;
    type Mem = Mem;

    fn reset(cfg: &Config) -> State {
        check_range("the number of scan-line engines", cfg.engines, 1..=cfg.screen().height);
        State {
            merges: 0,
            engines: (0..cfg.engines).map(|k| ScanLine::reset(&cfg.engine(k))).collect(),
            collect: Raster::reset(&cfg.raster),
            from: 0,
            part: false,
            pixel: 0,
            complete: false,
            second_is_shown: false,
            scanout: Scanout::reset(&cfg.scanout()),
        }
    }

    fn memories(cfg: &Config) -> Mem {
        let bank =
            || Ram1R1W::new(cfg.screen().pixels(), COLOUR_BITS, 1, ReadDuringWrite::Forbidden);
        Mem {
            engines: (0..cfg.engines).map(|k| ScanLine::memories(&cfg.engine(k))).collect(),
            first: bank(),
            second: bank(),
            scanout: Scanout::memories(&cfg.scanout()),
        }
    }

    fn moore(cfg: &Config, q: &State, m: &Mem) -> Moore {
        let collect = Raster::moore(&cfg.raster, &q.collect, &());
        let scanout = Scanout::moore(&cfg.scanout(), &q.scanout, &m.scanout);
        let (mut ready, mut sorted) = (true, true);
        for k in 0..cfg.engines {
            let engine =
                ScanLine::moore(&cfg.engine(k), &q.engines[k as usize], &m.engines[k as usize]);
            ready &= engine.ready;
            sorted &= engine.sorted;
        }
        Moore {
            ready,
            sorted,
            merged_ready: true,
            busy: collect.runs || q.complete,
            waits: q.complete,
            image: scanout.image,
            shows: scanout.busy,
        }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, m: &mut Mem, i: In) -> Out {
        // A primitive goes to all engines at once, and a line of the result is collected once it is complete.
        let collect = Raster::moore(&cfg.raster, &q.collect, &());
        let mut ready = true;
        let mut result = Stream::idle();
        let mut line_complete = false;
        for k in 0..cfg.engines {
            let engine =
                ScanLine::moore(&cfg.engine(k), &q.engines[k as usize], &m.engines[k as usize]);
            ready &= engine.ready;
            if q.from == k {
                result = engine.result;
                line_complete = engine.line_complete;
            }
        }
        let collects = collect.pixel && result.valid && (q.part || line_complete);
        let to_collect = raster::In { start: i.swap, moves: collects };
        let counted = Raster::next(&cfg.raster, &q.collect, &mut d.collect, &mut (), to_collect);
        if collects {
            d.part = true;
            d.pixel = if q.pixel + 1 == cfg.screen().pixels() { 0 } else { q.pixel + 1 };
            if q.second_is_shown {
                m.first.write(q.pixel, result.payload);
            } else {
                m.second.write(q.pixel, result.payload);
            }
        }
        if counted.line_done {
            d.part = false;
            d.from = after(cfg, q.from);
        }
        if i.line_merged {
            d.merges = after(cfg, q.merges);
        }
        if i.swap {
            d.from = 0;
            d.merges = 0;
        }

        // The engines.
        let (mut fragments, mut hidden, mut blended, mut lost) = (0, 0, 0, 0);
        for k in 0..cfg.engines {
            let merges = q.merges == k;
            let to_engine = scan_line::In {
                primitive: Stream {
                    valid: i.primitive.valid && ready,
                    payload: i.primitive.payload,
                },
                swap: i.swap,
                merged: Stream { valid: i.merged.valid && merges, payload: i.merged.payload },
                line_merged: i.line_merged && merges,
                result_ready: collects && q.from == k,
                clear: i.clear,
            };
            let did = ScanLine::next(
                &cfg.engine(k),
                &q.engines[k as usize],
                &mut d.engines[k as usize],
                &mut m.engines[k as usize],
                to_engine,
            );
            fragments += u32::from(did.fragment);
            hidden += u32::from(did.hidden);
            blended += u32::from(did.blended);
            lost += did.lost;
        }

        // A complete image is shown once the one before has gone out.
        let scanout = Scanout::moore(&cfg.scanout(), &q.scanout, &m.scanout);
        let complete = q.complete || counted.frame_done;
        let show = complete && !scanout.busy;
        d.complete = complete && !show;
        d.second_is_shown = q.second_is_shown ^ show;
        let colour = if q.second_is_shown { m.second.q() } else { m.first.q() };
        let to_scanout = scanout::In { start: show, colour, image_ready: i.image_ready };
        let shown =
            Scanout::next(&cfg.scanout(), &q.scanout, &mut d.scanout, &mut m.scanout, to_scanout);
        if q.second_is_shown {
            m.second.pass_read(shown.read);
        } else {
            m.first.pass_read(shown.read);
        }

        Out {
            fragments,
            hidden,
            blended,
            lost,
            collects,
            line_complete: collect.runs && line_complete,
            line_done: counted.line_done,
            frame_done: counted.frame_done,
            show,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_util::scan_lines;

    #[test]
    #[should_panic(expected = "the number of scan-line engines is 6: expected 1 to 5")]
    fn an_engine_has_a_line() {
        ScanLines::reset(&scan_lines(6));
    }
}
