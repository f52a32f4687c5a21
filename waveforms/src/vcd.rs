//! VCD: header by crate `vcd`, value changes by a table.
//!
//! Conventions: time 1 ns, a cycle lasts [`PERIOD_NS`]; `clk` rises when the cycle begins and falls
//! half-way; every other signal changes with the rise. All values stand under `$dumpvars` at the
//! start and again under `$dumpon` after a gap. Vectors carry their range, labels are strings. The names
//! of states stand in `$attrbegin` records, which Surfer and `wellen` read and others pass over. Only
//! changes are written.
//!
//! Crate `vcd` writes each bit of a value through a formatted write of its own. Here a value's bits
//! come from a table of all bytes, and every piece of text is a store of eight bytes of which the next one
//! overwrites what is too much.

use crate::layout::{Entry, Form, Layout, Walk};
use crate::wave::{Cycle, Format, PERIOD_NS, Whole};
use pellucid_sim::{Kind, Label, States};
use std::io::{self, Write};
use vcd::{IdCode, ReferenceIndex, ScopeType, TimescaleUnit, VarType};

/// `[b]` is byte `b` as eight digits.
pub(crate) static DIGITS: [[u8; 8]; 256] = digits();

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

    fn add_number(&mut self, number: impl itoa::Integer) {
        self.add_all(itoa::Buffer::new().format(number).as_bytes());
    }

    fn add_time(&mut self, time: u64) {
        self.add_all(b"#");
        self.add_number(time);
        self.add_all(b"\n");
    }
}

/// A signal of the file.
#[derive(Clone, Copy)]
struct Var {
    /// The bits of a value.
    width: u8,
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
        Var { width: width as u8, tail, tail_len: text.len() as u8 }
    }

    /// The longest that a change is, and eight bytes that may be stored beyond it: labels are shorter.
    const LONGEST: usize = 1 + 64 + 8 + 8;

    /// `1!` for one bit.
    #[inline(always)]
    fn digit(&self, digit: u8, to: &mut Text) {
        let mut tail = self.tail;
        tail[0] = digit;
        to.add(tail, self.tail_len.into());
    }

    /// `1!` for one bit, `b101 "` for more, without leading zeros. A value that is too wide loses its upper
    /// bits, as it would in hardware.
    fn change(&self, value: u64, to: &mut Text) {
        if self.width == 1 {
            return self.digit(b'0' + (value & 1) as u8, to);
        }
        to.add([b'b'; 8], 1);
        let value = value & u64::MAX >> (u64::BITS - u32::from(self.width));
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

    /// `s#3(1,2) "`; how many characters the label has.
    fn relabel(&self, label: Label, to: &mut Text) -> usize {
        to.add([b's'; 8], 1);
        let begin = to.len;
        if let Some(number) = label.number() {
            let (x, y) = label.place();
            to.add([b'#'; 8], 1);
            to.add_number(number);
            to.add([b'('; 8], 1);
            to.add_number(x);
            to.add([b','; 8], 1);
            to.add_number(y);
            to.add([b')'; 8], 1);
        }
        let chars = to.len - begin;
        to.add(self.tail, self.tail_len.into());
        chars
    }

    /// Unknown.
    fn unknown(&self, to: &mut Text) {
        if self.width == 1 {
            self.digit(b'x', to);
        } else {
            to.add_all(b"bx");
            to.add(self.tail, self.tail_len.into());
        }
    }
}

/// A value-change dump under way.
pub(crate) struct Vcd<W: Write> {
    out: W,
    clock: Var,
    cycle: Var,
    /// For each value its variable, if it is shown.
    values: Vec<Option<Var>>,
    /// For each label likewise.
    labels: Vec<Option<Var>>,
    text: Text,
    longest_label: usize,
}

impl<W: Write> Vcd<W> {
    /// Writes the header.
    pub(crate) fn new(mut out: W, layout: &Layout) -> io::Result<Vcd<W>> {
        let mut text = vec![];
        let mut writer = vcd::Writer::new(&mut text);
        // A fixed date, so that equal runs give equal files.
        writer.date("-")?;
        writer.version(concat!("pellucid ", env!("CARGO_PKG_VERSION")))?;
        writer.timescale(1, TimescaleUnit::NS)?;
        writer.scope_def(ScopeType::Module, "top")?;
        let clock = Var::new(writer.add_wire(1, "clk")?, 1);
        let range = ReferenceIndex::Range(CYCLE_BITS as i32 - 1, 0);
        let cycle = writer.add_var(VarType::Reg, CYCLE_BITS, "cycle", Some(range))?;
        let mut header = Header { out: writer, tables: vec![] };
        let mut values = vec![None; layout.values()];
        let mut labels = vec![None; layout.gates.len()];
        layout.walk(|step| {
            match step {
                Walk::Enter(name) => header.out.scope_def(ScopeType::Module, name)?,
                Walk::Leave => header.out.upscope()?,
                Walk::Entry(Entry { name, form: Form::Bits { at, width, kind }, .. }) => {
                    values[*at] = Some(header.signal(name, *width, *kind)?);
                }
                Walk::Entry(Entry { name, form: Form::Label { at }, .. }) => {
                    let id = header.out.add_var(VarType::String, 1, name, None)?;
                    // What ends a change of it is what ends a vector's.
                    labels[*at] = Some(Var::new(id, 0));
                }
            }
            io::Result::Ok(())
        })?;
        header.out.upscope()?;
        header.out.enddefinitions()?;
        out.write_all(&text)?;
        out.flush()?;
        let vars = layout.values() + layout.gates.len() + 2;
        let longest = 2 * STAMP + "$dumpvars\n$end\n".len() + vars * Var::LONGEST;
        let text = Text { bytes: vec![0; CHUNK + longest].into(), len: 0 };
        let cycle = Var::new(cycle, CYCLE_BITS);
        Ok(Vcd { out, clock, cycle, values, labels, text, longest_label: 0 })
    }

    /// Hands the text on if there is so much of it: always whole cycles.
    fn hand_on(&mut self, least: usize) -> io::Result<()> {
        if self.text.len >= least {
            self.out.write_all(&self.text.bytes[..self.text.len])?;
            self.out.flush()?;
            self.text.len = 0;
        }
        Ok(())
    }
}

impl<W: Write + Send> Format for Vcd<W> {
    fn cycle(&mut self, now: &Cycle) -> io::Result<()> {
        let Cycle { cycle, whole, changed, relabelled } = *now;
        let text = &mut self.text;
        text.add_time(cycle * PERIOD_NS);
        match whole {
            Whole::First => text.add_all(b"$dumpvars\n"),
            Whole::AfterGap => text.add_all(b"$dumpon\n"),
            Whole::No => {}
        }
        self.clock.digit(b'1', text);
        self.cycle.change(cycle, text);
        for (at, value) in changed {
            if let Some(var) = &self.values[*at as usize] {
                var.change(*value, text);
            }
        }
        for (at, label) in relabelled {
            if let Some(var) = &self.labels[*at as usize] {
                self.longest_label = self.longest_label.max(var.relabel(*label, text));
            }
        }
        if whole != Whole::No {
            text.add_all(b"$end\n");
        }
        text.add_time(cycle * PERIOD_NS + PERIOD_NS / 2);
        self.clock.digit(b'0', text);
        self.hand_on(CHUNK)
    }

    fn gap(&mut self, cycle: u64) -> io::Result<()> {
        let text = &mut self.text;
        text.add_time(cycle * PERIOD_NS);
        text.add_all(b"$dumpoff\n");
        self.clock.unknown(text);
        self.cycle.unknown(text);
        self.values.iter().flatten().for_each(|var| var.unknown(text));
        for var in self.labels.iter().flatten() {
            var.relabel(Label::NONE, text);
        }
        text.add_all(b"$end\n");
        // A window is complete: it is worth keeping.
        self.hand_on(0)
    }

    fn finish(&mut self, cycle: Option<u64>) -> io::Result<()> {
        if let Some(cycle) = cycle {
            self.text.add_time(cycle * PERIOD_NS);
        }
        self.hand_on(0)
    }

    fn longest_label(&self) -> usize {
        self.longest_label
    }
}

/// Bits of the cycle's number.
pub(crate) const CYCLE_BITS: u32 = 40;

/// Turns entries into the header's scopes and variables.
struct Header<W: Write> {
    out: vcd::Writer<W>,
    /// Tables of state names that the header has; the first has id 1.
    tables: Vec<&'static States>,
}

impl<W: Write> Header<W> {
    fn signal(&mut self, name: &str, width: u32, kind: Kind) -> io::Result<Var> {
        if let Kind::State(states) = kind {
            let id = self.table(states, width)?;
            writeln!(self.out.writer(), "$attrbegin misc 07 \"\" {id} $end")?;
        }
        let range = (width > 1).then_some(ReferenceIndex::Range(width as i32 - 1, 0));
        let id = self.out.add_var(VarType::Reg, width, name, range)?;
        Ok(Var::new(id, width))
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
