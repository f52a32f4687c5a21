//! What the golden model says of several frames that become one image.

use super::Reference;
use crate::image::Image;
use pellucid_machine::Accumulation;

/// What several frames must become.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Accumulated {
    /// The name of how they are accumulated.
    pub name: &'static str,
    /// Frames of an image.
    pub frames: u32,
    /// The images.
    pub image: Image,
    /// How far a channel may be from the exact mean, in levels.
    pub error_bound: u32,
}

impl Reference {
    /// Several frames of one size as the images that a machine makes of them; frames that make no whole image are left out.
    pub fn accumulated<'a>(
        frames: impl IntoIterator<Item = &'a Reference> + Clone,
        by: &Accumulation,
    ) -> Reference {
        let images: Vec<&Image> = frames.clone().into_iter().map(|frame| &frame.image).collect();
        let whole = images.chunks_exact(by.frames() as usize);
        let (width, rows) = images.first().map_or((0, 0), |image| (image.width, image.height));
        let image = || Image { width, height: rows * whole.len() as u32, pixels: vec![] };
        let (mut exact, mut found) = (image(), image());
        for frames in whole {
            for place in 0..frames[0].pixels.len() {
                let channel = |shift: u32| -> Vec<u8> {
                    frames.iter().map(|frame| (frame.pixels[place] >> shift) as u8).collect()
                };
                let channels = [16, 8, 0].map(channel);
                let colour = |of: &dyn Fn(&[u8]) -> u8| {
                    channels.iter().fold(0, |rgb, channel| rgb << 8 | u32::from(of(channel)))
                };
                exact.pixels.push(colour(&|channel| by.exact(channel)));
                found.pixels.push(colour(&*by.channel));
            }
        }
        let accumulated = Accumulated {
            name: by.name,
            frames: by.frames(),
            image: found,
            error_bound: by.error_bound,
        };
        Reference { image: exact, accumulated: Some(accumulated), ..Reference::counted(frames) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::golden::Golden;
    use pellucid_machine::pixel::{Fragment, Screen};
    use pellucid_sim::Label;

    /// Of each two frames of two pixels the exact mean, and the first one as what is found.
    #[test]
    fn images_are_made_of_the_frames_that_belong_to_them() {
        let screen = Screen { width: 1, height: 2, background: 0 };
        let frame = |upper: u32, lower: u32| {
            let pixel =
                |y, rgb: u32| Fragment { x: 0, y, z: 1, rgba: rgb << 8 | 0xff, label: Label::NONE };
            Golden::new(screen).of(&[pixel(0, upper), pixel(1, lower)]).unwrap()
        };
        let frames = [
            frame(0x10_00_00, 0x00_00_03),
            frame(0x20_00_00, 0x00_00_00),
            frame(0xff_ff_ff, 0x01_02_03),
            frame(0xff_ff_ff, 0x03_02_01),
        ];
        let weights = vec![1, 1];
        let by =
            Accumulation { name: "first", weights, channel: Box::new(|of| of[0]), error_bound: 9 };
        let made = Reference::accumulated(&frames, &by);
        assert_eq!((made.image.width, made.image.height), (1, 4));
        assert_eq!(made.image.pixels, [0x18_00_00, 0x00_00_02, 0xff_ff_ff, 0x02_02_02]);
        let found = made.accumulated.unwrap();
        assert_eq!(found.image.pixels, [0x10_00_00, 0x00_00_03, 0xff_ff_ff, 0x01_02_03]);
        assert_eq!((found.name, found.frames, found.error_bound), ("first", 2, 9));
        assert_eq!((made.fragments, made.opaque), (8, 8));
    }
}
