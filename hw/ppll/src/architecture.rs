//! What the architecture says of itself.

use crate::Ppll;
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
    name: "ppll",
    about: "Per-pixel linked lists of pages: a frame that does not fit is played again with more of them",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("page", "4"), ("growth", "double")],
        &[("page", "1"), ("growth", "needed")],
        &[
            ("page", "3"),
            ("scan", "linear"),
            ("pages", "12"),
            ("ssa", "cached"),
            ("ssa_sets", "2"),
            ("ssa_line", "4"),
        ],
        &[("page", "4"), ("overflow", "drop"), ("pages", "400"), ("fragments", "1")],
        &[
            ("page", "2"),
            ("pages", "100"),
            ("framebuffer", "cached"),
            ("framebuffer_sets", "2"),
            ("framebuffer_line", "4"),
        ],
    ],
    tight: &[
        ("page", "2"),
        ("pages", "20"),
        ("most_pages", "500"),
        ("fragments", "90"),
        ("sorter_depth", "2"),
        ("outside_latency", "9"),
        ("reads_in_flight", "5"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<Ppll> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    // Pages for all fragments from the start, or few that grow.
    let (pages, overflow) = match draw(0..=2) {
        0 => (needs.fragments, one_of(draw, &["rebuild", "drop"])),
        1 => (draw(1..=9), "rebuild"),
        _ => (draw(1..=needs.fragments), "rebuild"),
    };
    let depth = if draw(0..=1) == 0 { draw(1..=9) } else { 64 };
    vec![
        ("page", draw(1..=5).to_string()),
        ("pages", pages.to_string()),
        ("most_pages", needs.fragments.to_string()),
        ("growth", one_of(draw, &["double", "needed"]).to_string()),
        ("overflow", overflow.to_string()),
        ("fragments", draw(1..=2 * needs.fragments).to_string()),
        ("scan", one_of(draw, &["bitmap", "linear"]).to_string()),
        ("sorter_depth", depth.to_string()),
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
