use super::*;
use crate::test_util::sort;
use pellucid_sim::Sim;
use proptest::prelude::*;

/// What leaves of a frame's fragments (pixel, depth), by number, played in windows round after round; and how many rounds.
fn play(cfg: Config, fragments: &[(u32, u32)]) -> (Vec<u32>, u32) {
    let mut sim = Sim::<Sort>::new(cfg);
    let (mut leaves, mut rounds) = (vec![], 0);
    let windows: Vec<&[(u32, u32)]> = match fragments {
        [] => vec![&[]],
        all => all.chunks(cfg.places() as usize).collect(),
    };
    loop {
        rounds += 1;
        assert!(rounds < 100, "the frame does not end");
        let mut number = 0;
        for (window, of) in (1..).zip(&windows) {
            let last = window == windows.len();
            let items = of.iter().map(|(pixel, z)| {
                // The colour is the number, to tell them apart.
                number += 1;
                let item =
                    PixelFragment { pixel: *pixel, z: *z, rgba: number - 1, label: Label::NONE };
                Marked::item(item)
            });
            let items: Vec<_> = items.chain([Marked::end()]).collect();
            let (mut sent, mut over) = (0, false);
            for cycle in 0.. {
                assert!(cycle < 10_000, "the window does not end");
                let left = sim.moore().left;
                let offer = items.get(sent).map_or(Stream::idle(), |item| Stream::offer(*item));
                sent += usize::from(offer.valid && sim.moore().ready);
                let number = offer.payload.item.rgba;
                let i = In { fragment: offer, number, last, over };
                let out = sim.clock(i).unwrap().out;
                if over {
                    if last && !left {
                        assert!(!sim.moore().left);
                        return (leaves, rounds);
                    }
                    break;
                }
                over = out.sorted.valid && out.sorted.payload.end;
                if out.sorted.valid && !over {
                    assert!(last);
                    leaves.push(out.sorted.payload.item.rgba);
                }
            }
        }
    }
}

proptest! {
    /// By pixel, far to near, the earlier one first, however many windows there are; and as many rounds as windows.
    #[test]
    fn all_fragments_leave_once_in_blending_order(
        fragments in prop::collection::vec((0..6u32, 0..4u32), 0..40),
        place_bits in 1..4u32, lane_bits in 0..2u32,
    ) {
        let cfg = sort(place_bits, lane_bits);
        let mut expected: Vec<u32> = (0..fragments.len() as u32).collect();
        expected.sort_by_key(|number| {
            let (pixel, z) = fragments[*number as usize];
            (pixel, std::cmp::Reverse(z), *number)
        });
        let rounds = (fragments.len() as u32).div_ceil(cfg.places()).max(1);
        prop_assert_eq!(play(cfg, &fragments), (expected, rounds));
    }
}
