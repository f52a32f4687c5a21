use super::*;
use crate::test_util::{Clocked, Pattern, pattern};
use proptest::prelude::*;

const CAPACITY: u32 = 5;

struct Bench {
    sim: Clocked<DoubleBuffer<u32>>,
    cycle: u64,
}

fn nothing() -> In<u32> {
    In { insert: Stream::idle(), swap: false, take: false, again: false }
}

impl Bench {
    fn new() -> Bench {
        Bench { sim: Clocked::new(Config { capacity: CAPACITY, item: 16 }), cycle: 0 }
    }

    /// Swaps the banks and inserts `items`, while those from before are read as often as `rounds` says; gives
    /// what was read, and in how many cycles.
    fn frame(&mut self, items: &[u32], rounds: u32, ready: &Pattern) -> (Vec<u32>, u64) {
        self.sim.clock(In { swap: true, ..nothing() }).unwrap();
        let mut insert = items.iter().copied();
        let (mut seen, mut round, mut cycles) = (vec![], 1, 0);
        loop {
            self.cycle += 1;
            assert!(self.cycle < 100_000, "the items do not end");
            let shown = self.sim.moore();
            if insert.len() == 0 && shown.empty && round == rounds {
                return (seen, cycles);
            }
            let mut i = nothing();
            if let Some(item) = insert.next() {
                i.insert = Stream::offer(item);
            }
            i.take = shown.item.valid && ready.at(self.cycle);
            seen.extend(i.take.then_some(shown.item.payload));
            i.again = shown.empty && round < rounds;
            round += u32::from(i.again);
            cycles += u64::from(!shown.empty);
            self.sim.clock(i).unwrap();
        }
    }
}

#[test]
fn an_item_a_cycle() {
    let mut bench = Bench::new();
    bench.frame(&[7, 8, 9, 10], 1, &Pattern::always());
    let (seen, cycles) = bench.frame(&[], 1, &Pattern::always());
    // Two cycles until the first one is there.
    assert_eq!((seen, cycles), (vec![7, 8, 9, 10], 2 + 4));
}

proptest! {
    /// Each frame's items come in order and as often as asked for, but those that found no room.
    #[test]
    fn what_was_filled_is_read_in_the_next_frame(
        frames in prop::collection::vec((prop::collection::vec(0u32..1 << 16, 0..9), 1u32..4), 1..5),
        ready in pattern(),
    ) {
        let mut bench = Bench::new();
        let mut before: Vec<u32> = vec![];
        for (items, rounds) in frames {
            let (seen, _) = bench.frame(&items, rounds, &ready);
            prop_assert_eq!(seen, before.repeat(rounds as usize));
            before = items.into_iter().take(CAPACITY as usize).collect();
        }
    }
}

#[test]
#[should_panic(expected = "the capacity of a double buffer is 0: expected at least 1")]
fn a_bank_holds_an_item() {
    DoubleBuffer::<u32>::reset(&Config { capacity: 0, item: 16 });
}
