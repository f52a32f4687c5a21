//! A model at fault is shown with the cycles before, up to the cycle at fault.

use pellucid_machine::board::Fixed;
use pellucid_machine::pixel::{Fragment, Screen};
use pellucid_machine::{Failure, Item, Offer};
use pellucid_machine_properties::frames::Setup;
use pellucid_sim::Label;
use pellucid_tbuffer::architecture::ARCHITECTURE;
use pellucid_testbench::bench::{Bench, BenchError};
use pellucid_testbench::recorder::WaveJob;
use pellucid_testbench::window::Window;
use proptest::test_runner::TestCaseError;
use std::path::Path;
use tempfile::TempDir;

const SCREEN: Screen = Screen { width: 60, height: 40, background: 0 };

fn setup() -> Setup {
    Setup::free(&ARCHITECTURE, SCREEN, vec![])
}

fn bench(folder: &TempDir) -> Bench {
    let mut bench = Bench::new(&*setup().model);
    let job = WaveJob::new(&folder.path().join("wave.vcd"), &[Window::Failure]);
    bench.record(&job, "machine").unwrap();
    bench
}

fn fragment(k: u32) -> Fragment {
    Fragment { x: k % 60, y: k / 60 % 40, z: k % 90, rgba: k << 8 | 0x80, label: Label::NONE }
}

fn item(k: u32) -> Item {
    fragment(k).into()
}

/// What is wrong with the model.
fn failure<T>(done: Result<T, BenchError>) -> Failure {
    match done {
        Err(BenchError::Failure(failure)) => *failure,
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("nothing is wrong"),
    }
}

/// The cycles that a waveform shows, and the changes of one of its signals: in which cycle, to which value.
fn read(path: &Path, signal: &str) -> (Vec<u64>, Vec<(u64, String)>) {
    let mut wave = wellen::simple::read(path).unwrap();
    let hierarchy = wave.hierarchy();
    let find = |name: &str| {
        let mut vars = hierarchy.all_vars().map(|var| &hierarchy[var]);
        vars.find(|var| var.full_name(hierarchy) == name).unwrap().signal_ref()
    };
    let (cycle, signal) = (find("top.cycle"), find(signal));
    wave.load_signals(&[cycle, signal]);
    let times = wave.time_table().to_vec();
    let changes = |signal| -> Vec<(u64, String)> {
        let changes = wave.get_signal(signal).unwrap().iter_changes();
        changes.map(|(at, v)| (times[at as usize] / 10, v.to_bit_string().unwrap())).collect()
    };
    let cycles = changes(cycle).into_iter();
    let cycles = cycles.filter_map(|(_, bits)| u64::from_str_radix(&bits, 2).ok()).collect();
    (cycles, changes(signal))
}

/// The cycle of the first marker, with its name.
fn marker(folder: &TempDir) -> (u64, String) {
    let save = std::fs::read_to_string(folder.path().join("wave.gtkw")).unwrap();
    let line =
        |start: &str| save.lines().find_map(|line| line.strip_prefix(start)).unwrap().to_string();
    let time: u64 = line("*").split(' ').nth(1).unwrap().parse().unwrap();
    (time / 10, line("[markername] A").trim_start().to_string())
}

#[test]
fn a_fault_is_shown_with_its_cycle_and_a_thousand_before() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = bench(&folder);
    let mut sent = 0;
    let done = bench.traced(|bench| {
        (0..1500).try_for_each(|k| bench.send(&item(k)))?;
        sent = bench.cycles();
        // Far from the screen: no register has so many bits, no memory such a word.
        bench.send(&Fragment { x: 9000, ..fragment(0) }.into())?;
        bench.end_frame()
    });
    let Err(BenchError::Failure(failure)) = done else { panic!("no fault is found") };
    let Failure::Fault(fault) = *failure else { panic!("{failure}") };
    let found = fault.to_string();
    assert!(found.contains("is beyond its") || found.contains("does not fit its"), "{found}");
    let path = folder.path().join("wave.vcd");
    let (cycles, x) = read(&path, "top.machine.wires.fragment.payload.item.x");
    // Reset takes the cycles before the first in which the machine is ready.
    let ready = sent - 1500;
    let last = fault.cycle - ready;
    assert_eq!(*cycles.last().unwrap(), last);
    assert_eq!(cycles, (cycles[0]..=last).collect::<Vec<_>>());
    assert_eq!(cycles.len(), 1000);
    assert!(x.len() > 500, "the cycles before are as they were");
    assert_eq!(marker(&folder), (last, format!("fault in {}", fault.path)));
}

#[test]
fn a_stand_still_is_shown_with_what_led_to_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = bench(&folder);
    bench.set_display(|_| false);
    let done = bench.traced(|bench| {
        (0..1500).try_for_each(|k| bench.send(&item(k)))?;
        bench.end_frame()
    });
    assert!(matches!(failure(done), Failure::Deadlock(_)));
    let path = folder.path().join("wave.vcd");
    let (cycles, valid) = read(&path, "top.machine.wires.image.valid");
    let (at, name) = marker(&folder);
    assert_eq!(name, "stands still");
    assert!(bench.cycles() > at + 100_000, "it stood still for long");
    // The image is offered from then on, for ever.
    let (offered, value) = valid.last().unwrap();
    assert_eq!((value.as_str(), cycles[0] < *offered), ("1", true));
    assert!(at - offered < 10, "offered in {offered}, nothing moves from {at} on");
    assert!(cycles.contains(&at) && cycles.len() > 1000);
}

/// How long nothing may move follows from the memory.
#[test]
fn a_memory_that_takes_a_millisecond_is_no_stand_still() {
    let outside = vec![("sections", "1".to_string())];
    let setup = Setup::free(&ARCHITECTURE, SCREEN, outside);
    let frame: Vec<Fragment> = (0..100).map(fragment).collect();
    let mut bench = Bench::new(&*setup.model);
    bench.set_timing(Box::new(Fixed::new(1_000_000)));
    bench
        .traced(|bench| {
            frame.iter().try_for_each(|fragment| bench.send(&(*fragment).into()))?;
            bench.end_frame()?;
            bench.wait_for(1, |_, _| Ok(()))
        })
        .unwrap();
    assert!(bench.cycles() > 1_000_000);
    assert_eq!(bench.take_images()[0], setup.golden_image(&frame));
    // A display that takes nothing is one as ever.
    bench.set_display(|_| false);
    let done = bench.traced(|bench| {
        frame.iter().try_for_each(|fragment| bench.send(&(*fragment).into()))?;
        bench.end_frame()?;
        bench.wait_for(1, |_, _| Ok(()))
    });
    assert!(matches!(failure(done), Failure::Deadlock(_)));
}

#[test]
#[cfg(debug_assertions)]
fn a_stream_that_breaks_its_rules_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = bench(&folder);
    let done = bench.traced(|bench| {
        (0..200).try_for_each(|k| bench.send(&item(k)))?;
        while !bench.step(Offer::End)? {}
        // The machine is not ready for the next frame: what is offered must stay.
        bench.step(Offer::Item(&item(1)))?;
        bench.step(Offer::Item(&item(2)))
    });
    assert!(matches!(failure(done), Failure::Violation(_)));
    let (cycles, x) =
        read(&folder.path().join("wave.vcd"), "top.machine.wires.fragment.payload.item.x");
    let last = *cycles.last().unwrap();
    assert_eq!(marker(&folder), (last, "fragment breaks a rule".to_string()));
    let wide = |x: u64| format!("{x:06b}");
    assert_eq!(x[x.len() - 2..], [(last - 1, wide(1)), (last, wide(2))]);
}

#[test]
fn an_assertion_that_fails_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = bench(&folder);
    let done = bench.traced(|bench| {
        (0..100).try_for_each(|k| bench.send(&item(k)))?;
        assert_eq!(bench.cycles(), 0, "as a block might assert");
        Ok(())
    });
    let Err(error) = done else { panic!("it holds") };
    let text = error.to_string();
    assert!(text.starts_with("fault in the model: an assertion failed: "), "{text}");
    assert!(text.contains("as a block might assert"), "{text}");
    let (cycles, _) = read(&folder.path().join("wave.vcd"), "top.machine.wires.image.valid");
    assert_eq!(cycles, (0..100).collect::<Vec<_>>());
    assert_eq!(marker(&folder), (99, "assertion fails".to_string()));
}

#[test]
fn a_waveform_without_that_window_ends_as_it_would() {
    let folder = tempfile::tempdir().unwrap();
    let mut bench = Bench::new(&*setup().model);
    let path = folder.path().join("wave.vcd");
    bench.record(&WaveJob::new(&path, &[Window::Cycles { from: 2, to: 5 }]), "machine").unwrap();
    let done = bench.traced(|bench| {
        bench.send(&Fragment { x: 9000, ..fragment(0) }.into())?;
        bench.end_frame()
    });
    assert!(matches!(failure(done), Failure::Fault(_)));
    assert!(path.exists());
}

/// What is wrong with the model is said even where it cannot be shown.
#[cfg(unix)]
#[test]
fn a_fault_is_told_without_its_waveform() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wave.vcd");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    // Nobody reads on behind the header.
    let pipe = path.clone();
    let reader = std::thread::spawn(move || std::fs::File::open(pipe).unwrap());
    let mut bench = bench(&folder);
    drop(reader.join().unwrap());
    let done = bench.traced(|bench| {
        (0..100).try_for_each(|k| bench.send(&item(k)))?;
        bench.send(&Fragment { x: 9000, ..fragment(0) }.into())?;
        bench.end_frame()
    });
    let Err(BenchError::Unseen { fault, lost }) = done else { panic!("it is shown") };
    assert!(matches!(failure::<()>(Err(*fault)), Failure::Fault(_)));
    assert_eq!(lost.to_string(), format!("cannot write `{}`: Broken pipe", path.display()));
}

/// A test that fails keeps the waveform of its frames and says where.
#[test]
fn a_test_that_fails_keeps_its_waveform() {
    let setup = setup();
    let frames = [(0..300).map(fragment).collect::<Vec<_>>()];
    let done = setup.judged(&frames, || Err(TestCaseError::fail("not right")));
    let Err(TestCaseError::Fail(reason)) = done else { panic!("it passes") };
    let (what, path) = reason.message().split_once("\nits waveform: ").unwrap();
    assert_eq!(what, "not right");
    let (cycles, _) = read(Path::new(path), "top.machine.wires.image.valid");
    let setup_cycles = setup.run(&frames).unwrap().tally.cycles;
    assert_eq!(cycles, (0..cycles.len() as u64).collect::<Vec<_>>());
    assert!(cycles.len() as u64 > setup_cycles.total);
    assert!(setup.judged(&frames, || Ok(())).is_ok());
}
