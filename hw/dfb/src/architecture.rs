//! What the architecture says of itself.

use crate::Dfb;
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
    name: "dfb",
    about: "Dynamic Fragment Buffer: fragments counted first, then stored side by side",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("index", "down"), ("scan", "adders")],
        &[("index", "up"), ("scan", "adders")],
        &[("index", "up"), ("scan", "adders"), ("scan_width", "1")],
        &[("index", "down"), ("scan", "passes"), ("scan_width", "2")],
        &[("index", "up"), ("scan", "passes"), ("scan_width", "1")],
        &[("index", "down"), ("overflow", "drop"), ("outside_fragments", "400")],
        &[
            ("counters", "cached"),
            ("counters_sets", "2"),
            ("counters_line", "4"),
            ("outside_fragments", "300"),
        ],
        &[
            ("counters", "cached"),
            ("index", "up"),
            ("scan", "passes"),
            ("count_bits", "5"),
            ("counters_sets", "1"),
            ("outside_fragments", "300"),
        ],
        &[("counters", "cached"), ("fragments", "60"), ("outside_fragments", "0")],
        &[
            ("framebuffer", "cached"),
            ("framebuffer_sets", "2"),
            ("framebuffer_line", "4"),
            ("outside_fragments", "600"),
        ],
    ],
    tight: &[
        ("fragments", "40"),
        ("outside_fragments", "60"),
        ("scan_width", "4"),
        ("sorter_depth", "2"),
        ("outside_latency", "9"),
        ("reads_in_flight", "5"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<Dfb> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    // All on chip; few on chip and enough outside; or, in bands, no more than a pixel takes.
    let fragments = draw(1..=30);
    let (fragments, outside, overflow) = match draw(0..=3) {
        0 => (needs.fragments, 0, "drop"),
        1 => (fragments, needs.fragments, "drop"),
        2 => (fragments, needs.fragments, "bands"),
        _ => (fragments, needs.layers, "bands"),
    };
    let count_bits = if draw(0..=1) == 0 { 32 } else { u32::BITS - needs.layers.leading_zeros() };
    let depth = if draw(0..=1) == 0 { draw(1..=9) } else { 64 };
    vec![
        ("fragments", fragments.to_string()),
        ("outside_fragments", outside.to_string()),
        ("overflow", overflow.to_string()),
        ("count_bits", count_bits.to_string()),
        ("scan_width", one_of(draw, &[1, 2, 4, 8, 16]).to_string()),
        ("scan", one_of(draw, &["adders", "passes"]).to_string()),
        ("index", one_of(draw, &["down", "up"]).to_string()),
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
