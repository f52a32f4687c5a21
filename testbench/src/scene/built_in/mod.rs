//! The scenes that need no file, each made by a short procedure and the same on every run.

mod field;
pub(super) mod glass;
pub(super) mod panes;
pub(super) mod paper;
mod patches;
mod shapes;
pub(super) mod smoke;
pub(super) mod teapot;

/// Background of the teapot and of mesh files, `0xRRGGBB`.
pub(super) const BACKDROP: u32 = 0xf4f1ea;

/// A built-in scene as a list shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// The name to open it by.
    pub name: &'static str,
    /// What it shows, one sentence without a full stop.
    pub about: &'static str,
}

const BUILT_IN: [BuiltIn; 12] = [
    BuiltIn {
        name: "glass",
        about: "tinted panes and spheres that intersect, among opaque things on a checkered floor",
    },
    BuiltIn { name: "teapot", about: "the Utah teapot, half transparent" },
    BuiltIn { name: "smoke", about: "a column of soft particles, dozens of layers deep" },
    BuiltIn {
        name: "panes",
        about: "the example of the image composition paper: seven panes, where all meet yellow over blue is green",
    },
    BuiltIn { name: "paper-0", about: "pixels and layers of frame 0 of the T-buffer paper" },
    BuiltIn { name: "paper-120", about: "pixels and layers of frame 120 of the T-buffer paper" },
    BuiltIn { name: "paper-180", about: "pixels and layers of frame 180 of the T-buffer paper" },
    BuiltIn { name: "paper-240", about: "pixels and layers of frame 240 of the T-buffer paper" },
    BuiltIn { name: "paper-300", about: "pixels and layers of frame 300 of the T-buffer paper" },
    BuiltIn { name: "paper-360", about: "pixels and layers of frame 360 of the T-buffer paper" },
    BuiltIn { name: "paper-420", about: "pixels and layers of frame 420 of the T-buffer paper" },
    BuiltIn { name: "paper-480", about: "pixels and layers of frame 480 of the T-buffer paper" },
];

/// All built-in scenes, the default one first.
pub fn built_in() -> &'static [BuiltIn] {
    &BUILT_IN
}
