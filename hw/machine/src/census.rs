//! What is known of a frame before a machine has seen it, and what the machine must count of it.

/// What is known of a frame without the machine.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Census {
    /// N: transparent fragments, hidden or not.
    pub transparent: u64,
    /// F: transparent fragments in front of the opaque depth at their arrival.
    pub stored: u64,
    /// `[i]` is N_i: pixels with exactly `i` of them.
    pub histogram: Vec<u64>,
    /// The same of those alone that are in front of the final opaque depth.
    pub visible: Vec<u64>,
}

impl Census {
    /// Several frames as one.
    pub fn together(frames: &[Census]) -> Census {
        let mut all = Census::default();
        for Census { transparent, stored, histogram, visible } in frames {
            all.transparent += transparent;
            all.stored += stored;
            add(&mut all.histogram, histogram);
            add(&mut all.visible, visible);
        }
        all
    }

    /// For each number of fragments from 0 on: the pixels that have so many, and the number.
    pub fn layers(&self) -> impl Iterator<Item = (u64, u64)> {
        self.histogram.iter().copied().zip(0..)
    }

    /// Fragments of the deepest pixel.
    pub fn deepest(&self) -> u64 {
        self.layers().filter(|(pixels, _)| *pixels > 0).map(|(_, n)| n).max().unwrap_or(0)
    }

    /// What the pixels take together, each so much by its number of fragments.
    pub fn sum(&self, of: impl Fn(u64) -> u64) -> u64 {
        self.layers().map(|(pixels, n)| pixels * of(n)).sum()
    }

    /// P: pixels with at least one fragment.
    pub fn pixels(&self) -> u64 {
        self.histogram.iter().skip(1).sum()
    }
}

/// Adds a histogram to a sum of such.
pub fn add(sum: &mut Vec<u64>, histogram: &[u64]) {
    sum.resize(sum.len().max(histogram.len()), 0);
    for (sum, pixels) in sum.iter_mut().zip(histogram) {
        *sum += pixels;
    }
}

/// A figure that is known beforehand.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Check {
    /// What it is.
    pub what: &'static str,
    /// What it must be.
    pub expected: u64,
    /// What the run counted.
    pub found: u64,
}
