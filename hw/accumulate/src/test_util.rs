//! What the tests of this architecture share.

use crate::config::{Config, Params};
use crate::{level, sums, tree};
use pellucid_machine::params::Parameters;
pub use pellucid_test_util::*;

/// A machine for few pixels with these settings, or why there is none.
pub fn config(settings: &[(&str, &str)]) -> Result<Config, String> {
    let mut params = Params::default();
    for (name, value) in settings {
        params.set(name, value).map_err(|error| error.to_string())?;
    }
    Config::new(screen(3, 2), params).map_err(|error| error.to_string())
}

/// The same, with memories that are smaller than random numbers.
pub fn small(settings: &[(&str, &str)]) -> Config {
    const TBUFFER: [(&str, &str); 3] = [
        ("tbuffer.sections", "6"),
        ("tbuffer.outside_sections", "9"),
        ("tbuffer.section_capacity", "2"),
    ];
    config(&[&TBUFFER, settings].concat()).unwrap()
}

/// The same with planes outside.
pub fn outside(settings: &[(&str, &str)]) -> Config {
    small(&[&[("planes", "outside"), ("reads_in_flight", "5")], settings].concat())
}

/// A tree whose levels have so many inputs, with weights of so many bits: none if it is plain.
pub fn tree(inputs: &[u32], nodes: bool, weight_bits: u32) -> tree::Config {
    let frames = inputs.iter().product::<u32>().to_string();
    let branching: Vec<String> = inputs.iter().map(u32::to_string).collect();
    let branching = if inputs.is_empty() { "2".to_string() } else { branching.join(",") };
    let weight_bits = weight_bits.to_string();
    let mut settings = vec![("frames", &*frames), ("branching", &branching), ("plane_bits", "9")];
    if nodes {
        settings.push(("schedule", "nodes"));
    }
    if weight_bits != "0" {
        settings.extend([("weights", "triangle"), ("weight_bits", &weight_bits)]);
    }
    small(&settings).tree
}

/// A level whose nodes have so many inputs, the same way.
pub fn level(inputs: u32, weight_bits: u32) -> level::Config {
    *tree(&[inputs, 2], false, weight_bits).level(0)
}

/// Sums of so many frames.
pub fn sums(frames: u32, blends: bool) -> sums::Config {
    let frames = frames.to_string();
    let method = if blends { "blend" } else { "buffer" };
    small(&[("frames", &frames), ("method", method)]).sums
}
