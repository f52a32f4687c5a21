//! VCD: header by crate `vcd`, value changes by a table.
//!
//! Conventions: time 1 ns, a cycle lasts [`PERIOD_NS`]; `clk` rises when the cycle begins and falls
//! half-way; every other signal changes with the rise. All values stand under `$dumpvars` at the
//! start and again under `$dumpon` after a gap. Vectors carry their range. The names of states stand
//! in `$attrbegin` records, which Surfer and `wellen` read and others pass over. Only changes are
//! written.
//!
//! Crate `vcd` writes each bit of a value through a formatted write of its own. Here a value's bits
//! come from a table of all bytes, every piece of text is a store of eight bytes of which the next one
//! overwrites what is too much, and a value is compared with the one shown as it is sampled.

use pellucid_sim::{Declare, Kind, Sink, States};
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

/// How much text is handed on at once.
const CHUNK: usize = 1 << 16;
/// The longest that a time stamp and the clock's change with it are.
const STAMP: usize = 32;

/// Text on its way to the file.
struct Text {
    bytes: Box<[u8]>,
    /// How many of them are text.
    len: usize,
}

impl Text {
    /// Adds the first `used` of eight bytes.
    #[inline(always)]
    fn add(&mut self, bytes: [u8; 8], used: usize) {
        self.bytes[self.len..self.len + 8].copy_from_slice(&bytes);
        self.len += used;
    }

    fn add_all(&mut self, bytes: &[u8]) {
        self.bytes[self.len..self.len + bytes.len()].copy_from_slice(bytes);
        self.len += bytes.len();
    }

    fn add_time(&mut self, time: u64) {
        self.add_all(b"#");
        self.add_all(itoa::Buffer::new().format(time).as_bytes());
        self.add_all(b"\n");
    }
}

/// A signal of the file.
#[derive(Clone, Copy)]
struct Var {
    /// It has one bit.
    flag: bool,
    /// What ends a change of it: its id and a line feed, after a byte that is a blank for vectors and the
    /// value for one bit.
    tail: [u8; 8],
    tail_len: u8,
}

impl Var {
    /// # Panics
    /// If the id is of more than six digits: 94^6 signals come before it.
    fn new(id: IdCode, width: u32) -> Var {
        let text = format!(" {id}\n");
        let mut tail = [0; 8];
        tail[..text.len()].copy_from_slice(text.as_bytes());
        Var { flag: width == 1, tail, tail_len: text.len() as u8 }
    }

    /// The longest that a change is, and eight bytes that may be stored beyond it.
    const LONGEST: usize = 1 + 64 + 8 + 8;

    /// `1!` for one bit.
    #[inline(always)]
    fn digit(&self, digit: u8, to: &mut Text) {
        let mut tail = self.tail;
        tail[0] = digit;
        to.add(tail, self.tail_len.into());
    }

    /// `1!` for one bit, `b101 "` for more, without leading zeros.
    fn change(&self, value: u64, to: &mut Text) {
        if self.flag {
            return self.digit(b'0' + (value & 1) as u8, to);
        }
        to.add([b'b'; 8], 1);
        let used = (u64::BITS - value.leading_zeros()).max(1);
        let mut rest = value << (u64::BITS - used);
        let start = to.len;
        for _ in 0..used.div_ceil(8) {
            to.add(DIGITS[(rest >> 56) as usize], 8);
            rest <<= 8;
        }
        to.len = start + used as usize;
        to.add(self.tail, self.tail_len.into());
    }
}

/// Takes a cycle's values and writes those that changed.
pub struct Changes<'a> {
    vars: &'a [Var],
    shown: &'a mut [u64],
    text: &'a mut Text,
    /// Which signal is next.
    at: usize,
    /// All ones to write every value, changed or not.
    all: u64,
}

impl Sink for Changes<'_> {
    #[inline(always)]
    fn push(&mut self, value: u64) {
        if (self.shown[self.at] ^ value) | self.all != 0 {
            self.write(value);
        }
        self.at += 1;
    }
}

impl Changes<'_> {
    #[inline(never)]
    fn write(&mut self, value: u64) {
        self.shown[self.at] = value;
        self.vars[self.at].change(value, self.text);
    }
}

/// A value-change dump under way.
pub struct Vcd<W: Write> {
    out: W,
    clock: Var,
    vars: Vec<Var>,
    /// What was shown last.
    shown: Vec<u64>,
    state: Showing,
    text: Text,
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
        let clock = Var::new(writer.add_wire(1, "clk")?, 1);
        let mut header = Header { out: &mut writer, vars: vec![], tables: vec![], result: Ok(()) };
        declare(&mut header);
        let Header { vars, result, .. } = header;
        result?;
        writer.upscope()?;
        writer.enddefinitions()?;
        out.write_all(&text)?;
        let shown = vec![0; vars.len()];
        let longest = 2 * STAMP + "$dumpvars\n$end\n".len() + vars.len() * Var::LONGEST;
        let text = Text { bytes: vec![0; CHUNK + longest].into(), len: 0 };
        Ok(Vcd { out, clock, vars, shown, state: Showing::NotYet, text })
    }

    /// Shows one cycle; `sample` tells every signal's value. Cycles must rise.
    ///
    /// # Errors
    /// Those of the writer.
    #[inline]
    pub fn cycle(&mut self, cycle: u64, sample: impl FnOnce(&mut Changes)) -> io::Result<()> {
        let all = self.state != Showing::Now;
        self.text.add_time(cycle * PERIOD_NS);
        if all {
            let first = self.state == Showing::NotYet;
            self.text.add_all(if first { b"$dumpvars\n" } else { b"$dumpon\n" });
        }
        self.clock.digit(b'1', &mut self.text);
        let Vcd { vars, shown, text, .. } = self;
        let all_ones = if all { u64::MAX } else { 0 };
        let mut changes = Changes { vars, shown, text, at: 0, all: all_ones };
        sample(&mut changes);
        debug_assert_eq!(changes.at, self.vars.len(), "one value per declared signal");
        if all {
            self.text.add_all(b"$end\n");
            self.state = Showing::Now;
        }
        self.text.add_time(cycle * PERIOD_NS + PERIOD_NS / 2);
        self.clock.digit(b'0', &mut self.text);
        self.hand_on(CHUNK)
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
        self.text.add_time(cycle * PERIOD_NS);
        self.text.add_all(b"$dumpoff\n");
        self.clock.digit(b'x', &mut self.text);
        for var in &self.vars {
            if var.flag {
                var.digit(b'x', &mut self.text);
            } else {
                self.text.add_all(b"bx");
                self.text.add(var.tail, var.tail_len.into());
            }
        }
        self.text.add_all(b"$end\n");
        self.hand_on(CHUNK)
    }

    /// Hands the text on if there is so much of it.
    fn hand_on(&mut self, least: usize) -> io::Result<()> {
        if self.text.len >= least {
            self.out.write_all(&self.text.bytes[..self.text.len])?;
            self.text.len = 0;
        }
        Ok(())
    }

    /// Ends the file and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self, cycle: u64) -> io::Result<W> {
        if self.state == Showing::Now {
            self.text.add_time(cycle * PERIOD_NS);
        }
        self.hand_on(0)?;
        self.out.flush()?;
        Ok(self.out)
    }
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
            header.vars.push(Var::new(id, width));
            Ok(())
        });
    }
}
