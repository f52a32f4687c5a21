//! What is said and shown of a sequence that breaks a property.

use crate::harness::{Broken, Run, Seen, play};
use crate::panics::caught;
use crate::reference::Reference;
use pellucid_sim::{Block, Declare, Signals, Sink};
use pellucid_waveforms::{FileFormat, Layout, Marker, View, Wave};
use std::fs::{self, File};
use std::io;
use std::iter;
use std::path::Path;

/// How many cycles are told, the last ones.
const TOLD: usize = 100;

/// What is said of a sequence that breaks a property; its waveform is written into the folder.
pub fn report<R: Reference>(setup: &R::Setup, steps: &[R::Step], folder: &Path) -> String {
    let (played, cycles) = match Run::<R>::new(setup) {
        Ok(mut run) => {
            run.kept = Some(vec![]);
            (play(&mut run, &mut steps.iter()), run.kept.unwrap_or_default())
        }
        Err(broken) => (Err(broken), vec![]),
    };
    let Err(broken) = played else { return "no property is broken".to_string() };
    let told = R::told(setup);
    if cycles.is_empty() {
        return format!("{broken}\n{told}, before the first cycle, so that there is no waveform");
    }
    let failed = match caught(|| record::<R>(&R::config(setup), &cycles, &broken, folder)) {
        Ok(Ok(())) => None,
        Ok(Err(error)) => Some(error.to_string()),
        Err(said) => Some(said),
    };
    let wave = match failed {
        None => format!("its waveform: gtkwave {}", folder.join("wave.gtkw").display()),
        Some(why) => format!("its waveform cannot be written to `{}`: {why}", folder.display()),
    };
    let before = cycles.len().saturating_sub(TOLD);
    let mut lines = vec![];
    if before > 0 {
        lines.push(format!("  ...   {before} cycles, see the waveform"));
    }
    lines.extend(cycles[before..].iter().map(|seen| line(seen.cycle, seen.reset, &seen.told)));
    format!("{broken}\n{wave}\n{told}, cycle by cycle:\n{}", lines.join("\n"))
}

/// A cycle in words.
fn line(cycle: u64, reset: bool, told: &[String]) -> String {
    let what: Vec<&str> =
        reset.then_some("reset").into_iter().chain(told.iter().map(String::as_str)).collect();
    let what = if what.is_empty() { "nothing".to_string() } else { what.join(", ") };
    format!("  {cycle:4}  {what}")
}

/// Writes the waveform, with a marker where a property is broken.
fn record<R: Reference>(
    cfg: &R::Config,
    cycles: &[Seen<R>],
    broken: &Broken<R::Property>,
    folder: &Path,
) -> io::Result<()> {
    let mut waveform = Waveform::new(folder, &mut |to| {
        to.open(R::NAME);
        <<R::Block as Block>::State as pellucid_sim::Registers>::declare(cfg, "registers", to);
        to.open("wires");
        <R::Block as Block>::In::declare(cfg, "in", to);
        R::Outputs::declare(cfg, "out", to);
        bool::declare(&(), "reset", to);
        to.close();
        to.close();
    })?;
    // Inputs that nobody gives are low, and outputs where it panics before there are any.
    let low = <R::Block as Block>::In::restore(cfg, &mut iter::repeat(0));
    let none = R::Outputs::restore(cfg, &mut iter::repeat(0));
    for Seen { cycle, q, inputs, outputs, reset, .. } in cycles {
        waveform.wave.sample(|to| {
            pellucid_sim::Registers::sample(q, cfg, to);
            inputs.unwrap_or(low).sample(cfg, to);
            outputs.unwrap_or(none).sample(cfg, to);
            to.push(u64::from(*reset));
        });
        waveform.wave.show(*cycle)?;
    }
    waveform.finish(folder, broken.cycle, broken.property.to_string())
}

/// A waveform under way: what of it does not depend on what is tried, and so is compiled once.
struct Waveform {
    layout: Layout,
    wave: Wave,
}

impl Waveform {
    fn new(folder: &Path, declare: &mut dyn FnMut(&mut dyn Declare)) -> io::Result<Waveform> {
        let layout = Layout::new(vec![], declare);
        fs::create_dir_all(folder)?;
        let file = File::create(folder.join("wave.vcd"))?;
        let wave = Wave::new(FileFormat::Vcd, file, layout.clone(), 0)?;
        Ok(Waveform { layout, wave })
    }

    /// Ends it behind the cycle in which `property` is broken.
    fn finish(self, folder: &Path, cycle: u64, property: String) -> io::Result<()> {
        let view = View {
            stem: "wave".to_string(),
            format: FileFormat::Vcd,
            markers: vec![Marker { cycle, name: property }],
            longest_label: self.wave.finish(cycle + 1)?,
            ..View::default()
        };
        let make = |path: &Path| fs::create_dir_all(path);
        view.write(&self.layout, folder, make, |path, text| fs::write(path, text))
    }
}
