//! All free sections: those on chip first, those outside once the chip has none.
//!
//! ```text
//!             +------+
//!   take ---->|      |---> grant
//!  release -->| Pool |---> exhausted
//!             +------+
//! ```
//! Two allocators of the same kind behind the allocators' own port contract (see
//! [`crate::allocator`]); a section's number tells where it belongs. One thing differs: the offer of an
//! outside section is replaced as soon as one on chip is given back.

use super::config::Config;
use crate::allocator::{self, Allocator, Moore};
use pellucid_sim::Block;
use pellucid_sim::{Memory, Signals, Stream};
use std::marker::PhantomData;

/// See the module's description.
pub struct Pool<A>(PhantomData<A>);

/// Registers.
#[derive(Clone, Copy, Signals)]
pub struct State<A: Allocator> {
    /// The allocator of the sections on chip.
    #[with(cfg.on_chip())]
    pub on_chip: A::State,
    /// The allocator of the sections outside.
    #[with(cfg.outside())]
    pub outside: A::State,
}

/// Memories.
#[derive(Memory)]
pub struct Mem<A: Allocator> {
    /// Of the allocator of the sections on chip.
    pub on_chip: A::Mem,
    /// Of the allocator of the sections outside.
    pub outside: A::Mem,
}

impl<A: Allocator> Block for Pool<A> {
    type Config = Config;
    type State = State<A>;
    type In = allocator::In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem<A>;

    fn reset(cfg: &Config) -> State<A> {
        State { on_chip: A::reset(&cfg.on_chip()), outside: A::reset(&cfg.outside()) }
    }

    fn memories(cfg: &Config) -> Mem<A> {
        Mem { on_chip: A::memories(&cfg.on_chip()), outside: A::memories(&cfg.outside()) }
    }

    #[inline(always)]
    fn moore(cfg: &Config, q: &State<A>, m: &Self::Mem) -> Moore {
        let on_chip = A::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        let outside = A::moore(&cfg.outside(), &q.outside, &m.outside);
        let elsewhere = on_chip.exhausted && outside.grant.valid;
        Moore {
            grant: Stream {
                valid: on_chip.grant.valid || elsewhere,
                payload: if on_chip.grant.valid {
                    on_chip.grant.payload
                } else {
                    outside.grant.payload + cfg.params.sections
                },
            },
            exhausted: on_chip.exhausted && outside.exhausted,
        }
    }

    #[inline(always)]
    fn next(cfg: &Config, q: &State<A>, d: &mut State<A>, m: &mut Self::Mem, i: allocator::In) {
        let here = A::moore(&cfg.on_chip(), &q.on_chip, &m.on_chip);
        let back = i.release.payload;
        let back_outside = cfg.is_outside(back);
        let to_on_chip = allocator::In {
            take: i.take && here.grant.valid,
            release: Stream { valid: i.release.valid && !back_outside, payload: back },
        };
        let to_outside = allocator::In {
            take: i.take && here.exhausted,
            release: Stream {
                valid: i.release.valid && back_outside,
                payload: back.wrapping_sub(cfg.params.sections),
            },
        };
        A::next(&cfg.on_chip(), &q.on_chip, &mut d.on_chip, &mut m.on_chip, to_on_chip);
        A::next(&cfg.outside(), &q.outside, &mut d.outside, &mut m.outside, to_outside);
    }
}
