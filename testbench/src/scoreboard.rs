//! The scoreboard: holds a run to the golden model, to the conservation of fragments and to the
//! closed forms.

use crate::golden::Reference;
use crate::image::{Difference, Image};
use crate::window::Window;
use pellucid_machine::{Arithmetic, Check, Tally};

/// The judgement of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// How many frames were played: the images below are theirs, one below the other.
    pub frames: u32,
    /// Frames of an image.
    pub of_image: u32,
    /// How often they were sent, all together.
    pub plays: u64,
    /// Rows of an image.
    pub rows: u32,
    /// How the machine makes the image, as it stands in "the golden model of the ...".
    pub arithmetic: &'static str,
    /// What the image is compared with beside that; nothing if that is the same.
    pub exact: Option<&'static str>,
    /// How far the image is from the exact blend, or from the exact mean of several frames.
    pub image: Difference,
    /// How far the image is from the golden model of the machine's arithmetic.
    pub golden: Difference,
    /// How far the image is from the exact blend, in those pixels alone in which it is farther than the
    /// arithmetic allows.
    pub beyond: Difference,
    /// How far the arithmetic allows a channel to be from the exact blend, in levels: that of the pixel
    /// with the most layers.
    pub error_bound: u32,
    /// Fragments for which the machine had no place.
    pub dropped: u64,
    /// Why it has none for them.
    pub dropped_since: &'static str,
    /// Every figure that is not what it must be.
    pub wrong: Vec<Check>,
}

impl Verdict {
    /// Judges a run of one frame by a machine of that arithmetic. `closed_forms` are those of its
    /// architecture.
    ///
    /// # Panics
    /// The golden model was made without that arithmetic.
    pub fn new(
        reference: &Reference,
        arithmetic: Arithmetic,
        image: &Image,
        tally: &Tally,
        closed_forms: Vec<Check>,
    ) -> Verdict {
        let f = &tally.fragments;
        let check = |what, expected, found| Check { what, expected, found };
        let mut checks = vec![
            check("fragments that came in", reference.fragments, f.arrived),
            check("opaque fragments, drawn or hidden", reference.opaque, f.drawn + f.hidden),
            check(
                "transparent fragments, blended, culled, killed or dropped",
                reference.transparent,
                f.blended + f.culled + f.killed + f.dropped,
            ),
        ];
        if f.dropped == 0 {
            // Of those that are killed a machine need not know whether they are hidden.
            let killed = reference.killed_by(arithmetic);
            checks.push(check("fragments stored", reference.stored - killed, f.stored));
            checks.push(check("fragments blended", reference.blended - killed, f.blended));
            let lost = reference.culled + killed;
            checks.push(check("fragments culled or killed", lost, f.culled + f.killed));
            checks.extend(closed_forms);
        }
        let (golden, name, exact) = match &reference.accumulated {
            Some(by) => (&by.image, by.name, Some("exact mean")),
            None if arithmetic == Arithmetic::BLEND => (&reference.image, arithmetic.name, None),
            None => (reference.image_by(arithmetic), arithmetic.name, Some(Arithmetic::BLEND.name)),
        };
        let allowed = |x: u32, y: u32| match &reference.accumulated {
            Some(by) => by.error_bound,
            None => {
                let pixel = y as usize * reference.image.width as usize + x as usize;
                (arithmetic.error_bound)(reference.layers[pixel])
            }
        };
        let error_bound = || (arithmetic.error_bound)(reference.max_layers);
        Verdict {
            frames: 1,
            of_image: reference.accumulated.as_ref().map_or(1, |by| by.frames),
            plays: 1,
            rows: reference.image.height,
            arithmetic: name,
            exact,
            image: image.compare(&reference.image),
            golden: image.compare(golden),
            beyond: image.compare_within(&reference.image, allowed),
            error_bound: reference
                .accumulated
                .as_ref()
                .map_or_else(error_bound, |by| by.error_bound),
            dropped: f.dropped,
            dropped_since: tally.dropped_since,
            wrong: checks.into_iter().filter(|c| c.expected != c.found).collect(),
        }
    }

    /// The same of several frames of one size, which were judged as one: [`Reference::stacked`].
    #[must_use]
    pub fn of_frames(self, frames: u32) -> Verdict {
        let verdict = Verdict { frames, ..self };
        Verdict { rows: verdict.rows / verdict.images(), ..verdict }
    }

    /// Images that the frames made.
    fn images(&self) -> u32 {
        self.frames / self.of_image
    }

    /// Whether the image is the one that the machine's arithmetic makes of all fragments.
    fn image_is_right(&self) -> bool {
        self.golden.mismatched_pixels == 0 && self.beyond.mismatched_pixels == 0
    }

    /// Whether the image and all counts are what they must be.
    pub fn is_right(&self) -> bool {
        self.dropped == 0 && self.image_is_right() && self.wrong.is_empty()
    }

    /// Whether the run is right but for fragments that it dropped and said so.
    pub fn is_right_but_for_drops(&self) -> bool {
        self.wrong.is_empty() && (self.dropped > 0 || self.image_is_right())
    }

    /// Whether the run passes, if dropped fragments may be no failure.
    pub fn passes(&self, allow_drops: bool) -> bool {
        self.is_right() || (allow_drops && self.is_right_but_for_drops())
    }

    /// Where to look for what is wrong: the first fragment that was dropped, or all fragments of the first
    /// pixel that is not what it must be. Nothing if all is right, or if only a count tells of what is wrong.
    pub fn place(&self) -> Option<Window> {
        if self.dropped > 0 {
            return Some(Window::Event { name: "dropped".to_string() });
        }
        let wrong = self.golden.first.or(self.beyond.first);
        wrong.map(|(x, y)| Window::Pixel { x: x as u16, y: (y % self.rows) as u16 })
    }

    /// What is right, in a sentence; nothing if there is a fault.
    pub fn approval(&self) -> Option<String> {
        let Difference { mismatched_pixels, max_error, .. } = self.image;
        let images = match self.images() {
            1 => "The image equals".to_string(),
            images => format!("Each of the {images} images equals"),
        };
        let name = self.arithmetic;
        self.is_right().then(|| {
            let Some(exact) = self.exact else {
                return format!(
                    "{images} the golden model's, bit for bit, and every count its closed form."
                );
            };
            format!(
                "{images} the golden model of its {name}, bit for bit, and every count its closed form. \
                 {mismatched_pixels} pixels differ from the {exact}, by {max_error} of 255 at most; its \
                 arithmetic allows {}.",
                self.error_bound
            )
        })
    }

    /// Pixels that differ, as the end of a sentence; nothing if there is none. `how` says from what.
    fn told(&self, difference: &Difference, how: &str) -> Option<String> {
        let Difference { mismatched_pixels: pixels, max_error: most, first } = difference;
        let (x, y) = (*first)?;
        let (frame, y) = (y / self.rows, y % self.rows);
        let of = match self.images() {
            1 => String::new(),
            _ if self.of_image > 1 => format!(" of image {frame}"),
            _ => format!(" of frame {frame}"),
        };
        Some(format!("{pixels} pixels {how}, by {most} at most, the first at x={x} y={y}{of}"))
    }

    /// One sentence per fault; empty if there is none.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = vec![];
        let (golden, beyond) = match self.exact {
            // Both would say the same.
            None => (self.told(&self.golden, "differ from the golden model"), None),
            Some(exact) => {
                let name = self.arithmetic;
                let golden = format!("differ from the golden model of the {name}");
                let beyond = format!("are farther from the {exact} than the {name} allows");
                (self.told(&self.golden, &golden), self.told(&self.beyond, &beyond))
            }
        };
        if self.dropped > 0 {
            let difference = golden.map(|text| format!("; {text}")).unwrap_or_default();
            let (dropped, since) = (self.dropped, self.dropped_since);
            faults.push(format!("{dropped} fragments were dropped, {since}{difference}"));
        } else {
            faults.extend(golden.into_iter().chain(beyond));
        }
        for Check { what, expected, found } in &self.wrong {
            faults.push(format!("{what}: expected {expected}, the run counted {found}"));
        }
        faults
    }
}

#[cfg(test)]
mod tests;
