//! The frame with a waveform that crate `vcd` alone writes, as its documentation shows: a value that differs
//! from the one before is handed on as a vector of bits, through a buffered writer.

use crate::{Frame, Machine, Played, checksum};
use pellucid_machine::board::Board;
use pellucid_machine::pixel::Marked;
use pellucid_machine::{FragmentIn, Machine as _};
use pellucid_sim::block::Cycle;
use pellucid_sim::{Block, Declare, Kind, Signals, Sim, Stream};
use pellucid_tbuffer::config::{Config, Params};
use pellucid_tbuffer::{Out, State};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::Instant;
use vcd::{IdCode, TimescaleUnit, Value, VarType, Writer};

type Wave = Writer<BufWriter<File>>;

/// Writes the header.
struct Header<'a> {
    wave: &'a mut Wave,
    vars: Vec<(IdCode, u32)>,
}

impl Declare for Header<'_> {
    fn open(&mut self, name: &str) {
        self.wave.add_module(name).unwrap();
    }
    fn close(&mut self) {
        self.wave.upscope().unwrap();
    }
    fn signal(&mut self, name: &str, width: u32, _: Kind) {
        self.vars.push((self.wave.add_var(VarType::Reg, width, name, None).unwrap(), width));
    }
}

/// A waveform under way.
struct Dump {
    wave: Wave,
    clock: IdCode,
    vars: Vec<(IdCode, u32)>,
    shown: Vec<u64>,
}

impl Dump {
    fn new(path: &Path, cfg: &Config) -> Dump {
        let mut wave = Writer::new(BufWriter::new(File::create(path).unwrap()));
        wave.timescale(1, TimescaleUnit::NS).unwrap();
        wave.add_module("top").unwrap();
        let clock = wave.add_wire(1, "clk").unwrap();
        let mut header = Header { wave: &mut wave, vars: vec![] };
        <Machine as Block>::State::declare(cfg, "registers", &mut header);
        Out::declare(cfg, "wires", &mut header);
        let vars = header.vars;
        wave.upscope().unwrap();
        wave.enddefinitions().unwrap();
        // No value is all ones before it is shown.
        let shown = vec![u64::MAX; vars.len()];
        Dump { wave, clock, vars, shown }
    }

    fn cycle(&mut self, cycle: u64, values: &[u64]) {
        let Dump { wave, clock, vars, shown } = self;
        wave.timestamp(cycle * 10).unwrap();
        wave.change_scalar(*clock, Value::V1).unwrap();
        for ((new, old), (id, width)) in values.iter().zip(shown).zip(vars) {
            if new == old {
                continue;
            }
            *old = *new;
            if *width == 1 {
                wave.change_scalar(*id, *new & 1 == 1).unwrap();
            } else {
                let bits = (0..*width).rev().map(|bit| Value::from(*new >> bit & 1 == 1));
                wave.change_vector(*id, bits).unwrap();
            }
        }
        wave.timestamp(cycle * 10 + 5).unwrap();
        wave.change_scalar(*clock, Value::V0).unwrap();
    }
}

/// Plays the frame once; where `wave` is given, every cycle is written to it.
pub fn play(frame: &Frame, wave: Option<&Path>) -> Played {
    let mut sim = Sim::<Board<Machine>>::new(Config::new(frame.screen, Params::default()).unwrap());
    let mut pixels = Vec::with_capacity(frame.screen.pixels() as usize);
    let start = Instant::now();
    let mut dump = wave.map(|path| Dump::new(path, sim.config()));
    let items = frame.fragments.iter().map(|f| Marked::item(*f)).chain([Marked::end()]);
    let mut items = items.peekable();
    let mut values = vec![];
    while pixels.len() < frame.screen.pixels() as usize {
        let at = sim.cycle();
        let fragment = items.peek().map_or(Stream::idle(), |item| Stream::offer(*item));
        let outside = sim.memories().outside();
        let cycle = sim.clock(FragmentIn { fragment, image_ready: true, outside }).unwrap();
        let ports = Machine::ports(cycle.cfg, &cycle.out);
        if fragment.valid && ports.item_ready {
            items.next();
        }
        pixels.extend(ports.image.fires().then_some(ports.image.payload));
        if let Some(dump) = &mut dump {
            let Cycle { cfg, q, out } = cycle;
            values.clear();
            let q: &State<_> = q;
            q.sample(cfg, &mut values);
            out.sample(cfg, &mut values);
            dump.cycle(at, &values);
        }
    }
    // Its writer is flushed as it is dropped.
    drop(dump);
    let seconds = start.elapsed().as_secs_f64();
    Played { cycles: sim.cycle(), seconds, checksum: checksum(&pixels) }
}
