//! Scenes through the presets of every machine.

use crate::frames::kept_at;
use pellucid_machine::{Architecture, Tally};
use pellucid_testbench::progress::Progress;
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::scene::{Options, built_in};
use pellucid_testbench::source::Source;
use pellucid_testbench::trial::Case;
use pellucid_testbench::window::{Window, default_windows};

/// The frame through the machine of a preset; the run must be right.
///
/// # Panics
/// It is not.
pub fn preset(arch: &Architecture, scene: &str, options: &Options, preset: &str) -> Tally {
    let mut progress = Progress::new("", None, true);
    let source = Source::open(scene, options).unwrap();
    let machine = arch.build(source.screen(), Some(preset), &[]).unwrap();
    let case = Case::new(scene, source, &*machine, &mut progress).unwrap();
    let trial = case.run(arch.name, &*machine, None, &mut progress);
    if trial.as_ref().map_or(true, |trial| !trial.verdict.is_right()) {
        let mut windows = default_windows(machine.phases());
        windows.push(Window::Failure);
        let wave = WaveJob::new(&kept_at(), &windows);
        println!("its waveform: {}", wave.path.display());
        let place = trial.as_ref().ok().and_then(|trial| trial.verdict.place());
        let place = place.unwrap_or(Window::Failure);
        let _ = case.run_again(arch.name, &*machine, &wave, place, &mut progress);
    }
    let trial = trial.unwrap();
    let faults = trial.verdict.faults();
    assert!(trial.verdict.is_right(), "{scene}, {}, {preset}: {faults:?}", arch.name);
    trial.report.tally().clone()
}

/// A small view of a scene through every preset.
///
/// # Panics
/// A run is not right.
pub fn all_presets(arch: &Architecture, scene: &str) {
    let options = Options { width: Some(160), height: Some(120), ..Options::default() };
    for (name, _) in (arch.presets)() {
        preset(arch, scene, &options, name);
    }
}

/// A rate of which the targets speak: `part` per `whole`.
///
/// # Panics
/// It is below `least`.
pub fn assert_rate(what: &str, part: u64, whole: u64, least: f64) {
    let rate = part as f64 / whole as f64;
    assert!(rate >= least, "{what}: {rate:.4} fragments per cycle, expected at least {least}");
}

/// The eight frames of seed 000 through a preset: about one fragment a cycle in either phase.
///
/// # Panics
/// A run is not right, or slower.
pub fn papers_frames_at_the_target_rate(arch: &Architecture, preset_name: &str) {
    for scene in built_in().iter().filter(|scene| scene.name.starts_with("paper-")) {
        let Tally { fragments, cycles, .. } =
            preset(arch, scene.name, &Options::default(), preset_name);
        for (phase, least) in [("store", 0.98), ("resolve", 0.9)] {
            let spent = cycles.of(phase).unwrap();
            assert_rate(&format!("{}, {phase}", scene.name), fragments.stored, spent, least);
        }
    }
}
