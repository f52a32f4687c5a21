//! Watches the scan-line engines.

use super::{Config, Out, ScanLines, State};
use crate::scan_line;
use crate::transparency::{Transparency, Watch};
use pellucid_machine::primitive::pixels;
use pellucid_machine::{Arithmetic, Census, Check, Fragments, Memories, Tally, seen, waits};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Figures, Handshake, StorageInfo, StreamMonitor, Violation, Wait};

pellucid_sim::counters! {
    /// Figures of the scan-line engines.
    pub struct ScanLineCounters {
        /// Cycles in which scan-line engines swept along a line, of all added up.
        scan_line_work: "cycles",
        /// The same of the one with the most.
        busiest_scan_line_engine: "cycles",
        /// From the last line's completion until it is in the global frame buffer, in the last frame (T_out).
        last_line: "cycles",
        /// Transparent primitives for which there was no place in an engine.
        lost_primitives: "primitives",
    }
}

/// See the module's description.
pub struct ScanLinesMonitor {
    image: StreamMonitor<u32>,
    /// Of each engine, the cycles of work.
    work: Vec<u64>,
    fragments: Fragments,
    /// Fragments that were blended, opaque ones included, and pixels that came of them.
    blends: u64,
    collected: u64,
    lost_primitives: u64,
    /// Cycles since the line that is collected was complete.
    collecting: u64,
    last_line: u64,
    peak: Peak,
}

/// The most words in use, of the engines added up.
#[derive(Default)]
struct Peak {
    down: u64,
    active_down: u64,
    along: u64,
    active_along: u64,
    opaque: u64,
    results: u64,
}

impl Transparency for ScanLines {
    type Monitor = ScanLinesMonitor;

    fn arithmetic(_: &Config) -> Arithmetic {
        Arithmetic::BLEND
    }

    fn closed_forms(cfg: &Config, tally: &Tally, _: &[Census]) -> Vec<Check> {
        vec![Check {
            what: "cycles from the last line's completion until it is collected, v + beta",
            expected: u64::from(cfg.screen().width + cfg.raster.beta),
            found: tally.figure("last_line"),
        }]
    }
}

impl Watch<ScanLines> for ScanLinesMonitor {
    fn new(cfg: &Config) -> ScanLinesMonitor {
        ScanLinesMonitor {
            image: StreamMonitor::new("image", "scanout", "display"),
            work: vec![0; cfg.engines as usize],
            fragments: Fragments::default(),
            blends: 0,
            collected: 0,
            lost_primitives: 0,
            collecting: 0,
            last_line: 0,
            peak: Peak::default(),
        }
    }

    #[inline(always)]
    fn observe(
        &mut self,
        cfg: &Config,
        q: &State,
        o: &Out,
        image: Handshake<u32>,
    ) -> Result<(), Violation> {
        self.image.observe(image)?;
        let f = &mut self.fragments;
        f.arrived += u64::from(o.fragments) + u64::from(o.lost);
        f.culled += u64::from(o.hidden);
        f.stored += u64::from(o.fragments - o.hidden);
        f.dropped += u64::from(o.lost);
        self.blends += u64::from(o.blended);
        let mut now = Peak::default();
        for (k, q) in q.engines.iter().enumerate() {
            self.work[k] += u64::from(q.along.runs);
            if let Some(primitive) = scan_line::lost(&cfg.engine(k as u32), q) {
                let lost = pixels(&primitive, cfg.screen().width);
                self.lost_primitives += 1;
                self.fragments.arrived += lost;
                self.fragments.dropped += lost;
            }
            now.down += q.down.buckets.iter().map(|b| u64::from(b.filled)).sum::<u64>();
            now.active_down += u64::from(q.down.active.count);
            now.along += q.along.buckets.iter().map(|b| u64::from(b.filled)).sum::<u64>();
            now.active_along += u64::from(q.along.active.count);
            now.opaque += u64::from(q.opaque.count);
            now.results += u64::from(q.results.count);
        }
        let p = &mut self.peak;
        p.down = p.down.max(now.down);
        p.active_down = p.active_down.max(now.active_down);
        p.along = p.along.max(now.along);
        p.active_along = p.active_along.max(now.active_along);
        p.opaque = p.opaque.max(now.opaque);
        p.results = p.results.max(now.results);
        self.collected += u64::from(o.collects);
        if o.line_complete || self.collecting > 0 {
            self.collecting += 1;
        }
        if o.line_done {
            self.last_line = self.collecting;
            self.collecting = 0;
        }
        Ok(())
    }

    fn transfers(&self) -> u64 {
        self.image.transfers + self.collected + self.blends + self.fragments.arrived
    }

    fn waits(&self, q: &State) -> Vec<Wait> {
        waits(&[seen(&self.image)], |_| state_name(q.scanout.fsm))
    }

    fn tally(&self, _: &Config, memories: &[(String, StorageInfo)]) -> Tally {
        let own = ScanLineCounters {
            scan_line_work: self.work.iter().sum(),
            busiest_scan_line_engine: self.work.iter().copied().max().unwrap_or(0),
            last_line: self.last_line,
            lost_primitives: self.lost_primitives,
        };
        let p = &self.peak;
        let mut memories = Memories::new(memories);
        for (path, words) in [
            ("engines.down.buckets.items", p.down),
            ("engines.down.buckets.next", p.down),
            ("engines.down.active", p.active_down),
            ("engines.along.buckets.items", p.along),
            ("engines.along.buckets.next", p.along),
            ("engines.along.active", p.active_along),
            ("engines.opaque", p.opaque),
            ("engines.results", p.results),
        ] {
            memories.set_peak(path, words);
        }
        Tally {
            // Each pixel has one opaque fragment.
            fragments: Fragments {
                blended: self.blends.saturating_sub(self.collected),
                ..self.fragments
            },
            dropped_since: "a frame or a line had too many primitives (see `primitives` and `line_primitives`)",
            streams: vec![seen(&self.image).tally],
            memories: memories.tallies(),
            own: own.figures(),
            outside: vec![],
            ..Tally::default()
        }
    }
}
