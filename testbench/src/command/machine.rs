//! Which machine: an architecture and its parameters.

use crate::arch::{Architecture, Runnable, Setting, SettingError};
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
        let Some((name, value)) = text.split_once('=').filter(|(name, _)| !name.trim().is_empty())
        else {
            bail!("-p {text}: expected NAME=VALUE");
        };
        let (name, value) = (name.trim().to_string(), value.trim().to_string());
        settings.push(Setting { name, value, origin: format!("-p {text}") });
    }
    Ok(settings)
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
