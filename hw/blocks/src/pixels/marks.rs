//! Which pixels of either bank hold something: a bit for each on chip, so that no bank need be cleared.
//!
//! ```text
//!  front read, mark -->+-------+---> front
//!  back read, wipe --->| Marks |---> back
//!  clear, swap ------->|       |---> front_is_b
//!                      +-------+
//! ```
//! A pixel without its mark is at the far plane and has the background's colour, whatever its word in memory holds: so it need
//! not be read. Whoever shows a frame takes the marks away, so that the bank is clear for the next. A read sees
//! the mark that is set in its cycle.

use pellucid_machine::pixel::Screen;
use pellucid_sim::{Block, Memory, Ram1R1W, Read, ReadDuringWrite, ReadPort, Signals, Stream, rtl};

/// See the module's description.
pub struct Marks;

/// Registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct State {
    /// Bank b is in front.
    pub front_is_b: bool,
}

/// Inputs. In a cycle at most one user asks on each port.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct In {
    /// Reads a mark of the front bank: two users.
    #[with(cfg.pixel_bits())]
    pub read: [ReadPort; 2],
    /// Sets a mark of the front bank: two users.
    #[with(cfg.pixel_bits())]
    pub mark: [Stream<u32>; 2],
    /// Reads a mark of the back bank.
    #[with(cfg.pixel_bits())]
    pub back_read: ReadPort,
    /// Takes a mark of the back bank away.
    #[with(cfg.pixel_bits())]
    pub wipe: Stream<u32>,
    /// Takes those of a pixel away in both banks.
    #[with(cfg.pixel_bits())]
    pub clear: Stream<u32>,
    /// The banks change places on the coming edge.
    pub swap: bool,
}

/// Outputs of registers.
#[derive(Clone, Copy, Debug, Signals)]
#[signals(Screen)]
pub struct Moore {
    /// The mark of the front bank that was asked for.
    pub front: Read<bool>,
    /// That of the back bank.
    pub back: Read<bool>,
    /// Bank b is in front.
    pub front_is_b: bool,
}

/// Memories.
#[derive(Memory)]
pub struct Mem {
    /// Bank a.
    pub a: Ram1R1W<bool>,
    /// Bank b.
    pub b: Ram1R1W<bool>,
}

#[rtl(check(Marks, crate::test_util::screen(3, 2)))]
impl Block for Marks {
    type Config = Screen;
    type State = State;
    type In = In;
    type Moore = Moore;
    type Out = ();
    type Mem = Mem;

    fn reset(_: &Screen) -> State {
        State { front_is_b: false }
    }

    fn memories(cfg: &Screen) -> Mem {
        let bank = || Ram1R1W::new(cfg.pixels(), (), 1, ReadDuringWrite::New);
        Mem { a: bank(), b: bank() }
    }

    fn moore(_: &Screen, q: &State, m: &Mem) -> Moore {
        Moore {
            front: if q.front_is_b { m.b.q() } else { m.a.q() },
            back: if q.front_is_b { m.a.q() } else { m.b.q() },
            front_is_b: q.front_is_b,
        }
    }

    fn next(_: &Screen, q: &State, d: &mut State, m: &mut Mem, i: In) {
        if q.front_is_b {
            for user in i.read {
                m.b.pass_read(user);
            }
            for user in i.mark {
                if user.valid {
                    m.b.write(user.payload, true);
                }
            }
            m.a.pass_read(i.back_read);
            if i.wipe.valid {
                m.a.write(i.wipe.payload, false);
            }
        } else {
            for user in i.read {
                m.a.pass_read(user);
            }
            for user in i.mark {
                if user.valid {
                    m.a.write(user.payload, true);
                }
            }
            m.b.pass_read(i.back_read);
            if i.wipe.valid {
                m.b.write(i.wipe.payload, false);
            }
        }
        if i.clear.valid {
            m.a.write(i.clear.payload, false);
            m.b.write(i.clear.payload, false);
        }
        d.front_is_b = q.front_is_b ^ i.swap;
    }
}
