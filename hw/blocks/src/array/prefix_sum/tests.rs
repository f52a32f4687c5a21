use super::*;
use crate::array::config::Shape;
use crate::array::counters::{self, Counters};
use crate::test_util::{Clocked, arrays, screen};
use pellucid_sim::Sim;
use proptest::prelude::*;

/// A prefix sum beside its counters.
struct Bench {
    sim: Sim<PrefixSum>,
    counters: Clocked<Counters>,
}

/// What a band came to.
#[derive(Debug, PartialEq)]
struct Summed {
    band: (u32, u32),
    /// Slots that the band takes.
    slots: u32,
    /// The sums of its pixels.
    sums: Vec<u32>,
    /// The words that are listed.
    listed: Vec<u32>,
    /// All counters after it.
    counters: Vec<u32>,
}

fn config(side: (u32, u32), shape: Shape) -> Config {
    Config::new(screen(side.0, side.1), shape)
}

fn nothing() -> In {
    In {
        start: false,
        counts: Read::default(),
        index_read: ReadPort::default(),
        walk_read: ReadPort::default(),
        occupied_read: ReadPort::default(),
    }
}

fn reads(addr: u32) -> ReadPort {
    let mut port = ReadPort::default();
    port.read(addr);
    port
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

    /// Sums a band up; also gives the cycles from the start on.
    fn band(&mut self) -> (Summed, u64) {
        let cfg = *self.sim.config();
        let mut slots = 0;
        let mut cycles = 0;
        for cycle in 0.. {
            assert!(cycle < 10_000, "the band does not end");
            let i = In { start: cycle == 0, counts: self.counters.moore(), ..nothing() };
            let out = self.sim.clock(i).unwrap().out;
            let ports =
                counters::In { sum_read: out.read, sum_write: out.write, ..Default::default() };
            self.counters.clock(ports).unwrap();
            if out.slots.valid {
                slots = out.slots.payload;
            }
            if out.done {
                cycles = cycle;
                break;
            }
        }
        let Moore { band: Band { from, to }, occupied, .. } = self.sim.moore();
        let mut summed =
            Summed { band: (from, to), slots, sums: vec![], listed: vec![], counters: vec![] };
        for pixel in from..to {
            self.sim.clock(In { index_read: reads(cfg.word_of(pixel)), ..nothing() }).unwrap();
            summed.sums.push(self.sim.moore().sums.data.of[cfg.lane_of(pixel) as usize]);
        }
        for place in 0..occupied {
            self.sim.clock(In { occupied_read: reads(place), ..nothing() }).unwrap();
            summed.listed.push(self.sim.moore().word.data);
        }
        for pixel in 0..cfg.screen.pixels() {
            let index_read = reads(cfg.word_of(pixel));
            self.counters.clock(counters::In { index_read, ..Default::default() }).unwrap();
            let data = self.counters.moore().data;
            summed.counters.push(data.of[cfg.lane_of(pixel) as usize]);
        }
        (summed, cycles)
    }
}

/// The same by a plain sum; `counts` are the counters as the band finds them.
fn reference(cfg: &Config, from: u32, counts: &[u32]) -> Summed {
    let (mut to, mut sum, mut sums) = (from, 0, vec![]);
    for count in &counts[from as usize..] {
        if sum + count > cfg.slots() {
            break;
        }
        sums.push(if cfg.shape.down { sum + count } else { sum });
        sum += count;
        to += 1;
    }
    let inside = |pixel: &u32| (from..to).contains(pixel);
    let mut listed: Vec<u32> = (from..to).filter(|pixel| counts[*pixel as usize] > 0).collect();
    listed.iter_mut().for_each(|pixel| *pixel /= cfg.shape.lanes);
    listed.dedup();
    if cfg.shape.lanes == 1 {
        listed.clear();
    }
    let kept = |(pixel, count): (u32, &u32)| {
        let cleared = if inside(&pixel) { !cfg.shape.down } else { !cfg.shape.bands };
        if cleared { 0 } else { *count }
    };
    let counters = (0..).zip(counts).map(kept).collect();
    Summed { band: (from, to), slots: sum, sums, listed, counters }
}

#[test]
fn by_hand() {
    // Of five pixels two fit into five slots, then two, then one.
    let shape = |down| Shape { on_chip: 5, outside: 0, ..arrays(2, down).shape };
    for (down, bands) in [
        (true, [(0, 2, vec![2, 5]), (2, 4, vec![4, 5]), (4, 5, vec![5])]),
        (false, [(0, 2, vec![0, 2]), (2, 4, vec![0, 4]), (4, 5, vec![0])]),
    ] {
        let cfg = config((5, 1), Shape { bands: true, ..shape(down) });
        let mut bench = Bench::new(cfg, &[2, 3, 4, 1, 5]);
        for _frame in 0..if down { 2 } else { 1 } {
            for (from, to, sums) in &bands {
                let (summed, _) = bench.band();
                assert_eq!((summed.band, &summed.sums), ((*from, *to), sums), "down: {down}");
            }
        }
    }
}

#[test]
fn a_sweep_takes_a_cycle_a_word_and_one_more() {
    for (lanes, sweeps, cycles) in [(1, false, 61), (4, false, 16), (16, false, 5)]
        .into_iter()
        .chain([(1, true, 6 * 61), (4, true, 4 * 16), (16, true, 2 * 5)])
    {
        let shape = Shape { sweeps, on_chip: 100, ..arrays(lanes, true).shape };
        let mut bench = Bench::new(config((10, 6), shape), &[1; 60]);
        assert_eq!(bench.band().1, cycles, "lanes {lanes}, sweeps: {sweeps}");
    }
}

proptest! {
    /// Band after band, with every way to sum up.
    #[test]
    fn behaves_as_a_plain_sum(
        width in 1u32..20,
        lanes in 0u32..=4,
        flags: (bool, bool, bool),
        on_chip in 7u32..40,
        counts in proptest::collection::vec(prop_oneof![Just(0), 0u32..=7], 60),
    ) {
        let (down, sweeps, bands) = flags;
        let shape = Shape { lanes: 1 << lanes, down, sweeps, bands, on_chip, ..arrays(1, true).shape };
        let cfg = config((width, 3), shape);
        let mut counts = counts[..3 * width as usize].to_vec();
        let mut bench = Bench::new(cfg, &counts);
        let mut from = 0;
        for _ in 0..60 {
            let (summed, _) = bench.band();
            let expected = reference(&cfg, from, &counts);
            prop_assert_eq!(&summed, &expected);
            counts = summed.counters;
            from = summed.band.1;
            if from == cfg.screen.pixels() || !bands {
                break;
            }
        }
        prop_assert!(from == cfg.screen.pixels() || !bands);
    }
}
