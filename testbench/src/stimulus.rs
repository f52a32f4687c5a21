//! How a frame is played to a machine whose ports are recorded.

use crate::bench::{Bench, BenchError};
use crate::source::{Played, Source};
use pellucid_hw::machine::Machine;
use pellucid_hw::pixel::Marked;
use pellucid_sim::{Registers, Signals};

/// See the module's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stimulus {
    /// One frame, as fast as the machine takes it.
    Plain,
    /// Half a frame, a reset, and the frame twice in a row; the source pauses and the display stalls.
    Stress,
}

/// Whether number `n` of a fixed, irregular sequence is one of the `of_eight` that are chosen.
pub fn chosen(n: u64, of_eight: u64) -> bool {
    n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 61 < of_eight
}

/// Of eight cycles, in how many the display takes no pixel.
const DISPLAY_BUSY: u64 = 3;
/// Of eight items, how many come a cycle late.
const SOURCE_LATE: u64 = 2;

impl Stimulus {
    /// Plays the frame.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn play<M>(self, bench: &mut Bench<M>, source: &Source) -> Result<(), BenchError>
    where
        M: Machine<Item: Played>,
        M::State: Registers<Config = M::Config>,
        M::Out: Signals<Config = M::Config>,
    {
        if self == Stimulus::Plain {
            bench
                .frame(|bench| M::Item::play(source, &mut |item| bench.send(Marked::item(item))))?;
            return bench.wait_for(1, || {});
        }
        let mut items = 0u64;
        M::Item::play::<BenchError>(source, &mut |_| {
            items += 1;
            Ok(())
        })?;
        bench.set_display(|cycle| !chosen(cycle, DISPLAY_BUSY));
        let mut sent = 0;
        let mut send = |bench: &mut Bench<M>, item| {
            sent += 1;
            if chosen(sent, SOURCE_LATE) {
                bench.pause()?;
            }
            bench.send(Marked::item(item))
        };
        let mut half = items / 2;
        M::Item::play::<BenchError>(source, &mut |item| {
            if half == 0 {
                return Ok(());
            }
            half -= 1;
            send(bench, item)
        })?;
        bench.reset()?;
        // The second frame comes in while the first is still being shown.
        for _ in 0..2 {
            bench.frame(|bench| M::Item::play(source, &mut |item| send(bench, item)))?;
        }
        bench.wait_for(2, || {})
    }
}
