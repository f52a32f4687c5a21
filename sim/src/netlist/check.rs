//! Holds a module to the native source: both get the same registers, inputs and memories at random, and
//! must give the same outputs and the same next registers.
//!
//! Random registers and inputs can be ones that never occur together. Where the native arithmetic then
//! overflows, a value does not fit its register, or a memory is misused, the block has made no promise:
//! the case is passed over and not counted.

use super::elaborate::{Netlist, elaborate};
use super::evaluate::Evaluator;
use super::module::Module;
use super::node::mask;
use super::shape::{Leaf, Shape};
use crate::memory::{FaultKind, Memory};
use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Cycles that are tried.
const CYCLES: u32 = 4000;

/// A fixed, irregular sequence of numbers (xorshift).
struct Random {
    x: u64,
    recent: [u64; 4],
}

impl Random {
    fn next(&mut self) -> u64 {
        self.x ^= self.x << 13;
        self.x ^= self.x >> 7;
        self.x ^= self.x << 17;
        self.x
    }
    fn one_in(&mut self, n: u64) -> bool {
        self.next().is_multiple_of(n)
    }
    /// A number of `width` bits: any, a small one, a large one, or one that came before.
    fn value(&mut self, width: u32) -> u64 {
        let any = self.next();
        let value = match self.next() % 4 {
            0 => any,
            1 => any % 4,
            2 => (any % 4).wrapping_neg(),
            _ => self.recent[(any % 4) as usize],
        } & mask(width);
        self.recent[(any % 4) as usize] = value;
        value
    }
    fn values(&mut self, leaves: &[Leaf]) -> Vec<u64> {
        leaves.iter().map(|leaf| self.value(leaf.width)).collect()
    }
}

fn fits(leaves: &[Leaf], values: &[u64]) -> bool {
    leaves.iter().zip(values).all(|(leaf, value)| *value <= mask(leaf.width))
}

/// Compares a block with its module over some thousand random cycles.
///
/// # Errors
/// The first difference: which signal, what the native source gives and what the module gives; or that
/// hardly any case was one in which the block makes a promise.
pub fn agrees<B: Netlist>(cfg: &B::Config) -> Result<(), String> {
    let state = Shape::of(|to| B::declare_state(cfg, to)).leaves;
    let q = B::reset(cfg);
    let mut source = Source::<B> { cfg, d: q.clone(), q, memories: B::memories(cfg) };
    compare(&mut source, &elaborate::<B>(cfg), &state)
        .map_err(|difference| format!("`{}`{difference}", B::name(cfg)))
}

/// The native source of a block, whatever block it is: what compares it is compiled once for all.
trait Native {
    /// The block is in reset; `anew` with empty memories.
    fn reset(&mut self, anew: bool);
    /// Sets the registers. Gives what they hold then.
    fn set(&mut self, registers: Vec<u64>) -> Vec<u64>;
    /// A cycle with these inputs, before the edge.
    fn cycle(&mut self, inputs: &[u64]) -> Given;
    /// The edge: the registers take what the cycle gave them.
    fn edge(&mut self);
}

/// What is given in a cycle.
struct Given {
    /// The inputs, as far as there are such.
    inputs: Vec<u64>,
    /// Outputs and next registers; nothing where the block makes no promise.
    promised: Option<[Vec<u64>; 2]>,
}

struct Source<'a, B: Netlist> {
    cfg: &'a B::Config,
    q: B::State,
    d: B::State,
    memories: B::Mem,
}

impl<B: Netlist> Native for Source<'_, B> {
    fn reset(&mut self, anew: bool) {
        self.q = B::reset(self.cfg);
        if anew {
            self.memories = B::memories(self.cfg);
        } else {
            self.memories.reset();
        }
    }
    fn set(&mut self, registers: Vec<u64>) -> Vec<u64> {
        let numbers = B::numbers();
        self.q = (numbers.to_state)(self.cfg, &mut registers.into_iter());
        let mut values = vec![];
        (numbers.state)(self.cfg, &self.q, &mut values);
        values
    }
    fn cycle(&mut self, inputs: &[u64]) -> Given {
        let Source { cfg, q, d, memories } = self;
        let numbers = B::numbers();
        let i = (numbers.to_in)(cfg, &mut inputs.iter().copied());
        let mut inputs = vec![];
        (numbers.input)(cfg, &i, &mut inputs);
        let native = catch_unwind(AssertUnwindSafe(|| {
            *d = q.clone();
            let (mut out, mut next) = (vec![], vec![]);
            (numbers.moore)(cfg, &B::moore(cfg, q, memories), &mut out);
            let o = B::next(cfg, q, d, memories, i);
            (numbers.out)(cfg, &o, &mut out);
            (numbers.state)(cfg, d, &mut next);
            [out, next]
        }));
        Given { inputs, promised: native.ok().filter(|_| !misused(memories)) }
    }
    fn edge(&mut self) {
        self.q = self.d.clone();
    }
}

/// [`agrees`] for a block with registers of these signals.
fn compare(native: &mut dyn Native, module: &Module, state: &[Leaf]) -> Result<(), String> {
    let mut evaluator = Evaluator::new(module);
    let outputs: Vec<Leaf> = module.outputs.iter().flat_map(|shape| shape.leaves.clone()).collect();
    let mut random = Random { x: 0x9e37_79b9_7f4a_7c15, recent: [0; 4] };
    let mut compared = 0;
    for cycle in 0..CYCLES {
        if random.one_in(64) {
            native.reset(false);
            evaluator.reset();
        } else if random.one_in(4) {
            evaluator.set(&native.set(random.values(state)));
        }
        let Given { inputs, promised } = native.cycle(&random.values(&module.inputs.leaves));
        let found = evaluator.evaluate(&inputs);
        let found_next = evaluator.next();
        evaluator.edge();
        let fitting = promised.filter(|[out, next]| fits(&outputs, out) && fits(state, next));
        let Some([out, next]) = fitting else {
            // Both begin again.
            native.reset(true);
            evaluator = Evaluator::new(module);
            continue;
        };
        let all = outputs.iter().zip(out.iter().zip(&found));
        let registers = state.iter().zip(next.iter().zip(&found_next));
        let mut difference = String::new();
        for (Leaf { path, .. }, (native, found)) in all.chain(registers) {
            if native != found {
                let _ = write!(difference, "\n  {path}: {native} in Rust, {found} in the netlist");
            }
        }
        if !difference.is_empty() {
            return Err(format!(", cycle {cycle}:{difference}"));
        }
        compared += 1;
        native.edge();
    }
    if compared < CYCLES / 16 {
        return Err(format!(": only {compared} of {CYCLES} cycles could be compared"));
    }
    Ok(())
}

/// Clocks the memories; whether one of them was misused. To read a word that was never written is none
/// here: it is 0 on both sides.
fn misused(memories: &mut impl Memory) -> bool {
    let mut misused = false;
    if memories.clock() {
        memories.visit("", &mut |_, storage| {
            let fault = storage.take_fault();
            misused |= fault.is_some_and(|kind| !matches!(kind, FaultKind::Unwritten(_)));
        });
    }
    misused
}
