//! Watches the scan-line engines.

use super::{Config, Out, ScanLines, State};
use crate::composer::scan_line;
use crate::composer::transparency::{Transparency, Watch};
use crate::machine::Fragments;
use crate::primitive::{Primitive, Span, next_row, span};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Figure, Figures, Violation};

pellucid_sim::counters! {
    /// Figures of the scan-line engines.
    pub struct Own {
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

/// Pixels of a primitive whose rows are those of a screen of this width, one by one.
fn pixels(primitive: &Primitive, width: u32) -> u64 {
    let mut at = *primitive;
    let mut pixels = 0;
    for _ in primitive.row..=primitive.last_row {
        let Span { empty, first, last } = span(at.edges, width);
        pixels += if empty { 0 } else { u64::from(last - first) + 1 };
        at = next_row(at);
    }
    pixels
}

impl Transparency for ScanLines {
    type Monitor = ScanLinesMonitor;
}

impl Watch<ScanLines> for ScanLinesMonitor {
    fn new(cfg: &Config) -> ScanLinesMonitor {
        ScanLinesMonitor {
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
    fn observe(&mut self, cfg: &Config, q: &State, o: &Out) -> Result<(), Violation> {
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

    fn state(block: &str, q: &State) -> Option<&'static str> {
        match block {
            "scanout" => Some(state_name(q.scanout.fsm)),
            _ => None,
        }
    }

    fn fragments(&self) -> Fragments {
        // Each pixel has one opaque fragment.
        Fragments { blended: self.blends.saturating_sub(self.collected), ..self.fragments }
    }

    fn dropped_since(&self) -> &'static str {
        "a frame or a line had too many primitives (see `primitives` and `line_primitives`)"
    }

    fn own(&self) -> Vec<Figure> {
        let own = Own {
            scan_line_work: self.work.iter().sum(),
            busiest_scan_line_engine: self.work.iter().copied().max().unwrap_or(0),
            last_line: self.last_line,
            lost_primitives: self.lost_primitives,
        };
        own.figures()
    }

    fn peak_words(&self, name: &str) -> Option<u64> {
        let p = &self.peak;
        match name {
            "engines.down.buckets.items" | "engines.down.buckets.next" => Some(p.down),
            "engines.down.active" => Some(p.active_down),
            "engines.along.buckets.items" | "engines.along.buckets.next" => Some(p.along),
            "engines.along.active" => Some(p.active_along),
            "engines.opaque" => Some(p.opaque),
            "engines.results" => Some(p.results),
            _ => None,
        }
    }
}
