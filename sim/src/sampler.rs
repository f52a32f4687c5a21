//! Takes a cycle's values over those of the cycle before, and finds what changed.

use crate::label::Label;
use crate::signals::Sink;

/// See the module's description.
pub struct Sampler<'a> {
    values: &'a mut [u64],
    labels: &'a mut [Label],
    changed: &'a mut Vec<(u32, u64)>,
    /// Which value is next.
    at: usize,
    /// Which label is next.
    label_at: usize,
}

impl<'a> Sampler<'a> {
    /// Takes as many values and labels as there are, over those of the cycle before. Those that change go to
    /// `changed`, by their numbers.
    pub fn new(
        values: &'a mut [u64],
        labels: &'a mut [Label],
        changed: &'a mut Vec<(u32, u64)>,
    ) -> Sampler<'a> {
        Sampler { values, labels, changed, at: 0, label_at: 0 }
    }

    /// Values taken so far.
    pub fn values(&self) -> usize {
        self.at
    }

    /// Labels taken so far.
    pub fn labels(&self) -> usize {
        self.label_at
    }

    #[inline(never)]
    fn change(&mut self, value: u64) {
        self.values[self.at] = value;
        self.changed.push((self.at as u32, value));
    }
}

/// # Panics
/// More is told than there was of the cycle before.
impl Sink for Sampler<'_> {
    #[inline(always)]
    fn push(&mut self, value: u64) {
        if self.values[self.at] != value {
            self.change(value);
        }
        self.at += 1;
    }
    #[inline(always)]
    fn label(&mut self, label: Label) {
        self.labels[self.label_at] = label;
        self.label_at += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_changes_is_listed_by_its_number() {
        let (mut values, mut labels, mut changed) = ([5, 6, 7], [Label::NONE; 1], vec![]);
        let mut sampler = Sampler::new(&mut values, &mut labels, &mut changed);
        sampler.push(5);
        sampler.push(9);
        sampler.label(Label::new(3, 1, 2));
        sampler.push(0);
        assert_eq!((sampler.values(), sampler.labels()), (3, 1));
        assert_eq!((values, labels), ([5, 9, 0], [Label::new(3, 1, 2)]));
        assert_eq!(changed, [(1, 9), (2, 0)]);
    }
}
