//! Which machine: an architecture and its parameters.

use super::quoted;
use anyhow::{anyhow, bail};
use clap::Args;
use pellucid_hw::{ARCHITECTURES, architecture};
use pellucid_machine::architecture::{FRAMES, Setting, SettingError};
use pellucid_machine::params::Value;
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Architecture, Census, Model};
use pellucid_testbench::outside::board;
use pellucid_testbench::settings::{self, SettingsError};
use pellucid_testbench::trial::Case;
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
    /// What the commands of the DRAM outside take, in place of what its part says: a file with a section `[energy]`; the same as
    /// `-p dram_energy=FILE.toml`
    #[arg(long, value_name = "FILE.toml")]
    energy: Option<String>,
    /// A parameter of the architecture, or of the memory outside; goes over the file's; may be given several times, the last
    /// value of a parameter counts. `NAME=@FILE` takes what is in the file
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
    let machine = words(Some(arch), preset, settings).join(" ");
    format!("pellucid run {machine} {scene}")
}

/// The options that name a machine, as a shell takes them.
fn words<'a>(
    arch: Option<&str>,
    preset: Option<&str>,
    settings: impl IntoIterator<Item = (&'a str, &'a str)>,
) -> Vec<String> {
    let arch = arch.map(|arch| format!("--arch {}", quoted(arch)));
    let preset = preset.map(|preset| format!("--preset {}", quoted(preset)));
    let settings = settings.into_iter();
    let settings =
        settings.map(|(name, value)| format!("-p {}", quoted(&format!("{name}={value}"))));
    arch.into_iter().chain(preset).chain(settings).collect()
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

    /// Whether the machine makes one image of several frames.
    pub(super) fn accumulates(&self) -> anyhow::Result<bool> {
        Ok(accumulates(self.arch()?))
    }

    /// Of how many frames the machine makes an image, if that is among its parameters.
    pub(super) fn frames(&self) -> anyhow::Result<Option<u32>> {
        let given = if self.accumulates()? { self.given()?.parameters } else { vec![] };
        let last = given.iter().rfind(|parameter| parameter.name == FRAMES);
        // A machine that cannot have so many says so itself.
        Ok(last.and_then(|parameter| parameter.value.parse().ok()))
    }

    /// The machine for a screen and a run of so many frames.
    pub(super) fn build(&self, screen: Screen, frames: u32) -> anyhow::Result<Box<dyn Model>> {
        self.with(screen, frames, &[])
    }

    /// The machine for a screen and a run of so many frames, with further parameters over what is given.
    pub(super) fn with(
        &self,
        screen: Screen,
        frames: u32,
        over: &[Setting],
    ) -> anyhow::Result<Box<dyn Model>> {
        let mut given = self.given()?;
        given.parameters.extend(frames_of(given.arch()?, frames, &given.parameters)?);
        given.parameters.extend(over.iter().cloned());
        given.build(screen)
    }

    /// A machine of these, with room outside for the frames of a case: see [`with_room`].
    pub(super) fn with_room(
        &self,
        machine: Box<dyn Model>,
        case: &Case,
    ) -> anyhow::Result<Box<dyn Model>> {
        let given = self.given()?;
        let (screen, frames) = (machine.screen(), case.frames());
        Ok(with_room(machine, case, &given.parameters, |over| self.with(screen, frames, over)))
    }

    /// What is given of the parameters of these names.
    pub(super) fn gives(&self, names: &[&str]) -> anyhow::Result<Option<Setting>> {
        let given = self.given()?.parameters;
        Ok(given.into_iter().find(|given| names.contains(&&*given.name)))
    }

    /// All that is given but parameters of these names, as a shell takes it.
    pub(super) fn words(&self, without: &[&str]) -> anyhow::Result<Vec<String>> {
        let Given { arch, preset, parameters } = self.given()?;
        let value = |setting: &Option<Setting>| setting.as_ref().map(|s| s.value.clone());
        let (arch, preset) = (value(&arch), value(&preset));
        let parameters = parameters.iter().map(|Setting { name, value, .. }| (&**name, &**value));
        let parameters = parameters.filter(|(name, _)| !without.contains(name));
        Ok(words(arch.as_deref(), preset.as_deref(), parameters))
    }

    /// All that is given, and further parameters, as a file says them.
    pub(super) fn with_values(&self, over: &[Setting]) -> anyhow::Result<Vec<Setting>> {
        let given = self.given()?;
        let arch = given.arch()?.name;
        let head = given.preset.iter().map(|preset| plain("preset", &preset.value));
        let head = [plain("arch", arch)].into_iter().chain(head);
        // Of what is given several times the last counts.
        let mut values: Vec<Setting> = vec![];
        for setting in given.parameters.into_iter().chain(over.iter().cloned()) {
            values.retain(|earlier| earlier.name != setting.name);
            values.push(setting);
        }
        Ok(head.chain(values).collect())
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
        parameters.extend(self.energy.iter().map(|file| Setting {
            name: "dram_energy".to_string(),
            value: file.clone(),
            origin: format!("--energy {file}"),
        }));
        for text in &self.param {
            parameters.push(settings::given(text, format!("-p {text}"))?);
        }
        Ok(Given { arch, preset, parameters })
    }
}

/// A parameter's value that nobody gave.
pub(super) fn plain(name: &str, value: &str) -> Setting {
    Setting { name: name.to_string(), value: value.to_string(), origin: format!("`{name}`") }
}

/// How many frames a run has, for a machine that makes one image of several.
///
/// # Errors
/// What is given says something else.
fn frames_of(
    arch: &Architecture,
    frames: u32,
    given: &[Setting],
) -> anyhow::Result<Option<Setting>> {
    if frames == 1 || !accumulates(arch) {
        return Ok(None);
    }
    let value = frames.to_string();
    let other = given.iter().rfind(|setting| setting.name == FRAMES);
    if let Some(other) = other.filter(|other| other.value != value) {
        bail!(
            "--frames {frames} and parameter `{FRAMES}` {} are both given: expected one of them",
            other.value
        );
    }
    Ok(Some(Setting { name: FRAMES.into(), value, origin: format!("--frames {frames}") }))
}

/// Whether machines of an architecture make one image of several frames.
fn accumulates(arch: &Architecture) -> bool {
    (arch.parameters)().iter().any(|parameter| parameter.name == FRAMES)
}

/// A parameter that is a number, as large as frames need it.
pub(super) fn setting(name: &str, value: u64) -> Setting {
    let value = value.to_string();
    Setting { origin: format!("`{name}={value}`, which the frame needs"), ..plain(name, &value) }
}

/// The machine with as much memory outside as the frames of a case need, unless it has that, or what is given says how much there is.
/// A machine that cannot be so large stays as it is, and drops what finds no place.
fn with_room(
    machine: Box<dyn Model>,
    case: &Case,
    given: &[Setting],
    build: impl Fn(&[Setting]) -> anyhow::Result<Box<dyn Model>>,
) -> Box<dyn Model> {
    let values = machine.values();
    let value = |name: &str| match values.iter().find(|(known, _)| known == name) {
        Some((_, Value::Number(value))) => u64::from(*value),
        _ => 0,
    };
    let needs = case.censuses();
    let needs = needs.iter().filter_map(|frame| machine.room(frame)).filter_map(|room| {
        let (name, units) = room.outside(value(&room.on_chip))?;
        Some((name.to_string(), units))
    });
    let Some((name, units)) = needs.max_by_key(|(_, units)| *units) else { return machine };
    if value(&name) >= units || given.iter().any(|setting| setting.name == name) {
        return machine;
    }
    build(&[setting(&name, units)]).unwrap_or(machine)
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
    fn build(&self, screen: Screen) -> anyhow::Result<Box<dyn Model>> {
        let preset = self.preset.as_ref();
        let name = preset.map(|preset| &*preset.value);
        build(self.arch()?, screen, name, &self.parameters, |error| match (error, preset) {
            (error @ SettingError::Preset { .. }, Some(preset)) => {
                anyhow!("{}: {error}", preset.origin)
            }
            (error, _) => error.into(),
        })
    }

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
        // What has no name goes on with the value before it.
        let mut texts: Vec<String> = vec![];
        for part in parts {
            match texts.last_mut().filter(|_| !part.contains('=')) {
                Some(text) => *text += &format!(",{part}"),
                None => texts.push(part.to_string()),
            }
        }
        let settings = texts.iter().map(|text| settings::given(text, origin.clone()));
        let settings = settings.collect::<Result<_, _>>()?;
        Ok(Choice { origin, ..Choice::new(arch, preset, settings) })
    }

    /// The machine for a screen.
    pub(super) fn build(&self, screen: Screen) -> anyhow::Result<Box<dyn Model>> {
        self.build_for(screen, 1)
    }

    /// The machine for a screen and a run of so many frames.
    pub(super) fn build_for(&self, screen: Screen, frames: u32) -> anyhow::Result<Box<dyn Model>> {
        self.with(screen, frames, &[])
    }

    /// The values of a machine of these before it has seen a frame: of what then may become more it is said.
    pub(super) fn values(&self, machine: &dyn Model) -> Vec<(String, Value)> {
        let grows = machine.room(&Census::default());
        let grows = grows.as_ref().and_then(|room| room.outside(0)).map(|(name, _)| name);
        let given = |name: &str| self.settings.iter().any(|setting| setting.name == name);
        let values = machine.values().into_iter();
        let values = values.map(|(name, value)| match Some(&*name) == grows && !given(&name) {
            true => (name, Value::Text(format!("{value} or more"))),
            false => (name, value),
        });
        values.collect()
    }

    /// A machine of these, with room outside for the frames of a case: see [`with_room`].
    pub(super) fn with_room(&self, machine: Box<dyn Model>, case: &Case) -> Box<dyn Model> {
        let (screen, frames) = (machine.screen(), case.frames());
        with_room(machine, case, &self.settings, |over| self.with(screen, frames, over))
    }

    fn with(
        &self,
        screen: Screen,
        frames: u32,
        over: &[Setting],
    ) -> anyhow::Result<Box<dyn Model>> {
        let mut settings = self.settings.clone();
        settings.extend(frames_of(self.arch, frames, &settings)?);
        settings.extend(over.iter().cloned());
        build(self.arch, screen, Some(&self.preset), &settings, |error| match error {
            SettingError::Setting { .. } => error.into(),
            other => anyhow!("{}: {other}", self.origin),
        })
    }
}
