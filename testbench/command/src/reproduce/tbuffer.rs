//! The comparison of seed document 000, made again: its eight frames through clocked machines, beside the
//! closed forms of its Table 2 and the percentages that it prints.
//!
//! The sizes are those with which the printed percentages come out: 6 bytes for a fragment of T-buffer
//! and M-buffer, 10 for one of the R-buffer, 4 for a depth, 2 for an address; three fragments in a
//! section of the T-buffer, two in one of the M-buffer.

use super::price::Price;
use comfy_table::{Table, presets};
use pellucid_machine::Census;
use pellucid_machine::params::ParamError;
use pellucid_machine::pixel::Screen;
use pellucid_mbuffer as mbuffer;
use pellucid_rbuffer as rbuffer;
use pellucid_tbuffer as tbuffer;
use pellucid_testbench::report::{align_right, at_margin, grouped};
use pellucid_testbench::trial::Trial;
use serde_json::{Value as Json, json};

/// The section capacities that are tried.
const CAPACITIES: std::ops::RangeInclusive<u32> = 1..=8;
/// The section capacity of the document's comparison.
const CAPACITY: u32 = 3;
/// How far a percentage may be from the printed one, in points.
const POINTS: f64 = 2.0;

/// What one frame takes in one machine.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Accesses to memory, in words.
    pub accesses: u64,
    /// Storage, in bytes.
    pub bytes: u64,
}

/// A frame: by the closed forms, and as the clocked machines counted.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Its scene.
    pub name: String,
    census: Census,
    screen: Screen,
    /// T-buffer: by the closed form, counted.
    pub tbuffer: [Need; 2],
    /// R-buffer: by the closed form, counted.
    pub rbuffer: [Need; 2],
    /// M-buffer: by the closed form, counted.
    pub mbuffer: [Need; 2],
    /// What it costs in each of the three.
    pub prices: [Price; 3],
}

/// `N_i` with its `i`.
fn layers(census: &Census) -> impl Iterator<Item = (u64, u64)> {
    census.histogram.iter().copied().zip(0..).filter(|(_, i)| *i > 0)
}

/// Storage of a T-buffer with sections of `capacity` fragments.
fn tbuffer_bytes(census: &Census, screen: Screen, capacity: u32) -> Result<u64, ParamError> {
    let sections = layers(census).map(|(n, i)| n * i.div_ceil(capacity.into())).sum();
    let params = tbuffer::config::Params {
        section_capacity: capacity,
        ..tbuffer::config::Params::default()
    };
    let cfg = tbuffer::config::Config::new(screen, params)?;
    Ok(tbuffer::monitor::seed_bytes(&cfg, sections))
}

fn counted(trial: &Trial) -> Need {
    let tally = trial.report.tally();
    Need { accesses: tally.seed_accesses, bytes: tally.seed_bytes_used }
}

impl Frame {
    /// The frame `name` whose fragments are as `census` says, and what T-buffer, R-buffer and
    /// M-buffer counted.
    ///
    /// # Errors
    /// The screen is too large for a machine.
    pub fn new(
        name: &str,
        screen: Screen,
        census: Census,
        [tbuffer, rbuffer, mbuffer]: [&Trial; 3],
    ) -> Result<Frame, ParamError> {
        let fragments = census.stored;
        let popped: u64 = layers(&census).map(|(n, i)| n * i * (i + 1) / 2).sum();
        let cfg = rbuffer::config::Config::new(screen, rbuffer::config::Params::default())?;
        let params = mbuffer::config::Params::default();
        let section = u64::from(params.section_capacity);
        let overflow = layers(&census).map(|(n, i)| n * (i.div_ceil(section) - 1)).sum();
        let m = Need {
            accesses: 2 * fragments,
            bytes: mbuffer::monitor::seed_bytes(
                &mbuffer::config::Config::new(screen, params)?,
                overflow,
            ),
        };
        let t = Need {
            accesses: 2 * fragments + census.pixels(),
            bytes: tbuffer_bytes(&census, screen, CAPACITY)?,
        };
        let r = Need {
            accesses: 2 * fragments + 2 * popped,
            bytes: rbuffer::monitor::seed_bytes(&cfg, fragments),
        };
        Ok(Frame {
            name: name.to_string(),
            tbuffer: [t, counted(tbuffer)],
            rbuffer: [r, counted(rbuffer)],
            mbuffer: [m, counted(mbuffer)],
            prices: [tbuffer, rbuffer, mbuffer].map(Price::of),
            census,
            screen,
        })
    }

    /// Whether the clocked machines counted what the closed forms say.
    pub fn is_exact(&self) -> bool {
        [self.tbuffer, self.rbuffer, self.mbuffer].iter().all(|[form, counted]| form == counted)
    }
}

/// A percentage that the document prints.
pub struct Headline {
    /// What is compared.
    pub what: &'static str,
    /// What is printed, in percent.
    pub printed: f64,
    /// What comes out, in percent: the mean over the frames.
    pub found: f64,
}

impl Headline {
    /// Whether it comes out within two points.
    pub fn holds(&self) -> bool {
        (self.found - self.printed).abs() <= POINTS
    }
}

/// One section capacity: means over the frames, and the frames that take more than the R-buffer.
pub struct Capacity {
    /// Fragments in a section.
    pub capacity: u32,
    /// Storage against the R-buffer and against the M-buffer, in percent.
    pub storage: [f64; 2],
    /// Frames in which the T-buffer takes more storage than the R-buffer.
    pub above: Vec<String>,
}

/// All of it.
pub struct Reproduction {
    /// The frames.
    pub frames: Vec<Frame>,
    /// The section capacities.
    pub capacities: Vec<Capacity>,
}

/// How much more `a` is than `b` on average, in percent.
fn percent(pairs: impl ExactSizeIterator<Item = (u64, u64)>) -> f64 {
    let count = pairs.len() as f64;
    let ratios: f64 = pairs.map(|(a, b)| a as f64 / b as f64).sum();
    100.0 * (ratios / count - 1.0)
}

impl Reproduction {
    /// Compares the frames.
    ///
    /// # Errors
    /// The screen is too large for a machine.
    pub fn new(frames: Vec<Frame>) -> Result<Reproduction, ParamError> {
        let mut capacities = vec![];
        for capacity in CAPACITIES {
            let of = |frame: &Frame| tbuffer_bytes(&frame.census, frame.screen, capacity);
            let bytes: Vec<u64> = frames.iter().map(of).collect::<Result<_, _>>()?;
            let each = || bytes.iter().copied().zip(&frames);
            let above = each().filter(|(bytes, frame)| *bytes > frame.rbuffer[0].bytes);
            let above = above.map(|(_, frame)| frame.name.clone()).collect();
            let storage = [
                percent(each().map(|(bytes, frame)| (bytes, frame.rbuffer[0].bytes))),
                percent(each().map(|(bytes, frame)| (bytes, frame.mbuffer[0].bytes))),
            ];
            capacities.push(Capacity { capacity, storage, above });
        }
        Ok(Reproduction { frames, capacities })
    }

    /// The printed percentages beside those of the counted figures.
    pub fn headlines(&self) -> [Headline; 4] {
        let of = |part: fn(&Frame) -> (u64, u64)| percent(self.frames.iter().map(part));
        let line = |what, printed, found| Headline { what, printed, found };
        [
            line(
                "T-buffer accesses against R-buffer",
                -52.0,
                of(|f| (f.tbuffer[1].accesses, f.rbuffer[1].accesses)),
            ),
            line(
                "T-buffer accesses against M-buffer",
                27.0,
                of(|f| (f.tbuffer[1].accesses, f.mbuffer[1].accesses)),
            ),
            line(
                "T-buffer storage against R-buffer",
                -29.0,
                of(|f| (f.tbuffer[1].bytes, f.rbuffer[1].bytes)),
            ),
            line(
                "T-buffer storage against M-buffer",
                -67.0,
                of(|f| (f.tbuffer[1].bytes, f.mbuffer[1].bytes)),
            ),
        ]
    }

    /// Whether every count is its closed form, and every percentage within two points.
    pub fn is_reproduced(&self) -> bool {
        self.frames.iter().all(Frame::is_exact) && self.headlines().iter().all(Headline::holds)
    }

    fn needs(&self, title: &str, part: fn(&Need) -> u64) -> String {
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        table.add_row([title, "T counted", "T form", "R counted", "R form", "M counted", "M form"]);
        for frame in &self.frames {
            let [t, r, m] = [frame.tbuffer, frame.rbuffer, frame.mbuffer];
            let needs = [t[1], t[0], r[1], r[0], m[1], m[0]];
            let mut row = vec![format!("  {}", frame.name)];
            row.extend(needs.iter().map(|need| grouped(&json!(part(need)))));
            table.add_row(row);
        }
        align_right(&mut table, &[1, 2, 3, 4, 5, 6]);
        table.to_string()
    }

    /// What each frame costs in each machine.
    fn costs(&self) -> String {
        let mut table = Table::new();
        table.load_style(presets::NOTHING);
        let machines = ["T", "R", "M"];
        let heads = Price::NAMES.iter().flat_map(|name| {
            machines.map(|machine| format!("{machine} {}", name.split(',').next().unwrap_or(name)))
        });
        let head = "COSTS, nJ a frame and mm2".to_string();
        table.add_row([head].into_iter().chain(heads).collect::<Vec<_>>());
        for frame in &self.frames {
            let figures = frame.prices.map(|price| price.figures());
            let row = (0..Price::NAMES.len())
                .flat_map(|k| figures.map(|figures| Price::shown(figures[k])));
            table.add_row([format!("  {}", frame.name)].into_iter().chain(row).collect::<Vec<_>>());
        }
        align_right(&mut table, &[1, 2, 3, 4, 5, 6, 7, 8, 9]);
        table.to_string()
    }

    /// Everything as tables.
    pub fn table(&self) -> String {
        let mut headlines = Table::new();
        headlines.load_style(presets::NOTHING);
        headlines.add_row(["PERCENTAGES, means over the frames", "printed", "here"]);
        for Headline { what, printed, found } in self.headlines() {
            let row = [format!("  {what}"), format!("{printed:+.0} %"), format!("{found:+.1} %")];
            headlines.add_row(row);
        }
        align_right(&mut headlines, &[1, 2]);
        let mut capacities = Table::new();
        capacities.load_style(presets::NOTHING);
        capacities.add_row([
            "SECTION CAPACITY, fragments",
            "against R",
            "against M",
            "frames above R",
        ]);
        for Capacity { capacity, storage, above } in &self.capacities {
            let [r, m] = storage.map(|percent| format!("{percent:+.1} %"));
            capacities.add_row([format!("  {capacity}"), r, m, above.join(", ")]);
        }
        align_right(&mut capacities, &[1, 2]);
        let accesses = self.needs("ACCESSES, words", |need| need.accesses);
        let bytes = self.needs("STORAGE, bytes", |need| need.bytes);
        let costs = self.costs();
        at_margin(&format!("{accesses}\n{bytes}\n{headlines}\n{capacities}\n{costs}"))
    }

    /// Everything as JSON.
    pub fn json(&self) -> Json {
        let need = |need: &Need| json!({ "accesses": need.accesses, "bytes": need.bytes });
        let both = |[form, counted]: &[Need; 2]| json!({ "closed_form": need(form), "counted": need(counted) });
        let frames: Vec<Json> = self
            .frames
            .iter()
            .map(|frame| {
                json!({
                    "scene": frame.name,
                    "fragments": frame.census.stored,
                    "pixels": frame.census.pixels(),
                    "tbuffer": both(&frame.tbuffer),
                    "rbuffer": both(&frame.rbuffer),
                    "mbuffer": both(&frame.mbuffer),
                    "costs": {
                        "tbuffer": frame.prices[0].json(),
                        "rbuffer": frame.prices[1].json(),
                        "mbuffer": frame.prices[2].json(),
                    },
                })
            })
            .collect();
        let headlines: Vec<Json> = self
            .headlines()
            .iter()
            .map(|h| json!({ "what": h.what, "printed_percent": h.printed, "found_percent": h.found }))
            .collect();
        let capacities: Vec<Json> = self
            .capacities
            .iter()
            .map(|c| {
                let [r, m] = c.storage;
                json!({
                    "section_capacity": c.capacity,
                    "against_rbuffer_percent": r,
                    "against_mbuffer_percent": m,
                    "frames_above_rbuffer": c.above,
                })
            })
            .collect();
        json!({ "frames": frames, "headlines": headlines, "section_capacities": capacities })
    }
}
