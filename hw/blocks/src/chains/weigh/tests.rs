use super::*;
use crate::chains::config::Shape;
use crate::chains::test_util::{Pixel, Stored};
use crate::test_util::{Pattern, edge, pattern, small_owned, traffic};
use pellucid_machine::pixel::rgba;
use pellucid_sim::{Label, Sim};
use proptest::prelude::*;

/// Sections of the pixel of each test, in the order of its chain: its own one, then some on chip, outside and on
/// chip again.
const SECTIONS: [u32; 8] = [0, 17, 16, 20, 24, 15, 23, 18];

/// The weigher beside what a pixel has.
struct Bench {
    sim: Sim<Weigh>,
    stored: Stored,
    /// Where its fragments are.
    places: Vec<Place>,
    entry: SsaEntry,
    /// When sections outside may be asked for.
    port: Pattern,
}

/// What became of a fragment that came.
#[derive(Debug)]
struct Seen {
    weight: u32,
    /// Cycles until its weight was shown.
    cycles: u64,
    /// Stored fragments that were written back, in that order.
    written: Vec<Place>,
    nsa_reads: u64,
}

impl Bench {
    fn new(capacity: u32, words: &[Word]) -> Bench {
        let cfg = small_owned(true);
        let cfg = Config::new(cfg.screen, Shape { capacity, ..cfg.shape });
        let pixel = Pixel { layers: words.iter().map(|word| word.z).collect(), depth: 0 };
        let mut stored = Stored::new(&cfg, &[pixel], &SECTIONS);
        let place =
            |at: u32| Place { section: SECTIONS[(at / capacity) as usize], slot: at % capacity };
        let places: Vec<Place> = (0..words.len() as u32).map(place).collect();
        for (place, word) in places.iter().zip(words) {
            stored.words.put(*place, *word);
        }
        let entry = stored.entries[0];
        Bench { sim: Sim::new(cfg), stored, places, entry, port: Pattern::always() }
    }

    /// A fragment comes; its weight is taken `late` cycles after it is shown.
    fn come(&mut self, z: u32, rgba: u32, late: u64) -> Seen {
        let fragment = PixelFragment { pixel: 0, z, rgba, label: Label::NONE };
        let (nsa_reads, _) = traffic(&mut self.stored.nsa);
        let mut seen = Seen { weight: 0, cycles: 0, written: vec![], nsa_reads: 0 };
        let mut shown = 0;
        for cycle in 0.. {
            assert!(cycle < 1000, "the weight is not shown: {seen:?}");
            let weight = self.sim.moore().weight;
            if weight.valid {
                assert!(shown == 0 || seen.weight == weight.payload, "the weight changes");
                seen.weight = weight.payload;
                seen.cycles = if shown == 0 { cycle } else { seen.cycles };
                shown += 1;
            }
            // One outside has its turn while the port takes something.
            let outside_ready = self.port.at(cycle);
            let oldest = self.sim.moore().oldest;
            let waits = oldest.valid && oldest.payload && !outside_ready;
            let word = if waits { Read::default() } else { self.stored.words.answer(cycle) };
            let i = In {
                start: cycle == 0,
                fragment,
                entry: self.entry,
                nsa: self.stored.nsa.q(),
                word,
                taken: weight.valid && shown > late,
                outside_ready,
            };
            let taken = i.taken;
            let out = self.sim.clock(i).unwrap().out;
            assert!(!(out.read.valid && out.write.valid), "a read and a write meet");
            let asked = if out.read.valid { out.read } else { out.write };
            let outside = self.sim.config().is_outside(asked.payload.section);
            assert!(!asked.valid || i.outside_ready || !outside, "the port takes nothing");
            if out.read.valid {
                self.stored.words.ask(cycle, out.read.payload);
            }
            if out.write.valid {
                self.stored.words.put(out.write.payload, out.word);
                seen.written.push(out.write.payload);
            }
            self.stored.nsa.pass(out.nsa);
            edge(&mut self.stored.nsa);
            if taken {
                break;
            }
        }
        assert!(!self.sim.moore().weight.valid, "it is shown after it was taken");
        seen.nsa_reads = traffic(&mut self.stored.nsa).0 - nsa_reads;
        seen
    }

    fn words(&self) -> Vec<Word> {
        self.places.iter().map(|place| self.stored.words.at(*place)).collect()
    }
}

/// A fifth of what is behind it is hidden: 52429 of 65536 come through, 0.8 * 65536 = 52428.8 rounded.
const FIFTH: u32 = 0x1122_3300 | 51;
/// Its own weight, (65536 - 52429) * 256.
const OWN: u32 = 3_355_392;
/// That behind another one: floor(3355392 * 52429 / 65536), 687186903 / 256 = 2684323.8.
const BEHIND: u32 = 2_684_323;

fn stored(z: u32, rgba: u32, weight: u32) -> Word {
    Word { z, rgba, weight, label: Label::new(z, 0, 0) }
}

#[test]
fn of_two_the_farther_ones_weight_changes_and_of_equal_depths_the_earlier_ones() {
    for (z, weight, changed) in [(4, OWN, true), (5, OWN, true), (6, BEHIND, false)] {
        let word = stored(5, FIFTH, OWN);
        let mut bench = Bench::new(2, &[word]);
        let seen = bench.come(z, FIFTH, 0);
        assert_eq!(seen.weight, weight, "z = {z}");
        let after = if changed { Word { weight: BEHIND, ..word } } else { word };
        assert_eq!(bench.words(), [after], "z = {z}");
        assert_eq!(seen.written, &bench.places[..usize::from(changed)]);
    }
}

#[test]
fn a_clear_fragment_weighs_nothing_and_changes_no_weight() {
    let word = stored(5, FIFTH, OWN);
    let mut bench = Bench::new(2, &[word]);
    assert_eq!(bench.come(1, rgba(9, 9, 9, 0), 0).weight, 0);
    assert_eq!(bench.words(), [word]);
}

/// Cycles and reads of the NSA table for a fragment at depth 5 that comes to so many in front of it (`true`) and
/// behind it, with sections of two.
fn cost(in_front: &[bool]) -> (u64, u64) {
    let words: Vec<Word> =
        in_front.iter().map(|front| stored(if *front { 1 } else { 9 }, FIFTH, OWN)).collect();
    let seen = Bench::new(2, &words).come(5, FIFTH, 0);
    (seen.cycles, seen.nsa_reads)
}

#[test]
fn one_on_chip_takes_a_cycle_and_another_if_its_weight_changes() {
    // The first is asked for in cycle 0, so the weight of one that is compared in cycle 1 is shown in cycle 2.
    assert_eq!(cost(&[true]), (2, 0));
    assert_eq!(cost(&[true, true, true, true]), (5, 1));
    // The last one's weight is written while the next step is taken.
    assert_eq!(cost(&[false]), (2, 0));
    assert_eq!(cost(&[false, false, true, false]), (7, 1));
    // The fifth is in the third section; that is on chip too.
    assert_eq!(cost(&[true; 5]), (6, 2));
}

#[test]
fn one_outside_takes_the_latency_of_its_memory() {
    // The fourth section, 20, is the first outside; its latency is 3.
    assert_eq!(cost(&[true; 6]), (7, 2));
    assert_eq!(cost(&[true; 7]), (10, 3));
    // The next one's answer follows right behind.
    assert_eq!(cost(&[true; 8]), (11, 3));
}

#[test]
fn the_weight_stays_until_it_is_taken() {
    let mut bench = Bench::new(2, &[stored(3, FIFTH, OWN)]);
    let seen = bench.come(5, FIFTH, 9);
    assert_eq!((seen.weight, seen.cycles), (BEHIND, 2));
    // Then the next one may come.
    assert_eq!(bench.come(5, FIFTH, 0).cycles, 2);
}

/// The pixel's fragments lie in sections 0, 17, 16, 20, 24, 15, 23 and 18, of which those from 20 on are outside: their
/// answers come after 3 cycles. All are asked for in cycles 0 to 7, and answered in 1, 2, 3, 6, 7, 8, 9 and 10.
#[test]
fn reads_go_ahead_of_the_answers() {
    let words: Vec<Word> = (0..8).map(|z| stored(z, FIFTH, OWN)).collect();
    let mut bench = Bench::new(1, &words);
    assert_eq!(bench.come(9, FIFTH, 0).cycles, 11);
}

/// A colour that is not opaque.
fn transparent() -> impl Strategy<Value = u32> {
    (any::<u32>(), 0..=254_u32).prop_map(|(colour, alpha)| colour & !0xff | alpha)
}

/// What a fragment of that alpha lets through, in units of 2^-16, rounded to nearest.
fn through(rgba: u32) -> u64 {
    let clear = 255 - u64::from(rgba & 0xff);
    (2 * clear * 65_536 + 255) / 510
}

proptest! {
    /// Fragment after fragment against the rule for each two, however they lie in sections.
    #[test]
    fn weights_are_those_of_each_two(
        first in proptest::collection::vec((0..6_u32, transparent(), 0..1_u32 << 24), 1..=8),
        come in proptest::collection::vec((0..6_u32, transparent(), 0..3_u64), 1..4),
        capacity in 1..=4_u32,
        port in proptest::option::of(pattern()),
    ) {
        let mut model: Vec<Word> = first.iter().map(|(z, rgba, w)| stored(*z, *rgba, *w)).collect();
        let mut bench = Bench::new(capacity, &model);
        let free_running = port.is_none();
        bench.port = port.unwrap_or(Pattern::always());
        for (z, rgba, late) in come {
            let mut weight = (65_536 - through(rgba)) << 8;
            let mut changed = vec![];
            let (mut cycles, mut outside) = (1, 0);
            for (at, word) in model.iter_mut().enumerate() {
                let nearer = z <= word.z;
                if nearer {
                    word.weight = (u64::from(word.weight) * through(rgba) / 65_536) as u32;
                    changed.push(bench.places[at]);
                } else {
                    weight = weight * through(word.rgba) / 65_536;
                }
                outside += u64::from(bench.places[at].section >= 20);
                cycles += 1 + u64::from(nearer && at + 1 < first.len());
            }
            let seen = bench.come(z, rgba, late);
            prop_assert_eq!(u64::from(seen.weight), weight);
            prop_assert_eq!(seen.written, changed);
            // One on chip takes a cycle; one outside two more at most, as its latency is 3.
            let fewest = if outside == 0 { cycles } else { first.len() as u64 + 1 };
            let most = match outside {
                0 => cycles,
                _ if free_running => cycles + 2 * outside,
                _ => u64::MAX,
            };
            prop_assert!((fewest..=most).contains(&seen.cycles), "{} cycles", seen.cycles);
            prop_assert_eq!(bench.words(), model.clone());
        }
    }
}
