//! A thread that writes a file while the simulation goes on.
//!
//! What changed in some cycles is gathered in a batch and handed on. There are a few batches and no more, so
//! memory is bounded and the simulation waits where the file is slower.

use crate::wave::{Cycle, Format, Whole};
use pellucid_sim::{Label, panic_text};
use std::io;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

/// How many batches there are, with that which is being filled.
const BATCHES: usize = 3;
/// From how many changes on a batch is handed on.
const CHANGES: usize = 4096;

/// Something that goes into the file.
enum Event {
    /// A cycle, with how many values and labels are shown anew.
    Cycle { cycle: u64, whole: Whole, changed: usize, relabelled: usize },
    /// From this cycle on nothing is known.
    Gap(u64),
    /// The file ends, and with this cycle the one before if that is shown.
    End(Option<u64>),
}

/// What changed in some cycles.
#[derive(Default)]
pub(crate) struct Batch {
    events: Vec<Event>,
    /// Values by their numbers, those of all cycles one behind the other.
    pub(crate) changed: Vec<(u32, u64)>,
    /// Labels likewise.
    pub(crate) relabelled: Vec<(u32, Label)>,
    /// How many of either belong to cycles that are over.
    changed_before: usize,
    relabelled_before: usize,
    /// Characters of the longest label in the file, once it is written.
    longest_label: usize,
}

impl Batch {
    /// Forgets the changes of the cycle at hand.
    pub(crate) fn forget(&mut self) {
        self.changed.truncate(self.changed_before);
        self.relabelled.truncate(self.relabelled_before);
    }

    /// Forgets its changed values alone.
    pub(crate) fn forget_values(&mut self) {
        self.changed.truncate(self.changed_before);
    }

    /// Whether the cycle at hand has changed values.
    pub(crate) fn has_changes(&self) -> bool {
        self.changed.len() > self.changed_before
    }

    /// The cycle at hand is over.
    fn end_cycle(&mut self, cycle: u64, whole: Whole) {
        let changed = self.changed.len() - self.changed_before;
        let relabelled = self.relabelled.len() - self.relabelled_before;
        self.events.push(Event::Cycle { cycle, whole, changed, relabelled });
        self.changed_before = self.changed.len();
        self.relabelled_before = self.relabelled.len();
    }

    fn clear(&mut self) {
        self.events.clear();
        self.changed.clear();
        self.relabelled.clear();
        (self.changed_before, self.relabelled_before) = (0, 0);
    }

    /// Writes it. A panic in the format's library is an error like any other.
    fn write(&mut self, format: &mut dyn Format) -> io::Result<()> {
        let written = catch_unwind(AssertUnwindSafe(|| self.tell(format)));
        self.longest_label = format.longest_label();
        written.unwrap_or_else(|panic| {
            Err(io::Error::other(format!("its writer failed: {}", panic_text(&*panic))))
        })
    }

    fn tell(&self, format: &mut dyn Format) -> io::Result<()> {
        let (mut changed, mut relabelled) = (&self.changed[..], &self.relabelled[..]);
        for event in &self.events {
            match *event {
                Event::Cycle { cycle, whole, changed: values, relabelled: labels } => {
                    let (now_changed, rest) = changed.split_at(values);
                    changed = rest;
                    let (now_relabelled, rest) = relabelled.split_at(labels);
                    relabelled = rest;
                    let (changed, relabelled) = (now_changed, now_relabelled);
                    format.cycle(&Cycle { cycle, whole, changed, relabelled })?;
                }
                Event::Gap(cycle) => format.gap(cycle)?,
                Event::End(cycle) => format.finish(cycle)?,
            }
        }
        Ok(())
    }
}

/// See the module's description.
pub(crate) struct Worker {
    /// The batch that is being filled.
    pub(crate) batch: Batch,
    /// To the thread; nothing once there is no more to come.
    full: Option<Sender<Batch>>,
    /// From the thread: an empty batch, and how writing what was in it went.
    empty: Receiver<(Batch, io::Result<()>)>,
    thread: Option<JoinHandle<()>>,
    /// Characters of the longest label that was written so far.
    pub(crate) longest_label: usize,
}

impl Worker {
    /// Starts the thread.
    ///
    /// # Errors
    /// There can be no thread.
    pub(crate) fn new(mut format: Box<dyn Format>) -> io::Result<Worker> {
        let (full, to_write) = channel::<Batch>();
        let (written, empty) = channel();
        for _ in 1..BATCHES {
            // The receiver is here.
            let _ = written.send((Batch::default(), Ok(())));
        }
        let thread = std::thread::Builder::new().name("waveform".into()).spawn(move || {
            let mut failed = false;
            for mut batch in to_write {
                // What comes behind a failure would make no sense.
                let result = if failed { Ok(()) } else { batch.write(&mut *format) };
                failed |= result.is_err();
                batch.clear();
                if written.send((batch, result)).is_err() {
                    break;
                }
            }
        })?;
        let (batch, full, thread) = (Batch::default(), Some(full), Some(thread));
        Ok(Worker { batch, full, empty, thread, longest_label: 0 })
    }

    /// The cycle at hand is over.
    ///
    /// # Errors
    /// Those of the writer, a batch or two late.
    pub(crate) fn cycle(&mut self, cycle: u64, whole: Whole) -> io::Result<()> {
        self.batch.end_cycle(cycle, whole);
        if self.batch.changed.len() < CHANGES { Ok(()) } else { self.hand_on() }
    }

    /// From this cycle on nothing is known.
    ///
    /// # Errors
    /// Those of the writer, a batch or two late.
    pub(crate) fn gap(&mut self, cycle: u64) -> io::Result<()> {
        self.batch.forget();
        self.batch.events.push(Event::Gap(cycle));
        // A window is complete: it is worth keeping.
        self.hand_on()
    }

    fn hand_on(&mut self) -> io::Result<()> {
        let (next, result) = self.empty.recv().map_err(io::Error::other)?;
        self.longest_label = next.longest_label.max(self.longest_label);
        let filled = std::mem::replace(&mut self.batch, next);
        if let Some(full) = &self.full {
            full.send(filled).map_err(|_| io::Error::other("the writer has gone"))?;
        }
        result
    }

    /// Ends the file, with the cycle after the last if that is shown, and waits until all is written. Gives how
    /// many characters the longest label has.
    ///
    /// # Errors
    /// Those of the writer.
    pub(crate) fn finish(mut self, cycle: Option<u64>) -> io::Result<usize> {
        self.batch.forget();
        self.batch.events.push(Event::End(cycle));
        let last = self.hand_on();
        self.full = None;
        // To the end, even if one of them is an error.
        let mut result = last;
        for (batch, written) in self.empty.iter() {
            self.longest_label = batch.longest_label.max(self.longest_label);
            result = result.and(written);
        }
        result.map(|()| self.longest_label)
    }
}

/// The file is closed when this is over.
impl Drop for Worker {
    fn drop(&mut self) {
        self.full = None;
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// Notes what comes, up to a cycle in which it fails, with an error or else with a panic.
    struct Notes {
        fails: u64,
        panics: bool,
        seen: Arc<Mutex<Vec<String>>>,
    }
    impl Format for Notes {
        fn cycle(&mut self, now: &Cycle) -> io::Result<()> {
            if now.cycle == self.fails {
                assert!(!self.panics, "no more than {} cycles", self.fails);
                return Err(io::ErrorKind::StorageFull.into());
            }
            let Cycle { cycle, changed, relabelled, .. } = now;
            let (value, label) = (changed.last(), relabelled.len());
            self.seen.lock().unwrap().push(format!("{cycle}: {} {value:?} {label}", changed.len()));
            Ok(())
        }
        fn gap(&mut self, cycle: u64) -> io::Result<()> {
            self.seen.lock().unwrap().push(format!("gap {cycle}"));
            Ok(())
        }
        fn finish(&mut self, cycle: Option<u64>) -> io::Result<()> {
            self.seen.lock().unwrap().push(format!("end {cycle:?}"));
            Ok(())
        }
        fn longest_label(&self) -> usize {
            self.seen.lock().unwrap().len()
        }
    }

    /// Cycle `k` changes 1000 values; cycle 8 is followed by a gap.
    fn write(cycles: u64, fails: u64, panics: bool) -> (Vec<String>, io::Result<usize>) {
        let seen = Arc::<Mutex<Vec<String>>>::default();
        let notes = Notes { fails, panics, seen: seen.clone() };
        let mut worker = Worker::new(Box::new(notes)).unwrap();
        let mut result = Ok(());
        for cycle in 0..cycles {
            // What is not shown is forgotten.
            worker.batch.changed.push((7, 7));
            worker.batch.forget();
            worker.batch.changed.extend((0..1000).map(|k| (k, cycle)));
            worker.batch.relabelled.push((0, Label::NONE));
            result = result.and(worker.cycle(cycle, Whole::No));
            if cycle == 8 {
                result = result.and(worker.gap(9));
            }
        }
        let finished = worker.finish(Some(cycles));
        let seen = seen.lock().unwrap().clone();
        (seen, result.and(finished))
    }

    #[test]
    fn everything_arrives_in_order() {
        let (seen, result) = write(100, u64::MAX, false);
        assert_eq!(result.unwrap(), 102, "the longest label is that of the end");
        let cycle = |k: u64| format!("{k}: 1000 Some((999, {k})) 1");
        let mut expected: Vec<String> = (0..100).map(cycle).collect();
        expected.insert(9, "gap 9".to_string());
        expected.push("end Some(100)".to_string());
        assert_eq!(seen, expected);
    }

    #[test]
    fn a_failure_is_told_and_nothing_is_written_behind_it() {
        for cycles in [8, 100] {
            let (seen, result) = write(cycles, 6, false);
            assert_eq!(result.unwrap_err().kind(), io::ErrorKind::StorageFull);
            assert_eq!(seen.len(), 6);
        }
    }

    #[test]
    fn a_panic_of_the_writer_is_told_as_a_failure() {
        for cycles in [8, 100] {
            let (seen, result) = write(cycles, 6, true);
            let told = result.unwrap_err().to_string();
            assert_eq!(told, "its writer failed: no more than 6 cycles");
            assert_eq!(seen.len(), 6);
        }
    }
}
