use super::*;
use crate::arch::Architecture;
use crate::bench::Bench;
use crate::scene::Options;
use crate::stimulus::Stimulus;
use pellucid_hw::allocator::FreeList;
use pellucid_hw::machine::{Arithmetic, Check, Tally};
use pellucid_hw::params::Value;
use pellucid_hw::pixel::{Fragment, Marked};
use pellucid_hw::primitive::Primitive;
use pellucid_hw::tbuffer::TBuffer;
use pellucid_hw::tbuffer::config::{Config, Params};
use pellucid_sim::netlist::{Module, elaborate};
use std::path::Path;
use std::sync::Mutex;

type Buffer = TBuffer<FreeList>;

/// A T-buffer whose display takes nothing, if it is stuck.
struct Broken {
    cfg: Config,
    stuck: bool,
    /// It sees primitives.
    primitives: bool,
    /// The windows of each run.
    runs: Mutex<Vec<Vec<Window>>>,
}

impl Runnable for Broken {
    fn values(&self) -> Vec<(String, Value)> {
        vec![]
    }
    fn arithmetic(&self) -> Arithmetic {
        Arithmetic::Blend
    }
    fn view(&self, source: &Source) -> Result<View, SourceError> {
        if self.primitives {
            View::new::<Primitive>(None, source)
        } else {
            View::new::<Fragment>(None, source)
        }
    }
    fn run(&self, job: Job) -> Result<Outcome, BenchError> {
        let mut bench = Bench::<Buffer>::new(self.cfg);
        if self.stuck {
            bench.set_display(|_| false);
        }
        let windows = job.wave.map(|wave| wave.windows.clone()).unwrap_or_default();
        self.runs.lock().unwrap().push(windows);
        if let Some(wave) = job.wave {
            bench.record(wave, "machine")?;
        }
        let ((), wave) = bench.traced(|bench| {
            job.source.play(&mut |fragment| bench.send(Marked::item(fragment)))?;
            bench.end_frame()
        })?;
        let images = bench.take_images();
        Ok(Outcome { images, tally: bench.tally(), wave })
    }
    fn netlist(&self) -> Module {
        elaborate::<Buffer>(&self.cfg)
    }
    fn record(&self, _: &Module, _: &Source, _: Stimulus, _: &Path) -> Result<u64, BenchError> {
        Ok(0)
    }
    fn closed_forms(&self, _: &Tally, _: &[Census]) -> Vec<Check> {
        vec![]
    }
}

/// The outcome, the windows of each run, and the first marker of the waveform.
fn trial(stuck: bool, wave: bool) -> (Result<Trial, BenchError>, Vec<Vec<Window>>, String) {
    let options = Options { width: Some(20), height: Some(15), ..Options::default() };
    let source = Source::open("glass", &options).unwrap();
    let cfg = Config::new(source.screen(), Params::default()).unwrap();
    let machine = Broken { cfg, stuck, primitives: false, runs: Mutex::default() };
    let mut progress = Progress::new("", None, true);
    let case = Case::new("glass", source, &machine, &mut progress).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let job = WaveJob::new(&folder.path().join("wave.vcd"), &[Window::Cycles { from: 3, to: 5 }]);
    let trial = case.run("tbuffer", &machine, wave.then_some(&job), &mut progress);
    let save = std::fs::read_to_string(folder.path().join("wave.gtkw")).unwrap_or_default();
    let marker = save.lines().find_map(|line| line.strip_prefix("[markername] A"));
    let runs = machine.runs.into_inner().unwrap();
    (trial, runs, marker.unwrap_or_default().to_string())
}

#[test]
fn a_fault_is_played_again_for_its_waveform() {
    let (trial, runs, marker) = trial(true, true);
    assert!(matches!(trial, Err(BenchError::Deadlock(_))));
    let window = Window::Cycles { from: 3, to: 5 };
    assert_eq!(runs, [vec![window.clone()], vec![window, Window::Failure]]);
    assert_eq!(marker, "stands still");
}

#[test]
fn nothing_is_played_twice_without_need() {
    let (failed, runs, _) = trial(true, false);
    assert!(failed.is_err());
    assert_eq!(runs, [vec![]]);
    let (right, runs, _) = trial(false, true);
    assert!(right.unwrap().verdict.is_right());
    assert_eq!(runs.len(), 1);
}

#[test]
fn machines_of_one_view_share_what_the_golden_model_says() {
    let options = Options { width: Some(20), height: Some(15), ..Options::default() };
    let source = Source::open("glass", &options).unwrap();
    let screen = source.screen();
    let build = |arch| Architecture::named(arch).unwrap().build(screen, None, &[]).unwrap();
    let (tbuffer, mbuffer) = (build("tbuffer"), build("mbuffer"));
    let cfg = Config::new(screen, Params::default()).unwrap();
    let other = Broken { cfg, stuck: false, primitives: true, runs: Mutex::default() };
    let machines: [&dyn Runnable; 4] = [&*tbuffer, &other, &*mbuffer, &other];
    let mut progress = Progress::new("", None, true);
    let cases = Case::all("glass", source, &machines, &mut progress).unwrap();
    let shared = |i: usize, k: usize| Arc::ptr_eq(&cases[i].reference, &cases[k].reference);
    assert!(shared(0, 2) && shared(1, 3) && !shared(0, 1));
    assert!(cases[0].reference.weighted.is_some() && cases[1].reference.weighted.is_none());
    assert_eq!(cases[0].items, cases[0].reference.fragments);
    assert_ne!(cases[1].items, cases[1].reference.fragments);
}
