//! VCD: header by crate `vcd`, value changes by a table.
//!
//! Conventions: time 1 ns, a cycle lasts [`PERIOD_NS`]; `clk` rises when the cycle begins and falls
//! half-way; every other signal changes with the rise. All values stand under `$dumpvars` at the
//! start and again under `$dumpon` after a gap. Vectors carry their range. The names of states stand
//! in `$attrbegin` records, which Surfer and `wellen` read and others pass over. Only changes are
//! written.
//!
//! Crate `vcd` writes each bit of a value through a formatted write of its own; here a value's bits
//! come from a table of all bytes, and a cycle is one write.

use pellucid_sim::{Declare, Kind, States};
use std::io::{self, Write};
use vcd::{IdCode, ReferenceIndex, ScopeType, TimescaleUnit, VarType};

/// How long a clock cycle is on the time axis, in nanoseconds.
pub const PERIOD_NS: u64 = 10;

/// `[b]` is byte `b` as eight digits.
static DIGITS: [[u8; 8]; 256] = digits();

const fn digits() -> [[u8; 8]; 256] {
    let mut table = [[b'0'; 8]; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < 8 {
            if byte >> (7 - bit) & 1 == 1 {
                table[byte][bit] = b'1';
            }
            bit += 1;
        }
        byte += 1;
    }
    table
}

/// A signal of the file.
struct Var {
    width: u32,
    /// What ends a change of it: a blank for vectors, its id, a line feed.
    tail: Box<[u8]>,
}

/// A value-change dump under way.
pub struct Vcd<W: Write> {
    out: W,
    clock: IdCode,
    vars: Vec<Var>,
    values: Vec<u64>,
    /// What was shown last.
    shown: Vec<u64>,
    state: Showing,
    /// What one cycle writes.
    text: Vec<u8>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Showing {
    NotYet,
    Now,
    Gap,
}

impl<W: Write> Vcd<W> {
    /// Writes the header. `declare` declares all signals, in the order in which [`Vcd::cycle`] will
    /// get their values.
    ///
    /// # Errors
    /// Those of `out`.
    pub fn new(mut out: W, declare: impl FnOnce(&mut dyn Declare)) -> io::Result<Vcd<W>> {
        let mut text = vec![];
        let mut writer = vcd::Writer::new(&mut text);
        // A fixed date, so that equal runs give equal files.
        writer.date("-")?;
        writer.version(concat!("pellucid ", env!("CARGO_PKG_VERSION")))?;
        writer.timescale(1, TimescaleUnit::NS)?;
        writer.scope_def(ScopeType::Module, "top")?;
        let clock = writer.add_wire(1, "clk")?;
        let mut header = Header { out: &mut writer, vars: vec![], tables: vec![], result: Ok(()) };
        declare(&mut header);
        let Header { vars, result, .. } = header;
        result?;
        writer.upscope()?;
        writer.enddefinitions()?;
        out.write_all(&text)?;
        let (values, shown) = (vec![], vec![]);
        Ok(Vcd { out, clock, vars, values, shown, state: Showing::NotYet, text })
    }

    /// Shows one cycle; `sample` appends every signal's value. Cycles must rise.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn cycle(&mut self, cycle: u64, sample: impl FnOnce(&mut Vec<u64>)) -> io::Result<()> {
        self.values.clear();
        sample(&mut self.values);
        debug_assert_eq!(self.values.len(), self.vars.len(), "one value per declared signal");
        self.text.clear();
        push_time(&mut self.text, cycle * PERIOD_NS);
        if self.state == Showing::Now {
            push_clock(&mut self.text, self.clock, b'1');
            for ((var, value), shown) in self.vars.iter().zip(&self.values).zip(&mut self.shown) {
                if value != shown {
                    *shown = *value;
                    push_change(&mut self.text, var, *value);
                }
            }
        } else {
            let first = self.state == Showing::NotYet;
            self.text.extend_from_slice(if first { b"$dumpvars\n" } else { b"$dumpon\n" });
            push_clock(&mut self.text, self.clock, b'1');
            for (var, value) in self.vars.iter().zip(&self.values) {
                push_change(&mut self.text, var, *value);
            }
            self.text.extend_from_slice(b"$end\n");
            self.shown.clone_from(&self.values);
            self.state = Showing::Now;
        }
        push_time(&mut self.text, cycle * PERIOD_NS + PERIOD_NS / 2);
        push_clock(&mut self.text, self.clock, b'0');
        self.out.write_all(&self.text)
    }

    /// A gap begins with `cycle`: what the signals do until the next [`Vcd::cycle`] is not shown.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn gap(&mut self, cycle: u64) -> io::Result<()> {
        if self.state != Showing::Now {
            return Ok(());
        }
        self.state = Showing::Gap;
        self.text.clear();
        push_time(&mut self.text, cycle * PERIOD_NS);
        self.text.extend_from_slice(b"$dumpoff\n");
        push_clock(&mut self.text, self.clock, b'x');
        for var in &self.vars {
            self.text.extend_from_slice(if var.width == 1 { b"x" } else { b"bx" });
            self.text.extend_from_slice(&var.tail);
        }
        self.text.extend_from_slice(b"$end\n");
        self.out.write_all(&self.text)
    }

    /// Ends the file and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self, cycle: u64) -> io::Result<W> {
        if self.state == Showing::Now {
            self.text.clear();
            push_time(&mut self.text, cycle * PERIOD_NS);
            self.out.write_all(&self.text)?;
        }
        self.out.flush()?;
        Ok(self.out)
    }
}

fn push_time(text: &mut Vec<u8>, time: u64) {
    text.extend_from_slice(format!("#{time}\n").as_bytes());
}

fn push_clock(text: &mut Vec<u8>, clock: IdCode, value: u8) {
    text.push(value);
    text.extend_from_slice(clock.to_string().as_bytes());
    text.push(b'\n');
}

/// `1!` for one bit, `b101 "` for more, without leading zeros.
#[inline]
fn push_change(text: &mut Vec<u8>, var: &Var, value: u64) {
    if var.width == 1 {
        text.push(b'0' + (value & 1) as u8);
    } else {
        text.push(b'b');
        let used = (u64::BITS - value.leading_zeros()).max(1);
        let bytes = used.div_ceil(8);
        let mut buffer = [0; 64];
        for k in 0..bytes {
            let byte = (value >> (8 * (bytes - 1 - k))) as u8;
            buffer[8 * k as usize..8 * (k as usize + 1)].copy_from_slice(&DIGITS[byte as usize]);
        }
        text.extend_from_slice(&buffer[(8 * bytes - used) as usize..8 * bytes as usize]);
    }
    text.extend_from_slice(&var.tail);
}

/// Turns declarations into the header's scopes and variables.
struct Header<'a, W: Write> {
    out: &'a mut vcd::Writer<W>,
    vars: Vec<Var>,
    /// Tables of state names that the header has; the first has id 1.
    tables: Vec<&'static States>,
    result: io::Result<()>,
}

impl<W: Write> Header<'_, W> {
    fn attempt(&mut self, what: impl FnOnce(&mut Self) -> io::Result<()>) {
        if self.result.is_ok() {
            self.result = what(self);
        }
    }

    /// The id of a table of state names, which is written before its first use.
    fn table(&mut self, states: &'static States, width: u32) -> io::Result<usize> {
        if let Some(at) = self.tables.iter().position(|known| *known == states) {
            return Ok(at + 1);
        }
        self.tables.push(states);
        let id = self.tables.len();
        let States { name, variants } = states;
        let writer = self.out.writer();
        write!(writer, "$attrbegin misc 07 {name} {}", variants.len())?;
        for variant in *variants {
            write!(writer, " {variant}")?;
        }
        for value in 0..variants.len() {
            write!(writer, " {value:0width$b}", width = width as usize)?;
        }
        writeln!(writer, " {id} $end")?;
        Ok(id)
    }
}

impl<W: Write> Declare for Header<'_, W> {
    fn open(&mut self, name: &str) {
        self.attempt(|header| header.out.scope_def(ScopeType::Module, name));
    }
    fn close(&mut self) {
        self.attempt(|header| header.out.upscope());
    }
    fn signal(&mut self, name: &str, width: u32, kind: Kind) {
        self.attempt(|header| {
            if let Kind::State(states) = kind {
                let id = header.table(states, width)?;
                writeln!(header.out.writer(), "$attrbegin misc 07 \"\" {id} $end")?;
            }
            let range = (width > 1).then_some(ReferenceIndex::Range(width as i32 - 1, 0));
            let id = header.out.add_var(VarType::Reg, width, name, range)?;
            let tail = format!("{}{id}\n", if width == 1 { "" } else { " " });
            header.vars.push(Var { width, tail: tail.into_bytes().into() });
            Ok(())
        });
    }
}
