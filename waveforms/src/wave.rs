//! A waveform under way: what changes from cycle to cycle, in any format.

use crate::fst::Fst;
use crate::layout::Layout;
use crate::vcd::Vcd;
use crate::worker::Worker;
use pellucid_sim::{Label, Sampler};
use std::collections::VecDeque;
use std::io::{self, Seek, Write};

/// How long a clock cycle is on the time axis, in nanoseconds.
pub const PERIOD_NS: u64 = 10;

/// A waveform's file format.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FileFormat {
    /// Value change dump: text that every viewer and many scripts read.
    #[default]
    Vcd,
    /// GTKWave's binary format: small, and quick to open however long it is.
    Fst,
}

impl FileFormat {
    /// What a file's name ends with.
    pub fn extension(self) -> &'static str {
        match self {
            FileFormat::Vcd => "vcd",
            FileFormat::Fst => "fst",
        }
    }
}

/// What a file is told of a cycle.
pub(crate) struct Cycle<'a> {
    /// Its number.
    pub(crate) cycle: u64,
    /// Whether all is shown.
    pub(crate) whole: Whole,
    /// Values to be shown anew, by their numbers.
    pub(crate) changed: &'a [(u32, u64)],
    /// Labels to be shown anew, by their numbers.
    pub(crate) relabelled: &'a [(u32, Label)],
}

/// Why all values are shown, whether they changed or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Whole {
    /// The waveform begins.
    First,
    /// It goes on after a gap.
    AfterGap,
    /// They are not.
    No,
}

/// A file format. Cycles come in rising order.
pub(crate) trait Format: Send {
    /// Shows a cycle.
    fn cycle(&mut self, now: &Cycle) -> io::Result<()>;
    /// From `cycle` on nothing is known.
    fn gap(&mut self, cycle: u64) -> io::Result<()>;
    /// Ends the file, and the last cycle where one is shown. Nothing follows.
    fn finish(&mut self, cycle: Option<u64>) -> io::Result<()>;
    /// Characters of the longest label so far.
    fn longest_label(&self) -> usize;
}

/// One cycle's values and labels.
#[derive(Clone, Debug, Default)]
struct Snapshot {
    values: Vec<u64>,
    labels: Vec<Label>,
}

impl Snapshot {
    fn new(layout: &Layout) -> Snapshot {
        let (values, labels) = (layout.values(), layout.gates.len());
        Snapshot { values: vec![0; values], labels: vec![Label::NONE; labels] }
    }

    /// Samples a cycle over the values that are here. Those that change go to `changed`.
    #[inline(always)]
    fn sample(
        &mut self,
        layout: &Layout,
        changed: &mut Vec<(u32, u64)>,
        sample: impl FnOnce(&mut Sampler),
    ) {
        let Snapshot { values, labels } = self;
        let mut sampler = Sampler::new(values, labels, changed);
        sample(&mut sampler);
        debug_assert_eq!(sampler.values(), layout.sampled, "one value per declared signal");
        debug_assert_eq!(sampler.labels(), layout.gates.len(), "one label per declared label");
        self.derive(layout, changed);
    }

    /// Stalls, and labels of stages that hold something.
    fn derive(&mut self, layout: &Layout, changed: &mut Vec<(u32, u64)>) {
        let Snapshot { values, labels } = self;
        for (at, stall) in (layout.sampled..).zip(&layout.stalls) {
            let value = values[stall.valid] & !values[stall.ready] & 1;
            if values[at] != value {
                values[at] = value;
                changed.push((at as u32, value));
            }
        }
        for (label, gate) in labels.iter_mut().zip(&layout.gates) {
            if gate.is_some_and(|gate| values[gate] == 0) {
                *label = Label::NONE;
            }
        }
    }
}

/// Cycles that may yet be shown.
struct History {
    /// The most that are remembered; 0 if a cycle is shown when it comes or not at all.
    most: usize,
    cycles: VecDeque<(u64, Snapshot)>,
    /// What was shown last.
    shown: Vec<u64>,
}

/// A waveform under way. See [`Layout`] for what it shows.
///
/// A cycle is sampled, then shown or passed over. With a history it can also be remembered and shown later.
pub struct Wave {
    layout: Layout,
    worker: Worker,
    /// The cycle that was sampled last.
    now: Snapshot,
    /// Labels as they were shown last.
    labels: Vec<Label>,
    state: Showing,
    /// The first and the last cycle that were shown.
    first: Option<u64>,
    last: u64,
    history: History,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Showing {
    NotYet,
    Now,
    Gap,
}

/// Where cycles in which nothing changes lie between two others, the most of them that are shown.
const STILL: u64 = 1000;

impl Wave {
    /// Begins a file. At most `history` cycles are remembered: see [`Wave::remember`].
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(
        format: FileFormat,
        out: impl Write + Seek + Send + 'static,
        layout: Layout,
        history: usize,
    ) -> io::Result<Wave> {
        let format: Box<dyn Format> = match format {
            FileFormat::Vcd => Box::new(Vcd::new(out, &layout)?),
            FileFormat::Fst => Box::new(Fst::new(out, &layout)?),
        };
        let now = Snapshot::new(&layout);
        Ok(Wave {
            worker: Worker::new(format)?,
            labels: now.labels.clone(),
            state: Showing::NotYet,
            first: None,
            last: 0,
            history: History { most: history, cycles: VecDeque::new(), shown: now.values.clone() },
            now,
            layout,
        })
    }

    /// What it shows.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// The first cycle that was shown.
    pub fn first(&self) -> Option<u64> {
        self.first
    }

    /// Characters of the longest label, as far as the file is written.
    pub fn longest_label(&self) -> usize {
        self.worker.longest_label
    }

    /// Samples a cycle: `sample` tells every signal's value and every label, in the order of the declarations.
    #[inline(always)]
    pub fn sample(&mut self, sample: impl FnOnce(&mut Sampler)) {
        let Wave { layout, worker, now, .. } = self;
        worker.batch.forget();
        now.sample(layout, &mut worker.batch.changed, sample);
    }

    /// Shows the cycle that was sampled. Cycles must rise.
    ///
    /// # Errors
    /// Those of the writer, which may come a few cycles late.
    pub fn show(&mut self, cycle: u64) -> io::Result<()> {
        if self.history.most > 0 {
            self.remember(cycle)?;
            return self.recall(cycle, cycle);
        }
        let Wave { worker, now, labels, state, .. } = self;
        show(worker, labels, state, cycle, now)?;
        self.shown(cycle);
        Ok(())
    }

    fn shown(&mut self, cycle: u64) {
        self.first.get_or_insert(cycle);
        self.last = cycle;
    }

    /// A gap begins with `cycle`: what the signals do until the next cycle is not shown.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn gap(&mut self, cycle: u64) -> io::Result<()> {
        if self.state == Showing::Now {
            self.state = Showing::Gap;
            self.worker.gap(cycle)?;
        }
        Ok(())
    }

    /// Remembers the cycle that was sampled, so that [`Wave::recall`] can show it later. The oldest is
    /// forgotten where there are too many; cycles in which nothing changes do not count.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn remember(&mut self, cycle: u64) -> io::Result<()> {
        let Wave { worker, now, history, .. } = self;
        let still = !worker.batch.has_changes();
        if still && history.cycles.back().is_some_and(|(_, last)| last.labels == now.labels) {
            return Ok(());
        }
        let mut room = Snapshot::default();
        let mut forgotten = None;
        if history.cycles.len() >= history.most.max(1)
            && let Some((cycle, oldest)) = history.cycles.pop_front()
        {
            (forgotten, room) = (Some(cycle), oldest);
        }
        room.clone_from(now);
        history.cycles.push_back((cycle, room));
        match forgotten {
            Some(cycle) => self.gap(cycle),
            None => Ok(()),
        }
    }

    /// The value of a signal in the cycle that was sampled last.
    pub fn value(&self, at: usize) -> u64 {
        self.now.values[at]
    }

    /// The labels in the cycle that was sampled last.
    pub fn labels(&self) -> &[Label] {
        &self.now.labels
    }

    /// The cycle that was remembered last: nothing has changed since.
    pub fn last_change(&self) -> Option<u64> {
        self.history.cycles.back().map(|(cycle, _)| *cycle)
    }

    /// Shows the remembered cycles from `from` on, up to `to`, and forgets all.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn recall(&mut self, from: u64, to: u64) -> io::Result<()> {
        while let Some((cycle, snapshot)) = self.history.cycles.pop_front() {
            // How long it stayed as it was.
            let next = self.history.cycles.front().map_or(to + 1, |(next, _)| *next);
            if next <= from {
                self.gap(cycle)?;
                continue;
            }
            let cycle = cycle.max(from);
            if self.state == Showing::Now && cycle > self.last + 1 {
                self.gap(self.last + 1)?;
            }
            let Wave { worker, labels, state, history, .. } = self;
            worker.batch.forget();
            let pairs = snapshot.values.iter().zip(&mut history.shown);
            for (at, (new, old)) in (0..).zip(pairs).filter(|(_, (new, old))| *new != *old) {
                *old = *new;
                worker.batch.changed.push((at, *new));
            }
            let until = next.min(cycle + STILL);
            for cycle in cycle..until {
                show(worker, labels, state, cycle, &snapshot)?;
            }
            self.shown(cycle);
            self.last = until - 1;
        }
        Ok(())
    }

    /// Ends the file with `cycle`, the one after the last. Gives how many characters its longest label has.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self, cycle: u64) -> io::Result<usize> {
        if let Some((first, _)) = self.history.cycles.pop_front() {
            self.gap(first)?;
        }
        let shown = self.state == Showing::Now;
        self.worker.finish(shown.then_some(cycle))
    }
}

/// Shows a cycle whose changed values are gathered.
fn show(
    worker: &mut Worker,
    labels: &mut [Label],
    state: &mut Showing,
    cycle: u64,
    now: &Snapshot,
) -> io::Result<()> {
    let whole = match state {
        Showing::NotYet => Whole::First,
        Showing::Gap => Whole::AfterGap,
        Showing::Now => Whole::No,
    };
    let batch = &mut worker.batch;
    for (k, (new, old)) in (0..).zip(now.labels.iter().zip(labels)) {
        if new != old || whole != Whole::No {
            *old = *new;
            batch.relabelled.push((k, *new));
        }
    }
    if whole != Whole::No {
        batch.forget_values();
        batch.changed.extend((0..).zip(now.values.iter().copied()));
    }
    *state = Showing::Now;
    worker.cycle(cycle, whole)
}
