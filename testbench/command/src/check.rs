//! `pellucid run --check`: what a scene holds and what of it is used, without a run.

use super::{SceneArgs, say};
use comfy_table::{Table, presets};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::{align_right, at_margin, grouped};
use pellucid_testbench::scene::PartContents;
use pellucid_testbench::source::{Source, SourceError};
use serde_json::{Value, json};

/// How many fragments a frame has.
#[derive(Default)]
struct Fragments {
    all: u64,
    transparent: u64,
}

/// Reads all of a scene and prints what it holds.
pub(super) fn check(scene: &SceneArgs, as_json: bool, quiet: bool) -> anyhow::Result<bool> {
    let source = scene.open()?;
    let mut fragments = Fragments::default();
    let mut progress = Progress::new("reading", None, quiet);
    source.play_fragments::<SourceError>(&mut |fragment| {
        progress.step();
        fragments.all += 1;
        fragments.transparent += u64::from(!fragment.is_opaque());
        Ok(())
    })?;
    drop(progress);
    if as_json {
        say(&format!("{:#}\n", json(&scene.scene, &source, &fragments)))?;
    } else if !quiet {
        say(&text(&scene.scene, &source, &fragments))?;
    }
    Ok(true)
}

fn text(scene: &str, source: &Source, fragments: &Fragments) -> String {
    let screen = source.screen();
    let number = |n: u64| grouped(&json!(n));
    let mut text = format!(
        "{scene}: {} x {} pixels, {} fragments, {} of them transparent.\n",
        screen.width,
        screen.height,
        number(fragments.all),
        number(fragments.transparent)
    );
    let Some(contents) = source.contents() else { return text };
    text += &format!("Seen from {} (eye, point looked at, field of view).\n\n", contents.camera);
    let mut table = Table::new();
    table.load_style(presets::NOTHING);
    table.add_row([
        "PARTS",
        "vertices",
        "triangles",
        "splats",
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
        table.add_row([format!("  {name}")].into_iter().chain(counts).chain([opacity, from, to]));
    }
    if contents.parts.len() > 1 {
        let sum = |of: fn(&PartContents) -> usize| {
            number(contents.parts.iter().map(of).sum::<usize>() as u64)
        };
        let counts =
            [sum(|part| part.vertices), sum(|part| part.triangles), sum(|part| part.splats)];
        let [from, to] = bounds(contents.bounds());
        table.add_row(["ALL".to_string()].into_iter().chain(counts).chain([
            String::new(),
            from,
            to,
        ]));
    }
    align_right(&mut table, &[1, 2, 3]);
    text + &at_margin(&table.to_string())
}

fn json(scene: &str, source: &Source, fragments: &Fragments) -> Value {
    let screen = source.screen();
    let ends =
        |bounds: Option<[[f32; 3]; 2]>| bounds.map(|[from, to]| json!({ "from": from, "to": to }));
    let mut json = json!({
        "scene": scene,
        "frame": {
            "width": screen.width,
            "height": screen.height,
            "fragments": fragments.all,
            "transparent": fragments.transparent,
        },
        "notes": source.notes(),
    });
    if let Some(contents) = source.contents() {
        let part = |part: &PartContents| {
            let PartContents { names, vertices, triangles, splats, opacity: [least, most], bounds } =
                part;
            json!({
                "names": names, "vertices": vertices, "triangles": triangles, "splats": splats,
                "opacity": { "least": least, "most": most }, "bounds": ends(*bounds),
            })
        };
        json["camera"] = json!(contents.camera.to_string());
        json["bounds"] = json!(ends(contents.bounds()));
        json["parts"] = contents.parts.iter().map(part).collect();
    }
    json
}
