//! Figure 1: two triangles in two passes, with an F-buffer and without one. Figure 2: a triangle, and what lies where in F-buffers of
//! several sizes once its fragments have come.

use crate::reproduce::frames::Frames;
use crate::{finished, passes};
use pellucid_hw::architecture;
use pellucid_machine::architecture::settings;
use pellucid_machine::pixel::Fragment;
use pellucid_testbench::image::Image;
use pellucid_testbench::progress::Progress;
use pellucid_testbench::source::SourceError;
use pellucid_testbench::trial::Case;

/// What a place shows that has no fragment.
const FREE: u32 = 0xd8_d8_d8;
/// Sides of the buffers.
const SIZES: [u32; 4] = [64, 128, 256, 512];
/// The side of the screen.
const SIDE: u32 = 512;
/// The side of Figure 1's screen.
const OVERLAP_SIDE: u32 = 128;

/// Figure 1, where passes leave what they know in one way.
pub struct Overlap {
    /// Where, as `store` says it.
    pub store: &'static str,
    /// Pixels that are not as in the exact blend.
    pub wrong: u64,
    /// Pixels in which the triangles overlap.
    pub overlapping: u64,
    /// The image.
    pub image: Image,
}

/// Figure 1 with an F-buffer, and with one place for each pixel; nothing if a machine is at fault.
///
/// # Errors
/// The scene cannot be opened.
pub fn overlap() -> anyhow::Result<Option<[Overlap; 2]>> {
    let frames = Frames::square("triangles", OVERLAP_SIDE);
    let of = |store: &'static str| -> anyhow::Result<Option<Overlap>> {
        let source = frames.open()?;
        let with = [("program", "restore".to_string()), ("store", store.to_string())];
        let machine = architecture("fbuffer")?.build(source.screen(), None, &settings(&with))?;
        let mut progress = Progress::new("", None, true);
        let case = Case::new(&frames.scene, source, &*machine, &mut progress)?;
        let overlapping = case.reference.layers.iter().filter(|layers| **layers > 1).count() as u64;
        let about = format!("store={store}: ");
        let done = case.run("fbuffer", &*machine, None, &mut progress);
        let Some(mut trial) = finished(done, &about)? else { return Ok(None) };
        let right = passes(&trial.verdict, false, &about);
        let wrong = trial.verdict.image.mismatched_pixels;
        let image = trial.images.remove(0);
        Ok(right.then_some(Overlap { store, wrong, overlapping, image }))
    };
    let [fbuffer, framebuffer] = [of("fbuffer")?, of("framebuffer")?];
    Ok(fbuffer.zip(framebuffer).map(|(fbuffer, framebuffer)| [fbuffer, framebuffer]))
}

/// A picture of Figure 2.
pub struct Picture {
    /// What it shows.
    pub caption: String,
    /// It.
    pub image: Image,
    /// Fragments in it.
    pub used: usize,
    /// Places that it has.
    pub places: usize,
}

/// The triangle, and what each buffer holds of it.
///
/// # Errors
/// The scene cannot be opened.
pub fn pictures() -> anyhow::Result<Vec<Picture>> {
    let frames = Frames {
        scene: "rainbow".to_string(),
        screen: (SIDE, SIDE),
        instances: None,
        camera: None,
        sequence: None,
    };
    let mut fragments: Vec<Fragment> = vec![];
    frames.open()?.play_fragments(&mut |fragment| {
        fragments.push(fragment);
        Ok::<(), SourceError>(())
    })?;
    let screen = |fragment: &Fragment| fragment.y * SIDE + fragment.x;
    let triangle = placed(SIDE, fragments.iter().map(|f| (screen(f), f.rgba)));
    let caption = format!("The triangle, {} fragments on {SIDE}x{SIDE} pixels", fragments.len());
    let mut all = vec![Picture { caption, ..triangle }];
    for size in SIZES {
        let first = fragments.iter().take((size * size) as usize);
        let buffer = placed(size, (0..).zip(first).map(|(place, f)| (place, f.rgba)));
        let caption = format!(
            "{size}x{size}: {} of {} fragments, in {} places",
            buffer.used,
            fragments.len(),
            buffer.places
        );
        all.push(Picture { caption, ..buffer });
    }
    Ok(all)
}

/// A square of this side with colours, `0xRRGGBBAA`, at some of its places, row by row.
fn placed(side: u32, colours: impl Iterator<Item = (u32, u32)>) -> Picture {
    let places = (side * side) as usize;
    let mut pixels = vec![FREE; places];
    let mut used = 0;
    for (place, rgba) in colours {
        pixels[place as usize] = rgba >> 8;
        used += 1;
    }
    let image = Image { width: side, height: side, pixels };
    Picture { caption: String::new(), image, used, places }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper: 4096 fragments at 64x64, more at 128x128, all with a little to spare at 256x256, and much at 512x512.
    #[test]
    fn buffers_hold_what_the_paper_says() {
        let used: Vec<_> = pictures().unwrap().iter().map(|p| (p.used, p.places)).collect();
        let all = used[0].0;
        assert!(1 << 14 < all && all < 1 << 16);
        let expected = [(all, 1 << 18), (1 << 12, 1 << 12), (1 << 14, 1 << 14)];
        assert_eq!(used, [&expected[..], &[(all, 1 << 16), (all, 1 << 18)]].concat());
    }

    /// Row by row from the upper left, as fragments come; the rest is free.
    #[test]
    fn places_are_filled_in_order() {
        let picture = placed(2, [(0, 0x01_02_03_ff), (1, 0x04_05_06_80)].into_iter());
        assert_eq!(picture.image.pixels, [0x01_02_03, 0x04_05_06, FREE, FREE]);
    }
}
