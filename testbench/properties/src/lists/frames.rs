//! Frames that are stored in lists.

use pellucid_blocks::allocator::AllocatorKind;
use pellucid_blocks::chains::config::{Config, Link, Passes, Shape};
use pellucid_machine::pixel::Screen;
use proptest::prelude::*;
use std::fmt;
use std::ops::Range;

/// A fragment that is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Its pixel.
    pub pixel: u32,
    /// Its depth.
    pub z: u32,
}

/// A frame as it is played.
#[derive(Clone, Debug)]
pub struct Play {
    /// So many pages may be used.
    pub limit: u32,
    /// It is read back; else it is given up.
    pub resolved: bool,
    /// Its fragments in arrival order.
    pub layers: Vec<Layer>,
}

/// What is fixed while a sequence is played.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The lists, of which a page is a section.
    pub cfg: Config,
    /// Each pixel's opaque depth.
    pub depths: Vec<u32>,
    /// The frames.
    pub plays: Vec<Play>,
}

/// `2 pixels, 9 pages of 4, K = 3, depths [5, 0], resolved of 8 pages: 0@3 1@2`
impl fmt::Display for Setup {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Setup { cfg, depths, plays } = self;
        let (pixels, pages) = (cfg.screen.pixels(), cfg.null);
        let Shape { capacity, bitmap, .. } = cfg.shape;
        let bitmap = if bitmap { ", with a bitmap" } else { "" };
        write!(f, "{pixels} pixels, {pages} pages of {capacity}, K = {}", cfg.pass_depth())?;
        write!(f, "{bitmap}, depths {depths:?}")?;
        for Play { limit, resolved, layers } in plays {
            let what = if *resolved { "resolved" } else { "given up" };
            write!(f, ", {what} of {limit} pages:")?;
            layers.iter().try_for_each(|Layer { pixel, z }| write!(f, " {pixel}@{z}"))?;
        }
        Ok(())
    }
}

/// Lists for so many pixels, with so many pages of so many fragments, of which K are taken in a pass.
fn config(pixels: u32, pages: u32, capacity: u32, depth: u32, bitmap: bool) -> Config {
    let screen = Screen { width: pixels, height: 1, background: 0 };
    let shape = Shape {
        owned: false,
        on_chip: pages,
        outside: 0,
        outside_latency: 1,
        capacity,
        link: Link::Head,
        bitmap,
        reads_in_flight: 4,
        passes: Passes::Each(depth),
        weight_bits: 0,
        allocator: AllocatorKind::Bump,
        ssa: None,
        depth_ahead: false,
    };
    Config::new(screen, shape)
}

/// So many frames of so many fragments.
pub(super) fn setups(plays: Range<usize>, fragments: Range<usize>) -> BoxedStrategy<Setup> {
    let cfg = (1..20u32, 1..30u32, 1..6u32, 1..5u32, any::<bool>());
    let cfg = cfg.prop_map(|(pixels, pages, page, k, map)| config(pixels, pages, page, k, map));
    cfg.prop_flat_map(move |cfg| {
        let pixels = cfg.screen.pixels();
        let pixel = prop_oneof![0..pixels, 0..pixels.min(2)];
        let layer = (pixel, 0..5u32).prop_map(|(pixel, z)| Layer { pixel, z });
        let layers = proptest::collection::vec(layer, fragments.clone());
        let limit = prop_oneof![0..=cfg.null, Just(cfg.null)];
        let play = (limit, prop::bool::weighted(0.7), layers);
        let play = play.prop_map(|(limit, resolved, layers)| Play { limit, resolved, layers });
        let depths = proptest::collection::vec(1..6u32, pixels as usize);
        (depths, proptest::collection::vec(play, plays.clone()))
            .prop_map(move |(depths, plays)| Setup { cfg, depths, plays })
    })
    .boxed()
}

/// Frames of up to three fragments of two pixels, with a page too few and with enough, and one that is given up.
pub(super) fn small() -> Vec<Setup> {
    let play = |limit, pixels: &[u32]| {
        let layers = pixels.iter().map(|&pixel| Layer { pixel, z: pixel }).collect();
        Play { limit, resolved: true, layers }
    };
    let setup = |capacity, depth, bitmap, plays| {
        let cfg = config(2, 3, capacity, depth, bitmap);
        Setup { cfg, depths: vec![1, 1], plays }
    };
    let given_up = Play { resolved: false, ..play(1, &[0]) };
    vec![
        setup(1, 2, false, vec![play(1, &[0])]),
        setup(1, 2, false, vec![given_up, play(1, &[0])]),
        setup(1, 2, false, vec![play(1, &[0, 0])]),
        setup(1, 2, false, vec![play(3, &[0, 0])]),
        setup(1, 2, false, vec![play(1, &[1, 0, 1])]),
        setup(2, 2, false, vec![play(3, &[0, 0])]),
        setup(2, 1, true, vec![play(3, &[0])]),
    ]
}
