//! Which frames go through which F-buffers.

use crate::reproduce::frames::Frames;
use crate::reproduce::kept::Machine;

/// What frames are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Figure 3: one view of a sphere.
    View,
    /// What the text counts of Figure 4's spheres.
    Counts,
    /// Figure 4: spheres through buffers of all sizes.
    Rates,
    /// How much memory a buffer takes.
    Memory,
}

/// An F-buffer, and how fast what is around it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Buffer {
    /// Places along its side.
    pub size: u32,
    /// Targets of four floats.
    pub targets: u32,
    /// Cycles from vertex to vertex.
    pub vertex_cycles: u32,
    /// Cycles from fragment to fragment in the shader.
    pub fragment_cycles: u32,
}

/// Frames, what they are for, and the buffers that they go through.
pub struct Planned {
    /// What they are for.
    pub figure: Figure,
    /// The frames.
    pub frames: Frames,
    /// The buffers, all of as many targets.
    pub buffers: Vec<Buffer>,
}

/// The fewest and the most vertices of Figure 4's spheres.
pub const SPHERES: [&str; 2] = ["sphere-12288", "sphere-196608"];
/// From where Figure 3's view is seen.
const NEARER: &str = "0,0,3.0625:0,0,0";
/// The screen of Figure 4.
pub const SIDE: u32 = 1024;
/// The largest buffer of Figure 4.
const LARGEST: u32 = 2048;
/// Passes of the shader, `program=glass`.
pub const PASSES: u64 = 3;

/// Cycles of a pass of the shader for a fragment in Figure 4, and of a vertex on the paper's screen: the low sphere's terms are then equal with
/// a buffer of 128x128, the high one's between 512x512 and 1024x1024.
const FRAGMENT_CYCLES: u32 = 152;
const VERTEX_CYCLES: u32 = 256;

/// A buffer beside which nothing takes longer than it must.
const fn buffer(size: u32) -> Buffer {
    Buffer { size, targets: 1, vertex_cycles: 1, fragment_cycles: 1 }
}

impl Buffer {
    /// Its places.
    pub fn places(self) -> u64 {
        u64::from(self.size) * u64::from(self.size)
    }

    /// As a machine is asked for that has it.
    pub fn machine(self) -> Machine {
        let Buffer { size, targets, vertex_cycles, fragment_cycles } = self;
        let settings = [
            ("size", size),
            ("targets", targets),
            ("vertex_cycles", vertex_cycles),
            ("fragment_cycles", fragment_cycles),
        ];
        Machine {
            name: format!("{size}x{size}, {targets}, {vertex_cycles}, {fragment_cycles}"),
            arch: "fbuffer",
            preset: Some("x800"),
            settings: settings.map(|(name, value)| (name, value.to_string())).to_vec(),
        }
    }
}

/// Everything, on the paper's screens or on smaller ones. A buffer that is smaller by as much has as many windows there; and where a vertex takes
/// less time by as much as there are fewer fragments, all is bound by what it is on the paper's screen.
pub fn plan(full: bool) -> Vec<Planned> {
    let frames = Frames::square;
    let planned =
        |figure, frames, buffers: &[Buffer]| Planned { figure, frames, buffers: buffers.to_vec() };
    let nearer = Some(NEARER.parse().expect("a camera"));
    let scale = if full { 1 } else { 4 };
    let view = Frames { camera: nearer, ..frames(SPHERES[0], SIDE / 2 / scale) };
    let mut all = vec![planned(Figure::View, view, &[buffer(128 / scale)])];
    for (sphere, least) in SPHERES.into_iter().zip([64, if full { 64 } else { 256 }]) {
        if !full {
            let buffers = [64, 256].into_iter().filter(|size| *size >= least);
            let buffers: Vec<Buffer> = buffers.map(|size| buffer(size / 8)).collect();
            all.push(planned(Figure::Counts, frames(sphere, SIDE / 8), &buffers));
        }
        let scale = if full { 1 } else { 16 };
        let sizes = (0..).map(|bits| least << bits).take_while(|size| *size <= LARGEST);
        let rated = |size| Buffer {
            vertex_cycles: VERTEX_CYCLES / (scale * scale),
            fragment_cycles: FRAGMENT_CYCLES,
            ..buffer(size / scale)
        };
        let buffers: Vec<Buffer> = sizes.map(rated).collect();
        all.push(planned(Figure::Rates, frames(sphere, SIDE / scale), &buffers));
    }
    for targets in [1, 4] {
        let buffer = Buffer { targets, ..buffer(1024) };
        all.push(planned(Figure::Memory, frames("triangles", 64), &[buffer]));
    }
    all
}
