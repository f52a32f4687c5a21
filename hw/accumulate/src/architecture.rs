//! What the architecture says of itself.

use crate::Accumulate;
use crate::config::{Config, PRESETS, Params};
use pellucid_machine::Architecture;
use pellucid_machine::architecture::{
    Built, Draw, Needs, Parameterised, Setting, about, chosen, one_of,
};
use pellucid_machine::model::Configured;
use pellucid_machine::params::Parameters;
use pellucid_machine::pixel::Screen;

/// See the module's description.
pub static ARCHITECTURE: Architecture = Architecture {
    name: "accumulate",
    about: "Accumulation: several frames as one image, by a tree of averages, a buffer of sums, or blending",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("frames", "4")],
        &[("frames", "4"), ("schedule", "nodes"), ("plane_bits", "10"), ("node_bits", "12")],
        &[("frames", "8"), ("branching", "2,4")],
        &[("frames", "3"), ("weights", "triangle")],
        &[("frames", "5"), ("branching", "4"), ("weights", "gaussian"), ("schedule", "nodes")],
        &[("frames", "2"), ("method", "buffer")],
        &[("frames", "2"), ("method", "blend")],
        &[("frames", "4"), ("planes", "outside")],
        &[
            ("frames", "7"),
            ("planes", "outside"),
            ("schedule", "nodes"),
            ("branching", "4,2"),
            ("weights", "box"),
        ],
        &[("frames", "3"), ("planes", "outside"), ("method", "buffer"), ("sum_bits", "24")],
    ],
    tight: &[
        ("reads_in_flight", "4"),
        ("tbuffer.sections", "40"),
        ("tbuffer.outside_sections", "400"),
        ("tbuffer.section_capacity", "2"),
        ("tbuffer.sorter_depth", "2"),
        ("tbuffer.outside_latency", "9"),
        ("tbuffer.reads_in_flight", "5"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<Accumulate> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    let method = one_of(draw, &["tree", "tree", "tree", "buffer", "blend"]);
    let (branching, leaves) = one_of(draw, &[("2", 2), ("2", 4), ("4", 4), ("2,4", 8)]);
    let weights = one_of(draw, &["none", "box", "triangle", "gaussian"]);
    let any = draw(1..=5);
    let (frames, weights) = match (method, weights) {
        ("tree", "none") => (one_of(draw, &[1, leaves]), "none"),
        ("tree", weights) => (any, weights),
        _ => (any, "none"),
    };
    // Few sections on chip and enough outside, or all on chip.
    let (sections, outside) = match draw(0..=3) {
        0 => (needs.fragments, 0),
        _ => (draw(1..=30), needs.fragments),
    };
    vec![
        ("frames", frames.to_string()),
        ("method", method.to_string()),
        ("branching", branching.to_string()),
        ("schedule", one_of(draw, &["stream", "nodes"]).to_string()),
        ("sum_bits", draw(11..=24).to_string()),
        ("node_bits", draw(8..=24).to_string()),
        ("plane_bits", draw(8..=16).to_string()),
        ("weights", weights.to_string()),
        ("weight_bits", draw(1..=16).to_string()),
        ("planes", one_of(draw, &["on_chip", "outside"]).to_string()),
        ("reads_in_flight", draw(1..=9).to_string()),
        ("tbuffer.sections", sections.to_string()),
        ("tbuffer.outside_sections", outside.to_string()),
        ("tbuffer.outside_latency", draw(1..=20).to_string()),
        ("tbuffer.ssa", one_of(draw, &["on_chip", "cached"]).to_string()),
        ("tbuffer.sorter_depth", draw(1..=9).to_string()),
    ]
}
