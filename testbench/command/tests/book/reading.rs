//! The run of the chapter on reading waveforms, and its waveform as a table.

use std::path::Path;
use std::process::Command;
use tempfile::TempDir;
use wellen::SignalValueRef;
use wellen::simple::Waveform;

/// What the chapter tells to run, and what it gives.
pub struct Run {
    folder: TempDir,
    wave: Waveform,
}

/// The arguments as the chapter has them, with the folder before `--out`'s.
pub const ARGUMENTS: &str = "run --scene docs/src/overflow.csv -p section_capacity=2 -p sections=8 \
                             -p outside_sections=0 -p sorter_depth=4 --follow-pixel 1,0 \
                             --wave-memory chains.ssa.table,chains.nsa.table:0..2";

impl Run {
    pub fn new(root: &Path) -> Run {
        let folder = tempfile::tempdir().unwrap();
        let run = Command::new(env!("CARGO_BIN_EXE_pellucid"))
            .args(ARGUMENTS.split_whitespace())
            .arg("--quiet")
            .arg("--out")
            .arg(folder.path())
            .current_dir(root)
            .output()
            .unwrap();
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let mut wave = wellen::simple::read(folder.path().join("wave.vcd")).unwrap();
        let hierarchy = wave.hierarchy();
        let signals: Vec<_> = hierarchy.all_vars().map(|v| hierarchy[v].signal_ref()).collect();
        wave.load_signals(&signals);
        Run { folder, wave }
    }

    /// The markers: letter, cycle and name.
    pub fn markers(&self) -> String {
        let save = std::fs::read_to_string(self.folder.path().join("wave.gtkw")).unwrap();
        let line = |start: &str| save.lines().find_map(|line| line.strip_prefix(start)).unwrap();
        let times: Vec<u64> =
            line("*").split(' ').skip(2).filter_map(|time| time.parse().ok()).collect();
        let mut text = String::from("| marker | cycle | |\n|---|---|---|\n");
        for ((letter, time), k) in ('A'..).zip(times).zip(0..) {
            let names: Vec<&str> =
                save.lines().filter_map(|line| line.strip_prefix("[markername] ")).collect();
            assert!(names[k].starts_with(letter));
            text += &format!("| {letter} | {} | {} |\n", time / 10, names[k][1..].trim_start());
        }
        text
    }

    /// What a signal shows in a cycle: a state's name, a label, a number, or `·` for an empty label.
    fn shown(&self, path: &str, cycle: u64) -> String {
        let hierarchy = self.wave.hierarchy();
        let path = format!("top.machine.{path}");
        let mut vars = hierarchy.all_vars().map(|v| &hierarchy[v]);
        let var = vars.find(|v| v.full_name(hierarchy) == path);
        let var = var.unwrap_or_else(|| panic!("there is no {path}"));
        let states: Option<Vec<(String, String)>> = var.enum_type(hierarchy).map(|(_, states)| {
            states.into_iter().map(|(a, b)| (a.to_string(), b.to_string())).collect()
        });
        let signal = var.signal_ref();
        let times = self.wave.time_table();
        let at = times.partition_point(|time| *time <= cycle * 10) as u32 - 1;
        let signal = self.wave.get_signal(signal).unwrap();
        let value = signal.get_value_at(&signal.get_offset(at).unwrap(), 0);
        let text = match value {
            SignalValueRef::String(text) => text.to_string(),
            value => value.to_bit_string().unwrap(),
        };
        match states {
            Some(states) => states.into_iter().find(|(bits, _)| *bits == text).unwrap().1,
            None if text.is_empty() => "·".to_string(),
            None => u64::from_str_radix(&text, 2).map_or(text, |number| number.to_string()),
        }
    }

    /// Signals cycle by cycle, each with the name that the table gives it.
    pub fn table(&self, cycles: std::ops::Range<u64>, signals: &[(&str, &str)]) -> String {
        let mut text = format!("```text\n{:28}", "cycle");
        for cycle in cycles.clone() {
            text += &format!("{cycle:<9}");
        }
        for (name, path) in signals {
            let mut line = format!("{name:28}");
            for cycle in cycles.clone() {
                line += &format!("{:<9}", self.shown(path, cycle));
            }
            text += "\n";
            text += line.trim_end();
        }
        let lines: Vec<&str> = text.lines().map(str::trim_end).collect();
        lines.join("\n") + "\n```"
    }
}
