//! A DRAM behind a machine's port.

use pellucid_dram::{Config, Dram, Request, Statistics};
use pellucid_machine::board::{Asked, Timing};
use pellucid_sim::{Figure, Figures};
use std::collections::VecDeque;

pellucid_sim::counters! {
    /// What the memory outside of the chip did.
    pub(crate) struct OutsideCounters {
        /// Bytes of the words that the machine read and wrote outside.
        bytes_asked: "bytes",
        /// Bytes that went over the memory's data buses, in whole bursts.
        bytes_moved: "bytes",
        /// Bursts that found their row open.
        row_hits: "bursts",
        /// Bursts for which a row was opened in a closed bank.
        row_misses: "bursts",
        /// Bursts for which another row was closed first.
        row_conflicts: "bursts",
        /// Reads that found their word in the burst of the read before them, and moved none.
        reads_gathered: "reads",
        /// Reads that were served from a write in the queue.
        reads_forwarded: "reads",
        /// Writes that joined a write in the queue to the same burst.
        writes_coalesced: "writes",
        /// Refresh commands.
        refreshes: "commands",
        /// From a read's arrival at the memory to the end of its data, on average.
        mean_read_latency: "ps",
        /// Clocks of the memory's data buses, summed over the buses.
        bus_clocks: "clocks",
        /// Those in which data went over them.
        busy_bus_clocks: "clocks",
    }
}

/// See the module's description. A word of the machine lies in a power of two of bytes, and an access asks for the
/// burst that has it. The burst that was read last is kept, so that words of one burst that are read one after the other
/// move it once; a write to it ends that.
pub(crate) struct DramTiming {
    dram: Dram,
    word_bytes: u64,
    /// Reads that were not answered, from the oldest on: whether their data are there.
    reads: VecDeque<bool>,
    /// The number of the oldest.
    first: u32,
    /// The burst that was asked for by the last read.
    burst: Option<u64>,
    gathered: u64,
    /// What had been done when counting began.
    before: Counted,
}

/// What was counted.
struct Counted {
    gathered: u64,
    dram: Statistics,
}

/// Bytes between words of so many bits, as they lie in memory.
pub(crate) fn word_bytes(bits: u32) -> u64 {
    u64::from(bits.div_ceil(8).next_power_of_two())
}

impl DramTiming {
    /// For words of so many bits.
    pub(crate) fn new(dram: Dram, word_bits: u32) -> DramTiming {
        let before = Counted { gathered: 0, dram: dram.statistics() };
        DramTiming {
            dram,
            word_bytes: word_bytes(word_bits),
            reads: VecDeque::new(),
            first: 0,
            burst: None,
            gathered: 0,
            before,
        }
    }
}

/// Data buses of a memory.
fn buses(config: &Config) -> u64 {
    u64::from(config.channels) * u64::from(config.part.organisation.pseudo_channels)
}

impl Timing for DramTiming {
    fn ready(&self) -> bool {
        self.dram.ready()
    }
    fn answers(&self) -> bool {
        self.reads.front() == Some(&true)
    }
    fn idle(&self) -> bool {
        false
    }
    fn longest(&self) -> u64 {
        let config = self.dram.config();
        let ps = u128::from(config.longest_wait()) * u128::from(config.part.timing.tck_ps);
        ps.div_ceil(config.machine_period_ps.into()).try_into().unwrap_or(u64::MAX)
    }
    fn cycle(&mut self, asked: Option<Asked>, answered: bool) {
        if answered {
            self.reads.pop_front();
            self.first = self.first.wrapping_add(1);
        }
        self.dram.cycle();
        if let Some(Asked { write, address }) = asked {
            let address = u64::from(address) * self.word_bytes;
            let burst = Some(self.dram.layout().burst(address));
            // Answers go in order: when it is this one's turn, the read before has its burst.
            let gathered = !write && burst == self.burst;
            if gathered {
                self.gathered += 1;
            } else {
                let tag = self.first.wrapping_add(self.reads.len() as u32);
                let taken = self.dram.push(Request { write, address, tag, client: 0 });
                debug_assert!(taken, "it was ready");
            }
            if !write {
                self.reads.push_back(gathered);
                self.burst = burst;
            } else if burst == self.burst {
                self.burst = None;
            }
        }
        while let Some(tag) = self.dram.pop() {
            if let Some(read) = self.reads.get_mut(tag.wrapping_sub(self.first) as usize) {
                *read = true;
            }
        }
    }
    fn reset(&mut self) {
        // What is under way is let run out, for nobody.
        while !self.dram.idle() {
            self.dram.cycle();
            while self.dram.pop().is_some() {}
        }
        self.reads.clear();
        self.burst = None;
    }
    fn figures(&self) -> Vec<Figure> {
        let s = self.dram.statistics();
        let since = |of: fn(&Statistics) -> u64| of(&s) - of(&self.before.dram);
        let gathered = self.gathered - self.before.gathered;
        let config = self.dram.config();
        let served = since(|s| s.reads);
        let latency = since(|s| s.read_latency_clocks) * config.part.timing.tck_ps;
        let counters = OutsideCounters {
            bytes_asked: (since(|s| s.reads + s.writes) + gathered) * self.word_bytes,
            bytes_moved: since(|s| s.bytes_read + s.bytes_written),
            row_hits: since(|s| s.row_hits),
            row_misses: since(|s| s.row_misses),
            row_conflicts: since(|s| s.row_conflicts),
            reads_gathered: gathered,
            reads_forwarded: since(|s| s.reads_forwarded),
            writes_coalesced: since(|s| s.writes_coalesced),
            refreshes: since(|s| s.refreshes),
            mean_read_latency: latency.checked_div(served).unwrap_or(0),
            bus_clocks: since(|s| s.clocks) * buses(config),
            busy_bus_clocks: since(|s| s.busy_bus_clocks),
        };
        let spent = config.spent(&s).zip(config.spent(&self.before.dram));
        let spent = spent.into_iter().flat_map(|(now, before)| {
            let figures = now.figures().into_iter().zip(before.figures());
            figures.map(|(now, before)| Figure { value: now.value - before.value, ..now })
        });
        counters.figures().into_iter().chain(spent).collect()
    }
    fn count_anew(&mut self) {
        self.before = Counted { gathered: self.gathered, dram: self.dram.statistics() };
    }
}
