use super::*;
use crate::chains::config::Shape;
use crate::chains::test_util::Words;
use crate::test_util::{Pattern, edge, pattern, small_owned, traffic};
use pellucid_machine::pixel::rgba;
use pellucid_sim::{Ram1RW, Sim};
use proptest::prelude::*;
use std::collections::{BTreeMap, VecDeque};

/// Sections that pixels get behind their own one, in that order: those from 20 on are outside, with a latency of 3.
const SECTIONS: [u32; 11] = [17, 16, 20, 24, 15, 23, 18, 21, 19, 22, 25];

/// A fragment that comes: its pixel, depth and colour.
type Comes = (u32, u32, u32);

/// The weigher beside what stores and tables hold.
struct Bench {
    sim: Sim<Weigh>,
    nsa: Ram1RW<NsaEntry>,
    words: Words,
    /// Where the fragments of each pixel are, or will be.
    chains: Vec<Vec<Place>>,
    free: VecDeque<u32>,
    /// The bits of each number of the tables of what is under way: of those that began, and that ended.
    marks: BTreeMap<u32, (bool, bool)>,
    cycle: u64,
    /// The cycle in which the fragments at hand began to come.
    begin: u64,
    /// When something may be written outside, and when read on chip and there.
    port: Pattern,
    reads: [Pattern; 2],
    /// When the place of the fragment at hand becomes known.
    places: Pattern,
}

/// What became of fragments that came.
#[derive(Debug, Default)]
struct Seen {
    /// In which cycle each was written to its place, and where that is.
    placed: Vec<(u64, Place)>,
    /// Stored fragments that were read, and written back, in that order.
    read: Vec<Place>,
    written: Vec<Place>,
    nsa_reads: u64,
}

impl Bench {
    /// Small chains, with so many fragments in a section.
    fn new(capacity: u32) -> Bench {
        let small = small_owned(true);
        Bench::of(Config::new(small.screen, Shape { capacity, ..small.shape }), SECTIONS.into())
    }

    /// Chains with those free sections, and nothing stored.
    fn of(cfg: Config, free: VecDeque<u32>) -> Bench {
        Bench {
            sim: Sim::new(cfg),
            nsa: Ram1RW::new(cfg.null, cfg, 1),
            words: Words::new(cfg),
            chains: vec![vec![]; cfg.screen.pixels() as usize],
            free,
            marks: BTreeMap::new(),
            cycle: 0,
            begin: 0,
            port: Pattern::always(),
            reads: [Pattern::always(), Pattern::always()],
            places: Pattern::always(),
        }
    }

    /// The pixel has so many fragments more.
    fn holds(&mut self, pixel: u32, words: &[Word]) {
        for word in words {
            let place = self.next_place(pixel);
            self.words.put(place, *word);
            self.takes(pixel, place);
            edge(&mut self.nsa);
        }
    }

    /// Where the pixel's next fragment goes.
    fn next_place(&self, pixel: u32) -> Place {
        let capacity = self.sim.config().shape.capacity;
        match self.chains[pixel as usize].last() {
            None => Place { section: pixel, slot: 0 },
            Some(last) if last.slot + 1 < capacity => Place { slot: last.slot + 1, ..*last },
            Some(_) => Place { section: self.free[0], slot: 0 },
        }
    }

    /// It goes there.
    fn takes(&mut self, pixel: u32, place: Place) {
        let chain = &mut self.chains[pixel as usize];
        if let (Some(last), 0) = (chain.last(), place.slot) {
            self.nsa.write(last.section, NsaEntry { next: place.section, fill: 0 });
            self.free.pop_front();
        }
        chain.push(place);
    }

    fn entry(&self, pixel: u32) -> SsaEntry {
        let cfg = self.sim.config();
        match self.chains[pixel as usize].last() {
            None => SsaEntry { head: 0, tail: cfg.null, fill: 0 },
            Some(last) => SsaEntry { head: 0, tail: last.section, fill: last.slot + 1 },
        }
    }

    /// Fragments come one after the other, until all are where they go.
    fn come(&mut self, fragments: &[Comes]) -> Seen {
        let (nsa_reads, _) = traffic(&mut self.nsa);
        let mut seen = Seen::default();
        let (mut next, mut known) = (0, false);
        self.begin = self.cycle;
        while next < fragments.len() || !self.sim.moore().idle {
            assert!(self.cycle < self.begin + 3000, "it does not end: {seen:?}");
            let fragment = match fragments.get(next) {
                Some(&(pixel, z, rgba)) => {
                    Stream::offer(PixelFragment { pixel, z, rgba, label: Label::NONE })
                }
                None => Stream::idle(),
            };
            let pixel = fragment.payload.pixel;
            let number = self.sim.config().mark_number(pixel);
            let (began, ended) = self.marks.get(&number).copied().unwrap_or_default();
            known |= self.places.at(self.cycle);
            let place = Stream { valid: fragment.valid && known, payload: self.next_place(pixel) };
            // One outside has its turn while the port takes something.
            let outside_ready = self.port.at(self.cycle);
            let oldest = self.sim.moore().oldest;
            let turn = oldest.valid && (outside_ready || !oldest.payload);
            let word = if turn { self.words.answer(self.cycle) } else { Read::default() };
            let [on_chip, outside] = [0, 1].map(|side: usize| self.reads[side].at(self.cycle));
            let i = In {
                fragment,
                entry: self.entry(pixel),
                place,
                under_way: under_way::Moore { busy: began != ended, turn: !began },
                nsa: self.nsa.q(),
                word,
                outside_ready,
                reads: ReadsReady { on_chip, outside },
            };
            let out = self.sim.clock(i).unwrap().out;
            self.obey(&i, &out, &mut seen);
            self.nsa.pass(out.nsa);
            if out.ready && place.valid {
                self.takes(pixel, place.payload);
                next += 1;
                known = false;
            }
            edge(&mut self.nsa);
            self.cycle += 1;
        }
        seen.nsa_reads = traffic(&mut self.nsa).0 - nsa_reads;
        seen
    }

    /// Does what is asked, if it may be asked.
    fn obey(&mut self, i: &In, out: &Out, seen: &mut Seen) {
        let cfg = *self.sim.config();
        assert!(!(out.write.valid && out.place.valid), "two writes meet");
        let write = if out.write.valid { out.write } else { out.place };
        let outside = write.valid && cfg.is_outside(write.payload.section);
        assert!(i.outside_ready || !outside, "the port takes nothing");
        if out.read.valid {
            let outside = cfg.is_outside(out.read.payload.section);
            assert!(if outside { i.reads.outside } else { i.reads.on_chip }, "no read may come");
            self.words.ask(self.cycle, out.read.payload);
            seen.read.push(out.read.payload);
        }
        if write.valid {
            self.words.put(write.payload, out.word);
        }
        seen.written.extend(out.write.valid.then_some(out.write.payload));
        if out.place.valid {
            seen.placed.push((self.cycle - self.begin, out.place.payload));
        }
        if out.begins.valid {
            let Mark { number, turn } = out.begins.payload;
            let (began, ended) = self.marks.entry(number).or_default();
            assert!(began == ended && turn != *began, "two of one pixel are under way");
            *began = turn;
        }
        if out.ends.valid {
            let Mark { number, turn } = out.ends.payload;
            let (began, ended) = self.marks.entry(number).or_default();
            assert!(began != ended && turn == *began, "what ends was not under way");
            *ended = turn;
        }
    }

    fn pixel(&self, pixel: u32) -> Vec<Word> {
        self.chains[pixel as usize].iter().map(|place| self.words.at(*place)).collect()
    }
}

/// A fifth of what is behind it is hidden: 52429 of 65536 come through, 0.8 * 65536 = 52428.8 rounded.
const FIFTH: u32 = 0x1122_3300 | 51;
/// Its own weight, (65536 - 52429) * 256.
const OWN: u32 = 3_355_392;
/// That behind another one: floor(3355392 * 52429 / 65536), 687186903 / 256 = 2684323.8.
const BEHIND: u32 = 2_684_323;

fn stored(z: u32, rgba: u32, weight: u32) -> Word {
    Word { z, rgba, weight, label: Label::NONE }
}

fn cycles(seen: &Seen) -> Vec<u64> {
    seen.placed.iter().map(|(cycle, _)| *cycle).collect()
}

#[test]
fn of_two_the_farther_ones_weight_changes_and_of_equal_depths_the_earlier_ones() {
    for (z, weight, changed) in [(4, OWN, true), (5, OWN, true), (6, BEHIND, false)] {
        let word = stored(5, FIFTH, OWN);
        let mut bench = Bench::new(2);
        bench.holds(0, &[word]);
        let seen = bench.come(&[(0, z, FIFTH)]);
        let before = if changed { Word { weight: BEHIND, ..word } } else { word };
        assert_eq!(bench.pixel(0), [before, stored(z, FIFTH, weight)], "z = {z}");
        assert_eq!(seen.written, &bench.chains[0][..usize::from(changed)]);
    }
}

#[test]
fn a_clear_fragment_weighs_nothing_and_changes_no_weight() {
    let word = stored(5, FIFTH, OWN);
    let mut bench = Bench::new(2);
    bench.holds(0, &[word]);
    bench.come(&[(0, 1, rgba(9, 9, 9, 0))]);
    assert_eq!(bench.pixel(0), [word, stored(1, rgba(9, 9, 9, 0), 0)]);
}

/// The cycle in which a fragment at depth 5 is at its place that comes in cycle 0 to so many in front of it (`true`) and behind
/// it, with sections of two; and the reads of the NSA table.
fn cost(in_front: &[bool]) -> (u64, u64) {
    let words: Vec<Word> =
        in_front.iter().map(|front| stored(if *front { 1 } else { 9 }, FIFTH, OWN)).collect();
    let mut bench = Bench::new(2);
    bench.holds(0, &words);
    let seen = bench.come(&[(0, 5, FIFTH)]);
    (cycles(&seen)[0], seen.nsa_reads)
}

#[test]
fn one_on_chip_is_compared_in_the_cycle_after_it_is_asked_for() {
    assert_eq!(cost(&[]), (0, 0));
    // The first is asked for in cycle 0 and compared in cycle 1, in which the fragment goes to its place.
    assert_eq!(cost(&[true]), (1, 0));
    assert_eq!(cost(&[true, true, true, true]), (4, 1));
    assert_eq!(cost(&[false, false, true]), (3, 1));
    // The last one is written back before.
    assert_eq!(cost(&[false]), (2, 0));
    assert_eq!(cost(&[false, false, true, false]), (5, 1));
    // The fifth is in the third section; that is on chip too.
    assert_eq!(cost(&[true; 5]), (5, 2));
}

#[test]
fn one_outside_takes_the_latency_of_its_memory() {
    // The fourth section, 20, is the first outside; its latency is 3.
    assert_eq!(cost(&[true; 6]), (6, 2));
    assert_eq!(cost(&[true; 7]), (9, 3));
    // The next one's answer follows right behind.
    assert_eq!(cost(&[true; 8]), (10, 3));
}

/// The pixel's fragments lie in sections 0, 17, 16, 20, 24, 15, 23 and 18, of which those from 20 on are outside: their
/// answers come after 3 cycles. All are asked for in cycles 0 to 7, and answered in 1, 2, 3, 6, 7, 8, 9 and 10.
#[test]
fn reads_go_ahead_of_the_answers() {
    let words: Vec<Word> = (0..8).map(|z| stored(z, FIFTH, OWN)).collect();
    let mut bench = Bench::new(1);
    bench.holds(0, &words);
    assert_eq!(cycles(&bench.come(&[(0, 9, FIFTH)])), [10]);
}

/// Pixels of whose two fragments the second is outside, 20 cycles away.
fn far_away(reads_in_flight: u32) -> Bench {
    let small = small_owned(true);
    let shape = Shape {
        on_chip: 0,
        outside: 40,
        outside_latency: 20,
        capacity: 1,
        reads_in_flight,
        ..small.shape
    };
    let cfg = Config::new(small.screen, shape);
    let mut bench = Bench::of(cfg, (cfg.first_outside()..cfg.null).collect());
    for pixel in 0..15 {
        bench.holds(pixel, &[stored(1, FIFTH, OWN), stored(2, FIFTH, OWN)]);
    }
    bench
}

#[test]
fn fragments_of_several_pixels_are_under_way_together() {
    let fragments: Vec<Comes> = (0..15).map(|pixel| (pixel, 3, FIFTH)).collect();
    // Each is read in two cycles, and placed as the second one comes.
    let seen = far_away(24).come(&fragments);
    assert_eq!(cycles(&seen), (0..15).map(|k| 2 * k + 1 + 20).collect::<Vec<u64>>());
    // With four reads for two of them in 20 cycles and those in which they are asked for and go.
    let seen = far_away(4).come(&fragments);
    assert!(cycles(&seen)[14] > 7 * 20);
}

#[test]
fn those_of_one_pixel_come_one_after_the_other() {
    let seen = far_away(24).come(&[(3, 3, FIFTH), (3, 4, FIFTH), (5, 3, FIFTH)]);
    // The second begins in the cycle after the first is placed, with three to be compared with; all wait for it.
    assert_eq!(cycles(&seen), [21, 22 + 2 + 20, 22 + 4 + 20]);
}

#[test]
fn what_is_not_compared_goes_at_once_or_behind_those_under_way() {
    let seen = far_away(24).come(&[(3, 3, FIFTH)]);
    assert_eq!(cycles(&seen), [21]);
    let mut bench = Bench::new(2);
    bench.holds(0, &[stored(1, FIFTH, OWN)]);
    let seen = bench.come(&[(1, 5, FIFTH), (2, 5, FIFTH), (0, 5, FIFTH), (4, 5, FIFTH)]);
    assert_eq!(cycles(&seen), [0, 1, 3, 4]);
    assert_eq!(bench.pixel(4), [stored(5, FIFTH, OWN)]);
}

#[test]
fn a_fragment_waits_for_its_place_with_the_last_of_its_reads() {
    let mut bench = Bench::new(2);
    bench.holds(0, &[stored(3, FIFTH, OWN), stored(4, FIFTH, OWN)]);
    bench.places = Pattern::of((0..=9).map(|cycle| cycle == 9).collect());
    assert_eq!(cycles(&bench.come(&[(0, 5, FIFTH)])), [10]);
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
        come in proptest::collection::vec((0..4_u32, 0..6_u32, transparent()), 1..14),
        capacity in 1..=4_u32,
        reads_in_flight in 2..12_u32,
        patterns in proptest::collection::vec(pattern(), 4),
    ) {
        let small = small_owned(true);
        let shape = Shape { capacity, reads_in_flight, ..small.shape };
        let mut bench = Bench::of(Config::new(small.screen, shape), SECTIONS.into());
        let [port, on_chip, outside, places] = patterns.try_into().unwrap();
        bench.port = port;
        bench.reads = [on_chip, outside];
        bench.places = places;
        let seen = bench.come(&come);

        let mut model = vec![vec![]; 4];
        let (mut read, mut written, mut placed, mut nsa_reads) = (vec![], vec![], vec![], 0);
        for (pixel, z, rgba) in come {
            let mut weight = (65_536 - through(rgba)) << 8;
            let (pixel, places) = (&mut model[pixel as usize], &bench.chains[pixel as usize]);
            for (word, place) in std::iter::zip(&mut *pixel, places) {
                let word: &mut Word = word;
                if z <= word.z {
                    word.weight = (u64::from(word.weight) * through(rgba) / 65_536) as u32;
                    written.push(*place);
                } else {
                    weight = weight * through(word.rgba) / 65_536;
                }
                read.push(*place);
            }
            // The NSA table has what follows each section but the last.
            nsa_reads += (pixel.len() as u64).div_ceil(u64::from(capacity)).saturating_sub(1);
            placed.push(places[pixel.len()]);
            pixel.push(stored(z, rgba, weight as u32));
        }
        for (pixel, words) in (0..).zip(model) {
            prop_assert_eq!(bench.pixel(pixel), words, "pixel {}", pixel);
        }
        prop_assert_eq!(seen.read, read);
        prop_assert_eq!(seen.written, written);
        prop_assert_eq!(seen.placed.iter().map(|(_, place)| *place).collect::<Vec<_>>(), placed);
        prop_assert_eq!(seen.nsa_reads, nsa_reads);
    }
}
