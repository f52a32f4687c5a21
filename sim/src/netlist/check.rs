//! Holds a module to the native source: both get the same registers, inputs and memories at random, and
//! must give the same outputs and the same next registers.
//!
//! Random registers and inputs can be ones that never occur together. Where the native arithmetic then
//! overflows, a value does not fit its register, or a memory is misused, the block has made no promise:
//! the case is passed over and not counted.

use super::elaborate::{Netlist, elaborate};
use super::evaluate::Evaluator;
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
    let module = elaborate::<B>(cfg);
    let mut evaluator = Evaluator::new(&module);
    let numbers = B::numbers();
    let state = Shape::of(|to| B::declare_state(cfg, to)).leaves;
    let outputs: Vec<Leaf> = module.outputs.iter().flat_map(|shape| shape.leaves.clone()).collect();
    let mut random = Random { x: 0x9e37_79b9_7f4a_7c15, recent: [0; 4] };
    let mut memories = B::memories(cfg);
    let mut q = B::reset(cfg);
    let mut compared = 0;
    for cycle in 0..CYCLES {
        if random.one_in(64) {
            q = B::reset(cfg);
            memories.reset();
            evaluator.reset();
        } else if random.one_in(4) {
            q = (numbers.to_state)(cfg, &mut random.values(&state).into_iter());
            let mut values = vec![];
            (numbers.state)(cfg, &q, &mut values);
            evaluator.set(&values);
        }
        let inputs = random.values(&module.inputs.leaves);
        let i = (numbers.to_in)(cfg, &mut inputs.iter().copied());
        let mut sampled = vec![];
        (numbers.input)(cfg, &i, &mut sampled);
        let native = catch_unwind(AssertUnwindSafe(|| {
            let mut d = q.clone();
            let (mut out, mut next) = (vec![], vec![]);
            (numbers.moore)(cfg, &B::moore(cfg, &q, &memories), &mut out);
            let o = B::next(cfg, &q, &mut d, &mut memories, i);
            (numbers.out)(cfg, &o, &mut out);
            (numbers.state)(cfg, &d, &mut next);
            (d, out, next)
        }));
        let promised = native.is_ok() && !misused(&mut memories);
        let found = evaluator.evaluate(&sampled);
        let found_next = evaluator.next();
        evaluator.edge();
        match native {
            Ok((d, out, next)) if promised && fits(&outputs, &out) && fits(&state, &next) => {
                let mut difference = String::new();
                let all = outputs.iter().zip(out.iter().zip(&found));
                let registers = state.iter().zip(next.iter().zip(&found_next));
                for (leaf, (native, module)) in all.chain(registers) {
                    if native != module {
                        let _ = write!(
                            difference,
                            "\n  {}: {native} in Rust, {module} in the netlist",
                            leaf.path
                        );
                    }
                }
                if !difference.is_empty() {
                    return Err(format!("`{}`, cycle {cycle}:{difference}", B::name(cfg)));
                }
                compared += 1;
                q = d;
            }
            _ => {
                // Both begin again, with empty memories.
                memories = B::memories(cfg);
                evaluator = Evaluator::new(&module);
                q = B::reset(cfg);
            }
        }
    }
    if compared < CYCLES / 16 {
        return Err(format!(
            "`{}`: only {compared} of {CYCLES} cycles could be compared",
            B::name(cfg)
        ));
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
