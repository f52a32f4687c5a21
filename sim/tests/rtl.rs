//! Ordinary Rust has a netlist form: each block here is written in another part of the exportable
//! subset. The tests that `#[rtl]` makes compare it with its netlist on random registers and inputs.

use pellucid_sim::netlist::{agrees, elaborate};
use pellucid_sim::{Block, Memory, Ram1R1W, ReadDuringWrite, Signals, Stream, bits_for, rtl};

/// Parameters of every block here.
#[derive(Clone, Debug)]
struct Config {
    bits: u32,
    limit: u32,
    swap: bool,
    table: Vec<u32>,
}

fn config() -> Config {
    Config { bits: 5, limit: 20, swap: true, table: vec![3, 9, 21] }
}

impl Config {
    fn step(&self, k: u32) -> u32 {
        k * 3 + self.limit
    }
}

#[rtl]
impl Config {
    fn above(&self, x: u32) -> bool {
        x > self.limit
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Signals)]
enum Operation {
    Add,
    Sub,
    Keep,
}

#[derive(Clone, Copy, Debug, Signals)]
struct In {
    operation: Operation,
    #[width(cfg.bits)]
    a: u32,
    #[width(cfg.bits)]
    b: u32,
    c: bool,
    #[width(4)]
    v: [u32; 4],
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Signals)]
struct Out {
    #[width(32)]
    y: u32,
    z: bool,
}

/// Makes a block of one combinational function and a register that is never read.
macro_rules! combinational {
    ($name:ident, $cfg:ident, $i:ident, $body:block) => {
        struct $name;
        #[rtl(check($name, config()))]
        impl Block for $name {
            type Config = Config;
            type State = ();
            type In = In;
            type Moore = ();
            type Out = Out;
            type Mem = ();
            fn reset(_: &Config) {}
            fn memories(_: &Config) {}
            fn moore(_: &Config, (): &(), (): &()) {}
            fn next($cfg: &Config, (): &(), (): &mut (), (): &mut (), $i: In) -> Out $body
        }
    };
}

const SEVEN: u32 = 7;
const TWENTY: u32 = 20;

combinational!(Shadowing, _cfg, i, {
    let x = i.a;
    let x = if i.c {
        let x = x + 1;
        x * 2
    } else {
        x
    };
    let (p, q) = if i.b > x { (x, i.b) } else { (i.b, x) };
    let y = {
        let mut s = 0;
        for k in 0..4 {
            if i.v[k] > 3 {
                s += i.v[k];
            } else if k == 2 {
                s += 1;
            }
        }
        s
    };
    Out { y: y + p + q, z: p <= q }
});

combinational!(Elaboration, cfg, i, {
    let twice = cfg.limit * 2;
    let (a, b) = if cfg.swap { (i.b, i.a) } else { (i.a, i.b) };
    let mut y = a;
    for (k, t) in cfg.table.iter().enumerate() {
        if b == *t {
            y = cfg.step(k as u32);
        }
    }
    match cfg.table.len() {
        0 => y = 9,
        n if n > 2 => y += n as u32,
        _ => {}
    }
    Out { y, z: y < twice && !cfg.above(i.a) }
});

combinational!(Patterns, cfg, i, {
    let y = match (i.operation, i.c) {
        (Operation::Add, _) => i.a + i.b,
        (Operation::Sub, true) if i.a >= i.b => i.a - i.b,
        (Operation::Sub, _) | (Operation::Keep, false) => i.a,
        (Operation::Keep, true) => SEVEN,
    };
    let z = match y {
        0 => true,
        1 | 3 => i.c,
        4..=9 => !i.c,
        10..12 => true,
        TWENTY => false,
        n => n & 1 != 0,
    };
    let keeps = matches!(i.operation, Operation::Add | Operation::Keep if i.c);
    Out { y: (y ^ (i.b << 2)) | u32::from(i.c), z: z ^ (keeps && !(cfg.swap && i.c)) }
});

combinational!(Arrays, _cfg, i, {
    let mut v = i.v;
    v[(i.a & 3) as usize] = i.b & 15;
    v[(i.b & 3) as usize] += 0;
    for x in i.v {
        if x == 15 {
            v[0] |= x;
        }
    }
    let mut o = Out { y: !i.a, z: false };
    o.y = o.y.wrapping_sub(v[(i.b & 3) as usize]).wrapping_add(v[0].min(v[1])).max(v[2]);
    if i.c {
        o = Out { z: true, ..o };
    }
    let [first, second] = [o.y >> 1, o.y >> (i.a & 7)];
    o.y = first ^ second.saturating_sub(i.b);
    (o.y, o.z) = (o.y ^ i.a, o.z || i.c);
    o
});

combinational!(Wide, _cfg, i, {
    let wide = u64::from(i.a) << 40 | 1u64 << (i.b & 31);
    let narrow = (wide >> 38) as u8;
    let zeros = (wide & !1).trailing_zeros();
    // Of a narrow number that is 0 there are as many as it has bits.
    let few = narrow.trailing_zeros();
    Out { y: (few << 16) + zeros * 256 + u32::from(narrow), z: wide == 0x100_0000_0001 }
});

/// A block that names things as Verilog does not allow, and feeds a sibling's output of the same cycle
/// to another sibling.
struct Siblings;

#[derive(Clone, Copy, Debug, Default, Signals)]
struct Word {
    #[width(cfg.bits)]
    reg: u32,
    wire: bool,
}

/// Holds what came, and passes it on in the same cycle where it is smaller.
struct Least;

#[derive(Clone, Copy, Debug, Signals)]
struct LeastState {
    #[with(*cfg)]
    input: Stream<Word>,
}
#[derive(Clone, Copy, Debug, Signals)]
struct LeastIn {
    #[with(*cfg)]
    offer: Stream<Word>,
}
#[derive(Clone, Copy, Debug, Signals)]
struct LeastMoore {
    #[with(*cfg)]
    held: Stream<Word>,
}
#[derive(Clone, Copy, Debug, Default, Signals)]
struct LeastOut {
    #[with(*cfg)]
    least: Stream<Word>,
}

#[rtl(check(Least, config()))]
impl Block for Least {
    type Config = Config;
    type State = LeastState;
    type In = LeastIn;
    type Moore = LeastMoore;
    type Out = LeastOut;
    type Mem = ();
    fn reset(_: &Config) -> LeastState {
        LeastState { input: Stream::idle() }
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, q: &LeastState, (): &()) -> LeastMoore {
        LeastMoore { held: q.input }
    }
    fn next(_: &Config, q: &LeastState, d: &mut LeastState, (): &mut (), i: LeastIn) -> LeastOut {
        d.input = i.offer;
        let Word { reg, wire } = i.offer.payload;
        let smaller = reg < q.input.payload.reg && !wire;
        LeastOut { least: if smaller { i.offer } else { q.input } }
    }
}

#[derive(Clone, Copy, Debug, Signals)]
struct SiblingsState {
    #[with(*cfg)]
    table: LeastState,
    #[with(*cfg)]
    release: LeastState,
    always: bool,
    /// Its name begins as that of a child does, to which it does not belong.
    table_read: bool,
    #[width(bits_for(cfg.limit.into()))]
    begin: u32,
}

#[derive(Memory)]
struct SiblingsMem {
    case: Ram1R1W<Word>,
}

#[derive(Clone, Copy, Debug, Signals)]
struct SiblingsOut {
    #[with(*cfg)]
    output: Stream<Word>,
    #[width(cfg.bits)]
    module: u32,
}

#[rtl(check(Siblings, config()))]
impl Block for Siblings {
    type Config = Config;
    type State = SiblingsState;
    type In = In;
    type Moore = ();
    type Out = SiblingsOut;
    type Mem = SiblingsMem;
    fn reset(cfg: &Config) -> SiblingsState {
        SiblingsState {
            table: Least::reset(cfg),
            release: Least::reset(cfg),
            always: true,
            table_read: false,
            begin: 3,
        }
    }
    fn memories(cfg: &Config) -> SiblingsMem {
        SiblingsMem { case: Ram1R1W::new(32, cfg.clone(), 2, ReadDuringWrite::Old) }
    }
    fn moore(_: &Config, _: &SiblingsState, _: &SiblingsMem) {}
    fn next(
        cfg: &Config,
        q: &SiblingsState,
        d: &mut SiblingsState,
        m: &mut SiblingsMem,
        i: In,
    ) -> SiblingsOut {
        let held = Least::moore(cfg, &q.release, &()).held;
        let word = Word { reg: i.a, wire: i.c };
        let to_table = LeastIn { offer: Stream { valid: held.valid, payload: word } };
        let initial = if i.v[0] == 0 {
            held
        } else {
            Least::next(cfg, &q.table, &mut d.table, &mut (), to_table).least
        };
        // Clocked only now and then, with what its sibling gives in this very cycle.
        let end = if i.operation != Operation::Keep {
            let to_release = LeastIn { offer: initial };
            Least::next(cfg, &q.release, &mut d.release, &mut (), to_release)
        } else {
            LeastOut::default()
        };
        if end.least.valid {
            m.case.write(i.b, end.least.payload);
        }
        if q.always {
            m.case.read(i.a);
            d.begin = q.begin ^ 1;
        }
        d.always = i.c || !q.always || q.table_read;
        d.table_read = q.always;
        SiblingsOut { output: end.least, module: m.case.q().data.reg }
    }
}

/// Holds what comes for a cycle in a register and for another one in a memory; it counts what it held.
struct Cell;

#[derive(Clone, Copy, Debug, Signals)]
struct CellState {
    #[with(*cfg)]
    held: Stream<Word>,
    #[width(3)]
    count: u8,
}

#[derive(Memory)]
struct CellMem {
    words: Ram1R1W<Word>,
}

#[rtl(moore = cfg.bits, check(Cell, config()))]
impl Block for Cell {
    type Config = Config;
    type State = CellState;
    type In = LeastIn;
    type Moore = u32;
    type Out = LeastOut;
    type Mem = CellMem;
    fn reset(_: &Config) -> CellState {
        CellState { held: Stream::idle(), count: 2 }
    }
    fn memories(cfg: &Config) -> CellMem {
        CellMem { words: Ram1R1W::new(8, cfg.clone(), 1, ReadDuringWrite::New) }
    }
    fn moore(_: &Config, _: &CellState, m: &CellMem) -> u32 {
        m.words.q().data.reg
    }
    fn next(_: &Config, q: &CellState, d: &mut CellState, m: &mut CellMem, i: LeastIn) -> LeastOut {
        d.held = i.offer;
        if q.held.valid {
            m.words.write(u32::from(q.count), q.held.payload);
            m.words.read(u32::from(q.count));
            d.count = (q.count + 1) & 7;
        }
        LeastOut { least: Stream { valid: q.held.valid, payload: m.words.q().data } }
    }
}

/// Cells in a line, some of them not clocked in each cycle.
struct Line;

#[derive(Clone, Copy, Debug, Signals)]
struct LineState {
    #[with(*cfg)]
    #[len(cfg.limit / 8)]
    cells: [CellState; 5],
}

#[derive(Memory)]
struct LineMem {
    cells: Vec<CellMem>,
}

#[rtl(check(Line, Config { limit: 8, ..config() }), check(Line, Config { limit: 24, ..config() }))]
impl Block for Line {
    type Config = Config;
    type State = LineState;
    type In = In;
    type Moore = ();
    type Out = Out;
    type Mem = LineMem;
    fn reset(cfg: &Config) -> LineState {
        LineState { cells: [Cell::reset(cfg); 5] }
    }
    fn memories(cfg: &Config) -> LineMem {
        LineMem { cells: (0..cfg.limit / 8).map(|_| Cell::memories(cfg)).collect() }
    }
    fn moore(_: &Config, _: &LineState, _: &LineMem) {}
    fn next(cfg: &Config, q: &LineState, d: &mut LineState, m: &mut LineMem, i: In) -> Out {
        let mut offer = Stream { valid: i.c, payload: Word { reg: i.a, wire: i.c } };
        let mut y = 0;
        for k in 0..cfg.limit as usize / 8 {
            y += Cell::moore(cfg, &q.cells[k], &m.cells[k]);
            if i.v[k] != 3 {
                offer = Cell::next(
                    cfg,
                    &q.cells[k],
                    &mut d.cells[k],
                    &mut m.cells[k],
                    LeastIn { offer },
                )
                .least;
            }
        }
        Out { y, z: offer.valid }
    }
}

#[test]
fn the_children_of_a_line_have_their_numbers() {
    let module = elaborate::<Line>(&Config { limit: 16, ..config() });
    let paths: Vec<&str> = module.instances.iter().map(|i| i.path.as_str()).collect();
    assert_eq!(paths, ["cells[0]", "cells[1]"]);
    let mut memories = vec![];
    Line::memories(&Config { limit: 16, ..config() })
        .visit("row", &mut |path, _| memories.push(path.to_string()));
    assert_eq!(memories, ["row.cells[0].words", "row.cells[1].words"]);
}

/// A flag whose default is no zero: the netlist takes every default for zero, so this is a difference.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Config)]
struct Unlike {
    flag: bool,
}
impl Default for Unlike {
    fn default() -> Unlike {
        Unlike { flag: true }
    }
}

struct Different;

// The test that comes with the attribute is pointed at another block.
#[rtl(check(Least, config()))]
impl Block for Different {
    type Config = Config;
    type State = ();
    type In = In;
    type Moore = ();
    type Out = Unlike;
    type Mem = ();
    fn reset(_: &Config) {}
    fn memories(_: &Config) {}
    fn moore(_: &Config, (): &(), (): &()) {}
    fn next(_: &Config, (): &(), (): &mut (), (): &mut (), i: In) -> Unlike {
        if i.a == 3 { Unlike::default() } else { Unlike { flag: i.c } }
    }
}

#[test]
fn a_difference_is_found_and_named() {
    let said = agrees::<Different>(&config()).unwrap_err();
    let (first, rest) = said.split_once('\n').unwrap();
    assert!(first.starts_with("`different`, cycle "), "{said}");
    assert_eq!(rest, "  flag: 1 in Rust, 0 in the netlist");
}

/// Breaks a rule that only elaboration sees.
struct Careless<const TWICE: bool>;

#[rtl(check(Least, config()))]
impl<const TWICE: bool> Block for Careless<TWICE> {
    type Config = Config;
    type State = SiblingsState;
    type In = In;
    type Moore = ();
    type Out = Unlike;
    type Mem = ();
    fn reset(cfg: &Config) -> SiblingsState {
        SiblingsState {
            table: Least::reset(cfg),
            release: Least::reset(cfg),
            always: true,
            table_read: false,
            begin: 3,
        }
    }
    fn memories(_: &Config) {}
    fn moore(_: &Config, _: &SiblingsState, (): &()) {}
    fn next(cfg: &Config, q: &SiblingsState, d: &mut SiblingsState, (): &mut (), i: In) -> Unlike {
        let offer = Stream { valid: i.c, payload: Word { reg: i.a, wire: i.c } };
        Least::next(cfg, &q.table, &mut d.table, &mut (), LeastIn { offer });
        let mut flag = q.always;
        if TWICE {
            Least::next(cfg, &q.table, &mut d.table, &mut (), LeastIn { offer });
        } else {
            flag = q.table.input.valid;
        }
        Unlike { flag }
    }
}

#[test]
#[should_panic = "`table` is clocked twice in one cycle"]
fn a_child_is_clocked_once() {
    elaborate::<Careless<true>>(&config());
}

#[test]
#[should_panic = "`careless` reads the register `table.input.valid` of its child `table`: the child must \
                  give it as an output"]
fn the_registers_of_a_child_are_its_own() {
    elaborate::<Careless<false>>(&config());
}
