use super::*;
use crate::test_util::{Clocked, Pattern, pattern};
use proptest::prelude::*;

const POSITIONS: u32 = 6;
const CAPACITY: u32 = 9;

/// An item: where it begins and where it is active last.
type Range = (u32, u32);

/// A sweep whose items are a number and, in the lower bits, the last position.
struct Bench {
    sim: Clocked<Sweep<u32>>,
    cycle: u64,
}

fn nothing() -> In<u32> {
    In {
        insert: Stream::idle(),
        swap: false,
        take: false,
        back: Stream::idle(),
        next: false,
        clear: Stream::idle(),
    }
}

impl Bench {
    fn new() -> Bench {
        let size = Size { positions: POSITIONS, capacity: CAPACITY };
        let mut sim = Clocked::<Sweep<u32>>::new(Config { size, item: 16 });
        for position in 0..POSITIONS {
            sim.clock(In { clear: Stream::offer(position), ..nothing() }).unwrap();
        }
        Bench { sim, cycle: 0 }
    }

    /// Sweeps over what was inserted before, `rounds` times at each position, and inserts `items`; gives the
    /// numbers of the items of each round, and how many cycles the sweep took.
    fn sweep(&mut self, items: &[Range], rounds: u32, ready: &Pattern) -> (Vec<Vec<u32>>, u64) {
        self.sim.clock(In { swap: true, ..nothing() }).unwrap();
        let mut insert = items.iter().zip(0u32..).peekable();
        let (mut seen, mut round, mut gone, mut cycles) = (vec![], vec![], 0, 0);
        while self.sim.moore().runs || insert.peek().is_some() {
            self.cycle += 1;
            assert!(self.cycle < 100_000, "the sweep does not end");
            cycles += u64::from(self.sim.moore().runs);
            let shown = self.sim.moore();
            let mut i = nothing();
            if let Some(((first, last), number)) = insert.next() {
                i.insert = Stream::offer(Insert { position: *first, item: number << 4 | last });
            }
            if shown.open && ready.at(self.cycle) {
                assert_eq!(shown.item.valid, shown.count > 0);
                let position = seen.len() as u32 / rounds;
                i.take = shown.item.valid;
                round.extend(i.take.then_some(shown.item.payload >> 4));
                let again = gone + 1 < rounds;
                let stays = again || (shown.item.payload & 15) > position;
                i.back = Stream { valid: stays, payload: shown.item.payload };
                if shown.count <= 1 {
                    seen.push(std::mem::take(&mut round));
                    gone = if again { gone + 1 } else { 0 };
                    i.next = !again;
                }
            }
            self.sim.clock(i).unwrap();
        }
        (seen, cycles)
    }
}

/// The items of each round, by definition.
fn active(items: &[Range], rounds: u32) -> Vec<Vec<u32>> {
    let at = |p: u32| {
        let items = items.iter().zip(0u32..).take(CAPACITY as usize);
        let here = items.filter(|((first, last), _)| (*first..=*last).contains(&p));
        here.map(|(_, number)| number).collect::<Vec<u32>>()
    };
    (0..POSITIONS).flat_map(|p| vec![at(p); rounds as usize]).collect()
}

#[test]
fn by_hand() {
    let mut bench = Bench::new();
    bench.sweep(&[(2, 4), (0, 2), (2, 2), (0, 0)], 1, &Pattern::always());
    let (seen, _) = bench.sweep(&[], 1, &Pattern::always());
    let expected: [&[u32]; 6] = [&[1, 3], &[1], &[0, 1, 2], &[0], &[0], &[]];
    assert_eq!(seen, expected);
}

#[test]
fn an_item_a_cycle_and_an_empty_position_a_cycle() {
    let mut bench = Bench::new();
    let items = [(1, 1), (2, 3), (2, 2), (0, 5), (5, 5)];
    bench.sweep(&items, 1, &Pattern::always());
    let (_, cycles) = bench.sweep(&[], 1, &Pattern::always());
    let given: u64 = active(&items, 1).iter().map(|round| round.len().max(1) as u64).sum();
    // Three cycles until the first list is read: asked for, shown, in the queue.
    assert_eq!(cycles, given + 3);
}

proptest! {
    /// Frames of items, one inserted while the one before is swept, whatever stalls; more than fit are
    /// left out.
    #[test]
    fn each_position_has_its_items_in_order(
        frames in proptest::collection::vec(
            proptest::collection::vec((0..POSITIONS, 0..POSITIONS), 0..12), 1..4,
        ),
        rounds in 1u32..3,
        ready in pattern(),
    ) {
        let mut bench = Bench::new();
        let ordered = |frame: &Vec<Range>| -> Vec<Range> {
            frame.iter().map(|(a, b)| (*a.min(b), *a.max(b))).collect()
        };
        let mut before = vec![];
        for frame in frames.iter().map(ordered).chain([vec![]]) {
            let (seen, _) = bench.sweep(&frame, rounds, &ready);
            prop_assert_eq!(seen, active(&before, rounds));
            before = frame;
        }
    }
}
