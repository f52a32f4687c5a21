//! Which machine: an architecture and its parameters.

use crate::arch::{ARCHITECTURES, Architecture, Runnable, Setting, SettingError};
use crate::output::reason;
use anyhow::{anyhow, bail};
use clap::Args;
use pellucid_hw::pixel::Screen;
use std::path::{Path, PathBuf};

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
        Ok(self.arch()?.build(screen, self.preset.as_deref(), &settings(self)?)?)
    }
}

/// The settings of the file, then those of the command line.
fn settings(args: &MachineArgs) -> anyhow::Result<Vec<Setting>> {
    let mut settings = match &args.config {
        Some(path) => file_settings(path)?,
        None => vec![],
    };
    for text in &args.param {
        settings.push(setting(text, format!("-p {text}"))?);
    }
    Ok(settings)
}

fn setting(text: &str, origin: String) -> anyhow::Result<Setting> {
    let Some((name, value)) = text.split_once('=').filter(|(name, _)| !name.trim().is_empty())
    else {
        bail!("{origin}: expected NAME=VALUE");
    };
    Ok(Setting { name: name.trim().to_string(), value: value.trim().to_string(), origin })
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
        let settings = parts.map(|part| setting(part, origin.clone()));
        let settings = settings.collect::<anyhow::Result<_>>()?;
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

fn file_settings(path: &Path) -> anyhow::Result<Vec<Setting>> {
    let shown = path.display();
    let text = std::fs::read_to_string(path)
        .map_err(|e| anyhow!("cannot read `{shown}`: {}", reason(&e)))?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
        anyhow!("`{shown}`, line {}: {}", before.matches('\n').count() + 1, error.message())
    })?;
    let mut settings = vec![];
    for (name, value) in table {
        let value = match value {
            toml::Value::Integer(n) => n.to_string(),
            toml::Value::String(s) => s,
            other => bail!(
                "`{shown}`, key `{name}`: found {}, expected a number or a string",
                other.type_str()
            ),
        };
        let origin = format!("`{shown}`, key `{name}`");
        settings.push(Setting { name, value, origin });
    }
    Ok(settings)
}
