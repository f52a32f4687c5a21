//! What the architecture says of itself.

use crate::RBuffer;
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
    name: "rbuffer",
    about: "R-buffer: fragments in a queue, sent round until all are blended",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[],
        &[("overflow", "replay")],
        &[("framebuffer", "cached"), ("framebuffer_sets", "2"), ("framebuffer_line", "4")],
        &[("framebuffer", "cached"), ("framebuffer_sets", "1"), ("overflow", "replay")],
    ],
    tight: &[("queue", "80"), ("outside_queue", "400"), ("outside_latency", "9")],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<RBuffer> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, needs: Needs) -> Parameterised {
    // With replay the fragments of a pixel have to fit into the queue.
    let queue = draw(2..=30);
    let (queue, outside, overflow) = match draw(0..=6) {
        0 => (needs.fragments, 0, "outside"),
        1..=3 => (queue, needs.fragments, "outside"),
        _ => (queue.max(needs.layers), 0, "replay"),
    };
    vec![
        ("queue", queue.to_string()),
        ("outside_queue", outside.to_string()),
        ("overflow", overflow.to_string()),
        ("outside_latency", draw(1..=20).to_string()),
        ("reads_in_flight", draw(2..=20).to_string()),
        ("framebuffer", one_of(draw, &["on_chip", "cached"]).to_string()),
        ("framebuffer_sets", one_of(draw, &[1, 2, 8]).to_string()),
        ("framebuffer_ways", one_of(draw, &[1, 2, 4]).to_string()),
        ("framebuffer_line", one_of(draw, &[1, 2, 4, 16]).to_string()),
    ]
}
