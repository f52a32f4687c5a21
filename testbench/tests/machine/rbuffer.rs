//! The R-buffer.

use crate::frames::{
    ADDED, ENOUGH, Setup, Tested, check_drops, effort, fragments, one_frame, properties, screens,
    tried,
};
use crate::presets::preset;
use pellucid_hw::machine::Tally;
use pellucid_hw::pixel::{Fragment, Screen, Z_FAR};
use pellucid_hw::rbuffer::RBuffer;
use pellucid_hw::rbuffer::config::{Config, Overflow, Params};
use pellucid_sim::Label;
use pellucid_testbench::scene::{Options, built_in};
use proptest::prelude::*;

impl Tested for RBuffer {
    fn machines(screen: Screen) -> BoxedStrategy<Config> {
        let queues = prop_oneof![
            3 => (2..=30u32).prop_map(|queue| (queue, ENOUGH, Overflow::Outside)),
            1 => Just((ENOUGH, 0, Overflow::Outside)),
            3 => (2..=30u32).prop_map(|queue| (queue, 0, Overflow::Replay)),
        ];
        let params = (queues, 1..=20u32).prop_map(|(queues, outside_latency)| {
            let (queue, outside_queue, overflow) = queues;
            Params { queue, overflow, outside_queue, outside_latency }
        });
        params.prop_map(move |params| Config::new(screen, params).unwrap()).boxed()
    }

    /// With replay all fragments of a pixel have to fit into the queue.
    fn fitted(cfg: Config, frames: &[Vec<Fragment>]) -> Config {
        if cfg.params.overflow == Overflow::Outside {
            return cfg;
        }
        let deepest = frames.iter().flat_map(|frame| {
            let transparent = || frame.iter().filter(|f| !f.is_opaque());
            transparent().map(move |f| transparent().filter(|g| (g.x, g.y) == (f.x, f.y)).count())
        });
        let deepest = deepest.max().unwrap_or_default() + ADDED;
        let queue = cfg.params.queue.max(deepest as u32);
        Config::new(cfg.screen, Params { queue, ..cfg.params }).unwrap()
    }

    fn resolved(tally: &Tally) -> [u64; 2] {
        ["popped", "queue_idle"].map(|name| tally.figure(name))
    }
}

properties!(RBuffer);

/// Which fragments of a frame find no place in a queue of `places`.
fn without_place(screen: Screen, frame: &[Fragment], places: u32) -> Vec<bool> {
    let mut nearest = vec![Z_FAR; screen.pixels() as usize];
    let mut free = places;
    let mut dropped = vec![];
    for f in frame {
        let nearest = &mut nearest[(f.y * screen.width + f.x) as usize];
        let visible = f.z < *nearest;
        if visible && f.is_opaque() {
            *nearest = f.z;
        }
        let stored = visible && !f.is_opaque();
        dropped.push(stored && free == 0);
        free -= u32::from(stored && free > 0);
    }
    dropped
}

/// What the transition table of the R-buffer does to a frame, pass after pass on plain lists: how many
/// passes there are, and how many fragments are popped.
fn passes(screen: Screen, frame: &[Fragment]) -> (u64, u64) {
    let mut opaque = vec![Z_FAR; screen.pixels() as usize];
    let mut queue = vec![];
    for f in frame {
        let pixel = (f.y * screen.width + f.x) as usize;
        if f.z >= opaque[pixel] {
        } else if f.is_opaque() {
            opaque[pixel] = f.z;
        } else {
            queue.push((pixel, f.z));
        }
    }
    let (mut passes, mut popped) = (0, 0);
    while !queue.is_empty() {
        let farthest = |pixel| queue.iter().filter(|f| f.0 == pixel).map(|f| f.1).max();
        let z1: Vec<Option<u32>> = (0..opaque.len()).map(farthest).collect();
        let mut blended = vec![false; opaque.len()];
        popped += queue.len() as u64;
        passes += 1;
        let first = passes == 1;
        queue.retain(|(pixel, z)| {
            // An opaque fragment that came later hides the farthest: this pass only culls.
            let hides = first && z1[*pixel] >= Some(opaque[*pixel]);
            let blend = !hides && !blended[*pixel] && z1[*pixel] == Some(*z);
            blended[*pixel] |= blend;
            !(blend || (hides && *z >= opaque[*pixel]))
        });
    }
    (passes, popped)
}

proptest! {
    #![proptest_config(effort())]

    #[test]
    fn a_full_queue_drops_what_finds_no_room(
        (mut setup, frame) in one_frame::<RBuffer>(), queue in 2..40u32, outside_queue in 0..40u32,
    ) {
        let Config { screen, params, .. } = setup.cfg;
        let overflow = Overflow::Outside;
        setup.cfg = Config::new(screen, Params { queue, overflow, outside_queue, ..params }).unwrap();
        check_drops(&setup, &frame, &without_place(screen, &frame, queue + outside_queue))?;
    }

    #[test]
    fn passes_are_those_of_the_transition_table(
        (setup, frame) in one_frame::<RBuffer>()
    ) {
        let params = Params { queue: ENOUGH, ..setup.cfg.params };
        let setup = Setup::<RBuffer> { cfg: Config::new(setup.screen(), params).unwrap(), ..setup };
        let run = tried(setup.run(std::slice::from_ref(&frame)))?;
        let figure = |name| run.tally.own.iter().find(|f| f.name == name).unwrap().value;
        let expected = passes(setup.screen(), &frame);
        prop_assert_eq!((figure("passes"), figure("popped")), expected);
    }

    /// A pass takes a cycle for each fragment and four more; a frame two more in all.
    #[test]
    fn one_fragment_leaves_the_queue_in_each_cycle(
        (screen, frame) in screens().prop_flat_map(|screen| (Just(screen), fragments(screen)))
    ) {
        let params = Params { queue: ENOUGH, outside_queue: 0, ..Params::default() };
        let setup = Setup::<RBuffer>::free(Config::new(screen, params).unwrap());
        let run = tried(setup.run(std::slice::from_ref(&frame)))?;
        let (passes, popped) = passes(screen, &frame);
        prop_assert_eq!(run.tally.cycles.resolve, popped + 4 * passes + 2);
        prop_assert_eq!(&run.images[0], &setup.golden_image(&frame));
    }
}

#[test]
fn outside_memory_costs_no_cycle_if_the_part_on_chip_covers_its_latency() {
    for scene in built_in().iter().filter(|scene| scene.name.starts_with("paper-")) {
        let [on_chip, outside] = ["on-chip", "outside"]
            .map(|name| preset("rbuffer", scene.name, &Options::default(), name).cycles);
        assert_eq!(outside.store, on_chip.store, "{}", scene.name);
        assert_eq!(outside.resolve, on_chip.resolve, "{}", scene.name);
    }
}

proptest! {
    #![proptest_config(effort())]

    /// One pixel alone: what does not fit is dropped, and the run says so.
    #[test]
    fn a_pixel_that_does_not_fit_at_all_is_cut(queue in 2..40u32, seed: u64) {
        let screen = Screen { width: 1, height: 1, background: 0x10_20_30 };
        let fragment = |k: u64| {
            let n = (seed + k).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let rgba = (n >> 32) as u32;
            Fragment { x: 0, y: 0, z: n as u32 & Z_FAR, rgba: rgba & !1, label: Label::NONE }
        };
        let frame: Vec<Fragment> = (0..60).map(fragment).collect();
        let params = Params { queue, overflow: Overflow::Replay, ..Params::default() };
        let setup = Setup::<RBuffer>::free(Config::new(screen, params).unwrap());
        check_drops(&setup, &frame, &without_place(screen, &frame, queue))?;
    }
}

/// A frame of which the fragments come layer by layer, so that no pixel is complete before the end.
#[test]
fn layer_by_layer_comes_out_in_few_rounds() {
    let screen = Screen { width: 40, height: 30, background: 0 };
    let layers = 6;
    let frame: Vec<Fragment> = (0..layers)
        .flat_map(|k| {
            (0..screen.pixels()).map(move |pixel| Fragment {
                x: pixel % screen.width,
                y: pixel / screen.width,
                z: (k * 7 + pixel) % 40,
                rgba: (pixel + k) << 8 | 0x80,
                label: Label::NONE,
            })
        })
        .collect();
    for (queue, failed, rounds) in [(7200, 0, 1), (3600, 1, 3), (900, 3, 11)] {
        let params = Params { queue, overflow: Overflow::Replay, ..Params::default() };
        let setup = Setup::<RBuffer>::free(Config::new(screen, params).unwrap());
        let run = setup.run(std::slice::from_ref(&frame)).unwrap();
        assert_eq!(run.images[0], setup.golden_image(&frame), "queue={queue}");
        assert_eq!(run.tally.fragments.dropped, 0);
        // A band of 150 pixels fits into 900 places: 8 of them, and each attempt at more fails.
        let counted = ["failed_rounds", "rounds"].map(|name| run.tally.figure(name));
        assert_eq!(counted, [failed, rounds], "queue={queue}");
        let again = (rounds - 1) * frame.len() as u64;
        assert_eq!(run.tally.figure("replayed"), again, "queue={queue}");
    }
}

/// Of 16 pixels the first 4 have as many fragments as half of the queue holds: the next band has 8.
#[test]
fn a_band_grows_if_just_half_of_the_queue_is_free() {
    let screen = Screen { width: 16, height: 1, background: 0 };
    let layers = [1, 1, 1, 1, 2, 1, 1, 1, 1, 1, 0, 0, 1, 1, 1, 1];
    let of_pixel = |(x, n): (u32, u32)| {
        (0..n).map(move |k| Fragment { x, y: 0, z: k + 1, rgba: 0x80, label: Label::NONE })
    };
    let frame: Vec<Fragment> = (0..).zip(layers).flat_map(of_pixel).collect();
    let params = Params { queue: 8, overflow: Overflow::Replay, ..Params::default() };
    let setup = Setup::<RBuffer>::free(Config::new(screen, params).unwrap());
    let run = setup.run(std::slice::from_ref(&frame)).unwrap();
    // 16 pixels have 15 fragments, 8 have 9: too many. Then come 4, 8 and 4 pixels, with 4, 7 and 4.
    let counted = ["failed_rounds", "rounds"].map(|name| run.tally.figure(name));
    assert_eq!(counted, [2, 5]);
}

/// One pixel among others has more fragments than the queue holds: in the round of its own the first ones
/// stay.
#[test]
fn a_pixel_among_others_that_does_not_fit_is_cut() {
    let screen = Screen { width: 5, height: 2, background: 0x40_50_60 };
    let fragment = |k: u32, x, y| Fragment {
        x,
        y,
        z: k * 7 % 50 + 1,
        rgba: k << 9 | 0x70,
        label: Label::NONE,
    };
    let many = (0..200).map(|k| fragment(k, k % 5, k / 5 % 2));
    let deep = (200..260).map(|k| fragment(k, 3, 1));
    let frame: Vec<Fragment> = many.chain(deep).collect();
    // 20 fragments at each pixel, 60 more at one.
    let queue = 25;
    let params = Params { queue, overflow: Overflow::Replay, ..Params::default() };
    let setup = Setup::<RBuffer>::free(Config::new(screen, params).unwrap());
    let mut of_pixel = 0;
    let mut dropped = vec![];
    for f in &frame {
        let deep = (f.x, f.y) == (3, 1);
        dropped.push(deep && of_pixel >= queue);
        of_pixel += u32::from(deep);
    }
    assert_eq!(dropped.iter().filter(|dropped| **dropped).count(), 55);
    check_drops(&setup, &frame, &dropped).unwrap();
}
