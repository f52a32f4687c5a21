//! What a run's waveform shows.

use super::*;
use std::collections::BTreeSet;
use wellen::simple::Waveform;
use wellen::{SignalRef, SignalValueRef};

/// A waveform as `wellen` reads it.
pub struct Wave {
    wave: Waveform,
    pub signals: BTreeMap<String, SignalRef>,
}

impl Wave {
    pub fn read(path: &Path) -> Wave {
        let mut wave = wellen::simple::read(path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
        let hierarchy = wave.hierarchy();
        let vars = hierarchy.all_vars().map(|var| &hierarchy[var]);
        let signals: BTreeMap<String, SignalRef> =
            vars.map(|v| (v.full_name(hierarchy), v.signal_ref())).collect();
        wave.load_signals(&signals.values().copied().collect::<Vec<_>>());
        Wave { wave, signals }
    }

    /// A signal's changes: the cycle in which they begin, and what it shows as bits or as text.
    pub fn changes(&self, name: &str) -> Vec<(u64, String)> {
        let signal = self.signals.get(name).unwrap_or_else(|| panic!("there is no {name}"));
        let times = self.wave.time_table();
        let changes = self.wave.get_signal(*signal).unwrap().iter_changes();
        let text = |value: SignalValueRef| match value {
            SignalValueRef::String(text) => text.to_string(),
            value => value.to_bit_string().unwrap(),
        };
        changes.map(|(at, value)| (times[at as usize] / 10, text(value))).collect()
    }

    /// The cycles that are shown.
    pub fn cycles(&self) -> Vec<u64> {
        let numbers = self.changes("top.cycle").into_iter();
        numbers.filter_map(|(_, bits)| u64::from_str_radix(&bits, 2).ok()).collect()
    }

    /// Everything that it says, but for labels, which are of two kinds in the two formats.
    fn all(&self) -> BTreeMap<&String, Vec<(u64, String)>> {
        let bits = self.signals.keys().filter(|name| !name.ends_with(".label"));
        bits.map(|name| (name, self.changes(name))).collect()
    }
}

/// Runs the small frame; gives what it says and its waveform.
fn waved(args: &[&str]) -> (String, Wave) {
    let folder = folder();
    let output = exact(run(folder.path(), args));
    let fst = folder.path().join("pellucid-out/wave.fst");
    let path = if fst.exists() { fst } else { folder.path().join("pellucid-out/wave.vcd") };
    (stdout(&output).to_string(), Wave::read(&path))
}

#[test]
fn both_formats_say_the_same() {
    let window = ["--wave", "5..60,1000..1100"];
    let [(_, vcd), (_, fst)] =
        ["vcd", "fst"].map(|format| waved(&[&window[..], &["--wave-format", format]].concat()));
    let (vcd, fst) = (vcd.all(), fst.all());
    assert!(vcd.len() > 200, "only {} signals", vcd.len());
    // An FST begins with time 0, at which nothing is known.
    let known = |changes: &[(u64, String)]| -> Vec<(u64, String)> {
        let from = changes.iter().position(|(_, value)| !value.contains('x'));
        changes[from.unwrap_or(0)..].to_vec()
    };
    for (name, changes) in &vcd {
        assert_eq!(known(changes), known(&fst[name]), "{name}");
    }
    assert_eq!(vcd.keys().collect::<Vec<_>>(), fst.keys().collect::<Vec<_>>());
}

/// The line that tells of a marker in a cycle below a million.
fn marker(letter: char, cycle: u64, name: &str) -> String {
    let (thousands, rest) = (cycle / 1000, cycle % 1000);
    let cycle = if thousands > 0 { format!("{thousands},{rest:03}") } else { rest.to_string() };
    format!("\n  {letter} cycle {cycle:>12}  {name}\n")
}

/// Where the fragment is, cycle by cycle: each label's signal with the cycles in which it is shown there.
pub fn places(wave: &Wave, label: &str) -> BTreeMap<String, Vec<u64>> {
    let mut places = BTreeMap::new();
    for name in wave.signals.keys().filter(|name| name.ends_with(".label")) {
        let shown = wave.changes(name);
        let cycles = shown.iter().filter(|(_, text)| text == label).map(|(cycle, _)| *cycle);
        let cycles: Vec<u64> = cycles.collect();
        if !cycles.is_empty() {
            places.insert(name.trim_start_matches("top.machine.").to_string(), cycles);
        }
    }
    places
}

#[test]
fn a_fragment_is_followed_through_its_whole_life() {
    let (said, wave) = waved(&["--follow-fragment", "100"]);
    let (_, whole) = waved(&["--wave", "all"]);
    let first = whole.changes("top.machine.wires.fragment.label");
    let (_, label) = first.iter().find(|(_, label)| label.starts_with("#100(")).unwrap();
    let (here, there) = (places(&wave, label), places(&whole, label));
    assert_eq!(here, there, "it is shown wherever it is");
    let stages: BTreeSet<&str> = here.keys().map(String::as_str).collect();
    for stage in [
        "wires.fragment.label",
        "registers.front.depth_test.stage.label",
        "wires.passed.label",
        "registers.chains.store.stage.label",
        "wires.chains.arrived.label",
        "registers.sorter.entries[0].label",
        "wires.sorted.label",
        "registers.blender.stage.label",
    ] {
        assert!(stages.contains(stage), "it was not seen in {stage}: {stages:?}");
    }
    let cycles = wave.cycles();
    assert!(cycles.len() < 100, "{} cycles are shown", cycles.len());
    let comes = here["wires.fragment.label"][0];
    let resolved = here["wires.chains.arrived.label"][0];
    assert_eq!(cycles[0], comes - 10);
    assert!(cycles.contains(&resolved));
    assert!(said.contains(&marker('A', comes, &format!("{label} store"))), "{said}");
}

#[test]
fn a_pixel_is_followed() {
    let (said, wave) = waved(&["--follow-pixel", "20,15"]);
    let (_, whole) = waved(&["--wave", "all"]);
    let labels = |wave: &Wave| -> BTreeSet<String> {
        let all = wave.changes("top.machine.wires.fragment.label").into_iter();
        all.map(|(_, label)| label).filter(|label| label.ends_with("(20,15)")).collect()
    };
    let expected = labels(&whole);
    assert!(expected.len() > 1, "{expected:?}");
    assert_eq!(labels(&wave), expected);
    for label in &expected {
        assert_eq!(places(&wave, label), places(&whole, label));
        assert!(said.contains(&format!("{label} store")), "{said}");
    }
}

#[test]
fn the_first_long_stall_is_shown_with_what_led_to_it() {
    // The R-buffer's replies from outside memory are slow: its queue is not ready for long.
    let args = ["--arch", "tbuffer", "-p", "outside_latency=1", "--wave"];
    let (said, wave) = waved(&[&args[..], &["stall:1"]].concat());
    let (_, whole) = waved(&[&args[..], &["all"]].concat());
    // The first stall of two cycles or more, among all streams.
    let mut first = None;
    for name in whole.signals.keys().filter(|name| name.ends_with(".stall")) {
        let changes = whole.changes(name);
        for pair in changes.windows(2).filter(|pair| pair[0].1 == "1") {
            let (from, to) = (pair[0].0, pair[1].0);
            if to - from > 1 {
                let stream = name.rsplit('.').nth(1).unwrap();
                let found = (from + 1, from, stream.to_string());
                first =
                    Some(first.map_or(found.clone(), |known: (u64, u64, String)| known.min(found)));
            }
        }
    }
    let (_, from, stream) = first.expect("there is a long stall");
    assert!(said.contains(&format!("{stream} stalls\n")), "{said}");
    assert_eq!(wave.cycles()[0], from.saturating_sub(20));
    assert!(wave.cycles().len() < 200);
}

#[test]
fn what_did_not_come_is_said() {
    let folder = folder();
    let waits =
        ["--wave", "stall:9000,event:dropped,900000..900001,store", "--follow-pixel", "0,0"];
    let output = run(folder.path(), &waits);
    assert_eq!(output.status.code(), Some(0));
    let said = stderr(&output);
    for note in [
        "note: window stall:9000: no stream stalled for more than 9000 cycles; the longest stall is that of `",
        "note: window event:dropped: `dropped` did not happen\n",
        "note: window 900000..900001: the run has ",
        "note: no fragment came to pixel 0,0\n",
    ] {
        assert!(said.contains(note), "{said}");
    }
    assert_eq!(said.lines().count(), 4, "{said}");
}

#[test]
fn a_run_that_loses_fragments_shows_the_first() {
    let folder = folder();
    let few = ["-p", "sections=10", "-p", "outside_sections=0"];
    let output = run(folder.path(), &[&few[..], &["--wave", "0..1"]].concat());
    assert_eq!(output.status.code(), Some(1));
    let wave = Wave::read(&folder.path().join("pellucid-out/wave.vcd"));
    let dropped = wave.changes("top.machine.wires.chains.events.dropped");
    let first = dropped.iter().find(|(_, value)| value == "1").unwrap().0;
    let said = stdout(&output);
    assert!(said.contains(&marker('A', first, "dropped")), "{said}");
    let before: Vec<u64> = wave.cycles().into_iter().filter(|c| *c > 0 && *c < first).collect();
    assert_eq!(before, (first.saturating_sub(20).max(1)..first).collect::<Vec<_>>());
    let allowed = run(folder.path(), &[&few[..], &["--wave", "0..1", "--allow-drops"]].concat());
    assert_eq!(allowed.status.code(), Some(0));
    let wave = Wave::read(&folder.path().join("pellucid-out/wave.vcd"));
    assert_eq!(wave.cycles(), [0]);
}

#[test]
fn only_the_selected_signals_and_words_are_there() {
    let (_, wave) = waved(&[
        "--wave",
        "all",
        "--wave-scope",
        "wires.events,*.sorter.count,memories",
        "--wave-memory",
        "chains.ssa.table:5..7,chains.nsa.*:0..3",
    ]);
    let names: BTreeSet<&str> =
        wave.signals.keys().filter_map(|name| name.strip_prefix("top.machine.")).collect();
    let expected = [
        "memories.chains.nsa.table.word[0].next",
        "memories.chains.nsa.table.word[1].next",
        "memories.chains.nsa.table.word[2].next",
        "memories.chains.ssa.table.word[5].head",
        "memories.chains.ssa.table.word[5].tail",
        "memories.chains.ssa.table.word[5].fill",
        "memories.chains.ssa.table.word[6].head",
        "registers.sorter.count",
        "wires.events.blended",
    ];
    for name in expected {
        assert!(names.contains(name), "{name} is not in {names:?}");
    }
    assert_eq!(names.iter().filter(|name| name.starts_with("memories")).count(), 3 + 2 * 3);
    assert_eq!(names.iter().filter(|name| name.starts_with("registers")).count(), 1);
}

/// The words of a memory are what its writes have made of them.
#[test]
fn words_follow_the_writes() {
    // A pixel with five fragments of three a section: its SSA entry goes from NULL to a second section.
    let folder = folder();
    let trace: String = (1..=5).map(|z| format!("0,0,{z},1,2,3,128\n")).collect();
    let trace =
        format!("# pellucid-trace width=1 height=1 background=0,0,0\nx,y,z,r,g,b,a\n{trace}");
    fs::write(folder.path().join("t.csv"), trace).unwrap();
    let args = ["run", "--scene", "t.csv", "--preset", "paper", "--wave", "all", "--wave-memory"];
    let memory = "chains.ssa.table,chains.sections.on_chip:0..3";
    exact(pellucid(folder.path(), &[&args[..], &[memory, "-p", "section_capacity=3"]].concat()));
    let wave = Wave::read(&folder.path().join("pellucid-out/wave.vcd"));
    let values = |name: &str| -> Vec<u64> {
        let name = format!("top.machine.memories.chains.{name}");
        let changes = wave.changes(&name).into_iter();
        changes.map(|(_, bits)| u64::from_str_radix(&bits, 2).unwrap()).collect()
    };
    let heads = values("ssa.table.word[0].head");
    assert_eq!(heads.len(), 3, "NULL, the first section, NULL: {heads:?}");
    assert_eq!(heads[0], heads[2]);
    for (slot, z) in [(0, 1), (1, 2), (2, 3)] {
        assert_eq!(values(&format!("sections.on_chip.word[{slot}].z")), [0, z]);
    }
}

#[test]
fn what_cannot_be_shown_is_refused() {
    let folder = folder();
    let refused = |args: &[&str], message: &str| {
        refused(folder.path(), &[&["run"], &SMALL[..], args].concat(), message);
        assert!(names(&folder.path().join("pellucid-out")).is_empty(), "{args:?}");
    };
    fs::create_dir(folder.path().join("pellucid-out")).unwrap();
    let fragments = 2266;
    refused(
        &["--follow-fragment", "1000000"],
        &format!("--follow-fragment 1000000: the frame has {fragments} fragments, numbered from 0"),
    );
    refused(
        &["--follow-pixel", "40,2"],
        "--follow-pixel 40,2: the screen has 40 columns and 30 rows",
    );
    refused(
        &["--follow-pixel", "7"],
        "invalid value '7' for '--follow-pixel <X,Y>': expected a column and a row, as in `3,4`",
    );
    refused(
        &["--wave-scope", "register.*"],
        "--wave-scope: `register.*` fits no signal; there is `wires.events.frame_done`, for instance",
    );
    refused(
        &["--wave-memory", "chains.ssa"],
        "--wave-memory: there is no memory `chains.ssa` (did you mean `chains.ssa.table`?); there are \
         `front.depth_test.queue`, `front.display.frame_buffer.depth_a`, \
         `front.display.frame_buffer.depth_b`, `front.display.frame_buffer.colour_a`, \
         `front.display.frame_buffer.colour_b`, `front.display.scanout.queue`, \
         `chains.ssa.table`, `chains.nsa.table`, `chains.sections.on_chip`, \
         `chains.answers.on_chip`, `chains.answers.outside`, `chains.pool.on_chip`, \
         `chains.pool.outside`, `chains.occupancy.bitmap`, \
         `chains.occupancy.summary`, `chains.store.queue`, `chains.read_back.lookup.queue`, \
         `chains.read_back.reader.chains`, `chains.read_back.reader.pending`, \
         `chains.read_back.reader.arrived`, `chains.read_back.release.queue`, \
         `chains.sections.outside`",
    );
    refused(
        &["--wave-memory", "chains.ssa.table:0..1201"],
        "--wave-memory: `chains.ssa.table` has 1200 words, numbered from 0",
    );
    refused(
        &["--wave-memory", "chains.ssa.table:7"],
        "invalid value 'chains.ssa.table:7' for '--wave-memory <WORDS>': expected PATH or PATH:FROM..TO \
         with FROM below TO",
    );
    refused(
        &["--wave", "event:droped"],
        "--wave: there is no event `droped` (did you mean `dropped`?); there are `stored`, `spilled`, \
         `first`, `section_taken`, `dropped`, `waits`, `compared`, `weight_changed`, `chain_begun`, `read`, \
         `read_again`, `culled_late`, `ssa_hit`, `ssa_miss`, `ssa_write_back`, `drawn`, `hidden`, `culled_early`, `blended`, `scanout`, `frame_done`",
    );
}

/// More signals than the FST's writer gathers for a block before anything has changed.
#[test]
fn an_fst_may_have_many_signals() {
    let folder = folder();
    let many = ["--arch", "composer", "-p", "engines=128", "--wave", "0..40,100..110"];
    exact(run(folder.path(), &[&many[..], &["--wave-format", "fst", "-q"]].concat()));
    let wave = Wave::read(&folder.path().join("pellucid-out/wave.fst"));
    assert!(wave.signals.len() > 16_384, "only {} signals", wave.signals.len());
    assert_eq!(wave.cycles(), (0..40).chain(100..110).collect::<Vec<_>>());
}

/// Seed 001, figure 6: while one frame is drawn, the one before is composed, and the one before that is shown.
#[test]
fn three_frames_are_in_flight() {
    const FRAMES: usize = 4;
    let frames = FRAMES.to_string();
    let wires = "wires.draws,wires.merges,wires.composes,wires.shows,wires.swap";
    let all = ["--arch", "composer", "--frames", &frames, "--wave", "all", "--wave-scope", wires];
    // Composing is to take longer than drawing.
    let long = ["--scene", "teapot", "-p", "beta=1000"];
    let (_, wave) = waved(&[&all[..], &long].concat());
    // From when until when a wire is high, each time; until the end of the run where it stays high.
    let high = |wire: &str| -> Vec<(u64, u64)> {
        let changes = wave.changes(&format!("top.machine.wires.{wire}"));
        let ends = changes.iter().skip(1).map(|(cycle, _)| *cycle).chain([u64::MAX]);
        let ranges = changes.iter().zip(ends).filter(|((_, bit), _)| bit == "1");
        ranges.map(|((from, _), to)| (*from, to)).collect()
    };
    let [draws, merges, composes, shows, swap] =
        ["draws", "merges", "composes", "shows", "swap"].map(high);
    let each = [&draws, &merges, &composes, &shows, &swap];
    assert_eq!(each.map(Vec::len), [FRAMES; 5], "{each:?}");
    for frame in 0..FRAMES {
        // Drawn until the swap or before it, then merged and composed, then shown.
        let swapped = swap[frame].1;
        assert!(draws[frame].1 < swapped, "{each:?}");
        assert_eq!((merges[frame].0, composes[frame].0), (swapped, swapped), "{each:?}");
        assert!(merges[frame].1 < composes[frame].1, "{each:?}");
        assert_eq!(shows[frame].0, composes[frame].1, "{each:?}");
        // The next one is begun at once.
        if let Some((next, _)) = draws.get(frame + 1) {
            assert_eq!(*next, swapped, "{each:?}");
        }
    }
    // All three at once.
    let together = |frame: usize| {
        let at_once = [shows[frame], composes[frame + 1], draws[frame + 2]];
        let from = at_once.iter().map(|(from, _)| *from).max();
        from < at_once.iter().map(|(_, to)| *to).min()
    };
    assert!((0..FRAMES - 2).all(together), "{each:?}");
}

/// The help names the events of all machines, and no other.
#[test]
fn the_help_names_the_events_and_how_long_a_stall_can_be() {
    let folder = folder();
    let help = exact(pellucid(folder.path(), &["run", "--help"]));
    let help: Vec<&str> = stdout(&help).split_whitespace().collect();
    let help = help.join(" ");
    assert!(help.contains("N from 1 to 10000; `event:NAME`"), "{help}");
    let (_, named) = help.split_once("the first time that the event happens: ").unwrap();
    let (named, _) = named.split_once(", as far as").unwrap();
    let named: BTreeSet<&str> = named.split(", ").collect();
    let mut known = BTreeSet::new();
    let stores = ["tbuffer", "rbuffer"].map(|store| format!("transparency={store}"));
    let composers = stores.iter().map(|store| vec!["--arch", "composer", "-p", store]);
    let machines = ["tbuffer", "rbuffer", "mbuffer", "dfb", "b3d", "ppll", "fbuffer", "accumulate"]
        .map(|arch| vec!["--arch", arch]);
    // A frame buffer outside has events of its own.
    let outside = [vec!["-p", "framebuffer=cached"]];
    for machine in machines.into_iter().chain(composers).chain(outside) {
        let output = run(folder.path(), &[&machine[..], &["--wave", "event:?"]].concat());
        let said = stderr(&output);
        let (_, events) = said.trim_end().split_once("there are ").unwrap();
        known.extend(events.split(", ").map(str::to_string));
    }
    assert_eq!(named, known.iter().map(String::as_str).collect());
    refused(
        folder.path(),
        &[&["run"], &SMALL[..], &["--arch", "composer", "--wave", "event:read"]].concat(),
        "--wave: there is no event `read`; the machine has none",
    );
}
