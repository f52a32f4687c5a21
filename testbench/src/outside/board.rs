//! What is behind a machine's port, as users say it: settings beside the machine's own.

use super::timing::{DramTiming, word_bytes};
use pellucid_dram::{Config, ConfigError, Dram, Part, PartError};
use pellucid_machine::architecture::Setting;
use pellucid_machine::params::{Param, ParamError, Value, nearest};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{
    Arithmetic, Census, Check, Dealer, Dut, Kind, Model, Outside, PhaseInfo, Tally, outside,
};
use pellucid_sim::netlist::Module;
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// Which memory it is.
const OUTSIDE: &str = "outside";
/// The memory with a fixed latency.
const FIXED: &str = "fixed";
/// What the names of all settings of a DRAM begin with.
const DRAM: &str = "dram_";
/// The machine's clock.
const CLOCK: &str = "clock_mhz";
/// The clock where none is named, MHz.
const DEFAULT_CLOCK: u64 = 1000;

/// A setting that was not understood, or does not fit the machine.
#[derive(Debug, thiserror::Error)]
pub enum BoardError {
    /// Unknown, or out of its range.
    #[error("{origin}: {error}")]
    Setting {
        /// Where it was given.
        origin: String,
        /// What is wrong.
        error: ParamError,
    },
    /// No such part, or a file that is none.
    #[error("{origin}: {error}")]
    Part {
        /// Where it was given.
        origin: String,
        /// What is wrong.
        error: Box<PartError>,
    },
    /// Settings that do not go together.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// It is of no use.
    #[error("{origin}: {problem}")]
    Use {
        /// Where it was given.
        origin: String,
        /// Why.
        problem: String,
    },
}

/// All settings.
pub fn settings() -> Vec<Param> {
    let list = |names: &[&str]| {
        let quoted: Vec<String> = names.iter().map(|name| format!("`{name}`")).collect();
        match quoted.split_last() {
            Some((last, others)) if !others.is_empty() => {
                format!("{} or {last}", others.join(", "))
            }
            _ => quoted.concat(),
        }
    };
    let parts = [&[FIXED], &Part::NAMES[..]].concat();
    let param = |name: &str, default: &str, range: String, unit, about| Param {
        name: name.to_string(),
        default: default.to_string(),
        unit,
        range,
        about,
    };
    vec![
        param(
            OUTSIDE,
            FIXED,
            format!("{}, or the file of a part (.toml)", list(&parts)),
            "",
            "The memory behind the machine's port: one of a fixed latency (`outside_latency`), or a DRAM.",
        ),
        param(
            "dram_channels",
            "1",
            "a power of two from 1 to 64".to_string(),
            "channels",
            "Channels of the DRAM.",
        ),
        param(
            "dram_ranks",
            "1",
            "a power of two from 1 to 128".to_string(),
            "ranks",
            "Ranks of a channel.",
        ),
        param(
            "dram_mapping",
            "row-bank-column-group",
            list(pellucid_dram::Mapping::NAMES),
            "",
            "Which bits of an address are its row, bank and column.",
        ),
        param(
            "dram_scheduler",
            "fr-fcfs",
            list(pellucid_dram::Scheduler::NAMES),
            "",
            "In which order requests are served.",
        ),
        param("dram_page", "open", list(pellucid_dram::Page::NAMES), "", "Whether rows stay open."),
        param(
            "dram_refresh",
            "all-bank",
            list(pellucid_dram::Refresh::NAMES),
            "",
            "Whether all banks of a rank are refreshed at once.",
        ),
        param(
            CLOCK,
            "1000",
            "a whole number from 1 to 100000".to_string(),
            "MHz",
            "The machine's clock, beside which the DRAM has its own.",
        ),
    ]
}

/// The settings of what is behind the port, and all others.
pub fn split(settings: Vec<Setting>) -> (Vec<Setting>, Vec<Setting>) {
    settings.into_iter().partition(|setting| {
        let name = &*setting.name;
        name == OUTSIDE || name == CLOCK || name.starts_with(DRAM)
    })
}

fn wrong(setting: &Setting, expected: impl Into<String>) -> BoardError {
    let Setting { name, value, origin } = setting.clone();
    let error = ParamError::Value { name, found: value, expected: expected.into() };
    BoardError::Setting { origin, error }
}

fn choice<T: FromStr<Err: Display>>(setting: &Setting) -> Result<T, BoardError> {
    setting.value.parse().map_err(|error: T::Err| BoardError::Use {
        origin: setting.origin.clone(),
        problem: error.to_string(),
    })
}

fn number(setting: &Setting, from: u64, to: u64) -> Result<u64, BoardError> {
    let number = setting.value.parse().ok().filter(|number| (from..=to).contains(number));
    number.ok_or_else(|| wrong(setting, format!("a whole number from {from} to {to}")))
}

fn power_of_two(setting: &Setting, to: u32) -> Result<u32, BoardError> {
    let fits = |number: &u32| number.is_power_of_two() && *number <= to;
    let number = setting.value.parse().ok().filter(fits);
    number.ok_or_else(|| wrong(setting, format!("a power of two from 1 to {to}")))
}

/// The part of that name, or of that file.
fn part(setting: &Setting) -> Result<Part, BoardError> {
    let value = &*setting.value;
    let is_file = value.ends_with(".toml") || value.contains(std::path::MAIN_SEPARATOR);
    let part = if is_file { Part::open(Path::new(value)) } else { Part::named(value) };
    part.map_err(|error| BoardError::Part {
        origin: setting.origin.clone(),
        error: Box::new(error),
    })
}

/// The machine with what the settings put behind its port; the last value of each counts.
///
/// # Errors
/// See [`BoardError`].
pub fn behind(model: Box<dyn Model>, settings: &[Setting]) -> Result<Box<dyn Model>, BoardError> {
    let last = |name: &str| settings.iter().rev().find(|setting| setting.name == name);
    let names: Vec<String> = self::settings().into_iter().map(|param| param.name).collect();
    for Setting { name, origin, .. } in settings {
        if !names.contains(name) {
            let near = nearest(name, names.iter().map(String::as_str)).map(str::to_string);
            let known = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
            let error = ParamError::Unknown { name: name.clone(), nearest: near, known };
            return Err(BoardError::Setting { origin: origin.clone(), error });
        }
    }
    let Some(chosen) = last(OUTSIDE).filter(|setting| setting.value != FIXED) else {
        return match settings.iter().find(|setting| setting.name != OUTSIDE) {
            None => Ok(model),
            Some(Setting { name, origin, .. }) => Err(BoardError::Use {
                origin: origin.clone(),
                problem: format!("`{name}` needs a DRAM: expected `outside=` and a part"),
            }),
        };
    };
    let mut config = Config::new(part(chosen)?);
    let clock = last(CLOCK).map_or(Ok(DEFAULT_CLOCK), |setting| number(setting, 1, 100_000))?;
    config.machine_period_ps = (1_000_000 + clock / 2) / clock;
    if let Some(setting) = last("dram_channels") {
        config.channels = power_of_two(setting, 64)?;
    }
    if let Some(setting) = last("dram_ranks") {
        config.ranks = power_of_two(setting, 128)?;
    }
    if let Some(setting) = last("dram_mapping") {
        config.mapping = choice(setting)?;
    }
    if let Some(setting) = last("dram_scheduler") {
        config.scheduler = choice(setting)?;
    }
    if let Some(setting) = last("dram_page") {
        config.page = choice(setting)?;
    }
    if let Some(setting) = last("dram_refresh") {
        config.refresh = choice(setting)?;
    }
    let dram = Dram::new(config.clone())?;
    let Some((port, _)) = model.outside() else {
        return Err(BoardError::Use {
            origin: chosen.origin.clone(),
            problem: "the machine has no port to outside memory: expected one with it, such as `tbuffer` with \
                      `outside_sections`"
                .to_string(),
        });
    };
    let (burst, word) = (config.part.organisation.burst_bytes(), word_bytes(port.bits));
    if burst < word {
        return Err(BoardError::Use {
            origin: chosen.origin.clone(),
            problem: format!(
                "a burst of `{}` is {burst} bytes: expected at least {word}, a word of the machine",
                config.part.name
            ),
        });
    }
    let (needed, has) =
        (u128::from(port.words) * u128::from(word_bytes(port.bits)), dram.layout().capacity());
    if needed > has {
        return Err(BoardError::Use {
            origin: chosen.origin.clone(),
            problem: format!(
                "the machine needs {needed} bytes outside: expected at most {has}, as many as `{}` has with these \
                 channels and ranks",
                config.part.name
            ),
        });
    }
    let values = vec![
        (OUTSIDE.to_string(), Value::Text(chosen.value.clone())),
        ("dram_channels".to_string(), Value::Number(config.channels)),
        ("dram_ranks".to_string(), Value::Number(config.ranks)),
        ("dram_mapping".to_string(), Value::Text(config.mapping.to_string())),
        ("dram_scheduler".to_string(), Value::Text(config.scheduler.to_string())),
        ("dram_page".to_string(), Value::Text(config.page.to_string())),
        ("dram_refresh".to_string(), Value::Text(config.refresh.to_string())),
        (CLOCK.to_string(), Value::Number(clock as u32)),
    ];
    Ok(Box::new(WithDram { model, config, bits: port.bits, values }))
}

/// A machine with a DRAM behind its port.
struct WithDram {
    model: Box<dyn Model>,
    config: Config,
    bits: u32,
    values: Vec<(String, Value)>,
}

impl Model for WithDram {
    fn values(&self) -> Vec<(String, Value)> {
        self.model.values().into_iter().chain(self.values.clone()).collect()
    }
    fn screen(&self) -> Screen {
        self.model.screen()
    }
    fn kind(&self) -> Kind {
        self.model.kind()
    }
    fn arithmetic(&self) -> Arithmetic {
        self.model.arithmetic()
    }
    fn phases(&self) -> &'static [PhaseInfo] {
        self.model.phases()
    }
    fn replays(&self) -> bool {
        self.model.replays()
    }
    fn dealer(&self) -> Option<Dealer> {
        self.model.dealer()
    }
    fn closed_forms(&self, tally: &Tally, frames: &[Census]) -> Vec<Check> {
        self.model.closed_forms(tally, frames)
    }
    fn outside(&self) -> Option<(outside::Config, Outside)> {
        let (port, outside) = self.model.outside()?;
        Some((port, Outside { latency: 0, ..outside }))
    }
    fn power_up(&self) -> Box<dyn Dut> {
        let mut dut = self.model.power_up();
        if let Ok(dram) = Dram::new(self.config.clone()) {
            dut.set_timing(Box::new(DramTiming::new(dram, self.bits)));
        }
        dut
    }
    fn netlist(&self) -> Module {
        self.model.netlist()
    }
}
