//! The examples of the F-buffer paper (seed 003): its figure 1, a cyan triangle behind a yellow one, each with an opacity of 0.5,
//! and its figure 2, a triangle in the colours of the rainbow, half transparent too.
//!
//! The cyan one comes first, so that the two are drawn from back to front.

use crate::scene::clip::Vertex;
use glam::{DVec4, Vec4};

/// Background, `0xRRGGBB`.
pub(in crate::scene) const BACKGROUND: u32 = 0xff_ff_ff;

/// Half of 255, rounded up.
const HALF: f32 = 128.0;
const CYAN: Vec4 = Vec4::new(0.0, 255.0, 255.0, HALF);
const YELLOW: Vec4 = Vec4::new(255.0, 255.0, 0.0, HALF);

/// A triangle of one depth: corners in half sides of the screen, each with its colour.
type Triangle = ([(f64, f64, Vec4); 3], f64);

const PAIR: [Triangle; 2] = [
    ([(-0.8, -0.5, CYAN), (0.4, -0.5, CYAN), (-0.2, 0.7, CYAN)], 0.6),
    ([(-0.4, -0.7, YELLOW), (0.8, -0.7, YELLOW), (0.2, 0.5, YELLOW)], 0.4),
];

/// At 512x512 it has 60 000 fragments, so that a buffer of 256x256 holds it with a little to spare, and one of 128x128 does not.
const RAINBOW: Triangle = (
    [
        (0.0, 0.66, Vec4::new(255.0, 0.0, 0.0, HALF)),
        (-0.7, -0.65, Vec4::new(0.0, 255.0, 0.0, HALF)),
        (0.7, -0.65, Vec4::new(0.0, 0.0, 255.0, HALF)),
    ],
    0.5,
);

/// Corners and triangles of figure 1.
pub(in crate::scene) fn pair() -> (Vec<Vertex>, Vec<[u32; 3]>) {
    placed(&PAIR)
}

/// Corners and triangle of figure 2.
pub(in crate::scene) fn rainbow() -> (Vec<Vertex>, Vec<[u32; 3]>) {
    placed(&[RAINBOW])
}

fn placed(triangles: &[Triangle]) -> (Vec<Vertex>, Vec<[u32; 3]>) {
    let corner = |(x, y, colour), depth| Vertex { clip: DVec4::new(x, y, depth, 1.0), colour };
    let corners = triangles
        .iter()
        .flat_map(|(corners, depth)| corners.map(|at| corner(at, *depth)))
        .collect();
    (corners, (0..triangles.len() as u32).map(|n| [0, 1, 2].map(|k| 3 * n + k)).collect())
}

#[cfg(test)]
mod tests {
    use crate::golden::Golden;
    use crate::scene::{Options, Scene};
    use pellucid_machine::pixel::Fragment;
    use std::convert::Infallible;

    fn at_512(name: &str) -> (Scene, Vec<Fragment>) {
        let options = Options { width: Some(512), height: Some(512), ..Options::default() };
        let scene = Scene::open(name, &options).unwrap();
        let mut fragments = vec![];
        let Ok(()) = scene.play(&mut |fragment| {
            fragments.push(fragment);
            Ok::<(), Infallible>(())
        });
        (scene, fragments)
    }

    /// Over white: cyan leaves 255 - 128 of 255 of it, yellow the same of what is there.
    #[test]
    fn yellow_over_cyan_is_green() {
        let (scene, fragments) = at_512("triangles");
        let image = Golden::new(scene.info()).of(&fragments).unwrap().image;
        let pixel = |x, y| image.get(x, y).unwrap();
        let (cyan, yellow) = (pixel(205, 128), pixel(307, 410));
        assert_eq!([cyan, yellow], [0x7f_ff_ff, 0xff_ff_7f]);
        // (128 * 255 + 127 * 127) / 255 = 191.2
        assert_eq!(pixel(256, 307), 0xbf_ff_7f);
        assert_eq!(pixel(0, 0), 0xff_ff_ff);
    }

    #[test]
    fn the_rainbow_fits_256x256_with_a_little_to_spare() {
        let (_, fragments) = at_512("rainbow");
        assert!((59_000..62_000).contains(&fragments.len()), "{}", fragments.len());
        assert!(fragments.is_sorted_by_key(|f| (f.y, f.x)));
    }
}
