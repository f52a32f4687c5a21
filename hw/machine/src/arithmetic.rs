//! How a machine makes a pixel's colour of its fragments: what its image is held to, in plain software.
//!
//! It shares no line with the hardware, on purpose: a mistake in a common function would hide itself.

use std::fmt;

/// A fragment that counts: a transparent one in front of its pixel's final opaque depth.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layer {
    /// Its depth.
    pub z: u32,
    /// Its colour, `0xRRGGBBAA`.
    pub rgba: u32,
}

/// A fragment as a program shades it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unshaded {
    /// Its column.
    pub x: u32,
    /// Its row.
    pub y: u32,
    /// Its depth.
    pub z: u32,
    /// The colour that it came with, `0xRRGGBBAA`.
    pub rgba: u32,
}

/// A program that gives each transparent fragment its colour or kills it, before pixels' colours are made of these.
#[derive(Clone, Copy)]
pub struct Shading {
    /// Which of the programs that `colour` knows it is.
    pub program: u64,
    /// The colour `0xRRGGBBAA` that a program gives a fragment, and the last one that counts in its pixel: where the two share
    /// what is stored between passes, one finds what the other has left. Nothing if the program kills it.
    pub colour: fn(u64, Unshaded, Unshaded) -> Option<u32>,
}

/// See the module's description. Two are equal if their names are, and the programs that shade.
#[derive(Clone, Copy)]
pub struct Arithmetic {
    /// Its name, as it stands in "the golden model of the ...".
    pub name: &'static str,
    /// The colour `0xRRGGBB` of a pixel: its layers in arrival order, over an opaque colour `0xRRGGBB`. Nothing if
    /// it is the exact blend.
    pub colour: Option<fn(&[Layer], u32) -> u32>,
    /// How a transparent fragment gets its colour, if it does not come with it.
    pub shading: Option<Shading>,
    /// How far a channel of a pixel with so many layers may be from the exact blend, in levels, 0 to 255.
    pub error_bound: fn(u32) -> u32,
}

impl Arithmetic {
    /// Far to near, at equal depth the earlier arrival first, rounded at each step: the exact blend.
    pub const BLEND: Arithmetic =
        Arithmetic { name: "exact blend", colour: None, shading: None, error_bound: |_| 0 };

    fn program(&self) -> Option<u64> {
        self.shading.map(|shading| shading.program)
    }
}

impl PartialEq for Arithmetic {
    fn eq(&self, other: &Arithmetic) -> bool {
        self.name == other.name && self.program() == other.program()
    }
}

impl Eq for Arithmetic {}

impl fmt::Debug for Arithmetic {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "Arithmetic({})", self.name)
    }
}
