//! What the architecture says of itself.

use crate::B3d;
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
    name: "b3d",
    about: "B3D: a fixed array of slots for each pixel, with a counter each",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("overflow", "rebuild")],
        &[("overflow", "drop"), ("layers", "5")],
        &[("overflow", "rebuild"), ("fragments", "100000")],
        &[("counters", "cached"), ("counters_sets", "2"), ("counters_line", "4")],
        &[("counters", "cached"), ("overflow", "drop"), ("layers", "5"), ("counters_sets", "1")],
        &[("framebuffer", "cached"), ("framebuffer_sets", "2"), ("framebuffer_line", "4")],
    ],
    tight: &[
        ("layers", "2"),
        ("most_layers", "12"),
        ("fragments", "500"),
        ("sorter_depth", "2"),
        ("outside_latency", "9"),
        ("reads_in_flight", "5"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<B3d> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    // Enough from the start, or few that come to be enough: whether that takes the last bit or is a round number.
    let enough = needs.layers + draw(0..=3);
    let few = draw(1..=enough.min(4));
    let (layers, overflow) = match draw(0..=3) {
        0 => (enough, "drop"),
        1 => (enough, "rebuild"),
        _ => (few, "rebuild"),
    };
    let on_chip = one_of(draw, &[1, needs.layers, needs.fragments, 1 << 20]);
    let depth = if draw(0..=1) == 0 { draw(1..=9) } else { 64 };
    vec![
        ("layers", layers.to_string()),
        ("most_layers", enough.to_string()),
        ("overflow", overflow.to_string()),
        ("fragments", on_chip.to_string()),
        ("sorter_depth", depth.to_string()),
        ("outside_latency", draw(1..=20).to_string()),
        ("reads_in_flight", draw(2..=9).to_string()),
        ("counters", one_of(draw, &["on_chip", "cached"]).to_string()),
        ("counters_sets", one_of(draw, &[1, 2, 8]).to_string()),
        ("counters_ways", one_of(draw, &[1, 2, 4]).to_string()),
        ("counters_line", one_of(draw, &[1, 2, 4, 16]).to_string()),
        ("framebuffer", one_of(draw, &["on_chip", "cached"]).to_string()),
        ("framebuffer_sets", one_of(draw, &[1, 2, 8]).to_string()),
        ("framebuffer_ways", one_of(draw, &[1, 2, 4]).to_string()),
        ("framebuffer_line", one_of(draw, &[1, 2, 4, 16]).to_string()),
    ]
}
