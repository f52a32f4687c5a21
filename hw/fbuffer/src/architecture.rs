//! What the architecture says of itself.

use crate::FBuffer;
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
    name: "fbuffer",
    about: "F-buffer: shading in several passes through a FIFO in rasterisation order",
    presets: || about(PRESETS),
    parameters: Params::list,
    model,
    small,
    ways: &[
        &[("program", "glass")],
        &[("program", "random"), ("targets", "3"), ("component_bits", "16"), ("overflow", "batch")],
        &[("program", "tint")],
        &[("program", "glass"), ("early_depth", "before_window"), ("component_bits", "8")],
        &[("program", "glass"), ("store", "framebuffer"), ("component_bits", "16")],
        &[("program", "tint"), ("mode", "sort")],
        &[("program", "sieve"), ("component_bits", "8")],
        &[("program", "sieve"), ("kill", "compact"), ("component_bits", "16")],
        &[("program", "glass"), ("buffer", "outside"), ("component_bits", "8")],
        &[("program", "sieve"), ("kill", "compact"), ("buffer", "outside")],
        &[
            ("program", "tint"),
            ("framebuffer", "cached"),
            ("framebuffer_sets", "2"),
            ("framebuffer_line", "4"),
        ],
        &[
            ("buffer", "outside"),
            ("framebuffer", "cached"),
            ("framebuffer_sets", "1"),
            ("component_bits", "16"),
        ],
    ],
    tight: &[
        ("size", "32"),
        ("outside_latency", "9"),
        ("vertex_cycles", "2"),
        ("fragment_cycles", "3"),
    ],
};

fn model(screen: Screen, preset: &str, settings: &[Setting]) -> Built {
    let params = chosen(PRESETS, preset, settings)?;
    let cfg = Config::new(screen, params)?;
    Ok(Box::new(Configured::<FBuffer> { cfg, values: params.values() }))
}

fn small(draw: &mut Draw, _: Needs) -> Parameterised {
    // Any size will do: a frame has as many windows or batches as it needs. A sort has as many rounds over them.
    let sorts = draw(0..=3) == 0;
    let store =
        if sorts { "fbuffer" } else { one_of(draw, &["fbuffer", "fbuffer", "framebuffer"]) };
    let kill = if store == "fbuffer" { one_of(draw, &["keep", "compact"]) } else { "keep" };
    let inside = sorts || store == "framebuffer";
    let buffer = if inside { "on_chip" } else { one_of(draw, &["on_chip", "outside"]) };
    let early_depth = one_of(draw, &["off", "before_window"]);
    let on_chip = inside || early_depth == "before_window";
    let framebuffer = if on_chip { "on_chip" } else { one_of(draw, &["on_chip", "cached"]) };
    let overflow = if sorts { "window" } else { one_of(draw, &["window", "batch"]) };
    vec![
        ("size", (1 << draw(if sorts { 4..=5 } else { 2..=5 })).to_string()),
        ("targets", draw(1..=4).to_string()),
        ("component_bits", one_of(draw, &["8", "16", "32"]).to_string()),
        (
            "program",
            one_of(draw, &["tint", "restore", "glass", "sieve", "random", "random"]).to_string(),
        ),
        ("seed", draw(0..=1000).to_string()),
        ("store", store.to_string()),
        ("buffer", buffer.to_string()),
        ("outside_latency", draw(1..=30).to_string()),
        ("reads_in_flight", draw(2..=20).to_string()),
        ("kill", kill.to_string()),
        ("early_depth", early_depth.to_string()),
        ("overflow", overflow.to_string()),
        ("mode", if sorts { "sort" } else { "shade" }.to_string()),
        ("sorter_lanes", (1 << draw(0..=4)).to_string()),
        ("vertex_cycles", draw(1..=3).to_string()),
        ("fragment_cycles", draw(1..=5).to_string()),
        ("framebuffer", framebuffer.to_string()),
        ("framebuffer_sets", one_of(draw, &[1, 2, 8]).to_string()),
        ("framebuffer_ways", one_of(draw, &[1, 2, 4]).to_string()),
        ("framebuffer_line", one_of(draw, &[1, 2, 4, 16]).to_string()),
    ]
}
