//! The results of a study as one page.

use super::points::Points;
use super::results::parameters;
use super::standing::{Standing, objectives};
use super::study::Study;
use super::work::Candidate;
use pellucid_hw::ARCHITECTURES;
use pellucid_testbench::html::{self, escaped, png_data};
use pellucid_testbench::plots;
use serde_json::{Value as Json, json};
use std::collections::{HashMap, HashSet};

/// What makes the page move.
const SCRIPT: &str = include_str!("page.js");
/// How its parts look.
const STYLE: &str = include_str!("page.css");

/// How much of a page images may take, in bytes.
const MOST_IMAGES: usize = 16 << 20;

/// What stands before a browser has drawn anything.
const BODY: &str = r#"<h2>Front</h2>
<p>Each point is a design; those on the front are ringed and joined: nothing else is as good in both figures. Point at one to see
its parameters, click to pin it.</p>
<p><label>across <select id="across"></select></label> <label>up <select id="up"></select></label>
<label><input type="checkbox" id="logarithmic"/> logarithmic</label> <label><input type="checkbox" id="out"/> with designs that are out</label></p>
<div id="legend"></div>
<div id="scatter"></div>
<div id="tip"></div>
<h2>Pinned</h2>
<div id="pinned"><p>None yet.</p></div>
<h2>Parameters</h2>
<p>A line for each design, through its parameters and objectives. Draw along an axis to see only what passes there; click the
axis to see all again.</p>
<div class="wide" id="parallel"></div>
<h2>Effects</h2>
<p>The mean of what goes up, for each value of each parameter that changes, over the designs that hold all constraints.</p>
<div id="effects"></div>
<h2>Designs</h2>
<p><label>Show <input id="filter" placeholder="a part of a name"/></label> <span id="count"></span></p>
<div class="wide"><table id="designs"></table></div>
"#;

/// The page.
pub fn page(
    command: &str,
    study: &Study,
    points: &Points,
    candidates: &[Candidate],
    standings: &[(Standing, bool)],
) -> String {
    let data = data(study, points, candidates, standings).to_string();
    // Nothing in it can end the script, in HTML or in XML.
    let data = data.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026");
    let scenes = study
        .scenes
        .iter()
        .map(|scene| format!("<li><code>{}</code></li>\n", escaped(&scene.arguments())));
    let constraints = study
        .constraints
        .iter()
        .map(|constraint| format!("<li>{}</li>\n", escaped(&constraint.to_string())));
    let objectives = study.objectives.iter().map(|objective| {
        let goal = if objective.most { "as large" } else { "as small" };
        format!("<li>{}: {goal} as it can be</li>\n", escaped(&objective.name()))
    });
    let list = |what: &str, lines: String| match lines.is_empty() {
        true => String::new(),
        false => format!("<p>{what}</p>\n<ul>\n{lines}</ul>\n"),
    };
    let text = [
        format!("<style>{STYLE}</style>\n"),
        list("Scenes:", scenes.collect()),
        list("What must hold:", constraints.collect()),
        list("What counts:", objectives.collect()),
        BODY.to_string(),
        format!("<script>\n//<![CDATA[\nconst DATA = {data};\n{SCRIPT}//]]>\n</script>\n"),
    ];
    let about = "A study: designs on scenes, each point a clocked run whose image was held to a golden model.";
    html::page("Exploration", about, command, &text.concat())
}

/// What the script shows.
fn data(
    study: &Study,
    points: &Points,
    candidates: &[Candidate],
    standings: &[(Standing, bool)],
) -> Json {
    let mut names: Vec<&String> = study.objectives.iter().map(|o| &o.figure).collect();
    let mut seen: HashSet<&String> = names.iter().copied().collect();
    let outcomes = candidates.iter().flat_map(|candidate| candidate.outcomes.iter().flatten());
    let all = outcomes.flat_map(|outcome| outcome.figures.iter().map(|(name, _)| name));
    names.extend(all.filter(|name| seen.insert(name)));
    let figures = names.iter().map(|name| {
        let [unit, about] = points.about(name);
        json!({ "name": name, "unit": unit, "about": about })
    });
    let designs = candidates.iter().zip(standings).map(|(candidate, (standing, front))| {
        let each = candidate.outcomes.iter().map(|outcome| {
            let outcome = outcome.as_ref().filter(|outcome| !outcome.figures.is_empty())?;
            let known: HashMap<&String, f64> =
                outcome.figures.iter().map(|(name, value)| (name, *value)).collect();
            Some(names.iter().map(|name| known.get(name).copied()).collect::<Vec<_>>())
        });
        let out = match standing {
            Standing::Open => json!("not run yet"),
            Standing::Out { why, .. } => json!(why),
            Standing::In(_) => Json::Null,
        };
        let parameters = parameters(candidate).into_iter().collect::<serde_json::Map<_, _>>();
        json!({
            "name": candidate.design.choice.name,
            "arch": candidate.design.choice.arch.name,
            "parameters": parameters,
            "front": front,
            "out": out,
            "objectives": objectives(study, candidate).ok(),
            "commands": candidate.commands,
            "files": candidate.files.iter().map(|file| file.as_ref().map(|file| file.display().to_string())).collect::<Vec<_>>(),
            "figures": each.collect::<Vec<_>>(),
            "images": candidate.outcomes.iter().map(|outcome| outcome.as_ref()?.image.clone()).collect::<Vec<_>>(),
        })
    });
    let objectives = study.objectives.iter().map(|objective| {
        json!({ "name": objective.name(), "figure": objective.figure, "most": objective.most })
    });
    let colours = (0..ARCHITECTURES.len()).map(plots::hex);
    json!({
        "colours": colours.collect::<Vec<_>>(),
        "scenes": study.scenes.iter().map(|scene| scene.arguments()).collect::<Vec<_>>(),
        "objectives": objectives.collect::<Vec<_>>(),
        "figures": figures.collect::<Vec<_>>(),
        "designs": designs.collect::<Vec<_>>(),
        "images": images(points, candidates, standings),
    })
}

/// The images of designs, each once, as many as there is room for: of those on the front first, then of others that are in.
fn images(
    points: &Points,
    candidates: &[Candidate],
    standings: &[(Standing, bool)],
) -> HashMap<String, String> {
    let mut all: Vec<_> = candidates.iter().zip(standings).collect();
    all.sort_by_key(|(_, (standing, front))| (!front, standing.values().is_none()));
    let all = all.into_iter().flat_map(|(candidate, _)| candidate.outcomes.iter().flatten());
    let (mut images, mut room) = (HashMap::new(), MOST_IMAGES);
    for name in all.filter_map(|outcome| outcome.image.as_ref()) {
        if images.contains_key(name) {
            continue;
        }
        let Some(data) = points.image(name).map(|png| png_data(&png)) else { continue };
        let Some(rest) = room.checked_sub(data.len()) else { break };
        room = rest;
        images.insert(name.clone(), data);
    }
    images
}
