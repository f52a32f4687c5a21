//! How a frame is played to a machine whose ports are recorded.

use crate::bench::{Bench, BenchError};
use crate::outside::Pausing;
use crate::source::Source;
use pellucid_machine::{Item, Model};

/// See the module's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stimulus {
    /// One frame, or as often as an image takes, as fast as the machine takes it.
    Plain,
    /// Half a frame, a reset, the frame, and three times less and less of it, so that what is not cleared in between is
    /// seen, in each of two banks, too, and again where whole images take more frames; the source pauses, and the display and the outside memory stall.
    Stress,
}

/// Whether number `n` of a fixed, irregular sequence is one of the `of_eight` that are chosen.
pub fn chosen(n: u64, of_eight: u64) -> bool {
    n.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 61 < of_eight
}

/// Of eight cycles, in how many the display takes no pixel.
const DISPLAY_BUSY: u64 = 3;
/// Of eight cycles, in how many the outside memory takes no request.
const MEMORY_BUSY: u64 = 2;
/// Of eight items, how many come a cycle late.
const SOURCE_LATE: u64 = 2;
/// Of eight items of the frame, how many are in each of the frames after the reset.
const FRAMES: [u64; 4] = [8, 5, 2, 1];

impl Stimulus {
    /// Plays the frame.
    ///
    /// # Errors
    /// See [`BenchError`].
    pub fn play(
        self,
        bench: &mut Bench,
        source: &Source,
        machine: &dyn Model,
    ) -> Result<(), BenchError> {
        let (kind, of_image) = (machine.kind(), machine.frames_of_image() as usize);
        if self == Stimulus::Plain {
            for _ in 0..of_image {
                bench.frame(|bench| source.play(kind, &mut |item| bench.send(item)))?;
            }
            return bench.wait_for(1, |_, _| Ok(()));
        }
        let mut items = 0u64;
        source.play::<BenchError>(kind, &mut |_| {
            items += 1;
            Ok(())
        })?;
        bench.set_display(|cycle| !chosen(cycle, DISPLAY_BUSY));
        // A DRAM pauses by itself.
        if let Some(latency) = machine.latency() {
            bench.set_timing(Box::new(Pausing::new(latency, MEMORY_BUSY)));
        }
        let mut sent = 0;
        let mut send = |bench: &mut Bench, item: &Item| {
            sent += 1;
            if chosen(sent, SOURCE_LATE) {
                bench.pause()?;
            }
            bench.send(item)
        };
        let mut half = items / 2;
        source.play::<BenchError>(kind, &mut |item| {
            if half == 0 {
                return Ok(());
            }
            half -= 1;
            send(bench, item)
        })?;
        bench.reset();
        // The next frame comes in while the one before is still being shown.
        let frames = FRAMES.len().next_multiple_of(of_image);
        for of_eight in FRAMES.into_iter().cycle().take(frames) {
            bench.frame(|bench| {
                let mut n = 0;
                source.play(kind, &mut |item| {
                    n += 1;
                    if chosen(n, of_eight) { send(bench, item) } else { Ok(()) }
                })
            })?;
        }
        bench.wait_for(frames / of_image, |_, _| Ok(()))
    }
}
