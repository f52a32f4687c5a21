//! What is written is read back by `wellen`, in either format, and VCD is held to the letter by a strict
//! reader.

use crate::machine::{
    Dump, LABELS, SIGNALS, dump, dump_cycles, labels, layout, remember, show, shown_label, stall,
    values,
};
use pellucid_sim::{Declare, Kind, Label, Sink};
use pellucid_waveforms::{FileFormat, Layout, PERIOD_NS, StreamOf};
use std::collections::HashMap;
use wellen::simple::Waveform;
use wellen::{SignalRef, SignalValueRef};

const FORMATS: [FileFormat; 2] = [FileFormat::Vcd, FileFormat::Fst];

/// A waveform as `wellen` reads it.
struct Read {
    wave: Waveform,
    signals: HashMap<String, SignalRef>,
}

impl Read {
    fn new(dump: &Dump) -> Read {
        let mut wave = wellen::simple::read(dump.path()).unwrap();
        let hierarchy = wave.hierarchy();
        let vars = hierarchy.all_vars().map(|var| &hierarchy[var]);
        let signals: HashMap<String, SignalRef> =
            vars.map(|v| (v.full_name(hierarchy), v.signal_ref())).collect();
        wave.load_signals(&signals.values().copied().collect::<Vec<_>>());
        Read { wave, signals }
    }

    /// What a signal shows in a cycle.
    fn value(&self, path: &str, cycle: u64) -> String {
        let times = self.wave.time_table();
        let at = times.partition_point(|time| *time <= cycle * PERIOD_NS) - 1;
        // `wellen` makes elements of an array a scope.
        let name = format!("top.{}", path.replace('[', ".["));
        let signal = self.signals.get(&name).unwrap_or_else(|| panic!("there is no {name}"));
        let signal = self.wave.get_signal(*signal).unwrap();
        let offset = signal.get_offset(at as u32).unwrap();
        match signal.get_value_at(&offset, 0) {
            SignalValueRef::String(text) => text.to_string(),
            value => value.to_bit_string().unwrap(),
        }
    }
}

/// A label of either format as text: a string, or characters of eight bits.
fn text(value: &str) -> String {
    if value.len() != 192 {
        return value.to_string();
    }
    let digits = value.as_bytes().chunks(8).map(|bits| std::str::from_utf8(bits).unwrap());
    let bytes = digits.filter_map(|bits| u8::from_str_radix(bits, 2).ok());
    String::from_utf8(bytes.filter(|byte| *byte > 0).collect()).unwrap()
}

#[test]
fn every_value_and_label_is_read_back() {
    for format in FORMATS {
        let read = Read::new(&dump_cycles(format, 0..200));
        for cycle in 0..200 {
            for (k, (path, width)) in SIGNALS.iter().enumerate() {
                let bits = read.value(&format!("machine.{path}"), cycle);
                assert_eq!(bits.len(), *width as usize, "{path}");
                let value = u64::from_str_radix(&bits, 2).unwrap();
                assert_eq!(value, values(cycle)[k], "{path} in cycle {cycle}, {format:?}");
            }
            for (k, (path, _)) in LABELS.iter().enumerate() {
                let label = read.value(&format!("machine.{path}"), cycle);
                let expected = shown_label(cycle, k);
                assert_eq!(text(&label), expected, "{path} in cycle {cycle}, {format:?}");
            }
            let stalls = read.value("machine.wires.passed.stall", cycle);
            assert_eq!(stalls, stall(cycle).to_string(), "cycle {cycle}");
            let number = read.value("cycle", cycle);
            assert_eq!(u64::from_str_radix(&number, 2).unwrap(), cycle);
        }
    }
}

/// More than the writer of an FST gathers for a block, before anything has changed.
#[test]
fn a_machine_may_have_many_signals() {
    const SIGNALS: u64 = 20_000;
    let declare = |to: &mut dyn Declare| {
        to.open("machine");
        (0..SIGNALS).for_each(|k| to.signal(&format!("word{k}"), 1 + k as u32 % 9, Kind::Bits(32)));
        to.label("label");
        to.close();
    };
    let value = |k: u64, cycle: u64| (k + cycle) % (2 << (k % 9));
    for format in FORMATS {
        for first in [0, 100] {
            let cycles = [first, first + 1, first + 20, first + 21];
            let dump = dump(format, Layout::new(vec![], declare), 0, |mut wave| {
                for cycle in cycles {
                    if cycle == first + 20 {
                        wave.gap(first + 2).unwrap();
                    }
                    wave.sample(|to| {
                        (0..SIGNALS).for_each(|k| to.push(value(k, cycle)));
                        to.label(Label::new(cycle as u32, 3, 4));
                    });
                    wave.show(cycle).unwrap();
                }
                assert_eq!(wave.finish(first + 22).unwrap(), format!("#{}(3,4)", first + 21).len());
            });
            let read = Read::new(&dump);
            for cycle in cycles {
                for k in (0..SIGNALS).step_by(701) {
                    let bits = read.value(&format!("machine.word{k}"), cycle);
                    let shown = u64::from_str_radix(&bits, 2);
                    assert_eq!(shown, Ok(value(k, cycle)), "{k} in cycle {cycle}, {format:?}");
                }
            }
        }
    }
}

#[test]
fn a_gap_is_unknown_and_the_next_cycle_shows_all_again() {
    for format in FORMATS {
        let read = Read::new(&dump_cycles(format, (10..13).chain(100..103)));
        for (k, (path, width)) in SIGNALS.iter().enumerate() {
            let path = format!("machine.{path}");
            assert_eq!(read.value(&path, 13), "x".repeat(*width as usize), "{path}, {format:?}");
            for cycle in [10, 12, 100, 102] {
                let value = u64::from_str_radix(&read.value(&path, cycle), 2).unwrap();
                assert_eq!(value, values(cycle)[k], "{path} in cycle {cycle}, {format:?}");
            }
        }
        for (path, _) in LABELS {
            assert_eq!(text(&read.value(&format!("machine.{path}"), 13)), "");
        }
    }
}

#[test]
fn equal_runs_give_equal_files() {
    for format in FORMATS {
        let [a, b] = [0, 1].map(|_| dump_cycles(format, 0..50).bytes());
        assert_eq!(a, b);
    }
}

#[test]
fn states_have_their_names_in_a_vcd() {
    let read = Read::new(&dump_cycles(FileFormat::Vcd, 0..2));
    let hierarchy = read.wave.hierarchy();
    let of = |path: &str| {
        let mut vars = hierarchy.all_vars().map(|v| &hierarchy[v]);
        let var = vars.find(|v| v.full_name(hierarchy) == path).unwrap();
        var.enum_type(hierarchy).unwrap().1
    };
    let names = [("00", "Idle"), ("01", "Run"), ("10", "Stall")];
    assert_eq!(of("top.machine.registers.store.fsm"), names);
    assert_eq!(of("top.machine.wires.phase"), names);
    let others = [("00", "Idle"), ("01", "Load"), ("10", "Drain"), ("11", "Stall")];
    assert_eq!(of("top.machine.registers.scan.fsm"), others);
}

/// Ids declared and unique, values of legal width, time rising, every change a change, all values
/// under `$dumpvars` and after a gap. Gives the changes of each variable by its name.
fn strict(text: &str) -> HashMap<String, Vec<(u64, String)>> {
    let (header, body) = text.split_once("$enddefinitions $end\n").unwrap();
    let mut vars: HashMap<&str, (&str, u32, String)> = HashMap::new();
    let mut scopes = vec![];
    for line in header.lines() {
        let words: Vec<&str> = line.split(' ').collect();
        match words[0] {
            "$scope" => scopes.push(words[2]),
            "$upscope" => drop(scopes.pop().unwrap()),
            "$var" => {
                let (kind, width, id, name) =
                    (words[1], words[2].parse().unwrap(), words[3], words[4]);
                assert!(id.bytes().all(|byte| (b'!'..=b'~').contains(&byte)), "{line}");
                let legal = |c: char| c.is_ascii_alphanumeric() || "_[]".contains(c);
                assert!(name.chars().all(legal), "{line}");
                if width > 1 {
                    assert_eq!(words[5], format!("[{}:0]", width - 1), "{line}");
                }
                let path = format!("{}.{name}", scopes.join("."));
                assert!(vars.insert(id, (kind, width, path)).is_none(), "id {id} twice");
            }
            _ => {}
        }
    }
    assert!(scopes.is_empty());
    let (mut time, mut block) = (None, None::<(String, usize)>);
    let mut shown: HashMap<String, String> = HashMap::new();
    let mut changes: HashMap<String, Vec<(u64, String)>> = HashMap::new();
    for line in body.lines() {
        if let Some(t) = line.strip_prefix('#') {
            let t: u64 = t.parse().unwrap();
            assert!(time.is_none_or(|before| t > before), "time goes back at #{t}");
            time = Some(t);
        } else if line == "$end" {
            let (command, count) = block.take().unwrap();
            assert_eq!(count, vars.len(), "{command} names every signal");
        } else if line.starts_with('$') {
            assert!(["$dumpvars", "$dumpoff", "$dumpon"].contains(&line), "{line}");
            block = Some((line.into(), 0));
        } else {
            let (value, id) = match line.strip_prefix(['b', 's']) {
                Some(rest) => rest.split_once(' ').unwrap(),
                None => line.split_at(1),
            };
            let (kind, width, path) = &vars[id];
            if *kind == "string" {
                assert!(line.starts_with('s') && value.is_ascii(), "{line}");
            } else {
                assert_eq!(*width == 1, !line.starts_with('b'), "{line}");
                assert!(value == "x" || value.bytes().all(|b| b == b'0' || b == b'1'), "{line}");
                assert!(value.len() as u32 <= *width, "{line}");
                assert!(value.len() == 1 || value.starts_with('1'), "leading zeros: {line}");
            }
            match &mut block {
                Some((_, count)) => *count += 1,
                None => assert_ne!(shown.get(id).map(String::as_str), Some(value), "{line}"),
            }
            shown.insert(id.into(), value.into());
            changes.entry(path.clone()).or_default().push((time.unwrap(), value.into()));
        }
    }
    changes
}

#[test]
fn a_vcd_is_legal_to_the_letter() {
    let changes = strict(&dump_cycles(FileFormat::Vcd, (0..500).chain(600..700)).text());
    assert_eq!(changes.len(), SIGNALS.len() + LABELS.len() + 3);
}

#[test]
fn the_clock_rises_with_each_cycle_and_falls_half_way() {
    let changes = strict(&dump_cycles(FileFormat::Vcd, (0..2).chain(4..5)).text());
    let expected = [(0, "1"), (5, "0"), (10, "1"), (15, "0"), (20, "x"), (40, "1"), (45, "0")];
    assert_eq!(changes["top.clk"], expected.map(|(t, v)| (t, v.to_string())));
}

/// As in hardware: a model at fault must not make an illegal file.
#[test]
fn a_value_that_is_too_wide_loses_its_upper_bits() {
    let declare = |to: &mut dyn Declare| {
        to.open("machine");
        to.signal("flag", 1, Kind::Flag);
        to.signal("small", 6, Kind::Bits(32));
        to.close();
    };
    for format in FORMATS {
        let dump = dump(format, Layout::new(vec![], declare), 0, |mut wave| {
            wave.sample(|to| [2, 9000].into_iter().for_each(|value| to.push(value)));
            wave.show(0).unwrap();
            wave.finish(1).unwrap();
        });
        let read = Read::new(&dump);
        assert_eq!(read.value("machine.flag", 0), "0", "{format:?}");
        assert_eq!(read.value("machine.small", 0), format!("{:06b}", 9000 % 64), "{format:?}");
    }
}

#[test]
fn names_become_legal() {
    let declare = |to: &mut dyn Declare| {
        to.open("r#type");
        to.signal("a b.c", 2, Kind::Bits(32));
        to.close();
    };
    let dump = dump(FileFormat::Vcd, Layout::new(vec![], declare), 0, |mut wave| {
        wave.sample(|to| to.push(1));
        wave.show(0).unwrap();
        wave.finish(1).unwrap();
    });
    assert!(strict(&dump.text()).contains_key("top.type.a_b_c"));
}

#[test]
fn only_what_is_selected_is_there() {
    let selected = |patterns: &[&str]| {
        let mut layout = layout();
        layout.select(&patterns.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap();
        let dump = dump(FileFormat::Vcd, layout, 0, |mut wave| {
            (0..20).for_each(|cycle| show(&mut wave, cycle));
            wave.finish(20).unwrap();
        });
        let text = dump.text();
        let mut names: Vec<String> = strict(&text).into_keys().collect();
        names.retain(|name| name.contains("machine"));
        names.iter_mut().for_each(|name| *name = name["top.machine.".len()..].to_string());
        names.sort();
        names
    };
    assert_eq!(selected(&["wires.events"]), ["wires.events.dropped"]);
    assert_eq!(
        selected(&["registers.scan", "*.phase"]),
        ["registers.scan.entries[3]", "registers.scan.fsm", "wires.phase"]
    );
    assert_eq!(
        selected(&["*stage.*l*"]),
        [
            "registers.store.stage.label",
            "registers.store.stage.payload.pixel",
            "registers.store.stage.valid"
        ]
    );
    assert_eq!(selected(&["wires.passed.stall"]), ["wires.passed.stall"]);
    assert_eq!(
        selected(&["wires", "!*.label", "!wires.passed.payload"]),
        [
            "wires.events.dropped",
            "wires.passed.ready",
            "wires.passed.stall",
            "wires.passed.valid",
            "wires.phase"
        ]
    );
    assert_eq!(selected(&["!registers", "!*.passed"]), ["wires.events.dropped", "wires.phase"]);
    let error = layout().select(&["wires".into(), "regs.*".into()]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`regs.*` fits no signal; there is `wires.events.dropped`, for instance"
    );
}

#[test]
fn remembered_cycles_are_shown_when_they_are_recalled() {
    for format in FORMATS {
        let dump = dump(format, layout(), 50, |mut wave| {
            // 50 cycles are remembered: 150..200, of which 190 and on are wanted.
            (0..200).for_each(|cycle| remember(&mut wave, cycle, cycle));
            assert_eq!(wave.last_change(), Some(199));
            assert_eq!(
                wave.labels(),
                [0, 1].map(|k| {
                    if shown_label(199, k).is_empty() { Label::NONE } else { labels(199)[k] }
                })
            );
            wave.recall(190, 199).unwrap();
            wave.recall(0, 199).unwrap();
            (200..300).for_each(|cycle| remember(&mut wave, cycle, cycle));
            wave.recall(0, 299).unwrap();
            assert_eq!(wave.first(), Some(190));
            wave.finish(300).unwrap();
        });
        let read = Read::new(&dump);
        let cycles: Vec<u64> = (0..310).filter(|c| *c >= 190 && !(200..250).contains(c)).collect();
        for cycle in cycles {
            let bits = read.value("machine.registers.scan.entries[3]", cycle);
            let shown = cycle.min(299);
            assert_eq!(u64::from_str_radix(&bits, 2), Ok(values(shown)[5]), "{cycle}, {format:?}");
        }
        assert_eq!(read.value("clk", 200), "x");
        // An FST begins with time 0, at which nothing is known.
        let before = if format == FileFormat::Vcd { 1900 } else { 0 };
        assert_eq!(read.wave.time_table()[0], before);
    }
}

/// Cycles in which nothing changes need no memory: before a stand-still there is what led to it.
#[test]
fn a_stand_still_is_one_remembered_cycle() {
    let dump = dump(FileFormat::Vcd, layout(), 50, |mut wave| {
        (0..60).for_each(|cycle| remember(&mut wave, cycle, cycle));
        (60..10_000).for_each(|cycle| remember(&mut wave, cycle, 59));
        assert_eq!(wave.last_change(), Some(59));
        wave.recall(0, 9_999).unwrap();
        wave.finish(10_000).unwrap();
    });
    let changes = strict(&dump.text());
    let cycles = &changes["top.cycle"];
    assert_eq!(cycles[0], (100, format!("{:b}", 10)));
    let last = cycles.last().unwrap();
    assert_eq!(*last, (10_580, format!("{:b}", 1058)), "a thousand still cycles are shown");
}

/// What was written until a file is abandoned can be read.
#[test]
fn a_file_without_an_end_is_read_up_to_its_last_flush() {
    for format in FORMATS {
        const CYCLES: u64 = 60_000;
        let dump = dump(format, layout(), 0, |mut wave| {
            (0..CYCLES).for_each(|cycle| show(&mut wave, cycle));
        });
        let read = Read::new(&dump);
        let last = *read.wave.time_table().last().unwrap() / PERIOD_NS;
        assert!((CYCLES / 2..CYCLES).contains(&last), "up to cycle {last}, {format:?}");
        for cycle in [0, last / 2, last - 1] {
            let bits = read.value("machine.registers.scan.entries[3]", cycle);
            assert_eq!(u64::from_str_radix(&bits, 2), Ok(values(cycle)[5]), "{cycle}, {format:?}");
        }
    }
}

/// An offer that nobody waits with is no stall.
#[test]
fn only_streams_have_stalls() {
    let stalls = |streams| {
        let layout = Layout::new(streams, crate::machine::declare);
        layout.stalls().map(|(name, _)| name.to_string()).collect::<Vec<_>>()
    };
    assert_eq!(stalls(vec![StreamOf { name: "passed".into(), to: "store".into() }]), ["passed"]);
    assert!(stalls(vec![]).is_empty());
}
