//! Figure 3: the mean of equal images by every method, as the golden model of each has it, to which the machines are held.

use super::plan::{EQUAL, Figure, Method, Planned, ROWS};
use pellucid_hw::architecture;
use pellucid_machine::architecture::settings;
use pellucid_machine::pixel::Screen;
use pellucid_testbench::golden::Golden;
use pellucid_testbench::image::Image;
use pellucid_testbench::trial::CaseError;

/// A picture of the figure.
pub struct Picture {
    /// What it shows.
    pub caption: String,
    /// It.
    pub image: Image,
}

/// The pictures, row by row.
///
/// # Errors
/// The scene cannot be opened.
pub fn pictures(plan: &[Planned]) -> anyhow::Result<Vec<Vec<Picture>>> {
    let is_one = |planned: &&Planned| planned.figure == Figure::Equal;
    let source = plan.iter().find(is_one).expect("equal frames are planned").frames.open()?;
    let golden = Golden::new(source.screen());
    let frame = golden.judge(|sink| source.play_fragments::<CaseError>(sink))?.0.image;
    let row = |method: Method| {
        let picture = |frames: u32| {
            Ok(Picture {
                caption: format!("{method}, {frames} images"),
                image: accumulated(&frame, method, frames)?,
            })
        };
        EQUAL.into_iter().map(picture).collect::<anyhow::Result<Vec<_>>>()
    };
    ROWS.into_iter().map(row).collect()
}

/// The image of so many equal frames.
fn accumulated(frame: &Image, method: Method, frames: u32) -> anyhow::Result<Image> {
    let machine = method.machine(frames);
    let screen = Screen { width: frame.width, height: frame.height, background: 0 };
    let with = settings(&machine.settings);
    let model = architecture(machine.arch)?.build(screen, machine.preset, &with)?;
    let accumulation = model.accumulation().expect("it makes one image of several frames");
    let levels: Vec<u8> =
        (0..=255).map(|level: u8| (accumulation.channel)(&vec![level; frames as usize])).collect();
    let pixel = |rgb: &u32| {
        let [_, channels @ ..] = rgb.to_be_bytes();
        let [red, green, blue] = channels.map(|channel| levels[usize::from(channel)]);
        u32::from_be_bytes([0, red, green, blue])
    };
    Ok(Image { pixels: frame.pixels.iter().map(pixel).collect(), ..*frame })
}

#[cfg(test)]
mod tests {
    use super::super::plan::BLACK;
    use super::*;

    /// Blending takes of each frame a part that is rounded down: N * floor(255 / N) is left of white. The others lose nothing of equal
    /// frames.
    #[test]
    fn blending_alone_darkens_white() {
        let frame = Image { width: 2, height: 1, pixels: vec![0xff_ffff, 0x01_8000] };
        for frames in EQUAL.into_iter().chain([BLACK]) {
            let white = frames * (255 / frames);
            let half = frames * (128 / frames);
            let by = |method| accumulated(&frame, method, frames).unwrap().pixels;
            assert_eq!(by(Method::Blend), [white * 0x01_0101, half << 8], "{frames}");
            for method in [Method::Buffer, Method::Tree(2)] {
                assert_eq!(by(method), frame.pixels, "{method}, {frames}");
            }
        }
    }
}
