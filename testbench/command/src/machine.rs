//! Which machine: an architecture and its parameters.

use super::quoted;
use anyhow::{anyhow, bail};
use clap::Args;
use pellucid_hw::{ARCHITECTURES, architecture};
use pellucid_machine::architecture::{Setting, SettingError};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Architecture, Model};
use pellucid_testbench::outside::board;
use pellucid_testbench::settings::{self, SettingsError};
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct MachineArgs {
    /// The architecture (see `pellucid list`) [default: that of --config, or tbuffer]
    #[arg(long, value_name = "NAME")]
    arch: Option<String>,
    /// A named set of parameters [default: that of --config, or the architecture's first]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Parameters from a TOML file of lines `name = value`; they go over the preset's. `arch` and `preset` may be
    /// among them
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// A parameter of the architecture, or of the memory outside; goes over the file's; may be given several times, the last
    /// value of a parameter counts
    #[arg(short, long = "param", value_name = "NAME=VALUE")]
    param: Vec<String>,
}

/// The architecture where none is named.
const DEFAULT_ARCH: &str = "tbuffer";

/// The command that runs a machine on a scene of these arguments, as a shell takes it.
pub(super) fn run_command<'a>(
    arch: &str,
    preset: Option<&str>,
    settings: impl IntoIterator<Item = (&'a str, &'a str)>,
    scene: &str,
) -> String {
    let preset = preset.map(|preset| format!("--preset {preset}"));
    let settings = settings.into_iter();
    let settings =
        settings.map(|(name, value)| format!("-p {}", quoted(&format!("{name}={value}"))));
    let words = [format!("pellucid run --arch {arch}")].into_iter().chain(preset).chain(settings);
    words.chain([scene.to_string()]).collect::<Vec<_>>().join(" ")
}

/// What is given of a machine, by the file and by the command line over it.
struct Given {
    arch: Option<Setting>,
    preset: Option<Setting>,
    parameters: Vec<Setting>,
}

impl MachineArgs {
    /// The architecture.
    pub(super) fn arch(&self) -> anyhow::Result<&'static Architecture> {
        self.given()?.arch()
    }

    /// The machine for a screen.
    pub(super) fn build(&self, screen: Screen) -> anyhow::Result<Box<dyn Model>> {
        let given = self.given()?;
        let preset = given.preset.as_ref();
        let arch = given.arch()?;
        let name = preset.map(|preset| &*preset.value);
        build(arch, screen, name, &given.parameters, |error| match (error, preset) {
            (error @ SettingError::Preset { .. }, Some(preset)) => {
                anyhow!("{}: {error}", preset.origin)
            }
            (error, _) => error.into(),
        })
    }

    fn given(&self) -> Result<Given, SettingsError> {
        let mut parameters = match &self.config {
            Some(path) => settings::read(path)?,
            None => vec![],
        };
        let mut take = |key: &str, over: &Option<String>| {
            let at = parameters.iter().position(|setting| setting.name == key);
            let in_file = at.map(|at| parameters.remove(at));
            let over = over.as_ref().map(|value| Setting {
                name: key.to_string(),
                value: value.clone(),
                origin: format!("--{key} {value}"),
            });
            over.or(in_file)
        };
        let (arch, preset) = (take("arch", &self.arch), take("preset", &self.preset));
        for text in &self.param {
            parameters.push(settings::parse(text, format!("-p {text}"))?);
        }
        Ok(Given { arch, preset, parameters })
    }
}

/// A machine with what the settings put behind its port; `said` tells what is wrong with its own.
fn build(
    arch: &Architecture,
    screen: Screen,
    preset: Option<&str>,
    settings: &[Setting],
    said: impl FnOnce(SettingError) -> anyhow::Error,
) -> anyhow::Result<Box<dyn Model>> {
    let (board, parameters) = board::split(settings, &(arch.parameters)());
    let model = arch.build(screen, preset, &parameters).map_err(said)?;
    Ok(board::behind(model, &board)?)
}

impl Given {
    fn arch(&self) -> anyhow::Result<&'static Architecture> {
        match &self.arch {
            Some(Setting { value, origin, .. }) => {
                architecture(value).map_err(|error| anyhow!("{origin}: {error}"))
            }
            None => Ok(architecture(DEFAULT_ARCH)?),
        }
    }
}

/// One machine of several.
pub(super) struct Choice {
    /// `ARCH:PRESET[,NAME=VALUE]...`.
    pub(super) name: String,
    /// The architecture.
    pub(super) arch: &'static Architecture,
    pub(super) preset: String,
    pub(super) settings: Vec<Setting>,
    origin: String,
}

impl Choice {
    /// A machine of a preset, with settings over it.
    pub(super) fn new(arch: &'static Architecture, preset: &str, settings: Vec<Setting>) -> Choice {
        let mut name = format!("{}:{preset}", arch.name);
        for Setting { name: key, value, .. } in &settings {
            name += &format!(",{key}={value}");
        }
        let origin = format!("--machine {name}");
        Choice { name, arch, preset: preset.to_string(), settings, origin }
    }

    /// The first preset of every architecture, and the names of all other presets.
    pub(super) fn defaults() -> (Vec<Choice>, Vec<String>) {
        let (mut first, mut others) = (vec![], vec![]);
        for arch in ARCHITECTURES.iter().copied() {
            let mut presets = (arch.presets)().into_iter();
            first.extend(presets.next().map(|(preset, _)| Choice::new(arch, preset, vec![])));
            others.extend(presets.map(|(preset, _)| format!("{}:{preset}", arch.name)));
        }
        (first, others)
    }

    /// The machine that `text` names: `ARCH[:PRESET][,NAME=VALUE]...`.
    pub(super) fn parse(text: &str) -> anyhow::Result<Choice> {
        let origin = format!("--machine {text}");
        let mut parts = text.split(',');
        let name = parts.next().unwrap_or_default();
        let (arch, preset) = match name.split_once(':') {
            Some((arch, preset)) => (arch, Some(preset.trim())),
            None => (name, None),
        };
        let arch = architecture(arch.trim()).map_err(|e| anyhow!("{origin}: {e}"))?;
        if let Some(setting) = preset.filter(|preset| preset.contains('=')) {
            bail!(
                "{origin}: `{setting}` is no preset; a parameter comes behind a comma: `{},{setting}`",
                arch.name
            );
        }
        let preset = preset.unwrap_or_else(|| (arch.presets)().first().map_or("", |p| p.0));
        let settings = parts.map(|part| settings::parse(part, origin.clone()));
        let settings = settings.collect::<Result<_, _>>()?;
        Ok(Choice { origin, ..Choice::new(arch, preset, settings) })
    }

    /// The machine for a screen.
    pub(super) fn build(&self, screen: Screen) -> anyhow::Result<Box<dyn Model>> {
        build(self.arch, screen, Some(&self.preset), &self.settings, |error| match error {
            SettingError::Setting { .. } => error.into(),
            other => anyhow!("{}: {other}", self.origin),
        })
    }
}
