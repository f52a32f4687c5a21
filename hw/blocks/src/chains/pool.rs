//! All free sections: those on chip first, those outside once the chip has none.
//!
//! ```text
//!             +------+
//!   take ---->|      |---> grant
//!  release -->| Pool |---> exhausted
//!             +------+
//! ```
//! Two allocators of the same kind, each where there are sections for it, behind the allocators' own port contract (see
//! [`crate::allocator`]); a section's number tells where it belongs, and so do those of the lent words, in
//! which each allocator counts from its own first section. One thing differs: the offer of an outside
//! section is replaced as soon as one on chip is given back.

use super::config::Config;
use crate::allocator::{self, Allocator, Lent, Moore};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Signals, Stream, rtl};
use std::marker::PhantomData;

/// See the module's description.
pub struct Pool<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// The allocator of the sections on chip.
    #[with(cfg.on_chip())]
    #[exists(cfg.shape.on_chip > 0)]
    #[block(A)]
    pub on_chip: A::State,
    /// The allocator of the sections outside.
    #[with(cfg.outside())]
    #[exists(cfg.shape.outside > 0)]
    #[block(A)]
    pub outside: A::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<A: Allocator> {
    /// Of the allocator of the sections on chip.
    #[block(A, cfg.on_chip())]
    pub on_chip: A::Mem,
    /// Of the allocator of the sections outside.
    #[block(A, cfg.outside())]
    pub outside: A::Mem,
}

/// What is seen of an allocator that has no sections, and is not there.
#[inline(always)]
fn none() -> Moore {
    Moore { grant: Stream::idle(), exhausted: true }
}

/// A section of either allocator by its number among all.
#[inline(always)]
#[rtl]
fn of_either(cfg: &Config, here: Stream<u32>, there: Stream<u32>) -> Stream<u32> {
    let on_chip = here.payload + cfg.owned;
    let outside = there.payload + cfg.first_outside();
    Stream { valid: here.valid || there.valid, payload: if here.valid { on_chip } else { outside } }
}

#[rtl(
    input = cfg.section_numbers(),
    moore = cfg.section_numbers(),
    output = cfg.section_numbers(),
    check(Pool<crate::allocator::FreeList>, crate::test_util::small(true)),
    check(Pool<crate::allocator::FreeList>, crate::test_util::small_of(13, 0)),
    check(Pool<crate::allocator::FreeList>, crate::test_util::small_of(0, 6)),
    check(Pool<crate::allocator::Bump>, crate::test_util::small_of(8, 4))
)]
impl<A: Allocator> Block for Pool<A> {
    type Config = Config;
    type State = State<A>;
    type In = allocator::In;
    type Moore = Moore;
    type Out = Lent;
    type Mem = Mem<A>;

    fn moore(cfg: &Config, q: &State<A>, m: &Self::Mem) -> Moore {
        let (mut on_chip, mut outside) = (none(), none());
        if cfg.shape.on_chip > 0 {
            on_chip = A::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        }
        if cfg.shape.outside > 0 {
            outside = A::moore(&cfg.outside(), &q.outside, &m.outside);
        }
        let elsewhere = on_chip.exhausted && outside.grant.valid;
        Moore {
            grant: Stream {
                valid: on_chip.grant.valid || elsewhere,
                payload: if on_chip.grant.valid {
                    on_chip.grant.payload + cfg.owned
                } else {
                    outside.grant.payload + cfg.first_outside()
                },
            },
            exhausted: on_chip.exhausted && outside.exhausted,
        }
    }

    fn next(
        cfg: &Config,
        q: &State<A>,
        d: &mut State<A>,
        m: &mut Self::Mem,
        i: allocator::In,
    ) -> Lent {
        let mut on_chip = none();
        if cfg.shape.on_chip > 0 {
            on_chip = A::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        }
        let back = i.release.payload;
        let back_outside = cfg.is_outside(back);
        let to_on_chip = allocator::In {
            take: i.take && on_chip.grant.valid,
            release: Stream {
                valid: i.release.valid && !back_outside,
                payload: back.wrapping_sub(cfg.owned),
            },
            word: i.word,
        };
        let to_outside = allocator::In {
            take: i.take && on_chip.exhausted,
            release: Stream {
                valid: i.release.valid && back_outside,
                payload: back.wrapping_sub(cfg.first_outside()),
            },
            word: i.word,
        };
        let (mut here, mut there) = (Lent::default(), Lent::default());
        if cfg.shape.on_chip > 0 {
            here = A::next(&cfg.on_chip(), &q.on_chip, &mut d.on_chip, &mut m.on_chip, to_on_chip);
        }
        if cfg.shape.outside > 0 {
            there = A::next(&cfg.outside(), &q.outside, &mut d.outside, &mut m.outside, to_outside);
        }
        // Of the two, one is taken from and one is given back to.
        Lent {
            read: of_either(cfg, here.read, there.read),
            write: of_either(cfg, here.write, there.write),
            word: if here.write.valid { here.word } else { there.word },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::allocator::{FreeList, In};
    use crate::chains::config::Shape;
    use crate::test_util::{screen, shape};
    use pellucid_sim::Sim;
    use proptest::prelude::*;
    use std::collections::VecDeque;

    fn pool(on_chip: u32, outside: u32) -> Sim<Pool<FreeList>> {
        let shape = Shape { on_chip, outside, ..shape() };
        Sim::new(Config::new(screen(4, 4), shape))
    }

    #[test]
    fn those_on_chip_go_first() {
        let mut sim = pool(3, 2);
        for id in 0..5 {
            assert_eq!(sim.moore().grant, Stream::offer(id));
            assert!(!sim.moore().exhausted);
            sim.clock(In { take: true, ..In::default() }).unwrap();
        }
        assert!(sim.moore().exhausted && !sim.moore().grant.valid);
    }

    #[test]
    fn an_outside_offer_gives_way_to_a_section_that_comes_back_on_chip() {
        let mut sim = pool(1, 2);
        sim.clock(In { take: true, ..In::default() }).unwrap();
        assert_eq!(sim.moore().grant, Stream::offer(1));
        sim.clock(In { release: Stream::offer(0), ..In::default() }).unwrap();
        assert_eq!(sim.moore().grant, Stream::offer(0));
        sim.clock(In { take: true, ..In::default() }).unwrap();
        assert_eq!(sim.moore().grant, Stream::offer(1));
    }

    #[test]
    fn without_outside_sections_it_is_exhausted_with_the_chip() {
        let mut sim = pool(1, 0);
        sim.clock(In { take: true, ..In::default() }).unwrap();
        assert!(sim.moore().exhausted && !sim.moore().grant.valid);
    }

    /// An allocator that is slow to answer: it offers nothing in the cycle after a take.
    #[derive(Clone, Copy, Debug)]
    struct Slow;

    #[derive(Clone, Copy, Debug, Signals)]
    #[signals(allocator::Config)]
    struct SlowState {
        #[width(8)]
        given: u32,
        busy: bool,
    }

    impl allocator::Contract for Slow {
        fn latency(_: &allocator::Config) -> u32 {
            2
        }
    }

    impl Allocator for Slow {}

    #[rtl(check(Slow, allocator::Config { sections: 5 }))]
    impl Block for Slow {
        type Config = allocator::Config;
        type State = SlowState;
        type In = In;
        type Moore = Moore;
        type Out = Lent;
        type Mem = ();
        fn reset(_: &allocator::Config) -> SlowState {
            SlowState { given: 0, busy: false }
        }
        fn memories(_: &allocator::Config) {}
        fn moore(cfg: &allocator::Config, q: &SlowState, _: &()) -> Moore {
            let free = q.given < cfg.sections;
            Moore { grant: Stream { valid: free && !q.busy, payload: q.given }, exhausted: !free }
        }
        fn next(
            cfg: &allocator::Config,
            q: &SlowState,
            d: &mut SlowState,
            m: &mut (),
            i: In,
        ) -> Lent {
            d.busy = i.take && Self::moore(cfg, q, m).grant.valid;
            d.given = q.given + u32::from(d.busy);
            Lent::default()
        }
    }

    #[test]
    fn a_section_on_its_way_on_chip_is_waited_for() {
        let mut sim = Sim::<Pool<Slow>>::new(pool(2, 2).config().to_owned());
        let mut granted = vec![];
        for _ in 0..8 {
            let Moore { grant, exhausted } = sim.moore();
            granted.push((grant.valid.then_some(grant.payload), exhausted));
            sim.clock(In { take: true, ..In::default() }).unwrap();
        }
        // The first outside section is at hand at once; the second is slow as those on chip are.
        let expected = [Some(0), None, Some(1), Some(2), None, Some(3), None, None];
        let expected: Vec<_> = expected.iter().enumerate().map(|(k, id)| (*id, k > 5)).collect();
        assert_eq!(granted, expected);
    }

    proptest! {
        /// Against two plain queues.
        #[test]
        fn behaves_as_two_free_lists(
            on_chip in 1u32..6,
            outside in 0u32..6,
            steps in proptest::collection::vec((any::<bool>(), any::<Option<prop::sample::Index>>()), 0..300),
        ) {
            let mut sim = pool(on_chip, outside);
            let mut free: [VecDeque<u32>; 2] =
                [(0..on_chip).collect(), (on_chip..on_chip + outside).collect()];
            let mut out: Vec<u32> = vec![];
            for (take, release) in steps {
                let seen = sim.moore();
                let next = free[0].front().or(free[1].front()).copied();
                prop_assert_eq!(seen.grant.valid, next.is_some());
                prop_assert_eq!(seen.exhausted, next.is_none());
                let release = release.filter(|_| !out.is_empty()).map(|k| {
                    let at = k.index(out.len());
                    out.swap_remove(at)
                });
                if let Some(next) = next {
                    prop_assert_eq!(seen.grant.payload, next);
                    if take {
                        free[usize::from(next >= on_chip)].pop_front();
                        out.push(next);
                    }
                }
                if let Some(id) = release {
                    free[usize::from(id >= on_chip)].push_back(id);
                }
                let release = release.map_or(Stream::idle(), Stream::offer);
                sim.clock(In { take, release, ..In::default() }).unwrap();
            }
        }
    }
}
