//! Which machine: an architecture and its parameters.

use crate::arch::{ARCHITECTURES, Architecture, Runnable, Setting, SettingError};
use crate::settings::{self, SettingsError};
use anyhow::anyhow;
use clap::Args;
use pellucid_hw::pixel::Screen;
use std::path::PathBuf;

#[derive(Args)]
pub(super) struct MachineArgs {
    /// The architecture (see `pellucid list`)
    #[arg(long, default_value = "tbuffer", value_name = "NAME")]
    arch: String,
    /// A named set of parameters [default: the architecture's first]
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Parameters from a TOML file of lines `name = value`; they go over the preset's
    #[arg(long, value_name = "FILE.toml")]
    config: Option<PathBuf>,
    /// A parameter of the architecture; goes over the file's; may be given several times, the last
    /// value of a parameter counts
    #[arg(short, long = "param", value_name = "NAME=VALUE")]
    param: Vec<String>,
}

impl MachineArgs {
    /// The architecture.
    pub(super) fn arch(&self) -> Result<&'static Architecture, SettingError> {
        Architecture::named(&self.arch)
    }

    /// The machine for a screen.
    pub(super) fn build(&self, screen: Screen) -> anyhow::Result<Box<dyn Runnable>> {
        Ok(self.arch()?.build(screen, self.preset.as_deref(), &given(self)?)?)
    }
}

/// The settings of the file, then those of the command line.
fn given(args: &MachineArgs) -> Result<Vec<Setting>, SettingsError> {
    let mut settings = match &args.config {
        Some(path) => settings::read(path)?,
        None => vec![],
    };
    for text in &args.param {
        settings.push(settings::parse(text, format!("-p {text}"))?);
    }
    Ok(settings)
}

/// One machine of several.
pub(super) struct Choice {
    /// `ARCH:PRESET[,NAME=VALUE]...`.
    pub(super) name: String,
    /// The architecture.
    pub(super) arch: &'static Architecture,
    preset: String,
    settings: Vec<Setting>,
    origin: String,
}

impl Choice {
    fn new(arch: &'static Architecture, preset: &str, settings: Vec<Setting>) -> Choice {
        let mut name = format!("{}:{preset}", arch.name);
        for Setting { name: key, value, .. } in &settings {
            name += &format!(",{key}={value}");
        }
        let origin = format!("--machine {name}");
        Choice { name, arch, preset: preset.to_string(), settings, origin }
    }

    /// Every preset of every architecture.
    pub(super) fn all() -> Vec<Choice> {
        let presets = |arch: &'static Architecture| {
            (arch.presets)().into_iter().map(move |(preset, _)| Choice::new(arch, preset, vec![]))
        };
        ARCHITECTURES.iter().flat_map(presets).collect()
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
        let arch = Architecture::named(arch.trim()).map_err(|e| anyhow!("{origin}: {e}"))?;
        let preset = preset.unwrap_or_else(|| (arch.presets)().first().map_or("", |p| p.0));
        let settings = parts.map(|part| settings::parse(part, origin.clone()));
        let settings = settings.collect::<Result<_, _>>()?;
        Ok(Choice { origin, ..Choice::new(arch, preset, settings) })
    }

    /// The machine for a screen.
    pub(super) fn build(&self, screen: Screen) -> anyhow::Result<Box<dyn Runnable>> {
        let built = self.arch.build(screen, Some(&self.preset), &self.settings);
        built.map_err(|error| match error {
            SettingError::Setting { .. } => error.into(),
            other => anyhow!("{}: {other}", self.origin),
        })
    }
}
