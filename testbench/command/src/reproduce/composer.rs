//! The timing of seed document 001, made again: its section 3.5 beside the closed forms and beside what the clocked
//! image composition machine counts.
//!
//! T_m is the time to merge an image of v x w pixels by n merging units, T_in that until its first line has come to a
//! scan-line engine, T_out that of the last line's way to the global frame buffer. An engine has what is left of the
//! frame interval.

use super::price::Price;
use comfy_table::{Table, presets};
use pellucid_testbench::report::{align_right, at_margin, grouped};
use pellucid_testbench::trial::Trial;
use serde_json::{Value as Json, json};

/// The frame interval, in milliseconds, as the document rounds it.
const INTERVAL: f64 = 33.3;
/// From a pixel's coming into a merging unit to its coming out, in clocks.
const STAGES: u64 = 4;
/// Overhead after each scan line, in clocks.
pub const BETA: u32 = 20;

/// One of the document's four cases.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// What it stands for.
    pub name: &'static str,
    /// Columns of the screen, v.
    pub width: u32,
    /// Rows of the screen, w.
    pub height: u32,
    /// The clock period t, in nanoseconds.
    pub period: u32,
    /// Merging units, n.
    pub engines: u32,
    /// What is printed of it.
    printed: [Option<Printed>; 4],
}

/// A printed number.
#[derive(Clone, Copy, Debug)]
struct Printed {
    /// As it is printed.
    text: &'static str,
    /// It, in milliseconds or percent.
    value: f64,
    /// How far a number may be from it that is rounded to it.
    rounding: f64,
    /// Why it is none of them, if it is a slip.
    slip: Option<&'static str>,
}

const fn printed(text: &'static str, value: f64, rounding: f64) -> Option<Printed> {
    Some(Printed { text, value, rounding, slip: None })
}

const fn slip(text: &'static str, value: f64, why: &'static str) -> Option<Printed> {
    Some(Printed { text, value, rounding: 0.0, slip: Some(why) })
}

/// What the four times are.
const WHAT: [&str; 4] = ["T_m, ms", "T_in, ms", "T_out, ms", "lost of a frame, %"];

/// The cases, in the document's order.
pub const SETTINGS: [Setting; 4] = [
    Setting {
        name: "VC-1, n = 16",
        width: 640,
        height: 480,
        period: 80,
        engines: 16,
        printed: [
            printed("25.3", 25.3, 0.05),
            printed("0.058", 0.058, 0.0005),
            printed("0.053", 0.053, 0.0005),
            slip("0.4", 0.4, "0.111 ms of 33.3 ms are 0.33 %, rounded up to 0.4"),
        ],
    },
    Setting {
        name: "estimate, n = 16",
        width: 1280,
        height: 1024,
        period: 20,
        engines: 16,
        printed: [
            slip("26.7", 26.7, "with n = 16 and beta = 20 it is 26.6; 26.7 is what n = 1024 gives"),
            slip("0.038", 0.038, "(1280 + 20) * 20 ns + 4 * 16 * 20 ns is 0.0273 ms"),
            printed("0.026", 0.026, 0.0005),
            printed("0.2", 0.2, 0.05),
        ],
    },
    Setting {
        name: "VC-1, n = 1024",
        width: 640,
        height: 480,
        period: 80,
        engines: 1024,
        printed: [
            None,
            printed("0.38", 0.38, 0.005),
            printed("0.053", 0.053, 0.0005),
            printed("1.3", 1.3, 0.05),
        ],
    },
    Setting {
        name: "estimate, n = 1024",
        width: 1280,
        height: 1024,
        period: 20,
        engines: 1024,
        printed: [
            None,
            slip(
                "0.083",
                0.083,
                "that is about 4 * 1024 * 20 ns alone; with the line's 0.026 it is 0.1079 ms",
            ),
            printed("0.026", 0.026, 0.0005),
            printed("0.4", 0.4, 0.05),
        ],
    },
];

/// What holds of all cases.
const FACTOR_W: &str = "T_in and T_out are printed as (v + beta) * w * t + 4 * n * t and (v + beta) * w * t: that is a whole \
                        frame. The numbers are those of one line, without the factor w.";

impl Setting {
    /// Rows of the screen that the machine is built for: T_m is printed for some cases only, and a line takes as long on
    /// a screen of few lines.
    pub fn rows(&self) -> u32 {
        if self.printed[0].is_some() { self.height } else { 2 }
    }

    /// T_m, T_in and T_out in clocks, by the closed forms, for a screen of so many rows.
    fn forms(&self, rows: u32) -> [u64; 3] {
        let line = u64::from(self.width + BETA);
        let through = STAGES * u64::from(self.engines);
        [line * u64::from(rows) + through, line + through, line]
    }

    fn milliseconds(&self, clocks: u64) -> f64 {
        clocks as f64 * f64::from(self.period) * 1e-6
    }

    /// T_m, T_in and T_out in milliseconds and the lost share of a frame in percent, for these counts of clocks.
    fn times(&self, clocks: [u64; 3]) -> [f64; 4] {
        let [merge, first, last] = clocks.map(|clocks| self.milliseconds(clocks));
        [merge, first, last, 100.0 * (first + last) / INTERVAL]
    }
}

/// A case with what the machine counted.
pub struct Timing {
    /// The case.
    pub setting: Setting,
    /// Clocks of merging, until the first line, and of the last line's way.
    pub counted: [u64; 3],
    /// What its frame costs.
    pub price: Price,
}

impl Timing {
    /// What a machine counted in that case.
    pub fn new(setting: Setting, trial: &Trial) -> Timing {
        let tally = trial.report.tally();
        let price = Price::of(trial);
        let counted = ["merge", "first_line", "last_line"].map(|f| tally.figure(f));
        Timing { setting, counted, price }
    }

    /// Whether the counts are the closed forms, and the printed numbers those of them, rounded, unless they are slips.
    pub fn is_reproduced(&self) -> bool {
        let Setting { printed, .. } = self.setting;
        let holds = |(printed, time): (&Option<Printed>, f64)| match printed {
            Some(Printed { value, rounding, slip: None, .. }) => (time - value).abs() <= *rounding,
            Some(Printed { slip: Some(_), .. }) | None => true,
        };
        self.counted == self.setting.forms(self.setting.rows())
            && printed.iter().zip(self.setting.times(self.counted)).all(holds)
    }
}

/// A time with as many digits as tell it apart.
fn digits(what: usize, value: f64) -> String {
    if what == 0 { format!("{value:.3}") } else { format!("{value:.4}") }
}

/// All cases as tables, with what is wrong in print.
pub fn table(timings: &[Timing]) -> String {
    let mut clocks = Table::new();
    clocks.load_style(presets::NOTHING);
    clocks.add_row([
        "CLOCKS",
        "T_m counted",
        "form",
        "T_in counted",
        "form",
        "T_out counted",
        "form",
    ]);
    let mut times = Table::new();
    times.load_style(presets::NOTHING);
    let mut head = vec!["TIMES".to_string()];
    head.extend(WHAT.iter().flat_map(|what| [what.to_string(), "printed".to_string()]));
    times.add_row(head);
    let mut slips = vec![format!("- {FACTOR_W}")];
    for Timing { setting, counted, .. } in timings {
        let forms = setting.forms(setting.rows());
        let mut row = vec![format!("  {}, {} lines", setting.name, setting.rows())];
        row.extend(
            counted.iter().zip(forms).flat_map(|(c, f)| [grouped(&json!(c)), grouped(&json!(f))]),
        );
        clocks.add_row(row);
        let full = setting.times(setting.forms(setting.height));
        let mut row = vec![format!("  {}", setting.name)];
        for (k, (time, printed)) in full.iter().zip(setting.printed).enumerate() {
            row.extend([digits(k, *time), printed.map_or("-", |p| p.text).to_string()]);
            if let Some(Printed { text, slip: Some(why), .. }) = printed {
                let what = WHAT[k].split(',').next().unwrap_or(WHAT[k]);
                slips.push(format!("- {}, {what}, printed {text}: {why}.", setting.name));
            }
        }
        times.add_row(row);
    }
    align_right(&mut clocks, &[1, 2, 3, 4, 5, 6]);
    align_right(&mut times, &[1, 2, 3, 4, 5, 6, 7, 8]);
    format!("{}\nSLIPS\n{}", at_margin(&format!("{clocks}\n{times}")), slips.join("\n"))
}

/// All cases as JSON.
pub fn json(timings: &[Timing]) -> Json {
    let of = |[merge, first, last]: [u64; 3]| json!({ "merge": merge, "first_line": first, "last_line": last });
    let cases: Vec<Json> = timings
        .iter()
        .map(|timing @ Timing { setting, counted, .. }| {
            let times = setting.times(setting.forms(setting.height));
            let printed = setting.printed.map(|printed| printed.map(|p| p.value));
            let slips = setting.printed.map(|printed| printed.and_then(|p| p.slip));
            let named = |values: [Json; 4]| {
                let [merge, first, last, lost] = values;
                json!({ "merge_ms": merge, "first_line_ms": first, "last_line_ms": last, "lost_percent": lost })
            };
            json!({
                "case": setting.name,
                "width": setting.width,
                "height": setting.height,
                "engines": setting.engines,
                "period_ns": setting.period,
                "beta": BETA,
                "counted_lines": setting.rows(),
                "counted_clocks": of(*counted),
                "closed_form_clocks": of(setting.forms(setting.rows())),
                "closed_form": named(times.map(|time| json!(time))),
                "printed": named(printed.map(|value| json!(value))),
                "slips": named(slips.map(|why| json!(why))),
                "costs": timing.price.json(),
            })
        })
        .collect();
    json!({ "cases": cases, "slip": FACTOR_W })
}
