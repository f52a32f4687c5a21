use super::*;
use crate::test_util::{Pattern, Source, pattern, window};
use pellucid_sim::Sim;
use proptest::prelude::*;

/// What goes on of a play's fragments, with the cycle in which it was taken, and what was discarded.
fn play(
    cfg: Config,
    play: Play,
    opaque: &[bool],
    starts: Pattern,
    advance: &Pattern,
) -> (Vec<(u64, Marked<Placed>)>, u32, u32) {
    let items = (0..).zip(opaque).map(|(z, opaque)| {
        let rgba = if *opaque { 255 } else { 100 };
        Marked::item(Fragment { z, rgba, ..Fragment::default() })
    });
    let mut source = Source::new(items.chain([Marked::end()]), starts);
    let mut sim = Sim::<Window>::new(cfg);
    let (mut given, mut discarded) = (vec![], 0);
    for cycle in 0.. {
        assert!(cycle < 10_000, "the end of the play does not come");
        let Moore { placed, counted, .. } = sim.moore();
        let advance = advance.at(cycle);
        if placed.valid && advance {
            given.push((cycle, placed.payload));
            if placed.payload.end {
                return (given, discarded, counted);
            }
        }
        let survivors = survivors::Moore::default();
        let i = In {
            fragment: source.offer(cycle),
            play,
            survivors,
            there: true,
            advance,
            over: false,
        };
        let out = sim.clock(i).unwrap().out;
        discarded += u32::from(out.discarded);
        source.edge(out.taken);
    }
    unreachable!()
}

proptest! {
    /// For any number of fragments and any buffer, windows one after the other shade each fragment once, each in a place of its
    /// own among those of its window.
    #[test]
    fn no_fragment_is_shaded_twice_or_never(
        opaque in prop::collection::vec(prop::bool::weighted(0.2), 0..60),
        place_bits in 0..5u32,
        fragment_cycles in 1..4u32,
        starts in pattern(),
        advance in pattern(),
    ) {
        let cfg = window(place_bits, fragment_cycles, true);
        let transparent = opaque.iter().filter(|opaque| !**opaque).count() as u32;
        let places = 1 << place_bits;
        let mut seen = vec![];
        for number in 0..transparent.div_ceil(places).max(1) {
            let of = Play { draws: number == 0, shades: true, reads: false, window: number };
            let (given, discarded, counted) = play(cfg, of, &opaque, starts.clone(), &advance);
            let all: Vec<Placed> =
                given.iter().filter(|(_, item)| !item.end).map(|(_, item)| item.item).collect();
            let drawn = all.iter().filter(|placed| placed.fragment.is_opaque()).count();
            prop_assert_eq!(drawn, if number == 0 { opaque.len() - transparent as usize } else { 0 });
            let shaded: Vec<&Placed> =
                all.iter().filter(|placed| !placed.fragment.is_opaque()).collect();
            let found: Vec<u32> = shaded.iter().map(|placed| placed.place).collect();
            prop_assert_eq!(found, (0..shaded.len() as u32).collect::<Vec<_>>());
            prop_assert!(shaded.len() as u32 <= places);
            prop_assert_eq!(counted, transparent);
            prop_assert_eq!(discarded, transparent - shaded.len() as u32);
            seen.extend(shaded.iter().map(|placed| placed.fragment.z));
        }
        let expected: Vec<u32> =
            (0..).zip(&opaque).filter(|(_, opaque)| !**opaque).map(|(z, _)| z).collect();
        prop_assert_eq!(seen, expected);
    }
}

#[test]
fn shaded_ones_keep_their_distance_and_discarded_ones_take_a_cycle() {
    let cfg = window(1, 3, true);
    let of = |window| Play { draws: true, shades: true, reads: true, window };
    let cycles = |window| {
        let always = Pattern::always();
        let (given, ..) = play(cfg, of(window), &[false; 6], always.clone(), &always);
        given.iter().map(|(cycle, _)| *cycle).collect::<Vec<_>>()
    };
    // Two in the window, each 3 cycles after the other; the four others and the end a cycle each.
    assert_eq!(cycles(0), [1, 4, 9]);
    assert_eq!(cycles(1), [3, 6, 9]);
    assert_eq!(cycles(2), [5, 8, 9]);
}

#[test]
fn a_batch_has_no_second_window() {
    let of = Play { draws: false, shades: true, reads: false, window: 0 };
    let always = Pattern::always();
    let (given, discarded, counted) =
        play(window(1, 1, false), of, &[false; 5], always.clone(), &always);
    assert_eq!((given.len(), discarded, counted), (3, 3, 5));
}
