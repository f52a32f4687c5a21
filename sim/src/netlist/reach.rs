//! What of a module has an effect that can be seen from outside.

use super::evaluate::{Dissolve, Flat, Port, Register};
use super::module::Module;

/// What of a register or of a memory another thing depends on.
#[derive(Clone, Copy)]
enum Needs {
    Operation(usize),
    Register(usize),
    /// That a memory shows a word.
    Shown(usize),
    /// A field of its words.
    Field(usize, usize),
}

/// The registers of a module and its children, and the fields of their memories' words, that no output of the module
/// depends on: by their paths. A register that never changes is not told.
pub fn without_effect(module: &Module) -> Vec<String> {
    let (mut dissolve, outputs) = Dissolve::of(module);
    let (mut registers, mut rams) = (vec![], vec![]);
    for at in 0..dissolve.places.len() {
        registers.extend(dissolve.registers_of(at));
        rams.extend(dissolve.rams_of(at));
    }
    let mut operation = vec![false; dissolve.ops.len()];
    let mut register = vec![false; registers.len()];
    let mut shown = vec![false; rams.len()];
    let mut fields: Vec<Vec<bool>> = rams.iter().map(|ram| vec![false; ram.widths.len()]).collect();
    let mut stack: Vec<Needs> = outputs.into_iter().map(Needs::Operation).collect();
    while let Some(needs) = stack.pop() {
        let seen = match needs {
            Needs::Operation(k) => &mut operation[k],
            Needs::Register(k) => &mut register[k],
            Needs::Shown(k) => &mut shown[k],
            Needs::Field(k, field) => &mut fields[k][field],
        };
        if std::mem::replace(seen, true) {
            continue;
        }
        match needs {
            Needs::Operation(k) => stack.extend(needed(dissolve.ops[k].0)),
            Needs::Register(k) => {
                let Register { next, enable, .. } = registers[k];
                stack.extend([Needs::Operation(next), Needs::Operation(enable)]);
            }
            Needs::Shown(k) => stack.push(Needs::Operation(rams[k].port.read)),
            Needs::Field(k, field) => {
                let Port { read, read_addr, write, write_addr, data } = &rams[k].port;
                let ports = [*read, *read_addr, *write, *write_addr, data[field]];
                stack.extend(ports.map(Needs::Operation));
            }
        }
    }
    let (mut first, mut ram) = (0, 0);
    let mut found = vec![];
    for place in &dissolve.places {
        let module = place.module;
        for (k, r) in module.registers.iter().enumerate() {
            let is_own = module.owner(k).is_none() && !module.is_constant(k);
            if is_own && !register[first + k] {
                found.push(crate::join(&place.path, &r.path));
            }
        }
        first += module.registers.len();
        for memory in &module.rams {
            let path = crate::join(&place.path, &memory.path);
            let leaves = memory.word.leaves.iter().zip(&fields[ram]);
            found.extend(
                leaves.filter(|(_, seen)| !**seen).map(|(leaf, _)| crate::join(&path, &leaf.path)),
            );
            ram += 1;
        }
    }
    found
}

/// What an operation reads.
fn needed(op: Flat) -> Vec<Needs> {
    match op {
        Flat::Const(_) | Flat::Input(_) => vec![],
        Flat::Register(k) => vec![Needs::Register(k)],
        Flat::ReadValid(k) => vec![Needs::Shown(k)],
        Flat::ReadData(k, field) => vec![Needs::Field(k, field)],
        Flat::Binary(_, a, b) => [a, b].map(Needs::Operation).to_vec(),
        Flat::Mux(c, a, b) => [c, a, b].map(Needs::Operation).to_vec(),
        Flat::Not(a) | Flat::Low(a) | Flat::TrailingZeros(a, _) => vec![Needs::Operation(a)],
    }
}
