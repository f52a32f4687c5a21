//! FST, by crate `fst-writer`: the same signals, times and names as the VCD.
//!
//! The crate writes no strings of any length and no tables of state names. A label is a vector of ASCII
//! characters, high impedance where there is none; states are numbers to which the viewers' set-ups give
//! names. There are no gaps in the format: what is not shown is unknown.
//!
//! Changes are gathered and written in blocks. What is on disk can be opened up to the last of them.

use crate::layout::{Entry, Form, Layout, Walk};
use crate::vcd::{CYCLE_BITS, DIGITS};
use crate::wave::{Cycle, Format, PERIOD_NS};
use fst_writer::{
    FstBodyWriter, FstFileType, FstHeaderWriter, FstInfo, FstScopeType, FstSignalId, FstSignalType,
    FstVarDirection, FstVarType, FstWriteError,
};
use pellucid_sim::Label;
use std::io::{self, Cursor, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, PoisonError};

/// How many bytes of changes are gathered for a block, about. The first blocks are smaller, so that there
/// soon is one: each is twice as large as the one before.
const BLOCK: usize = 2 << 20;
const FIRST_BLOCK: usize = 64 << 10;
/// Characters of the longest label.
pub(crate) const LABEL_CHARS: usize = 24;

/// Holds what is written until it is flushed, and writes it at once: the crate goes back in a block to fill in
/// its length, and a process that is stopped half-way must not leave half a block.
struct Held<W> {
    /// It stands at `base`.
    out: W,
    base: u64,
    held: Cursor<Vec<u8>>,
}

impl<W: Write> Write for Held<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.held.write(bytes)
    }
    fn flush(&mut self) -> io::Result<()> {
        let held = self.held.get_mut();
        self.out.write_all(held)?;
        self.base += held.len() as u64;
        held.clear();
        self.held.set_position(0);
        self.out.flush()
    }
}

impl<W: Write + Seek> Seek for Held<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let now = self.base + self.held.position();
        let within = match to {
            SeekFrom::Start(place) => Some(place),
            SeekFrom::Current(way) => now.checked_add_signed(way),
            SeekFrom::End(_) => None,
        };
        let held = self.held.get_ref().len() as u64;
        let place = within.and_then(|place| place.checked_sub(self.base));
        match place.filter(|place| *place <= held) {
            Some(place) => self.held.set_position(place),
            None => {
                self.flush()?;
                let to = within.map_or(to, SeekFrom::Start);
                self.base = self.out.seek(to)?;
            }
        }
        Ok(self.base + self.held.position())
    }
}

/// A writer that the crate writes to and that is flushed here after each block.
struct Shared<W>(Arc<Mutex<Held<W>>>);

impl<W> Shared<W> {
    fn with<T>(&self, act: impl FnOnce(&mut Held<W>) -> T) -> T {
        // One thread alone has it.
        act(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

impl<W: Write> Write for Shared<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.with(|out| out.write(bytes))
    }
    fn flush(&mut self) -> io::Result<()> {
        self.with(Held::flush)
    }
}

impl<W: Write + Seek> Seek for Shared<W> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.with(|out| out.seek(to))
    }
}

/// A variable: its id, and how many characters a value has.
#[derive(Clone, Copy)]
struct Var {
    id: FstSignalId,
    chars: usize,
}

/// An FST file under way.
pub(crate) struct Fst<W: Write + Seek> {
    out: Shared<W>,
    /// Nothing once the file has ended.
    body: Option<FstBodyWriter<Shared<W>>>,
    clock: Var,
    cycle: Var,
    /// For each value its variable, if it is shown.
    values: Vec<Option<Var>>,
    /// For each label likewise.
    labels: Vec<Option<Var>>,
    /// How many bytes are gathered for the block at hand.
    block: usize,
    /// What the crate says is gathered where nothing is: it counts a word for each signal.
    empty: usize,
    longest_label: usize,
}

/// The system's error, where there is one.
fn plain(error: FstWriteError) -> io::Error {
    match error {
        FstWriteError::Io(error) => error,
        other => io::Error::other(other),
    }
}

impl<W: Write + Seek> Fst<W> {
    /// Writes the header.
    pub(crate) fn new(out: W, layout: &Layout) -> io::Result<Fst<W>> {
        Fst::begin(out, layout).map_err(plain)
    }

    fn begin(out: W, layout: &Layout) -> fst_writer::Result<Fst<W>> {
        let held = Held { out, base: 0, held: Cursor::default() };
        let out = Arc::new(Mutex::new(held));
        let info = FstInfo {
            start_time: 0,
            timescale_exponent: -9,
            version: concat!("pellucid ", env!("CARGO_PKG_VERSION")).into(),
            // A fixed date, so that equal runs give equal files.
            date: "-".into(),
            file_type: FstFileType::Verilog,
        };
        let mut header = FstHeaderWriter::new(Shared(out.clone()), &info)?;
        header.scope("top", "", FstScopeType::Module)?;
        let var = |header: &mut FstHeaderWriter<Shared<W>>, name: &str, ty, bits: u32| {
            let name = if bits > 1 { format!("{name} [{}:0]", bits - 1) } else { name.to_string() };
            let (bits, chars) = (FstSignalType::bit_vec(bits), bits as usize);
            let id = header.var(name, bits, ty, FstVarDirection::Implicit, None)?;
            fst_writer::Result::Ok(Var { id, chars })
        };
        let clock = var(&mut header, "clk", FstVarType::Wire, 1)?;
        let cycle = var(&mut header, "cycle", FstVarType::Reg, CYCLE_BITS)?;
        let mut values = vec![None; layout.values()];
        let mut labels = vec![None; layout.gates.len()];
        layout.walk(|step| {
            match step {
                Walk::Enter(name) => header.scope(name, "", FstScopeType::Module)?,
                Walk::Leave => header.up_scope()?,
                Walk::Entry(Entry { name, form: Form::Bits { at, width, .. }, .. }) => {
                    values[*at] = Some(var(&mut header, name, FstVarType::Reg, *width)?);
                }
                Walk::Entry(Entry { name, form: Form::Label { at }, .. }) => {
                    let bits = 8 * LABEL_CHARS as u32;
                    labels[*at] = Some(var(&mut header, name, FstVarType::Reg, bits)?);
                }
            }
            fst_writer::Result::Ok(())
        })?;
        header.up_scope()?;
        let body = header.finish()?;
        let out = Shared(out);
        out.with(Held::flush)?;
        let empty = body.size();
        let (body, block, longest_label) = (Some(body), FIRST_BLOCK, 0);
        Ok(Fst { out, body, clock, cycle, values, labels, block, empty, longest_label })
    }

    fn body(&mut self) -> fst_writer::Result<&mut FstBodyWriter<Shared<W>>> {
        let ended = || io::Error::other("the file has ended").into();
        self.body.as_mut().ok_or_else(ended)
    }

    /// Writes what is gathered. A new time must follow: the crate takes no change between.
    fn write_block(&mut self) -> fst_writer::Result<()> {
        self.body()?.flush()?;
        Ok(self.out.with(Held::flush)?)
    }

    /// Goes on to a time, and writes a block before if enough is gathered.
    fn turn_to(&mut self, time: u64) -> fst_writer::Result<()> {
        if self.body()?.size() > self.empty + self.block {
            self.write_block()?;
            self.block = (2 * self.block).min(BLOCK);
        }
        self.body()?.time_change(time)
    }

    fn change(&mut self, var: Var, value: u64) -> fst_writer::Result<()> {
        let mut digits = [[0; 8]; 8];
        for (digits, byte) in digits.iter_mut().zip(value.to_be_bytes()) {
            *digits = DIGITS[usize::from(byte)];
        }
        self.body()?.signal_change(var.id, &digits.as_flattened()[64 - var.chars..])
    }

    fn relabel(&mut self, var: Var, label: Label) -> fst_writer::Result<()> {
        if label == Label::NONE {
            return self.body()?.signal_change(var.id, &[b'z'; 8 * LABEL_CHARS]);
        }
        let mut digits = [[b'0'; 8]; LABEL_CHARS];
        let text = label.to_string();
        self.longest_label = self.longest_label.max(text.len());
        for (digits, byte) in digits[LABEL_CHARS - text.len()..].iter_mut().zip(text.bytes()) {
            *digits = DIGITS[usize::from(byte)];
        }
        self.body()?.signal_change(var.id, digits.as_flattened())
    }

    fn show(&mut self, now: &Cycle) -> fst_writer::Result<()> {
        let Cycle { cycle, changed, relabelled, .. } = *now;
        self.turn_to(cycle * PERIOD_NS)?;
        self.change(self.clock, 1)?;
        self.change(self.cycle, cycle)?;
        for (at, value) in changed {
            if let Some(var) = self.values[*at as usize] {
                self.change(var, *value)?;
            }
        }
        for (at, label) in relabelled {
            if let Some(var) = self.labels[*at as usize] {
                self.relabel(var, *label)?;
            }
        }
        self.body()?.time_change(cycle * PERIOD_NS + PERIOD_NS / 2)?;
        self.change(self.clock, 0)
    }

    fn hide(&mut self, cycle: u64) -> fst_writer::Result<()> {
        self.turn_to(cycle * PERIOD_NS)?;
        let Fst { body, values, labels, clock, cycle, .. } = self;
        if let Some(body) = body {
            for var in values.iter().flatten().chain([&*clock, &*cycle]) {
                body.signal_change(var.id, &[b'x'; 64][..var.chars])?;
            }
            for var in labels.iter().flatten() {
                body.signal_change(var.id, &[b'z'; 8 * LABEL_CHARS])?;
            }
        }
        // A window is complete: it is worth keeping.
        self.write_block()
    }

    fn end(&mut self, cycle: Option<u64>) -> fst_writer::Result<()> {
        if let Some(cycle) = cycle {
            self.body()?.time_change(cycle * PERIOD_NS)?;
        }
        if let Some(body) = self.body.take() {
            body.finish()?;
        }
        Ok(self.out.with(Held::flush)?)
    }
}

impl<W: Write + Seek + Send> Format for Fst<W> {
    fn cycle(&mut self, now: &Cycle) -> io::Result<()> {
        self.show(now).map_err(plain)
    }

    fn gap(&mut self, cycle: u64) -> io::Result<()> {
        self.hide(cycle).map_err(plain)
    }

    fn finish(&mut self, cycle: Option<u64>) -> io::Result<()> {
        self.end(cycle).map_err(plain)
    }

    fn longest_label(&self) -> usize {
        self.longest_label
    }
}
