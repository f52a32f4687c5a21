use crate::test_util::config;

fn refused(settings: &[(&str, &str)]) -> String {
    config(settings).unwrap_err()
}

fn bound(settings: &[(&str, &str)]) -> u32 {
    config(settings).unwrap().accumulation().unwrap().error_bound
}

#[test]
fn trees_have_as_many_leaves_as_there_are_frames() {
    let levels = |frames, branching| {
        let cfg = config(&[("frames", frames), ("branching", branching)])?;
        Ok::<u32, String>(cfg.levels())
    };
    assert_eq!(levels("1", "2"), Ok(0));
    assert_eq!(levels("1024", "2"), Ok(10));
    assert_eq!(levels("1024", "4"), Ok(5));
    assert_eq!(levels("8", "2,4"), Ok(2));
    assert_eq!(
        levels("6", "2").unwrap_err(),
        "parameter `frames` is 6: expected as many as a tree of this `branching` has leaves, 4 or 8, or \
         `weights` for the frames"
    );
    assert_eq!(
        levels("2", "4").unwrap_err(),
        "parameter `frames` is 2: expected as many as a tree of this `branching` has leaves, 1 or 4, or \
         `weights` for the frames"
    );
    assert_eq!(
        levels("0", "2").unwrap_err(),
        "parameter `frames` is `0`: expected a whole number from 1 to 1024"
    );
    assert_eq!(
        levels("4", "3").unwrap_err(),
        "parameter `branching` is `3`: expected 2, 4, or up to 10 of these level by level, as in `2,4`"
    );
}

#[test]
fn a_buffer_has_bits_for_the_sum() {
    let buffer =
        |frames, bits| config(&[("method", "buffer"), ("frames", frames), ("sum_bits", bits)]);
    assert!(
        buffer("257", "16").is_ok() && buffer("1", "8").is_ok() && buffer("1024", "18").is_ok()
    );
    assert_eq!(
        buffer("258", "16").unwrap_err(),
        "parameter `sum_bits` is 16, which is enough for 257 frames: expected 17 for the 258 of `frames`"
    );
    assert!(
        buffer("2", "8")
            .unwrap_err()
            .ends_with("enough for 1 frames: expected 9 for the 2 of `frames`")
    );
}

#[test]
fn weights_are_one_for_each_frame_and_sum_to_one() {
    assert!(config(&[("frames", "3"), ("weights", "0.5,0.25,0.25")]).is_ok());
    assert_eq!(
        refused(&[("frames", "3"), ("weights", "0.5,0.5")]),
        "parameter `weights` is a list of 2 numbers: expected 3, one for each of `frames`"
    );
    assert_eq!(
        refused(&[("frames", "2"), ("weights", "0.5,0.25")]),
        "parameter `weights` is a list of numbers whose sum is 0.75: expected numbers that sum to one"
    );
    assert_eq!(
        refused(&[("frames", "2"), ("weights", "box"), ("method", "buffer")]),
        "parameter `weights` needs `method=tree`: expected `none` with any other"
    );
    assert!(
        refused(&[("tbuffer.sections", "16777216"), ("tbuffer.section_capacity", "64")])
            .starts_with("parameters `tbuffer.sections` + `tbuffer.outside_sections`")
    );
}

#[test]
fn planes_are_those_of_the_stack() {
    let planes = |frames, branching| {
        let nodes = [("frames", frames), ("branching", branching), ("schedule", "nodes")];
        config(&nodes).unwrap().planes()
    };
    // (b - 1) log_b N + 1.
    assert_eq!((planes("1024", "2"), planes("1024", "4")), (11, 16));
    assert_eq!((planes("2", "2"), planes("32", "2,4")), (2, 8));
    // In one sweep a frame needs no plane.
    assert_eq!(config(&[("frames", "1024")]).unwrap().planes(), 10);
}

#[test]
fn bounds_of_the_paper() {
    assert_eq!(bound(&[("frames", "256")]), 4);
    assert_eq!(bound(&[("frames", "256"), ("branching", "4"), ("node_bits", "10")]), 3);
    assert_eq!(bound(&[("frames", "256"), ("branching", "4")]), 4);
    assert_eq!(bound(&[("frames", "256"), ("method", "blend")]), 255);
    assert_eq!(bound(&[("frames", "32"), ("method", "blend")]), 31);
    assert_eq!(bound(&[("frames", "256"), ("method", "buffer")]), 0);
    assert!(config(&[]).unwrap().accumulation().is_none());
}

/// All of the rounding that a tree of 256 frames can do is done by one: at each node the sum is odd.
#[test]
fn the_bound_of_a_binary_tree_is_reached() {
    // A tree over values whose mean is x + 1 - 2^-8 at most below what its bits would hold: each node has x and x + 1.
    fn leaves(value: u8, levels: u32) -> Vec<u8> {
        if levels == 0 {
            return vec![value];
        }
        [leaves(value, levels - 1), leaves(value + 1, levels - 1)].concat()
    }
    for levels in 1..=8 {
        let frames = leaves(100, levels);
        let of = frames.len().to_string();
        let accumulation = config(&[("frames", &of)]).unwrap().accumulation().unwrap();
        assert_eq!((accumulation.channel)(&frames), 100);
        let mean = frames.iter().map(|c| f64::from(*c)).sum::<f64>() / frames.len() as f64;
        assert_eq!(mean - 100.0, 0.5 * f64::from(levels));
        let error = u32::from(accumulation.exact(&frames)) - 100;
        assert_eq!(error, accumulation.error_bound);
    }
}
