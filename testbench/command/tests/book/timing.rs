//! Timing diagrams as text: a T-buffer stores three fragments of one pixel and resolves them.
//!
//! A column is a clock cycle. A stream's row shows what is handed over, in brackets if it is offered
//! and not taken; a state's row shows each change; a memory's row shows the accesses asked for, `r`
//! and `w`.

use pellucid_blocks::allocator::FreeList;
use pellucid_blocks::chains::config::Scan;
use pellucid_blocks::front::Phase;
use pellucid_machine::pixel::{Fragment, Marked, Screen};
use pellucid_machine::{FragmentIn, outside};
use pellucid_sim::block::Cycle;
use pellucid_sim::{Handshake, Label, Memory, Sim, Stream, state_name};
use pellucid_tbuffer::TBuffer;
use pellucid_tbuffer::config::{Append, Config, Params};
use std::collections::BTreeMap;

/// Three pixels: the second has fragments.
const SCREEN: Screen = Screen { width: 3, height: 1, background: 0xffffff };

/// The frame: fragments of the second pixel, the nearest first.
const FRAGMENTS: [(&str, Fragment); 3] = [
    ("A", Fragment { x: 1, y: 0, z: 10, rgba: 0xff000080, label: Label::NONE }),
    ("B", Fragment { x: 1, y: 0, z: 30, rgba: 0x00ff0080, label: Label::NONE }),
    ("C", Fragment { x: 1, y: 0, z: 20, rgba: 0x0000ff80, label: Label::NONE }),
];

/// Characters of a column.
const COLUMN: usize = 7;
/// Characters of a row's name.
const NAME: usize = 11;

/// A signal in one cycle.
enum Cell {
    State(&'static str),
    Stream(String),
}

/// What was seen, cycle by cycle, from the first in which the machine was ready.
pub struct Timing {
    phases: Vec<Phase>,
    cycles: Vec<Vec<(&'static str, Cell)>>,
}

/// Runs the frame.
pub fn run(append: Append, scan: Scan) -> Timing {
    let params = Params {
        sections: 4,
        section_capacity: 2,
        append,
        scan,
        sorter_depth: 4,
        outside_sections: 0,
        ..Params::default()
    };
    let mut sim = Sim::<TBuffer<FreeList>>::new(Config::new(SCREEN, params).unwrap());
    let mut items: Vec<Marked<Fragment>> = FRAGMENTS.map(|(_, f)| Marked::item(f)).to_vec();
    items.push(Marked::end());
    let (mut sent, mut shown) = (0, 0);
    let mut timing = Timing { phases: vec![], cycles: vec![] };
    let mut before = traffic(&mut sim);
    while shown < SCREEN.pixels() {
        let fragment = items.get(sent).map_or(Stream::idle(), |item| Stream::offer(*item));
        // All sections are on chip.
        let outside = outside::In::default();
        let cycle = sim.clock(FragmentIn { fragment, image_ready: true, outside }).unwrap();
        sent += usize::from(cycle.out.fragment.fires());
        shown += u32::from(cycle.out.image.fires());
        let phase = cycle.out.phase;
        let mut cells = cells(&cycle);
        let now = traffic(&mut sim);
        if phase != Phase::Clear {
            for (row, memory) in MEMORIES {
                let [reads, writes] = [0, 1].map(|k| now[memory][k] > before[memory][k]);
                let text = [if reads { "r" } else { "" }, if writes { "w" } else { "" }].concat();
                cells.push((row, Cell::Stream(text)));
            }
            timing.phases.push(phase);
            timing.cycles.push(cells);
        }
        before = now;
    }
    timing
}

/// Rows of memories, and the memories.
const MEMORIES: [(&str, &str); 7] = [
    ("ssa", "chains.ssa.table"),
    ("nsa", "chains.nsa.table"),
    ("sections", "chains.sections.on_chip"),
    ("bitmap", "chains.occupancy.bitmap"),
    ("summary", "chains.occupancy.summary"),
    ("depth", "front.display.frame_buffer.depth_a"),
    ("colour", "front.display.frame_buffer.colour_a"),
];

/// Reads and writes of every memory so far.
fn traffic(sim: &mut Sim<TBuffer<FreeList>>) -> BTreeMap<String, [u64; 2]> {
    let mut traffic = BTreeMap::new();
    sim.memories().visit("", &mut |path, storage| {
        let info = storage.info();
        traffic.insert(path.to_string(), [info.reads, info.writes]);
    });
    traffic
}

/// The name of a fragment, by its colour.
fn letter(rgba: u32) -> String {
    let found = FRAGMENTS.iter().find(|(_, f)| f.rgba == rgba);
    found.map_or("?", |(name, _)| *name).to_string()
}

fn stream<T: Copy>(wires: Handshake<T>, text: impl Fn(T) -> String) -> Cell {
    let text = text(wires.payload);
    Cell::Stream(match (wires.valid, wires.ready) {
        (false, _) => String::new(),
        (true, false) => format!("({text})"),
        (true, true) => text,
    })
}

fn marked<T: pellucid_sim::Signals>(
    wires: Handshake<Marked<T>>,
    text: impl Fn(T) -> String,
) -> Cell {
    stream(wires, |Marked { end, item }| if end { "end".to_string() } else { text(item) })
}

fn cells(cycle: &Cycle<TBuffer<FreeList>>) -> Vec<(&'static str, Cell)> {
    let (q, o) = (cycle.q, cycle.out);
    // The pool offers a section all the time: what matters is when it is taken.
    let take = Handshake { valid: o.chains.grant.fires(), ..o.chains.grant };
    let pixel = |pixel: u32| format!("p{pixel}");
    let section = |section: u32| format!("s{section}");
    vec![
        ("phase", Cell::State(state_name(o.phase))),
        ("fragment", marked(o.fragment, |f| letter(f.rgba))),
        ("passed", marked(o.passed, |f| letter(f.rgba))),
        ("store", Cell::State(state_name(q.chains.store.fsm))),
        ("take", stream(take, section)),
        ("scan", Cell::State(state_name(q.chains.read_back.scan.fsm))),
        ("pixel", marked(o.chains.pixel, pixel)),
        ("chain", marked(o.chains.chain, |c| pixel(c.pixel))),
        ("reader", Cell::State(state_name(q.chains.read_back.reader.fsm))),
        ("arrived", marked(o.chains.arrived, |a| letter(a.rgba))),
        ("sorted", marked(o.sorted, |s| letter(s.rgba))),
        ("release", stream(o.chains.release, section)),
        ("scanout", Cell::State(state_name(q.front.display.scanout.fsm))),
        ("image", stream(o.image, |colour| format!("{colour:06x}"))),
    ]
}

impl Timing {
    /// The cycles until the frame is stored.
    pub fn store(&self) -> String {
        let rows = [
            "phase", "fragment", "passed", "store", "take", "ssa", "nsa", "sections", "bitmap",
            "summary", "depth",
        ];
        self.draw(0, self.start(Phase::Resolve), &rows)
    }

    /// The cycles of resolve.
    pub fn resolve(&self) -> String {
        let rows = [
            "phase", "scan", "pixel", "chain", "reader", "arrived", "sorted", "release", "ssa",
            "nsa", "sections", "bitmap", "summary", "depth", "colour",
        ];
        let from = self.start(Phase::Resolve);
        let cycles = self.phases[from..].iter().take_while(|p| **p == Phase::Resolve).count();
        self.draw(from - 1, from + cycles, &rows)
    }

    /// The cycles in which the image leaves.
    pub fn image(&self) -> String {
        let resolve = self.phases.iter().rposition(|p| *p == Phase::Resolve).unwrap();
        self.draw(resolve, self.cycles.len(), &["phase", "scanout", "image", "colour", "depth"])
    }

    fn start(&self, phase: Phase) -> usize {
        self.phases.iter().position(|p| *p == phase).unwrap()
    }

    fn draw(&self, from: usize, to: usize, rows: &[&str]) -> String {
        let numbers: String = (from..to).map(|cycle| format!("{cycle:<COLUMN$}")).collect();
        let mut text = format!("{:NAME$}{}\n", "cycle", numbers.trim_end());
        for row in rows {
            let mut before = "";
            let mut line = format!("{row:NAME$}");
            for cycle in &self.cycles[from..to] {
                let (_, cell) = cycle.iter().find(|(name, _)| name == row).unwrap();
                line += &match cell {
                    Cell::State(name) if *name == before => "─".repeat(COLUMN),
                    Cell::State(name) => {
                        before = name;
                        format!("{:─<COLUMN$}", format!("{name} "))
                    }
                    Cell::Stream(text) if text.is_empty() => format!("{:<COLUMN$}", "·"),
                    Cell::Stream(text) => format!("{text:<COLUMN$}"),
                };
            }
            text += &format!("{}\n", line.trim_end());
        }
        format!("```text\n{text}```\n")
    }
}
