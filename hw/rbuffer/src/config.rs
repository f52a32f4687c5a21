//! The R-buffer's parameters, and what the blocks derive from them.

use super::queue;
use pellucid_blocks::cached_table::Place;
use pellucid_blocks::pixels::Blends;
use pellucid_blocks::{front, shared_port};
use pellucid_machine::params::{ParamError, Preset, too_many_fragments};
use pellucid_machine::pixel::Screen;
use pellucid_machine::{Outside, choice, parameters};
use pellucid_sim::bits_for;

choice! {
    /// What happens to fragments for which the queue on chip has no room.
    pub enum Overflow {
        /// They go to outside memory.
        Outside = "outside",
        /// The frame is sent again for part of the screen after the other.
        Replay = "replay",
    }
}

/// The shortest queue.
pub const LEAST_QUEUE: u32 = 2;

parameters! {
    /// What a user chooses.
    pub struct Params {
        /// Fragments that the queue holds on chip.
        queue: u32 = 786_432, "fragments", LEAST_QUEUE..=1 << 28;
        /// What happens to fragments for which there is no room on chip: they go to outside memory, or the frame is sent again for part of the screen after the other.
        overflow: Overflow = Overflow::Outside, "", ();
        /// Further fragments that it holds in outside memory (overflow=outside).
        outside_queue: u32 = 3_145_728, "fragments", 0..=1 << 28;
        /// From a read request to outside memory to its data.
        outside_latency: u32 = 64, "cycles", 1..=1024;
        /// Fragments that wait for their pixel, and pixels that are read ahead to be shown (framebuffer=cached).
        reads_in_flight: u32 = 64, "reads", 2..=4096;
        /// Where depth and colour of the pixels lie: on chip, or in outside memory with a cache on chip.
        framebuffer: Place = Place::OnChip, "", ();
        /// Sets of that cache (framebuffer=cached), a power of two.
        framebuffer_sets: u32 = 256, "sets", 1..=1 << 16;
        /// Lines of a set, a power of two.
        framebuffer_ways: u32 = 4, "lines", 1..=8;
        /// Pixels of a line, a power of two.
        framebuffer_line: u32 = 8, "pixels", 1..=16;
    }
}

/// All presets; the first is the default.
pub const PRESETS: &[Preset<Params>] = &[
    Preset {
        name: "on-chip",
        about: "queue=786432: the frame's fragments stay on chip, as in the paper.",
        params: Params::default,
    },
    Preset {
        name: "outside",
        about: "queue=128: the queue lies in outside memory, with both ends on chip.",
        params: || Params { queue: 128, ..Params::default() },
    },
    Preset {
        name: "replay",
        about: "queue=65536, overflow=replay: what does not fit on chip is sent again.",
        params: || Params { queue: 65_536, overflow: Overflow::Replay, ..Params::default() },
    },
];

/// Everything that the blocks need to know, checked.
#[derive(Clone, Copy, Debug)]
pub struct Config {
    /// The screen.
    pub screen: Screen,
    /// The parameters.
    pub params: Params,
    /// The queue.
    pub queue: queue::Config,
    /// `overflow` is `replay`.
    pub replay: bool,
    /// The frame buffer.
    pub front: front::Config,
    /// The port to what lies outside.
    pub port: shared_port::Config,
}

impl Config {
    /// Checks the parameters against each other.
    ///
    /// # Errors
    /// The queue would hold more fragments than a simulation can, or a number of the cache is no power of two.
    pub fn new(screen: Screen, params: Params) -> Result<Config, ParamError> {
        let replay = params.overflow == Overflow::Replay;
        let (on_chip, latency) = (params.queue, params.outside_latency);
        let outside = if replay { 0 } else { params.outside_queue };
        let fragments = u64::from(on_chip) + u64::from(outside);
        too_many_fragments("`queue` + `outside_queue`", fragments)?;
        let queue = queue::Config { on_chip, outside, latency, screen };
        let lines = [params.framebuffer_sets, params.framebuffer_ways, params.framebuffer_line];
        let place = (params.framebuffer, lines);
        let reads = params.reads_in_flight;
        let (front, port) = front::Config::sharing(screen, place, reads, 1, queue.port())?;
        let front = front.blending(Blends::Revisiting);
        Ok(Config { screen, params, queue, replay, front, port })
    }

    /// What lies outside.
    pub fn outside_memory(&self) -> Option<Outside> {
        self.front.outside_memory(self.queue.outside_memory(), self.params.outside_latency)
    }

    /// All fragments that the queue holds.
    pub fn capacity(&self) -> u64 {
        u64::from(self.queue.on_chip) + u64::from(self.queue.outside)
    }

    /// Bits of a border of a band of pixels.
    pub fn band_bits(&self) -> u32 {
        bits_for(u64::from(self.screen.pixels()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_queue_outside_only_if_fragments_go_there() {
        let screen = Screen { width: 4, height: 4, background: 0 };
        let capacity = |overflow| {
            let params = Params { queue: 10, outside_queue: 30, overflow, ..Params::default() };
            Config::new(screen, params).unwrap().capacity()
        };
        assert_eq!((capacity(Overflow::Outside), capacity(Overflow::Replay)), (40, 10));
    }
}
