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
    let mut lines: Vec<String> = cycles.iter().map(line).collect();
    let before = lines.len().saturating_sub(TOLD);
    if before > 0 {
        lines.splice(..before, [format!("  ...   {before} cycles, see the waveform")]);
    }
    format!("{broken}\n{wave}\n{told}, cycle by cycle:\n{}", lines.join("\n"))
}

/// A cycle in words.
fn line<R: Reference>(seen: &Seen<R>) -> String {
    let reset = seen.reset.then_some("reset");
    let what: Vec<&str> = reset.into_iter().chain(seen.told.iter().map(String::as_str)).collect();
    let what = if what.is_empty() { "nothing".to_string() } else { what.join(", ") };
    format!("  {:4}  {what}", seen.cycle)
}

/// Writes the waveform, with a marker where a property is broken.
fn record<R: Reference>(
    cfg: &R::Config,
    cycles: &[Seen<R>],
    broken: &Broken<R::Property>,
    folder: &Path,
) -> io::Result<()> {
    let layout = Layout::new(vec![], |to: &mut dyn Declare| {
        to.open(R::NAME);
        <<R::Block as Block>::State as pellucid_sim::Registers>::declare(cfg, "registers", to);
        to.open("wires");
        <R::Block as Block>::In::declare(cfg, "in", to);
        R::Outputs::declare(cfg, "out", to);
        bool::declare(&(), "reset", to);
        to.close();
        to.close();
    });
    fs::create_dir_all(folder)?;
    let file = File::create(folder.join("wave.vcd"))?;
    let mut wave = Wave::new(FileFormat::Vcd, file, layout.clone(), 0)?;
    // Inputs that nobody gives are low, and outputs where it panics before there are any.
    let low = <R::Block as Block>::In::restore(cfg, &mut iter::repeat(0));
    let none = R::Outputs::restore(cfg, &mut iter::repeat(0));
    for Seen { cycle, q, inputs, outputs, reset, .. } in cycles {
        wave.sample(|to| {
            pellucid_sim::Registers::sample(q, cfg, to);
            inputs.unwrap_or(low).sample(cfg, to);
            outputs.unwrap_or(none).sample(cfg, to);
            to.push(u64::from(*reset));
        });
        wave.show(*cycle)?;
    }
    let longest_label = wave.finish(broken.cycle + 1)?;
    let view = View {
        stem: "wave".to_string(),
        format: FileFormat::Vcd,
        markers: vec![Marker { cycle: broken.cycle, name: broken.property.to_string() }],
        longest_label,
        ..View::default()
    };
    view.write(&layout, folder, |path| fs::create_dir_all(path), |path, text| fs::write(path, text))
}
