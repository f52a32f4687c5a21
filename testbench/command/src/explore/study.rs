//! A study: scenes, machines with what their parameters may be, what must hold, what counts, and how to search.

use super::criteria::{Constraint, Objective};
use super::reading::{File, Section, StudyError, expected};
use super::space::{Axis, Values, axes};
use crate::sequence::{Opened, SequenceArgs, frames};
use crate::technology::TechnologyArgs;
use crate::{ViewArgs, instances, quoted, side};
use pellucid_hw::architecture;
use pellucid_machine::Architecture;
use pellucid_testbench::costs::Technology;
use std::path::Path;
use std::str::FromStr;
use std::sync::Arc;
use toml::de::DeValue;

/// See the module's description.
pub struct Study {
    /// The scenes.
    pub scenes: Vec<Scene>,
    /// The machines.
    pub families: Vec<Family>,
    /// What must hold.
    pub constraints: Vec<Constraint>,
    /// What counts.
    pub objectives: Vec<Objective>,
    /// How designs are found.
    pub search: Search,
    /// Of memories on the chip.
    pub technology: Arc<Technology>,
    technology_args: TechnologyArgs,
}

/// A scene, as `run` takes it.
pub struct Scene {
    /// Its name or file.
    pub name: String,
    /// File and line.
    pub place: String,
    view: ViewArgs,
    sequence: SequenceArgs,
}

/// Machines of one architecture.
pub struct Family {
    /// The architecture.
    pub arch: &'static Architecture,
    /// File and line.
    pub place: String,
    /// Its presets, and then its parameters.
    pub axes: Vec<Axis>,
}

/// How designs are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Every combination.
    Grid,
    /// Independent draws.
    Random,
    /// The Halton sequence, which fills the space evenly: J. Halton, 1960.
    Halton,
    /// Bred from the best so far: see [`genetic`](super::genetic).
    Genetic,
}

/// See [`Study::search`].
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// How.
    pub method: Method,
    /// How many designs are looked at; a grid has as many as it has.
    pub designs: usize,
    /// Where chance begins.
    pub seed: u64,
}

/// The most designs of a study.
pub const MOST_DESIGNS: usize = 1_000_000;
/// The name of the axis that presets are.
pub const PRESET: &str = "preset";

impl Study {
    /// Reads it.
    ///
    /// # Errors
    /// It names the line.
    pub fn read(file: &File) -> Result<Study, StudyError> {
        let mut table = file.table()?;
        let scenes = table.tables("scene")?;
        let machines = table.tables("machine")?;
        let constraints = table.take("constraints");
        let objectives = table.take("objectives");
        let search = table.take("search");
        let technology = table.take("technology");
        let start = table.span.clone();
        table.end()?;
        for (what, is_empty) in [("scene", scenes.is_empty()), ("machine", machines.is_empty())] {
            if is_empty {
                let problem = format!("no {what} is given: expected at least one `[[{what}]]`");
                return Err(file.wrong(&start, problem));
            }
        }
        let scenes: Vec<Scene> = scenes.into_iter().map(Scene::read).collect::<Result<_, _>>()?;
        for (k, scene) in scenes.iter().enumerate() {
            if scenes[..k].iter().any(|other| other.arguments() == scene.arguments()) {
                let problem = "the scene is given twice".to_string();
                return Err(StudyError::Line { place: scene.place.clone(), problem });
            }
        }
        let families = machines.into_iter().map(Family::read).collect::<Result<_, _>>()?;
        let entries = |name, table: Option<_>| -> Result<_, StudyError> {
            Ok(table
                .map(|table| Section::of(file, name, table))
                .transpose()?
                .map_or(vec![], Section::rest))
        };
        let constraints = entries("constraints", constraints)?.into_iter();
        let constraints =
            constraints.map(|entry| Constraint::read(file, entry)).collect::<Result<_, _>>()?;
        let objectives = entries("objectives", objectives)?.into_iter();
        let objectives: Vec<Objective> =
            objectives.map(|entry| Objective::read(file, entry)).collect::<Result<_, _>>()?;
        let objectives = match objectives.is_empty() {
            true => ["cycles.total", "storage.on_chip_bytes"].map(Objective::least).into(),
            false => objectives,
        };
        let search = match search {
            Some(table) => Search::read(Section::of(file, "search", table)?)?,
            None => Search { method: Method::Grid, designs: MOST_DESIGNS, seed: 0 },
        };
        let technology = technology.map(|table| Section::of(file, "technology", table));
        let (technology_args, technology) = technology_of(technology.transpose()?)?;
        let technology = Arc::new(technology);
        Ok(Study { scenes, families, constraints, objectives, search, technology, technology_args })
    }

    /// What `run` is told of the scene and the technology, as a shell takes it.
    pub fn arguments(&self, scene: &Scene) -> String {
        let technology = self.technology_args.given();
        [vec![scene.arguments()], technology].concat().join(" ")
    }

    /// The files that a point on the scene depends on, but for those that its parameters name.
    pub fn files<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = &'a Path> {
        [Path::new(&scene.name)].into_iter().chain(self.technology_args.sram.as_deref())
    }
}

impl Scene {
    fn read(mut section: Section) -> Result<Scene, StudyError> {
        let file = section.file;
        let span = section.span.clone();
        let name = section.parse("scene", |text| Ok(text.to_string()))?;
        let view = ViewArgs {
            width: section.parse("width", side)?,
            height: section.parse("height", side)?,
            camera: section.parse("camera", parsed)?,
            alpha: alphas(&mut section)?,
            instances: section.parse("instances", instances)?,
            order: section.parse("order", parsed)?,
            opaque_first: section.parse("opaque_first", truth)?.unwrap_or(false),
            memory_limit: None,
        };
        let sequence = SequenceArgs {
            frames: section.parse("frames", frames)?,
            path: section.parse("path", parsed)?,
            vary: section.parse("vary", parsed)?,
        };
        section.end()?;
        let Some(name) = name else {
            return Err(
                file.wrong(&span, "a scene has a name or a file: `scene = \"glass\"`".into())
            );
        };
        Ok(Scene { name, place: file.place(&span), view, sequence })
    }

    /// Opens it.
    ///
    /// # Errors
    /// It is not there, or not one that can be played so.
    pub fn open(&self) -> anyhow::Result<Opened> {
        let opened = self.sequence.open(&self.name, &self.view, false);
        opened.map_err(|error| {
            let problem = error.to_string();
            StudyError::Line { place: self.place.clone(), problem }.into()
        })
    }

    /// What `run` is told of it, as a shell takes it.
    pub fn arguments(&self) -> String {
        let mut words = vec![format!("--scene {}", quoted(&self.name))];
        words.extend(self.view.given());
        words.extend(self.sequence.given());
        words.join(" ")
    }
}

impl Family {
    fn read(mut section: Section) -> Result<Family, StudyError> {
        let (file, span) = (section.file, section.span.clone());
        let arch = section.parse("arch", |text| architecture(text).map_err(|e| e.to_string()))?;
        let Some(arch) = arch else {
            let problem = "a machine has an architecture: `arch = \"tbuffer\"`".to_string();
            return Err(file.wrong(&span, problem));
        };
        let place = file.place(&span);
        let mut axes = axes(file, "", section.rest())?;
        let at = axes.iter().position(|axis| axis.name == PRESET);
        let preset = match at.map(|at| axes.remove(at)) {
            Some(axis) => axis,
            None => {
                let first = (arch.presets)().first().map_or("", |preset| preset.0).to_string();
                let values = Values::List(vec![first]);
                Axis { name: PRESET.to_string(), place: place.clone(), values }
            }
        };
        if !matches!(preset.values, Values::List(_)) {
            let problem = "`preset` is a name, or a list of names".to_string();
            return Err(StudyError::Line { place: preset.place, problem });
        }
        axes.insert(0, preset);
        Ok(Family { arch, place, axes })
    }
}

/// The technology that a section names, and as `run` is told of it.
fn technology_of(section: Option<Section>) -> Result<(TechnologyArgs, Technology), StudyError> {
    let mut args = TechnologyArgs { node: Technology::NODE, sram: None };
    let Some(mut section) = section else { return Ok((args, Technology::default())) };
    let place = section.file.place(&section.span);
    args.sram = section.parse("sram", |text| Ok(text.into()))?;
    args.node = section.parse("node", parsed)?.unwrap_or(args.node);
    section.end()?;
    let technology = args.read();
    let technology =
        technology.map_err(|error| StudyError::Line { place, problem: error.to_string() })?;
    Ok((args, technology))
}

impl Search {
    fn read(mut section: Section) -> Result<Search, StudyError> {
        let method = |text: &str| match text {
            "grid" => Ok(Method::Grid),
            "random" => Ok(Method::Random),
            "halton" => Ok(Method::Halton),
            "genetic" => Ok(Method::Genetic),
            _ => Err("expected `grid`, `random`, `halton` or `genetic`".to_string()),
        };
        let number = |text: &str| {
            let number = text.parse().ok().filter(|number| (1..=MOST_DESIGNS).contains(number));
            number.ok_or_else(|| format!("expected a whole number from 1 to {MOST_DESIGNS}"))
        };
        let any = |text: &str| {
            text.parse::<u64>().map_err(|_| "expected a whole number, 0 or more".to_string())
        };
        let method = section.parse("method", method)?.unwrap_or(Method::Grid);
        let designs = section.parse("designs", number)?;
        let seed = section.parse("seed", any)?;
        let (file, span) = (section.file, section.span.clone());
        section.end()?;
        let wrong = |problem: &str| Err(file.wrong(&span, problem.to_string()));
        match (method, designs) {
            (Method::Grid, Some(_)) => {
                wrong("a grid has as many designs as it has: `designs` is for the others")
            }
            (Method::Random | Method::Halton | Method::Genetic, None) => {
                wrong("expected `designs`, how many are looked at")
            }
            (Method::Grid | Method::Halton, _) if seed.is_some() => {
                wrong("only `random` and `genetic` have a `seed`")
            }
            _ => Ok(Search {
                method,
                designs: designs.unwrap_or(MOST_DESIGNS),
                seed: seed.unwrap_or(0),
            }),
        }
    }
}

/// What a type of the command line reads.
fn parsed<T: FromStr<Err: ToString>>(text: &str) -> Result<T, String> {
    text.parse().map_err(|error: T::Err| error.to_string())
}

fn truth(text: &str) -> Result<bool, String> {
    text.parse().map_err(|_| "expected `true` or `false`".to_string())
}

/// `alpha`, one or several.
fn alphas<T: FromStr<Err: ToString>>(section: &mut Section) -> Result<Vec<T>, StudyError> {
    const NAME: &str = "scene.alpha";
    let Some(value) = section.take("alpha") else { return Ok(vec![]) };
    let (file, span) = (section.file, value.span());
    let read = |value| {
        let text = super::reading::scalar(file, NAME, value)?;
        parsed(&text)
            .map_err(|problem| file.wrong(&span, format!("`{NAME}` is `{text}`: {problem}")))
    };
    match value.get_ref() {
        DeValue::Array(each) => each.iter().map(read).collect(),
        DeValue::Table(_) => {
            Err(file.wrong(&span, expected(NAME, value.get_ref(), "a number, a string, or a list")))
        }
        _ => Ok(vec![read(&value)?]),
    }
}
