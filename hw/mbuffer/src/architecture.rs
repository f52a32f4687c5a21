//! What the architecture says of itself.

use crate::MBuffer;
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
    name: "mbuffer",
    about: "M-buffer: a section for each pixel, fragments summed by weight without sorting",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("weights", "registers")],
        &[("weights", "memory")],
        &[("weights", "memory"), ("allocator", "threaded")],
        &[("framebuffer", "cached"), ("framebuffer_sets", "2"), ("framebuffer_line", "4")],
        &[("framebuffer", "cached"), ("framebuffer_sets", "1"), ("weights", "memory")],
    ],
    tight: &[
        ("overflow_sections", "20"),
        ("outside_sections", "60"),
        ("outside_latency", "9"),
        ("reads_in_flight", "5"),
        ("section_capacity", "2"),
        ("array", "3"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<MBuffer<Chosen>> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    // Few sections on chip and enough outside, or all on chip.
    let (sections, outside) = match draw(0..=3) {
        0 => (needs.fragments, 0),
        _ => (draw(0..=30), needs.fragments),
    };
    let kinds = AllocatorKind::ALL.iter().copied();
    let kinds: Vec<_> = kinds.filter(|kind| kind.check("", needs.fragments).is_ok()).collect();
    let array = if draw(0..=1) == 0 { draw(1..=9) } else { 32 };
    vec![
        ("weights", one_of(draw, &["registers", "memory"]).to_string()),
        ("scan", one_of(draw, &["bitmap", "linear"]).to_string()),
        ("allocator", one_of(draw, &kinds).value().to_string()),
        ("section_capacity", draw(1..=5).to_string()),
        ("array", array.to_string()),
        ("overflow_sections", sections.to_string()),
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
