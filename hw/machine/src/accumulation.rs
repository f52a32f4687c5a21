//! How a machine makes one image of several frames: what its image is held to, in plain software.
//!
//! It shares no line with the hardware, as the [arithmetic](crate::arithmetic) of one frame's colours does not.

use std::fmt;

/// Makes a channel of an image of that channel of each frame in order, 0 to 255.
pub type Channel = Box<dyn Fn(&[u8]) -> u8 + Send + Sync>;

/// See the module's description.
pub struct Accumulation {
    /// Its name, as it stands in "the golden model of the ...".
    pub name: &'static str,
    /// The weight of each frame in the exact mean, as many as there are frames, in a unit of its own. Their sum is at least 1
    /// and below 2^55.
    pub weights: Vec<u64>,
    /// A channel of its image.
    pub channel: Channel,
    /// How far a channel may be from the exact mean, rounded to nearest, in levels, 0 to 255.
    pub error_bound: u32,
}

impl Accumulation {
    /// Frames of an image.
    pub fn frames(&self) -> u32 {
        self.weights.len() as u32
    }

    /// A channel of the exact mean, rounded once: to nearest, a half up.
    pub fn exact(&self, frames: &[u8]) -> u8 {
        let whole: u64 = self.weights.iter().sum();
        let sum: u64 = self.weights.iter().zip(frames).map(|(w, c)| w * u64::from(*c)).sum();
        ((2 * sum + whole) / (2 * whole)) as u8
    }
}

impl fmt::Debug for Accumulation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Accumulation({} of {} frames)", self.name, self.frames())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_mean_is_rounded_once_and_a_half_goes_up() {
        let mean = |weights: &[u64], frames: &[u8]| {
            let weights = weights.to_vec();
            let channel: Channel = Box::new(|_| 0);
            Accumulation { name: "", weights, channel, error_bound: 0 }.exact(frames)
        };
        assert_eq!(mean(&[1, 1], &[7, 8]), 8);
        assert_eq!(mean(&[1, 1, 1], &[0, 0, 1]), 0);
        assert_eq!(mean(&[1, 1, 1], &[0, 1, 1]), 1);
        assert_eq!(mean(&[3, 1], &[255, 0]), 191);
        assert_eq!(mean(&[1 << 54, 1], &[255, 255]), 255);
    }
}
