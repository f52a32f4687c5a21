//! What a run's waveform shows, and what is left of it when it cannot be finished.

use super::*;
use std::collections::BTreeSet;
use wellen::simple::Waveform;
use wellen::{SignalRef, SignalValueRef};

/// A waveform as `wellen` reads it.
struct Wave {
    wave: Waveform,
    signals: BTreeMap<String, SignalRef>,
}

impl Wave {
    fn read(path: &Path) -> Wave {
        let mut wave = wellen::simple::read(path).unwrap_or_else(|e| panic!("{path:?}: {e}"));
        let hierarchy = wave.hierarchy();
        let vars = hierarchy.all_vars().map(|var| &hierarchy[var]);
        let signals: BTreeMap<String, SignalRef> =
            vars.map(|v| (v.full_name(hierarchy), v.signal_ref())).collect();
        wave.load_signals(&signals.values().copied().collect::<Vec<_>>());
        Wave { wave, signals }
    }

    /// A signal's changes: the cycle in which they begin, and what it shows as bits or as text.
    fn changes(&self, name: &str) -> Vec<(u64, String)> {
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
    fn cycles(&self) -> Vec<u64> {
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
fn places(wave: &Wave, label: &str) -> BTreeMap<String, Vec<u64>> {
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
        "registers.depth_test.stage.label",
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
         `chains.ssa.table`, `chains.nsa.table`, `chains.sections.on_chip`, `chains.sections.outside`, \
         `chains.pool.on_chip`, `chains.pool.outside`, `chains.occupancy.bitmap`, \
         `chains.occupancy.summary`, `chains.store.queue`, `chains.read_back.lookup.queue`, \
         `chains.read_back.reader.chains`, `chains.read_back.reader.pending`, \
         `chains.read_back.reader.arrived`, `chains.read_back.release.queue`, \
         `display.frame_buffer.depth_a`, `display.frame_buffer.depth_b`, \
         `display.frame_buffer.colour_a`, `display.frame_buffer.colour_b`, `display.scanout.queue`, \
         `depth_test.queue`",
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
         `read_again`, `culled_late`, `drawn`, `hidden`, `culled_early`, `blended`, `scanout`, `frame_done`",
    );
}

/// The bundle of a run is whole in either format, and made of these files.
#[test]
fn the_bundle_has_a_set_up_for_either_viewer() {
    for (format, file) in [("vcd", "wave.vcd"), ("fst", "wave.fst")] {
        let folder = folder();
        exact(run(folder.path(), &["--wave-format", format, "-q"]));
        let out = folder.path().join("pellucid-out");
        let expected = [
            ".surfer",
            "image.png",
            "stats.csv",
            "stats.json",
            file,
            "wave.gtkw",
            "wave.states",
            "wave.sucl",
        ];
        let mut expected = expected.map(str::to_string);
        expected.sort();
        assert_eq!(names(&out), expected);
        let save = fs::read_to_string(out.join("wave.gtkw")).unwrap();
        assert!(save.starts_with(&format!("[dumpfile] \"{file}\"\n")));
        for line in save.lines().filter_map(|line| line.strip_prefix('^')) {
            let filter = line.split_once(' ').unwrap().1;
            assert!(out.join(filter).is_file(), "{filter}");
        }
        let commands = fs::read_to_string(out.join("wave.sucl")).unwrap();
        let wave = Wave::read(&out.join(file));
        let variables = commands.lines().filter_map(|line| line.strip_prefix("variable_add "));
        let known: BTreeSet<String> =
            wave.signals.keys().map(|name| name.replace(".[", "[")).collect();
        for variable in variables {
            assert!(known.contains(variable), "{variable}");
        }
        let mappings = names(&out.join(".surfer/mappings"));
        for name in mappings.iter().map(|name| name.strip_suffix(".txt").unwrap()) {
            assert!(commands.contains(&format!("item_set_format {name}\n")), "{name}");
        }
    }
}

/// A disk that is full, or a limit on a file's size: what was written can be opened.
#[cfg(target_os = "linux")]
#[test]
fn a_waveform_that_does_not_fit_is_kept_as_far_as_it_goes() {
    for (format, blocks) in [("vcd", "2000"), ("fst", "300")] {
        let folder = folder();
        let command = format!(
            "trap '' XFSZ; ulimit -f {blocks}; exec '{}' run --width 160 --height 120 --wave all --quiet \
             --wave-format {format}",
            env!("CARGO_BIN_EXE_pellucid")
        );
        let output =
            Command::new("sh").args(["-c", &command]).current_dir(folder.path()).output().unwrap();
        let out = Path::new("pellucid-out");
        let (path, partial) = (format!("wave.{format}"), format!("wave.partial.{format}"));
        assert_eq!(
            stderr(&output),
            format!(
                "error: cannot write `{}`: File too large; what was written until then is `{}`\n",
                out.join(path).display(),
                out.join(&partial).display()
            )
        );
        assert_eq!(output.status.code(), Some(2));
        assert_eq!(names(&folder.path().join(out)), [&*partial]);
        let wave = Wave::read(&folder.path().join(out).join(partial));
        let cycles = wave.cycles();
        assert!(cycles.len() > 1000, "{} cycles", cycles.len());
        assert_eq!(cycles, (0..cycles.len() as u64).collect::<Vec<_>>());
    }
}

/// A process that is killed leaves what it wrote; one that is told to stop says where.
#[cfg(unix)]
#[test]
fn a_waveform_of_a_run_that_is_stopped_can_be_opened() {
    use std::process::Stdio;
    for (format, signal) in [("vcd", "-TERM"), ("vcd", "-KILL"), ("fst", "-TERM"), ("fst", "-KILL")]
    {
        let folder = folder();
        let args = ["run", "--scene", "smoke", "--wave", "all", "--wave-format", format];
        let child = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(args)
            .current_dir(folder.path())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let partial = folder.path().join("pellucid-out").join(format!("wave.partial.{format}"));
        // Several flushes of either format.
        while fs::metadata(&partial).map_or(0, |found| found.len()) < 2_000_000 {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        let kill = Command::new("kill").args([signal, &child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        let output = child.wait_with_output().unwrap();
        if signal == "-TERM" {
            let said = format!(
                "error: stopped by a signal, the files that were not complete are removed\n\
                 The waveform as far as it was written is `pellucid-out/wave.partial.{format}`.\n"
            );
            assert_eq!(stderr(&output), said);
            assert_eq!(output.status.code(), Some(130));
        }
        assert_eq!(names(&folder.path().join("pellucid-out")), [format!("wave.partial.{format}")]);
        let cycles = Wave::read(&partial).cycles();
        assert!(cycles.len() > 1000, "{} cycles", cycles.len());
        assert_eq!(cycles, (0..cycles.len() as u64).collect::<Vec<_>>());
    }
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
