//! The contract of a block, and the driver that clocks one.

use crate::memory::{Fault, Memory};
use crate::signals::Registers;

/// A piece of clocked hardware.
///
/// Everything that a block remembers is in its [`Block::State`] (registers) and its
/// [`Block::Mem`] (memories). What its functions give depends on their arguments alone. Their bodies
/// keep to what hardware is: `let`, `if`, `match`, integer operators, assignment, calls of other such
/// functions, loops whose bounds come from the configuration.
///
/// A parent holds its children's states and memories in its own, and calls their functions:
/// first [`Block::moore`] of every child, then [`Block::next`] from upstream to downstream. Rust's
/// own rule that a value is made before it is used then shows that no combinational loop exists.
pub trait Block {
    /// Parameters, checked when they are made.
    type Config;
    /// Every register.
    type State: Registers;
    /// Input ports.
    type In: Copy;
    /// Outputs that depend on registers (and read data) alone: every `ready` is one.
    type Moore: Copy;
    /// Outputs that depend on inputs too.
    type Out: Copy;
    /// The memories, `()` if none.
    type Mem: Memory;

    /// The registers after reset. Memories keep their contents through a reset.
    fn reset(cfg: &Self::Config) -> Self::State;
    /// The memories at power-up.
    fn memories(cfg: &Self::Config) -> Self::Mem;
    /// What can be seen of the block before its inputs are known.
    fn moore(cfg: &Self::Config, q: &Self::State, m: &Self::Mem) -> Self::Moore;
    /// One cycle with the inputs `i`: gives the outputs, asks the memories `m` for what the block
    /// needs of them, and sets the registers. `q` holds them as they are before the edge, `d` as they
    /// are after it: `d` comes in equal to `q`, so that a register keeps what it is not assigned.
    fn next(
        cfg: &Self::Config,
        q: &Self::State,
        d: &mut Self::State,
        m: &mut Self::Mem,
        i: Self::In,
    ) -> Self::Out;
}

/// A block under the clock.
pub struct Sim<B: Block> {
    cfg: B::Config,
    /// The registers at the start of the last cycle.
    q: B::State,
    /// The registers now.
    d: B::State,
    mem: B::Mem,
    cycle: u64,
    /// What came out in a cycle at fault.
    at_fault: Option<B::Out>,
}

/// What there was to see in one cycle.
pub struct Cycle<'a, B: Block> {
    /// The configuration.
    pub cfg: &'a B::Config,
    /// The registers during the cycle.
    pub q: &'a B::State,
    /// The outputs during the cycle.
    pub out: B::Out,
}

impl<B: Block> Sim<B>
where
    B::State: Registers<Config = B::Config>,
{
    /// The block at power-up, in reset.
    pub fn new(cfg: B::Config) -> Sim<B> {
        let (q, mem) = (B::reset(&cfg), B::memories(&cfg));
        Sim { cfg, d: q.clone(), q, mem, cycle: 0, at_fault: None }
    }

    /// One clock cycle with the inputs `i`; shows that cycle.
    ///
    /// # Errors
    /// A [`Fault`] is a bug in the block: a port used twice, an address out of range, or (in debug
    /// builds) a register wider than declared or a word read before it was written.
    #[inline(always)]
    pub fn clock(&mut self, i: B::In) -> Result<Cycle<'_, B>, Fault> {
        self.q.follow(&self.cfg, &self.d);
        let out = B::next(&self.cfg, &self.q, &mut self.d, &mut self.mem, i);
        if self.mem.clock() {
            self.at_fault = Some(out);
            return Err(self.fault());
        }
        if cfg!(debug_assertions)
            && let Err(overflow) = Registers::check(&self.d, &self.cfg)
        {
            self.at_fault = Some(out);
            return Err(Fault::overflow(self.cycle, overflow));
        }
        self.cycle += 1;
        Ok(Cycle { cfg: &self.cfg, q: &self.q, out })
    }

    /// One clock cycle in which `part` alone works, which clocks it, its memories included: of the registers at the start of the cycle
    /// and now, the configuration and the memories it takes what is its own, and says whether one of its memories is at fault. Where
    /// it does nothing nothing has happened; all else must be as [`Sim::clock`] would leave it.
    ///
    /// # Errors
    /// As [`Sim::clock`], of memories alone.
    #[inline(always)]
    pub fn clock_part(
        &mut self,
        part: impl FnOnce(&B::Config, &mut B::State, &mut B::State, &mut B::Mem) -> Option<bool>,
    ) -> Option<Result<(), Fault>> {
        if part(&self.cfg, &mut self.q, &mut self.d, &mut self.mem)? {
            return Some(Err(self.fault()));
        }
        self.cycle += 1;
        Some(Ok(()))
    }

    /// The registers at the start of the last cycle, and now.
    pub fn edge(&self) -> (&B::State, &B::State) {
        (&self.q, &self.d)
    }

    #[cold]
    fn fault(&mut self) -> Fault {
        let mut found = None;
        self.mem.visit("", &mut |path, storage| {
            if let Some(kind) = storage.take_fault() {
                found.get_or_insert((path.to_string(), kind));
            }
        });
        let (path, kind) = found.unwrap_or_else(|| unreachable!("a memory reported a fault"));
        Fault { path, cycle: self.cycle, kind }
    }

    /// The cycle at fault, once after [`Sim::clock`] has failed.
    pub fn at_fault(&mut self) -> Option<Cycle<'_, B>> {
        let out = self.at_fault.take()?;
        Some(Cycle { cfg: &self.cfg, q: &self.q, out })
    }

    /// Forgets of the registers what is not declared. A block whose registers are all declared, as they must
    /// be, does as it would have done.
    pub fn forget_undeclared(&mut self) {
        let mut values = vec![];
        Registers::sample(&self.d, &self.cfg, &mut values);
        self.d = B::State::restore(&self.cfg, &mut values.into_iter());
    }

    /// Reset: the registers go back; the memories keep what they hold and forget what is under way.
    pub fn reset(&mut self) {
        self.d = B::reset(&self.cfg);
        self.mem.reset();
    }

    /// The configuration.
    pub fn config(&self) -> &B::Config {
        &self.cfg
    }

    /// The registers now, as the coming cycle will see them.
    pub fn state(&self) -> &B::State {
        &self.d
    }

    /// What can be seen before the inputs of the coming cycle are known.
    pub fn moore(&self) -> B::Moore {
        B::moore(&self.cfg, &self.d, &self.mem)
    }

    /// Edges since power-up.
    pub fn cycle(&self) -> u64 {
        self.cycle
    }

    /// The configuration and the memories.
    pub fn parts(&mut self) -> (&B::Config, &mut B::Mem) {
        (&self.cfg, &mut self.mem)
    }

    /// The memories.
    pub fn memories(&mut self) -> &mut B::Mem {
        &mut self.mem
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Memory, Ram1R1W, ReadDuringWrite, Signals};

    #[derive(Clone, Copy, Signals)]
    #[signals(())]
    struct State {
        #[width(2)]
        count: u32,
    }
    /// Counts past its two bits, and uses its memory's write port twice when told to.
    struct Careless;
    #[derive(Memory)]
    struct Mem {
        table: Ram1R1W<u32>,
    }
    impl Block for Careless {
        type Config = ();
        type State = State;
        type In = bool;
        type Moore = ();
        type Out = ();
        type Mem = Mem;
        fn reset(_: &()) -> State {
            State { count: 0 }
        }
        fn memories(_: &()) -> Mem {
            Mem { table: Ram1R1W::new(4, 32, 1, ReadDuringWrite::New) }
        }
        fn moore(_: &(), _: &State, _: &Mem) {}
        fn next(_: &(), q: &State, d: &mut State, m: &mut Mem, twice: bool) {
            m.table.write(0, q.count);
            if twice {
                m.table.write(1, q.count);
            }
            d.count = q.count + 1;
        }
    }

    #[test]
    #[cfg(debug_assertions)]
    fn a_register_that_overflows_is_named_with_its_cycle() {
        let mut sim = Sim::<Careless>::new(());
        for _ in 0..3 {
            sim.clock(false).unwrap();
        }
        let fault = sim.clock(false).err().unwrap();
        assert_eq!(fault.to_string(), "cycle 3: count: `count` = 4 does not fit its 2 bits");
    }

    #[test]
    fn a_port_used_twice_is_named_with_its_cycle() {
        let mut sim = Sim::<Careless>::new(());
        sim.clock(false).unwrap();
        let fault = sim.clock(true).err().unwrap();
        assert_eq!(fault.to_string(), "cycle 1: table: its write port was used twice");
    }

    #[test]
    fn a_cycle_at_fault_can_be_seen_once() {
        let mut sim = Sim::<Careless>::new(());
        sim.clock(false).unwrap();
        assert!(sim.at_fault().is_none());
        sim.clock(true).err().unwrap();
        assert_eq!(sim.at_fault().map(|cycle| cycle.q.count), Some(1));
        assert!(sim.at_fault().is_none());
    }

    /// Counts in a register that nobody knows of.
    struct Secretive;
    #[derive(Clone, Copy, Signals)]
    #[signals(())]
    struct Hidden {
        #[width(2)]
        count: u32,
        #[unseen]
        half: bool,
    }
    impl Block for Secretive {
        type Config = ();
        type State = Hidden;
        type In = ();
        type Moore = ();
        type Out = ();
        type Mem = ();
        fn reset(_: &()) -> Hidden {
            Hidden { count: 0, half: false }
        }
        fn memories(_: &()) {}
        fn moore(_: &(), _: &Hidden, _: &()) {}
        fn next(_: &(), q: &Hidden, d: &mut Hidden, _: &mut (), _: ()) {
            d.half = !q.half;
            d.count = q.count + u32::from(q.half);
        }
    }

    #[test]
    fn an_undeclared_register_is_forgotten() {
        let (mut whole, mut declared) = (Sim::<Secretive>::new(()), Sim::<Secretive>::new(()));
        for _ in 0..2 {
            whole.clock(()).unwrap();
            declared.clock(()).unwrap();
            declared.forget_undeclared();
        }
        assert_eq!((whole.state().count, declared.state().count), (1, 0));
    }

    #[test]
    fn reset_forgets_what_a_memory_was_asked() {
        let mut sim = Sim::<Careless>::new(());
        sim.clock(false).unwrap();
        sim.memories().table.read(0);
        sim.reset();
        sim.clock(false).unwrap();
        assert!(!sim.memories().table.q().valid);
    }

    #[test]
    fn reset_restores_registers() {
        let mut sim = Sim::<Careless>::new(());
        sim.clock(false).unwrap();
        assert_eq!(sim.state().count, 1);
        sim.reset();
        assert_eq!(sim.state().count, 0);
        assert_eq!(sim.cycle(), 1);
    }
}
