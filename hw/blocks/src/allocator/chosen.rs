//! The allocator that a parameter names: any of the library's, behind one type, so that a machine is compiled
//! once for all of them.
//!
//! It is no hardware of its own: its registers, its memories and its netlist are those of the block that was
//! chosen.

use super::{
    Allocator, AllocatorKind, Bitmap, Bump, Cached, Choice, FreeList, Hierarchical, In, Lent,
    Moore, Stack, Threaded,
};
use pellucid_sim::netlist::{Lift, Numbers, Value};
use pellucid_sim::signals::Misfit;
use pellucid_sim::{Block, Declare, Memory, Netlist, Signals, Sink, Storage};

/// See the module's description.
#[derive(Clone, Copy, Debug)]
pub struct Chosen;

macro_rules! chosen {
    ($($kind:ident: $block:ty,)*) => {
        /// Registers of the one that was chosen.
        #[derive(Clone, Copy, Debug)]
        #[expect(clippy::large_enum_variant, reason = "registers lie side by side")]
        pub enum State {
            $(#[doc = concat!("Of [`", stringify!($block), "`].")] $kind(<$block as Block>::State),)*
        }

        /// Memories of the one that was chosen.
        pub enum Mem {
            $(#[doc = concat!("Of [`", stringify!($block), "`].")] $kind(<$block as Block>::Mem),)*
        }

        impl Signals for State {
            type Config = Choice;
            fn declare(cfg: &Choice, name: &str, to: &mut dyn Declare) {
                match cfg.kind {
                    $(AllocatorKind::$kind => {
                        <$block as Block>::State::declare(&cfg.numbers, name, to)
                    })*
                }
            }
            #[inline(always)]
            fn sample(&self, cfg: &Choice, to: &mut impl Sink) {
                match self {
                    $(State::$kind(q) => q.sample(&cfg.numbers, to),)*
                }
            }
            #[inline(always)]
            fn fits(&self, cfg: &Choice) -> bool {
                match self {
                    $(State::$kind(q) => q.fits(&cfg.numbers),)*
                }
            }
            fn seek(&self, cfg: &Choice, name: &str, to: &mut Misfit) {
                match self {
                    $(State::$kind(q) => q.seek(&cfg.numbers, name, to),)*
                }
            }
            fn restore(cfg: &Choice, from: &mut dyn Iterator<Item = u64>) -> State {
                match cfg.kind {
                    $(AllocatorKind::$kind => State::$kind(Signals::restore(&cfg.numbers, from)),)*
                }
            }
            #[inline(always)]
            fn follow(&mut self, cfg: &Choice, from: &State) {
                match (self, from) {
                    $((State::$kind(own), State::$kind(from)) => own.follow(&cfg.numbers, from),)*
                    _ => unreachable!("registers are those of one allocator"),
                }
            }
        }

        impl Lift for State {
            fn lift(self) -> Value {
                match self {
                    $(State::$kind(q) => q.lift(),)*
                }
            }
        }

        impl Memory for Mem {
            #[inline(always)]
            fn clock(&mut self) -> bool {
                match self {
                    $(Mem::$kind(m) => m.clock(),)*
                }
            }
            fn reset(&mut self) {
                match self {
                    $(Mem::$kind(m) => m.reset(),)*
                }
            }
            fn visit(&mut self, path: &str, to: &mut dyn FnMut(&str, &mut dyn Storage)) {
                match self {
                    $(Mem::$kind(m) => m.visit(path, to),)*
                }
            }
            fn each(&mut self, to: &mut dyn FnMut(&mut dyn Storage)) {
                match self {
                    $(Mem::$kind(m) => m.each(to),)*
                }
            }
        }

        impl Block for Chosen {
            type Config = Choice;
            type State = State;
            type In = In;
            type Moore = Moore;
            type Out = Lent;
            type Mem = Mem;

            fn reset(cfg: &Choice) -> State {
                match cfg.kind {
                    $(AllocatorKind::$kind => State::$kind(<$block>::reset(&cfg.numbers)),)*
                }
            }
            fn memories(cfg: &Choice) -> Mem {
                match cfg.kind {
                    $(AllocatorKind::$kind => Mem::$kind(<$block>::memories(&cfg.numbers)),)*
                }
            }
            #[inline(always)]
            fn moore(cfg: &Choice, q: &State, m: &Mem) -> Moore {
                match (q, m) {
                    $((State::$kind(q), Mem::$kind(m)) => <$block>::moore(&cfg.numbers, q, m),)*
                    _ => unreachable!("registers and memories are those of one allocator"),
                }
            }
            #[inline(always)]
            fn next(cfg: &Choice, q: &State, d: &mut State, m: &mut Mem, i: In) -> Lent {
                match (q, d, m) {
                    $((State::$kind(q), State::$kind(d), Mem::$kind(m)) => {
                        <$block>::next(&cfg.numbers, q, d, m, i)
                    })*
                    _ => unreachable!("registers and memories are those of one allocator"),
                }
            }
        }

        impl Netlist for Chosen {
            fn name(cfg: &Choice) -> &'static str {
                match cfg.kind {
                    $(AllocatorKind::$kind => <$block>::name(&cfg.numbers),)*
                }
            }
            fn source(cfg: &Choice) -> &'static str {
                match cfg.kind {
                    $(AllocatorKind::$kind => <$block>::source(&cfg.numbers),)*
                }
            }
            fn declare_state(cfg: &Choice, to: &mut dyn Declare) {
                State::declare(cfg, "", to);
            }
            fn declare_in(cfg: &Choice, to: &mut dyn Declare) {
                In::declare(&cfg.numbers, "", to);
            }
            fn declare_moore(cfg: &Choice, to: &mut dyn Declare) {
                Moore::declare(&cfg.numbers, "", to);
            }
            fn declare_out(cfg: &Choice, to: &mut dyn Declare) {
                Lent::declare(&cfg.numbers, "", to);
            }
            fn numbers() -> Numbers<Chosen> {
                Numbers {
                    state: |cfg, q, to| q.sample(cfg, to),
                    input: |cfg, i, to| i.sample(&cfg.numbers, to),
                    moore: |cfg, o, to| o.sample(&cfg.numbers, to),
                    out: |cfg, o, to| o.sample(&cfg.numbers, to),
                    to_state: |cfg, from| Signals::restore(cfg, from),
                    to_in: |cfg, from| Signals::restore(&cfg.numbers, from),
                }
            }
            fn moore_netlist(cfg: &Choice, q: Value, m: Value) -> Value {
                match cfg.kind {
                    $(AllocatorKind::$kind => <$block>::moore_netlist(&cfg.numbers, q, m),)*
                }
            }
            fn next_netlist(cfg: &Choice, q: Value, d: Value, m: Value, i: Value) -> [Value; 3] {
                match cfg.kind {
                    $(AllocatorKind::$kind => <$block>::next_netlist(&cfg.numbers, q, d, m, i),)*
                }
            }
        }

        impl Allocator for Chosen {}
    };
}

chosen! {
    Bump: Bump,
    Fifo: FreeList,
    Lifo: Stack,
    Threaded: Threaded,
    Bitmap: Bitmap,
    Hierarchical: Hierarchical,
    Cached: Cached,
}
