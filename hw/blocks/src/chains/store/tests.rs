use super::*;
use crate::chains::config::{Link, Shape};
use crate::test_util::{Pattern, Source, contents, edge, holding, pattern, screen, shape, traffic};
use pellucid_machine::pixel::Screen;
use pellucid_sim::{Ram1R1W, Ram1RW, ReadDuringWrite, Sim};
use proptest::prelude::*;
use proptest::sample::select;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

const SECTIONS: u32 = 40;
const SCREEN: (u32, u32) = (10, 7);
const LINKS: [Link; 3] = [Link::Walk, Link::Tail, Link::Head];

fn config(link: Link, capacity: u32) -> Config {
    let half = SECTIONS / 2;
    let shape = Shape { on_chip: half, outside: half, capacity, link, ..shape() };
    Config::new(screen(SCREEN.0, SCREEN.1), shape)
}

/// The store unit beside its tables, which are models of their own, and a plain list of free
/// sections.
struct Bench {
    sim: Sim<Store>,
    ssa: Ram1R1W<SsaEntry>,
    nsa: Ram1RW<NsaEntry>,
    asked: Option<u32>,
    occupied: BTreeSet<u32>,
    sections: BTreeMap<(u32, u32), Word>,
    free: VecDeque<u32>,
    /// When sections outside may be asked for.
    port: Pattern,
}

/// What a frame came to, cycle by cycle.
#[derive(Debug, Default, PartialEq)]
struct Seen {
    /// Cycles in which a fragment was written.
    placed: Vec<u64>,
    /// Cycles in which a fragment was dropped.
    dropped: Vec<u64>,
    /// Cycles in which a fragment waited for a section.
    waited: Vec<u64>,
    /// Cycles in which a pixel got its first fragment.
    first: Vec<u64>,
    /// The cycle in which the whole frame was stored.
    stored: u64,
}

impl Bench {
    fn new(cfg: Config, free: &[u32]) -> Bench {
        let Screen { width, height, .. } = cfg.screen;
        let null = SsaEntry { head: SECTIONS, tail: 0, fill: 0 };
        Bench {
            ssa: holding(&vec![null; (width * height) as usize], cfg, ReadDuringWrite::New),
            nsa: Ram1RW::new(SECTIONS, cfg, 1),
            asked: None,
            occupied: BTreeSet::new(),
            sections: BTreeMap::new(),
            free: free.iter().copied().collect(),
            port: Pattern::always(),
            sim: Sim::new(cfg),
        }
    }

    /// Stores `fragments`, given as pixel and word; a free section is offered from a cycle of
    /// `grants` on until it is taken.
    fn store(&mut self, fragments: &[(u32, Word)], starts: Pattern, grants: &Pattern) -> Seen {
        let item = |&(pixel, Word { z, rgba, label, .. })| {
            Marked::item(PixelFragment { pixel, z, rgba, label })
        };
        let mut source = Source::new(fragments.iter().map(item).chain([Marked::end()]), starts);
        let (mut seen, mut offered) = (Seen::default(), false);
        for cycle in 0.. {
            assert!(cycle < 50_000, "the end of the frame does not come");
            offered |= grants.at(cycle);
            let grant = match self.free.front() {
                Some(section) if offered => Stream::offer(*section),
                _ => Stream::idle(),
            };
            let i = In {
                fragment: source.offer(cycle),
                ssa: self.ssa.q(),
                nsa: self.nsa.q(),
                word: Read::default(),
                grant,
                exhausted: self.free.is_empty(),
                outside_ready: self.port.at(cycle),
                under_way: under_way::Moore::default(),
                reads: ReadsReady::default(),
            };
            source.edge(self.sim.moore().ready);
            let out = self.sim.clock(i).unwrap().out;
            self.ssa.pass_read(out.ssa_read);
            self.ssa.pass_write(out.ssa_write);
            edge(&mut self.ssa);
            self.nsa.pass(out.nsa);
            edge(&mut self.nsa);
            if out.occupancy_set.valid {
                let pixel = out.occupancy_set.payload;
                assert_eq!(self.asked, Some(pixel), "set without being asked for");
                assert!(self.occupied.insert(pixel), "pixel {pixel} was set twice");
            }
            if out.occupancy_ask.valid {
                self.asked = Some(out.occupancy_ask.payload);
            }
            if out.place.valid {
                let Place { section, slot } = out.place.payload;
                assert!(i.outside_ready || section < SECTIONS / 2, "the port takes nothing");
                let before = self.sections.insert((section, slot), out.word);
                assert_eq!(before, None, "slot {slot} of section {section} was written twice");
                seen.placed.push(cycle);
            }
            if out.take {
                assert!(grant.valid && out.place.valid, "a section is taken for nothing");
                self.free.pop_front();
                offered = false;
            }
            seen.dropped.extend(out.dropped.then_some(cycle));
            seen.waited.extend(out.waits.then_some(cycle));
            seen.first.extend(out.first.then_some(cycle));
            if out.frame_stored {
                seen.stored = cycle;
                return seen;
            }
        }
        unreachable!("the loop ends by return")
    }

    fn next_section(&mut self, section: u32) -> NsaEntry {
        self.nsa.read(section);
        edge(&mut self.nsa);
        self.nsa.q().data
    }

    /// Every pixel's fragments in the order of their arrival, as the tables have them.
    fn chains(&mut self) -> Vec<Vec<Word>> {
        let cfg = *self.sim.config();
        let entries = contents(&mut self.ssa, cfg.screen.pixels());
        let mut chains = vec![];
        for entry in entries {
            let (mut chain, mut section) = (vec![], entry.head);
            while section != SECTIONS {
                let newest_first = cfg.shape.link == Link::Head;
                let (next, fill) = if cfg.shape.link == Link::Tail && section == entry.tail {
                    (SECTIONS, entry.fill)
                } else {
                    let NsaEntry { next, fill } = self.next_section(section);
                    match cfg.shape.link {
                        Link::Walk => (next, fill),
                        Link::Head if section == entry.head => (next, entry.fill),
                        Link::Tail | Link::Head => (next, cfg.shape.capacity),
                    }
                };
                let may_have_holes =
                    if newest_first { section == entry.head } else { next == SECTIONS };
                assert!(
                    may_have_holes || fill == cfg.shape.capacity,
                    "section {section} has a hole"
                );
                let words: Vec<Word> =
                    (0..fill).map(|slot| self.sections[&(section, slot)]).collect();
                if newest_first {
                    chain.splice(0..0, words);
                } else {
                    chain.extend(words);
                }
                section = next;
            }
            chains.push(chain);
        }
        chains
    }
}

/// One pixel's fragments `count` times, distinguishable.
fn same_pixel(count: u32) -> Vec<(u32, Word)> {
    (0..count).map(|k| (9, Word { z: k, rgba: k, ..Word::default() })).collect()
}

fn all_sections() -> Vec<u32> {
    (0..SECTIONS).collect()
}

#[test]
fn where_the_entry_tells_the_fill_one_fragment_a_cycle_is_stored_same_pixel_or_not() {
    for (link, capacity) in
        [Link::Tail, Link::Head].into_iter().flat_map(|link| (1..=4).map(move |l| (link, l)))
    {
        let mut fragments = same_pixel(10);
        fragments.extend((0..10).map(|k| (k % 2 * 30, Word { z: k, rgba: k, ..Word::default() })));
        let mut bench = Bench::new(config(link, capacity), &all_sections());
        let seen = bench.store(&fragments, Pattern::always(), &Pattern::always());
        let first = seen.placed[0];
        assert_eq!(
            seen.placed,
            (first..first + 20).collect::<Vec<_>>(),
            "{link:?}, L = {capacity}"
        );
        assert_eq!(seen.stored, first + 20, "{link:?}, L = {capacity}");
    }
}

#[test]
fn walk_takes_a_cycle_a_section_and_one_more_and_one_to_link() {
    for capacity in 1..=4 {
        let mut bench = Bench::new(config(Link::Walk, capacity), &all_sections());
        let seen = bench.store(&same_pixel(17), Pattern::always(), &Pattern::always());
        // The chain has c = ceil(k / L) sections when fragment k comes: c + 1 cycles, of which it is
        // written in the last; one more if all c are full and c is not 0.
        let (mut at, mut expected) = (seen.placed[0], vec![]);
        for k in 0..17 {
            let sections = u64::from(k).div_ceil(u64::from(capacity));
            expected.push(at + sections);
            at += sections + 1 + u64::from(k > 0 && k % capacity == 0);
        }
        assert_eq!(seen.placed, expected, "L = {capacity}");
        assert_eq!(seen.stored, at, "L = {capacity}");
    }
}

#[test]
fn without_a_grant_it_waits_and_then_goes_on() {
    for link in LINKS {
        let mut bench = Bench::new(config(link, 2), &all_sections());
        let cycles = (0..=10).map(|cycle| cycle == 10).collect();
        let seen = bench.store(&same_pixel(1), Pattern::always(), &Pattern::of(cycles));
        // It comes to hand in cycle 2, two after it was offered.
        assert_eq!((seen.waited, seen.placed), ((2..10).collect(), vec![10]), "{link:?}");
        assert_eq!(seen.stored, 11, "{link:?}");
    }
}

#[test]
fn exhausted_drops_what_needs_a_section_and_stores_what_does_not() {
    for link in LINKS {
        let mut bench = Bench::new(config(link, 2), &[5]);
        let word = |z| Word { z, rgba: z, ..Word::default() };
        let fragments = [(3, word(1)), (4, word(2)), (3, word(3)), (3, word(4))];
        let seen = bench.store(&fragments, Pattern::always(), &Pattern::always());
        assert_eq!((seen.placed.len(), seen.dropped.len(), seen.waited.len()), (2, 2, 0));
        assert_eq!(bench.chains()[3], [word(1), word(3)], "{link:?}");
        assert_eq!(bench.chains()[4], [], "{link:?}");
    }
}

/// Chains as plain lists, and which fragments find no section.
fn reference(fragments: &[(u32, Word)], capacity: u32, mut free: usize) -> (Vec<Vec<Word>>, usize) {
    let mut chains: Vec<Vec<Word>> = vec![vec![]; (SCREEN.0 * SCREEN.1) as usize];
    let mut dropped = 0;
    for (pixel, word) in fragments {
        let chain = &mut chains[*pixel as usize];
        let full = chain.len().is_multiple_of(capacity as usize);
        if full && free == 0 {
            dropped += 1;
            continue;
        }
        free -= usize::from(full);
        chain.push(*word);
    }
    (chains, dropped)
}

proptest! {
    /// Against plain lists, with gaps before, late grants, and not always sections enough.
    #[test]
    fn behaves_as_plain_lists(
        link in select(&LINKS),
        capacity in 1u32..=4,
        free in Just(all_sections()).prop_shuffle(),
        sections in 0..=SECTIONS as usize,
        pixels in proptest::collection::vec(prop_oneof![0u32..3, 60u32..70], 0..80),
        starts in pattern(),
        grants in pattern(),
        port in pattern(),
    ) {
        let words = (0..).map(|k| Word { z: k, rgba: k + 1000, ..Word::default() });
        let fragments: Vec<(u32, Word)> = pixels.into_iter().zip(words).collect();
        let (chains, dropped) = reference(&fragments, capacity, sections);
        let cfg = config(link, capacity);
        let mut bench = Bench::new(cfg, &free[..sections]);
        bench.port = port;
        // In two frames, of which the second finds the tables as the first left them.
        let (early, late) = fragments.split_at(fragments.len() / 3);
        let mut seen = bench.store(early, starts.clone(), &grants);
        let rest = bench.store(late, starts, &grants);
        seen.placed.extend(rest.placed);
        seen.dropped.extend(rest.dropped);
        seen.first.extend(rest.first);
        // One read of the SSA table a fragment. With a kept fill one write a stored one, and an NSA write
        // where a section is linked behind another, or to the one behind it or NULL; with a walk one write a pixel.
        let firsts = seen.first.len();
        let (reads, writes) = traffic(&mut bench.ssa);
        let writes = writes - u64::from(SCREEN.0 * SCREEN.1);
        let stored = fragments.len() - dropped;
        prop_assert_eq!(reads, fragments.len() as u64);
        prop_assert_eq!(writes, if link == Link::Walk { firsts } else { stored } as u64);
        let taken = sections - bench.free.len();
        if link == Link::Tail {
            prop_assert_eq!(traffic(&mut bench.nsa), (0, (taken - firsts) as u64));
        } else if link == Link::Head {
            prop_assert_eq!(traffic(&mut bench.nsa), (0, taken as u64));
        }
        prop_assert_eq!(bench.chains(), chains.clone());
        prop_assert_eq!(seen.dropped.len(), dropped);
        prop_assert_eq!(seen.placed.len(), stored);
        let occupied = |pixel: &usize| !chains[*pixel].is_empty();
        prop_assert_eq!(firsts, (0..chains.len()).filter(occupied).count());
        let pixels = (0..chains.len()).filter(occupied).map(|pixel| pixel as u32);
        prop_assert_eq!(bench.occupied, pixels.collect::<BTreeSet<_>>());
    }
}
