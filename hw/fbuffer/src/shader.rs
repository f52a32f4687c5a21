//! The fragment program: a line of instructions for each pass.
//!
//! ```text
//!               +--------+
//!  fragment --->|        |---> shaded (Stream)
//!  values ----->| Shader |
//!  pass ------->|        |<--- advance
//!               +--------+
//! ```
//! A fragment a cycle; as many cycles from input to output as the longest pass has instructions, one in each stage. Registers
//! travel with their fragment. All of it stands while `advance` is low. An opaque fragment goes through
//! as it is. One that is killed goes through, too: whoever takes what leaves sees to it that it goes no further.

use crate::program::{
    COMPONENTS, Input, Instruction, MOST_INSTRUCTIONS, MOST_REGISTERS, MOST_TARGETS, MOST_VALUES,
    Op, Operand, Program, TEMPORARIES,
};
use crate::window::{self, Placed, Places};
use pellucid_machine::pixel::{Fragment, Marked, is_opaque};
use pellucid_machine::primitive::MOST_TRANSPARENT;
use pellucid_sim::{Block, Read, Signals, Stream, bits_for, check_range, rtl};

/// See the module's description.
pub struct Shader;

/// Parameters.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// Where a fragment has its place.
    pub window: window::Config,
    /// The program.
    pub program: Program,
    /// Targets of a pass, 1 to [`MOST_TARGETS`].
    pub targets: u32,
    /// Bits of a component, and of a register: 8 to 32.
    pub bits: u32,
}

impl Config {
    /// Words of what passes leave, wherever they lie: one for each place, or two where places are those of pixels.
    #[inline]
    pub fn words(&self) -> u32 {
        let buffers = if self.window.places == Places::Pixel { 2 } else { 1 };
        buffers * self.window.places()
    }
    /// Values that a pass leaves.
    #[inline]
    pub fn values(&self) -> u32 {
        COMPONENTS * self.targets
    }
    fn registers(&self) -> u32 {
        TEMPORARIES + self.values()
    }
    /// Stages.
    #[inline]
    pub fn stages(&self) -> u32 {
        self.program.longest()
    }
    /// Bits of a pass's number.
    pub fn pass_bits(&self) -> u32 {
        bits_for(u64::from(self.program.count - 1))
    }
    /// Whether a fragment that is killed keeps its place, and says so there.
    #[inline]
    pub fn tells(&self) -> bool {
        self.program.kills && !self.window.compacts
    }
    /// The greatest number of a register.
    #[inline]
    fn most(&self) -> u64 {
        (1 << self.bits) - 1
    }
}

/// What a pass leaves of a fragment: a word of the F-buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Values {
    /// Each value.
    #[width(cfg.bits)]
    #[len(cfg.values())]
    pub of: [u32; MOST_VALUES],
    /// It was killed.
    #[exists(cfg.tells())]
    pub killed: bool,
}

/// A fragment with its registers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Signals)]
pub struct Running {
    /// The fragment with its place.
    #[with(cfg.window)]
    pub placed: Placed,
    /// Its registers, the temporary ones first.
    #[width(cfg.bits)]
    #[len(cfg.registers())]
    pub registers: [u32; MOST_REGISTERS],
    /// It was killed; of an opaque one without meaning.
    #[exists(cfg.program.kills)]
    pub killed: bool,
}

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct State {
    /// What each instruction has made.
    #[with(*cfg)]
    #[len(cfg.stages())]
    pub stages: [Stream<Marked<Running>>; MOST_INSTRUCTIONS],
}

/// Inputs.
#[derive(Clone, Copy, Debug, Signals)]
pub struct In {
    /// Fragments, then the end of the play.
    #[with(cfg.window)]
    pub fragment: Stream<Marked<Placed>>,
    /// What the pass before has left of the fragment.
    #[with(*cfg)]
    pub values: Read<Values>,
    /// The pass.
    #[width(cfg.pass_bits())]
    pub pass: u32,
    /// All stages go on.
    pub advance: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
pub struct Moore {
    /// Fragments as their pass leaves them, then the end of the play.
    #[with(*cfg)]
    pub shaded: Stream<Marked<Running>>,
}

/// The upper bits of a number of `from` bits, or the number with zeros behind it: `to` bits.
#[inline(always)]
#[rtl]
fn scaled(number: u32, from: &u32, to: &u32) -> u32 {
    if *from > *to { number >> (*from - *to) } else { number << (*to - *from) }
}

/// The number that an operand is.
#[inline(always)]
#[rtl]
fn number(cfg: &Config, operand: &Operand, running: Running) -> u32 {
    let Fragment { x, y, z, rgba, .. } = running.placed.fragment;
    match *operand {
        Operand::Register(k) => running.registers[k as usize],
        Operand::Constant(k) => k << (cfg.bits - 8),
        Operand::Input(input) => match input {
            Input::X => scaled(x & 15, &4, &cfg.bits),
            Input::Y => scaled(y & 15, &4, &cfg.bits),
            Input::Z => scaled(z, &24, &cfg.bits),
            Input::Red => scaled(rgba >> 24, &8, &cfg.bits),
            Input::Green => scaled(rgba >> 16 & 0xff, &8, &cfg.bits),
            Input::Blue => scaled(rgba >> 8 & 0xff, &8, &cfg.bits),
            Input::Alpha => scaled(rgba & 0xff, &8, &cfg.bits),
        },
    }
}

/// Whether an instruction kills.
#[inline(always)]
#[rtl]
fn kills(cfg: &Config, of: &Instruction, running: Running) -> bool {
    number(cfg, &of.a, running) < number(cfg, &of.b, running)
}

/// What an instruction sets its register to.
#[inline(always)]
#[rtl]
fn result(cfg: &Config, of: &Instruction, running: Running) -> u32 {
    let a = number(cfg, &of.a, running);
    let b = number(cfg, &of.b, running);
    match of.op {
        Op::Add => {
            let sum = u64::from(a) + u64::from(b);
            sum.min(cfg.most()) as u32
        }
        Op::Sub => a.saturating_sub(b),
        Op::Mul => ((u64::from(a) * u64::from(b)) >> cfg.bits) as u32,
        Op::Min => a.min(b),
        Op::Max => a.max(b),
        Op::Select => {
            let c = number(cfg, &of.c, running);
            let held = running.registers[of.to as usize];
            if a < b { c } else { held }
        }
        Op::Kill => running.registers[of.to as usize],
    }
}

/// The values of a fragment.
#[inline(always)]
#[rtl]
pub fn values(cfg: &Config, running: Running) -> Values {
    let mut values = Values { of: [0; MOST_VALUES], killed: running.killed };
    for k in 0..cfg.values() {
        values.of[k as usize] = running.registers[(TEMPORARIES + k) as usize];
    }
    values
}

/// A fragment with the colour that its first four values are, or that it came with if it is opaque. None that is shaded
/// comes to be opaque.
#[inline(always)]
#[rtl]
pub fn coloured(cfg: &Config, running: Running) -> Fragment {
    let mut fragment = running.placed.fragment;
    let red = running.registers[TEMPORARIES as usize] >> (cfg.bits - 8);
    let green = running.registers[TEMPORARIES as usize + 1] >> (cfg.bits - 8);
    let blue = running.registers[TEMPORARIES as usize + 2] >> (cfg.bits - 8);
    let alpha = running.registers[TEMPORARIES as usize + 3] >> (cfg.bits - 8);
    if !is_opaque(fragment.rgba) {
        fragment.rgba = red << 24 | green << 16 | blue << 8 | alpha.min(MOST_TRANSPARENT);
    }
    fragment
}

#[rtl(
    check(Shader, crate::test_util::shader("tint", 1, 8)),
    check(Shader, crate::test_util::shader("glass", 1, 16)),
    check(Shader, crate::test_util::shader("glass", 2, 32)),
    check(Shader, crate::test_util::shader("random", 3, 32)),
    check(Shader, crate::test_util::shader("sieve", 1, 8))
)]
impl Block for Shader {
    type Config = Config;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = ();

    fn reset(cfg: &Config) -> State {
        check_range("the number of targets", cfg.targets, 1..=MOST_TARGETS);
        check_range("the bits of a component", cfg.bits, 8..=32);
        State { stages: [Stream::idle(); MOST_INSTRUCTIONS] }
    }

    fn memories(_: &Config) {}

    fn moore(cfg: &Config, q: &State, (): &()) -> Moore {
        Moore { shaded: q.stages[cfg.stages() as usize - 1] }
    }

    fn next(cfg: &Config, q: &State, d: &mut State, (): &mut (), i: In) {
        let Marked { end, item } = i.fragment.payload;
        let mut first = Running { placed: item, registers: [0; MOST_REGISTERS], killed: false };
        if i.pass > 0 {
            first.killed = i.values.data.killed;
            for k in 0..cfg.values() {
                first.registers[(TEMPORARIES + k) as usize] = i.values.data.of[k as usize];
            }
        }
        let entered = Stream { valid: i.fragment.valid, payload: Marked { end, item: first } };
        if i.advance {
            for k in 0..cfg.stages() {
                let before = if k == 0 { entered } else { q.stages[k as usize - 1] };
                d.stages[k as usize].valid = before.valid;
                if before.valid {
                    let running = before.payload.item;
                    let mut after = running;
                    for pass in 0..cfg.program.count {
                        if k < cfg.program.passes[pass as usize].length {
                            let of = cfg.program.passes[pass as usize].instructions[k as usize];
                            if i.pass == pass && of.op == Op::Kill {
                                after.killed = running.killed || kills(cfg, &of, running);
                            } else if i.pass == pass {
                                after.registers[of.to as usize] = result(cfg, &of, running);
                            }
                        }
                    }
                    d.stages[k as usize].payload = Marked { end: before.payload.end, item: after };
                }
            }
        }
    }
}

#[cfg(test)]
mod tests;
