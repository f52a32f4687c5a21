//! `pellucid size`: the smallest machine that loses nothing of some frames.

use super::amount::bytes;
use super::machine::{MachineArgs, plain, setting};
use super::sequence::SequenceArgs;
use super::{DEFAULT_SCENE, ViewArgs, finished, passes, say};
use anyhow::{anyhow, bail};
use clap::Args;
use pellucid_machine::architecture::Setting;
use pellucid_machine::params::Value;
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Census, Model, Rest, Room};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::report::{grouped, known_beforehand};
use pellucid_testbench::trial::Case;
use serde_json::json;

#[derive(Args)]
pub(super) struct SizeArgs {
    /// A built-in scene (see `pellucid list`), a mesh (.obj, .ply, .ply.gz, .gltf, .glb) or a trace
    /// (.csv, .ptrace); may be given several times
    #[arg(long, default_value = DEFAULT_SCENE, value_name = "NAME|FILE")]
    scene: Vec<String>,
    #[command(flatten)]
    view: ViewArgs,
    #[command(flatten)]
    machine: MachineArgs,
    #[command(flatten)]
    sequence: SequenceArgs,
    /// Most bytes of memory on the chip, frame buffers included, as `4 MiB`: as much as fits is held there, the rest outside
    /// [default: all of it is on the chip]
    #[arg(long, value_name = "BYTES", value_parser = bytes)]
    budget: Option<u64>,
    /// Room beyond what the fullest frame takes, in percent, a whole number from 0 to 1000
    #[arg(long, value_name = "PERCENT", default_value_t = 10, value_parser = percent, allow_hyphen_values = true)]
    margin: u32,
    /// Print nothing but the machine and errors
    #[arg(long, short)]
    quiet: bool,
}

/// A share of what is needed.
fn percent(text: &str) -> Result<u32, String> {
    let percent = text.parse().ok().filter(|percent| (0..=1000).contains(percent));
    percent.ok_or_else(|| "expected a whole number from 0 to 1000".to_string())
}

/// The figure that a budget bounds.
const ON_CHIP: &str = "storage.on_chip_bytes";

/// What all frames together ask of a machine.
struct Needs {
    room: Room,
    /// The value of the parameter of what is on chip with which nothing is outside.
    all: u64,
}

impl Needs {
    /// The larger of two; both are of one architecture.
    fn with(self, other: Needs) -> Needs {
        let room = Room {
            units: self.room.units.max(other.room.units),
            least: self.room.least.max(other.room.least),
            ..self.room
        };
        Needs { room, all: self.all.max(other.all) }
    }

    /// With so many percent more.
    fn with_margin(self, percent: u32) -> Needs {
        let more = |n: u64| (n * u64::from(100 + percent)).div_ceil(100);
        let of_unit = self.room.of_unit;
        let some = u64::from(matches!(self.room.rest, Rest::All(_)));
        let units = more(self.room.units).max(some);
        let least = match self.room.rest {
            Rest::Nothing => more(self.room.least),
            _ => self.room.least,
        };
        let all = (more(self.all / of_unit) * of_unit).max(least);
        Needs { room: Room { units, least, ..self.room }, all }
    }

    /// The parameters with so much on chip.
    fn settings(&self, on_chip: u64) -> Vec<Setting> {
        let Room { on_chip: name, units, rest, .. } = &self.room;
        let mut settings = vec![setting(name, on_chip)];
        match rest {
            Rest::Nothing => {}
            Rest::Beyond(_) => {
                settings.extend(self.room.outside(on_chip).map(|(name, n)| setting(name, n)));
            }
            Rest::All(names) => settings.extend(names.iter().map(|name| setting(name, *units))),
        }
        settings
    }
}

/// Sizes a machine; whether it is right on every scene.
pub(super) fn size(args: &SizeArgs) -> anyhow::Result<bool> {
    let arch = args.machine.arch()?;
    let mut cases = vec![];
    let mut needs: Option<Needs> = None;
    let mut sequence = args.sequence.clone();
    sequence.frames = sequence.frames.or(args.machine.frames()?);
    for scene in &args.scene {
        let (source, frames) = sequence.open(scene, &args.view, args.machine.accumulates()?)?;
        let machine = first(args, source.screen(), frames)?;
        let frames = frames.next_multiple_of(machine.frames_of_image());
        let mut progress = Progress::new("golden model", None, args.quiet);
        let case = Case::new(scene, source, &*machine, &mut progress)?;
        let case = case.with_frames(frames, &*machine, &mut progress)?;
        for frame in case.censuses() {
            let Some(need) = need(&*machine, &frame) else {
                bail!(
                    "`{}` has no parameter that says how much of a frame it holds: there is nothing to size",
                    arch.name
                );
            };
            needs = Some(match needs {
                Some(needs) => needs.with(need),
                None => need,
            });
        }
        cases.push(case);
    }
    let needs = needs.expect("a case has a frame").with_margin(args.margin);
    if let Some(given) = args.machine.gives(&needs.room.names())? {
        bail!("{}: `{}` is what is looked for here, leave it out", given.origin, given.name);
    }
    let build = |on_chip: u64| -> anyhow::Result<Vec<Box<dyn Model>>> {
        let settings = needs.settings(on_chip);
        cases
            .iter()
            .map(|case| args.machine.with(case.source.screen(), case.frames(), &settings))
            .collect()
    };
    let taken = |machines: &[Box<dyn Model>]| {
        let each = machines.iter().filter_map(|machine| known_beforehand(&**machine, ON_CHIP));
        each.max().unwrap_or(0)
    };
    let budget = args.budget.unwrap_or(u64::MAX);
    let fits = |on_chip| match build(on_chip) {
        Ok(machines) => Ok(taken(&machines) <= budget),
        // A DRAM that is asked for has something in it.
        Err(_) if on_chip == needs.all && args.budget.is_some() => Ok(false),
        Err(error) => Err(error),
    };
    let mut on_chip = needs.all;
    if !fits(on_chip)? {
        let (mut low, mut high) = (needs.room.least, needs.all);
        if !fits(low)? {
            return Err(too_small(args, &needs, &cases, &build(low)?));
        }
        while high - low > 1 {
            let middle = low + (high - low) / 2;
            if fits(middle)? {
                low = middle;
            } else {
                high = middle;
            }
        }
        on_chip = low;
    }

    let machines = build(on_chip)?;
    let mut right = true;
    for (case, machine) in cases.iter().zip(&machines) {
        let items = case.items * u64::from(case.frames());
        let mut progress = Progress::new("simulating", Some(items), args.quiet);
        let trial = case.run(arch.name, &**machine, None, &mut progress);
        drop(progress);
        let about = format!("{}: ", case.scene);
        let Some(trial) = finished(trial, &about)? else { return Ok(false) };
        right &= passes(&trial.verdict, false, &about);
    }
    say(&toml(args, &needs, on_chip, &cases, &machines)?)?;
    Ok(right)
}

/// A machine that sees frames as the one that is looked for does: as it is given, or where it cannot be so large, as small as can be.
fn first(args: &SizeArgs, screen: Screen, frames: u32) -> anyhow::Result<Box<dyn Model>> {
    let error = match args.machine.build(screen, frames) {
        Ok(machine) => return Ok(machine),
        Err(error) => error,
    };
    let any = args.machine.arch()?.build(screen, None, &[]);
    let Some(need) = any.ok().and_then(|any| need(&*any, &Census::default())) else {
        return Err(error);
    };
    let smallest = need.with_margin(0);
    args.machine.with(screen, frames, &smallest.settings(smallest.all)).map_err(|_| error)
}

/// What a frame asks of a machine.
fn need(machine: &dyn Model, frame: &Census) -> Option<Needs> {
    let room = machine.room(frame)?;
    let all = (room.units * room.of_unit).max(room.least);
    Some(Needs { room, all })
}

/// The sentence about a budget below what a machine takes with as little on chip as can be.
fn too_small(
    args: &SizeArgs,
    needs: &Needs,
    cases: &[Case],
    machines: &[Box<dyn Model>],
) -> anyhow::Error {
    let of = |machine: &dyn Model| known_beforehand(machine, ON_CHIP).unwrap_or(0);
    let each = cases.iter().zip(machines);
    let Some((case, machine)) = each.max_by_key(|(_, machine)| of(&***machine)) else {
        return anyhow!("there is no machine");
    };
    let mut memories = machine.power_up().tally().memories;
    memories.retain(|memory| !memory.info.outside);
    memories.sort_by_key(|memory| std::cmp::Reverse(memory.info.bits()));
    let largest = memories.iter().take(3).map(|memory| {
        let bytes = grouped(&json!(memory.info.bits().div_ceil(8)));
        format!("`{}` {bytes}", memory.name)
    });
    let largest = largest.collect::<Vec<_>>().join(", ");
    // Tables that could lie outside, with a cache on chip or without, where that is smaller.
    let smaller = |name: &str, place: &str| {
        let mut settings = needs.settings(needs.room.least);
        settings.push(plain(name, place));
        let other = args.machine.with(case.source.screen(), case.frames(), &settings);
        other.is_ok_and(|other| of(&*other) < of(&**machine))
    };
    let tables = machine.values().into_iter();
    let tables = tables.filter(|(_, value)| *value == Value::Choice("on_chip"));
    let places =
        tables.flat_map(|(name, _)| ["cached", "outside"].map(|place| (name.clone(), place)));
    let movable: Vec<String> = places
        .filter(|(name, place)| smaller(name, place))
        .map(|(name, place)| format!("; `-p {name}={place}` has less there"))
        .collect();
    anyhow!(
        "--budget {}: with `{}={}` the machine has {} bytes on the chip, among them {largest}{}",
        grouped(&json!(args.budget)),
        needs.room.on_chip,
        needs.room.least,
        grouped(&json!(of(&**machine))),
        movable.concat(),
    )
}

/// The machine as a file for `--config`, with what it is in comments.
fn toml(
    args: &SizeArgs,
    needs: &Needs,
    on_chip: u64,
    cases: &[Case],
    machines: &[Box<dyn Model>],
) -> anyhow::Result<String> {
    let scenes = cases.iter().map(|case| {
        let Screen { width, height, .. } = case.source.screen();
        let frames = match case.frames() {
            1 => String::new(),
            frames => format!(", {frames} frames"),
        };
        format!("{} at {width}x{height}{frames}", case.scene)
    });
    let figure = |name| {
        let each = machines.iter().filter_map(|machine| known_beforehand(&**machine, name));
        grouped(&json!(each.max().unwrap_or(0)))
    };
    let mut text = format!(
        "# For {}: room for {} % more than the fullest frame takes.\n\
         # {} bytes on the chip, frame buffers included, {} outside.\n",
        scenes.collect::<Vec<_>>().join(", "),
        args.margin,
        figure(ON_CHIP),
        figure("storage.outside_bytes"),
    );
    for Setting { name, value, .. } in args.machine.with_values(&needs.settings(on_chip))? {
        let value = match value.parse::<i64>() {
            Ok(number) => toml::Value::Integer(number),
            Err(_) => toml::Value::String(value),
        };
        text += &format!("{name} = {value}\n");
    }
    Ok(text)
}
