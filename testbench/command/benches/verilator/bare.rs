//! A waveform that crate `vcd` alone writes, as its documentation shows: a value that differs from the one before is
//! handed on as a vector of bits, through a buffered writer.

use pellucid_machine::dut::{At, Dut, Observed, Observer, Quiet};
use pellucid_sim::{Declare, Kind, Label, Sampler};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use vcd::{IdCode, TimescaleUnit, Value, VarType, Writer};

type Wave = Writer<BufWriter<File>>;

/// Writes the header.
struct Header<'a> {
    wave: &'a mut Wave,
    vars: Vec<(IdCode, u32)>,
    labels: usize,
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
    fn label(&mut self, _: &str) {
        self.labels += 1;
    }
}

/// A waveform under way. Its writer is flushed as it is dropped.
pub struct Dump {
    wave: Wave,
    clock: IdCode,
    vars: Vec<(IdCode, u32)>,
    values: Vec<u64>,
    labels: Vec<Label>,
    changed: Vec<(u32, u64)>,
}

impl Dump {
    /// Begins the waveform `path` of a machine.
    pub fn new(path: &Path, dut: &dyn Dut) -> Dump {
        let mut wave = Writer::new(BufWriter::new(File::create(path).unwrap()));
        wave.timescale(1, TimescaleUnit::NS).unwrap();
        wave.add_module("top").unwrap();
        let clock = wave.add_wire(1, "clk").unwrap();
        let mut header = Header { wave: &mut wave, vars: vec![], labels: 0 };
        dut.declare(&mut header);
        let Header { vars, labels, .. } = header;
        wave.upscope().unwrap();
        wave.enddefinitions().unwrap();
        // No value is all ones before it is shown.
        let values = vec![u64::MAX; vars.len()];
        Dump { wave, clock, vars, values, labels: vec![Label::NONE; labels], changed: vec![] }
    }
}

impl Observer for Dump {
    fn cycle(&mut self, at: At, seen: &dyn Observed) -> Quiet {
        let Dump { wave, clock, vars, values, labels, changed } = self;
        let At { time: Some(time), phase } = at else {
            return Quiet { phase: at.phase, until: u64::MAX };
        };
        seen.sample(&mut Sampler::new(values, labels, changed));
        wave.timestamp(time * 10).unwrap();
        wave.change_scalar(*clock, Value::V1).unwrap();
        for (number, value) in changed.drain(..) {
            let (id, width) = vars[number as usize];
            if width == 1 {
                wave.change_scalar(id, value & 1 == 1).unwrap();
            } else {
                let bits = (0..width).rev().map(|bit| Value::from(value >> bit & 1 == 1));
                wave.change_vector(id, bits).unwrap();
            }
        }
        wave.timestamp(time * 10 + 5).unwrap();
        wave.change_scalar(*clock, Value::V0).unwrap();
        Quiet { phase, until: 0 }
    }
}
