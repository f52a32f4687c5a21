//! The full-screen experiment of the dynamic fragment buffer paper (seed 002, its figures 5 and 6): transparent quads, one
//! behind the other, that face the viewer and cover a share of the screen.
//!
//! All quads of a frame are one rectangle in the middle of the screen, so that each of its pixels has a layer of each quad.

use crate::scene::clip::Vertex;
use crate::scene::{SceneError, Screen};
use glam::{DVec4, Vec4};
use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// What comes before the numbers of a name.
const FAMILY: &str = "quads-";
/// The most quads.
const MOST: u32 = 64;
/// Seed of colours and order: with this one, no order of three quads or more is sorted.
const SEED: u64 = 1;

/// A frame of quads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) struct Quads {
    /// How many there are, `1..=64`.
    count: u32,
    /// How much of the screen each covers, `0..=100`.
    percent: u32,
}

/// Where each quad is, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Rectangle {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
}

impl Quads {
    /// The frame with the name `quads-N-P`; nothing if it is the name of something else.
    ///
    /// # Errors
    /// The numbers are missing or out of range.
    pub fn parse(name: &str) -> Option<Result<Quads, SceneError>> {
        let numbers = name.strip_prefix(FAMILY)?;
        let is_file = |c: char| c.is_ascii_alphabetic() || c == '/' || c == '\\';
        // The ending of a file's name has letters; that of `quads-1-2.5` has none.
        if numbers.rsplit_once('.').is_some_and(|(_, ending)| ending.contains(is_file))
            || numbers.contains(['/', '\\'])
        {
            return None;
        }
        let parsed = numbers.split_once('-').and_then(|(count, percent)| {
            let count = count.parse().ok().filter(|count| (1..=MOST).contains(count))?;
            let percent = percent.parse().ok().filter(|percent| *percent <= 100)?;
            Some(Quads { count, percent })
        });
        Some(parsed.ok_or_else(|| SceneError::Quads { scene: name.into(), most: MOST }))
    }

    /// Corners and triangles, two for each quad, in the order in which they are drawn.
    pub fn triangles(self, info: Screen) -> (Vec<Vertex>, Vec<[u32; 3]>) {
        let mut rng = ChaCha8Rng::seed_from_u64(SEED);
        let mut order: Vec<u32> = (0..self.count).collect();
        order.shuffle(&mut rng);
        let Rectangle { left, top, width, height } = self.rectangle(info);
        let x = |column: u32| 2.0 * f64::from(column) / f64::from(info.width) - 1.0;
        let y = |row: u32| 1.0 - 2.0 * f64::from(row) / f64::from(info.height);
        let (right, bottom) = (left + width, top + height);
        let corners = [(left, top), (right, top), (left, bottom), (right, bottom)];
        let (mut vertices, mut triangles) = (vec![], vec![]);
        for (n, quad) in (0..).zip(order) {
            let depth = f64::from(quad + 1) / f64::from(self.count + 1);
            let [red, green, blue] = [0; 3].map(|_| f32::from(rng.random_range(48..=240_u8)));
            let colour = Vec4::new(red, green, blue, f32::from(rng.random_range(64..=160_u8)));
            vertices.extend(corners.map(|(column, row)| Vertex {
                clip: DVec4::new(x(column), y(row), depth, 1.0),
                colour,
            }));
            let first = 4 * n;
            triangles.extend([[0, 1, 2], [1, 3, 2]].map(|corners| corners.map(|k| first + k)));
        }
        (vertices, triangles)
    }

    /// The rectangle whose area is nearest to that share of the screen; of several the one that is most like the screen, of
    /// these the lowest.
    fn rectangle(self, Screen { width, height, .. }: Screen) -> Rectangle {
        let wanted = i64::from(width) * i64::from(height) * i64::from(self.percent);
        let sides = |rows: i64| {
            let columns = (wanted + 50 * rows) / (100 * rows);
            (columns.min(width.into()), rows)
        };
        let nearest = (1..=i64::from(height)).map(sides).min_by_key(|(columns, rows)| {
            let off = (100 * columns * rows - wanted).abs();
            (off, (columns * i64::from(height) - rows * i64::from(width)).abs())
        });
        let (columns, rows) =
            nearest.map_or((0, 0), |(columns, rows)| (columns as u32, rows as u32));
        Rectangle {
            left: (width - columns) / 2,
            top: (height - rows) / 2,
            width: columns,
            height: rows,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Options, Scene};
    use pellucid_machine::pixel::Fragment;
    use proptest::prelude::*;
    use std::convert::Infallible;

    fn played(name: &str, width: u32, height: u32) -> Vec<Fragment> {
        let options = Options { width: Some(width), height: Some(height), ..Options::default() };
        let mut fragments = vec![];
        let Ok(()) = Scene::open(name, &options).unwrap().play(&mut |fragment| {
            fragments.push(fragment);
            Ok::<(), Infallible>(())
        });
        fragments
    }

    /// The product of two sides on the screen that is nearest to 1/100 of `hundredths`, by trying all.
    fn nearest(width: u32, height: u32, hundredths: u32) -> u32 {
        let areas = (0..=width).flat_map(|columns| (0..=height).map(move |rows| columns * rows));
        let off = |area: &u32| (100 * area).abs_diff(hundredths);
        areas.min_by_key(off).unwrap()
    }

    #[test]
    fn a_share_of_the_usual_screens_is_exact() {
        for (width, height) in [(640, 480), (800, 600), (500, 500), (1100, 1100)] {
            for percent in [0, 5, 10, 25, 50, 75, 90, 100] {
                let fragments = played(&format!("quads-2-{percent}"), width, height);
                let share = 2 * (width * height / 100 * percent);
                assert_eq!(fragments.len(), share as usize, "{width}x{height}, {percent} %");
            }
        }
    }

    proptest! {
        #[test]
        fn every_quad_covers_the_nearest_rectangle_once(
            count in 1u32..=64, percent in 0u32..=100, width in 1u32..40, height in 1u32..40,
        ) {
            let fragments = played(&format!("quads-{count}-{percent}"), width, height);
            prop_assert!(fragments.iter().all(|f| !f.is_opaque()));
            let area = nearest(width, height, width * height * percent);
            let off = |area: u32| (100 * area).abs_diff(width * height * percent);
            let each = fragments.len() as u32 / count;
            prop_assert_eq!(each * count, fragments.len() as u32);
            prop_assert_eq!(off(each), off(area));
            let mut places: Vec<_> = fragments.iter().map(|f| (f.y, f.x, f.z)).collect();
            places.sort_unstable();
            places.dedup();
            prop_assert_eq!(places.len(), fragments.len());
            // One depth for each quad.
            let mut depths: Vec<_> = fragments.iter().map(|f| f.z).collect();
            depths.sort_unstable();
            depths.dedup();
            prop_assert_eq!(depths.len() as u32, if each == 0 { 0 } else { count });
        }
    }

    #[test]
    fn quads_come_in_no_order_of_depth() {
        for count in 3..=64 {
            let depths: Vec<u32> =
                played(&format!("quads-{count}-100"), 1, 1).iter().map(|f| f.z).collect();
            assert!(!depths.is_sorted() && !depths.iter().rev().is_sorted(), "{count}: {depths:?}");
        }
    }

    #[test]
    fn bad_numbers_are_refused_and_files_are_none_of_the_family() {
        for name in [
            "quads-",
            "quads-0-5",
            "quads-65-5",
            "quads-5",
            "quads-5-101",
            "quads-5--1",
            "quads-1-2.5",
            "quads-N-P",
        ] {
            let error = Quads::parse(name).unwrap().unwrap_err().to_string();
            let expected = format!(
                "unknown scene `{name}`: expected quads-N-P with N from 1 to 64, the number of quads, and P from 0 to 100, the \
                 percentage of the screen"
            );
            assert_eq!(error, expected);
        }
        for name in ["quads", "quads-1.ply", "quads-1/2", "glass"] {
            assert!(Quads::parse(name).is_none(), "{name}");
        }
        assert_eq!(Quads::parse("quads-10-50").unwrap().unwrap(), Quads { count: 10, percent: 50 });
    }
}
