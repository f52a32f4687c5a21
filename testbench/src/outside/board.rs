//! What is behind a machine's port, as users say it: settings beside the machine's own.

use super::timing::{DramTiming, word_bytes};
use crate::costs::CLOCK;
use pellucid_dram::{Config, Dram, Energy, Mapping, Page, Part, PartError, Refresh, Scheduler};
use pellucid_machine::architecture::{Setting, quoted};
use pellucid_machine::params::{
    Param, ParamError, ParamType, Value, did_you_mean, nearest, one_of,
};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{
    Accumulation, Arithmetic, Census, Check, Dealer, Dut, Kind, Model, PhaseInfo, Room, Tally,
    outside,
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
/// The clock beside a DRAM where none is named, MHz.
const DEFAULT_CLOCK: u32 = 1000;

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
    /// It is of no use, or does not go with others.
    #[error("{origin}: {problem}")]
    Use {
        /// Where it was given.
        origin: String,
        /// Why.
        problem: String,
    },
}

/// What is behind a port, as far as it can be set.
struct Chosen {
    dram: Config,
    clock_mhz: u32,
    /// The file that says what commands take, or [`OF_PART`].
    energy: String,
}

/// What commands take is said by the part.
const OF_PART: &str = "part";

/// A setting of a DRAM, or of the clock beside it.
struct Field {
    name: &'static str,
    unit: &'static str,
    about: &'static str,
    /// What it may be, as text.
    range: fn() -> String,
    set: fn(&mut Chosen, &Setting) -> Result<(), BoardError>,
    get: fn(&Chosen) -> Value,
}

/// The most channels that a memory can have, and the most ranks of one.
const MOST_CHANNELS: u32 = 64;
const MOST_RANKS: u32 = 128;
/// The fastest clock, MHz.
const MOST_MHZ: u32 = 100_000;

/// All but the memory itself.
const FIELDS: [Field; 8] = [
    Field {
        name: "dram_channels",
        unit: "channels",
        about: "Channels of the DRAM.",
        range: || power_of_two_to(MOST_CHANNELS),
        set: |to, setting| power_of_two(setting, MOST_CHANNELS).map(|n| to.dram.channels = n),
        get: |of| Value::Number(of.dram.channels),
    },
    Field {
        name: "dram_ranks",
        unit: "ranks",
        about: "Ranks of a channel.",
        range: || power_of_two_to(MOST_RANKS),
        set: |to, setting| power_of_two(setting, MOST_RANKS).map(|n| to.dram.ranks = n),
        get: |of| Value::Number(of.dram.ranks),
    },
    Field {
        name: "dram_mapping",
        unit: "",
        about: "Which bits of an address are its row, bank and column.",
        range: || one_of(Mapping::NAMES),
        set: |to, setting| choice(setting).map(|mapping| to.dram.mapping = mapping),
        get: |of| Value::Text(of.dram.mapping.to_string()),
    },
    Field {
        name: "dram_scheduler",
        unit: "",
        about: "In which order requests are served.",
        range: || one_of(Scheduler::NAMES),
        set: |to, setting| choice(setting).map(|scheduler| to.dram.scheduler = scheduler),
        get: |of| Value::Text(of.dram.scheduler.to_string()),
    },
    Field {
        name: "dram_page",
        unit: "",
        about: "Whether rows stay open.",
        range: || one_of(Page::NAMES),
        set: |to, setting| choice(setting).map(|page| to.dram.page = page),
        get: |of| Value::Text(of.dram.page.to_string()),
    },
    Field {
        name: "dram_refresh",
        unit: "",
        about: "Whether all banks of a rank are refreshed at once.",
        range: || one_of(Refresh::NAMES),
        set: |to, setting| choice(setting).map(|refresh| to.dram.refresh = refresh),
        get: |of| Value::Text(of.dram.refresh.to_string()),
    },
    Field {
        name: "dram_energy",
        unit: "",
        about: "What its commands take: as the part says, or a file with a section `[energy]`.",
        range: || format!("`{OF_PART}`, or a file (.toml)"),
        set: |to, setting| energy(to, setting),
        get: |of| Value::Text(of.energy.clone()),
    },
    Field {
        name: CLOCK,
        unit: "MHz",
        about: "The machine's clock, beside which a DRAM has its own, and by which cycles become time; where neither a DRAM nor this is \
                named, the fastest that its memories on the chip allow.",
        range: || u32::expected(&(1..=MOST_MHZ)),
        set: |to, setting| clock(setting).map(|mhz| to.clock_mhz = mhz),
        get: |of| Value::Number(of.clock_mhz),
    },
];

impl Chosen {
    /// What is chosen where nothing but the part is said.
    fn new(part: Part) -> Chosen {
        let dram = Config::new(part);
        Chosen { dram, clock_mhz: DEFAULT_CLOCK, energy: OF_PART.to_string() }
    }

    /// The memory beside a machine of that clock.
    fn memory(self) -> Config {
        let clock = u64::from(self.clock_mhz);
        Config { machine_period_ps: (1_000_000 + clock / 2) / clock, ..self.dram }
    }
}

/// All settings.
pub fn settings() -> Vec<Param> {
    let parts = one_of(&[&[FIXED], &Part::NAMES[..]].concat());
    let memory = Param {
        name: OUTSIDE.to_string(),
        default: FIXED.to_string(),
        unit: "",
        range: format!("{parts}, or the file of a part (.toml)"),
        about: "The memory behind the machine's port: one of a fixed latency (`outside_latency`), or a DRAM.",
    };
    // The same with any part.
    let part = Part::named(Part::NAMES[0]).expect("a part that is shipped");
    let chosen = Chosen::new(part);
    let fields = FIELDS.iter().map(|field| Param {
        name: field.name.to_string(),
        default: (field.get)(&chosen).to_string(),
        unit: field.unit,
        range: (field.range)(),
        about: field.about,
    });
    [memory].into_iter().chain(fields).collect()
}

/// The names of all settings.
fn names() -> impl Iterator<Item = &'static str> {
    [OUTSIDE].into_iter().chain(FIELDS.iter().map(|field| field.name))
}

/// The settings of what is behind the port, and all others. One that neither it nor the machine has is of the side whose
/// names are most like it.
pub fn split(settings: &[Setting], machine: &[Param]) -> (Vec<Setting>, Vec<Setting>) {
    let board: Vec<&str> = names().collect();
    let machine: Vec<&str> = machine.iter().map(|param| &*param.name).collect();
    settings.iter().cloned().partition(|Setting { name, .. }| {
        let name = &**name;
        let all = board.iter().chain(&machine).copied();
        let like_one = || nearest(name, all).is_some_and(|near| board.contains(&near));
        let known = board.contains(&name) || name.starts_with(DRAM);
        known || (!machine.contains(&name) && like_one())
    })
}

fn wrong(setting: &Setting, expected: String) -> BoardError {
    let Setting { name, value, origin } = setting.clone();
    let error = ParamError::Value { name, found: value, expected };
    BoardError::Setting { origin, error }
}

fn choice<T: FromStr<Err: Display>>(setting: &Setting) -> Result<T, BoardError> {
    setting.value.parse().map_err(|error: T::Err| BoardError::Use {
        origin: setting.origin.clone(),
        problem: error.to_string(),
    })
}

fn power_of_two_to(most: u32) -> String {
    format!("a power of two from 1 to {most}")
}

fn power_of_two(setting: &Setting, to: u32) -> Result<u32, BoardError> {
    let fits = |number: &u32| number.is_power_of_two() && *number <= to;
    let number = setting.value.parse().ok().filter(fits);
    number.ok_or_else(|| wrong(setting, power_of_two_to(to)))
}

fn clock(setting: &Setting) -> Result<u32, BoardError> {
    let mhz = u32::parse(&setting.value, &(1..=MOST_MHZ));
    mhz.ok_or_else(|| wrong(setting, u32::expected(&(1..=MOST_MHZ))))
}

fn energy(to: &mut Chosen, setting: &Setting) -> Result<(), BoardError> {
    if setting.value != OF_PART {
        let energy = Energy::open(Path::new(&setting.value));
        let origin = || setting.origin.clone();
        to.dram.part.energy = Some(energy.map_err(|error| match error {
            PartError::Read { file, error } => BoardError::Use {
                origin: origin(),
                problem: format!(
                    "cannot read `{file}`: {error}; expected `{OF_PART}`, or a file with a section `[energy]`"
                ),
            },
            error => BoardError::Part { origin: origin(), error: Box::new(error) },
        })?);
        to.energy = setting.value.clone();
    }
    Ok(())
}

/// The part of that name, or of that file.
fn part(setting: &Setting) -> Result<Part, BoardError> {
    let value = &*setting.value;
    let is_file = value.ends_with(".toml") || value.contains(std::path::MAIN_SEPARATOR);
    if !is_file && !Part::NAMES.contains(&value) {
        let memories = [&[FIXED], &Part::NAMES[..]].concat();
        let near = did_you_mean(&nearest(value, memories.iter().copied()));
        let known = quoted(&memories);
        return Err(BoardError::Use {
            origin: setting.origin.clone(),
            problem: format!(
                "unknown memory `{value}`{near}; known are {known}, and the files of parts (.toml)"
            ),
        });
    }
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
    for Setting { name, origin, .. } in settings {
        if !names().any(|known| known == name) {
            let near = nearest(name, names()).map(str::to_string);
            let known = quoted(&names().collect::<Vec<_>>());
            let error = ParamError::Unknown { name: name.clone(), nearest: near, known };
            return Err(BoardError::Setting { origin: origin.clone(), error });
        }
    }
    let Some(chosen) = last(OUTSIDE).filter(|setting| setting.value != FIXED) else {
        // What was said of a DRAM goes where `fixed` is said over it.
        let memories = settings.iter().enumerate().filter(|(_, setting)| setting.name == OUTSIDE);
        let from = memories.skip(1).last().map_or(0, |(over, _)| over);
        let of_dram = |setting: &&Setting| ![OUTSIDE, CLOCK].contains(&&*setting.name);
        if let Some(Setting { name, origin, .. }) = settings[from..].iter().find(of_dram) {
            return Err(BoardError::Use {
                origin: origin.clone(),
                problem: format!("`{name}` needs a DRAM: expected `outside=` and a part"),
            });
        }
        // The clock is the machine's own.
        return match last(CLOCK) {
            None => Ok(model),
            Some(setting) => {
                let values = vec![(CLOCK.to_string(), Value::Number(clock(setting)?))];
                Ok(Box::new(OnBoard { model, dram: None, values }))
            }
        };
    };
    let mut with = Chosen::new(part(chosen)?);
    for field in &FIELDS {
        if let Some(setting) = last(field.name) {
            (field.set)(&mut with, setting)?;
        }
    }
    let fields = FIELDS.iter().map(|field| (field.name.to_string(), (field.get)(&with)));
    let values: Vec<(String, Value)> = [(OUTSIDE.to_string(), Value::Text(chosen.value.clone()))]
        .into_iter()
        .chain(fields)
        .collect();
    let config = with.memory();
    let dram = Dram::new(config.clone()).map_err(|error| BoardError::Use {
        origin: last("dram_ranks").unwrap_or(chosen).origin.clone(),
        problem: error.to_string(),
    })?;
    let port = model.port();
    if !port.exists() {
        return Err(BoardError::Use {
            origin: chosen.origin.clone(),
            problem: "the machine has no port to outside memory: expected one with it, such as `tbuffer` with \
                      `outside_sections`"
                .to_string(),
        });
    }
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
    let (needed, has) = (u128::from(port.words) * u128::from(word), dram.layout().capacity());
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
    Ok(Box::new(OnBoard { model, dram: Some(config), values }))
}

/// A machine with what was set beside its own parameters.
struct OnBoard {
    model: Box<dyn Model>,
    /// The DRAM behind its port. Checked: a memory was made of it.
    dram: Option<Config>,
    values: Vec<(String, Value)>,
}

impl Model for OnBoard {
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
    fn accumulation(&self) -> Option<Accumulation> {
        self.model.accumulation()
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
    fn room(&self, frame: &Census) -> Option<Room> {
        self.model.room(frame)
    }
    fn port(&self) -> outside::Config {
        self.model.port()
    }
    fn latency(&self) -> Option<u32> {
        self.model.latency().filter(|_| self.dram.is_none())
    }
    fn power_up(&self) -> Box<dyn Dut> {
        let mut dut = self.model.power_up();
        if let Some(config) = &self.dram {
            let dram = Dram::new(config.clone()).expect("a configuration that one was made of");
            dut.set_timing(Box::new(DramTiming::new(dram, self.port().bits)));
        }
        dut
    }
    fn netlist(&self) -> Module {
        self.model.netlist()
    }
}
