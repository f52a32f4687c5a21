//! What is found of a block with a fault.

use pellucid_properties::Reference;
use pellucid_properties::harness::{Must, exhaust};
use pellucid_properties::trials::{test, test_long};
use std::cell::Cell;
use std::fmt::Display;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use tempfile::TempDir;

/// States that are searched of each small setup.
const SEARCHED: usize = 100_000;

/// Nothing is wrong.
pub const NONE: u32 = 0;

thread_local! {
    static FAULT: Cell<u32> = const { Cell::new(NONE) };
}

/// What is wrong with the blocks that this thread plays, [`NONE`] if nothing is. Were it a parameter of their types, all that plays and
/// searches would be compiled anew for each of a hundred faults.
pub fn fault() -> u32 {
    FAULT.get()
}

/// Plays with that fault.
pub fn with<T>(fault: u32, play: impl FnOnce() -> T) -> T {
    FAULT.set(fault);
    let played = play();
    FAULT.set(NONE);
    played
}

/// The message of what random sequences find of a fault, and the folder of its waveform.
pub fn found<R: Reference>(fault: u32) -> (String, TempDir) {
    with(fault, || said(|folder| test::<R>("", folder)))
}

/// The message of what long sequences find of a fault, and the folder of its waveform.
pub fn found_long<R: Reference>(fault: u32) -> (String, TempDir) {
    with(fault, || said(|folder| test_long::<R>("", folder)))
}

/// The message of a test that fails, and the folder that it has left.
pub fn said(test: impl FnOnce(&Path)) -> (String, TempDir) {
    let folder = tempfile::tempdir().unwrap();
    let tested = catch_unwind(AssertUnwindSafe(|| test(folder.path())));
    let panic = tested.expect_err("it is not found");
    (panic.downcast_ref::<String>().unwrap().clone(), folder)
}

/// Random sequences and the search find the fault, and name what it breaks.
pub fn is_found<R: Reference>(fault: u32, property: R::Property) {
    let (message, _) = found::<R>(fault);
    assert!(message.contains(&format!(": {property}: ")), "{message}");
    let search = |setup: &R::Setup| exhaust::<R>(setup, SEARCHED).err();
    let found = with(fault, || R::small().iter().find_map(search));
    let (broken, steps) = found.expect("the search does not find it");
    assert_eq!(broken.property, Must::Keep(property), "{broken}, after {steps:?}");
}

/// The waveform leads to where a property is broken.
pub fn has_marker(folder: &TempDir, property: impl Display) {
    let save = std::fs::read_to_string(folder.path().join("wave.gtkw")).unwrap();
    let mut names = save.lines().filter_map(|line| line.strip_prefix("[markername] A"));
    // One near the left edge has blanks before it.
    assert_eq!(names.next().map(str::trim_start), Some(&property.to_string()[..]), "{save}");
}

/// The values of a signal in the waveform, each with the cycle in which it begins.
pub fn shown(folder: &TempDir, signal: &str) -> Vec<(u64, u64)> {
    let mut wave = wellen::simple::read(folder.path().join("wave.vcd")).unwrap();
    let name = format!("top.{signal}");
    let signal = {
        let hierarchy = wave.hierarchy();
        let mut vars = hierarchy.all_vars().map(|var| &hierarchy[var]);
        let found = vars.find(|var| var.full_name(hierarchy) == name);
        found.unwrap_or_else(|| panic!("there is no `{name}`")).signal_ref()
    };
    wave.load_signals(&[signal]);
    let times = wave.time_table().to_vec();
    let changes = wave.get_signal(signal).unwrap().iter_changes();
    changes
        .map(|(at, value)| {
            let bits = value.to_bit_string().unwrap();
            (times[at as usize] / 10, u64::from_str_radix(&bits, 2).unwrap())
        })
        .collect()
}
