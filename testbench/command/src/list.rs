//! `pellucid list`: what there is.

use super::say;
use clap::Args;
use pellucid_hw::{ARCHITECTURES, architecture};
use pellucid_machine::Architecture;
use pellucid_machine::params::Param;
use pellucid_testbench::outside::board;
use pellucid_testbench::scene::{BuiltIn, built_in};
use serde_json::{Value, json};

#[derive(Args)]
pub(super) struct ListArgs {
    /// Only this architecture [default: all of them, and the scenes]
    #[arg(value_name = "ARCHITECTURE")]
    only: Option<String>,
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// Prints the architectures and the scenes.
pub(super) fn list(args: &ListArgs) -> anyhow::Result<bool> {
    let (architectures, scenes) = match &args.only {
        Some(name) => (vec![architecture(name)?], &[][..]),
        None => (ARCHITECTURES.to_vec(), built_in()),
    };
    say(&match args.json {
        true => format!("{:#}\n", as_json(&architectures, scenes)),
        false => as_text(&architectures, scenes),
    })?;
    Ok(true)
}

fn as_text(architectures: &[&Architecture], scenes: &[BuiltIn]) -> String {
    let mut text = String::from("ARCHITECTURES (--arch)\n");
    for arch in architectures {
        text += &format!("\n  {}  {}\n", arch.name, arch.about);
        text += "\n    presets (--preset), the first is the default\n";
        for (name, about) in (arch.presets)() {
            text += &format!("      {name:18} {about}\n");
        }
        text += "\n    parameters (-p NAME=VALUE)\n";
        text += &listed(&(arch.parameters)());
    }
    text += "\nMEMORY OUTSIDE OF THE CHIP (-p NAME=VALUE, where the machine has a port to it)\n\n";
    text += &listed(&board::settings());
    if scenes.is_empty() {
        return text;
    }
    text += "\nSCENES (--scene)\n\n";
    for scene in scenes {
        text += &format!("  {:14} {}\n", scene.name, scene.about);
    }
    text +=
        "  FILE           a mesh (.obj, .ply, .ply.gz, .gltf, .glb) or a trace (.csv, .ptrace)\n";
    text
}

/// Parameters, one below the other.
fn listed(parameters: &[Param]) -> String {
    let width = parameters.iter().map(|p| p.name.len()).max().unwrap_or(0);
    let of = |p: &Param| {
        let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
        let Param { name, about, default, range, .. } = p;
        format!(
            "      {name:width$} {about}\n      {:width$} default {default}{unit}; {range}\n",
            ""
        )
    };
    parameters.iter().map(of).collect()
}

fn parameters_json(parameters: &[Param]) -> Vec<Value> {
    let of = |p: &Param| {
        json!({
            "name": p.name, "default": p.default, "unit": p.unit, "range": p.range, "about": p.about,
        })
    };
    parameters.iter().map(of).collect()
}

fn as_json(architectures: &[&Architecture], scenes: &[BuiltIn]) -> Value {
    let architectures: Vec<Value> = architectures
        .iter()
        .map(|arch| {
            let presets: Vec<Value> = (arch.presets)()
                .iter()
                .map(|(name, about)| json!({ "name": name, "about": about }))
                .collect();
            let parameters = parameters_json(&(arch.parameters)());
            json!({
                "name": arch.name, "about": arch.about,
                "presets": presets, "parameters": parameters,
            })
        })
        .collect();
    let scenes: Vec<Value> =
        scenes.iter().map(|s| json!({ "name": s.name, "about": s.about })).collect();
    let outside = parameters_json(&board::settings());
    json!({ "architectures": architectures, "outside": outside, "scenes": scenes })
}
