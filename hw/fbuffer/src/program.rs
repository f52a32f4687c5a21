//! Fragment programs: what is done with each fragment, pass by pass.
//!
//! A register holds a number of `component_bits` bits, a fraction of 2^`component_bits`: from 0 to short of 1. Sums stop at the
//! greatest number, differences at 0, and a product is rounded down. Two registers are *temporary*: what they hold ends with a pass.
//! All others are *values*: a pass leaves them in the F-buffer, and the next one finds them there. Before the first pass all
//! are 0; after the last one the first four are red, green, blue and alpha.
//!
//! This is the text of programs alone. The hardware that runs it is in [`shader`](crate::shader), and the plain model of a whole
//! program, which knows nothing of passes, in [`golden`](crate::golden).

use pellucid_machine::choice;

/// The most passes of a program.
pub const MOST_PASSES: usize = 4;
/// The most instructions of a pass.
pub const MOST_INSTRUCTIONS: usize = 12;
/// Registers whose contents end with a pass.
pub const TEMPORARIES: u32 = 2;
/// Values of one target.
pub const COMPONENTS: u32 = 4;
/// The most targets of a pass.
pub const MOST_TARGETS: u32 = 4;
/// The most values.
pub const MOST_VALUES: usize = (COMPONENTS * MOST_TARGETS) as usize;
/// The most registers.
pub const MOST_REGISTERS: usize = MOST_VALUES + TEMPORARIES as usize;

choice! {
    /// What is done with each transparent fragment.
    pub enum Kind {
        /// It keeps its colour: one pass.
        Tint = "tint",
        /// The same in two passes: the first one leaves the colour to the second.
        Restore = "restore",
        /// Pitted thin glass: absorption, pits and an edge in three passes.
        Glass = "glass",
        /// A sheet with a hole in each tile that thins out with depth, in three passes, two of which kill fragments.
        Sieve = "sieve",
        /// Drawn from a seed: two to four passes, which may kill.
        Random = "random",
    }
}

/// What a fragment brings along.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// Its column among 16: a sixteenth for each.
    X,
    /// Its row among 16.
    Y,
    /// Its depth: 1 would be behind the far plane.
    Z,
    /// Its colour, each level a 256th.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Alpha.
    Alpha,
}

/// Where a number comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operand {
    /// A register: first the temporary ones, then the values.
    Register(u32),
    /// What the fragment brings along.
    Input(Input),
    /// So many 256ths, at most 255.
    Constant(u32),
}

/// What an instruction does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Op {
    /// `a + b`.
    Add,
    /// `a - b`.
    Sub,
    /// `a * b`.
    Mul,
    /// The smaller of `a` and `b`.
    Min,
    /// The greater of `a` and `b`.
    Max,
    /// `c` where `a` is less than `b`, else what the register holds.
    Select,
    /// The fragment is killed where `a` is less than `b`: it is not blended. No register is set.
    Kill,
}

/// An instruction: one register is set, or a fragment killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// What it does.
    pub op: Op,
    /// The register that is set.
    pub to: u32,
    /// The first operand.
    pub a: Operand,
    /// The second one.
    pub b: Operand,
    /// The third one, of `Select`.
    pub c: Operand,
}

/// A pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pass {
    /// Its instructions; those from `length` on are without meaning.
    pub instructions: [Instruction; MOST_INSTRUCTIONS],
    /// How many there are.
    pub length: u32,
}

/// A program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Program {
    /// Its passes; those from `count` on are without meaning.
    pub passes: [Pass; MOST_PASSES],
    /// How many there are, at least 1.
    pub count: u32,
    /// It may kill a fragment.
    pub kills: bool,
}

const NOTHING: Instruction = {
    let zero = Operand::Constant(0);
    Instruction { op: Op::Max, to: 0, a: zero, b: zero, c: zero }
};

/// A temporary register.
const fn t(k: u32) -> Operand {
    Operand::Register(k)
}

/// A value.
const fn v(k: u32) -> Operand {
    Operand::Register(TEMPORARIES + k)
}

const X: Operand = Operand::Input(Input::X);
const Y: Operand = Operand::Input(Input::Y);
const Z: Operand = Operand::Input(Input::Z);
const RED: Operand = Operand::Input(Input::Red);
const GREEN: Operand = Operand::Input(Input::Green);
const BLUE: Operand = Operand::Input(Input::Blue);
const ALPHA: Operand = Operand::Input(Input::Alpha);

const fn constant(k: u32) -> Operand {
    Operand::Constant(k)
}

/// `to` is a register.
fn instruction(op: Op, to: Operand, a: Operand, b: Operand) -> Instruction {
    let to = if let Operand::Register(to) = to { to } else { 0 };
    Instruction { op, to, a, b, ..NOTHING }
}

impl Pass {
    fn of(of: &[Instruction]) -> Pass {
        let mut instructions = [NOTHING; MOST_INSTRUCTIONS];
        instructions[..of.len()].copy_from_slice(of);
        Pass { instructions, length: of.len() as u32 }
    }

    /// Its instructions.
    pub fn list(&self) -> &[Instruction] {
        &self.instructions[..self.length as usize]
    }
}

impl Program {
    fn of(of: &[Pass]) -> Program {
        let mut passes = [Pass::of(&[]); MOST_PASSES];
        passes[..of.len()].copy_from_slice(of);
        let kills = of.iter().flat_map(Pass::list).any(|i| i.op == Op::Kill);
        Program { passes, count: of.len() as u32, kills }
    }

    /// The program of that kind, for so many targets; a random one is drawn from `seed`.
    pub fn new(kind: Kind, seed: u32, targets: u32) -> Program {
        match kind {
            Kind::Tint => Program::of(&[colour()]),
            Kind::Restore => Program::of(&[colour(), Pass::of(&[])]),
            Kind::Glass => glass(),
            Kind::Sieve => sieve(),
            Kind::Random => random(seed, targets),
        }
    }

    /// Its passes.
    pub fn list(&self) -> &[Pass] {
        &self.passes[..self.count as usize]
    }

    /// Instructions of the longest pass.
    pub fn longest(&self) -> u32 {
        self.list().iter().map(|pass| pass.length).max().unwrap_or_default()
    }
}

/// The colour that a fragment comes with.
fn colour() -> Pass {
    let keep = |k, input| instruction(Op::Max, v(k), input, input);
    Pass::of(&[keep(0, RED), keep(1, GREEN), keep(2, BLUE), keep(3, ALPHA)])
}

/// In `t(0)` and `t(1)`: how far a fragment is from the middle of its tile of 16 x 16 pixels in each direction, 1/2 at most. `free` is set.
fn from_middle(free: Operand) -> [Instruction; 6] {
    use Op::{Max, Sub};
    let (i, half) = (instruction, constant(128));
    [
        i(Sub, t(0), X, half),
        i(Sub, t(1), half, X),
        i(Max, t(0), t(0), t(1)),
        i(Sub, t(1), Y, half),
        i(Sub, free, half, Y),
        i(Max, t(1), t(1), free),
    ]
}

fn glass() -> Program {
    use Op::{Add, Max, Min, Mul, Sub};
    let i = instruction;
    // What comes from afar has less red and green, and still less blue.
    let absorption = [
        i(Mul, t(0), Z, constant(160)),
        i(Sub, t(0), constant(255), t(0)),
        i(Mul, v(0), RED, t(0)),
        i(Mul, v(1), GREEN, t(0)),
        i(Mul, t(0), t(0), t(0)),
        i(Mul, v(2), BLUE, t(0)),
    ];
    // A pit in each tile of 16 x 16 pixels, the deeper the nearer to its middle.
    let depth = [i(Max, v(3), t(0), t(1)), i(Min, v(3), v(3), constant(64))];
    let pits = [&from_middle(v(3))[..], &depth].concat();
    // Pits are darker; and the less is let through, the less of white is reflected.
    let edge = [
        i(Add, t(0), v(3), v(3)),
        i(Add, t(0), t(0), constant(128)),
        i(Mul, v(0), v(0), t(0)),
        i(Mul, v(1), v(1), t(0)),
        i(Mul, v(2), v(2), t(0)),
        i(Sub, t(1), constant(255), ALPHA),
        i(Mul, t(1), t(1), t(1)),
        i(Mul, t(1), t(1), constant(96)),
        i(Add, v(0), v(0), t(1)),
        i(Add, v(1), v(1), t(1)),
        i(Add, v(2), v(2), t(1)),
        i(Add, v(3), ALPHA, t(1)),
    ];
    Program::of(&[Pass::of(&absorption), Pass::of(&pits), Pass::of(&edge)])
}

fn sieve() -> Program {
    use Op::{Kill, Max, Mul, Sub};
    let i = instruction;
    // A hole of 11 x 11 pixels.
    let hole = [
        i(Max, t(0), t(0), t(1)),
        i(Kill, t(0), t(0), constant(96)),
        i(Max, v(0), RED, RED),
        i(Max, v(1), GREEN, GREEN),
        i(Max, v(2), BLUE, BLUE),
    ];
    // The farther away, the thinner; an alpha test takes what is next to nothing.
    let fog = [i(Mul, t(0), Z, constant(128)), i(Sub, t(0), constant(255), t(0))];
    let thins = [i(Mul, v(3), ALPHA, t(0)), i(Kill, v(3), v(3), constant(32))];
    // And the darker.
    let darkens = [0, 1, 2].map(|k| i(Mul, v(k), v(k), t(0)));
    Program::of(&[
        Pass::of(&[&from_middle(v(3))[..], &hole].concat()),
        Pass::of(&[fog, thins].concat()),
        Pass::of(&[&fog[..], &darkens].concat()),
    ])
}

/// Numbers at random: xorshift, Marsaglia 2003.
struct Draw(u64);

impl Draw {
    /// A number below `bound`.
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        ((self.0 >> 33) as usize) % bound
    }
}

fn random(seed: u32, targets: u32) -> Program {
    const OPS: [Op; 6] = [Op::Add, Op::Sub, Op::Mul, Op::Min, Op::Max, Op::Select];
    /// One instruction of so many kills.
    const KILLS: usize = 12;
    const INPUTS: [Operand; 7] = [X, Y, Z, RED, GREEN, BLUE, ALPHA];
    let mut draw = Draw(u64::from(seed) << 20 | 0x9_e377);
    // The first numbers of neighbouring seeds are alike.
    (0..8).for_each(|_| _ = draw.below(1));
    let values = (COMPONENTS * targets) as usize;
    let mut pass = || {
        // A temporary register is read if this pass has set it.
        let mut readable: Vec<Operand> = (0..values as u32).map(v).collect();
        let operand = |draw: &mut Draw, readable: &[Operand]| match draw.below(3) {
            0 => INPUTS[draw.below(INPUTS.len())],
            1 => constant(draw.below(256) as u32),
            _ => readable[draw.below(readable.len())],
        };
        let mut instructions = vec![];
        for _ in 0..=draw.below(8) {
            let kills = draw.below(KILLS) == 0;
            let op = if kills { Op::Kill } else { OPS[draw.below(OPS.len())] };
            let [a, b, c] = [(); 3].map(|()| operand(&mut draw, &readable));
            let temporary = draw.below(4) == 0 && !matches!(op, Op::Select | Op::Kill);
            let to = if temporary { t(draw.below(2) as u32) } else { v(draw.below(values) as u32) };
            instructions.push(Instruction { c, ..instruction(op, to, a, b) });
            if !readable.contains(&to) {
                readable.push(to);
            }
        }
        (Pass::of(&instructions), draw.below(MOST_PASSES - 1))
    };
    let (first, further) = pass();
    let mut passes = vec![first];
    passes.extend((0..=further).map(|_| pass().0));
    Program::of(&passes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_programs_read_no_temporary_register_that_their_pass_has_not_set() {
        let (mut ops, mut counts) = (vec![], vec![]);
        for seed in 0..200 {
            for targets in 1..=MOST_TARGETS {
                let program = Program::new(Kind::Random, seed, targets);
                counts.push(program.count);
                for pass in program.list() {
                    let mut set = vec![];
                    for Instruction { op, to, a, b, c } in pass.list() {
                        ops.push(*op);
                        let third = (*op == Op::Select).then_some(*c);
                        let holds = (*op == Op::Select).then_some(Operand::Register(*to));
                        for read in [*a, *b].into_iter().chain(third).chain(holds) {
                            if let Operand::Register(k) = read {
                                assert!(k < TEMPORARIES + COMPONENTS * targets);
                                assert!(k >= TEMPORARIES || set.contains(&k));
                            }
                        }
                        set.extend((*op != Op::Kill).then_some(*to));
                    }
                }
            }
        }
        let all = [Op::Add, Op::Sub, Op::Mul, Op::Min, Op::Max, Op::Select, Op::Kill];
        assert!(all.iter().all(|op| ops.contains(op)));
        assert!((2..=MOST_PASSES as u32).all(|count| counts.contains(&count)));
        assert!(!counts.contains(&1));
    }
}
