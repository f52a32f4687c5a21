//! The figures of each frame of a run by itself.

use crate::bench::Played;
use crate::golden::Reference;
use pellucid_sim::Figure;
use serde_json::{Value as Json, json};

/// One frame of a run. But for `max_layers`, the figures of all frames add up to those of the run.
pub struct Frame {
    counts: Vec<Figure>,
    cycles: Vec<Figure>,
    histogram: Vec<u64>,
}

/// What the golden model says of a frame, or of several together.
pub(super) fn of_reference(r: &Reference) -> [Figure; 6] {
    let fragments = |name, about, value| Figure { name, unit: "fragments", about, value };
    [
        fragments("fragments", "Fragments of the frame.", r.fragments),
        fragments("opaque", "Opaque ones among them.", r.opaque),
        fragments("transparent", "Transparent ones among them.", r.transparent),
        fragments(
            "culled",
            "Transparent fragments behind their pixel's final opaque depth.",
            r.culled,
        ),
        Figure {
            name: "transparent_pixels",
            unit: "pixels",
            about: "Pixels with a transparent fragment that counts.",
            value: r.transparent_pixels,
        },
        fragments(
            "max_layers",
            "The most transparent fragments that count at one pixel.",
            r.max_layers.into(),
        ),
    ]
}

/// How often frames were sent.
pub(super) fn of_plays(plays: u64) -> Figure {
    let about = "How often frames came: more than once each where the machine asks for them again.";
    Figure { name: "plays", unit: "times", about, value: plays }
}

impl Frame {
    /// The frame of which the golden model says this, and what it took.
    pub fn new(reference: &Reference, Played { cycles, plays }: &Played) -> Frame {
        let mut counts = of_reference(reference).to_vec();
        counts.push(Figure {
            name: "stored",
            unit: "fragments",
            about: "Transparent fragments in front of the opaque depth when they come: those that have to be stored.",
            value: reference.stored,
        });
        counts.push(of_plays(*plays));
        let figure = |name, about, value| Figure { name, unit: "cycles", about, value };
        let about = "All phases in which a frame is worked on, from this frame's first item to the next one's.";
        let total = figure("total", about, cycles.total);
        let phases = cycles.phases.iter().map(|(phase, n)| figure(phase.name, phase.about, *n));
        let cycles = [total].into_iter().chain(phases).collect();
        Frame { counts, cycles, histogram: reference.layer_histogram.clone() }
    }

    /// Its figures, each with its name among those of a frame.
    pub(super) fn figures(&self) -> impl Iterator<Item = (String, &Figure)> {
        let counts = self.counts.iter().map(|f| (f.name.to_string(), f));
        counts.chain(self.cycles.iter().map(|f| (format!("cycles.{}", f.name), f)))
    }

    /// `[i]`: pixels with exactly `i` layers.
    pub(super) fn histogram(&self) -> &[u64] {
        &self.histogram
    }

    /// The same as an object.
    pub(super) fn json(&self) -> Json {
        let object = |figures: &[Figure]| -> Json {
            figures.iter().map(|f| (f.name.to_string(), json!(f.value))).collect()
        };
        let mut frame = object(&self.counts);
        frame["layer_histogram"] = json!(self.histogram);
        frame["cycles"] = object(&self.cycles);
        frame
    }
}
