//! `pellucid run --check`: what a scene holds and what of it is used, without a run.

use super::say;
use comfy_table::{Table, presets};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::{align_right, at_margin, grouped};
use pellucid_testbench::scene::{Extension, PartContents, TextureContents};
use pellucid_testbench::source::{Source, SourceError};
use serde_json::{Value, json};

/// How many fragments there are.
#[derive(Default)]
struct Fragments {
    all: u64,
    transparent: u64,
}

/// Reads all of a scene and prints what it holds.
pub(super) fn check(
    scene: &str,
    source: &Source,
    frames: u32,
    as_json: bool,
    quiet: bool,
) -> anyhow::Result<bool> {
    let mut fragments = Fragments::default();
    let mut progress = Progress::new("reading", None, quiet);
    source.each_frame(frames, &mut |_, source| {
        source.play_fragments::<SourceError>(&mut |fragment| {
            progress.step();
            fragments.all += 1;
            fragments.transparent += u64::from(!fragment.is_opaque());
            Ok(())
        })
    })?;
    drop(progress);
    if as_json {
        say(&format!("{:#}\n", json(scene, source, frames, &fragments)))?;
    } else if !quiet {
        say(&text(scene, source, frames, &fragments))?;
    }
    Ok(true)
}

fn text(scene: &str, source: &Source, frames: u32, fragments: &Fragments) -> String {
    let screen = source.screen();
    let number = |n: u64| grouped(&json!(n));
    let of_frames = if frames > 1 { format!("{frames} frames of ") } else { String::new() };
    let mut text = format!(
        "{scene}: {of_frames}{} x {} pixels, {} fragments, {} of them transparent.\n",
        screen.width,
        screen.height,
        number(fragments.all),
        number(fragments.transparent)
    );
    let Some(contents) = source.contents() else { return text };
    text += &format!("Seen from {} (eye, point looked at, field of view).\n", contents.camera);
    if !contents.extensions.is_empty() {
        let each =
            |extension: &Extension| format!("{} ({})", extension.name, extension.handling.as_str());
        let all: Vec<String> = contents.extensions.iter().map(each).collect();
        text += &format!("Extensions: {}.\n", all.join(", "));
    }
    text.push('\n');
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_row([
        "PARTS",
        "vertices",
        "triangles",
        "splats",
        "material",
        "alpha mode",
        "textures",
        "opacity",
        "from x,y,z",
        "to x,y,z",
    ]);
    let bounds = |bounds: Option<[[f32; 3]; 2]>| {
        bounds.map_or([String::new(), String::new()], |ends| {
            ends.map(|[x, y, z]| format!("{x},{y},{z}"))
        })
    };
    for part in &contents.parts {
        let PartContents { names, vertices, triangles, splats, opacity: [least, most], .. } = part;
        let opacity = if least == most { least.to_string() } else { format!("{least} to {most}") };
        let [from, to] = bounds(part.bounds);
        let counts = [vertices, triangles, splats].map(|n| number(*n as u64));
        let name = if names.is_empty() { "without a name".to_string() } else { names.join(", ") };
        let textures: Vec<String> = part.textures.iter().map(TextureContents::to_string).collect();
        let look = [
            part.material.clone().unwrap_or_default(),
            part.alpha_mode.map(|mode| mode.to_string()).unwrap_or_default(),
            textures.join(", "),
            opacity,
        ];
        let cells = [format!("  {name}")].into_iter().chain(counts).chain(look);
        table.add_row(cells.chain([from, to]));
    }
    if contents.parts.len() > 1 {
        let sum = |of: fn(&PartContents) -> usize| {
            number(contents.parts.iter().map(of).sum::<usize>() as u64)
        };
        let counts =
            [sum(|part| part.vertices), sum(|part| part.triangles), sum(|part| part.splats)];
        let [from, to] = bounds(contents.bounds());
        let look = [const { String::new() }; 4];
        let cells = ["ALL".to_string()].into_iter().chain(counts).chain(look);
        table.add_row(cells.chain([from, to]));
    }
    align_right(&mut table, &[1, 2, 3]);
    text + &at_margin(&table.to_string())
}

fn json(scene: &str, source: &Source, frames: u32, fragments: &Fragments) -> Value {
    let screen = source.screen();
    let ends =
        |bounds: Option<[[f32; 3]; 2]>| bounds.map(|[from, to]| json!({ "from": from, "to": to }));
    let mut json = json!({
        "scene": scene,
        "frame": {
            "width": screen.width,
            "height": screen.height,
            "frames": frames,
            "fragments": fragments.all,
            "transparent": fragments.transparent,
        },
        "notes": source.notes(),
    });
    if let Some(contents) = source.contents() {
        let part = |part: &PartContents| {
            let PartContents { names, material, vertices, triangles, splats, .. } = part;
            let [least, most] = part.opacity;
            let texture = |texture: &TextureContents| {
                let TextureContents { gives, size: [width, height] } = texture;
                json!({ "gives": gives, "width": width, "height": height })
            };
            let textures: Vec<Value> = part.textures.iter().map(texture).collect();
            json!({
                "names": names, "material": material,
                "alpha_mode": part.alpha_mode.map(|mode| mode.to_string()), "textures": textures,
                "vertices": vertices, "triangles": triangles, "splats": splats,
                "opacity": { "least": least, "most": most }, "bounds": ends(part.bounds),
            })
        };
        json["camera"] = json!(contents.camera.to_string());
        json["bounds"] = json!(ends(contents.bounds()));
        let extension = |extension: &Extension| json!({ "name": extension.name, "handling": extension.handling.as_str() });
        json["extensions"] = contents.extensions.iter().map(extension).collect();
        json["parts"] = contents.parts.iter().map(part).collect();
    }
    json
}
