//! Names, widths and kinds of registers and wires, declared once beside the field.
//!
//! [`Signals`] is derived (`#[derive(Signals)]`). What is declared serves the width check after
//! every cycle of a debug build, every waveform format, and the error messages.

use crate::label::Label;
use crate::netlist::Lift;
use std::fmt;

/// Bytes of registers that [`Signals::follow`] takes without asking what of them exists.
pub const TAKEN_WHOLE: usize = 256;

/// What a signal's bits mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// One bit, true or false.
    Flag,
    /// An unsigned number, in a Rust integer of so many bits.
    Bits(u32),
    /// The state of a state machine, by name.
    State(&'static States),
}

/// The names of a state machine's states.
#[derive(Debug, PartialEq, Eq)]
pub struct States {
    /// The type's name.
    pub name: &'static str,
    /// The name of state `k` at `[k]`.
    pub variants: &'static [&'static str],
}

/// Receives declarations, in the order in which [`Signals::sample`] gives the values.
pub trait Declare {
    /// A group of signals begins.
    fn open(&mut self, name: &str);
    /// The innermost group ends.
    fn close(&mut self);
    /// One signal of 1..=64 bits.
    fn signal(&mut self, name: &str, width: u32, kind: Kind);
    /// One label. It is no hardware: whoever is after hardware passes over it.
    fn label(&mut self, _name: &str) {}
}

/// Receives values, in the order of declarations.
pub trait Sink {
    /// The value of the next signal.
    fn push(&mut self, value: u64);
    /// The next label.
    #[inline(always)]
    fn label(&mut self, _label: Label) {}
}

impl Sink for Vec<u64> {
    #[inline(always)]
    fn push(&mut self, value: u64) {
        Vec::push(self, value);
    }
}

/// A bundle of registers or wires.
pub trait Signals: Copy + Lift {
    /// What the widths depend on.
    type Config;
    /// Declares every signal of the bundle under `name`.
    fn declare(cfg: &Self::Config, name: &str, to: &mut dyn Declare);
    /// Tells every signal's value, in the order of [`Signals::declare`].
    fn sample(&self, cfg: &Self::Config, to: &mut impl Sink);
    /// Whether every value fits its declared width.
    fn fits(&self, cfg: &Self::Config) -> bool;
    /// Tells every signal's value and width, those that do not exist included, with `name` and the names below it.
    fn seek(&self, cfg: &Self::Config, name: &str, to: &mut Misfit);
    /// [`Signals::fits`], by name.
    ///
    /// # Errors
    /// The first signal that does not.
    #[inline(always)]
    fn check(&self, cfg: &Self::Config) -> Result<(), Overflow> {
        if self.fits(cfg) { Ok(()) } else { Err(misfit(&mut |to| self.seek(cfg, "", to))) }
    }
    /// The bundle that [`Signals::sample`] gives these values for; bits beyond a signal's Rust type
    /// are cut off, a number beyond the last state counts round.
    fn restore(cfg: &Self::Config, from: &mut dyn Iterator<Item = u64>) -> Self;
    /// Takes the values of `from`, as far as there are such signals.
    #[inline(always)]
    fn follow(&mut self, _cfg: &Self::Config, from: &Self) {
        *self = *from;
    }
}

/// The registers of a block: signals, or a struct that holds lines of children too, which are as long as the
/// configuration says. Derived for such a struct (`#[derive(Registers)]`); signals are registers as they are.
pub trait Registers: Clone {
    /// What the widths depend on.
    type Config;
    /// As [`Signals::declare`].
    fn declare(cfg: &Self::Config, name: &str, to: &mut dyn Declare);
    /// As [`Signals::sample`].
    fn sample(&self, cfg: &Self::Config, to: &mut impl Sink);
    /// As [`Signals::fits`].
    fn fits(&self, cfg: &Self::Config) -> bool;
    /// As [`Signals::seek`].
    fn seek(&self, cfg: &Self::Config, name: &str, to: &mut Misfit);
    /// As [`Signals::check`].
    ///
    /// # Errors
    /// The first signal that does not fit.
    #[inline(always)]
    fn check(&self, cfg: &Self::Config) -> Result<(), Overflow> {
        if self.fits(cfg) { Ok(()) } else { Err(misfit(&mut |to| self.seek(cfg, "", to))) }
    }
    /// As [`Signals::restore`].
    fn restore(cfg: &Self::Config, from: &mut dyn Iterator<Item = u64>) -> Self;
    /// As [`Signals::follow`].
    fn follow(&mut self, cfg: &Self::Config, from: &Self);
}

impl<T: Signals> Registers for T {
    type Config = <T as Signals>::Config;
    fn declare(cfg: &<T as Signals>::Config, name: &str, to: &mut dyn Declare) {
        <T as Signals>::declare(cfg, name, to);
    }
    #[inline(always)]
    fn sample(&self, cfg: &<T as Signals>::Config, to: &mut impl Sink) {
        Signals::sample(self, cfg, to);
    }
    #[inline(always)]
    fn fits(&self, cfg: &<T as Signals>::Config) -> bool {
        Signals::fits(self, cfg)
    }
    fn seek(&self, cfg: &<T as Signals>::Config, name: &str, to: &mut Misfit) {
        Signals::seek(self, cfg, name, to);
    }
    fn restore(cfg: &<T as Signals>::Config, from: &mut dyn Iterator<Item = u64>) -> T {
        <T as Signals>::restore(cfg, from)
    }
    #[inline(always)]
    fn follow(&mut self, cfg: &<T as Signals>::Config, from: &T) {
        Signals::follow(self, cfg, from);
    }
}

/// A value that does not fit the width of its register.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overflow {
    /// The signal's path below the bundle that was checked.
    pub path: String,
    /// What it held.
    pub value: u64,
    /// How many bits it has.
    pub width: u32,
}

/// Looks for the first value that does not fit.
#[derive(Debug, Default)]
pub struct Misfit {
    path: String,
    found: Option<Overflow>,
}

impl Misfit {
    /// A group of signals: `within` tells them.
    pub fn group(&mut self, name: &str, within: &mut dyn FnMut(&mut Misfit)) {
        let outer = self.path.len();
        self.path = crate::join(&self.path, name);
        within(self);
        self.path.truncate(outer);
    }
    /// A signal.
    fn signal(&mut self, name: &str, value: u64, width: u32) {
        if self.found.is_none() && !fits(value, width) {
            self.found = Some(Overflow { path: crate::join(&self.path, name), value, width });
        }
    }
}

/// The first of all that is told that does not fit.
#[cold]
fn misfit(seek: &mut dyn FnMut(&mut Misfit)) -> Overflow {
    let mut to = Misfit::default();
    seek(&mut to);
    to.found.unwrap_or_else(|| unreachable!("a value does not fit"))
}

/// Whether a value needs no more bits.
#[inline(always)]
fn fits(value: u64, width: u32) -> bool {
    width >= u64::BITS || value >> width == 0
}

impl fmt::Display for Overflow {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "`{}` = {} does not fit its {} bits", self.path, self.value, self.width)
    }
}

macro_rules! integers {
    ($($t:ty),*) => { $(
        impl Signals for $t {
            type Config = u32;
            fn declare(width: &u32, name: &str, to: &mut dyn Declare) {
                if *width > 0 {
                    to.signal(name, *width, Kind::Bits(<$t>::BITS));
                }
            }
            #[inline(always)]
            fn sample(&self, width: &u32, to: &mut impl Sink) {
                if *width > 0 {
                    to.push(u64::from(*self));
                }
            }
            #[inline(always)]
            fn fits(&self, width: &u32) -> bool {
                fits(u64::from(*self), *width)
            }
            fn seek(&self, width: &u32, name: &str, to: &mut Misfit) {
                to.signal(name, u64::from(*self), *width);
            }
            fn restore(width: &u32, from: &mut dyn Iterator<Item = u64>) -> $t {
                if *width > 0 { from.next().unwrap_or_default() as $t } else { 0 }
            }
        }
    )* };
}
integers!(u8, u16, u32, u64);

impl Signals for bool {
    type Config = ();
    fn declare(_: &(), name: &str, to: &mut dyn Declare) {
        to.signal(name, 1, Kind::Flag);
    }
    #[inline(always)]
    fn sample(&self, _: &(), to: &mut impl Sink) {
        to.push(u64::from(*self));
    }
    #[inline(always)]
    fn fits(&self, _: &()) -> bool {
        true
    }
    fn seek(&self, _: &(), _: &str, _: &mut Misfit) {}
    fn restore(_: &(), from: &mut dyn Iterator<Item = u64>) -> bool {
        from.next().is_some_and(|value| value & 1 == 1)
    }
}

impl Signals for () {
    type Config = ();
    fn declare(_: &(), _: &str, _: &mut dyn Declare) {}
    fn sample(&self, _: &(), _: &mut impl Sink) {}
    #[inline(always)]
    fn fits(&self, _: &()) -> bool {
        true
    }
    fn seek(&self, _: &(), _: &str, _: &mut Misfit) {}
    fn restore(_: &(), _: &mut dyn Iterator<Item = u64>) {}
}

/// How many bits hold every value in `0..=max`; at least 1.
#[inline(always)]
pub fn bits_for(max: u64) -> u32 {
    (u64::BITS - max.leading_zeros()).max(1)
}

/// The bits of a whole bundle, as a memory word would store it.
pub fn width_of<T: Signals>(cfg: &T::Config) -> u32 {
    struct Sum(u32);
    impl Declare for Sum {
        fn open(&mut self, _: &str) {}
        fn close(&mut self) {}
        fn signal(&mut self, _: &str, width: u32, _: Kind) {
            self.0 += width;
        }
    }
    let mut sum = Sum(0);
    T::declare(cfg, "", &mut sum);
    sum.0
}

/// The name of a state machine's state.
pub fn state_name<T: Signals<Config = ()>>(state: T) -> &'static str {
    struct Names(&'static [&'static str]);
    impl Declare for Names {
        fn open(&mut self, _: &str) {}
        fn close(&mut self) {}
        fn signal(&mut self, _: &str, _: u32, kind: Kind) {
            if let Kind::State(states) = kind {
                self.0 = states.variants;
            }
        }
    }
    let (mut names, mut value) = (Names(&[]), Vec::new());
    T::declare(&(), "", &mut names);
    state.sample(&(), &mut value);
    let index = value.first().map_or(usize::MAX, |v| *v as usize);
    names.0.get(index).copied().unwrap_or("?")
}

#[cfg(test)]
mod tests {
    use crate::{Declare, Kind, Signals, bits_for, state_name, width_of};

    struct Config {
        bits: u32,
        used: u32,
    }
    #[derive(Clone, Copy, Signals)]
    enum Fsm {
        Idle,
        Run,
        Stall,
    }
    #[derive(Clone, Copy, Signals)]
    struct Inner {
        #[width(cfg.bits)]
        slots: [u32; 4],
    }
    #[derive(Clone, Copy, Signals)]
    struct Outer {
        fsm: Fsm,
        #[with(*cfg)]
        inner: Inner,
        #[width(3)]
        #[len(cfg.used)]
        some: [u8; 4],
        #[width(0)]
        absent: u32,
        #[with(*cfg)]
        #[exists(cfg.used > 2)]
        spare: Inner,
        flag: bool,
    }

    #[derive(Default)]
    struct Flat {
        path: Vec<String>,
        seen: Vec<(String, u32)>,
    }
    impl Declare for Flat {
        fn open(&mut self, name: &str) {
            self.path.push(name.into());
        }
        fn close(&mut self) {
            self.path.pop();
        }
        fn signal(&mut self, name: &str, width: u32, _: Kind) {
            self.seen.push((format!("{}.{name}", self.path.join(".")), width));
        }
    }

    const CFG: Config = Config { bits: 5, used: 2 };
    const ZERO: Outer = Outer {
        fsm: Fsm::Idle,
        inner: Inner { slots: [0; 4] },
        some: [0; 4],
        absent: 0,
        spare: Inner { slots: [0; 4] },
        flag: false,
    };

    #[test]
    fn declarations_and_samples_go_in_the_same_order() {
        let mut flat = Flat::default();
        Outer::declare(&CFG, "top", &mut flat);
        let expected = [
            ("top.fsm", 2),
            ("top.inner.slots[0]", 5),
            ("top.inner.slots[1]", 5),
            ("top.inner.slots[2]", 5),
            ("top.inner.slots[3]", 5),
            ("top.some[0]", 3),
            ("top.some[1]", 3),
            ("top.flag", 1),
        ];
        assert_eq!(flat.seen, expected.map(|(n, w)| (n.to_string(), w)));
        let outer = Outer {
            fsm: Fsm::Stall,
            inner: Inner { slots: [1, 2, 3, 31] },
            some: [4, 5, 6, 7],
            flag: true,
            ..ZERO
        };
        let mut values = vec![];
        outer.sample(&CFG, &mut values);
        assert_eq!(values, [2, 1, 2, 3, 31, 4, 5, 1]);
        assert_eq!(width_of::<Outer>(&CFG), 2 + 4 * 5 + 2 * 3 + 1);
    }

    #[test]
    fn a_value_too_wide_is_named() {
        let mut outer = ZERO;
        assert_eq!(outer.check(&CFG), Ok(()));
        outer.inner.slots[2] = 32;
        let error = outer.check(&CFG).unwrap_err();
        assert_eq!(error.to_string(), "`inner.slots[2]` = 32 does not fit its 5 bits");
        let absent = Outer { absent: 1, ..ZERO };
        assert_eq!(absent.check(&CFG).unwrap_err().path, "absent");
    }

    #[test]
    fn a_bundle_exists_where_it_says_so() {
        for (used, signals) in [(2, 8), (3, 8 + 1 + 4)] {
            let cfg = Config { used, ..CFG };
            let mut flat = Flat::default();
            Outer::declare(&cfg, "top", &mut flat);
            let outer = Outer { spare: Inner { slots: [9, 8, 7, 6] }, ..ZERO };
            let mut values = vec![];
            outer.sample(&cfg, &mut values);
            assert_eq!((flat.seen.len(), values.len()), (signals, signals));
            let restored = Outer::restore(&cfg, &mut values.into_iter());
            let expected = if used > 2 { [9, 8, 7, 6] } else { [0; 4] };
            assert_eq!(restored.spare.slots, expected);
            let wide = Outer { spare: Inner { slots: [32; 4] }, ..ZERO };
            assert_eq!(wide.check(&cfg).is_err(), used > 2);
        }
    }

    #[test]
    fn states_have_names() {
        assert_eq!(state_name(Fsm::Run), "Run");
        assert_eq!(state_name(Fsm::Stall), "Stall");
    }

    #[test]
    fn widths() {
        assert_eq!([0, 1, 2, 3, 4, 255, 256].map(bits_for), [1, 1, 2, 2, 3, 8, 9]);
        assert_eq!(bits_for(u64::MAX), 64);
    }
}
