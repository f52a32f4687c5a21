//! Which frames go to which machines.

use super::contender::{
    B3D, Contender, DFB, DFB_BANDS, DFB_PAPER, DX, PLL, PLL_ENOUGH, PPLL4, PPLL4_ENOUGH, RIVALS,
};
use crate::reproduce::frames::Frames;
use pellucid_testbench::scene::{CameraPath, Sequence, Walk};

/// What frames are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Table I: one view of one model.
    Table,
    /// Figures 5 and 6: so many quads, each over so many percent of the screen.
    Quads(u32, u32),
    /// Figure 7: a walk around so many models.
    Walk(u32),
    /// Figure 8: a walk through the power plant.
    Tour,
}

/// Frames, what they are for, and the machines that play them.
pub struct Planned {
    /// What they are for.
    pub figure: Figure,
    /// The frames.
    pub frames: Frames,
    /// The machines.
    pub contenders: Vec<Contender>,
}

/// Quads on top of each other, and models side by side.
pub const NUMBERS: [u32; 3] = [1, 5, 10];
/// The quads of Figure 6: the fewest and the most.
pub const MANAGED: [u32; 2] = [NUMBERS[0], NUMBERS[2]];

/// How much of it all is played.
#[derive(Clone, Copy)]
pub struct Sizes {
    /// Side of the screen in pixels; three of them.
    pub sides: [u32; 3],
    /// How much of the screen quads cover, in percent.
    pub percents: &'static [u32],
    /// Frames of a walk around models.
    pub walk: u32,
    /// The model of Figure 7, where no mesh is given.
    pub model: &'static str,
    /// The screen of the walk through the plant.
    pub tour_screen: (u32, u32),
    /// Its frames.
    pub tour: u32,
}

/// A tenth of the paper's screens in each direction: done in well under a minute.
pub const QUICK: Sizes = Sizes {
    sides: [50, 80, 110],
    percents: &[0, 10, 25, 50, 100],
    walk: 8,
    model: "teapot",
    tour_screen: (80, 60),
    tour: 8,
};

/// The screens of the paper's Table I and Figure 8.
pub const FULL: Sizes = Sizes {
    sides: [500, 800, 1100],
    percents: &[0, 10, 25, 50, 75, 100],
    walk: 16,
    model: "plant",
    tour_screen: (800, 600),
    tour: 24,
};

/// A walk of so many frames.
fn walk(path: CameraPath, frames: u32) -> Option<Sequence> {
    Some(Sequence::Walk(Walk { path, frames }))
}

/// Everything, with the mesh in Table I and Figure 7 if one is given.
pub fn plan(sizes: &Sizes, mesh: Option<&str>) -> Vec<Planned> {
    let frames = Frames::square;
    let planned = |figure, frames, contenders: &[Contender]| Planned {
        figure,
        frames,
        contenders: contenders.to_vec(),
    };
    let mut all = vec![];
    for side in sizes.sides {
        let contenders = [B3D, DFB, DFB_PAPER, PPLL4, PLL, DX];
        all.push(planned(Figure::Table, frames(mesh.unwrap_or("teapot"), side), &contenders));
    }
    for number in NUMBERS {
        for side in sizes.sides {
            for percent in sizes.percents {
                let mut contenders = RIVALS.to_vec();
                if MANAGED.contains(&number) {
                    contenders.extend([DFB_BANDS, PPLL4_ENOUGH, PLL_ENOUGH]);
                }
                let scene = format!("quads-{number}-{percent}");
                let figure = Figure::Quads(number, *percent);
                all.push(planned(figure, frames(&scene, side), &contenders));
            }
        }
    }
    for number in NUMBERS {
        for side in sizes.sides {
            let sequence = walk(CameraPath::Orbit, sizes.walk);
            let one = frames(mesh.unwrap_or(sizes.model), side);
            let several = Frames { instances: Some(number), sequence, ..one };
            all.push(planned(Figure::Walk(number), several, &RIVALS));
        }
    }
    let sequence = walk(CameraPath::Ellipse, sizes.tour);
    let tour = Frames { screen: sizes.tour_screen, sequence, ..frames("plant", 0) };
    all.push(planned(Figure::Tour, tour, &RIVALS));
    all
}
