//! The scenes that need no file, each made by a short procedure and the same on every run.

pub(super) mod cube;
mod field;
pub(super) mod glass;
pub(super) mod panes;
pub(super) mod paper;
mod patches;
pub(super) mod plant;
pub(super) mod quads;
mod shapes;
pub(super) mod smoke;
pub(super) mod sphere;
pub(super) mod teapot;
pub(super) mod triangles;

/// Background of the teapot, the cube, of quads and of mesh files, `0xRRGGBB`.
pub(super) const BACKDROP: u32 = 0xf4f1ea;

/// A built-in scene as a list shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltIn {
    /// The name to open it by; that of a family has letters for its numbers.
    pub name: &'static str,
    /// The same name, or one of the family.
    pub example: &'static str,
    /// What it shows, one sentence without a full stop.
    pub about: &'static str,
}

const BUILT_IN: [BuiltIn; 19] = [
    one(
        "glass",
        "tinted panes and spheres that intersect, among opaque things on a checkered floor",
    ),
    one("teapot", "the Utah teapot, half transparent"),
    one("smoke", "a column of soft particles, dozens of layers deep"),
    one("plant", "a pipe rack of 300 000 triangles, seen from its end through hundreds of layers"),
    one(
        "panes",
        "the example of the image composition paper: seven panes, where all meet yellow over blue is green",
    ),
    one(
        "triangles",
        "Figure 1 of the F-buffer paper: a cyan triangle, then a yellow one before it, each half transparent",
    ),
    one(
        "rainbow",
        "Figure 2 of the F-buffer paper: a half transparent triangle, red, green and blue at its corners",
    ),
    one(
        "sphere-12288",
        "a half transparent sphere of 4096 triangles, 12 288 vertices, its back first",
    ),
    one("sphere-196608", "the same sphere of 65 536 triangles, 196 608 vertices"),
    one(
        "cube",
        "Figure 3 of the accumulation paper: the RGB colour cube, opaque and without light",
    ),
    BuiltIn {
        example: "quads-5-50",
        ..one(
            "quads-N-P",
            "N transparent quads that face the viewer, 1 to 64, each over P percent of the screen, 0 to 100",
        )
    },
    one("paper-0", "pixels and layers of frame 0 of the T-buffer paper"),
    one("paper-120", "pixels and layers of frame 120 of the T-buffer paper"),
    one("paper-180", "pixels and layers of frame 180 of the T-buffer paper"),
    one("paper-240", "pixels and layers of frame 240 of the T-buffer paper"),
    one("paper-300", "pixels and layers of frame 300 of the T-buffer paper"),
    one("paper-360", "pixels and layers of frame 360 of the T-buffer paper"),
    one("paper-420", "pixels and layers of frame 420 of the T-buffer paper"),
    one("paper-480", "pixels and layers of frame 480 of the T-buffer paper"),
];

/// A scene of one name.
const fn one(name: &'static str, about: &'static str) -> BuiltIn {
    BuiltIn { name, example: name, about }
}

/// All built-in scenes, the default one first.
pub fn built_in() -> &'static [BuiltIn] {
    &BUILT_IN
}

/// Whether a built-in scene has that name, or it is one of a family.
pub fn is_built_in(name: &str) -> bool {
    quads::Quads::parse(name).is_some() || BUILT_IN.iter().any(|scene| scene.name == name)
}
