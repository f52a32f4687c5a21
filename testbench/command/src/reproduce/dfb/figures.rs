//! The figures as text, JSON and CSV.

use super::contender::{
    B3D, Contender, DFB, DFB_BANDS, DFB_PAPER, DX, PLL, PLL_ENOUGH, PPLL4, PPLL4_ENOUGH,
};
use super::plan::{Figure, MANAGED};
use super::runs::{Cycles, Entry, Outcome, PHASES, Played};
use crate::reproduce::claims::{self, Claim};
use crate::reproduce::number;
use crate::reproduce::price::Price;
use comfy_table::{Table, presets};
use pellucid_testbench::plots::FiveNumbers;
use pellucid_testbench::report::{align_right, at_margin, csv_text};
use serde_json::{Map, Value as Json, json};

/// Table I of the paper: frames a second on a GeForce GTX 580, for each of its resolutions; the machines in its order.
const PRINTED: [(u32, [u32; 5]); 3] = [
    (500, [1250, 500, 500, 333, 11]),
    (800, [625, 294, 213, 141, 4]),
    (1100, [345, 170, 114, 74, 0]),
];
/// The machines of these columns.
const COLUMNS: [Contender; 5] = [B3D, DFB, PPLL4, PLL, DX];
/// The columns here: DFB as the paper describes it stands beside the fast one.
const TABLE: [Contender; 6] = [B3D, DFB, DFB_PAPER, PPLL4, PLL, DX];

/// Rows of Table I: cycles of a frame, and how much slower than DFB that is; after the printed ones.
pub fn table(entries: &[Entry]) -> Vec<Vec<String>> {
    let mut rows = vec![];
    let head = |what: &str, machines: &[Contender]| {
        let names = machines.iter().map(|machine| machine.name.to_string());
        [what.to_string()].into_iter().chain(names).collect::<Vec<_>>()
    };
    rows.push(head("frames a second, printed", &COLUMNS));
    for (side, rates) in PRINTED {
        let mut row = vec![format!("  {side}x{side}")];
        row.extend(rates.iter().map(|rate| {
            let ratio = f64::from(*rate) / f64::from(rates[1]);
            format!("{rate} ({ratio:.2})")
        }));
        rows.push(row);
    }
    rows.push(head("cycles a frame, here", &TABLE));
    for entry in entries.iter().filter(|entry| entry.figure == Figure::Table) {
        let mut row = vec![format!("  {}", entry.frames.size())];
        let dfb = entry.total(DFB);
        row.extend(TABLE.iter().map(|machine| match (entry.total(*machine), dfb) {
            (Some(total), Some(dfb)) => {
                format!("{} ({:.2})", number(total), dfb as f64 / total as f64)
            }
            (Some(total), None) => number(total),
            (None, _) => machine.lacks(&entry.need).unwrap_or("-").to_string(),
        }));
        rows.push(row);
    }
    rows
}

/// What a frame of Table I costs in each of its machines, a table for each figure of a price.
pub fn costs(entries: &[Entry]) -> Vec<Vec<String>> {
    let mut rows = vec![];
    for (k, name) in Price::NAMES.iter().enumerate() {
        let machines = TABLE.iter().map(|machine| machine.name.to_string());
        rows.push([format!("{name}, here")].into_iter().chain(machines).collect());
        for entry in entries.iter().filter(|entry| entry.figure == Figure::Table) {
            let mut row = vec![format!("  {}", entry.frames.size())];
            row.extend(TABLE.iter().map(|machine| match entry.run(*machine) {
                Some(run) => Price::shown(run.price.figures()[k]),
                None => machine.lacks(&entry.need).unwrap_or("-").to_string(),
            }));
            rows.push(row);
        }
    }
    rows
}

/// What memory management costs, in cycles, by a name for each way.
pub const MANAGEMENT: [&str; 5] = [
    "dfb:fast: count and scan",
    "dfb:paper: count and scan",
    "dfb:fast, a quarter of the memory: count, scan and bands",
    "ppll4: rebuilds",
    "pll: rebuilds",
];

/// The cost of each of [`MANAGEMENT`] for frames, as far as its machines have played them: what is counted and summed up,
/// and what further bands and plays take beyond the same machine with enough memory.
pub fn management(entry: &Entry) -> [Option<u64>; 5] {
    let prefix = |machine: Contender| {
        let cycles = &entry.run(machine)?.cycles;
        Some(cycles.of("count") + cycles.of("scan"))
    };
    let beyond = |machine: Contender, enough: Contender| {
        Some(entry.total(machine)?.saturating_sub(entry.total(enough)?))
    };
    let bands = prefix(DFB).zip(beyond(DFB_BANDS, DFB)).map(|(prefix, bands)| prefix + bands);
    [prefix(DFB), prefix(DFB_PAPER), bands, beyond(PPLL4, PPLL4_ENOUGH), beyond(PLL, PLL_ENOUGH)]
}

/// Least, lower quartile, median, upper quartile and greatest of values, between two of them in proportion; nothing without
/// values.
pub fn five_numbers(values: impl IntoIterator<Item = u64>) -> Option<FiveNumbers> {
    let mut values: Vec<u64> = values.into_iter().collect();
    values.sort_unstable();
    let last = values.len().checked_sub(1)?;
    Some([0.0, 0.25, 0.5, 0.75, 1.0].map(|part| {
        let at = part * last as f64;
        let (below, above) =
            (values[at.floor() as usize] as f64, values[at.ceil() as usize] as f64);
        below + (above - below) * at.fract()
    }))
}

/// Everything as text: Table I, and the claims.
pub fn text(entries: &[Entry], said: &[Claim]) -> String {
    let mut tables = Table::new();
    tables.load_style(presets::NOTHING);
    for row in table(entries).into_iter().chain(costs(entries)) {
        tables.add_row(row);
    }
    align_right(&mut tables, &[1, 2, 3, 4, 5, 6]);
    format!(
        "TABLE I, in brackets the speed against DFB (here: against dfb:fast)\n{}\n{}",
        at_margin(&tables.to_string()),
        claims::text(said)
    )
}

fn phases(cycles: &Cycles) -> Json {
    let mut object = Map::new();
    object.insert("total".into(), json!(cycles.total));
    for phase in PHASES {
        object.insert(phase.into(), json!(cycles.of(phase)));
    }
    Json::Object(object)
}

/// The figure of the paper that frames are for.
fn figure(figure: Figure) -> &'static str {
    match figure {
        Figure::Table => "Table I",
        Figure::Quads(..) => "Figures 5 and 6",
        Figure::Walk(_) => "Figure 7",
        Figure::Tour => "Figure 8",
    }
}

/// Everything as JSON.
pub fn json(command: &str, entries: &[Entry], claims: &[Claim]) -> Json {
    let claims: Vec<Json> = claims.iter().map(Claim::json).collect();
    let printed = PRINTED.map(|(side, rates)| {
        let rates: Map<String, Json> = COLUMNS
            .iter()
            .zip(rates)
            .map(|(machine, rate)| (machine.name.into(), json!(rate)))
            .collect();
        json!({ "width": side, "height": side, "frames_per_second": rates })
    });
    let frames = entries.iter().map(|entry| {
        let machines = entry.contenders.iter().zip(&entry.outcomes);
        let machines: Vec<Json> = machines
            .map(|(machine, outcome)| {
                let mut object =
                    json!({ "machine": machine.name, "bytes": machine.bytes(&entry.need) });
                match outcome {
                    Outcome::Lacks(why) => object["lacks"] = json!(why),
                    Outcome::Run(run) => {
                        object["command"] = json!(run.command);
                        object["cycles"] = phases(&run.cycles);
                        object["accesses"] =
                            json!({ "seed": run.accesses[0], "full": run.accesses[1] });
                        object["bytes_counted"] = json!(run.bytes);
                        object["costs"] = run.price.json();
                        object["plays"] = json!(run.plays());
                        let frames = run.frames.iter().map(|Played { cycles, plays, .. }| {
                            json!({ "cycles": phases(cycles), "plays": plays })
                        });
                        object["frames"] = frames.collect();
                    }
                }
                object
            })
            .collect();
        let (width, height) = entry.frames.screen;
        let mut object = json!({
            "figure": figure(entry.figure),
            "scene": entry.frames.scene,
            "width": width,
            "height": height,
            "instances": entry.frames.instances,
            "path": entry.frames.walk().map(|walk| walk.path.to_string()),
            "frames": entry.frames.count(),
            "need": entry.need.json(),
            "machines": machines,
        });
        if let Figure::Quads(number, _) = entry.figure
            && MANAGED.contains(&number)
        {
            let costs = MANAGEMENT.iter().zip(management(entry));
            object["memory_management_cycles"] =
                costs.map(|(what, cycles)| (what.to_string(), json!(cycles))).collect();
        }
        object
    });
    let frames: Vec<Json> = frames.collect();
    json!({ "command": command, "claims": claims, "table_1_printed": printed, "frames": frames })
}

/// Every run as a line, and each of its frames.
pub fn csv(entries: &[Entry]) -> String {
    let mut text = format!(
        "figure,scene,width,height,instances,frames,machine,frame,plays,total,count,scan,store,rebuild,resolve,bytes,\
         accesses_seed,accesses_full,{},lacks\n",
        Price::COLUMNS
    );
    for entry in entries {
        let (width, height) = entry.frames.screen;
        let instances = entry.frames.instances.map_or(String::new(), |n| n.to_string());
        let (figure, count) = (figure(entry.figure), entry.frames.count());
        let scene = csv_text(&entry.frames.scene);
        let key = format!("{figure},{scene},{width},{height},{instances},{count}");
        for (machine, outcome) in entry.contenders.iter().zip(&entry.outcomes) {
            let (name, bytes) = (machine.name, machine.bytes(&entry.need));
            let run = match outcome {
                Outcome::Run(run) => run,
                Outcome::Lacks(why) => {
                    text += &format!("{key},{name},all,,,,,,,,{bytes},,,,,,{why}\n");
                    continue;
                }
            };
            let of = |cycles: &Cycles| {
                let phases = PHASES.iter().map(|phase| cycles.of(phase).to_string());
                let all = [cycles.total.to_string()].into_iter().chain(phases);
                all.collect::<Vec<_>>().join(",")
            };
            let (all, [seed, full]) = (of(&run.cycles), run.accesses);
            let (plays, price) = (run.plays(), run.price.csv());
            text += &format!("{key},{name},all,{plays},{all},{bytes},{seed},{full},{price},\n");
            for (frame, played) in run.frames.iter().enumerate() {
                let (plays, cycles) = (played.plays, of(&played.cycles));
                text += &format!("{key},{name},{frame},{plays},{cycles},,,,,,,\n");
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_lie_between_values_in_proportion() {
        assert_eq!(five_numbers([]), None);
        assert_eq!(five_numbers([7]), Some([7.0; 5]));
        assert_eq!(five_numbers([5, 1, 3]), Some([1.0, 2.0, 3.0, 4.0, 5.0]));
        assert_eq!(five_numbers([4, 0, 2, 8]), Some([0.0, 1.5, 3.0, 5.0, 8.0]));
    }
}
