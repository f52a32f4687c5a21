//! What an architecture says of itself: to the command line, to listings, to tests.

use crate::model::Model;
use crate::params::{Param, ParamError, Parameters, Preset, did_you_mean, nearest};
use crate::pixel::Screen;
use std::ops::RangeInclusive;

/// An architecture.
pub struct Architecture {
    /// Its name.
    pub name: &'static str,
    /// One sentence.
    pub about: &'static str,
    /// Its presets with a sentence each; the first is the default.
    pub presets: fn() -> Vec<(&'static str, &'static str)>,
    /// Its parameters.
    pub parameters: fn() -> Vec<Param>,
    /// Builds a machine from a preset and settings, later ones before earlier ones.
    pub model: fn(Screen, &str, &[Setting]) -> Built,
    /// A small machine for random frames: parameters over their ranges as far as a small screen makes use of them, with
    /// places for every fragment that is needed.
    pub small: fn(&mut Draw, Needs) -> Parameterised,
    /// Ways to build it that are hardware of their own; the first is the default.
    pub ways: &'static [Set],
    /// What leaves a small frame too little room, so that memory outside of the chip is used and pixels take several
    /// passes. Parameters of one of the ways go over it.
    pub tight: Set,
}

/// The parameter that says of how many frames a machine makes an image, where it makes one of several: a run of so many sets it.
pub const FRAMES: &str = "frames";

/// Values for some of the parameters.
pub type Set = &'static [(&'static str, &'static str)];

/// Gives numbers of a range at random.
pub type Draw<'a> = dyn FnMut(RangeInclusive<u32>) -> u32 + 'a;

/// Parameters with their values.
pub type Parameterised = Vec<(&'static str, String)>;

/// What a machine must have places for.
#[derive(Clone, Copy, Debug)]
pub struct Needs {
    /// All fragments of a frame.
    pub fragments: u32,
    /// Those of one pixel.
    pub layers: u32,
}

/// One of several values, at random.
pub fn one_of<T: Copy>(draw: &mut Draw, values: &[T]) -> T {
    values[draw(0..=values.len() as u32 - 1) as usize]
}

/// The settings that parameters with their values make.
pub fn settings(parameters: &[(&str, String)]) -> Vec<Setting> {
    let setting = |(name, value): &(&str, String)| Setting {
        name: (*name).to_string(),
        value: value.clone(),
        origin: format!("-p {name}={value}"),
    };
    parameters.iter().map(setting).collect()
}

/// A machine, or why it cannot be built.
pub type Built = Result<Box<dyn Model>, SettingError>;

/// A parameter's value as a user gave it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Setting {
    /// The parameter's name.
    pub name: String,
    /// Its value.
    pub value: String,
    /// Where it was given, as a user knows the place.
    pub origin: String,
}

/// An architecture that cannot be built as asked.
#[derive(Debug, thiserror::Error)]
pub enum SettingError {
    /// No such architecture.
    #[error("unknown architecture `{name}`{}; known are {known}", did_you_mean(nearest))]
    Architecture {
        /// What was asked for.
        name: String,
        /// The known name most like it.
        nearest: Option<&'static str>,
        /// All known names.
        known: String,
    },
    /// No such preset.
    #[error("unknown preset `{name}` of `{arch}`{}; known are {known}", did_you_mean(nearest))]
    Preset {
        /// What was asked for.
        name: String,
        /// The architecture.
        arch: &'static str,
        /// The known name most like it.
        nearest: Option<&'static str>,
        /// All known names.
        known: String,
    },
    /// A setting that was not understood.
    #[error("{origin}: {error}")]
    Setting {
        /// Where it was given.
        origin: String,
        /// What is wrong.
        error: ParamError,
    },
    /// Settings that do not go together.
    #[error(transparent)]
    Together(#[from] ParamError),
}

/// Names in quotes, one after the other.
pub fn quoted(names: &[&'static str]) -> String {
    names.iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

/// The presets as an architecture lists them.
pub fn about<P>(presets: &[Preset<P>]) -> Vec<(&'static str, &'static str)> {
    presets.iter().map(|p| (p.name, p.about)).collect()
}

/// The parameters of the preset of that name, with the settings over them.
///
/// # Errors
/// A setting that is not understood.
pub fn chosen<P: Parameters + Default>(
    presets: &[Preset<P>],
    name: &str,
    settings: &[Setting],
) -> Result<P, SettingError> {
    let preset = presets.iter().find(|p| p.name == name);
    let mut params = preset.map_or_else(P::default, |p| (p.params)());
    for Setting { name, value, origin } in settings {
        let set = params.set(name, value);
        set.map_err(|error| SettingError::Setting { origin: origin.clone(), error })?;
    }
    Ok(params)
}

impl Architecture {
    /// The architecture of that name among `all`.
    ///
    /// # Errors
    /// There is none; the nearest name is suggested.
    pub fn named(
        all: &[&'static Architecture],
        name: &str,
    ) -> Result<&'static Architecture, SettingError> {
        let names: Vec<&str> = all.iter().map(|a| a.name).collect();
        all.iter().copied().find(|a| a.name == name).ok_or_else(|| SettingError::Architecture {
            name: name.to_string(),
            nearest: nearest(name, names.iter().copied()),
            known: quoted(&names),
        })
    }

    /// A machine of this architecture.
    ///
    /// # Errors
    /// An unknown preset or parameter, or a value out of range.
    pub fn build(&self, screen: Screen, preset: Option<&str>, settings: &[Setting]) -> Built {
        let names: Vec<&str> = (self.presets)().iter().map(|p| p.0).collect();
        let name = preset.unwrap_or(names[0]);
        if !names.contains(&name) {
            return Err(SettingError::Preset {
                name: name.to_string(),
                arch: self.name,
                nearest: nearest(name, names.iter().copied()),
                known: quoted(&names),
            });
        }
        (self.model)(screen, name, settings)
    }
}
