//! What of a netlist has no effect is told.

use pellucid_sim::netlist::{elaborate, without_effect};
use pellucid_sim::{Block, Memory, Ram1R1W, ReadDuringWrite, Signals, rtl};

/// Counts, and writes what it counts into a memory of which it shows a part.
struct Counts;

#[derive(Clone, Copy, Debug, Default, Signals)]
#[signals(())]
struct Word {
    #[width(4)]
    shown: u32,
    #[width(4)]
    hidden: u32,
}

#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
struct State {
    /// Shown by way of the memory.
    #[width(4)]
    count: u32,
    /// Decides when it counts.
    turn: bool,
    /// Only ever read for its own next value.
    #[width(4)]
    idle: u32,
    /// Read by `idle` alone.
    beside: bool,
    /// Never changes.
    fixed: bool,
}

#[derive(Clone, Copy, Debug, Signals)]
#[signals(())]
struct Out {
    #[width(4)]
    shown: u32,
}

#[derive(Memory)]
struct Mem {
    words: Ram1R1W<Word>,
}

#[rtl(check(Counts, ()))]
impl Block for Counts {
    type Config = ();
    type State = State;
    type In = ();
    type Moore = ();
    type Out = Out;
    type Mem = Mem;

    fn reset((): &()) -> State {
        State { count: 0, turn: false, idle: 0, beside: false, fixed: true }
    }
    fn memories((): &()) -> Mem {
        Mem { words: Ram1R1W::new(2, (), 1, ReadDuringWrite::Old) }
    }
    fn moore((): &(), _: &State, _: &Mem) {}
    fn next((): &(), q: &State, d: &mut State, m: &mut Mem, (): ()) -> Out {
        d.turn = !q.turn;
        d.beside = !q.beside;
        if q.turn {
            d.count = (q.count + 1) & 15;
        }
        if q.beside {
            d.idle = (q.idle + 1) & 15;
        }
        m.words.write(0, Word { shown: q.count, hidden: q.idle });
        m.words.read(0);
        Out { shown: m.words.q().data.shown }
    }
}

#[test]
fn registers_and_fields_that_reach_no_output_are_told() {
    let mut told = without_effect(&elaborate::<Counts>(&()));
    told.sort();
    assert_eq!(told, ["beside", "idle", "words.hidden"]);
}
