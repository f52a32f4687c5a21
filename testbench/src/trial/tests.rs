use super::*;
use crate::scene::Options;
use pellucid_machine::params::Value;
use pellucid_machine::pixel::Screen;
use pellucid_machine::{
    Accumulation, Arithmetic, Check, Dealer, Dut, Kind, PhaseInfo, Room, Tally, outside,
};
use pellucid_mbuffer::architecture as mbuffer;
use pellucid_sim::netlist::Module;
use pellucid_tbuffer::architecture::ARCHITECTURE;
use std::sync::atomic::{AtomicUsize, Ordering};

/// A T-buffer whose display takes nothing, if it is stuck.
struct Broken {
    model: Box<dyn Model>,
    stuck: bool,
    /// It says that it takes primitives.
    primitives: bool,
    runs: AtomicUsize,
}

impl Broken {
    fn new(screen: Screen, stuck: bool, primitives: bool) -> Broken {
        let model = ARCHITECTURE.build(screen, None, &[]).unwrap();
        Broken { model, stuck, primitives, runs: AtomicUsize::new(0) }
    }
}

impl Model for Broken {
    fn values(&self) -> Vec<(String, Value)> {
        self.model.values()
    }
    fn screen(&self) -> Screen {
        self.model.screen()
    }
    fn kind(&self) -> Kind {
        if self.primitives { Kind::Primitives } else { Kind::Fragments }
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
        self.model.latency()
    }
    fn power_up(&self) -> Box<dyn Dut> {
        self.runs.fetch_add(1, Ordering::Relaxed);
        let mut dut = self.model.power_up();
        if self.stuck {
            dut.set_display(Box::new(|_| false));
        }
        dut
    }
    fn netlist(&self) -> Module {
        self.model.netlist()
    }
}

/// The outcome, how often the machine was run, and the markers of the waveform.
fn trial(stuck: bool, wave: bool) -> (Result<Trial, BenchError>, usize, Vec<String>) {
    let options = Options { width: Some(20), height: Some(15), ..Options::default() };
    let source = Source::open("glass", &options).unwrap();
    let machine = Broken::new(source.screen(), stuck, false);
    let mut progress = Progress::new("", None, true);
    let case = Case::new("glass", source, &machine, &mut progress).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let job = WaveJob::new(&folder.path().join("wave.vcd"), &[Window::Cycles { from: 3, to: 5 }]);
    let trial = case.run("tbuffer", &machine, wave.then_some(&job), &mut progress);
    let save = std::fs::read_to_string(folder.path().join("wave.gtkw")).unwrap_or_default();
    let markers = save.lines().filter_map(|line| line.strip_prefix("[markername] "));
    // A letter, and blanks that move the name.
    let markers = markers.map(|name| name[1..].trim_start().to_string());
    (trial, machine.runs.into_inner(), markers.collect())
}

#[test]
fn a_fault_is_played_again_for_its_waveform() {
    let (trial, runs, markers) = trial(true, true);
    let Err(BenchError::Failure(failure)) = trial else { panic!("nothing stands still") };
    assert!(matches!(*failure, pellucid_machine::Failure::Deadlock(_)), "{failure}");
    assert_eq!(runs, 2);
    assert_eq!(markers, ["stands still"]);
}

#[test]
fn nothing_is_played_twice_without_need() {
    let (failed, runs, _) = trial(true, false);
    assert!(failed.is_err());
    assert_eq!(runs, 1);
    let (right, runs, markers) = trial(false, true);
    assert!(right.unwrap().verdict.is_right());
    assert_eq!((runs, markers.len()), (1, 0));
}

#[test]
fn machines_of_one_view_share_what_the_golden_model_says() {
    let options = Options { width: Some(20), height: Some(15), ..Options::default() };
    let source = Source::open("glass", &options).unwrap();
    let screen = source.screen();
    let tbuffer = ARCHITECTURE.build(screen, None, &[]).unwrap();
    let mbuffer = mbuffer::ARCHITECTURE.build(screen, None, &[]).unwrap();
    let other = Broken::new(screen, false, true);
    let machines: [&dyn Model; 4] = [&*tbuffer, &other, &*mbuffer, &other];
    let mut progress = Progress::new("", None, true);
    let cases = Case::all("glass", source, &machines, &mut progress).unwrap();
    let shared = |i: usize, k: usize| Arc::ptr_eq(&cases[i].reference, &cases[k].reference);
    assert!(shared(0, 2) && shared(1, 3) && !shared(0, 1));
    assert_eq!([0, 1].map(|k| cases[k].reference.further.len()), [1, 0]);
    assert_eq!(cases[0].items, cases[0].reference.fragments);
    assert_ne!(cases[1].items, cases[1].reference.fragments);
}

/// The cycles of a phase of a frame.
fn cycles(frame: &serde_json::Value, phase: &str) -> u64 {
    frame["cycles"][phase].as_u64().unwrap()
}

#[test]
fn figures_of_frames_add_up_to_those_of_the_run_and_are_each_frames_own() {
    let options = Options { width: Some(20), height: Some(15), ..Options::default() };
    let source = || Source::open("glass", &options).unwrap();
    let machine = ARCHITECTURE.build(source().screen(), None, &[]).unwrap();
    let mut progress = Progress::new("", None, true);
    let case = Case::new("glass", source(), &*machine, &mut progress).unwrap();
    let mut case = case.with_frames(3, &*machine, &mut progress).unwrap();
    for warm_up in [0, 1] {
        case.warm_up = warm_up;
        let report = case.run("tbuffer", &*machine, None, &mut progress).unwrap().report;
        let json = report.json();
        let frames = json["frames"].as_array().unwrap();
        assert_eq!(frames.len(), 3);
        let number = |value: &serde_json::Value| value.as_u64().unwrap();
        for name in ["fragments", "opaque", "transparent", "culled", "transparent_pixels"] {
            let sum: u64 = frames.iter().map(|frame| number(&frame[name])).sum();
            assert_eq!(sum, number(&json["frame"][name]), "{name}");
        }
        let stored: u64 = frames.iter().map(|frame| number(&frame["stored"])).sum();
        assert_eq!(stored, number(&json["fragments"]["stored"]));
        let deepest = frames.iter().map(|frame| number(&frame["max_layers"])).max();
        assert_eq!(deepest, json["frame"]["max_layers"].as_u64());
        for phase in ["total", "store", "resolve", "wait"] {
            let sum: u64 = frames.iter().map(|frame| cycles(frame, phase)).sum();
            assert_eq!(sum, cycles(&json, phase), "{phase}, {warm_up}");
        }
        // Each as it is in a run of its own.
        for (k, frame) in (0..).zip(frames) {
            let source = match k {
                0 => source(),
                _ => source().later(k).unwrap().unwrap(),
            };
            let alone = Case::new("glass", source, &*machine, &mut progress).unwrap();
            let alone = alone.run("tbuffer", &*machine, None, &mut progress).unwrap().report.json();
            assert_eq!(alone["frame"]["fragments"], frame["fragments"]);
            for phase in ["store", "resolve"] {
                assert_eq!(cycles(&alone, phase), cycles(frame, phase), "{phase} of {k}");
            }
            let (fragments, store) = (&frame["fragments"], cycles(frame, "store"));
            for (name, value) in [("fragments", number(fragments)), ("cycles.store", store)] {
                let line = format!("\nframes.{k}.{name},{value},");
                assert!(report.csv().contains(&line), "{line}");
            }
        }
    }
}

/// Whether frames are held or made anew, and for which machines they were made, nothing differs.
#[test]
fn cases_of_one_scene_are_those_of_each_machine_alone() {
    let screen = Screen { width: 24, height: 18, background: 0 };
    let machines =
        [(&ARCHITECTURE, "fast"), (&mbuffer::ARCHITECTURE, "registers"), (&ARCHITECTURE, "paper")]
            .map(|(arch, preset)| (arch, arch.build(screen, Some(preset), &[]).unwrap()));
    let (width, height) = (Some(screen.width), Some(screen.height));
    let source = || {
        let options = Options { width, height, ..Options::default() };
        Source::open("glass", &options).unwrap()
    };
    for frames in [1, 2] {
        let mut progress = Progress::new("", None, true);
        let mut cases = Cases::new("glass", source(), frames);
        for (arch, machine) in &machines {
            let report = |case: Case, progress: &mut Progress| {
                case.run(arch.name, &**machine, None, progress).unwrap().report.json()
            };
            let case = cases.of(&**machine, &mut progress).unwrap();
            let alone = Case::new("glass", source(), &**machine, &mut progress).unwrap();
            let alone = Case { held: None, ..alone };
            let alone = alone.with_frames(frames, &**machine, &mut progress).unwrap();
            assert_eq!(report(case, &mut progress), report(alone, &mut progress), "{}", arch.name);
        }
        let [first, last] =
            [0, 2].map(|k: usize| cases.of(&*machines[k].1, &mut progress).unwrap());
        assert!(Arc::ptr_eq(&first.reference, &last.reference));
    }
}
