//! The R-buffer.

use crate::frames::{
    ENOUGH, OverFrames, Setup, Tested, check_drops, fragments, one_frame, preset, properties,
    screens, tried,
};
use pellucid_hw::machine::Check;
use pellucid_hw::pixel::{Fragment, Screen, Z_FAR};
use pellucid_hw::rbuffer::RBuffer;
use pellucid_hw::rbuffer::config::{Config, Params};
use pellucid_testbench::scene::{Options, built_in};
use proptest::prelude::*;

impl Tested for RBuffer {
    fn machines(screen: Screen) -> BoxedStrategy<Config> {
        let queues = prop_oneof![
            3 => (2..=30u32).prop_map(|queue| (queue, ENOUGH)),
            1 => Just((ENOUGH, 0)),
        ];
        let params = (queues, 1..=20u32).prop_map(|((queue, outside_queue), outside_latency)| {
            Params { queue, outside_queue, outside_latency }
        });
        params.prop_map(move |params| Config::new(screen, params).unwrap()).boxed()
    }

    fn over_frames(check: &Check) -> OverFrames {
        match check.what.split([':', ',']).next() {
            Some("passes") => OverFrames::Sum,
            Some("most fragments in the queue") => OverFrames::Max,
            _ => OverFrames::Together,
        }
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
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn a_full_queue_drops_what_finds_no_room(
        (mut setup, frame) in one_frame::<RBuffer>(), queue in 2..40u32, outside_queue in 0..40u32,
    ) {
        let Config { screen, params, .. } = setup.cfg;
        setup.cfg = Config::new(screen, Params { queue, outside_queue, ..params }).unwrap();
        check_drops(&setup, &frame, &without_place(screen, &frame, queue + outside_queue))?;
    }

    #[test]
    fn passes_are_those_of_the_transition_table(
        (setup, frame) in one_frame::<RBuffer>()
    ) {
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
        let params = Params { queue: ENOUGH, outside_queue: 0, outside_latency: 1 };
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
