use super::*;
use crate::array::config::Shape;
use crate::array::counters::{self, Counters};
use crate::test_util::{Clocked, arrays, screen};
use pellucid_sim::Sim;

/// A prefix sum beside its counters.
struct Bench {
    sim: Sim<PrefixSum>,
    counters: Clocked<Counters>,
}

fn nothing() -> In {
    In {
        start: false,
        counts: Read::default(),
        sums: Read::default(),
        ready: true,
        index_read: ReadPort::default(),
        walk_read: ReadPort::default(),
        occupied_read: ReadPort::default(),
    }
}

impl Bench {
    fn new(cfg: Config, counts: &[u32]) -> Bench {
        let mut counters = Clocked::<Counters>::new(cfg);
        for (word, lanes) in (0..).zip(counts.chunks(cfg.shape.lanes as usize)) {
            let mut of = [0; MAX_LANES];
            of[..lanes.len()].copy_from_slice(lanes);
            let mut i = counters::In::default();
            i.index_write.write(word, Counts { of });
            counters.clock(i).unwrap();
        }
        Bench { sim: Sim::new(cfg), counters }
    }

    /// Sums a band up; gives its first pixel, the one behind its last, and the sums of its pixels.
    fn band(&mut self) -> (u32, u32, Vec<u32>) {
        let cfg = *self.sim.config();
        for cycle in 0.. {
            assert!(cycle < 100, "the band does not end");
            let i = In { start: cycle == 0, counts: self.counters.moore(), ..nothing() };
            let out = self.sim.clock(i).unwrap().out;
            let ports =
                counters::In { sum_read: out.read, sum_write: out.write, ..Default::default() };
            self.counters.clock(ports).unwrap();
            if out.done {
                break;
            }
        }
        let Band { from, to } = self.sim.moore().band;
        let sum = |pixel| {
            let mut index_read = ReadPort::default();
            index_read.read(cfg.word_of(pixel));
            self.sim.clock(In { index_read, ..nothing() }).unwrap();
            self.sim.moore().sums.data.of[cfg.lane_of(pixel) as usize]
        };
        (from, to, (from..to).map(sum).collect())
    }
}

/// Everything else is left to the contract of a prefix sum.
#[test]
fn by_hand() {
    // Of five pixels two fit into five slots, then two, then one.
    for (down, bands) in [
        (true, [(0, 2, vec![2, 5]), (2, 4, vec![4, 5]), (4, 5, vec![5])]),
        (false, [(0, 2, vec![0, 2]), (2, 4, vec![0, 4]), (4, 5, vec![0])]),
    ] {
        let shape = Shape { on_chip: 5, outside: 0, bands: true, ..arrays(2, down).shape };
        let mut bench = Bench::new(Config::new(screen(5, 1), shape), &[2, 3, 4, 1, 5]);
        for _frame in 0..if down { 2 } else { 1 } {
            for band in &bands {
                assert_eq!(bench.band(), *band, "down: {down}");
            }
        }
    }
}
