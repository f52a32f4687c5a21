//! What the architecture says of itself.

use crate::TBuffer;
use crate::config::{Config, PRESETS, Params};
use pellucid_blocks::allocator::{AllocatorKind, Chosen};
use pellucid_machine::Architecture;
use pellucid_machine::architecture::{
    Built, Draw, Needs, Parameterised, Setting, about, chosen, one_of,
};
use pellucid_machine::model::Configured;
use pellucid_machine::params::{ParamType, Parameters};
use pellucid_machine::pixel::Screen;

/// See the module's description.
pub static ARCHITECTURE: Architecture = Architecture {
    name: "tbuffer",
    about: "T-buffer: fragments grouped by pixel in sections that any pixel can have",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("append", "tail"), ("scan", "bitmap")],
        &[("append", "tail"), ("scan", "linear")],
        &[("append", "walk"), ("scan", "bitmap")],
        &[("append", "walk"), ("scan", "linear")],
        &[("allocator", "bump")],
        &[("allocator", "lifo")],
        &[("allocator", "threaded")],
        &[("allocator", "bitmap"), ("sections", "64"), ("outside_sections", "64")],
        &[("allocator", "hierarchical")],
        &[("allocator", "cached")],
        &[("ssa", "cached"), ("ssa_sets", "2"), ("ssa_line", "4")],
        &[("ssa", "cached"), ("ssa_sets", "1"), ("append", "walk"), ("scan", "linear")],
        &[("framebuffer", "cached"), ("framebuffer_sets", "2"), ("framebuffer_line", "4")],
        &[
            ("framebuffer", "cached"),
            ("framebuffer_sets", "1"),
            ("ssa", "cached"),
            ("ssa_sets", "2"),
            ("sections", "4096"),
            ("outside_sections", "0"),
        ],
    ],
    tight: &[
        ("sections", "40"),
        ("outside_sections", "400"),
        ("section_capacity", "2"),
        ("sorter_depth", "2"),
        ("outside_latency", "9"),
        ("reads_in_flight", "5"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<TBuffer<Chosen>> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    // Few sections on chip and enough outside, or all on chip.
    let (sections, outside) = match draw(0..=3) {
        0 => (needs.fragments, 0),
        _ => (draw(1..=30), needs.fragments),
    };
    let kinds = AllocatorKind::ALL.iter().copied();
    let kinds: Vec<_> = kinds.filter(|kind| kind.check("", needs.fragments).is_ok()).collect();
    let depth = if draw(0..=1) == 0 { draw(1..=9) } else { 64 };
    vec![
        ("append", one_of(draw, &["tail", "walk"]).to_string()),
        ("scan", one_of(draw, &["bitmap", "linear"]).to_string()),
        ("allocator", one_of(draw, &kinds).value().to_string()),
        ("section_capacity", draw(1..=5).to_string()),
        ("sorter_depth", depth.to_string()),
        ("sections", sections.to_string()),
        ("outside_sections", outside.to_string()),
        ("outside_latency", draw(1..=20).to_string()),
        ("reads_in_flight", draw(2..=9).to_string()),
        ("ssa", one_of(draw, &["on_chip", "cached"]).to_string()),
        ("ssa_sets", one_of(draw, &[1, 2, 8]).to_string()),
        ("ssa_ways", one_of(draw, &[1, 2, 4]).to_string()),
        ("ssa_line", one_of(draw, &[1, 2, 4, 16]).to_string()),
        ("framebuffer", one_of(draw, &["on_chip", "cached"]).to_string()),
        ("framebuffer_sets", one_of(draw, &[1, 2, 8]).to_string()),
        ("framebuffer_ways", one_of(draw, &[1, 2, 4]).to_string()),
        ("framebuffer_line", one_of(draw, &[1, 2, 4, 16]).to_string()),
    ]
}
