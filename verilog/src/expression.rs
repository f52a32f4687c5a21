//! Expressions: which bits of each wire anything needs, which wires get a name, and their text.
//!
//! A wire is as wide as what is needed of it, so that `count + 1` for a register of four bits is a sum
//! of four bits. Every operand is written at the width of its operation, so that no tool need guess.

use crate::names::{Names, upper};
use pellucid_sim::netlist::node::mask;
use pellucid_sim::netlist::{Binary, Module, Node, Op, Type};
use std::collections::{BTreeSet, HashMap};

/// Text longer than this becomes a wire of its own.
const LONGEST: usize = 60;

/// How a node is written where it is used.
#[derive(Clone, Debug)]
enum Form {
    /// It has no effect.
    Dead,
    /// A number.
    Number(u64),
    /// A state, by the name of its constant.
    Constant(String),
    /// A signal, or bits of one from `low` on.
    Signal { name: String, low: u32, whole: bool },
    /// An expression that is used once.
    Inline(String),
}

/// The expressions of a module.
pub struct Expressions<'a> {
    module: &'a Module,
    /// Which bits of each node are needed.
    used: Vec<u64>,
    users: Vec<u32>,
    /// Bits other than the low ones are taken of it: it needs a name.
    sliced: Vec<bool>,
    forms: Vec<Form>,
    /// Declarations of wires, in order.
    pub wires: String,
    /// Constants for states that are used: of which type, number, width, name.
    pub constants: BTreeSet<(String, u64, u32, String)>,
    /// Widths for which a function is needed that counts trailing zeros.
    pub trailing_zeros: BTreeSet<(u32, u32)>,
    /// Signals of which not every bit is used.
    pub unused: Vec<String>,
}

/// `[7:0] `, or nothing for one bit.
pub fn range(width: u32) -> String {
    if width == 1 { String::new() } else { format!("[{}:0] ", width - 1) }
}

/// A number at a width.
pub fn number(value: u64, width: u32) -> String {
    let value = value & mask(width);
    if value < 100_000 { format!("{width}'d{value}") } else { format!("{width}'h{value:x}") }
}

/// A root of the module's wires: a node, and how many of its bits are needed.
pub type Need = (Node, u32);

impl<'a> Expressions<'a> {
    /// Finds out what is needed of each node. `needs` are the roots; `leaf` names what is no operation;
    /// `fixed` are names that certain nodes have, `hints` names that others get if they need one.
    pub fn new(
        module: &'a Module,
        needs: &[Need],
        names: &mut Names,
        fixed: &HashMap<Node, String>,
        hints: &HashMap<Node, String>,
        leaf: impl Fn(Op) -> Option<(String, u32, bool)>,
    ) -> Expressions<'a> {
        let drivers = &module.graph.drivers;
        let mut used = vec![0u64; drivers.len()];
        let mut users = vec![0u32; drivers.len()];
        let mut sliced = vec![false; drivers.len()];
        for (node, width) in needs {
            used[node.0 as usize] |= mask(*width);
            users[node.0 as usize] += 1;
        }
        for (n, driver) in drivers.iter().enumerate().rev() {
            if users[n] == 0 {
                continue;
            }
            used[n] &= mask(driver.width);
            let wanted = mask(u64::BITS - used[n].leading_zeros());
            let all = |node: Node| mask(drivers[node.0 as usize].width);
            let mut need = |node: Node, bits: u64| {
                used[node.0 as usize] |= bits;
                users[node.0 as usize] += 1;
            };
            match driver.op {
                Op::Binary(op, a, b) => {
                    let (for_a, for_b) = match op {
                        Binary::Eq | Binary::Lt => (all(a), all(b)),
                        Binary::Shl => (wanted, all(b)),
                        Binary::Shr => match drivers[b.0 as usize].op {
                            Op::Const(k) => {
                                sliced[a.0 as usize] = true;
                                (wanted.checked_shl(k as u32).unwrap_or(0), all(b))
                            }
                            _ => (all(a), all(b)),
                        },
                        _ => (wanted, wanted),
                    };
                    need(a, for_a);
                    need(b, for_b);
                }
                Op::Mux(c, a, b) => {
                    need(c, 1);
                    need(a, wanted);
                    need(b, wanted);
                }
                Op::Not(a) | Op::Low(a) => need(a, wanted),
                Op::TrailingZeros(a) => need(a, all(a)),
                _ => {}
            }
        }
        let mut expressions = Expressions {
            module,
            used,
            users,
            sliced,
            forms: vec![],
            wires: String::new(),
            constants: BTreeSet::new(),
            trailing_zeros: BTreeSet::new(),
            unused: vec![],
        };
        for n in 0..drivers.len() {
            let form = if expressions.users[n] == 0 {
                Form::Dead
            } else {
                expressions.form(Node(n as u32), names, fixed, hints, &leaf)
            };
            expressions.forms.push(form);
        }
        expressions
    }

    /// Which bits of a node are used.
    pub fn used(&self, node: Node) -> u64 {
        self.used[node.0 as usize]
    }

    /// How wide a node is written.
    fn width(&self, node: Node) -> u32 {
        let n = node.0 as usize;
        let driver = &self.module.graph.drivers[n];
        let own = match driver.op {
            Op::Binary(Binary::Shr, _, by) => {
                matches!(self.module.graph.drivers[by.0 as usize].op, Op::Const(_))
            }
            Op::Binary(..) | Op::Not(_) | Op::Mux(..) | Op::Low(_) => true,
            _ => false,
        };
        let needed = u64::BITS - self.used[n].leading_zeros();
        if own { needed.clamp(1, driver.width) } else { driver.width }
    }

    fn form(
        &mut self,
        node: Node,
        names: &mut Names,
        fixed: &HashMap<Node, String>,
        hints: &HashMap<Node, String>,
        leaf: &impl Fn(Op) -> Option<(String, u32, bool)>,
    ) -> Form {
        let driver = self.module.graph.drivers[node.0 as usize];
        if let Op::Const(value) = driver.op {
            return match self.state(value, driver.width, driver.ty) {
                Some(name) => Form::Constant(name),
                None => Form::Number(value),
            };
        }
        if let Some((name, low, whole)) = leaf(driver.op) {
            return Form::Signal { name, low, whole };
        }
        let width = self.width(node);
        if let Op::Low(a) = driver.op
            && let Form::Signal { name, low, whole } = &self.forms[a.0 as usize]
        {
            let whole = *whole && self.width(a) == width;
            return Form::Signal { name: name.clone(), low: *low, whole };
        }
        let text = self.operation(node, width);
        let own = self.module.graph.names.get(&node).map(String::as_str);
        let fixed = fixed.get(&node).filter(|_| width == driver.width || own.is_none());
        let once = self.users[node.0 as usize] == 1 && !self.sliced[node.0 as usize];
        let full = self.used[node.0 as usize] == mask(width);
        if full && once && own.is_none() && fixed.is_none() && text.len() <= LONGEST {
            return Form::Inline(text);
        }
        let name = match (fixed, own, hints.get(&node)) {
            (Some(name), ..) => name.clone(),
            (None, Some(name), _) => names.unique(name),
            (None, None, Some(name)) => names.unique(name),
            (None, None, None) => names.unique("n"),
        };
        self.wires += &format!("  wire {}{name} ={};\n", range(width), laid_out(&text));
        if !full {
            self.unused.push(name.clone());
        }
        Form::Signal { name, low: 0, whole: true }
    }

    /// The constant for a state's number, if it is one.
    pub fn state(&mut self, value: u64, width: u32, ty: Type) -> Option<String> {
        let Type::State(states) = ty else { return None };
        let state = states.variants.get(value as usize)?;
        let (of, state) = (upper(states.name), upper(state));
        let name = format!("{of}_{state}");
        self.constants.insert((of, value, width, name.clone()));
        Some(name)
    }

    /// A node at a width.
    pub fn at(&self, node: Node, width: u32) -> String {
        let own = self.width(node);
        match &self.forms[node.0 as usize] {
            Form::Number(value) => number(*value, width),
            Form::Dead => number(0, width),
            form if own < width => {
                format!("{{{}, {}}}", number(0, width - own), bare(self.text(form, own, own)))
            }
            form => self.text(form, own, width),
        }
    }

    /// The low `width` bits of a form that is `own` bits wide.
    fn text(&self, form: &Form, own: u32, width: u32) -> String {
        match form {
            Form::Signal { name, low, whole } => {
                if *whole && own == width {
                    name.clone()
                } else if width == 1 {
                    format!("{name}[{low}]")
                } else {
                    format!("{name}[{}:{low}]", low + width - 1)
                }
            }
            Form::Inline(text) => text.clone(),
            Form::Constant(name) => name.clone(),
            Form::Number(value) => number(*value, width),
            Form::Dead => number(0, width),
        }
    }

    fn operation(&mut self, node: Node, width: u32) -> String {
        let drivers = &self.module.graph.drivers;
        let driver = drivers[node.0 as usize];
        let flag = driver.ty == Type::Flag;
        match driver.op {
            Op::Binary(op, a, b) => {
                let both = |operator: &str, at: u32| {
                    format!("({} {operator} {})", self.at(a, at), self.at(b, at))
                };
                // A number is as wide as what it is compared with.
                let fits = |n: Node, other: Node| match self.forms[n.0 as usize] {
                    Form::Number(value) => value <= mask(self.width(other)),
                    _ => false,
                };
                let wider = match (self.width(a), self.width(b)) {
                    (_, of_b) if fits(a, b) => of_b,
                    (of_a, _) if fits(b, a) => of_a,
                    (of_a, of_b) => of_a.max(of_b),
                };
                match op {
                    Binary::Add => both("+", width),
                    Binary::Sub => both("-", width),
                    Binary::Mul => both("*", width),
                    Binary::And => both(if flag { "&&" } else { "&" }, width),
                    Binary::Or => both(if flag { "||" } else { "|" }, width),
                    Binary::Xor => both("^", width),
                    Binary::Eq => both("==", wider),
                    Binary::Lt => both("<", wider),
                    Binary::Shl => {
                        format!("({} << {})", self.at(a, width), self.at(b, self.width(b)))
                    }
                    Binary::Shr => match (drivers[b.0 as usize].op, &self.forms[a.0 as usize]) {
                        (Op::Const(k), Form::Signal { name, low, whole }) => {
                            let low = low + k as u32;
                            let bits = Form::Signal { name: name.clone(), low, whole: false };
                            debug_assert!(*whole || low > 0);
                            self.text(&bits, width, width)
                        }
                        _ => format!(
                            "({} >> {})",
                            self.at(a, self.width(a)),
                            self.at(b, self.width(b))
                        ),
                    },
                }
            }
            Op::Not(a) => format!("{}{}", if flag { "!" } else { "~" }, self.at(a, width)),
            Op::Mux(c, a, b) => {
                format!("({} ? {} : {})", self.at(c, 1), self.at(a, width), self.at(b, width))
            }
            Op::Low(a) => self.at(a, width),
            Op::TrailingZeros(a) => {
                let bits = self.width(a);
                self.trailing_zeros.insert((bits, driver.width));
                format!("trailing_zeros_{bits}({})", bare(self.at(a, bits)))
            }
            _ => unreachable!("what is no operation has a name"),
        }
    }
}

/// An expression without the parentheses around it.
pub fn bare(text: String) -> String {
    let mut depth = 0;
    let closes = |(k, c): (usize, char)| {
        depth += i32::from(c == '(') - i32::from(c == ')');
        (depth == 0).then_some(k)
    };
    match text.char_indices().find_map(closes) {
        Some(k) if text.starts_with('(') && k + 1 == text.len() => text[1..k].to_string(),
        _ => text,
    }
}

/// An expression behind `=`: a chain of choices gets a line for each.
pub fn laid_out(text: &str) -> String {
    let text = bare(text.to_string());
    if text.len() < 76 || !text.contains(" ? ") {
        return format!(" {text}");
    }
    let mut lines = String::new();
    let mut rest = text;
    while let Some((head, tail)) = split_choice(&rest) {
        lines += &format!("\n    {head} :");
        rest = bare(tail);
    }
    format!("{lines}\n    {rest}")
}

/// `c ? a` and `b` of `c ? a : b`.
fn split_choice(text: &str) -> Option<(String, String)> {
    let (mut depth, mut asked) = (0, false);
    for (k, c) in text.char_indices() {
        match c {
            '(' | '{' | '[' => depth += 1,
            ')' | '}' | ']' => depth -= 1,
            '?' if depth == 0 => asked = true,
            ':' if depth == 0 && asked => {
                return Some((text[..k].trim_end().to_string(), text[k + 1..].trim().to_string()));
            }
            _ => {}
        }
    }
    None
}
