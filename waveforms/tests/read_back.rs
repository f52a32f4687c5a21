//! What is written is read back by `wellen`, and held to the letter of the format by a strict reader.

use pellucid_sim::{Declare, Kind, Sink, States};
use pellucid_waveforms::{PERIOD_NS, Vcd, gtkwave};
use std::collections::HashMap;

const STATES: &States = &States { name: "Fsm", variants: &["Idle", "Run", "Stall"] };
const SIGNALS: [(&str, u32); 4] = [("flag", 1), ("state", 2), ("mem[3]", 7), ("wide", 64)];

fn declare(to: &mut dyn Declare) {
    to.open("block");
    to.signal("flag", 1, Kind::Flag);
    to.signal("state", 2, Kind::State(STATES));
    to.open("inner");
    to.signal("mem[3]", 7, Kind::Bits(32));
    to.signal("wide", 64, Kind::Bits(32));
    to.close();
    to.close();
}

/// Values that change now and then, at every width.
fn values(cycle: u64) -> [u64; 4] {
    let mixed = (cycle / 3).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    [cycle / 2 % 2, cycle / 5 % 3, mixed >> 57, if cycle == 7 { u64::MAX } else { mixed }]
}

fn dump(cycles: impl IntoIterator<Item = u64>) -> String {
    let mut vcd = Vcd::new(Vec::new(), declare).unwrap();
    let mut last = 0;
    for cycle in cycles {
        if cycle > last + 1 {
            vcd.gap(last + 1).unwrap();
        }
        vcd.cycle(cycle, |to| values(cycle).into_iter().for_each(|value| to.push(value))).unwrap();
        last = cycle;
    }
    String::from_utf8(vcd.finish(last + 1).unwrap()).unwrap()
}

#[test]
fn wellen_reads_hierarchy_and_every_value() {
    let text = dump(0..200);
    let mut wave = wellen::simple::read_from_reader(std::io::Cursor::new(text)).unwrap();
    let hierarchy = wave.hierarchy();
    let vars: HashMap<String, wellen::SignalRef> = hierarchy
        .all_vars()
        .map(|v| &hierarchy[v])
        .map(|v| (v.full_name(hierarchy), v.signal_ref()))
        .collect();
    let names =
        ["top.block.flag", "top.block.state", "top.block.inner.mem.[3]", "top.block.inner.wide"];
    let signals: Vec<_> = names.iter().map(|n| vars[*n]).collect();
    wave.load_signals(&signals);
    let times = wave.time_table().to_vec();
    for cycle in 0..200 {
        let at = times.iter().position(|t| *t == cycle * PERIOD_NS).unwrap() as u32;
        for (k, signal) in signals.iter().enumerate() {
            let signal = wave.get_signal(*signal).unwrap();
            let offset = signal.get_offset(at).unwrap();
            let bits = signal.get_value_at(&offset, 0).to_bit_string().unwrap();
            let value = u64::from_str_radix(&bits, 2).unwrap();
            assert_eq!(value, values(cycle)[k], "{} in cycle {cycle}", names[k]);
        }
    }
}

#[test]
fn wellen_knows_the_states_names() {
    let wave = wellen::simple::read_from_reader(std::io::Cursor::new(dump(0..2))).unwrap();
    let hierarchy = wave.hierarchy();
    let state =
        hierarchy.all_vars().map(|v| &hierarchy[v]).find(|v| v.name(hierarchy) == "state").unwrap();
    let (name, table) = state.enum_type(hierarchy).unwrap();
    assert_eq!(name, "Fsm");
    assert_eq!(table, [("00", "Idle"), ("01", "Run"), ("10", "Stall")]);
}

/// Ids declared and unique, values of legal width, time rising, every change a change, all values
/// under `$dumpvars` and after a gap. Gives the changes of each signal.
fn strict(text: &str) -> HashMap<String, Vec<(u64, String)>> {
    let (header, body) = text.split_once("$enddefinitions $end\n").unwrap();
    let mut widths = HashMap::new();
    for line in header.lines().filter(|l| l.starts_with("$var")) {
        let words: Vec<&str> = line.split(' ').collect();
        let (width, id) = (words[2].parse::<u32>().unwrap(), words[3]);
        if width > 1 {
            assert_eq!(words[5], format!("[{}:0]", width - 1), "{line}");
        }
        assert!(widths.insert(id.to_string(), width).is_none(), "id {id} twice");
    }
    assert_eq!(widths.len(), SIGNALS.len() + 1);
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
            assert_eq!(count, widths.len(), "{command} names every signal");
        } else if line.starts_with('$') {
            assert!(["$dumpvars", "$dumpoff", "$dumpon"].contains(&line), "{line}");
            block = Some((line.into(), 0));
        } else {
            let (value, id) = match line.strip_prefix('b') {
                Some(rest) => rest.split_once(' ').unwrap(),
                None => line.split_at(1),
            };
            let width = widths[id];
            assert_eq!(width == 1, !line.starts_with('b'), "{line}");
            assert!(value == "x" || value.bytes().all(|b| b == b'0' || b == b'1'), "{line}");
            assert!(value.len() as u32 <= width, "{line}");
            assert!(value.len() == 1 || value.starts_with('1'), "leading zeros: {line}");
            match &mut block {
                Some((_, count)) => *count += 1,
                None => assert_ne!(shown.get(id).map(String::as_str), Some(value), "{line}"),
            }
            shown.insert(id.into(), value.into());
            changes.entry(id.into()).or_default().push((time.unwrap(), value.into()));
        }
    }
    changes
}

#[test]
fn the_file_is_legal_to_the_letter() {
    strict(&dump(0..500));
}

#[test]
fn the_clock_rises_with_each_cycle_and_falls_half_way() {
    let changes = strict(&dump(0..3));
    let expected = [(0, "1"), (5, "0"), (10, "1"), (15, "0"), (20, "1"), (25, "0")];
    assert_eq!(changes["!"], expected.map(|(t, v)| (t, v.to_string())));
}

#[test]
fn a_gap_hides_and_the_next_cycle_shows_all_again() {
    let text = dump((10..13).chain(100..103));
    let changes = strict(&text);
    let clock: Vec<_> = changes["!"].iter().map(|(t, v)| (*t, v.as_str())).collect();
    assert_eq!(clock[0], (100, "1"));
    assert_eq!(clock[6], (130, "x"));
    assert_eq!(clock[7], (1000, "1"));
    let counts = ["$dumpvars", "$dumpoff", "$dumpon"].map(|c| text.matches(c).count());
    assert_eq!(counts, [1, 1, 1]);
}

#[test]
fn equal_runs_give_equal_files() {
    assert_eq!(dump(0..50), dump(0..50));
}

/// Another table of the same name, with the same first and last state.
const OTHERS: &States = &States { name: "Fsm", variants: &["Idle", "Load", "Drain", "Stall"] };

#[test]
fn the_save_file_groups_streams_and_blocks_and_translates_states() {
    let files = gtkwave("wave", |to| {
        to.open("machine");
        to.open("registers");
        to.open("store");
        to.signal("fsm", 2, Kind::State(STATES));
        to.open("queue");
        to.signal("count", 3, Kind::Bits(32));
        to.close();
        to.close();
        to.open("scan");
        to.signal("fsm", 2, Kind::State(OTHERS));
        to.close();
        to.close();
        to.open("wires");
        to.open("passed");
        to.signal("valid", 1, Kind::Flag);
        to.signal("ready", 1, Kind::Flag);
        to.open("payload");
        to.signal("pixel", 12, Kind::Bits(32));
        to.signal("z", 24, Kind::Bits(32));
        to.close();
        to.close();
        to.open("events");
        to.signal("dropped", 1, Kind::Flag);
        to.close();
        to.close();
        to.close();
    });
    let [states, others, save] = &files[..] else { panic!("{files:?}") };
    assert_eq!(states.name, "wave.states/Fsm-1");
    assert_eq!(states.text, "0 ?DarkSlateGray?Idle\n1 ?DarkGreen?Run\n2 ?DarkBlue?Stall\n");
    assert_eq!(others.name, "wave.states/Fsm-2");
    assert_eq!(save.name, "wave.gtkw");
    let (head, traces) = save.text.split_once("top.clk\n").unwrap();
    assert!(head.contains("[dumpfile] \"wave.vcd\"\n"), "{head}");
    let expected = "@800200\n-passed\n\
        @28\ntop.machine.wires.passed.valid\n@28\ntop.machine.wires.passed.ready\n\
        @24\ntop.machine.wires.passed.payload.pixel[11:0]\n\
        @22\ntop.machine.wires.passed.payload.z[23:0]\n@1000200\n-passed\n\
        @800200\n-events\n@28\n[color] 1\ntop.machine.wires.events.dropped\n@1000200\n-events\n\
        @c00200\n-store: registers\n@2022\n^1 wave.states/Fsm-1\n\
        top.machine.registers.store.fsm[1:0]\n\
        @8024\ntop.machine.registers.store.queue.count[2:0]\n@20000\n-\n@1400200\n-store: registers\n\
        @c00200\n-scan: registers\n@2022\n^2 wave.states/Fsm-2\n\
        top.machine.registers.scan.fsm[1:0]\n@1400200\n-scan: registers\n";
    assert_eq!(traces, expected);
}
