//! Watches the image composition machine: counts what it does and holds its streams to their rules.

use super::merging_unit::{Opaque, STAGES};
use super::transparency::{Transparency, Watch};
use super::{Composer, Config, Out, State, object_engine};
use pellucid_blocks::sequencer::{PHASES, Phase};
use pellucid_machine::monitor::{above, below, seen_from};
use pellucid_machine::outside::{self, Outside};
use pellucid_machine::pixel::{Marked, Screen};
use pellucid_machine::primitive::Primitive;
use pellucid_machine::{
    Arithmetic, Census, Check, Dealer, Fragments, Item, Machine, Memories, Monitor, PhaseCounts,
    PhaseInfo, Ports, Room, Seen, Tally, seen, waits,
};
use pellucid_sim::signals::state_name;
use pellucid_sim::{Deadlock, Figures, StorageInfo, StreamMonitor, Violation};

pellucid_sim::counters! {
    /// Cycles that the machine counts beside those that all count.
    pub struct Cycles {
        /// Drawing opaque primitives and sorting transparent ones, over all frames.
        draw: "cycles",
        /// Merging local images, over all frames: (v + beta) * w + 4 * n for each.
        merge: "cycles",
        /// Merging and adding transparent primitives, until the image is shown, over all frames.
        compose: "cycles",
    }
}

pellucid_sim::counters! {
    /// Figures of the object-order engines and the merger.
    pub struct ComposerCounters {
        /// Frames that were composed.
        frames: "frames",
        /// Cycles in which object-order engines had something to do, of all added up.
        engine_work: "cycles",
        /// The same of the one with the most.
        busiest_engine: "cycles",
        /// From the begin of merging until the first line is complete, in the last frame (T_in).
        first_line: "cycles",
    }
}

/// Where the memories behind the merger are.
const BEHIND: &str = "transparency.";

/// See the module's description.
pub struct ComposerMonitor<T: Transparency> {
    phases: PhaseCounts,
    primitive: StreamMonitor<Marked<Primitive>>,
    merged: StreamMonitor<Opaque>,
    behind: T::Monitor,
    cycles: Cycles,
    frames: u64,
    /// Of each object-order engine, the cycles of work.
    work: Vec<u64>,
    drawn: u64,
    hidden: u64,
    /// Cycles since merging began, until the first line is complete.
    first_line: Option<u64>,
    until_first_line: u64,
    /// Primitives that waited, of all engines added up, at the peak.
    queued: u64,
}

impl<T: Transparency> ComposerMonitor<T> {
    fn streams(&self) -> Vec<Seen> {
        vec![seen(&self.primitive), seen(&self.merged)]
    }
}

impl<T: Transparency> Machine for Composer<T> {
    type Item = Primitive;
    type Monitor = ComposerMonitor<T>;
    const PHASES: &[PhaseInfo] = PHASES;

    fn dealer(cfg: &Self::Config) -> Option<Dealer> {
        let mut engines = cfg.distributor.distribution.engines(cfg.engines());
        // Transparent ones have no turn.
        Some(Box::new(move |item| match item {
            Item::Primitive(primitive) if primitive.opaque => engines.engine(primitive),
            _ => 0,
        }))
    }

    fn arithmetic(cfg: &Self::Config) -> Arithmetic {
        T::arithmetic(&cfg.transparency)
    }

    #[inline(always)]
    fn ports(cfg: &Self::Config, out: &Self::Out) -> Ports {
        Ports {
            phase: out.phase as u8,
            item_ready: out.primitive.ready,
            image: out.image,
            replay: false,
            outside: T::wires(&cfg.transparency, &out.transparency),
        }
    }

    fn port(cfg: &Self::Config) -> outside::Config {
        T::port(&cfg.transparency)
    }

    fn outside(cfg: &Self::Config) -> Option<Outside> {
        T::outside(&cfg.transparency).map(|memory| memory.within("transparency"))
    }

    fn room(cfg: &Self::Config, frame: &Census) -> Option<Room> {
        T::room(&cfg.transparency, frame)
    }

    fn screen(cfg: &Self::Config) -> Screen {
        *cfg.screen()
    }

    fn closed_forms(cfg: &Self::Config, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        let Screen { width, height, .. } = *cfg.screen();
        let line = u64::from(width + cfg.merger.shape.raster.beta);
        let through = u64::from(STAGES * cfg.engines());
        let frame = line * u64::from(height) + through;
        let mut checks = vec![
            Check {
                what: "cycles of merging, (v + beta) * w + 4 * n for each frame",
                expected: frames.len() as u64 * frame,
                found: tally.figure("merge"),
            },
            Check {
                what: "cycles until the first line is merged, v + beta + 4 * n",
                expected: line + through,
                found: tally.figure("first_line"),
            },
        ];
        checks.extend(T::closed_forms(&cfg.transparency, &seen_from(BEHIND, tally), frames));
        checks
    }
}

impl<T: Transparency> Monitor<Composer<T>> for ComposerMonitor<T> {
    fn new(cfg: &Config<T::Config>) -> ComposerMonitor<T> {
        ComposerMonitor {
            phases: PhaseCounts::default(),
            primitive: StreamMonitor::new("primitive", "source", "distributor"),
            merged: StreamMonitor::new("merged", "merger", "transparency"),
            behind: T::Monitor::new(&cfg.transparency),
            cycles: Cycles::default(),
            frames: 0,
            work: vec![0; cfg.engines() as usize],
            drawn: 0,
            hidden: 0,
            first_line: None,
            until_first_line: 0,
            queued: 0,
        }
    }

    // It is so much code that one copy of it is enough.
    #[inline(never)]
    fn observe(
        &mut self,
        cfg: &Config<T::Config>,
        q: &State<T>,
        o: &Out<T>,
    ) -> Result<(), Violation> {
        self.phases.observe(o.phase as u8, o.shows);
        self.behind.observe(&cfg.transparency, &q.transparency, &o.transparency, o.image)?;
        if o.phase == Phase::Clear {
            return Ok(());
        }
        self.primitive.observe(o.primitive)?;
        self.merged.observe(o.merger.merged)?;
        self.cycles.draw += u64::from(o.draws);
        self.cycles.merge += u64::from(o.merges);
        self.cycles.compose += u64::from(o.composes);
        self.drawn += u64::from(o.merger.drawn);
        self.hidden += u64::from(o.merger.hidden);
        let mut queued = 0;
        for (engine, work) in q.merger.engines.iter().zip(&mut self.work) {
            *work += u64::from(object_engine::works(engine));
            queued += u64::from(engine.queue.count);
        }
        self.queued = self.queued.max(queued);
        if let Some(cycles) = &mut self.first_line {
            *cycles += 1;
            if o.merger.line_done {
                self.until_first_line = *cycles;
                self.first_line = None;
            }
        }
        if o.swap {
            self.frames += 1;
            self.first_line = Some(0);
        }
        Ok(())
    }

    fn transfers(&self) -> u64 {
        let streams: u64 = self.streams().iter().map(|stream| stream.tally.transfers).sum();
        streams + self.drawn + self.hidden + self.cycles.merge + self.behind.transfers()
    }

    fn deadlock(&self, cycle: u64, idle: u64, q: &State<T>) -> Deadlock {
        let at = if q.begun { Phase::Store } else { Phase::Idle };
        let mut waits = waits(&self.streams(), |_| state_name(at));
        waits.extend(self.behind.waits(&q.transparency));
        // Who cannot send is the cause.
        if waits.iter().any(|wait| wait.sends) {
            waits.retain(|wait| wait.sends);
        }
        Deadlock { cycle, idle, waits }
    }

    fn tally(&self, cfg: &Config<T::Config>, memories: &[(String, StorageInfo)]) -> Tally {
        let own = ComposerCounters {
            frames: self.frames,
            engine_work: self.work.iter().sum(),
            busiest_engine: self.work.iter().copied().max().unwrap_or(0),
            first_line: self.until_first_line,
        };
        let [inside, around] = below(BEHIND, &together(memories));
        let behind = self.behind.tally(&cfg.transparency, &inside);
        let mut around = Memories::new(&around);
        around.set_peak("merger.engines.queue", self.queued);
        let mut tally = Tally {
            cycles: self.phases.cycles(PHASES),
            further_cycles: self.cycles.figures(),
            fragments: Fragments {
                arrived: self.drawn + self.hidden + behind.fragments.arrived,
                drawn: self.drawn,
                hidden: self.hidden,
                ..behind.fragments
            },
            streams: self.streams().into_iter().map(|stream| stream.tally).collect(),
            memories: around.tallies(),
            own: own.figures(),
            outside: vec![],
            ..behind.clone()
        };
        tally.streams.extend(behind.streams);
        tally.memories.extend(above(BEHIND, behind.memories));
        tally.own.extend(behind.own);
        tally
    }
}

/// The memories of engines of one kind as one, their numbers left out of the name.
fn together(memories: &[(String, StorageInfo)]) -> Vec<(String, StorageInfo)> {
    let mut all: Vec<(String, StorageInfo)> = vec![];
    for (path, info) in memories {
        let parts = path.split('.').map(|part| part.split('[').next().unwrap_or(part));
        let name = parts.collect::<Vec<_>>().join(".");
        match all.iter_mut().find(|(found, _)| *found == name) {
            Some((_, sum)) => {
                sum.words += info.words;
                sum.reads += info.reads;
                sum.writes += info.writes;
                sum.peak_words = sum.peak_words.zip(info.peak_words).map(|(a, b)| a + b);
            }
            None => all.push((name, *info)),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use pellucid_sim::{Ports, ReadDuringWrite};

    #[test]
    fn memories_of_a_kind_are_added_up() {
        let memory = |path: &str, words, reads| {
            let info = StorageInfo {
                ports: Ports::OneReadOneWrite,
                read_during_write: ReadDuringWrite::New,
                latency: 1,
                outside: false,
                words,
                bits_per_word: 8,
                reads,
                writes: 1,
                peak_words: Some(words),
            };
            (path.to_string(), info)
        };
        let all = together(&[
            memory("a[0].x[1].b", 3, 5),
            memory("c", 1, 1),
            memory("a[1].x[0].b", 4, 6),
        ]);
        let seen: Vec<_> =
            all.iter().map(|(n, i)| (n.as_str(), i.words, i.reads, i.writes)).collect();
        assert_eq!(seen, [("a.x.b", 7, 11, 2), ("c", 1, 1, 1)]);
    }
}
