use super::*;
use crate::test_util::Clocked;

const CONFIG: Config<u32> = Config { size: Size { positions: 4, capacity: 6 }, item: 8 };

fn nothing() -> In<u32> {
    In {
        insert: Stream::idle(),
        empties: false,
        open: false,
        take: false,
        restart: false,
        clear: Stream::idle(),
    }
}

/// Fills them, and empties them again: the items of each position with their numbers.
fn round(sim: &mut Clocked<Buckets<u32>>, items: &[(u32, u32)]) -> Vec<Vec<(u32, u32)>> {
    sim.clock(In { restart: true, ..nothing() }).unwrap();
    for (position, item) in items {
        let insert = Stream::offer(Insert { position: *position, item: *item });
        sim.clock(In { insert, ..nothing() }).unwrap();
    }
    let mut seen = vec![];
    while seen.len() < 4 {
        let open = sim.moore().count.valid;
        let count = sim.moore().count.payload;
        sim.clock(In { empties: true, open, ..nothing() }).unwrap();
        if !open {
            continue;
        }
        let mut given = vec![];
        while sim.moore().first.valid {
            assert_eq!(sim.moore().left, count - given.len() as u32);
            let Ordered { order, item } = sim.moore().first.payload;
            given.push((order, item));
            sim.clock(In { empties: true, take: true, ..nothing() }).unwrap();
        }
        assert_eq!(given.len(), count as usize);
        seen.push(given);
    }
    seen
}

#[test]
fn items_come_by_position_in_their_order() {
    let mut sim = Clocked::<Buckets<u32>>::new(CONFIG);
    for position in 0..4 {
        sim.clock(In { clear: Stream::offer(position), ..nothing() }).unwrap();
    }
    let seen = round(&mut sim, &[(3, 10), (1, 11), (1, 12), (3, 13), (1, 14)]);
    assert_eq!(seen, [vec![], vec![(1, 11), (2, 12), (4, 14)], vec![], vec![(0, 10), (3, 13)]]);
    // They were left empty; the seventh item finds no room.
    let many: Vec<(u32, u32)> = (0..7).map(|k| (2, 20 + k)).collect();
    let expected: Vec<(u32, u32)> = (0..6).map(|k| (k, 20 + k)).collect();
    assert_eq!(round(&mut sim, &many), [vec![], vec![], expected, vec![]]);
    assert!(sim.moore().full);
}

#[test]
#[should_panic(expected = "the number of positions of buckets is 0: expected at least 1")]
fn there_is_a_position() {
    Buckets::<u32>::reset(&Config { size: Size { positions: 0, ..CONFIG.size }, ..CONFIG });
}

#[test]
#[should_panic(expected = "the capacity of buckets is 0: expected at least 1")]
fn they_hold_an_item() {
    Buckets::<u32>::reset(&Config { size: Size { capacity: 0, ..CONFIG.size }, ..CONFIG });
}
