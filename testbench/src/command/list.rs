//! `pellucid list`: what there is.

use super::say;
use crate::arch::ARCHITECTURES;
use crate::scene::built_in;
use clap::Args;
use serde_json::{Value, json};

#[derive(Args)]
pub(super) struct ListArgs {
    /// Print as JSON
    #[arg(long)]
    json: bool,
}

/// Prints the architectures and the scenes.
pub(super) fn list(args: &ListArgs) -> anyhow::Result<bool> {
    say(&if args.json { format!("{:#}\n", as_json()) } else { as_text() })?;
    Ok(true)
}

fn as_text() -> String {
    let mut text = String::from("ARCHITECTURES (--arch)\n");
    for arch in ARCHITECTURES {
        text += &format!("\n  {}  {}\n", arch.name, arch.about);
        text += "\n    presets (--preset), the first is the default\n";
        for (name, about) in (arch.presets)() {
            text += &format!("      {name:18} {about}\n");
        }
        text += "\n    parameters (-p NAME=VALUE)\n";
        let parameters = (arch.parameters)();
        let width = parameters.iter().map(|p| p.name.len()).max().unwrap_or(0);
        for p in parameters {
            let unit = if p.unit.is_empty() { String::new() } else { format!(" {}", p.unit) };
            text += &format!("      {:width$} {}\n", p.name, p.about);
            text += &format!("      {:width$} default {}{unit}; {}\n", "", p.default, p.range);
        }
    }
    text += "\nSCENES (--scene)\n\n";
    for scene in built_in() {
        text += &format!("  {:14} {}\n", scene.name, scene.about);
    }
    text +=
        "  FILE           a mesh (.obj, .ply, .ply.gz, .gltf, .glb) or a trace (.csv, .ptrace)\n";
    text
}

fn as_json() -> Value {
    let architectures: Vec<Value> = ARCHITECTURES
        .iter()
        .map(|arch| {
            let presets: Vec<Value> = (arch.presets)()
                .iter()
                .map(|(name, about)| json!({ "name": name, "about": about }))
                .collect();
            let parameters: Vec<Value> = (arch.parameters)()
                .iter()
                .map(|p| {
                    json!({
                        "name": p.name, "default": p.default, "unit": p.unit,
                        "range": p.range, "about": p.about,
                    })
                })
                .collect();
            json!({
                "name": arch.name, "about": arch.about,
                "presets": presets, "parameters": parameters,
            })
        })
        .collect();
    let scenes: Vec<Value> =
        built_in().iter().map(|s| json!({ "name": s.name, "about": s.about })).collect();
    json!({ "architectures": architectures, "scenes": scenes })
}
